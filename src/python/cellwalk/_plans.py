# SPDX-License-Identifier: Apache-2.0
"""Products' arguments, checked, as plans: numbers by name for the extension, and how the result looks. Field makes a plan of all rows,
cellwalk.dask of a chunk's."""

from __future__ import annotations

import datetime
import re
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np

from . import _cellwalk
from ._convert import Crs, count, finite, numbers, warn

if TYPE_CHECKING:
    Time = Union[str, datetime.datetime, np.datetime64]
    Day = Union[str, datetime.date, np.datetime64]

SPOTS_MOST = 65534  # which uint16 counts
SUN_RADIUS = 0.2666  # degrees, as src/terrain/sun/sun.h has it
_DEGREES = 180 / 3.141592653589793


class Site(NamedTuple):
    """Where a raster lies."""
    rows: int
    columns: int
    map: Any
    placed: bool
    crs: Crs
    nodata: Optional[float] = None
    scale: bytes = b""  # of the map; empty: it has none


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


# ---- the sun ----------------------------------------------------------------------------------------------------------------


def seconds_of(time: Time) -> float:
    if isinstance(time, str):
        seconds = _cellwalk.parse_time(time)
        if seconds is None:
            raise ValueError(f"time: {time!r}, expected a time with its zone, as 2024-06-21T12:00:00Z or +02:00")
        return seconds
    if isinstance(time, np.datetime64):
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
    if times.size:
        _cellwalk.suns(times, longitude, latitude, turned, out)
    return out


def locate(site: Site, what: str, place: Optional[tuple[float, float]] = None) -> tuple[float, float, float]:
    """Longitude and latitude of a place, by default the middle; how far the map's north is turned there from the true one, toward the
    west."""
    m, known = site.map, site.crs
    i, j = 0.5 * (site.columns - 1), 0.5 * (site.rows - 1)
    x, y = (float(m[k][0] * i + m[k][1] * j + m[k][3]) for k in range(2)) if place is None else place
    if known.geographic:
        unit = known.unit or 3.141592653589793 / 180
        return x * unit * _DEGREES, y * unit * _DEGREES, 0.0
    if known.wkt is None:
        raise ValueError(f"{what}: without a coordinate system (crs) nothing says where the sun stands; give "
                         f"{'azimuth and altitude' if what == 'time' else 'lon_lat'}")
    return _cellwalk.locate(known.wkt, x, y)


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


def _lon_lat(lon_lat) -> tuple[float, float]:
    return finite(lon_lat[0], "lon_lat"), finite(lon_lat[1], "lon_lat", -90, 90)


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


def warn_of_night(altitude: float) -> None:
    if altitude <= 0:
        warn(f"altitude: the sun is at {altitude:.3f} degrees, below the horizon")


def shadow(site: Site, azimuth, altitude, time, hillshade, disc, curvature) -> Plan:
    if time is not None:
        if azimuth is not None or altitude is not None:
            raise ValueError("time: goes without azimuth and altitude")
        seconds = seconds_of(time)  # a wrong time is reported before a missing map
        azimuth, altitude, _, radius, _ = suns_at(seconds, *locate(site, "time"))[0].tolist()
        disc = radius if disc is True else disc
    azimuth = finite(225 if azimuth is None else azimuth, "azimuth")
    altitude = finite(30 if altitude is None else altitude, "altitude", -90, 90)
    disc = SUN_RADIUS if disc is True else finite(disc, "disc", 0, 10)
    curvature, share = finite(curvature, "curvature", 0), disc > 0 or bool(hillshade)
    warn_of_night(altitude)
    light = {"azimuth": azimuth, "altitude": altitude}
    return Plan("shadow", {**light, "disc": disc, "curvature": curvature, "hillshade": bool(hillshade), "share": share}, "shadow",
                {"long_name": "sunlight", **light, **({} if share else {"_FillValue": np.uint8(255)})}, np.float32 if share else np.uint8)


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


def sun_days(site: Site, place: tuple[float, float], date, to, step, tilt, facing, linke, sky, lon_lat, curvature, max_distance,
             listed: bool) -> dict[str, float]:
    first, days = (0, 1) if listed else _span(date, to)
    longitude, latitude, turned = ((0.0, 0.0, 0.0) if listed else locate(site, "date", place) if lon_lat is None else
                                   (*_lon_lat(lon_lat), 0.0))
    ground = isinstance(tilt, str)
    if ground and tilt != "ground":
        raise ValueError(f"tilt: {tilt!r}, expected degrees or 'ground'")
    return {"first": first, "days": days, "step": _step(step), "tilt": 0 if ground else finite(tilt, "tilt", 0, 180), "lean": ground,
            "facing": finite(facing, "facing"), "linke": finite(linke, "linke", 1, 10), "sky": count(sky, "sky", 1, 3600),
            "longitude": longitude, "latitude": latitude, "turned": turned, "curvature": finite(curvature, "curvature", 0),
            "max_distance": distance_of(max_distance)}


def insolation(site: Site, date, to, step, directions, irradiance, linke, sky, lon_lat, curvature, suns) -> Plan:
    seconds = _step(step)
    how = {"hours": seconds / 3600, "linke": finite(linke, "linke", 1, 10), "sky": count(sky, "sky", 1, 3600),
           "directions": 0 if directions is None else count(directions, "directions", 8, 3600),
           "curvature": finite(curvature, "curvature", 0), "energy": bool(irradiance)}
    if suns is not None:
        about = {"long_name": f"weights of the suns {'on the ground' if irradiance else 'that are seen'}"}
        return Plan("insolation", how, "sunlight", about, inputs=suns_of(suns, date, to))
    first, days = _span(date, to)
    place = locate(site, "date") if lon_lat is None else (*_lon_lat(lon_lat), 0.0)
    steps = round(days * 86400 / seconds)
    if steps > 1100000:
        raise ValueError(f"step: {step!r} makes {steps} steps of the time from {date} to {to or date}, expected at most 1100000")
    # Days begin at midnight of the place's mean solar time; the sun stands in the middle of each step.
    midnight = first - place[0] / 360 * 86400
    places = suns_at(midnight + (np.arange(steps) + 0.5) * seconds, *place)
    if irradiance:
        return Plan("insolation", how, "irradiance", {"long_name": "energy of sunlight on the ground", "units": "Wh m-2"},
                    lead=("light", ["direct", "diffuse"]), inputs=(places,))
    return Plan("insolation", how, "sunlight_hours", {"long_name": "hours of direct sunlight", "units": "h"}, inputs=(places,))


def lowest_suns(plan: Plan) -> np.ndarray:
    """The lowest sun of each direction from which the plan's shadows are cast: azimuth, altitude, radius and curvature."""
    suns, n = plan.inputs[0][plan.inputs[0][:, 1] > 0], plan.numbers["directions"]
    azimuths = np.fmod(np.fmod(suns[:, 0], 360) + 360, 360)
    if n:
        azimuths = 360 * (np.rint(azimuths / 360 * n) % n) / n
    azimuths, of = np.unique(azimuths, return_inverse=True)
    lowest = np.full(len(azimuths), 90.0)
    np.minimum.at(lowest, of, suns[:, 1])
    lights = np.stack([azimuths, lowest, 0 * lowest, np.full(len(lowest), plan.numbers["curvature"])], -1)
    return lights if len(lights) else np.array([[0.0, 90, 0, 0]])


# ---- what goes all round ----------------------------------------------------------------------------------------------------


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


def horizon(site: Site, directions, max_distance, start, curvature, distance) -> Plan:
    sky = round_of(directions, max_distance, curvature, start)
    azimuths = np.fmod(sky["start"] + 360 * np.arange(directions) / directions, 360)
    about = {"long_name": "distance to the horizon", "units": "m"} if distance else {"long_name": "horizon", "units": "degrees"}
    return Plan("horizon", {**sky, "metres": bool(distance)}, "horizon", about, lead=("azimuth", azimuths))


def sky_view(site: Site, directions, max_distance, curvature, tilted) -> Plan:
    numbers = {**round_of(directions, max_distance, curvature), "tilted": bool(tilted)}
    return Plan("sky_view", numbers, "sky_view", {"long_name": "sky-view factor"})


def openness(site: Site, directions, max_distance, start, curvature, negative) -> Plan:
    numbers = {**round_of(directions, max_distance, curvature, start), "below": bool(negative)}
    if negative and numbers["curvature"] != 0:
        raise ValueError("negative: is that of a flat earth, and goes without curvature")
    return Plan("openness", numbers, "openness", {"long_name": f"{'negative ' if negative else ''}openness", "units": "degrees"})


# ---- sight ------------------------------------------------------------------------------------------------------------------

_VISIBILITY = {"area": {"long_name": "ground in sight", "units": "km2"}, "share": {"long_name": "share of the ground in sight"},
               "longest": {"long_name": "farthest ground in sight", "units": "m"},
               "azimuth": {"long_name": "azimuth of the farthest ground in sight from the map's north", "units": "degrees"}}


def bend_of(site: Site, curvature) -> float:
    """The curvature of lines of sight."""
    return (6.0 / 7 if site.placed else 0.0) if curvature is None else finite(curvature, "curvature", 0)


def visibility(site: Site, directions, max_distance, observer_height, target_height, curvature, every, result) -> Plan:
    if result not in _VISIBILITY:
        raise ValueError(f"result: {result!r}, expected one of {', '.join(_VISIBILITY)}")
    look = {"directions": count(directions, "directions", 1, 3600), "max_distance": distance_of(max_distance),
            "observer_height": finite(observer_height, "observer_height", 0), "target_height": finite(target_height, "target_height", 0),
            "curvature": bend_of(site, curvature), "every": count(every, "every", 1, 1 << 20), "kind": list(_VISIBILITY).index(result)}
    return Plan("visibility", look, "visibility", _VISIBILITY[result])


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


def _pair(value, name: str, low: float, high: float) -> tuple[float, float]:
    if np.shape(value) != (2,):
        raise ValueError(f"{name}: {value!r}, expected two angles")
    return finite(value[0], name, low, high), finite(value[1], name, low, high)


def limits_of(site: Site, target_height, max_distance, min_distance, azimuth, vertical, curvature) -> dict[str, float]:
    """Which targets count, and the earth's curvature."""
    limits = {"target_height": finite(target_height, "target_height"), "max_distance": distance_of(max_distance),
              "min_distance": finite(min_distance, "min_distance", 0), "curvature": bend_of(site, curvature)}
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


_KINDS = ("seen", "weights", "angle", "needed", "needed_absolute")
VIEWS = {"seen": ("viewshed", {"long_name": "number of observers that see it"}),
         "weights": ("viewshed", {"long_name": "sum of the weights of the observers that see it"}),
         "angle": ("viewshed_angle", {"long_name": "angle of the target above the eye's horizontal", "units": "degrees"}),
         "needed": ("needed_height", {"long_name": "height above ground needed to be seen", "units": "m"}),
         "needed_absolute": ("needed_height", {"long_name": "height needed to be seen", "units": "m"})}


def viewshed(spots: np.ndarray, limits: dict[str, float], kind: str, bands: bool) -> Plan:
    """What the spots see. Counts come as uint16, weights as float64, with nothing at holes."""
    if kind not in _KINDS[:2] and len(spots) > 1 and not bands:
        raise ValueError(f"{kind}: that of one observer, not of {len(spots)}; bands=True gives one for each")
    if bands and kind == "weights":
        raise ValueError("weights: adds observers up, and bands keeps them apart")
    if kind.startswith("needed") and "has_verticals" in limits:
        raise ValueError("vertical: is about targets of a given height, and needed looks for that height")
    dtype = {"seen": np.uint16, "weights": np.float64}.get(kind, np.float32)
    return Plan("viewshed", {**limits, "kind": _KINDS.index(kind), "bands": bands}, *VIEWS[kind], dtype,
                ("observer", list(range(len(spots)))) if bands else None, (spots,))


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


def frequency_of(frequency) -> float:
    return 0.0 if frequency is None else finite(frequency, "frequency", 0.1, 1e6)
