# SPDX-License-Identifier: Apache-2.0
"""Calls of the libraries, which cffi binds by the names of their functions and structs, and the height field."""

from __future__ import annotations

import ctypes
import functools
import os
import re
import sys
import threading
import types
import warnings
from typing import Any, Callable, Optional

# Before NumPy, which may refuse too. The pools and GDAL's module belong to the process, and the main interpreter's GIL guards them.
_interpreter, _number = ctypes.pythonapi.PyInterpreterState_Get, ctypes.pythonapi.PyInterpreterState_GetID
_interpreter.restype, _number.argtypes, _number.restype = ctypes.c_void_p, [ctypes.c_void_p], ctypes.c_int64
if _number(_interpreter()) != 0:
    raise ImportError("cellwalk does not run in sub-interpreters: use threads or processes")

import numpy as np  # noqa: E402

from ._cellwalk import ffi, lib  # type: ignore[import-not-found]  # noqa: E402

NULL = ffi.NULL
version = ffi.string(lib.cw_version()).decode()


def c_text(text: str | bytes) -> bytes:
    """Bytes are a path. In other names, characters that C cannot have become question marks, so nothing has such a name."""
    if isinstance(text, str):
        return text.encode(errors="replace").replace(b"\0", b"?")
    if b"\0" in text:
        raise ValueError(f"path: {os.fsdecode(text)!r} has a null character")
    return text


def owner(kind: str, drop) -> Any:
    """Room for a pointer that a function makes; drop destroys both. The room is there before the call, so that Ctrl-C loses nothing."""
    return ffi.gc(ffi.new(kind), drop)


def check(status: int, name: str) -> None:
    """Raises what a status says, with the library's message of the last failure on this thread."""
    if status != lib.CW_OK:
        kind = {lib.CW_ERROR_MEMORY: MemoryError, lib.CW_ERROR_BUSY: RuntimeError}.get(status, ValueError)
        detail = ffi.string(lib.cw_last_error()) or ffi.string(lib.cw_status_message(status))
        raise kind(f"{name}: {detail.decode(errors='replace')}")


# GDAL's module is for one thread at a time. The same thread may come back by a progress callable or where a GeoTIFF is forgotten.
raster_door = threading.RLock()
# A fork waits for it, so that no thread is within GDAL. If Ctrl-C ends the wait, the child has a door that is open all the same.
os.register_at_fork(before=raster_door.acquire, after_in_parent=raster_door.release, after_in_child=raster_door._at_fork_reinit)


def do_io(function, *arguments, fails: Any = OSError, work: Any = None) -> None:
    """Calls a function of src/io or src/ground whose last argument is an io_error, and raises what that says."""
    error = ffi.new("io_error *")
    with raster_door:
        good = function(*arguments, error)
    if work is not None:
        work.check()
    if not good:
        raise fails(ffi.string(error.text).decode(errors="replace"))


def warn(text: str) -> None:
    """At the line of the caller's that called this package."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, stacklevel=level)


# ---- how a call runs: on a pool, under a watch that lets Ctrl-C end it and tells a progress callable ---------------------------


@functools.lru_cache(maxsize=2)
def _pool(threads: int, process: int):
    """Threads cost too much to start for each call: the two pools used last stay, others go once idle. A forked child makes its own."""
    pool = owner("cw_pool **", lib.drop_pool)
    check(lib.cw_pool_create(threads, pool), "threads")
    return pool


def progress_call(progress) -> Optional[Callable[[float], object]]:
    """A callable that takes the share done, or an object like tqdm's bar with `update`, `n` and `total`."""
    if progress is None or not (hasattr(progress, "update") and hasattr(progress, "n")):
        if progress is not None and not callable(progress):
            raise TypeError(f"progress: {progress!r} is neither callable nor a progress bar")
        return progress
    total = progress.total or 1
    return lambda share: progress.update(share * total - progress.n)


def _told(context) -> types.SimpleNamespace:
    return ffi.from_handle(ffi.cast("work *", context).python)


def _keep(kind, error, trace) -> None:
    """Keeps an exception of the next two functions for Work.check. Ctrl-C raises one in whatever they do."""
    context = trace.tb_frame.f_locals["context"]
    ffi.cast("work *", context).stopped = True
    _told(context).error = error


@ffi.def_extern(onerror=_keep)
def python_watch(context, share):
    progress = _told(context).progress
    if progress is not None:
        progress(share)
    return True


@ffi.def_extern(onerror=_keep)
def python_warn(context, text):
    _told(context).sentences.append(ffi.string(text).decode(errors="replace"))


class Work:
    """One call or several of the libraries by this thread. name: what messages begin with."""

    def __init__(self, name: str, threads: int = 1, progress=None, kernel: Optional[str] = None) -> None:
        self.name, self.told = name, types.SimpleNamespace(progress=progress_call(progress), error=None, sentences=[])
        self._held = ffi.new_handle(self.told), None if threads == 1 else _pool(threads, os.getpid())
        self.c = ffi.new("work *", {"python": self._held[0]})
        self.run = ffi.addressof(self.c, "run")
        if self._held[1] is not None:
            self.run.pool = self._held[1][0]
        if kernel is not None:
            self.run.expert.kernel = lib.cw_kernel_find(c_text(str(kernel)))
            if not lib.cw_kernel_exists(self.run.expert.kernel):
                raise ValueError(f"kernel: {kernel!r}, expected a name of cellwalk.kernels()")
        lib.work_begin(self.c)

    def check(self, status: int = 0) -> None:
        """After each call."""
        if self.c.stopped:
            error, self.told.error = self.told.error, None
            try:
                raise error or KeyboardInterrupt  # without one, a second Ctrl-C met _keep
            finally:
                del error
        check(status, self.name)

    def tell(self) -> None:
        """Warns of what C warned of, with arguments in place of the program's options."""
        self.check()
        for sentence in self.told.sentences:
            warn(re.sub(r"--(band|nodata|zscale)( (?=[-\d]))?", lambda found: found[1] + ("=" if found[2] else ""), sentence))

    def part(self, number: int, parts: int) -> None:
        """From here on progress is that of part number of so many."""
        self.c.begin, self.c.share = number / parts, 1 / parts
        lib.work_watch(self.c, 0)
        self.check()

    def finish(self) -> None:
        if self.told.progress is not None:
            self.told.progress(1.0)


# ---- the field ------------------------------------------------------------------------------------------------------------


class Core:
    """The height field over a Source's samples, which stay where they are, or without work its map. made: the field, if there is one."""

    def __init__(self, source, work: Work | None = None, made=None) -> None:
        self.source, self.shape, self.affine = source, source.shape, np.array(source.map)
        self.users, self.process, self.bounds, self.scaled, self._scale = 0, os.getpid(), None, False, None
        self._samples = NULL if work is None else ffi.from_buffer("float[]", source.samples)
        self._map = ffi.new("double[3][4]", self.affine.tolist())
        self._field = owner("cw_field **", lib.drop_field) if made is None else made
        if work is not None and made is None:
            desc = {"samples": self._samples, "nx": self.shape[1], "ny": self.shape[0], "map": self._map, "storage": lib.CW_BORROW}
            work.check(lib.cw_field_create(ffi.new("cw_field_desc *", desc), work.run, self._field))
            work.finish()
        self.field = self._field[0]
        self.about = self.describe() if work is not None else None  # at the end of the last change
        self.identity = bool((self.affine == np.eye(3, 4)).all())
        self._terrain = self._whole = self._place(self.shape, self._map)
        if source.whole is not None and self._terrain:
            whole, self._terrain.column, self._terrain.row = source.whole
            self._whole = self._terrain.whole = self._place(whole.shape, ffi.new("double[3][4]", whole.map))

    def _place(self, shape: tuple[int, int], affine) -> Any:
        """NULL if the map cannot be inverted."""
        if not self.source.placed:
            # A picture's, with the first row in the north. A coarser field's samples stand more than 1 apart.
            apart = affine[0][0]
            affine = ffi.new("double[3][4]", [[apart, 0, 0, 0], [0, -apart, 0, apart * (shape[0] - 1)], [0, 0, affine[2][2], 0]])
        terrain, crs = ffi.new("terrain *", {"nx": shape[1], "ny": shape[0], "stride": shape[1], "z": self._samples}), self.source.crs
        desc = {"field": self.field, "geographic": crs.geographic, "unit": crs.unit, "semi_major": crs.semi_major,
                "inverse_flattening": crs.inverse_flattening}
        return terrain if lib.cw_terrain_place(terrain, affine, ffi.new("cw_terrain_desc *", desc)) else NULL

    @property
    def terrain(self) -> Any:
        if not self._terrain:
            raise ValueError("transform: cannot be inverted, or has latitudes beyond 90 degrees")
        return self._terrain

    def set_scale(self, scale: bytes) -> None:
        """How long the unit of a projected map is on the ground. Before the first product."""
        if scale and not (self.scaled or self.source.crs.geographic) and self._terrain:
            self._scale = ffi.new("map_scale *")
            ffi.buffer(self._scale)[:] = scale
            self._terrain.scale = self._whole.scale = self._scale
        self.scaled = True

    def north(self, y):
        """y of the caller's as that of the terrain, and back."""
        return y if self.source.placed else self._map[0][0] * (self._whole.ny - 1) - y

    def describe(self) -> Any:
        """A cw_field_info."""
        info = ffi.new("cw_field_info *")
        lib.cw_field_describe_into(self.field, info, ffi.sizeof(info[0]))
        return info

    def warn_of_heights(self) -> None:
        """What programs often write for no data, and heights whose last digits are lost, as the program warns of them."""
        if self.about.low <= 0 or self.about.high > 2**24:
            work, about = Work("z"), {"nx": self.shape[1], "ny": self.shape[0], "z": self._samples}
            raster = ffi.new("io_raster *", {**about, "georef": {"has_nodata": self.source.nodata is not None}})
            lib.io_raster_smell(b"z", ffi.new("io_warner *", (lib.python_warn, work.c)), raster)
            work.tell()

    def with_bounds(self, work: Work) -> Any:
        """The terrain with the highest samples of blocks, for lines over it. Two threads may both make them; the last ones stay."""
        work.bounds = self.bounds  # stay as long as the work
        if work.bounds is None:
            work.bounds = owner("sight_bounds **", lib.drop_bounds)
            work.check(lib.cw_sight_bounds_create(self.terrain, work.bounds))
            self.bounds = work.bounds
        terrain = ffi.new("terrain *", self.terrain[0])
        terrain.bounds = work.bounds[0]
        return terrain

    def use(self, work: Work, make, *arguments, change: bool = False) -> Any:
        """make(self, work, *arguments) while nobody changes the field, or while nobody else uses it. make checks the statuses it gets."""
        if self.process != os.getpid():  # a fork forgets who used it
            self.users, self.process = 0, os.getpid()
        if change and self.users:
            raise RuntimeError("update: queries or another update are running on the field")
        if self.users < 0:
            raise RuntimeError("the field is being changed by another thread")
        # From the looks above to try, and in finally, nothing is called: there CPython neither handles signals nor changes threads.
        self.users += -1 if change else 1
        try:
            answer = make(self, work, *arguments)
            work.check()
        finally:
            self.users -= -1 if change else 1
        work.finish()
        return answer
