# SPDX-License-Identifier: Apache-2.0
"""Products of places that see each other. The computing is that of the program's subcommands, bit for bit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._convert import array_of, count, finite
from ._core import ffi, lib, warn
from ._plans import ANSWER, Plan, Products, along, azimuths_of, distance_of, ends_of, find_eye, round_of, spots_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class LineOfSight(NamedTuple):
    """visible: bool; distance: metres from end to end on the map; blocked_at: x, y, z where the line first meets the surface,
    NaN if it does not; blocked_distance: metres from the first place to there. With a frequency, of the place where least of
    the first Fresnel zone's radius is free: clearance, as a share of the radius; clearance_distance and fresnel_radius in
    metres. Else NaN. Holes hide nothing."""
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
    """What each observer sees: how many samples, their area, the distance in metres of the farthest one, and where that is (x, y)."""
    samples: np.ndarray
    km2: np.ndarray
    farthest: np.ndarray
    farthest_at: np.ndarray


_VISIBILITY = {"area": {"long_name": "ground in sight", "units": "km2"}, "share": {"long_name": "share of the ground in sight"},
               "longest": {"long_name": "farthest ground in sight", "units": "m"},
               "azimuth": {"long_name": "azimuth of the farthest ground in sight from the map's north", "units": "degrees"}}
VIEWS = {"seen": ("viewshed", {"long_name": "number of observers that see it"}),
         "weights": ("viewshed", {"long_name": "sum of the weights of the observers that see it"}),
         "angle": ("viewshed_angle", {"long_name": "angle of the target above the eye's horizontal", "units": "degrees"}),
         "needed": ("needed_height", {"long_name": "height above ground needed to be seen", "units": "m"}),
         "needed_absolute": ("needed_height", {"long_name": "height needed to be seen", "units": "m"})}


def views_of(spots: np.ndarray, limits: dict[str, float], kind: str, bands: bool = False) -> Plan:
    """What the spots see. Counts come as uint16, weights as float64."""
    if kind not in ("seen", "weights") and len(spots) > 1 and not bands:
        raise ValueError(f"{kind}: that of one observer, not of {len(spots)}; bands=True gives one for each")
    if bands and kind == "weights":
        raise ValueError("weights: adds observers up, and bands keeps them apart")
    wrong = "target_height" if limits["target"] else "vertical" if limits["limits"] & lib.CW_OBSERVER_VERTICALS else None
    if kind.startswith("needed") and wrong:
        raise ValueError(f"{wrong}: is about targets of a given height, and needed looks for that height")
    dtype: Any = {"seen": np.uint16, "weights": np.float64}.get(kind, np.float32)
    return Plan("viewshed", _viewshed, limits, *VIEWS[kind], dtype, ("observer", list(range(len(spots)))) if bands else None, (spots, kind))


# ---- what is called -------------------------------------------------------------------------------------------------------


def _look(core, work, terrain, spot, limits, area, **to):
    """What one observer sees; to: members of cw_view. Returns where the eye is."""
    eye = find_eye(core, spot, "x, y")
    # The eye's height is that of the place that was found, bit for bit.
    where = {"x": spot[0], "y": core.north(spot[1]), "height": eye[2] * terrain.map[2][2], "absolute": 1}
    work.check(lib.cw_viewshed(terrain, work.run, ffi.new("cw_observer *", {**limits, **where}), area, ffi.new("cw_view *", to)))
    return eye


def _viewshed(core, work, area, out, limits, spots, kind):
    """Of each sample how many observers see it (65535 at holes), the sum of their weights, or a float; or a plane of them for each
    observer."""
    terrain = core.with_bounds(work)
    for k, spot in enumerate(spots):
        work.part(k, len(spots))
        to = out[k] if out.ndim == 3 else out
        if kind == "seen":
            view = {"seen": ffi.from_buffer("uint16_t[]", to)}
        elif kind == "weights":  # one of 0 adds nothing
            view = {"sum": ffi.from_buffer("double[]", to), "weight": spot[4]} if spot[4] else {}
        else:
            view = {"angle" if kind == "angle" else "needed": ffi.from_buffer("float[]", to)}
        _look(core, work, terrain, spot, limits, area, **view)
    heights = core.source.samples[area.at.j:area.at.j + area.at.ny, area.at.i:area.at.i + area.at.nx]
    if kind in ("seen", "weights"):
        out[..., ~np.isfinite(heights)] = 65535 if kind == "seen" else np.nan
    elif kind == "needed_absolute":
        out += heights.astype(np.float64) * terrain.map[2][2]


def _sites(core, work, area, limits, spots, within):
    """Of each observer: samples, square kilometres, the farthest one's distance and place."""
    terrain, seen, table = core.with_bounds(work), np.empty(core.shape, np.uint16), np.empty((len(spots), 5))
    counts = ffi.from_buffer("uint16_t[]", seen)
    mask = ffi.NULL if within is None else ffi.from_buffer("uint8_t[]", within)
    for k, spot in enumerate(spots):
        work.part(k, len(spots))
        seen[:] = 0
        eye = _look(core, work, terrain, spot, limits, area, seen=counts)
        v = lib.view_sum_of(terrain, area.at, counts, mask, eye)
        table[k] = v.samples, v.km2, v.farthest, v.farthest_at[0], core.north(v.farthest_at[1])
    return table


def _horizons(core, work, spots, sky):
    terrain, out, sight, azimuths = core.with_bounds(work), np.empty((len(spots), sky["count"], 5)), ffi.new("sight *"), azimuths_of(sky)
    for k, (spot, to) in enumerate(zip(spots, out)):
        work.part(k, len(spots))
        eye = find_eye(core, spot, "x, y")
        if np.isnan(lib.cw_terrain_height(terrain, eye[0], eye[1])):
            raise ValueError(f"x, y: ({spot[0]:.10g}, {spot[1]:.10g}) is not on the terrain, where the horizon is found")
        lib.cw_sight_init(sight, terrain, terrain.bounds, eye, sky["curvature"])
        ffi.from_buffer("place_horizon[]", to)[0:len(to)] = [lib.cw_place_horizon(sight, a, sky["max_distance"]) for a in azimuths]
    out[..., 4] = core.north(out[..., 4])
    return out


def _northward(core, lines):
    """The lines as they are on the terrain."""
    lines = lines.copy()
    lines["ends"][..., 1] = core.north(lines["ends"][..., 1])
    return lines


def _check_ends(core, line) -> None:
    for end in range(2):
        find_eye(core, (*line["ends"][end].tolist(), line["absolute"] >> end & 1, 0), "ab"[end])


def _lines(core, work, lines, curvature, frequency):
    """Answers, and of each line a clearance."""
    placed, answers = _northward(core, lines), np.empty(lines.shape, ANSWER)
    clearances = np.full((*lines.shape, 3), np.nan)
    given = ffi.from_buffer("cw_sight[]", placed), lines.size
    work.part(0, 2 if frequency else 1)
    work.check(lib.cw_lines_of_sight(core.terrain, work.run, curvature, *given, ffi.from_buffer("cw_sight_answer[]", answers)))
    for wrong in np.flatnonzero(answers["state"] >= lib.CW_SIGHT_NO_GROUND)[:1]:
        _check_ends(core, lines.reshape(-1)[wrong])
    if frequency:
        work.part(1, 2)
        if not lib.lines_clearance(core.terrain, work.c, curvature, frequency, *given, ffi.from_buffer("clearance[]", clearances)):
            raise MemoryError("line_of_sight: out of memory")
    answers["blocked"][..., 1] = core.north(answers["blocked"][..., 1])
    return answers, clearances


def _profile(core, work, line, curvature, frequency):
    _check_ends(core, line)
    (a, b), absolute = _northward(core, line)["ends"].tolist(), int(line["absolute"])
    ends = ffi.new("io_place[2]", [{"x": p[0], "y": p[1], "z": p[2], "absolute": bool(absolute >> k & 1)} for k, p in enumerate((a, b))])
    found, points = ffi.new("line *"), ffi.gc(ffi.new("profile *"), lib.cw_profile_free)
    lib.line_find(found, core.terrain, ends, curvature, ffi.NULL)
    work.check(lib.cw_profile_make(points, ffi.addressof(found, "sight"), *found.target))
    rows = np.empty((points.count, 7))
    lib.line_rows(found, frequency, points, ffi.from_buffer("line_row[]", rows))
    rows[:, 2] = core.north(rows[:, 2])
    return rows


def _visibility(core, work, area, out, how, member):
    answers = ffi.new("cw_visibility_answers *", {member: ffi.from_buffer("float[]", out)})
    work.check(lib.cw_visibility(core.terrain, work.run, ffi.new("cw_visibility_desc *", how), area, answers))


class Sight(Products):
    """Methods of Field."""

    def _limits(self, target_height, max_distance, min_distance, azimuth, vertical, curvature) -> dict[str, Any]:
        """Which targets count, and the earth's curvature, as cw_observer has them."""
        limits: dict[str, Any] = {"target": finite(target_height, "target_height", 0), "farthest": distance_of(max_distance),
                                  "nearest": finite(min_distance, "min_distance", 0), "curvature": self._bend(curvature), "limits": 0}
        if max_distance is not None and limits["nearest"] > limits["farthest"]:
            raise ValueError(f"min_distance: {min_distance} is more than max_distance={max_distance}")
        for name, pair, most, flag in (("azimuth", azimuth, 360, lib.CW_OBSERVER_AZIMUTHS), ("vertical", vertical, 90, lib.CW_OBSERVER_VERTICALS)):
            if pair is not None:
                if np.shape(pair) != (2,):
                    raise ValueError(f"{name}: {pair!r}, expected two angles")
                limits[name + "s"] = low, high = [finite(angle, name, -most, most) for angle in pair]
                if name == "vertical" and low > high:
                    raise ValueError(f"vertical: {vertical!r}, expected the lower angle first")
                limits["limits"] |= flag
        return limits

    def _spots(self, spots: np.ndarray, every: float | None, skip_outside: bool) -> np.ndarray:
        """Observers along a line of which the spots are corners; without those that have no ground to stand on or are under it, if
        they are to be skipped."""
        if every is not None:
            if len(spots) < 2 or not finite(every, "every", 0) > 0:
                raise ValueError(f"every: {every!r}, expected metres above 0, and two corners of a line or more")
            spots = self._run("along", along, spots, every, threads=1)
        if not skip_outside:
            return spots
        found = self._run("found", lambda core, work: np.array([find_eye(core, spot, None) is not None for spot in spots]), threads=1)
        if not found.any():
            raise ValueError(f"x, y: none of {len(spots)} observers has ground to stand on")
        if not found.all():
            lost = np.flatnonzero(~found)
            warn(f"x, y: {len(lost)} of {len(spots)} observers have no ground to stand on or are under it and are skipped: "
                 f"{', '.join(map(str, lost[:10]))}{', ...' if len(lost) > 10 else ''}")
        return spots[found]

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
        needed (metres, 0 where nothing rises above the line to the ground), angle (degrees) and weights. A line that touches an edge of
        the surface on the way is blocked; holes hide nothing. Raises ValueError if an observer has no ground to stand on, or is under it.

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
            data = data.astype(np.uint8) if bands or len(spots) <= 254 else data
            plan.attrs["_FillValue"] = data.dtype.type(np.iinfo(data.dtype).max)
        elif kind == "weights":
            data = data.astype(np.float32)
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
        if within is not None:
            within = np.ascontiguousarray(array_of(within, "within") != 0, np.uint8)
            if within.shape != self.shape:
                raise ValueError(f"within: shape {within.shape}, expected the field's {self.shape}")
        area = ffi.new("cw_area *", {"at": (0, 0, *self.shape[::-1])})[0]
        out = self._run("viewshed", _sites, area, limits, spots, within, progress=progress)
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
        out = self._run("place_horizon", _horizons, spots, round_of(directions, max_distance, curvature, start), progress=progress)
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
        if result not in tuple(_VISIBILITY):
            raise ValueError(f"result: {result!r}, expected one of {', '.join(_VISIBILITY)}")
        look = {"directions": count(directions, "directions", 1, 3600), "max_distance": distance_of(max_distance),
                "height": finite(observer_height, "observer_height", 0), "target": finite(target_height, "target_height", 0),
                "curvature": self._bend(curvature), "every": count(every, "every", 1, 1 << 20)}
        member = "farthest" if result == "longest" else result
        return self._product(Plan("visibility", _visibility, look, "visibility", _VISIBILITY[result], inputs=(member,)), progress)

    def _link(self, curvature, frequency) -> tuple[float, float]:
        return self._bend(curvature), 0.0 if frequency is None else finite(frequency, "frequency", 0.1, 1e6)

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
        out, free = self._run("line_of_sight", _lines, ends_of(a, b, absolute), *self._link(curvature, frequency), progress=progress)
        return LineOfSight(out["state"] == lib.CW_SIGHT_SEEN, out["metres"], out["blocked"], out["distance"], free[..., 0], free[..., 1], free[..., 2])

    def profile(self, a: ArrayLike, b: ArrayLike, *, absolute: bool | tuple[bool, bool] = False, curvature: float | None = None,
                frequency: float | None = None) -> Profile:
        """The terrain along the line from a to b, each of shape (3,) or (2,). Arguments as for line_of_sight.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 4), "float32"); z[:, 2] = 3
            >>> p = cw.Field(z).profile((0, 1, 1), (3, 1, 1))
            >>> p.distance.round(3).tolist(), p.ground.tolist()
            ([0.0, 1.0, 2.0, 3.0], [0.0, 0.0, 3.0, 0.0])
        """
        line = ends_of(a, b, absolute)
        if line.shape:
            raise ValueError(f"a, b: shape {(*line.shape, 3)}, expected one line")
        out = self._run("profile", _profile, line, *self._link(curvature, frequency), threads=1).T.copy()
        return Profile(*out[:5], out[5] == 1, out[6])
