# SPDX-License-Identifier: Apache-2.0
"""What terrain people ask of a field. The computing is that of the program's subcommands, bit for bit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _cellwalk, _plans
from ._convert import Source, dress, finite, pool_of, progress_call, warn

if TYPE_CHECKING:
    import datetime
    from numpy.typing import ArrayLike
    from ._plans import Day, Time


class Sun(NamedTuple):
    """Where the sun stands, in degrees: azimuth from true north over east, altitude with refraction, radius of the disc."""
    azimuth: float
    altitude: float
    refraction: float
    radius: float


def sun(time: Time, longitude: float, latitude: float) -> Sun:
    """Where the sun stands at a time over a place, right to 0.01 degrees from 1950 to 2050.

    time       "2024-06-21T12:00:00Z", a datetime with its zone, or a datetime64 (UTC)
    longitude  east, latitude north, in degrees

        >>> import cellwalk as cw
        >>> s = cw.sun("2024-06-21T12:00:00Z", 0, 51.5)
        >>> round(s.azimuth), round(s.altitude)
        (179, 62)
    """
    seconds = _plans.seconds_of(time)
    place = finite(longitude, "longitude"), finite(latitude, "latitude", -90, 90)
    return Sun(*_plans.suns_at(seconds, *place)[0, :4].tolist())


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


class SunDays(NamedTuple):
    """The sun at one place, a number for each day: when it is first and last seen behind the hills (UTC; NaT: never), hours
    of its light and energy in Wh/m2 of the surface, direct and diffuse; free: without hills."""
    day: np.ndarray
    rise: np.ndarray
    set: np.ndarray
    hours: np.ndarray
    free_hours: np.ndarray
    direct: np.ndarray
    free_direct: np.ndarray
    diffuse: np.ndarray
    free_diffuse: np.ndarray


class Sites(NamedTuple):
    """What each observer sees: how many samples, their area, the distance in metres of the farthest one, and where that is
    (x, y)."""
    samples: np.ndarray
    km2: np.ndarray
    farthest: np.ndarray
    farthest_at: np.ndarray


class Products:
    """Methods of Field, which has these members."""
    _ground: _cellwalk.Field
    _source: Source
    _samples: np.ndarray
    _threads: int
    shape: tuple[int, int]

    @property
    def _site(self) -> _plans.Site:
        return _plans.Site(*self.shape, self._source.map, self._source.placed, self._source.crs)

    def _call(self, name: str, numbers: dict[str, float], inputs: tuple, outputs: tuple, progress=None, *, threads: int | None = None,
              window: _cellwalk._Window = (0, 0, 0, 0), core: _cellwalk.Field | None = None, kernel: str | None = None) -> None:
        """One call of the extension: of the ground, or of the field's core, whose map need not have a way back."""
        pool = pool_of(self._threads if threads is None else threads)
        (self._ground if core is None else core).make(name, numbers, window, inputs, outputs, pool, progress_call(progress), kernel)

    def _rows(self, plan: _plans.Plan, window: _cellwalk._Window | None = None, progress=None) -> np.ndarray:
        """The plan's product of all samples, or of a window's."""
        window = (0, 0, *self.shape) if window is None else window
        out = np.zeros(plan.shape(*window[2:]), plan.dtype)
        self._call(plan.make, plan.numbers, plan.inputs, (out,), progress, window=window)
        return out

    def _dress(self, plan: _plans.Plan, data: np.ndarray) -> Any:
        """Data as a DataArray if the field was made of one."""
        like, every = self._source.like, int(plan.numbers.get("every", 1))
        return data if like is None else dress(like[::every, ::every], data, plan.name, plan.attrs, plan.lead)

    def _product(self, plan: _plans.Plan, progress=None) -> Any:
        return self._dress(plan, self._rows(plan, None, progress))

    def sun(self, time: Time) -> Sun:
        """Where the sun stands at a time over the middle of the field, its azimuth from the map's north. For the light that falls on
        the ground see insolation."""
        seconds = _plans.seconds_of(time)
        return Sun(*_plans.suns_at(seconds, *_plans.locate(self._site, "time"))[0, :4].tolist())

    def shadow(self, azimuth: float | None = None, altitude: float | None = None, *, time: Time | None = None, hillshade: bool = False,
               disc: float | bool = 0, curvature: float = 0.0, progress=None) -> Any:
        """Sun and shadow on every sample.

        azimuth    of the sun in degrees from the map's north over east; default 225. Without a map, the first row is in the north
        altitude   of the sun above the horizon in degrees; default 30
        time       in place of both: the sun at that time over the field's middle, as for cellwalk.sun
        hillshade  True: light on the ground, the cosine between the sun and the normal, 0 in the shadow
        disc       radius of the sun in degrees, for soft shadows; True: that of the sun. 0: a point
        curvature  how much of the earth's curvature counts: 0 flat (default), 1 without air, 6/7 with usual refraction

        Returns uint8, shape (rows, columns): 1 where the sun is seen, 0 in the shadow, 255 at holes. With hillshade or disc
        float32: the share of the light, NaN at holes. A ray that touches the surface is in the shadow.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((1, 8), "float32").repeat(3, 0); z[:, 2] = 2       # a wall along y
            >>> cw.Field(z).shadow(azimuth=270, altitude=45)[0]
            array([1, 1, 1, 0, 0, 1, 1, 1], dtype=uint8)
        """
        return self._product(_plans.shadow(self._site, azimuth, altitude, time, hillshade, disc, curvature), progress)

    def insolation(self, date: Day | None = None, to: Day | None = None, *, suns: ArrayLike | None = None, step: str | float | datetime.timedelta = "15min", directions: int | None = None,
                   irradiance: bool = False, linke: float = 3.0, sky: int = 32, lon_lat: tuple[float, float] | None = None,
                   curvature: float = 0.0, progress=None) -> Any:
        """Hours of direct sunlight on every sample over a day or several, or the light's energy.

        date, to    the first and the last day, as "2024-06-21", a date or a datetime64; "2024-06" and "2024": all their days
        suns        in place of days: azimuth from the map's north, altitude and, if there, weight of each place of the sun, shape
                    (n, 3) or (n, 2). The result is the sum of the weights of those that are seen; with irradiance that of their
                    light on the ground as it leans, where a weight is the energy on a surface that faces the sun
        step        between two places of the sun: "30s", "15min", "1h", seconds or a timedelta; it divides a day
        directions  cast shadows from the nearest of so many directions all round, 8 to 3600, so that many days share their
                    horizons; azimuths are then off by up to 180 / directions degrees. Default: each sun's own
        irradiance  True: energy instead, under a cloudless sky, on the ground as it leans
        linke       with irradiance: Linke's turbidity for an air mass of 2, 1 to 10
        sky         with irradiance: directions of the sky-view factor for diffuse light
        lon_lat     longitude and latitude of the land, in degrees, for a field without a coordinate system; the map's north is
                    then the true one
        curvature   how much of the earth's curvature counts: 0 flat (default), 1 without air, 6/7 with usual refraction

        Returns float32: hours, shape (rows, columns), or Wh/m2, shape (2, rows, columns), direct and diffuse; NaN at holes. Days
        begin at midnight of the land's mean solar time, and the sun stands in the middle of each step. The model of energy
        is that of the European Solar Radiation Atlas (Rigollier, Bauer and Wald 2000).

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 9), "float32"); z[:, 6] = 5                     # a wall in the east
            >>> cw.Field(z).insolation("2024-03-20", lon_lat=(0, 50))[1, [0, 5]]
            array([11.25,  6.5 ], dtype=float32)
        """
        return self._product(_plans.insolation(self._site, date, to, step, directions, irradiance, linke, sky, lon_lat, curvature, suns), progress)

    def sun_days(self, x: float, y: float, date: Day | None = None, to: Day | None = None, height: float | None = None,
                 *, elevation: float | None = None, suns: ArrayLike | None = None, max_distance: float | None = None,
                 step: str | float | datetime.timedelta = "1min", tilt: float | str = 0.0, facing: float = 180.0, linke: float = 3.0,
                 sky: int = 32, lon_lat: tuple[float, float] | None = None, curvature: float = 0.0, progress=None) -> SunDays:
        """The sun at one place day by day, behind the hills and without them: for a window, a garden or a roof.

        x, y        of the place on the map
        date, to    the first and the last day; "2024-01" and "2024" are all days of a month or year
        height      above ground, metres; default: 0; elevation in its place: the height itself
        suns        in place of days, as for insolation: one row without a time, whose hours are sums of weights
        max_distance  terrain farther away does not count, metres; default: no limit
        step        between two places of the sun, to which rise and set are right
        tilt        of the surface on which energy falls, degrees: 0 level (default), 90 upright; "ground": as the ground leans
        facing      where a tilted surface looks to, degrees from the map's north; default: south
        linke, sky, lon_lat, curvature as for insolation

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 9), "float32"); z[:, 6] = 5                     # a wall in the east
            >>> d = cw.Field(z).sun_days(5, 1, "2024-03-20", lon_lat=(0, 50))
            >>> str(d.rise[0]), d.hours.round(2).tolist(), d.free_hours.round(2).tolist()
            ('2024-03-20T11:38:00', [6.57], [12.13])
        """
        spots = _plans.spots_of(x, y, height, elevation, 0.0, of="")
        if len(spots) != 1:
            raise ValueError(f"x, y: {len(spots)} places, expected one")
        numbers = _plans.sun_days(self._site, (spots[0, 0], spots[0, 1]), date, to, step, tilt, facing, linke, sky, lon_lat, curvature,
                                  max_distance, suns is not None)
        out = np.empty((int(numbers["days"]), 8))
        listed = () if suns is None else _plans.suns_of(suns, date, to)
        self._call("sun_days", numbers, (spots, *listed), (out,), progress, threads=1)
        days = np.datetime64(int(numbers["first"]), "s").astype("datetime64[D]") + np.arange(len(out))
        days = np.full(1, np.datetime64("NaT", "D")) if listed else days
        times = np.where(np.isnan(out[:, :2]), np.datetime64("NaT"), np.nan_to_num(out[:, :2]).round().astype("datetime64[s]"))
        return SunDays(days, times[:, 0], times[:, 1], *out[:, 2:].T.copy())

    def horizon(self, directions: int = 32, max_distance: float | None = None, *, start: float = 0.0, curvature: float = 0.0,
                distance: bool = False, progress=None) -> Any:
        """How high the terrain stands against the sky, in directions all round.

        directions    how many, evenly spaced, 1 to 3600; the first is start, in degrees from the map's north over east
        max_distance  terrain farther away does not count, metres; default: no limit
        curvature     how much of the earth's curvature counts: 0 flat (default), 1 without air, 6/7 with usual refraction
        distance      True: how far away the horizon is instead, in metres

        Returns float32, shape (directions, rows, columns): degrees above the level of the sample, negative below it, NaN at
        holes and where there is no terrain in that direction, or none within max_distance. A DataArray has the dimension
        `azimuth`.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 8), "float32"); z[:, 5] = 2
            >>> cw.Field(z).horizon(directions=4)[1, 1, 3:5].round(2)      # toward x
            array([45.  , 63.43], dtype=float32)
        """
        return self._product(_plans.horizon(self._site, directions, max_distance, start, curvature, distance), progress)

    def sky_view(self, directions: int = 32, max_distance: float | None = None, *, curvature: float = 0.0,
                 tilted: bool = False, progress=None) -> Any:
        """The share of an evenly bright sky's light that reaches level ground: float32, 0 to 1, NaN at holes.

        It is the mean over the directions of the cosine squared of the horizon's angle above the level. Arguments as for
        horizon; with max_distance, the sky is free where no terrain is within it.

        tilted   True: for the ground as it leans, which is also hidden behind itself

            >>> import numpy as np, cellwalk as cw
            >>> cw.Field(np.zeros((3, 3), "float32")).sky_view()[1, 1]
            1.0
        """
        return self._product(_plans.sky_view(self._site, directions, max_distance, curvature, tilted), progress)

    def openness(self, directions: int = 32, max_distance: float | None = None, *, start: float = 0.0, curvature: float = 0.0,
                 negative: bool = False, progress=None) -> Any:
        """Openness (Yokoyama, Shirasawa and Pike 2002): the mean over the directions in which there is terrain of the angle between
        the zenith and the horizon, in degrees: 90 on a plane, more on ridges. float32, NaN at holes. Arguments as for horizon.

        negative  True: between the nadir and the lowest point in each direction instead, more in valleys; without curvature

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((5, 5), "float32"); z[2, 2] = 2                   # a peak
            >>> f = cw.Field(z)
            >>> f.openness(4)[2, 2].round(2), f.openness(4, negative=True)[2, 2].round(2)
            (135.0, 26.57)
        """
        return self._product(_plans.openness(self._site, directions, max_distance, start, curvature, negative), progress)

    def _spots(self, spots: np.ndarray, every: float | None, skip_outside: bool) -> np.ndarray:
        """Observers along a line of which the spots are corners; without those that have no ground to stand on or are under it, if
        they are to be skipped."""
        if every is not None:
            if len(spots) < 2 or not finite(every, "every", 0) > 0:
                raise ValueError(f"every: {every!r}, expected metres above 0, and two corners of a line or more")
            line, number = np.empty((_plans.SPOTS_MOST, 5)), np.empty(1)
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
        spots = self._spots(_plans.spots_of(x, y, observer_height, observer_elevation, 2.0, weights), every, skip_outside)
        limits = _plans.limits_of(self._site, target_height, max_distance, min_distance, azimuth, vertical, curvature)
        plan = _plans.viewshed(spots, limits, kind, bool(bands))
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
        spots = self._spots(_plans.spots_of(x, y, observer_height, observer_elevation), every, skip_outside)
        limits = _plans.limits_of(self._site, target_height, max_distance, min_distance, azimuth, vertical, curvature)
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
        spots = _plans.spots_of(x, y, height, elevation, 0.0, of="")
        numbers = _plans.round_of(directions, max_distance, curvature, start)
        out = np.empty((len(spots), directions, 5))
        self._call("place_horizon", numbers, (spots,), (out,), progress)
        turned = np.full((len(spots), 1), np.nan)
        if self._source.crs.geographic or self._source.crs.wkt is not None:
            turned[:, 0] = [_plans.locate(self._site, "x, y", (at[0], at[1]))[2] for at in spots.tolist()]
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
        return self._product(_plans.visibility(self._site, directions, max_distance, observer_height, target_height, curvature, every, result),
                          progress)

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
        shape, lines = _plans.ends_of(a, b, absolute)
        out = np.full((*shape, 9), np.nan)
        numbers = {"curvature": _plans.bend_of(self._site, curvature), "frequency": _plans.frequency_of(frequency)}
        if out.size:
            self._call("line_of_sight", numbers, (lines,), (out,), progress)
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
        shape, line = _plans.ends_of(a, b, absolute)
        if shape:
            raise ValueError(f"a, b: shape {(*shape, 3)}, expected one line")
        numbers = {"curvature": _plans.bend_of(self._site, curvature), "frequency": _plans.frequency_of(frequency)}
        room, found = 4 * sum(self.shape), np.array([np.inf])
        while found[0] > room or np.isinf(found[0]):
            room = max(room, int(found[0]) if np.isfinite(found[0]) else 0)
            out = np.empty((room, 7))
            self._call("profile", numbers, (line,), (out, found), threads=1)
        out = out[:int(found[0])].T.copy()
        return Profile(*out[:5], out[5] == 1, out[6])
