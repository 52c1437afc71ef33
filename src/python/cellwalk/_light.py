# SPDX-License-Identifier: Apache-2.0
"""Products of the sun and the sky. The computing is that of the program's subcommands, bit for bit."""

from __future__ import annotations

import datetime
import re
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np

from ._convert import count, finite, numbers
from ._core import c_text, ffi, lib, owner, warn
from ._plans import Plan, Products, azimuths_of, distance_of, find_eye, round_of, spots_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    Time = Union[str, datetime.datetime, np.datetime64]
    Day = Union[str, datetime.date, np.datetime64]

_SUN_RADIUS = 0.2666  # degrees, as src/terrain/sun/sun.h has it


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
    seconds = seconds_of(time)
    place = finite(longitude, "longitude"), finite(latitude, "latitude", -90, 90)
    return Sun(*suns_at(seconds, *place)[0, :4].tolist())


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


def seconds_of(time: Time) -> float:
    if isinstance(time, str):
        seconds = ffi.new("double *")
        if not lib.cw_sun_parse_time(c_text(time), seconds):
            raise ValueError(f"time: {time!r}, expected a time with its zone, as 2024-06-21T12:00:00Z or +02:00")
        return seconds[0]
    if isinstance(time, np.datetime64):
        if not 0 <= int(time.astype("M8[Y]").astype(int)) + 1970 <= 9999:  # as in text; NaT is far off
            raise ValueError(f"time: {time!r}, expected one of the years 0 to 9999")
        return float((time - np.datetime64(0, "s")) / np.timedelta64(1, "s"))
    if isinstance(time, datetime.datetime):
        if time.tzinfo is None:
            raise ValueError(f"time: {time!r} has no time zone; use datetime.timezone.utc")
        return time.timestamp()
    raise TypeError(f"time: {time!r}, expected a string, datetime or datetime64 (UTC)")


def suns_at(seconds, longitude: float, latitude: float, turned: float = 0.0) -> np.ndarray:
    """Azimuth, altitude, refraction, radius and distance at each of the times."""
    times = np.atleast_1d(np.asarray(seconds, np.float64))
    out = np.empty((times.size, 5))
    lib.suns_at(ffi.new("sun_place *", (longitude, latitude, turned)), ffi.from_buffer("double[]", times), times.size,
                ffi.from_buffer("sun_position[]", out))
    return out


def _days(day: Day, name: str) -> tuple[float, float]:
    """Seconds to the beginning of a day, month or year of UTC, and to its end."""
    text = day.isoformat() if isinstance(day, datetime.date) else str(day) if isinstance(day, (str, np.datetime64)) else ""
    try:
        if not re.fullmatch(r"\d{4}(-\d\d){0,2}", text):
            raise ValueError
        begin = np.datetime64(text)
    except ValueError:
        raise ValueError(f"{name}: {day!r}, expected a day, as 2024-06-21, a month or a year") from None
    begin, end = (float(d.astype("datetime64[s]").astype(np.int64)) for d in (begin, begin + 1))
    return begin, end


def _step(step: str | float | datetime.timedelta) -> float:
    """Seconds that divide a day."""
    found = re.fullmatch(r"([\d.]+)(s|min|h)", step) if isinstance(step, str) else None
    try:
        seconds = (step.total_seconds() if isinstance(step, datetime.timedelta) else
                   float(found[1]) * {"s": 1, "min": 60, "h": 3600}[found[2]] if found else float(step))
    except (TypeError, ValueError):
        seconds = 0.0
    if not (1 <= seconds <= 86400 and abs(round(86400 / seconds) * seconds - 86400) < 1e-6):
        raise ValueError(f"step: {step!r}, expected a time that divides a day, as 15min, 1h or 30s")
    return seconds


def _span(date, to) -> tuple[float, int]:
    """The beginning of the first day, in seconds, and how many days there are. "2024-01" and "2024" are all of their days."""
    first, until = _days(date, "date")
    until = until if to is None else _days(to, "to")[1]
    if until <= first:
        raise ValueError(f"to: {to!r} is before date={date!r}")
    return first, round((until - first) / 86400)


def suns_of(suns, date, to) -> tuple[np.ndarray, np.ndarray]:
    """Places of the sun as the extension takes them, and their weights."""
    if date is not None or to is not None:
        raise ValueError("suns: goes without date and to")
    given = numbers(suns, "suns").astype(np.float64)
    if given.ndim != 2 or given.shape[1] not in (2, 3) or not len(given) or not np.isfinite(given).all() or (abs(given[:, 1]) > 90).any():
        raise ValueError(f"suns: shape {given.shape}, expected (n, 3) or (n, 2): finite azimuths, altitudes from -90 to 90, weights")
    places = np.zeros((len(given), 5))
    places[:, :2], places[:, 4] = given[:, :2], 1
    return places, np.ascontiguousarray(given[:, 2]) if given.shape[1] == 3 else np.ones(len(given))


# ---- what is called for a plan ----------------------------------------------------------------------------------------------


_FILL = {"shadow": (lib.cw_shadow, "cw_light *", "uint8_t[]"), "sunlight": (lib.cw_sunlight, "cw_light *", "float[]"),
         "sky_view": (lib.cw_sky_view, "cw_horizon *", "float[]"), "openness": (lib.cw_openness, "cw_horizon *", "float[]")}


def _fill(core, work, area, out, how, which):
    function, struct, kind = _FILL[which]
    work.check(function(core.terrain, work.run, ffi.new(struct, how), area, ffi.from_buffer(kind, out)))


def _horizon(core, work, area, out, sky, metres):
    horizon = ffi.new("cw_horizon *", sky)
    for k, plane in enumerate(out):
        work.part(k, len(out))
        to = ffi.from_buffer("float[]", plane)
        angles, distances = (ffi.NULL, to) if metres else (to, ffi.NULL)
        work.check(lib.cw_horizon_angles(core.terrain, work.run, horizon, k, area, angles, distances))


def _insolation(core, work, area, out, how, suns, weights, energy, sky):
    """Hours or, with energy, a plane of direct light and without weights one of diffuse light."""
    given = {"suns": ffi.from_buffer("sun_position[]", suns), "count": len(suns),
             "weights": ffi.NULL if weights is None else ffi.from_buffer("double[]", weights)}
    found, planes = owner("insolation **", lib.drop_insolation), out.reshape(-1, *out.shape[-2:])
    work.check(lib.cw_insolation_create(core.terrain, ffi.new("insolation_desc *", {**how, **given}), found))
    work.part(0, len(planes))
    direct = lib.cw_insolation_direct if energy else lib.cw_insolation_hours
    work.check(direct(found[0], work.run, area, ffi.from_buffer("float[]", planes[0])))
    if len(planes) > 1:
        work.part(1, 2)
        diffuse = {"count": sky, "curvature": how["curvature"], "flags": lib.CW_HORIZON_TILTED}
        _fill(core, work, area, planes[1], diffuse, "sky_view")
        planes[1] *= np.float32(lib.cw_insolation_diffuse(found[0]))


def _sun_days(core, work, spot, how, lean, curvature, first, suns, weights, out):
    """out: a sun_day for each day, or one of the suns."""
    day, terrain, eye, sight = ffi.new("sun_day_desc *", how), core.with_bounds(work), find_eye(core, spot, "x, y"), ffi.new("sight *")
    if lean:
        lib.cw_sun_day_lean(terrain, eye, day)
    lib.cw_sight_init(sight, terrain, terrain.bounds, eye, curvature)
    listed = (ffi.NULL, ffi.NULL, 0) if suns is None else (ffi.from_buffer("sun_position[]", suns), ffi.from_buffer("double[]", weights), len(suns))
    share = lib.cw_sun_day_sky(sight, day) if suns is None else 0.0
    for k in range(len(out)):
        work.part(k, len(out))
        out[k] = lib.cw_sun_day(sight, day, share, first + 86400.0 * k, *listed)


class Light(Products):
    """Methods of Field."""

    def sun(self, time: Time) -> Sun:
        """Where the sun stands at a time over the middle of the field, its azimuth from the map's north. For the light that falls on
        the ground see insolation."""
        seconds = seconds_of(time)  # a wrong time is reported before a missing map
        return Sun(*suns_at(seconds, *self._locate("time"))[0, :4].tolist())

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
        if time is not None:
            if azimuth is not None or altitude is not None:
                raise ValueError("time: goes without azimuth and altitude")
            azimuth, altitude, _, radius = self.sun(time)
            disc = radius if disc is True else disc
        light = {"azimuth": finite(225 if azimuth is None else azimuth, "azimuth"),
                 "altitude": finite(30 if altitude is None else altitude, "altitude", -90, 90)}
        disc = _SUN_RADIUS if disc is True else finite(disc, "disc", 0, 10)
        how = {**light, "radius": disc, "curvature": finite(curvature, "curvature", 0, 1e9), "hillshade": bool(hillshade)}
        share = disc > 0 or bool(hillshade)
        if light["altitude"] <= 0:
            warn(f"altitude: the sun is at {light['altitude']:.3f} degrees, not above the horizon")
        attrs = {"long_name": "sunlight", **light, **({} if share else {"_FillValue": np.uint8(255)})}
        dtype, which = (np.float32, "sunlight") if share else (np.uint8, "shadow")
        return self._product(Plan("shadow", _fill, how, "shadow", attrs, dtype, inputs=(which,)), progress)

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
        seconds = _step(step)
        linke, sky = finite(linke, "linke", 1, 10), count(sky, "sky", 1, 3600)
        how = {"hours": seconds / 3600, "linke": linke, "directions": 0 if directions is None else count(directions, "directions", 8, 3600),
               "curvature": finite(curvature, "curvature", 0, 1e9)}
        if suns is not None:
            about = {"long_name": f"weights of the suns {'on the ground' if irradiance else 'that are seen'}"}
            inputs = *suns_of(suns, date, to), bool(irradiance), sky
            return self._product(Plan("insolation", _insolation, how, "sunlight", about, inputs=inputs), progress)
        first, days = _span(date, to)
        place = self._locate("date", None, lon_lat)
        steps = round(days * 86400 / seconds)
        if steps > 1100000:
            raise ValueError(f"step: {step!r} makes {steps} steps of the time from {date} to {to or date}, expected at most 1100000")
        # Days begin at midnight of the place's mean solar time; the sun stands in the middle of each step.
        midnight = first - place[0] / 360 * 86400
        inputs = suns_at(midnight + (np.arange(steps) + 0.5) * seconds, *place), None, bool(irradiance), sky
        name, about, lead = (("irradiance", {"long_name": "energy of sunlight on the ground", "units": "Wh m-2"}, ("light", ["direct", "diffuse"]))
                             if irradiance else ("sunlight_hours", {"long_name": "hours of direct sunlight", "units": "h"}, None))
        return self._product(Plan("insolation", _insolation, how, name, about, lead=lead, inputs=inputs), progress)

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
        spots = spots_of(x, y, height, elevation, 0.0, of="")
        if len(spots) != 1:
            raise ValueError(f"x, y: {len(spots)} places, expected one")
        listed, ground = suns is not None, isinstance(tilt, str)
        first, days = (0.0, 1) if listed else _span(date, to)
        place = (0.0, 0.0, 0.0) if listed else self._locate("date", (spots[0, 0], spots[0, 1]), lon_lat)
        if ground and tilt != "ground":
            raise ValueError(f"tilt: {tilt!r}, expected degrees or 'ground'")
        how = {"step": _step(step), "tilt": 0 if ground else finite(tilt, "tilt", 0, 180), "facing": finite(facing, "facing"),
               "linke": finite(linke, "linke", 1, 10), "sky": count(sky, "sky", 1, 3600), "place": place}
        bend, how["max_distance"] = finite(curvature, "curvature", 0, 1e9), distance_of(max_distance)
        places, weights = suns_of(suns, date, to) if listed else (None, None)
        out = np.empty((days, 8))
        self._run("sun_days", _sun_days, spots[0], how, ground, bend, first, places, weights, ffi.from_buffer("sun_day[]", out),
                  progress=progress, threads=1)
        dates = np.datetime64("NaT" if listed else int(first), "s").astype("datetime64[D]") + np.arange(days)
        times = np.where(np.isnan(out[:, :2]), np.datetime64("NaT"), np.nan_to_num(out[:, :2]).round().astype("datetime64[s]"))
        return SunDays(dates, times[:, 0], times[:, 1], *out[:, 2:].T.copy())

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
        sky = round_of(directions, max_distance, curvature, start)
        about = {"long_name": "distance to the horizon", "units": "m"} if distance else {"long_name": "horizon", "units": "degrees"}
        plan = Plan("horizon", _horizon, sky, "horizon", about, lead=("azimuth", azimuths_of(sky)), inputs=(bool(distance),))
        return self._product(plan, progress)

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
        sky = round_of(directions, max_distance, curvature, 0.0, lib.CW_HORIZON_TILTED if tilted else 0)
        return self._product(Plan("sky_view", _fill, sky, "sky_view", {"long_name": "sky-view factor"}, inputs=("sky_view",)), progress)

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
        sky = round_of(directions, max_distance, curvature, start, lib.CW_HORIZON_BELOW if negative else 0)
        if negative and sky["curvature"] != 0:
            raise ValueError("negative: is that of a flat earth, and goes without curvature")
        about = {"long_name": f"{'negative ' if negative else ''}openness", "units": "degrees"}
        return self._product(Plan("openness", _fill, sky, "openness", about, inputs=("openness",)), progress)
