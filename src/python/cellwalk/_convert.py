# SPDX-License-Identifier: Apache-2.0
"""What callers hand in, made into what the libraries take: contiguous arrays and maps. No argument is ever changed. Messages say
argument, shape and value."""

from __future__ import annotations

import math
import operator
from typing import Any, Optional

import numpy as np

from ._core import lib, warn
from ._raster import WGS84, Crs, Source, read_crs

# ---- maps -----------------------------------------------------------------------------------------------------------------

def map_of_transform(transform) -> np.ndarray:
    """Samples (i, j, z) to the map, 3 x 4. A transform of rasterio's kind speaks of the corners of pixels, and a sample stands in
    its pixel's middle."""
    if transform is None:
        return np.eye(3, 4)
    given = [getattr(transform, name) for name in "abcdef"] if all(hasattr(transform, name) for name in "abcdef") else transform
    try:
        numbers = np.array(given, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"transform: {transform!r}, expected an Affine or numbers") from None
    if numbers.shape == (3, 4):
        return numbers
    if numbers.shape in ((9,), (3, 3)):
        numbers = numbers.ravel()[:6]
    if numbers.shape != (6,):
        raise ValueError(f"transform: shape {numbers.shape}, expected an Affine, (6,), (3, 3) or (3, 4)")
    a, b, c, d, e, f = (float(x) for x in numbers)
    sides = math.hypot(a, d), math.hypot(b, e)
    if 1000 * min(sides) < max(sides):
        raise ValueError(f"transform: {(a, b, c, d, e, f)} makes cells of {sides[0]:g} x {sides[1]:g}, which looks like GDAL's order of "
                         "the numbers; Affine.from_gdal takes that")
    if not (np.isfinite(numbers).all() and a * e - b * d != 0):
        raise ValueError(f"transform: {(a, b, c, d, e, f)}, expected finite numbers with a way back from x and y to samples")
    # The order of additions is the one of src/io/raster/gdal/read.c, so that bits are the same.
    return np.array([[a, b, 0, c + 0.5 * a + 0.5 * b], [d, e, 0, f + 0.5 * d + 0.5 * e], [0, 0, 1, 0]])


def line_of_coordinates(values, name: str) -> tuple[float, float]:
    """Start and step of regular coordinates. They may be off by a hundredth of a step, or by what their dtype rounds."""
    values = np.asarray(values)
    if values.ndim != 1 or values.size < 2:
        raise ValueError(f"{name}: shape {values.shape}, expected the coordinates of at least 2 samples")
    if not np.issubdtype(values.dtype, np.number):
        raise ValueError(f"{name}: dtype {values.dtype}, expected numbers")
    numbers = values.astype(np.float64)
    first, last = float(numbers[0]), float(numbers[-1])
    step = (last - first) / (numbers.size - 1)
    if not (math.isfinite(step) and step != 0):
        raise ValueError(f"{name}: from {first} to {last}, expected finite coordinates that rise or fall")
    off = np.abs(numbers - (first + step * np.arange(numbers.size)))
    rounding = np.finfo(values.dtype).eps * float(np.abs(numbers).max()) if values.dtype.kind == "f" else 1.0
    worst = int(np.argmax(off))
    if not off[worst] <= max(0.01 * abs(step), rounding):
        raise ValueError(f"{name}: irregular spacing: number {worst} is {numbers[worst]}, expected about "
                         f"{first + step * worst}; resample to a regular grid first")
    return first, step


# ---- samples --------------------------------------------------------------------------------------------------------------

def check_sides(shape: tuple[int, int], name: str, least: int = 2) -> None:
    if min(shape) < least or max(shape) > lib.CW_SIDE_MAX:
        raise ValueError(f"{name}: shape {shape}, expected at least {least} rows and {least} columns, and at most {lib.CW_SIDE_MAX}")


def samples_of(values, nodata=None, name: str = "z", least: int = 2) -> np.ndarray:
    """Contiguous native float32 with NaN at holes, at least so many rows and columns. Copied only if it is not that already."""
    holes: Any = False
    if isinstance(values, np.ma.MaskedArray):
        holes, values = np.ma.getmaskarray(values), values.data
    array = array_of(values, name)
    if array.ndim != 2:
        raise ValueError(f"{name}: shape {array.shape}, expected (rows, columns)")
    check_sides(array.shape, name, least)
    if array.dtype.kind not in "fiub" or array.dtype.itemsize > 8 and array.dtype.kind != "f":
        raise TypeError(f"{name}: dtype {array.dtype}, expected real numbers")
    if nodata is not None and not np.isnan(nodata):
        # Compared as the samples are stored: a float32 file's 3.4e38 is not the double that a header spells.
        with np.errstate(over="ignore"):
            equal = array == (array.dtype.type(nodata) if array.dtype.kind == "f" else nodata)
        holes = equal | holes
    with np.errstate(over="ignore", invalid="ignore"):
        samples = np.require(array, np.float32, ["C", "A"])
    if array.dtype.kind == "f" and array.dtype.itemsize > 4:
        over = np.isinf(samples) & np.isfinite(array) & np.logical_not(holes)
        if over.any():
            place = tuple(int(k) for k in np.argwhere(over)[0])
            raise ValueError(f"{name}: the sample at {place} is {array[place]}, beyond the range of float32")
    if np.any(holes):
        if np.shares_memory(samples, array):
            samples = samples.copy()
        samples[holes] = np.nan
    return samples


_X_NAMES = ("x", "lon", "longitude", "easting", "projection_x_coordinate")
_Y_NAMES = ("y", "lat", "latitude", "northing", "projection_y_coordinate")


def describe_dataarray(z, transform=None, crs=None, nodata=None, zscale=None) -> Source:
    """All but the samples, which need not be in memory."""
    like = z
    if z.ndim > 2:
        like = z.squeeze([d for d in z.dims[:-2] if z.sizes[d] == 1])
    if like.ndim != 2:
        raise ValueError(f"z: dimensions {dict(z.sizes)}, expected (y, x); choose one with .isel")
    y, x = like.dims
    if str(x).lower() in _Y_NAMES or str(y).lower() in _X_NAMES:
        raise ValueError(f"z: dimensions {like.dims}, expected (y, x); use .transpose({x!r}, {y!r})")
    if (like.attrs.get("scale_factor", 1), like.attrs.get("add_offset", 0)) != (1, 0):
        raise ValueError("z: attrs have scale_factor or add_offset, so its numbers are not heights yet; open it with mask_and_scale=True")
    placed = True
    if transform is not None:
        affine = map_of_transform(transform)
    elif x in like.coords and y in like.coords:
        first_x, step_x = line_of_coordinates(like[x].values, f"z.{x}")
        first_y, step_y = line_of_coordinates(like[y].values, f"z.{y}")
        affine = np.array([[step_x, 0, 0, first_x], [0, step_y, 0, first_y], [0, 0, 1, 0]], np.float64)
    else:
        affine, placed = map_of_transform(None), False
    for place in (like.attrs, {} if {"scale_factor", "add_offset"} & like.encoding.keys() else like.encoding):  # not of packed numbers
        for key in ("_FillValue", "nodata", "missing_value"):
            if nodata is None and np.ndim(place.get(key)) == 0 and place.get(key) is not None:
                nodata = nodata_of(place[key])
    if crs is None:
        mapping = like.coords.get(like.attrs.get("grid_mapping", like.encoding.get("grid_mapping", "spatial_ref")))
        named = {} if mapping is None else mapping.attrs
        crs = named.get("crs_wkt") or named.get("spatial_ref") or like.attrs.get("crs")
    if crs is None and placed and str(x).lower() in ("lon", "longitude"):
        crs = WGS84
    known = read_crs(crs)
    return _source(None, like.shape, affine, placed, known, nodata, zscale, like.attrs.get("units"), like)


def coarser_like(like, samples, factor):
    """A DataArray as like for every factor-th sample, or None. Coordinates of its dimensions go on beyond like's last ones."""
    if like is None:
        return None
    import xarray
    coords = {name: value for name, value in like.coords.items() if not set(value.dims) & set(like.dims)}
    for axis, name in enumerate(like.dims):
        if name in like.coords:
            old = like.coords[name]
            place = factor * np.arange(samples.shape[axis])
            first, step = float(old.values[0]), (float(old.values[-1]) - float(old.values[0])) / (len(old) - 1)
            values = np.where(place < len(old), np.asarray(old.values, np.float64)[np.minimum(place, len(old) - 1)],
                              first + step * place)
            coords[name] = xarray.Variable((name,), values, old.attrs)
    return xarray.DataArray(samples, coords, like.dims, like.name, like.attrs)


def dress(like, data, name: str, attrs: dict[str, Any], lead: Optional[tuple[str, Any]] = None):
    """Data as a DataArray like another one; lead: a dimension before its own, and the values there."""
    keep = {key: like.attrs[key] for key in ("grid_mapping", "crs") if key in like.attrs}
    if lead is not None:
        like = like.expand_dims(dict([lead]))
    out = like.copy(deep=False, data=data)
    out.name, out.attrs, out.encoding = name, {**attrs, **keep}, {}
    return out


_METRES = {"m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
           "us-ft": 1200 / 3937, "us survey foot": 1200 / 3937, "km": 1000.0, "cm": 0.01, "mm": 0.001, "dm": 0.1}


def _source(samples, shape, affine: np.ndarray, placed: bool, crs: Crs, nodata, zscale, unit, like=None) -> Source:
    """Fills in the map's third row: heights in the unit of x and y, or in metres on a map in degrees. Warns, as the program does,
    where that is a guess that may be wrong."""
    dx, (x, y) = math.hypot(affine[0, 0], affine[1, 0]), affine[:2, 3]
    if crs.geographic and not placed:
        raise ValueError("crs: is in degrees, and without a transform nothing says where the samples lie")
    if placed and crs.wkt is None and 0 < dx < 0.1 and abs(x) <= 360 and abs(y) <= 90:
        warn(f"transform: samples are {dx:g} apart around ({x:g}, {y:g}), which looks like degrees, but there is no coordinate system "
              "(crs); heights are taken in the same unit")
    if zscale is not None:
        affine[2, 2] = above(zscale, "zscale")
    elif isinstance(unit, str) and unit.lower() in _METRES and (placed or crs.unit > 0):
        affine[2, 2] = _METRES[unit.lower()] / (1.0 if crs.geographic or crs.unit == 0 else crs.unit)
        if affine[2, 2] != 1 and crs.unit == 0:
            warn(f"units: heights are in {unit}, and x and y are taken as metres, as there is no coordinate system (crs); zscale=1 if they "
                 "are in the unit of heights")
    elif placed and not crs.geographic and crs.unit not in (0, 1):
        known = (name for metres, name in ((0.3048, "ft"), (1200 / 3937, "US survey ft")) if abs(crs.unit / metres - 1) < 1e-8)
        name = next(known, f"x {crs.unit:.9g} m")
        warn(f"crs: heights taken as {name}, as x and y; zscale={1 / crs.unit:.5g} if they are metres")
    return Source(samples, shape, affine, placed, crs, nodata, like)


def _source_of_dataset(z, transform, crs, nodata, zscale, band) -> Source:
    band = 1 if band is None else band
    array = z.read(band, masked=True)
    samples = samples_of(array, nodata)
    nodata = z.nodata if nodata is None else nodata
    scale, offset = (getattr(z, "scales", None) or (1,) * band)[band - 1], (getattr(z, "offsets", None) or (0,) * band)[band - 1]
    if (scale, offset) != (1, 0):
        samples = samples_of(np.ma.MaskedArray(offset + scale * array.data.astype(np.float64), np.isnan(samples)))
    given = transform if transform is not None else z.transform
    placed = transform is not None or tuple(given)[:6] != (1, 0, 0, 0, 1, 0)
    known = read_crs(crs if crs is not None else z.crs)
    affine = map_of_transform(given if placed else None)
    units = getattr(z, "units", None)
    return _source(samples, array.shape, affine, placed, known, nodata, zscale, units[band - 1] if units else None)


def read_source(z, transform, crs, nodata, zscale, band) -> Source:
    if hasattr(z, "ndim") and hasattr(z, "coords"):
        described = describe_dataarray(z, transform, crs, nodata, zscale)
        return described._replace(samples=samples_of(described.like.values, described.nodata))
    if hasattr(z, "read") and hasattr(z, "transform"):
        return _source_of_dataset(z, transform, crs, nodata, zscale, band)
    if isinstance(z, (str, bytes)) or hasattr(z, "__fspath__"):
        raise TypeError(f"z: {z!r} is a path; use cellwalk.open")
    if band is not None:
        raise ValueError(f"band: {band!r}, but z is an array and has none")
    known, affine, placed = read_crs(crs), map_of_transform(transform), transform is not None
    samples = samples_of(z, nodata)
    return _source(samples, samples.shape, affine, placed, known, nodata, zscale, None)


# ---- numbers --------------------------------------------------------------------------------------------------------------


def nodata_of(value) -> Optional[float]:
    """A float, or None; NaN and infinity may also stand for no data."""
    try:
        return None if value is None else float(value)
    except (TypeError, ValueError):
        raise TypeError(f"nodata: {value!r}, expected a number") from None


def finite(value, name: str, low: float = -math.inf, high: float = math.inf) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: {value!r}, expected a number") from None
    if not (math.isfinite(number) and low <= number <= high):
        limits = f" from {low:g} to {high:g}" if high < math.inf else f" from {low:g} on" if low > -math.inf else ""
        raise ValueError(f"{name}: {value!r}, expected a finite number{limits}")
    return number


def above(value, name: str, what: str = "a number above 0") -> float:
    """A number above 0; 0 for None."""
    if value is not None and not finite(value, name) > 0:
        raise ValueError(f"{name}: {value!r}, expected {what}")
    return 0.0 if value is None else float(value)


def common_shape(named: dict[str, tuple], shapes=None) -> tuple[int, ...]:
    """The broadcast of shapes, by default of those of named; errors list named."""
    try:
        return np.broadcast_shapes(*(named.values() if shapes is None else shapes))
    except ValueError:
        raise ValueError(f"shapes do not broadcast: {', '.join(f'{name} {shape}' for name, shape in named.items())}") from None


def count(value, name: str, low: int, high: int) -> int:
    try:
        number = operator.index(None if isinstance(value, bool) else value)
    except TypeError:
        raise TypeError(f"{name}: {value!r}, expected an integer") from None
    if not low <= number <= high:
        raise ValueError(f"{name}: {number}, expected {low} to {high}")
    return number


def array_of(value, name: str) -> np.ndarray:
    try:
        return np.asarray(value)
    except (TypeError, ValueError) as error:  # rows of different lengths
        raise ValueError(f"{name}: {error}") from None


def numbers(value, name: str) -> np.ndarray:
    """An array of real numbers as float32 or float64, in any layout; copied only to convert. Masked ones become NaN."""
    array = array_of(value, name)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: dtype {array.dtype}, expected real numbers")
    if np.ma.is_masked(value):
        array = np.where(np.ma.getmaskarray(value), np.float32(np.nan), array)
    return array.astype(np.float32 if array.dtype.kind == "f" and array.dtype.itemsize <= 4 else np.float64, copy=False)
