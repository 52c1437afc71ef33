# SPDX-License-Identifier: Apache-2.0
"""Products of rasters larger than memory, on Dask's scheduler.

    import cellwalk.dask as cwd
    lit = cwd.shadow("dem.tif", azimuth=225, altitude=30)      # lazy: a DataArray, or a Dask array without xarray
    cwd.to_geotiff(lit, "shadow.tif", "dem.tif")               # chunk by chunk, as they are done

A source is a path, of which each task reads its own window, or a chunked DataArray. The result has, to the last bit, what the
same method of cellwalk.Field gives for the whole raster: each chunk is computed with a halo that is proved to hold all that
matters to it.

    shadow, insolation what can throw a shadow on the chunk, found by the lowest and highest samples of blocks, which one pass over
                       the raster finds first
    viewshed           max_distance around each observer
    horizon, sky_view, openness, visibility
                       max_distance around the chunk; without one the whole raster in each task, as far mountains may count

Where a task needs more than `memory` bytes, that is said before work starts. The rectangles are those by which the program
makes rasters larger than memory (src/ground/ground.h).
"""

from __future__ import annotations

import functools
import os
import threading
from typing import Any, NamedTuple, Optional, TypedDict, Unpack

import dask
import dask.array as da
import numpy as np

from . import _light
from ._convert import check_sides, count, describe_dataarray, dress, finite, nodata_of, samples_of
from ._core import Core, check, ffi, lib
from ._field import Field, field_of, open as open_field
from ._light import Light
from ._plans import Plan, spots_of
from ._raster import Source, read_raster, scale_of
from ._sight import VIEWS, Sight, views_of
from ._store import INPUT, to_geotiff as to_geotiff
from ._xarray import xarray

# A task's samples, as they are read and as the field has them, and the field's bounds over them.
_BYTES_A_SAMPLE = 10


class _Window(NamedTuple):  # as cw_rectangle
    column: int
    row: int
    columns: int
    rows: int

    def inside(self, outer: "_Window") -> tuple[slice, slice]:
        row, column = self.row - outer.row, self.column - outer.column
        return slice(row, row + self.rows), slice(column, column + self.columns)

    def blocks(self) -> tuple[slice, slice]:
        """Rows and columns of the blocks of src/terrain/reach/reach.h that it has samples of."""
        size = lib.REACH_BLOCK
        return (slice(self.row // size, -(-(self.row + self.rows) // size)),
                slice(self.column // size, -(-(self.column + self.columns) // size)))


# ---- what runs in a worker --------------------------------------------------------------------------------------------------


# g: the raster's Source, without samples. part: a path with a band, or the window's block of a chunked array.


def _samples(part, g: Source, window: _Window) -> np.ndarray:
    if isinstance(part, tuple):
        path, band = part
        return read_raster(path, band, g.nodata, window=window)[0].samples
    return samples_of(part, g.nodata)


def _field(part, g: Source, window: _Window, threads: int, stamp=None) -> Field:
    affine, samples = np.array(g.map), _samples(part, g, window)
    affine[:2, 3] += affine[:2, 0] * window.column + affine[:2, 1] * window.row
    return field_of(g._replace(samples=samples, shape=samples.shape, map=affine, whole=(g, window.column, window.row)), threads)


_kept_field = functools.lru_cache(maxsize=1)(_field)  # the whole raster, for chunk after chunk


def _stamp(path):
    """That a file has been written again; None for what is no file."""
    try:
        s = os.stat(path)
    except OSError:
        return None
    return s.st_mtime_ns, s.st_size, s.st_ino


_one_at_a_time = threading.Lock()


def _field_of(part, g, window, threads) -> Field:
    if not isinstance(part, tuple) or (window.rows, window.columns) != g.shape:
        return _field(part, g, window, threads)
    with _one_at_a_time:  # threads of a worker share it
        return _kept_field(part, g, window, threads, _stamp(part[0]))


def _ranges(part, g, window):
    """Lowest and highest samples of the window's blocks; none of a block of holes."""
    z, size = _samples(part, g, window), lib.REACH_BLOCK
    rows, columns = (np.maximum(np.arange(s.start, s.stop) * size - start, 0) for s, start in zip(window.blocks(), (window.row, window.column)))
    return tuple(of.reduceat(of.reduceat(np.where(np.isfinite(z), z, none), rows, 0), columns, 1)
                 for of, none in ((np.minimum, np.float32(np.inf)), (np.maximum, np.float32(-np.inf))))


def _make(part, g, window, chunk, plan, threads):
    """A chunk of a plan's product."""
    rows, columns = chunk.inside(window)
    return _field_of(part, g, window, threads)._rows(plan, (columns.start, rows.start, chunk.columns, chunk.rows))


def _seen(part, g, window, plan, threads):
    """1 where one observer sees a sample of the window, 0 elsewhere, any number at holes; or the heights that are needed."""
    out = _field_of(part, g, window, threads)._rows(plan)
    return out if plan.dtype == np.float32 else out.astype(np.uint8)


def _join(part, g, chunk, padded, nodata, views):
    """A chunk of the viewshed from what observers near it see, or if nodata is NaN the heights that are needed, from one view."""
    counts = not np.isnan(nodata)
    out = np.full((chunk.rows, chunk.columns), 0 if counts else np.nan, np.uint16 if counts else np.float32)
    for window, view in views:
        row, column = max(chunk.row, window.row), max(chunk.column, window.column)
        both = _Window(column, row, min(chunk.column + chunk.columns, window.column + window.columns) - column,
                       min(chunk.row + chunk.rows, window.row + window.rows) - row)
        here = both.inside(chunk)
        out[here] = view[both.inside(window)] + (out[here] if counts else 0)
    if counts:
        out[~np.isfinite(_samples(part, g, padded)[chunk.inside(padded)])] = nodata
    return out.astype(np.uint8) if nodata == 255 else out


class _Reach:
    """How much of a raster matters to a part of it."""

    def __init__(self, g: Source) -> None:
        self.core = Core(g)
        self.core.set_scale(g.scale)

    def grown(self, w: _Window) -> _Window:
        """To at least 2 rows and columns, which a field needs."""
        return _window_of(lib.cw_reach_grow(self.core.terrain, w, 0))

    def around(self, x: float, y: float, distance: float) -> _Window:
        """The part that a viewshed from a place examines; without rows if there is none."""
        at = ffi.new("double[2]")
        if not lib.cw_terrain_find_place(self.core.terrain, x, self.core.north(y), at):
            raise ValueError(f"x, y: ({x:.10g}, {y:.10g}) is too far away from the terrain")
        return _window_of(lib.cw_reach_around(self.core.terrain, at, distance))

    def matters(self, w: _Window, distance: float, ranges=None, lights=()) -> _Window:
        """All within the distance, or with lights all that can throw a shadow on it. ranges: lowest and highest samples of all blocks, and the
        highest of all."""
        suns, piece = ffi.new("cw_light[]", list(lights)), ffi.new("cw_rectangle *")
        plan = ffi.new("ground_plan *", {"by": {"distance": distance, "suns": suns, "sun_count": len(suns)}, "whole": self.core.terrain})
        if ranges is not None:
            low, high, highest = ranges
            plan.blocks = {"whole": self.core.terrain, "across": low.shape[1], "down": low.shape[0], "low": ffi.from_buffer("float[]", low),
                           "high": ffi.from_buffer("float[]", high), "highest": highest, "lowest": low.min()}
        check(lib.ground_plan_around(plan, w, piece), "reach")
        return _window_of(piece)


def _window_of(r) -> _Window:
    return _Window(r.i, r.j, r.nx, r.ny)


# ---- the graph --------------------------------------------------------------------------------------------------------------


# Of a chunk's results and what they are made of, for each sample: sums in double, of insolation also the sky's light, of visibility the
# turned land and its bounds.
_BYTES = {"sunlight_hours": 12, "sunlight": 12, "irradiance": 16, "openness": 12, "visibility": 16}


def _lights_of(plan: Plan) -> Optional[list[dict[str, float]]]:
    """The lights by which the plan's shadows are cast, of each direction the lowest, as cw_light has them. None: the plan's halo is a
    distance."""
    if plan.method == "shadow":
        return [plan.numbers]
    if plan.method != "insolation" or plan.lead:
        return None
    suns, n = plan.inputs[0][plan.inputs[0][:, 1] > 0], plan.numbers["directions"]
    azimuths = np.fmod(np.fmod(suns[:, 0], 360) + 360, 360)
    if n:
        azimuths = 360 * (np.rint(azimuths / 360 * n) % n) / n
    azimuths, of = np.unique(azimuths, return_inverse=True)
    lowest = np.full(len(azimuths), 90.0)
    np.minimum.at(lowest, of, suns[:, 1])
    lights = [{"azimuth": azimuth, "altitude": altitude, "curvature": plan.numbers["curvature"]} for azimuth, altitude in zip(azimuths, lowest)]
    return lights or [{"altitude": 90.0}]


class _Raster(Light, Sight):
    """A source, cut into chunks, whose products are those of a field, but lazy."""

    def __init__(self, source, chunks=None, threads=1, nodata=None, crs=None, band=None, memory=2e9) -> None:
        self.threads = count(threads, "threads", 0, 4096)
        self.memory = finite(memory, "memory", 1)
        self.like = self.path = self.input = None
        nodata = nodata_of(nodata)
        if isinstance(source, (str, os.PathLike)):
            self.path = os.path.abspath(os.fspath(source)) if "://" not in str(source) and not str(source).startswith("/vsi") else str(source)
            self.input = self.path
            self.band = 0 if band is None else count(band, "band", 1, 65535)
            self.shape = read_raster(self.path, self.band)[0].shape
            about = open_field(self.path, (0, 0, 2, 2), band=band, nodata=nodata, crs=crs, threads=1)._source
        elif hasattr(source, "ndim") and hasattr(source, "coords"):
            about = describe_dataarray(source, crs=crs, nodata=nodata)
            self.like, nodata, self.shape = about.like, about.nodata, about.shape
            self.input = source.encoding.get("source")
            self.array = self.like.data if isinstance(self.like.data, da.Array) else da.from_array(self.like.values, chunks="auto")
            chunks = self.array.chunks if chunks is None else chunks
        else:
            raise TypeError(f"source: {type(source).__name__}, expected a path or a DataArray")
        rows, columns = self.shape
        check_sides(self.shape, "source")
        self._source = about._replace(shape=self.shape)
        # Can be hashed.
        self.site = about._replace(shape=self.shape, map=tuple(map(tuple, about.map.tolist())), crs=about.crs._replace(given=None),
                                   nodata=nodata, like=None, scale=scale_of(self._source, self.path or "crs"))
        self.reach = _Reach(self.site)
        try:
            self.chunks = da.core.normalize_chunks(2048 if chunks is None else chunks, (rows, columns), dtype=np.float32)
        except (TypeError, ValueError, ZeroDivisionError) as error:
            raise ValueError(f"chunks: {chunks!r}, expected rows and columns of a chunk, for a raster of {rows} x {columns}: {error}") from None
        ends = [np.concatenate([[0], np.cumsum(sizes)]) for sizes in self.chunks]
        self.windows = [[_Window(int(c), int(r), w, h) for c, w in zip(ends[1], self.chunks[1])] for r, h in zip(ends[0], self.chunks[0])]

    def part(self, window: _Window):
        if self.path is not None:
            return self.path, self.band
        return self.array[window.row:window.row + window.rows, window.column:window.column + window.columns]

    def delayed(self, task):
        return dask.annotate(**{INPUT: self.input})(dask.delayed(task, pure=True))

    def check_memory(self, what: str, windows, chunk_bytes: int = 4) -> None:
        """Refuses tasks that take more than `memory` bytes: windows and chunks in pairs; chunk_bytes of results a sample of
        their common rows."""
        def need(pair):
            window, chunk = pair
            return window.rows * window.columns * _BYTES_A_SAMPLE + chunk.rows * window.columns * chunk_bytes
        worst = max(windows, key=need)
        if need(worst) > self.memory:
            raise ValueError(f"{what}: a chunk needs {worst[0].rows} x {worst[0].columns} samples around it, {need(worst) / 1e9:.2f} GB "
                             f"a task, more than memory={self.memory / 1e9:.2f} GB")

    def block_ranges(self) -> tuple[np.ndarray, np.ndarray]:
        """Of all blocks. One pass over the raster, made at once."""
        size, g = lib.REACH_BLOCK, self.site
        shape = tuple(-(-n // size) for n in g.shape)
        low, high = np.full(shape, np.inf, np.float32), np.full(shape, -np.inf, np.float32)
        task = dask.delayed(_ranges, pure=True)
        windows = [self.reach.grown(w) for row in self.windows for w in row]
        for window, (least, most) in zip(windows, dask.compute([task(self.part(w), g, w) for w in windows])[0]):
            here = window.blocks()
            np.minimum(low[here], least, out=low[here])
            np.maximum(high[here], most, out=high[here])
        return low, high

    def _product(self, plan: Plan, progress=None) -> Any:
        """The plan's product, of which each chunk is made from the window that matters to it."""
        distance, lights = plan.numbers.get("max_distance", 0), _lights_of(plan)
        if lights is not None:
            low, high = self.block_ranges()
            ranges, what = (low, high, float(high.max())), f"altitude: {min(light['altitude'] for light in lights)}"
        else:
            ranges, lights, what = None, (), f"max_distance: {f'{distance:g}' if distance else 'None, so far mountains may count'}"
        windows = [[self.reach.matters(w, distance, ranges, lights) for w in row] for row in self.windows]
        self.check_memory(what, [pair for rows in zip(windows, self.windows) for pair in zip(*rows)],
                          _BYTES.get(plan.name, 4 * len(plan.lead[1]) if plan.lead else 4))
        task = self.delayed(_make)
        blocks = [[task(self.part(window), self.site, window, chunk, plan, self.threads) for window, chunk in zip(*rows)]
                  for rows in zip(windows, self.windows)]
        return self.result(blocks, plan.dtype, plan.name, plan.attrs, plan.lead)

    def result(self, blocks, dtype, name, attrs, lead=None):
        """Blocks of tasks, row by row, as one array, and as a DataArray if the source is one."""
        shape = (lambda w: (w.rows, w.columns)) if lead is None else (lambda w: (len(lead[1]), w.rows, w.columns))
        array = da.block([[da.from_delayed(b, shape(w), dtype) for b, w in zip(row, windows)] for row, windows in zip(blocks, self.windows)])
        like = self.like
        if like is None:
            m = self.site.map
            if xarray is None or m[0][1] or m[1][0]:
                return array
            like = xarray.DataArray(array if lead is None else array[0], dims=("y", "x"), coords={
                "y": m[1][3] + m[1][1] * np.arange(self.shape[0]), "x": m[0][3] + m[0][0] * np.arange(self.shape[1])})
        return dress(like, array, name, attrs, lead)


class _Reading(TypedDict, total=False):
    """Of every product: how the source is cut, read and worked on."""
    chunks: Any
    threads: int
    nodata: float | None
    crs: Any
    band: int | None
    memory: float


def shadow(source: Any, azimuth: float | None = None, altitude: float | None = None, *, time: _light.Time | None = None,
           hillshade: bool = False, disc: float | bool = 0, curvature: float = 0.0, **reading: Unpack[_Reading]) -> Any:
    """Sun and shadow on every sample, as Field.shadow. One pass over the raster is made at once; the rest is lazy."""
    return _Raster(source, **reading).shadow(azimuth, altitude, time=time, hillshade=hillshade, disc=disc, curvature=curvature)


def insolation(source: Any, date: _light.Day | None = None, to: _light.Day | None = None, *, suns: Any = None, step: Any = "15min",
               directions: int | None = None, irradiance: bool = False, linke: float = 3.0, sky: int = 32,
               lon_lat: tuple[float, float] | None = None, curvature: float = 0.0, **reading: Unpack[_Reading]) -> Any:
    """Hours of sunlight over days, or its energy, as Field.insolation. One pass over the raster is made at once; diffuse light depends
    on all of the raster, as sky_view does."""
    return _Raster(source, **reading).insolation(date, to, suns=suns, step=step, directions=directions, irradiance=irradiance, linke=linke,
                                                 sky=sky, lon_lat=lon_lat, curvature=curvature)


def horizon(source: Any, directions: int = 32, max_distance: float | None = None, *, start: float = 0.0, curvature: float = 0.0,
            distance: bool = False, **reading: Unpack[_Reading]) -> Any:
    """The horizon's angle in directions all round, or its distance, as Field.horizon."""
    return _Raster(source, **reading).horizon(directions, max_distance, start=start, curvature=curvature, distance=distance)


def sky_view(source: Any, directions: int = 32, max_distance: float | None = None, *, curvature: float = 0.0, tilted: bool = False,
             **reading: Unpack[_Reading]) -> Any:
    """The share of the sky, as Field.sky_view."""
    return _Raster(source, **reading).sky_view(directions, max_distance, curvature=curvature, tilted=tilted)


def openness(source: Any, directions: int = 32, max_distance: float | None = None, *, start: float = 0.0, curvature: float = 0.0,
             negative: bool = False, **reading: Unpack[_Reading]) -> Any:
    """How open the land is, as Field.openness."""
    return _Raster(source, **reading).openness(directions, max_distance, start=start, curvature=curvature, negative=negative)


def visibility(source: Any, directions: int = 128, max_distance: float | None = None, *, observer_height: float = 2.0,
               target_height: float = 0.0, curvature: float | None = None, result: str = "area", **reading: Unpack[_Reading]) -> Any:
    """How much of the ground every sample sees, as Field.visibility."""
    return _Raster(source, **reading).visibility(directions, max_distance, observer_height=observer_height, target_height=target_height,
                                                 curvature=curvature, result=result)


def viewshed(source: Any, x: Any, y: Any, observer_height: Any = None, target_height: float = 0.0, max_distance: float | None = None,
             needed: bool = False, *, observer_elevation: Any = None, curvature: float | None = None, min_distance: float = 0.0,
             azimuth: tuple[float, float] | None = None, vertical: tuple[float, float] | None = None, **reading: Unpack[_Reading]) -> Any:
    """Which samples are seen, as Field.viewshed. Observers are looked from one by one, each in its window of max_distance."""
    places = spots_of(x, y, observer_height, observer_elevation)
    r = _Raster(source, **reading)
    g = r.site
    limits = r._limits(target_height, max_distance, min_distance, azimuth, vertical, curvature)
    kind, distance = "needed" if needed else "seen", limits["farthest"]
    if needed and len(places) > 1:
        raise ValueError(f"needed: that of one observer, not of {len(places)}")
    task, views, whole = r.delayed(_seen), [], _Window(0, 0, *g.shape[::-1])
    for place in places:
        window = r.reach.around(place[0], place[1], distance) if distance else whole
        if window.rows:
            window = r.reach.grown(window)
            r.check_memory("max_distance", [(window, window)])
            views.append((window, task(r.part(window), g, window, views_of(place[None], limits, kind), r.threads)))
        elif not place[3]:
            raise ValueError(f"x, y: ({place[0]:.10g}, {place[1]:.10g}) has no ground under it within max_distance")

    def near(w):
        return [(v, s) for v, s in views if v.row < w.row + w.rows and w.row < v.row + v.rows
                and v.column < w.column + w.columns and w.column < v.column + v.columns]
    nodata_out = np.float32(np.nan) if needed else np.uint8(255) if len(places) <= 254 else np.uint16(65535)
    name, attrs = VIEWS[kind]
    join, padded = r.delayed(_join), [[r.reach.grown(w) for w in row] for row in r.windows]
    blocks = [[join(None if needed else r.part(p), g, w, p, nodata_out, near(w)) for w, p in zip(*rows)] for rows in zip(r.windows, padded)]
    return r.result(blocks, nodata_out.dtype, name, attrs if needed else {**attrs, "_FillValue": nodata_out})
