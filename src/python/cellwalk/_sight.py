# SPDX-License-Identifier: Apache-2.0
"""Products of places that see each other. The computing is that of the program's subcommands, bit for bit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._convert import count, finite, numbers, warn
from ._plans import SPOTS_MOST, Plan, Products, distance_of, round_of, spots_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class LineOfSight(NamedTuple):
    """visible: bool; distance: metres from end to end on the map; blocked_at: x, y, z where the line first meets the surface,
    NaN if it does not; blocked_distance: metres from the first place to there. With a frequency, of the place where least of
    the first Fresnel zone's radius is free: clearance, as a share of the radius; clearance_distance and fresnel_radius in
    metres. Else NaN."""
    visible: np.ndarray
    distance: np.ndarray
    blocked_at: np.ndarray
    blocked_distance: np.ndarray
    clearance: np.ndarray
    clearance_distance: np.ndarray
    fresnel_radius: np.ndarray


class Profile(NamedTuple):
    """Along a line, wherever it crosses an edge of a triangle: metres from the first place; x and y on the map; heights of
    the ground (NaN at holes) and of the line, bent as the earth falls away; whether the ground is seen from the first place;
    with a frequency the first Fresnel zone's radius, else NaN."""
    distance: np.ndarray
    x: np.ndarray
    y: np.ndarray
    ground: np.ndarray
    line: np.ndarray
    seen: np.ndarray
    fresnel_radius: np.ndarray


class PlaceHorizon(NamedTuple):
    """The horizon of places, each of shape (..., directions): azimuths from the map's north and from the true one (NaN
    without a coordinate system), angle in degrees, distance in metres; at: (..., directions, 2), x and y of the horizon. NaN
    where no terrain is."""
    azimuth: np.ndarray
    true_azimuth: np.ndarray
    angle: np.ndarray
    distance: np.ndarray
    at: np.ndarray


class Sites(NamedTuple):
    """What each observer sees: how many samples, their area, the distance in metres of the farthest one, and where that is
    (x, y)."""
    samples: np.ndarray
    km2: np.ndarray
    farthest: np.ndarray
    farthest_at: np.ndarray


_VISIBILITY = {"area": {"long_name": "ground in sight", "units": "km2"}, "share": {"long_name": "share of the ground in sight"},
               "longest": {"long_name": "farthest ground in sight", "units": "m"},
               "azimuth": {"long_name": "azimuth of the farthest ground in sight from the map's north", "units": "degrees"}}
KINDS = ("seen", "weights", "angle", "needed", "needed_absolute")
VIEWS = {"seen": ("viewshed", {"long_name": "number of observers that see it"}),
         "weights": ("viewshed", {"long_name": "sum of the weights of the observers that see it"}),
         "angle": ("viewshed_angle", {"long_name": "angle of the target above the eye's horizontal", "units": "degrees"}),
         "needed": ("needed_height", {"long_name": "height above ground needed to be seen", "units": "m"}),
         "needed_absolute": ("needed_height", {"long_name": "height needed to be seen", "units": "m"})}


def views_of(spots: np.ndarray, limits: dict[str, float], kind: str, bands: bool = False) -> Plan:
    """What the spots see. Counts come as uint16, weights as float64, with nothing at holes."""
    if kind not in KINDS[:2] and len(spots) > 1 and not bands:
        raise ValueError(f"{kind}: that of one observer, not of {len(spots)}; bands=True gives one for each")
    if bands and kind == "weights":
        raise ValueError("weights: adds observers up, and bands keeps them apart")
    if kind.startswith("needed") and "has_verticals" in limits:
        raise ValueError("vertical: is about targets of a given height, and needed looks for that height")
    dtype: Any = {"seen": np.uint16, "weights": np.float64}.get(kind, np.float32)
    return Plan("viewshed", {**limits, "kind": KINDS.index(kind), "bands": bands}, *VIEWS[kind], dtype,
                ("observer", list(range(len(spots)))) if bands else None, (spots,))


def _pair(value, name: str, low: float, high: float) -> tuple[float, float]:
    if np.shape(value) != (2,):
        raise ValueError(f"{name}: {value!r}, expected two angles")
    return finite(value[0], name, low, high), finite(value[1], name, low, high)


def ends_of(a, b, absolute) -> tuple[tuple[int, ...], np.ndarray]:
    """Lines as pairs of spots, and their shape."""
    pair = []
    for value, name in ((a, "a"), (b, "b")):
        ends = numbers(value, name).astype(np.float64)
        if ends.ndim == 0 or ends.shape[-1] not in (2, 3):
            raise ValueError(f"{name}: shape {ends.shape}, expected (..., 3) with x, y and height, or (..., 2)")
        pair.append(np.concatenate([ends, np.zeros(ends.shape[:-1] + (5 - ends.shape[-1],))], -1))
    try:
        both = np.broadcast_arrays(*pair)
    except ValueError:
        raise ValueError(f"shapes do not broadcast: a {np.shape(a)}, b {np.shape(b)}") from None
    lines = np.ascontiguousarray(np.stack(both, -2))
    above = (absolute, absolute) if isinstance(absolute, (bool, np.bool_)) else tuple(absolute) if np.ndim(absolute) == 1 else ()
    if len(above) != 2:
        raise TypeError(f"absolute: {absolute!r}, expected True, False or a pair of them")
    lines[..., 3] = above
    return lines.shape[:-2], lines


class Sight(Products):
    """Methods of Field."""

    def _limits(self, target_height, max_distance, min_distance, azimuth, vertical, curvature) -> dict[str, float]:
        """Which targets count, and the earth's curvature."""
        limits = {"target_height": finite(target_height, "target_height"), "max_distance": distance_of(max_distance),
                  "min_distance": finite(min_distance, "min_distance", 0), "curvature": self._bend(curvature)}
        if max_distance is not None and limits["min_distance"] > limits["max_distance"]:
            raise ValueError(f"min_distance: {min_distance} is more than max_distance={max_distance}")
        if azimuth is not None:
            first, until = _pair(azimuth, "azimuth", -360, 360)
            limits.update(has_azimuths=1, azimuth=first, azimuth_until=until)
        if vertical is not None:
            lowest, highest = _pair(vertical, "vertical", -90, 90)
            if lowest > highest:
                raise ValueError(f"vertical: {vertical!r}, expected the lower angle first")
            limits.update(has_verticals=1, lowest=lowest, highest=highest)
        return limits

    def _spots(self, spots: np.ndarray, every: float | None, skip_outside: bool) -> np.ndarray:
        """Observers along a line of which the spots are corners; without those that have no ground to stand on or are under it, if
        they are to be skipped."""
        if every is not None:
            if len(spots) < 2 or not finite(every, "every", 0) > 0:
                raise ValueError(f"every: {every!r}, expected metres above 0, and two corners of a line or more")
            line, number = np.empty((SPOTS_MOST, 5)), np.empty(1)
            self._call("along", {"every": float(every)}, (spots,), (line, number), threads=1)
            if number[0] > len(line):
                raise ValueError(f"every: {every!r} makes {number[0]:.0f} observers, expected at most {len(line)}")
            spots = np.ascontiguousarray(line[:int(number[0])])
        if not skip_outside:
            return spots
        found = np.empty(len(spots), np.uint8)
        self._call("found", {}, (spots,), (found,), threads=1)
        if not found.any():
            raise ValueError(f"x, y: none of {len(spots)} observers has ground to stand on")
        if not found.all():
            lost = np.flatnonzero(found == 0)
            warn(f"x, y: {len(lost)} of {len(spots)} observers have no ground to stand on or are under it and are skipped: "
                 f"{', '.join(map(str, lost[:10]))}{', ...' if len(lost) > 10 else ''}")
        return np.ascontiguousarray(spots[found == 1])

    def viewshed(self, x: ArrayLike, y: ArrayLike, observer_height: ArrayLike | None = None, target_height: float = 0.0,
                 max_distance: float | None = None, needed: bool | str = False, *, observer_elevation: ArrayLike | None = None,
                 curvature: float | None = None, min_distance: float = 0.0, azimuth: tuple[float, float] | None = None,
                 vertical: tuple[float, float] | None = None, angle: bool = False, weights: ArrayLike | None = None, bands: bool = False,
                 every: float | None = None, skip_outside: bool = False, progress=None) -> Any:
        """Which samples are seen from a place, or from how many of several.

        x, y                of the observers on the map; scalars, or arrays that broadcast with the heights
        observer_height     of the eye above ground, metres; default: 2
        observer_elevation  in its place: the eye's height itself, metres; the place may then be outside the terrain
        target_height       something of that height on each sample is looked for, metres
        max_distance        nothing farther away is seen, metres; default: no limit
        min_distance        nothing nearer is seen, though it blocks the view, metres
        azimuth             only directions from the first of two azimuths clockwise to the second, degrees from the map's north
        vertical            only targets between two angles above the eye's horizontal, degrees
        curvature           how much of the earth's curvature counts: 0 flat, 1 without air, 6/7 with usual refraction. Default:
                            6/7 on a map, else 0
        needed              True: the height above ground that is needed to be seen; "absolute": as an absolute height
        angle               True: the angle of the target above the eye's horizontal
        weights             the sum of the weights of the observers that see the sample
        bands               True: a band for each observer in place of counts
        every               x, y are the corners of a line: an observer at its beginning and every so many metres; heights and weights
                            change evenly between corners
        skip_outside        True: observers without ground, or under it, are left out with a warning

        Returns uint8, shape (rows, columns): 1 where seen, else 0, 255 at holes. From several observers: how many see it
        (uint16 with 65535 at holes, from 255 observers on). bands: shape (observers, rows, columns). float32 with NaN for none are
        needed (metres, 0 where the ground is seen), angle (degrees) and weights. A line that touches the surface on the way is
        blocked. Raises ValueError if an observer has no ground to stand on, or is under it.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 8), "float32"); z[:, 3] = 5
            >>> cw.Field(z).viewshed(0, 1)[1]
            array([1, 1, 1, 1, 0, 0, 0, 0], dtype=uint8)
        """
        if needed not in (True, False, "absolute"):
            raise ValueError(f"needed: {needed!r}, expected True, False or 'absolute'")
        if bool(needed) + bool(angle) + (weights is not None) > 1:
            raise ValueError("needed, angle, weights: only one can be had")
        kind = "needed_absolute" if needed == "absolute" else "needed" if needed else "angle" if angle else "seen" if weights is None else "weights"
        spots = self._spots(spots_of(x, y, observer_height, observer_elevation, 2.0, weights), every, skip_outside)
        limits = self._limits(target_height, max_distance, min_distance, azimuth, vertical, curvature)
        plan = views_of(spots, limits, kind, bool(bands))
        data = self._rows(plan, None, progress)
        if kind == "seen":
            small = bands or len(spots) <= 254
            data[..., ~np.isfinite(self._samples)] = 255 if small else 65535
            data = data.astype(np.uint8) if small else data
            plan.attrs["_FillValue"] = data.dtype.type(255 if small else 65535)
        elif kind == "weights":
            data = np.where(np.isfinite(self._samples), data, np.nan).astype(np.float32)
        elif kind == "needed_absolute":
            metres = self._source.map[2, 2] * (1.0 if self._source.crs.geographic else self._source.crs.unit or 1.0)
            data = (data + self._samples.astype(np.float64) * metres).astype(np.float32)
        return self._dress(plan, data)

    def sites(self, x: ArrayLike, y: ArrayLike, observer_height: ArrayLike | None = None, target_height: float = 0.0,
              max_distance: float | None = None, *, observer_elevation: ArrayLike | None = None, curvature: float | None = None,
              min_distance: float = 0.0, azimuth: tuple[float, float] | None = None, vertical: tuple[float, float] | None = None,
              within: Any = None, every: float | None = None, skip_outside: bool = False, progress=None) -> Sites:
        """How much each of several observers sees. Arguments as for viewshed.

        within  only samples count where this array of the field's shape is not 0

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((9, 9), "float32"); z[4, 4] = 5
            >>> cw.Field(z).sites([4, 0], [4, 0]).samples
            array([81, 69])
        """
        spots = self._spots(spots_of(x, y, observer_height, observer_elevation), every, skip_outside)
        limits = self._limits(target_height, max_distance, min_distance, azimuth, vertical, curvature)
        mask: tuple = ()
        if within is not None:
            mask = (np.ascontiguousarray(np.asarray(within) != 0, np.uint8),)
            if mask[0].shape != self.shape:
                raise ValueError(f"within: shape {mask[0].shape}, expected the field's {self.shape}")
        out = np.empty((len(spots), 5))
        self._call("viewshed", limits, (spots, *mask), (np.empty(self.shape, np.uint16), out), progress, window=(0, 0, *self.shape))
        return Sites(out[:, 0].astype(np.int64), out[:, 1], out[:, 2], out[:, 3:])

    def horizon_at(self, x: ArrayLike, y: ArrayLike, height: ArrayLike | None = None, directions: int = 32, max_distance: float | None = None,
                   *, elevation: ArrayLike | None = None, start: float = 0.0, curvature: float = 0.0, progress=None) -> PlaceHorizon:
        """The horizon as places on the terrain see it: angles, and how far away it is.

        x, y        of the places on the map; scalars, or arrays that broadcast with the heights
        height      of the eye above ground, metres; default: 0
        elevation   in its place: the height itself, metres
        directions, max_distance, start, curvature as for horizon

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 8), "float32"); z[:, 5] = 2
            >>> h = cw.Field(z).horizon_at(3, 1, directions=4)
            >>> h.angle[1].round(2), h.distance[1].round(2)
            (45.0, 2.0)
        """
        spots = spots_of(x, y, height, elevation, 0.0, of="")
        numbers = round_of(directions, max_distance, curvature, start)
        out = np.empty((len(spots), directions, 5))
        self._call("place_horizon", numbers, (spots,), (out,), progress)
        turned = np.full((len(spots), 1), np.nan)
        if self._source.crs.geographic or self._source.crs.wkt is not None:
            turned[:, 0] = [self._locate("x, y", (at[0], at[1]))[2] for at in spots.tolist()]
        out = out.reshape(*np.broadcast_shapes(*map(np.shape, (x, y, elevation if height is None else height))), directions, 5)
        true = np.fmod(out[..., 0] - turned.reshape(*out.shape[:-2], 1) + 360, 360)
        return PlaceHorizon(out[..., 0], true, out[..., 1], out[..., 2], out[..., 3:])

    def visibility(self, directions: int = 128, max_distance: float | None = None, *, observer_height: float = 2.0,
                   target_height: float = 0.0, curvature: float | None = None, every: int = 1, result: str = "area",
                   progress=None) -> Any:
        """How much of the ground every sample sees, as float32, NaN at holes.

        directions       how many, evenly spaced from the map's north on, 1 to 3600; along each the parts in sight are exact
        max_distance     what is farther away does not count, metres; default: no limit
        observer_height  of the eyes above the ground, metres
        target_height    of what must be seen above the ground, metres
        curvature        how much of the earth's curvature counts; default: 6/7 with a map, else 0
        every            eyes at every so many columns and rows
        result           "area": square kilometres in sight; "share": that area as a share of all within max_distance and
                         the field; "longest": metres to the farthest place in sight; "azimuth": of that
                         place, in degrees from the map's north

        How exposed a place is, from how much of the ground one sees it, follows by exchanging the two heights.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((9, 9), "float32"); z[:, 5] = 3           # a wall
            >>> cw.Field(z).visibility(result="share")[4, [1, 5]].round(2)
            array([0.63, 1.  ], dtype=float32)
        """
        if result not in _VISIBILITY:
            raise ValueError(f"result: {result!r}, expected one of {', '.join(_VISIBILITY)}")
        look = {"directions": count(directions, "directions", 1, 3600), "max_distance": distance_of(max_distance),
                "observer_height": finite(observer_height, "observer_height", 0), "target_height": finite(target_height, "target_height", 0),
                "curvature": self._bend(curvature), "every": count(every, "every", 1, 1 << 20), "kind": list(_VISIBILITY).index(result)}
        return self._product(Plan("visibility", look, "visibility", _VISIBILITY[result]), progress)

    def _link(self, curvature, frequency) -> dict[str, float]:
        return {"curvature": self._bend(curvature), "frequency": 0.0 if frequency is None else finite(frequency, "frequency", 0.1, 1e6)}

    def line_of_sight(self, a: ArrayLike, b: ArrayLike, *, absolute: bool | tuple[bool, bool] = False, curvature: float | None = None,
                      frequency: float | None = None, progress=None) -> LineOfSight:
        """Whether places see each other, or where the straight line from a to b first meets the surface.

        a, b       (..., 3): x and y on the map, and metres above ground; (..., 2): on the ground. They broadcast.
        absolute   True: the third number is the height itself; or a pair, for a and for b
        curvature  as for viewshed; 0.75 is the 4/3 earth of radio
        frequency  of a radio link in MHz: also the clearance of its first Fresnel zone, of which 0.6 is the usual demand

        Raises ValueError if a place has no ground under it or is under the ground. The ends themselves block nothing.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 9), "float32"); z[:, 4] = 3
            >>> s = cw.Field(z).line_of_sight((0, 1, 1), (8, 1, 1))
            >>> bool(s.visible), s.blocked_at.round(3).tolist()
            (False, [3.333, 1.0, 1.0])
        """
        shape, lines = ends_of(a, b, absolute)
        out = np.full((*shape, 9), np.nan)
        link = self._link(curvature, frequency)
        if out.size:
            self._call("line_of_sight", link, (lines,), (out,), progress)
        return LineOfSight(out[..., 0] == 1, out[..., 1], out[..., 2:5], out[..., 5], out[..., 6], out[..., 7], out[..., 8])

    def profile(self, a: ArrayLike, b: ArrayLike, *, absolute: bool | tuple[bool, bool] = False, curvature: float | None = None,
                frequency: float | None = None) -> Profile:
        """The terrain along the line from a to b, each of shape (3,) or (2,). Arguments as for line_of_sight.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 4), "float32"); z[:, 2] = 3
            >>> p = cw.Field(z).profile((0, 1, 1), (3, 1, 1))
            >>> p.distance.round(3).tolist(), p.ground.tolist()
            ([0.0, 1.0, 2.0, 3.0], [0.0, 0.0, 3.0, 0.0])
        """
        shape, line = ends_of(a, b, absolute)
        if shape:
            raise ValueError(f"a, b: shape {(*shape, 3)}, expected one line")
        link = self._link(curvature, frequency)
        room, found = 4 * sum(self.shape), np.array([np.inf])
        while found[0] > room or np.isinf(found[0]):
            room = max(room, int(found[0]) if np.isfinite(found[0]) else 0)
            out = np.empty((room, 7))
            self._call("profile", link, (line,), (out, found), threads=1)
        out = out[:int(found[0])].T.copy()
        return Profile(*out[:5], out[5] == 1, out[6])
