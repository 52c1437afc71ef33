# SPDX-License-Identifier: Apache-2.0
"""Rays as callers have them - origins and directions that broadcast, or packed - and where they hit."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ._convert import common_shape, numbers
from ._core import ffi, lib
from ._plans import Products

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_dtype = np.dtype({"names": ["t", "u", "v", "i", "j", "triangle"], "formats": ["=f4", "=f4", "=f4", "=i4", "=i4", "=u4"],
                   "offsets": [0, 16, 20, 4, 8, 12], "itemsize": 24})  # as cw_hit of include/cellwalk.h


class Kernel(NamedTuple):
    name: str
    what: str
    isa: str
    width: int
    available: bool


def kernels() -> list[Kernel]:
    """The ways in which rays can be traced, by name; all give exact answers.

    `available` says whether this machine can run it. The `kernel` of closest and occluded takes one of the names; without it, the
    library chooses the fastest.

        >>> import cellwalk as cw
        >>> "cell" in [k.name for k in cw.kernels()]
        True
    """
    info, rows = ffi.new("cw_kernel_info *"), []
    for k in range(lib.cw_kernel_count()):
        lib.cw_kernel_describe_into(lib.cw_kernel_at(k), info, ffi.sizeof(info[0]))
        name, what, isa = (ffi.string(text).decode() for text in (info.name, info.what, lib.cw_isa_name(info.isa)))
        rows.append(Kernel(name, what, isa, info.width, info.available))
    return rows


def _member(name: str) -> np.ndarray:
    return property(lambda hits: hits.records[name])  # type: ignore[return-value]


class Hits:
    """Where rays hit; every member has the shape of the rays.

    hit       bool: whether the ray hits at all
    t         float32: the hit is at origin + t * direction; inf on a miss
    i, j      int32: column and row of the cell; -1 on a miss
    triangle  uint32: 0 below the cell's diagonal from (i, j) to (i + 1, j + 1), 1 above
    u, v      float32: place on the triangle p0 p1 p2, p0 + u (p1 - p0) + v (p2 - p0); its vertices are (i, j), (i + 1, j),
              (i + 1, j + 1) below the diagonal and (i, j), (i + 1, j + 1), (i, j + 1) above
    records   the same as one structured array

    Members are views of `records`; nothing is copied. hits[index] is the hits at that index.

        >>> import numpy as np, cellwalk as cw
        >>> f = cw.Field(np.zeros((5, 5), "float32"))
        >>> h = f.closest([[1.5, 1.25, 9], [7, 7, 9]], [0, 0, -1])
        >>> h.hit, h.t
        (array([ True, False]), array([ 9., inf], dtype=float32))
        >>> h[h.hit].points()
        array([[1.5 , 1.25, 0.  ]])
    """

    __slots__ = ("records", "_field")
    t, u, v = _member("t"), _member("u"), _member("v")
    i, j, triangle = _member("i"), _member("j"), _member("triangle")

    def __init__(self, records: np.ndarray, field) -> None:
        self.records = records
        self._field = field

    @property
    def hit(self) -> np.ndarray:
        return self.records["i"] >= 0

    @property
    def shape(self) -> tuple[int, ...]:
        return self.records.shape

    def __len__(self) -> int:
        return len(self.records)

    def __bool__(self) -> bool:
        if self.records.ndim:
            raise ValueError(f"the truth of {self.records.size} rays is ambiguous: use hits.hit.any() or hits.hit.all()")
        return bool(self.hit)

    def __getitem__(self, index) -> "Hits":
        return Hits(np.asarray(self.records[index]), self._field)

    def __repr__(self) -> str:
        return f"<cellwalk.Hits: {int(self.hit.sum())} of {self.records.size} rays hit, shape {self.shape}>"

    def points(self, *, progress=None) -> np.ndarray:
        """Places of the hits on the surface: float64, shape (..., 3), x, y, z of the map; NaN on a miss.

        They lie on the triangle to rounding, unlike origin + t * direction.
        """
        return self._follow("points", lib.cw_hit_points, progress)

    def normals(self, smooth: bool = False, *, progress=None) -> np.ndarray:
        """Unit normals on the upper side: float64, shape (..., 3); NaN on a miss.

        smooth: normals interpolated over the triangle from those at the samples, instead of the triangle's own.
        """
        return self._follow("normals", lib.cw_hit_phong_normals if smooth else lib.cw_hit_normals, progress)

    def _follow(self, name: str, function, progress) -> np.ndarray:
        records = np.ascontiguousarray(self.records)
        if records.dtype.fields != _dtype.fields or records.itemsize != _dtype.itemsize:
            raise TypeError(f"records: dtype {records.dtype}, expected that of Field.closest")
        out = np.empty(self.shape + (3,), np.float64)
        if records.size:
            hits, to = ffi.from_buffer("cw_hit[]", records.view(np.uint8)), ffi.from_buffer("double[]", out)
            self._field._run(name, lambda core, work: work.check(function(core.field, work.run, hits, records.size, to)), progress=progress,
                             core=self._field._core)
        return out


def _operand(array: np.ndarray, shape: tuple, width: tuple) -> np.ndarray:
    """The array broadcast to the rays, one after another."""
    rows = np.broadcast_to(array, shape + width).reshape(-1, *width)
    return np.ascontiguousarray(rows) if width and rows.strides[1] != rows.itemsize else rows


def _unpack(rays, tmin, tmax):
    """Origins, directions, tmin and tmax as views of packed rays."""
    rays = numbers(rays, "rays")
    if rays.ndim == 0 or rays.shape[-1] not in (6, 8):
        raise ValueError(f"rays: shape {rays.shape}, expected (..., 6) with origin and direction, "
                         "or (..., 8) with origin, tmin, direction and tmax")
    rays = np.ascontiguousarray(rays)
    if rays.shape[-1] == 8:
        if tmin is not None or tmax is not None:
            raise ValueError("tmin, tmax: rays of shape (..., 8) have theirs already")
        return rays[..., :3], rays[..., 4:7], rays[..., 3], rays[..., 7]
    shape = rays.shape[:-1]
    for end, name in (tmin, "tmin"), (tmax, "tmax"):
        if np.ndim(end) > len(shape) or any(n not in (1, m) for n, m in zip(np.shape(end)[::-1], shape[::-1])):
            raise ValueError(f"{name}: shape {np.shape(end)} does not broadcast to that of the rays, {shape}")
    return rays[..., :3], rays[..., 3:], tmin, tmax


def rays_of(origins, directions, tmin, tmax):
    """Shape of the answer, and operands of extension.h: rows of numbers with any step between them, which is 0 for what all rays share.
    Nothing is copied that has such a form already."""
    if directions is None:
        origins, directions, tmin, tmax = _unpack(origins, tmin, tmax)
    given = [numbers(origins, "origins"), numbers(directions, "directions"), numbers(0 if tmin is None else tmin, "tmin"),
             numbers(np.inf if tmax is None else tmax, "tmax")]
    names = ("origins", "directions", "tmin", "tmax")
    for array, name in zip(given[:2], names):
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"{name}: shape {array.shape}, expected (..., 3)")
    shape = common_shape(dict(zip(names, map(np.shape, given))), [array.shape[:-1] for array in given[:2]] + [array.shape for array in given[2:]])
    # Floats stay floats: widened, they would give the same rays. Scalars do not decide, but no double is rounded that is no float.
    narrow = all(array.dtype == np.float32 if array.ndim else float(np.float32(array)) == float(array) for array in given)
    dtype = np.dtype(np.float32 if narrow else np.float64)
    return shape, tuple(_operand(array.astype(dtype, copy=False), shape, width) for array, width in zip(given, ((3,), (3,), (), ())))


class Rays(Products):
    """Methods of Field."""

    def closest(self, origins: ArrayLike, directions: ArrayLike | None = None, tmin: ArrayLike | None = None,
                tmax: ArrayLike | None = None, *, kernel: str | None = None, progress=None) -> Hits:
        """The first place where each ray meets the surface.

        origins      (..., 3) in the map's coordinates; or rays, (..., 6) with origin and direction as Open3D has them, or
                     (..., 8) with origin, tmin, direction and tmax as the program's .npy files have them
        directions   (..., 3); need not have unit length
        tmin, tmax   (...): points origin + t * direction count for t from tmin to tmax; default: 0 and infinity

        All broadcast against each other as NumPy's arrays do. float32 and float64 are taken as they are, other real
        numbers become float64. A ray with a NaN, an infinite origin or a zero direction misses.

        Returns Hits with the shape of the broadcast rays.

            >>> import numpy as np, cellwalk as cw
            >>> f = cw.Field(np.zeros((9, 9), "float32"))
            >>> f.closest([[4, 4, 2], [4, 4, -2]], [0, 0, -1]).t
            array([ 2., inf], dtype=float32)
        """
        shape, out = self._trace("closest", origins, directions, tmin, tmax, kernel, progress)
        return Hits(out.view(_dtype).reshape(shape), self)

    def occluded(self, origins: ArrayLike, directions: ArrayLike | None = None, tmin: ArrayLike | None = None,
            tmax: ArrayLike | None = None, *, kernel: str | None = None, progress=None) -> np.ndarray:
        """Whether each ray meets the surface at all: bool, with the shape of the rays. Arguments as for closest.

            >>> import numpy as np, cellwalk as cw
            >>> f = cw.Field(np.zeros((9, 9), "float32"))
            >>> f.occluded([4, 4, 2], [0, 0, -1], tmax=[1, 3])
            array([False,  True])
        """
        shape, out = self._trace("occluded", origins, directions, tmin, tmax, kernel, progress)
        return out.view(np.bool_).reshape(shape)

    def _trace(self, method, origins, directions, tmin, tmax, kernel, progress):
        shape, operands = rays_of(origins, directions, tmin, tmax)
        n, wide = len(operands[0]), operands[0].dtype == np.float64
        rays = ffi.new("rays *", {"at": [a.ctypes.data for a in operands], "step": [a.strides[0] for a in operands], "n": n, "wide": wide,
                                  "user": wide or not self._core.identity})
        closest = method == "closest"
        out = np.empty(n * (_dtype.itemsize if closest else 1), np.uint8)
        hits, any_hit = (ffi.from_buffer("cw_hit[]", out), ffi.NULL) if closest else (ffi.NULL, ffi.from_buffer("uint8_t[]", out))
        self._run(method, lambda core, work: work.check(lib.rays_trace(rays, core.field, work.c, hits, any_hit)), progress=progress,
                  core=self._core, kernel=kernel)
        return shape, out
