# SPDX-License-Identifier: Apache-2.0
"""Products of rasters larger than memory, on Dask's scheduler.

    import cellwalk.dask as cwd
    lit = cwd.shadow("dem.tif", azimuth=225, altitude=30)      # lazy: a DataArray, or a Dask array without xarray
    cwd.to_geotiff(lit, "shadow.tif", "dem.tif")               # chunk by chunk, as they are done

A source is a path, of which each task reads its own window, or a chunked DataArray. The result has, to the last bit, what the
same method of cellwalk.Field gives for the whole raster: each chunk is computed with a halo that is proved to hold all that
matters to it.

    shadow             as far as the highest sample can throw a shadow on the chunk's lowest; one pass over the raster finds
                       lowest and highest samples of chunks first
    viewshed           max_distance around each observer
    horizon, sky_view  the whole raster in each worker, as far mountains may count

Where a halo needs more than `memory` bytes a task, that is said before work starts.
"""

from __future__ import annotations

import functools
import math
import os
from typing import NamedTuple, Optional

import dask
import dask.array as da
import numpy as np

from . import _cellwalk
from ._convert import Crs, Source, count, describe_dataarray, finite, numbers, samples_of
from ._field import Field, open as open_field
from ._products import SUN_RADIUS

# A task's samples, the field's bounds over them, and its result.
_BYTES_A_SAMPLE = 12


class _Geometry(NamedTuple):
    """What tasks are told of the whole raster."""
    rows: int
    columns: int
    map: tuple
    placed: bool
    crs: Crs
    nodata: Optional[float]

    def metres(self, row) -> tuple[np.ndarray, np.ndarray]:
        """Metres in one of the map's x and y at rows, as src/terrain/terrain.c has them."""
        row = np.asarray(row, np.float64)
        unit = self.crs.unit or (math.pi / 180 if self.crs.geographic else 1.0)
        if not self.crs.geographic:
            return np.full(row.shape, unit), np.full(row.shape, unit)
        f = 1 / 298.257223563 if not self.crs.semi_major else 1 / self.crs.inverse_flattening if self.crs.inverse_flattening else 0.0
        radius, e2 = self.crs.semi_major or 6378137.0, f * (2 - f)
        y = self.map[1][0] * 0.5 * (self.columns - 1) + self.map[1][1] * row + self.map[1][3]
        latitude = np.clip(y * unit, -math.pi / 2, math.pi / 2)
        w2 = 1 - e2 * np.sin(latitude) ** 2
        return np.maximum(unit * radius / np.sqrt(w2) * np.cos(latitude), 1e-3), unit * radius * (1 - e2) / w2 ** 1.5

    def cells_per_metre(self, azimuth, row) -> tuple[np.ndarray, np.ndarray]:
        """Along columns and rows, in a direction of the compass."""
        east, north = self.metres(row)
        x, y = np.sin(np.radians(azimuth)) / east, np.cos(np.radians(azimuth)) / north
        (a, b), (c, d) = self.map[0][:2], self.map[1][:2]
        if not self.placed:  # the first row is in the north
            d = -d
        determinant = a * d - b * c
        return (d * x - b * y) / determinant, (a * y - c * x) / determinant

    @property
    def metres_of_height(self) -> float:
        return self.map[2][2] * (1.0 if self.crs.geographic else self.crs.unit or 1.0)


class _Window(NamedTuple):
    row: int
    column: int
    rows: int
    columns: int

    def grown(self, g: _Geometry, north: int, south: int, west: int, east: int) -> "_Window":
        """With so many rows and columns more on each side, as far as the raster goes, and at least 2 of each."""
        top, left = max(self.row - north, 0), max(self.column - west, 0)
        bottom, right = min(self.row + self.rows + south, g.rows), min(self.column + self.columns + east, g.columns)
        top, left = min(top, max(bottom - 2, 0)), min(left, max(right - 2, 0))
        return _Window(top, left, max(bottom, top + 2) - top, max(right, left + 2) - left)

    def inside(self, outer: "_Window") -> tuple[slice, slice]:
        row, column = self.row - outer.row, self.column - outer.column
        return slice(row, row + self.rows), slice(column, column + self.columns)


# ---- what runs in a worker --------------------------------------------------------------------------------------------------


def _samples(part, g: _Geometry, window: _Window) -> np.ndarray:
    """part is a path with a band, or the window's block of a chunked array."""
    if isinstance(part, tuple):
        path, band = part
        given = _cellwalk.read_raster(path, band, g.nodata, 0.0, 0.0, (window.column, window.row, window.columns, window.rows), None)
        return np.asarray(given["samples"])
    return samples_of(part, g.nodata)


def _field(part, g: _Geometry, window: _Window, threads: int) -> Field:
    affine = np.array(g.map)
    whole = g.columns, g.rows, window.column, window.row, affine.copy()
    affine[:2, 3] += affine[:2, 0] * window.column + affine[:2, 1] * window.row
    field = Field.__new__(Field)
    field._make(Source(_samples(part, g, window), affine, g.placed, g.crs, None, g.nodata), threads, False, None, whole=whole)
    return field


_kept_field = functools.lru_cache(maxsize=1)(_field)  # the whole raster, for chunk after chunk


def _range(part, g, window):
    z = _samples(part, g, window)
    z = z[np.isfinite(z)]
    return (float(z.min()), float(z.max())) if z.size else (math.inf, -math.inf)


def _shadow(part, g, window, chunk, azimuth, altitude, disc, hillshade, threads):
    rows, columns = chunk.inside(window)
    field = _field(part, g, window, threads)
    return field._shadow_rows(azimuth, altitude, disc, hillshade, rows.start, chunk.rows)[:, columns]


def _around(part, g, window, chunk, name, threads, *arguments):
    rows, columns = chunk.inside(window)
    field = (_kept_field if isinstance(part, tuple) else _field)(part, g, window, threads)
    return getattr(field, name)(*arguments, rows.start, chunk.rows)[..., columns]


def _seen(part, g, window, place, absolute, target, distance, curvature, threads):
    """Counts of one observer, with 0 at holes."""
    field = _field(part, g, window, threads)
    out = np.zeros(field.shape, np.uint16)
    field._core.viewshed(np.array([place]), absolute, target, distance, curvature, False, out, threads, None)
    return out


def _sum_seen(part, g, chunk, padded, nodata, views):
    """A chunk of the viewshed from what observers near it see."""
    total = np.zeros((chunk.rows, chunk.columns), np.uint16)
    for window, seen in views:
        top, left = max(chunk.row, window.row), max(chunk.column, window.column)
        bottom, right = min(chunk.row + chunk.rows, window.row + window.rows), min(chunk.column + chunk.columns, window.column + window.columns)
        common = _Window(top, left, bottom - top, right - left)
        total[common.inside(chunk)] += seen[common.inside(window)]
    holes = ~np.isfinite(_samples(part, g, padded)[chunk.inside(padded)])
    total[holes] = nodata
    return total if nodata > 255 else total.astype(np.uint8)


# ---- the graph --------------------------------------------------------------------------------------------------------------


class _Raster:
    """A source, cut into chunks."""

    def __init__(self, source, chunks, threads, nodata, crs, band, memory) -> None:
        self.threads = count(threads, "threads", 0, 4096)
        self.memory = finite(memory, "memory", 1)
        self.like = self.path = None
        if isinstance(source, (str, os.PathLike)):
            self.path = os.path.abspath(os.fspath(source)) if "://" not in str(source) and not str(source).startswith("/vsi") else str(source)
            self.band = 0 if band is None else count(band, "band", 1, 65535)
            columns, rows = _cellwalk.raster_size(self.path, self.band)
            corner = open_field(self.path, (0, 0, 2, 2), band=band, nodata=nodata, crs=crs, threads=1)
            about = corner._source
            nodata = None if nodata is None else float(nodata)
        elif hasattr(source, "dims") and hasattr(source, "coords"):
            about = describe_dataarray(source, crs=crs, nodata=nodata)
            self.like, nodata = about.like, about.nodata
            rows, columns = self.like.shape
            self.array = self.like.data if isinstance(self.like.data, da.Array) else da.from_array(self.like.values, chunks="auto")
            chunks = self.array.chunks if chunks is None else chunks
        else:
            raise TypeError(f"source: {type(source).__name__}, expected a path or a DataArray")
        if min(rows, columns) < 2:
            raise ValueError(f"source: {rows} rows of {columns} samples, expected at least 2 of each")
        self.geometry = _Geometry(rows, columns, tuple(map(tuple, about.map.tolist())), about.placed, about.crs._replace(given=None), nodata)
        self.chunks = da.core.normalize_chunks(2048 if chunks is None else chunks, (rows, columns), dtype=np.float32)
        ends = [np.concatenate([[0], np.cumsum(sizes)]) for sizes in self.chunks]
        self.windows = [[_Window(int(r), int(c), h, w) for c, w in zip(ends[1], self.chunks[1])] for r, h in zip(ends[0], self.chunks[0])]

    def part(self, window: _Window):
        if self.path is not None:
            return self.path, self.band
        return self.array[window.row:window.row + window.rows, window.column:window.column + window.columns]

    def check_memory(self, window: _Window, what: str) -> None:
        need = window.rows * window.columns * _BYTES_A_SAMPLE
        if need > self.memory:
            raise ValueError(f"{what}: a chunk needs {window.rows} x {window.columns} samples around it, {need / 1e9:.2f} GB a task, more than "
                             f"memory={self.memory / 1e9:.2f} GB")

    def ranges(self):
        task = dask.delayed(_range, pure=True)
        padded = [[w.grown(self.geometry, 0, 0, 0, 0) for w in row] for row in self.windows]
        return dask.compute([[task(self.part(p), self.geometry, p) for p in row] for row in padded])[0]

    def result(self, blocks, dtype, name, attrs, lead=None):
        """Blocks of tasks, row by row, as one array, and as a DataArray if the source is one."""
        shape = (lambda w: (w.rows, w.columns)) if lead is None else (lambda w: (len(lead), w.rows, w.columns))
        array = da.block([[da.from_delayed(b, shape(w), dtype) for b, w in zip(row, windows)] for row, windows in zip(blocks, self.windows)])
        like = self.like
        if like is None:
            try:
                import xarray
            except ImportError:
                return array
            m = self.geometry.map
            if m[0][1] or m[1][0]:
                return array
            like = xarray.DataArray(array if lead is None else array[0], dims=("y", "x"), coords={
                "y": m[1][3] + m[1][1] * np.arange(self.geometry.rows), "x": m[0][3] + m[0][0] * np.arange(self.geometry.columns)})
        keep = {key: like.attrs[key] for key in ("grid_mapping", "crs") if key in like.attrs}
        if lead is not None:
            like = like.expand_dims(azimuth=lead)
        out = like.copy(deep=False, data=array)
        out.name, out.attrs, out.encoding = name, {**attrs, **keep}, {}
        return out


def shadow(source, azimuth=225, altitude=30, *, hillshade=False, disc=0, chunks=None, threads=1, nodata=None, crs=None, band=None,
           memory=2e9):
    """Sun and shadow on every sample, as Field.shadow. One pass over the raster is made at once; the rest is lazy."""
    r = _Raster(source, chunks, threads, nodata, crs, band, memory)
    g = r.geometry
    azimuth, altitude = finite(azimuth, "azimuth"), finite(altitude, "altitude", -90, 90)
    disc = SUN_RADIUS if disc is True else finite(disc, "disc", 0, 10)
    ranges = r.ranges()
    highest = max(high for row in ranges for _, high in row)
    windows = [[_sunward(g, w, low, highest, azimuth, altitude, disc) for w, (low, _) in zip(*rows)] for rows in zip(r.windows, ranges)]
    r.check_memory(max((w for row in windows for w in row), key=lambda w: w.rows * w.columns), f"altitude: {altitude}")
    task = dask.delayed(_shadow, pure=True)
    blocks = [[task(r.part(o), g, o, w, azimuth, altitude, disc, bool(hillshade), r.threads) for o, w in zip(*rows)]
              for rows in zip(windows, r.windows)]
    share = disc > 0 or hillshade
    attrs = {"long_name": "sunlight", "azimuth": azimuth, "altitude": altitude}
    return r.result(blocks, np.float32 if share else np.uint8, "shadow", attrs if share else {**attrs, "_FillValue": np.uint8(255)})


def _sunward(g, w, low, highest, azimuth, altitude, disc) -> _Window:
    """All from which a shadow can fall on the window. Rises are computed to 2^-21, hence the hair more; a cell for the edge that
    is crossed and one for the normal of hillshade."""
    if not low < highest:
        return w.grown(g, 1, 1, 1, 1)
    level = math.cos(math.radians(altitude))
    aside = disc / level if level > 0.01 else 0.0
    lowest_ray = altitude - disc
    if lowest_ray >= 90:
        return w.grown(g, 1, 1, 1, 1)
    reach = (highest - low) * g.metres_of_height / math.tan(math.radians(lowest_ray)) * (1 + 2.0**-19) if lowest_ray > 0 else math.inf
    azimuths = azimuth + aside * ((2 * np.arange(16) + 1) / 16 - 1)  # the strips of src/terrain/shadow.c
    # A heading serves up to 256 rows of a map in degrees, by the latitude of their middle.
    rows = np.arange(max(w.row - 256, 0), min(w.row + w.rows + 256, g.rows))
    across, down = g.cells_per_metre(azimuths[:, None], rows[None, :])
    if not math.isfinite(reach):
        reach = 1e30

    def cells(rate):
        return int(min(math.ceil(max(float(rate.max()), 0.0) * reach), 2**31)) + 2
    return w.grown(g, cells(-down), cells(down), cells(-across), cells(across))


def _everywhere(source, name, dtype, arguments, chunks, threads, nodata, crs, band, memory, attrs, lead=None):
    r = _Raster(source, chunks, threads, nodata, crs, band, memory)
    whole = _Window(0, 0, r.geometry.rows, r.geometry.columns)
    r.check_memory(whole, f"{name}: far mountains may count")
    task = dask.delayed(_around, pure=True)
    blocks = [[task(r.part(whole), r.geometry, whole, w, f"_{name}_rows", r.threads, *arguments) for w in row] for row in r.windows]
    return r.result(blocks, dtype, name, attrs, lead)


def horizon(source, directions=32, *, start=0.0, chunks=None, threads=1, nodata=None, crs=None, band=None, memory=2e9):
    """The horizon's angle in directions all round, as Field.horizon."""
    directions, start = count(directions, "directions", 1, 3600), finite(start, "start")
    azimuths = np.fmod(start + 360 * np.arange(directions) / directions, 360)
    return _everywhere(source, "horizon", np.float32, (directions, start), chunks, threads, nodata, crs, band, memory,
                       {"long_name": "horizon", "units": "degrees"}, azimuths)


def sky_view(source, directions=32, *, chunks=None, threads=1, nodata=None, crs=None, band=None, memory=2e9):
    """The share of the sky, as Field.sky_view."""
    directions = count(directions, "directions", 1, 3600)
    return _everywhere(source, "sky_view", np.float32, (directions,), chunks, threads, nodata, crs, band, memory,
                       {"long_name": "sky-view factor"})


def viewshed(source, x, y, observer_height=2.0, target_height=0.0, max_distance=None, *, observer_elevation=None, curvature=None,
             chunks=None, threads=1, nodata=None, crs=None, band=None, memory=2e9):
    """Which samples are seen, as Field.viewshed. Observers are looked at one by one, each in its window of max_distance."""
    r = _Raster(source, chunks, threads, nodata, crs, band, memory)
    g = r.geometry
    absolute = observer_elevation is not None
    given = [numbers(v, n).astype(np.float64) for v, n in ((x, "x"), (y, "y"), (observer_elevation if absolute else observer_height, "observer_height"))]
    places = np.stack(np.broadcast_arrays(*given), -1).reshape(-1, 3)
    if not 1 <= len(places) <= 65534 or not np.isfinite(places).all():
        raise ValueError(f"x, y: expected 1 to 65534 finite observers, not {len(places)}")
    distance = 0.0 if max_distance is None else finite(max_distance, "max_distance", 0)
    bend = (6.0 / 7 if g.placed else 0.0) if curvature is None else finite(curvature, "curvature", 0)
    task, views = dask.delayed(_seen, pure=True), []
    for place in places:
        window = _around_place(g, place, distance)
        if window is None:
            continue
        r.check_memory(window, "max_distance")
        views.append((window, task(r.part(window), g, window, place, absolute, finite(target_height, "target_height"), distance, bend, r.threads)))
    nodata_out, add = 255 if len(places) <= 254 else 65535, dask.delayed(_sum_seen, pure=True)

    def block(w):
        near = [(v, s) for v, s in views if v.row < w.row + w.rows and w.row < v.row + v.rows
                and v.column < w.column + w.columns and w.column < v.column + v.columns]
        padded = w.grown(g, 0, 0, 0, 0)
        return add(r.part(padded), g, w, padded, nodata_out, near)
    dtype = np.uint8 if nodata_out == 255 else np.uint16
    return r.result([[block(w) for w in row] for row in r.windows], dtype, "viewshed",
                    {"long_name": "number of observers that see it", "_FillValue": dtype(nodata_out)})


def _around_place(g, place, distance) -> Optional[_Window]:
    """The samples within the distance and a cell more, the eye's own cell among them."""
    whole = _Window(0, 0, g.rows, g.columns)
    if distance == 0:
        return whole
    (a, b, _, e), (c, d, _, f) = g.map[0], g.map[1]
    determinant = a * d - b * c
    x, y = place[0] - e, place[1] - f
    column, row = (d * x - b * y) / determinant, (a * y - c * x) / determinant
    east, north = (float(v) for v in g.metres(row))
    across = distance * (abs(d / determinant) / east + abs(b / determinant) / north) + 3
    down = distance * (abs(a / determinant) / north + abs(c / determinant) / east) + 3
    top, left = max(math.floor(row - down), 0), max(math.floor(column - across), 0)
    bottom, right = min(math.ceil(row + down), g.rows), min(math.ceil(column + across), g.columns)
    if bottom <= top or right <= left:
        return None
    return _Window(top, left, bottom - top, right - left).grown(g, 0, 0, 0, 0)


# ---- results ----------------------------------------------------------------------------------------------------------------


class _GeoTiff:
    """Takes chunks as they are done. A chunk that is written twice, since a worker died, is the same both times."""

    def __init__(self, path) -> None:
        self.path = path

    def __setitem__(self, index, block) -> None:
        import rasterio
        from rasterio.windows import Window
        rows, columns = index[-2:]
        window = Window(columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start)
        with rasterio.open(self.path, "r+") as file:
            bands = range(index[0].start + 1, index[0].stop + 1) if block.ndim == 3 else 1
            file.write(block, indexes=list(bands) if block.ndim == 3 else 1, window=window)


def to_geotiff(result, path, like=None) -> None:
    """Computes a result and writes it to a tiled GeoTIFF, chunk by chunk as they are done. Needs rasterio.

    like: a file of the same size whose place and coordinate system the result takes.
    """
    import rasterio
    array = result.data if hasattr(result, "dims") else result
    profile = {"driver": "GTiff", "height": array.shape[-2], "width": array.shape[-1], "count": array.shape[0] if array.ndim == 3 else 1,
               "dtype": array.dtype.name, "tiled": True, "blockxsize": 256, "blockysize": 256, "compress": "deflate", "BIGTIFF": "IF_SAFER",
               "nodata": np.nan if array.dtype.kind == "f" else int(np.iinfo(array.dtype).max)}
    if like is not None:
        with rasterio.open(like) as file:
            profile.update(transform=file.transform, crs=file.crs)
    part = f"{os.fspath(path)}.part"
    with rasterio.open(part, "w", **profile):
        pass
    try:
        from distributed import Lock, get_client
        get_client()
        lock = Lock(part)
    except (ImportError, ValueError):
        lock = True
    try:
        da.store(array, _GeoTiff(os.path.abspath(part)), lock=lock)
        os.replace(part, path)
    finally:
        if os.path.exists(part):
            os.unlink(part)
