# SPDX-License-Identifier: Apache-2.0
"""The height field."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np

from ._convert import above, check_sides, coarser_like, common_shape, count, nodata_of, numbers, read_source, samples_of
from ._core import Core, Work, ffi, lib, owner, raster_door
from ._light import Light
from ._raster import Source, read_crs, read_raster, scale_of
from ._rays import Rays
from ._sight import Sight

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Difference(NamedTuple):
    """How far a coarser field's surface lies from the full one. above, below: no point lies farther above or below; rms: root
    mean square over the area; all in the samples' unit. lost, made: triangles of the full field where only the full field has a
    surface, and where only the coarser one has."""
    above: float
    below: float
    rms: float
    lost: int
    made: int


_filters = ("mean", "highest", "lowest")


# ---- what is called -------------------------------------------------------------------------------------------------------


def _heights(core, work, places):
    """z of places of the map, in their place."""
    if core.affine[0, 2] or core.affine[1, 2]:
        raise ValueError("transform: leans the heights, so that no single place is above x and y")
    n = places.size // 3
    hits, points = ffi.new("cw_hit[]", n), ffi.from_buffer("double[]", places)
    work.part(0, 2)
    work.check(lib.cw_surface_at_user(core.field, work.run, points, n, hits))
    work.part(1, 2)
    work.check(lib.cw_hit_points(core.field, work.run, hits, n, points))


def _coarser(core, work, factor, filter):
    difference, made = ffi.new("cw_difference *"), owner("cw_field **", lib.drop_field)
    work.check(lib.cw_field_coarser(core.field, work.run, factor, filter, made, difference, ffi.sizeof(difference[0])))
    rows, columns = (-(-(n - 1) // factor) + 1 for n in core.shape)
    first = ffi.gc(lib.cw_field_row(made[0], 0), [made].count)  # keeps made as long as the samples; no Python code runs, which drops Ctrl-C
    samples = np.frombuffer(ffi.buffer(first, 4 * rows * columns), np.float32).reshape(rows, columns)
    return made, samples, Difference(difference.above, difference.below, difference.rms, difference.lost, difference.made)


def _update(core, work, field, row, column, block):
    """If the field refuses it, the old samples are restored. Other threads get a copied field when it is ready."""
    if core is not field._core:
        raise RuntimeError("update: another update is running on the field")
    if not (field._own and core.source.samples.flags.writeable):
        core = field._build(core.source.samples.copy())
    here, status = core.source.samples[row:row + block.shape[0], column:column + block.shape[1]], None
    before, change = here.copy(), ffi.new("cw_update *", {"at": (column, row, *block.shape[::-1])})
    updated, field._updated, core.bounds = field._updated, True, None
    try:
        here[:] = block
        status = lib.cw_field_update(core.field, work.run, change)
    finally:
        if status != lib.CW_OK:
            here[:] = before
            lib.cw_field_update(core.field, work.run, change)
            field._updated = updated
    if status == lib.CW_OK:
        core.about, field._core, field._own = core.describe(), core, True
    work.check(status)


class Field(Rays, Light, Sight):
    """A height field: rows of samples, two triangles between each four of them.

    z            array of shape (rows, columns), at least 2 x 2; an xarray.DataArray with dimensions (y, x); or a rasterio
                 dataset. NaN, infinity, masked samples and `nodata` are holes, through which rays pass.
    transform    where pixels lie on the map: an Affine, or six numbers in its order (x by column, x by row, x0, y by column,
                 y by row, y0) for the corner of the first pixel, as rasterio has them. A sample stands in its pixel's middle.
                 A (3, 4) array maps samples (column, row, z) to x, y and z directly. Default: that of the DataArray or dataset,
                 else x is the column and y the row.
    crs          coordinate system: WKT, an object with to_wkt(), or what pyproj or rasterio understand. It says whether x and
                 y are degrees, and how long the map's unit is. Default: that of the DataArray or dataset.
    nodata       a value that stands for no data; default: what the DataArray or dataset says.
    zscale       one unit of height is so many of the map's units (metres, if that is in degrees); default: 1, or by the
                 dataset's unit.
    band         of a dataset; default: the first.
    threads      how many threads queries use; 0 (default): one for each CPU.
    copy         False (default): contiguous float32 is used where it lies, and must not change but by `update`. All else is
                 converted once. True: samples are copied.
    progress     a callable that takes the share done, or a tqdm bar. While a file is read it must not wait for threads that read.

    Raises ValueError or TypeError naming the argument, MemoryError, KeyboardInterrupt.

    Queries may run in several threads at once; Python's other threads go on meanwhile. Ctrl-C ends a query. Fields can be
    copied and pickled, while no thread updates them. One made by `open` is pickled as its path: the file is opened again.

        >>> import numpy as np, cellwalk as cw
        >>> f = cw.Field(np.zeros((3, 5), "float32"), transform=(10, 0, 500, 0, -10, 800))
        >>> f.shape, f.bounds
        ((3, 5), (505.0, 775.0, 545.0, 795.0))
    """

    def __init__(self, z: Any, transform: Any = None, crs: Any = None, nodata: float | None = None, threads: int = 0, *,
                 zscale: float | None = None, band: int | None = None, copy: bool = False, progress=None) -> None:
        self._make(read_source(z, transform, crs, nodata_of(nodata), zscale, band), threads, copy, progress, z)
        self._core.warn_of_heights()

    def _make(self, source: Source, threads, copy=False, progress=None, given=None, made=None) -> None:
        self._threads = count(threads, "threads", 0, 4096)
        self._source = source._replace(samples=None)
        self._origin: Optional[tuple] = None  # how to open it again
        self._updated = False  # no longer what its file says
        self._difference: Optional[Difference] = None
        held = given.data if hasattr(given, "dims") else given  # chunks are not computed again, and may be views of another array
        shared = given is not None and (hasattr(held, "dask") or np.shares_memory(source.samples, np.asarray(held)))
        self._own = made is None and (copy or not shared)  # else an update copies the samples
        self._core = self._build(source.samples.copy() if copy and shared else source.samples, progress, made)

    def _build(self, samples: np.ndarray, progress=None, made=None) -> Core:
        try:
            return Core(self._source._replace(samples=samples), Work("z", self._threads, progress), made)
        except ValueError:
            if not np.isinf(samples).any():
                raise
        self._own = True  # infinite holes become NaN in a copy
        return self._build(np.where(np.isinf(samples), np.float32(np.nan), samples), progress)

    @property
    def _ground(self) -> Core:
        """The field for products, which need the scale of a projected map: GDAL is loaded for it."""
        core = self._core
        if not core.scaled:
            with raster_door:
                if self._source.scale is None:
                    self._source = self._source._replace(scale=scale_of(self._source, self._origin[0] if self._origin else "crs"))
                core.set_scale(self._source.scale)
        return core

    # ---- what it is ------------------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, int]:  # type: ignore[override]
        """Rows and columns of samples."""
        return self._core.shape

    @property
    def z(self) -> np.ndarray:
        """The samples as the field has them: float32, NaN at holes. Not to be written to: see update."""
        view = self._core.source.samples.view()
        view.flags.writeable = False
        return view

    @property
    def map(self) -> np.ndarray:
        """Samples (column, row, z) to x, y and z of the map: float64, shape (3, 4)."""
        return self._source.map.copy()

    @property
    def transform(self) -> tuple[float, float, float, float, float, float]:
        """Where pixels lie on the map, six numbers in Affine's order: Affine(*f.transform) is what rasterio writes."""
        (a, b, _, c), (d, e, _, f), _ = self._source.map.tolist()
        return a, b, c - 0.5 * a - 0.5 * b, d, e, f - 0.5 * d - 0.5 * e

    @property
    def crs(self):
        """The coordinate system as it was given, as WKT if it comes from a file, or None."""
        return self._source.crs.given

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x, least y, greatest x, greatest y of the samples on the map."""
        rows, columns = self.shape
        corners = np.array([[i, j] for j in (0, rows - 1) for i in (0, columns - 1)], np.float64)
        places = corners @ self._source.map[:2, :2].T + self._source.map[:2, 3]
        (x0, y0), (x1, y1) = places.min(0).tolist(), places.max(0).tolist()
        return x0, y0, x1, y1

    @property
    def difference(self) -> Difference | None:
        """Of a field made by `coarser`: how far its surface lies from the full one. None of any other."""
        return self._difference

    def __repr__(self) -> str:
        about, known, m = self._core.about, self._source.crs, self._source.map
        heights = f"heights {about.low:g} to {about.high:g}" if about.low <= about.high else "no heights"
        cell = " x ".join(f"{float(np.hypot(m[0, k], m[1, k])):g}" for k in range(2))
        unit = ("" if not self._source.placed else " degrees" if known.geographic else
                " m" if known.unit == 1 else f" x {known.unit:g} m" if known.unit else "")
        name = known.wkt.split('"')[1] if known.wkt and '"' in known.wkt else "no crs"
        return (f"<cellwalk.Field: {self.shape[0]} rows of {self.shape[1]} samples, {heights}, {about.holes} holes, "
                f"cells {cell}{unit}, {name}>")

    def __reduce__(self):
        if self._origin is not None and self._updated:
            raise TypeError("a Field is not pickled after update, which its file lacks; send field.z")
        if self._origin is not None:
            return _reopen, (*self._origin, self.shape)
        return field_of, (self._source._replace(samples=self._core.source.samples), self._threads, None, self._difference)

    def __copy__(self, memo=None) -> Field:
        """A field of its own samples: an update of one does not change the other."""
        samples = self._run("copy", lambda core, work: core.source.samples.copy(), core=self._core)
        return field_of(self._source._replace(samples=samples), self._threads, None, self._difference)

    __deepcopy__ = __copy__

    def at(self, x: ArrayLike, y: ArrayLike, *, progress=None) -> Any:
        """Height of the surface at places of the map, in the map's z: float64, the shape of x and y broadcast; NaN outside
        and in holes.

            >>> import numpy as np, cellwalk as cw
            >>> f = cw.Field(np.arange(9, dtype="float32").reshape(3, 3))
            >>> f.at([0.5, 1, 7], 1)
            array([3.5, 4. , nan])
        """
        x, y = numbers(x, "x"), numbers(y, "y")
        places = np.empty((*common_shape({"x": x.shape, "y": y.shape}), 3))
        places[..., 0], places[..., 1], places[..., 2] = x, y, self._source.map[2, 3]
        if places.size:
            self._run("at", _heights, places, progress=progress, core=self._core)
        return places[..., 2].copy()[()]

    def coarser(self, factor: int, filter: str = "mean", *, progress=None) -> Field:
        """A field of every factor-th row and column, in the same place on the map. It takes a share of 1 / factor² of the memory.

        factor   from 2 on
        filter   "mean": the weighted mean of the samples less than factor away, for views and most products; "highest": the
                 surface is nowhere below the full one, so that no obstacle is missed; "lowest": nowhere above it, so that none
                 is invented

        The last row and column may lie up to factor - 1 samples beyond the full field's. `difference` of the new field says how
        far the two surfaces lie apart, at most and in the root mean square, and how many triangles were lost or made at holes.
        Later updates of either field do not change the other.

            >>> import numpy as np, cellwalk as cw
            >>> f = cw.Field(np.arange(25, dtype="float32").reshape(5, 5) ** 2)
            >>> g = f.coarser(2, "highest")
            >>> g.shape, g.difference.below
            ((3, 3), 0.0)
        """
        factor = count(factor, "factor", 2, 2**31 - 1)
        if filter not in _filters:
            raise ValueError(f"filter: {filter!r}, expected one of {', '.join(map(repr, _filters))}")
        made, samples, difference = self._run("coarser", _coarser, factor, _filters.index(filter), progress=progress, core=self._core)
        affine = self._source.map.copy()
        affine[:, :2] *= factor
        like = coarser_like(self._source.like, samples, factor)
        source = self._source._replace(samples=samples, shape=samples.shape, map=affine, like=like, scale=None, whole=None)
        return field_of(source, self._threads, None, difference, made)

    def update(self, row: int, column: int, block: ArrayLike, nodata: float | None = None) -> None:
        """Replaces the samples from (row, column) on by block, of shape (rows, columns). Afterwards the field is what one made
        of the new samples would be.

        The array that the field was made of does not change: a field that uses it where it lies copies it first, once.
        Time follows the block, not the field. RuntimeError while queries run in other threads; ValueError, and the field
        stays as it was, if the block does not fit or a height is beyond 1e30.

            >>> import numpy as np, cellwalk as cw
            >>> f = cw.Field(np.zeros((9, 9), "float32"))
            >>> f.update(3, 3, np.full((3, 3), 5.0))
            >>> float(f.at(4, 4))
            5.0
        """
        block = samples_of(block, nodata_of(nodata), "block", 0)
        rows, columns = block.shape
        row, column = count(row, "row", 0, self.shape[0]), count(column, "column", 0, self.shape[1])
        if row + rows > self.shape[0] or column + columns > self.shape[1]:
            raise ValueError(f"block: shape {block.shape} at ({row}, {column}) goes beyond the field's {self.shape}")
        if rows == 0 or columns == 0:
            return
        block = np.where(np.isinf(block), np.float32(np.nan), block)
        self._run("block", _update, self, row, column, block, core=self._core, change=True)


def open(path: str | bytes | os.PathLike, window: Any = None, *, band: int | None = None, nodata: float | None = None,
         cellsize: float | None = None, zscale: float | None = None, crs: Any = None, threads: int = 0, progress=None) -> Field:
    """A field from a raster file: GeoTIFF and all else that GDAL reads, or .npy.

    window     (column, row, columns, rows) of samples to read, or a rasterio Window; default: all
    band       counts from 1; default: the first
    nodata     a value that stands for no data, beside the one that the file names
    cellsize   of a file that has no map: samples are that far apart, the first row in the north
    zscale     one unit of height is so many of the map's (metres, if that is in degrees)
    crs        in place of the file's

    Raises OSError with the file's name and what is wrong; warns of what looks wrong but is no error.

        >>> import numpy as np, cellwalk as cw, os, tempfile
        >>> path = os.path.join(tempfile.mkdtemp(), "flat.npy")
        >>> np.save(path, np.zeros((4, 6), "float32"))
        >>> cw.open(path, window=(1, 0, 3, 4)).shape
        (4, 3)
    """
    if not isinstance(path, (str, bytes, os.PathLike)):
        raise TypeError(f"path: {path!r}, expected a path")
    path = os.fsdecode(path)
    column, row, columns, rows = _window(window)
    given, work = read_raster(path, 0 if band is None else count(band, "band", 1, 65535), nodata_of(nodata),
                              above(cellsize, "cellsize"), above(zscale, "zscale"), (column, row, columns, rows), progress)
    work.tell()
    source = given if crs is None else given._replace(crs=read_crs(crs))
    check_sides(given.shape, path)
    field = field_of(source, threads, progress)
    field._origin = path, window if window is None else (column, row, columns, rows), band, nodata, cellsize, zscale, crs, threads
    return field


def field_of(source: Source, threads: int, progress=None, difference: Difference | None = None, made=None) -> Field:
    field = Field.__new__(Field)
    field._make(source, threads, False, progress, None, made)
    field._difference = difference
    return field


def _reopen(path, window, band, nodata, cellsize, zscale, crs, threads, shape) -> Field:
    field = open(path, window, band=band, nodata=nodata, cellsize=cellsize, zscale=zscale, crs=crs, threads=threads)
    if field.shape != shape:
        raise ValueError(f"{path}: {field.shape[0]} x {field.shape[1]} samples, the pickled field had {shape[0]} x {shape[1]}")
    return field


def _window(window) -> tuple[int, int, int, int]:
    if window is None:
        return 0, 0, 0, 0
    if hasattr(window, "col_off"):
        window = window.col_off, window.row_off, window.width, window.height
    try:
        column, row, columns, rows = window
    except (TypeError, ValueError):
        raise ValueError(f"window: {window!r}, expected (column, row, columns, rows)") from None
    most = 2**31 - 1
    return (count(column, "window column", 0, most), count(row, "window row", 0, most),
            count(columns, "window columns", 1, most), count(rows, "window rows", 1, most))
