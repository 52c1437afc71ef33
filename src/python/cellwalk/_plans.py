# SPDX-License-Identifier: Apache-2.0
"""How a product's arguments, checked, become a plan: the library's structs by the names of their members, and how the result looks. Field
makes a plan's product of all rows, cellwalk.dask of a chunk's. And places: spots, lines of sight."""

from __future__ import annotations

import math
from typing import Any, Callable, NamedTuple, Optional

import numpy as np

from ._convert import above, common_shape, count, dress, finite, numbers
from ._core import Core, Work, ffi, lib
from ._raster import Source, find_place

SPOTS_MOST = 65534  # which uint16 counts


class Plan(NamedTuple):
    method: str  # which messages of the library begin with
    make: Callable[..., Any]  # (core, work, area, out, numbers, *inputs)
    numbers: dict[str, Any]  # members of the struct that says how
    name: str  # the result's
    attrs: dict[str, Any]
    dtype: Any = np.float32
    lead: Optional[tuple[str, Any]] = None  # a dimension before rows and columns, and its values
    inputs: tuple = ()

    def shape(self, rows: int, columns: int) -> tuple[int, ...]:
        every = int(self.numbers.get("every", 1))
        return (*(() if self.lead is None else (len(self.lead[1]),)), -(-rows // every), -(-columns // every))


class Products:
    """Methods of Field, which has these members."""
    _core: Core
    _ground: Core
    _source: Source
    _threads: int
    shape: tuple[int, int]

    def _run(self, method: str, make: Callable[..., Any], *arguments, progress=None, threads: int | None = None, core: Core | None = None,
             kernel: str | None = None, change: bool = False) -> Any:
        """make(core, work, *arguments) of the ground, or of the field's core, whose map need not have a way back."""
        work = Work(method, self._threads if threads is None else threads, progress, kernel)
        return (self._ground if core is None else core).use(work, make, *arguments, change=change)

    def _rows(self, plan: Plan, window: tuple[int, int, int, int] | None = None, progress=None) -> np.ndarray:
        """The plan's product of all samples, or of a window's: column, row, columns and rows."""
        at = (0, 0, *self.shape[::-1]) if window is None else window
        out = np.zeros(plan.shape(at[3], at[2]), plan.dtype)
        self._run(plan.method, plan.make, ffi.new("cw_area *", {"at": at})[0], out, plan.numbers, *plan.inputs, progress=progress)
        return out

    def _dress(self, plan: Plan, data: np.ndarray) -> Any:
        """Data as a DataArray if the field was made of one."""
        like, every = self._source.like, int(plan.numbers.get("every", 1))
        return data if like is None else dress(like[::every, ::every], data, plan.name, plan.attrs, plan.lead)

    def _product(self, plan: Plan, progress=None) -> Any:
        return self._dress(plan, self._rows(plan, None, progress))

    def _locate(self, what: str, place: Optional[tuple[float, float]] = None, lon_lat=None) -> tuple[float, float, float]:
        """Longitude and latitude of a place, by default the middle, unless given; how far its map's north is turned west of the true one."""
        m, known, (rows, columns) = self._source.map, self._source.crs, self.shape
        if lon_lat is not None:
            if np.shape(lon_lat) != (2,):
                raise ValueError(f"lon_lat: {lon_lat!r}, expected a longitude and a latitude")
            if known.geographic or known.wkt is not None:
                raise ValueError("lon_lat: is for fields without a coordinate system (crs), and this one has it")
            return math.remainder(finite(lon_lat[0], "lon_lat", -360, 360), 360), finite(lon_lat[1], "lon_lat", -90, 90), 0.0
        i, j = 0.5 * (columns - 1), 0.5 * (rows - 1)
        x, y = (float(m[k][0] * i + m[k][1] * j + m[k][3]) for k in range(2)) if place is None else place
        if not known.geographic and known.wkt is None:
            raise ValueError(f"{what}: without a coordinate system (crs) nothing says where the sun stands; give "
                             f"{'azimuth and altitude' if what == 'time' else 'lon_lat'}")
        longitude, latitude, turned = find_place(known, x, y)
        return longitude, finite(latitude, "latitude", -90, 90), turned

    def _bend(self, curvature) -> float:
        """The curvature of lines of sight."""
        return (6.0 / 7 if self._source.placed else 0.0) if curvature is None else finite(curvature, "curvature", 0, 1e9)


def distance_of(max_distance) -> float:
    """Metres; 0: no limit."""
    return above(max_distance, "max_distance", "metres above 0")


def round_of(directions, max_distance, curvature, start=0.0, flags: int = 0) -> dict[str, Any]:
    """A cw_horizon."""
    return {"start": finite(start, "start"), "count": count(directions, "directions", 1, 3600),
            "max_distance": distance_of(max_distance), "curvature": finite(curvature, "curvature", 0, 1e9), "flags": flags}


def azimuths_of(sky: dict[str, Any]) -> np.ndarray:
    return np.fmod(sky["start"] + 360 * np.arange(sky["count"]) / sky["count"], 360)


def spots_of(x, y, height, elevation, default: float = 2.0, weights=None, of: str = "observer_") -> np.ndarray:
    """Places, shape (n, 5): x, y, height, 1 if that is absolute and 0 if above ground, weight. of: what arguments' names begin with."""
    absolute = elevation is not None
    if absolute and height is not None:
        raise ValueError(f"{of}height: goes without {of}elevation")
    name = f"{of}elevation" if absolute else f"{of}height"
    height = elevation if absolute else default if height is None else height
    given = [numbers(value, what).astype(np.float64) for value, what in
             ((x, "x"), (y, "y"), (height, name), (1.0 if weights is None else weights, "weights"))]
    spots = np.empty((*common_shape(dict(zip(("x", "y", name, "weights"), map(np.shape, given)))), 5))
    spots[..., 0], spots[..., 1], spots[..., 2], spots[..., 4] = given
    spots[..., 3] = absolute
    spots = spots.reshape(-1, 5)
    if not np.isfinite(spots[:, 4]).all():
        raise ValueError(f"weights: {spots[~np.isfinite(spots[:, 4]), 4][0]}, expected finite numbers")
    if not np.isfinite(spots).all():
        raise ValueError(f"x, y, {name}: {spots[~np.isfinite(spots).all(1)][0, :3].tolist()} is not finite")
    if not 1 <= len(spots) <= SPOTS_MOST:
        raise ValueError(f"x, y: {len(spots)} places, expected 1 to {SPOTS_MOST}")
    return spots


def find_eye(core: Core, spot, name: Optional[str]) -> Any:
    """Field coordinates of a spot that one can look from. name: the argument's, for the error; None: return None."""
    x, y, z, absolute, _ = spot
    at, place = ffi.new("double[3]"), ffi.new("io_place *", {"x": x, "y": core.north(y), "z": z, "absolute": bool(absolute)})
    state = lib.ground_try_place(core.terrain, place, at, ffi.new("double *"))
    if state == lib.PLACE_GOOD:
        return at
    if name is not None:
        why = {lib.PLACE_FAR: "is too far away from the terrain", lib.PLACE_NO_GROUND: "has no ground under it, as only an absolute height may",
               lib.PLACE_UNDER: "is under the ground", lib.PLACE_HIGH: "is too high"}[state]
        raise ValueError(f"{name}: ({x:.10g}, {y:.10g}, {z:.10g}) {why}")
    return None


def along(core, work, spots, every):
    """Observers along a line."""
    corners = ffi.new("io_place[]", [{"x": x, "y": core.north(y), "z": z, "absolute": bool(absolute), "weight": weight}
                                         for x, y, z, absolute, weight in spots])
    source = ffi.new("observers_from *", {"places": corners, "place_count": len(spots), "every": every})
    ground, error = ffi.new("ground *", {"whole": core.terrain[0]}), ffi.new("io_error *")
    found = ffi.gc(ffi.new("io_points *"), lib.io_points_free)
    if not lib.observers_find(found, source, ground, error):
        raise ValueError(f"every: {ffi.string(error.text).decode()}")
    if found.count > SPOTS_MOST:
        raise ValueError(f"every: {every!r} makes {found.count} observers, expected at most {SPOTS_MOST}")
    return np.array([(o.x, core.north(o.y), o.z, o.absolute, o.weight) for o in found.list[0:found.count]], np.float64)


# Of include/cellwalk_terrain.h.
SIGHT = np.dtype([("ends", "f8", (2, 3)), ("absolute", "u4"), ("zero", "u4")])
ANSWER = np.dtype([("metres", "f8"), ("blocked", "f8", 3), ("distance", "f8"), ("state", "u4"), ("end", "u4")])


def ends_of(a, b, absolute) -> np.ndarray:
    """Lines of sight as cw_sight has them."""
    pair = []
    for value, name in ((a, "a"), (b, "b")):
        ends = numbers(value, name).astype(np.float64)
        if ends.ndim == 0 or ends.shape[-1] not in (2, 3):
            raise ValueError(f"{name}: shape {ends.shape}, expected (..., 3) with x, y and height, or (..., 2)")
        pair.append(np.concatenate([ends, np.zeros(ends.shape[:-1] + (3 - ends.shape[-1],))], -1))
    lines = np.zeros(common_shape({"a": np.shape(a), "b": np.shape(b)}, [ends.shape[:-1] for ends in pair]), SIGHT)
    lines["ends"][..., 0, :], lines["ends"][..., 1, :] = pair
    above = (absolute, absolute) if isinstance(absolute, (bool, np.bool_)) else tuple(absolute) if np.ndim(absolute) == 1 else ()
    if len(above) != 2:
        raise TypeError(f"absolute: {absolute!r}, expected True, False or a pair of them")
    lines["absolute"] = bool(above[0]) + 2 * bool(above[1])
    return lines
