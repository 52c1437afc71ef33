# SPDX-License-Identifier: Apache-2.0
"""Coordinate systems; rasters from and to files."""

from __future__ import annotations

import importlib
import math
import os
import re
from typing import Any, NamedTuple, Optional

import numpy as np

from ._core import NULL, Work, c_text, do_io, ffi, lib, raster_door

WGS84 = ('GEOGCRS["WGS 84",DATUM["World Geodetic System 1984",ELLIPSOID["WGS 84",6378137,298.257223563,LENGTHUNIT["metre",1]]],'
          'CS[ellipsoidal,2],AXIS["longitude",east],AXIS["latitude",north],ANGLEUNIT["degree",0.0174532925199433]]')


class Crs(NamedTuple):
    given: Any  # what the caller had
    wkt: Optional[str]
    geographic: bool
    unit: float  # metres or radians in one of x and y; 0: not known
    semi_major: float
    inverse_flattening: float


class Source(NamedTuple):
    """What a field is made of, whatever it came from."""
    samples: Any  # float32, contiguous; the caller's own memory where that is possible. None: not read yet
    shape: tuple[int, int]
    map: Any  # 3 rows of 4 numbers
    placed: bool
    crs: Crs
    nodata: Optional[float]
    like: Any = None  # the DataArray that results look like
    scale: Optional[bytes] = None  # of scale_of; None: not known yet
    whole: Any = None  # the Source that the samples are a window of, and column and row of the window


def read_crs(crs) -> Crs:
    """A coordinate system as WKT, an object with to_wkt(), or what rasterio or pyproj make one of ("EPSG:32632", 4326)."""
    if crs is None:
        return Crs(None, None, False, 0.0, 0.0, 0.0)
    if isinstance(crs, Crs):
        return crs
    if isinstance(crs, (str, int)) and str(crs).upper() in ("4326", "EPSG:4326", "OGC:CRS84"):
        return read_crs(WGS84)._replace(given=crs)
    text = crs.to_wkt() if hasattr(crs, "to_wkt") else crs
    georef = georef_of(text if isinstance(text, str) else None)
    if not georef.crs and not hasattr(crs, "to_wkt"):
        georef = georef_of(_look_up(crs))
    if not georef.crs:
        raise ValueError(f"crs: {crs!r} is neither geographic nor projected")
    return crs_of(georef, crs)


def _look_up(crs) -> str:
    for module in "pyproj.crs", "rasterio.crs":
        try:
            wkt = importlib.import_module(module).CRS.from_user_input(crs).to_wkt()
        except ImportError:
            continue
        except Exception as error:
            raise ValueError(f"crs: {crs!r}: {error}") from None
        found, is_name = wkt.split('"')[1], isinstance(crs, str) and not re.search(r"[:+={\[]|^\d+$", crs)
        if is_name and re.sub("[ _]", "", crs).lower() != found.replace(" ", "").lower():  # "foo" is found, as a part of Amersfoort
            raise ValueError(f"crs: {crs!r} is the name of no coordinate system; {found!r} is the nearest")
        return wkt
    raise ValueError(f"crs: {crs!r} is no well-known text, and neither pyproj nor rasterio is installed to look it up")


def georef_of(wkt: Optional[str]) -> Any:
    """Without crs if that is no well-known text."""
    georef = ffi.gc(ffi.new("io_georef *"), lib.io_georef_free)
    if wkt is not None:
        lib.io_georef_from_wkt(georef, c_text(wkt))
    return georef


def crs_of(georef, given: Any = None) -> Crs:
    wkt = ffi.string(georef.crs).decode(errors="replace") if georef.crs else None
    return Crs(wkt if given is None else given, wkt, georef.geographic, georef.unit, georef.semi_major, georef.inverse_flattening)


def scale_of(source: Source, name: str) -> bytes:
    """How long the unit of a projected map is on the ground, for Core.set_scale; warns if that is not known or not the same in all
    directions."""
    if source.crs.wkt is None or source.crs.geographic or not source.placed:
        return b""
    work, scale, georef = Work("crs"), ffi.new("map_scale *"), georef_of(source.crs.wkt)
    georef.placed = georef.crs != NULL
    with raster_door:
        found = min(source.shape) >= 2 and lib.io_scale_find(georef, ffi.new("double[3][4]", source.map.tolist()), *source.shape[::-1],
                                                             c_text(name), ffi.new("io_warner *", (lib.python_warn, work.c)), scale)
    work.tell()
    return bytes(ffi.buffer(scale)) if found else b""


def find_place(crs: Crs, x: float, y: float) -> tuple[float, float, float]:
    """Longitude, latitude, and how far the map's north is turned there from the true one, toward the west."""
    place, terrain = ffi.new("sun_place *"), ffi.new("terrain *", {"geographic": crs.geographic, "unit": crs.unit or math.pi / 180})
    do_io(lib.sun_place_of, terrain, georef_of(crs.wkt), ffi.new("double[2]", [x, y]), b"crs", NULL, place, fails=ValueError)
    return place.longitude, place.latitude, place.turned


# ---- files -------------------------------------------------------------------------------------------------------------------


def read_raster(path: str, band: int, nodata: Optional[float] = None, cellsize: float = 0.0, zscale: float = 0.0,
                window: Optional[tuple[int, int, int, int]] = None, progress=None) -> tuple[Source, Work]:
    """Returns the raster, and the work that tells its warnings. Band 0 is the first. window: column, row, columns and rows, all zero for
    all; None: only the header, if the format has windows."""
    column, row, columns, rows = window or (0, 0, 0, 0)
    work, raster = Work(path, progress=progress), ffi.gc(ffi.new("io_raster *"), lib.io_raster_free)
    values = ffi.new("double[]", [] if nodata is None else [nodata])
    options = ffi.new("io_raster_options *", {
        "band": band, "nodata": values, "nodata_count": len(values), "cellsize": cellsize, "zscale": zscale, "no_samples": window is None,
        "window": {"i": column, "j": row, "nx": columns, "ny": rows}, "warn": (lib.python_warn, work.c),
        "progress": ffi.addressof(lib, "work_watch"), "context": work.c})
    do_io(lib.io_raster_read, c_text(os.fsencode(path)), options, raster, work=work)
    work.finish()
    shape = raster.ny, raster.nx
    samples = None
    if raster.memory:
        memory, raster.memory = raster.memory, NULL
        samples = np.frombuffer(ffi.buffer(ffi.gc(memory, lib.drop_samples), 4 * shape[0] * shape[1]), np.float32).reshape(shape)
    georef = raster.georef
    return Source(samples, shape, np.array([list(line) for line in raster.map]), georef.placed, crs_of(georef),
                  georef.nodata if georef.has_nodata else None), work


_CELLS = {name: getattr(lib, f"IO_CELL_{name.upper()}") for name in ("uint8", "uint16", "int16", "float32")}


class GeoTiff:
    """A file that is written by windows, through the same code as the program's results: it has no name before all is on the disk, and a
    disk that is full is an error."""

    def __init__(self, path, bands: int, rows: int, columns: int, dtype: str, nodata: float, affine: Optional[np.ndarray],
                 wkt: Optional[str], compress: bool) -> None:
        self._writer, self._process, self._dtype = ffi.new("io_raster_writer *"), os.getpid(), dtype
        if dtype not in _CELLS:
            raise TypeError(f"result: dtype {dtype}, expected uint8, uint16, int16 or float32; astype converts")
        name = c_text(os.fsencode(path))
        if not lib.io_raster_is_tif(name):
            raise ValueError(f"path: {os.fsdecode(name)!r}, expected a name that ends in .tif")
        georef = georef_of(wkt)
        georef.placed = affine is not None
        place = ffi.new("double[3][4]", [] if affine is None else affine.tolist())
        tiles = [ffi.new("char[]", option) for option in (b"BLOCKXSIZE=256", b"BLOCKYSIZE=256")]  # end where aligned chunks do
        creation = ffi.new("char *[]", tiles)
        product = {"bands": bands, "ny": rows, "nx": columns, "cell": _CELLS[dtype], "map": place, "georef": georef, "has_nodata": True,
                   "nodata": nodata, "uncompressed": not compress, "creation": creation, "creation_count": len(tiles)}
        self._kept = georef, place, tiles, creation  # the writer has pointers to them
        do_io(lib.io_raster_create, self._writer, name, ffi.new("io_raster_product *", product))

    def _is_open(self) -> bool:
        """GDAL's unwritten tiles and the file belong to the process that opened it: a child that was forked touches neither."""
        return self._writer.sink != NULL and self._process == os.getpid()

    def _do(self, function, *arguments) -> None:
        if not self._is_open():
            raise ValueError("the GeoTIFF is closed, or was opened by another process")
        do_io(function, self._writer, *arguments)

    def write(self, band: int, row: int, column: int, rows: int, columns: int, block: np.ndarray) -> None:
        """Each cell once, in any order."""
        p = self._writer.product
        if not (0 <= band < p.bands and 0 <= row < row + rows <= p.ny and 0 <= column < column + columns <= p.nx
                and block.nbytes == rows * columns * np.dtype(self._dtype).itemsize):
            raise ValueError("block: not of the size of its window, or beyond the raster")
        window = ffi.new("io_raster_window *", (column, row, columns, rows))
        self._do(lib.io_raster_write_window, band, window, ffi.from_buffer(block))

    def commit(self) -> None:
        """The file gets its name, if every cell was written."""
        self._do(lib.io_raster_commit)

    def discard(self) -> None:
        """Nothing remains. After commit there is nothing to do."""
        if self._is_open():
            with raster_door:
                lib.io_raster_discard(self._writer)

    __del__ = discard
