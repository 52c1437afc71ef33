# SPDX-License-Identifier: Apache-2.0
"""How a product's arguments, checked, become a plan: numbers by name for the extension, and how the result looks. Field makes a plan's
product of all rows, cellwalk.dask of a chunk's."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np

from . import _cellwalk  # type: ignore[attr-defined]
from ._convert import Source, count, dress, finite, numbers, pool_of, progress_call

SPOTS_MOST = 65534  # which uint16 counts
_DEGREES = 180 / 3.141592653589793


class Plan(NamedTuple):
    make: str  # the extension's name
    numbers: dict[str, float]
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
    _ground: _cellwalk.Field
    _source: Source
    _samples: np.ndarray
    _threads: int
    shape: tuple[int, int]

    def _call(self, name: str, numbers: dict[str, float], inputs: tuple, outputs: tuple, progress=None, *, threads: int | None = None,
              window: tuple[int, int, int, int] = (0, 0, 0, 0), core: _cellwalk.Field | None = None, kernel: str | None = None, text: str | None = None) -> None:
        """One call of the extension: of the ground, or of the field's core, whose map need not have a way back."""
        pool = pool_of(self._threads if threads is None else threads)
        (self._ground if core is None else core).make(name, numbers, window, inputs, outputs, pool, progress_call(progress), kernel,
                                                           text)

    def _rows(self, plan: Plan, window: tuple[int, int, int, int] | None = None, progress=None) -> np.ndarray:
        """The plan's product of all samples, or of a window's."""
        window = (0, 0, *self.shape) if window is None else window
        out = np.zeros(plan.shape(*window[2:]), plan.dtype)
        self._call(plan.make, plan.numbers, plan.inputs, (out,), progress, window=window)
        return out

    def _dress(self, plan: Plan, data: np.ndarray) -> Any:
        """Data as a DataArray if the field was made of one."""
        like, every = self._source.like, int(plan.numbers.get("every", 1))
        return data if like is None else dress(like[::every, ::every], data, plan.name, plan.attrs, plan.lead)

    def _product(self, plan: Plan, progress=None) -> Any:
        return self._dress(plan, self._rows(plan, None, progress))

    def _locate(self, what: str, place: Optional[tuple[float, float]] = None) -> tuple[float, float, float]:
        """Longitude and latitude of a place, by default the middle; how far the map's north is turned there from the true one, toward
        the west."""
        m, known, (rows, columns) = self._source.map, self._source.crs, self.shape
        i, j = 0.5 * (columns - 1), 0.5 * (rows - 1)
        x, y = (float(m[k][0] * i + m[k][1] * j + m[k][3]) for k in range(2)) if place is None else place
        if known.geographic:
            unit = known.unit or 3.141592653589793 / 180
            return x * unit * _DEGREES, y * unit * _DEGREES, 0.0
        if known.wkt is None:
            raise ValueError(f"{what}: without a coordinate system (crs) nothing says where the sun stands; give "
                             f"{'azimuth and altitude' if what == 'time' else 'lon_lat'}")
        out = np.empty(3)
        NOWHERE.make("crs", {"x": x, "y": y}, (0, 0, 0, 0), (), (out,), None, None, None, known.wkt)
        longitude, latitude, turned = out.tolist()
        return longitude, latitude, turned

    def _bend(self, curvature) -> float:
        """The curvature of lines of sight."""
        return (6.0 / 7 if self._source.placed else 0.0) if curvature is None else finite(curvature, "curvature", 0)


# For what no field is asked.
NOWHERE = _cellwalk.Field(None, 2, 2, np.eye(3, 4), False, False, 0.0, 0.0, 0.0, None, None)


def distance_of(max_distance) -> float:
    """Metres; 0: no limit."""
    if max_distance is None:
        return 0.0
    distance = finite(max_distance, "max_distance", 0)
    if distance == 0:
        raise ValueError("max_distance: 0, expected metres above 0")
    return distance


def round_of(directions, max_distance, curvature, start=0.0) -> dict[str, float]:
    return {"start": finite(start, "start"), "directions": count(directions, "directions", 1, 3600),
            "max_distance": distance_of(max_distance), "curvature": finite(curvature, "curvature", 0)}


def spots_of(x, y, height, elevation, default: float = 2.0, weights=None, of: str = "observer_") -> np.ndarray:
    """Places, shape (n, 5): x, y, height above ground or, if the fourth number is 1, the height itself, weight. of: what the arguments'
    names begin with."""
    absolute = elevation is not None
    if absolute and height is not None:
        raise ValueError(f"{of}height: goes without {of}elevation")
    name = f"{of}elevation" if absolute else f"{of}height"
    height = elevation if absolute else default if height is None else height
    given = [numbers(value, what).astype(np.float64) for value, what in
             ((x, "x"), (y, "y"), (height, name), (1.0 if weights is None else weights, "weights"))]
    try:
        columns = np.broadcast_arrays(*given)
    except ValueError:
        raise ValueError(f"shapes do not broadcast: x {given[0].shape}, y {given[1].shape}, {name} {given[2].shape}, weights "
                         f"{given[3].shape}") from None
    spots = np.stack([*columns[:3], np.full(columns[0].shape, float(absolute)), columns[3]], -1).reshape(-1, 5)
    if not np.isfinite(spots).all():
        raise ValueError(f"x, y, {name}: {spots[~np.isfinite(spots).all(1)][0, :3].tolist()} is not finite")
    if not 1 <= len(spots) <= SPOTS_MOST:
        raise ValueError(f"x, y: {len(spots)} places, expected 1 to {SPOTS_MOST}")
    return np.ascontiguousarray(spots)
