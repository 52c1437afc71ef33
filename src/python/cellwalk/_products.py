# SPDX-License-Identifier: Apache-2.0
"""What terrain people ask of a field. The computing is that of the program's subcommands, bit for bit."""

from __future__ import annotations

import datetime
import math
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np

from . import _cellwalk
from ._convert import Source, count, finite, numbers, progress_call, warn

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    Time = Union[str, datetime.datetime, np.datetime64]

SUN_RADIUS = 0.2666  # degrees, as src/terrain/sun.h has it


class Sun(NamedTuple):
    """Where the sun stands, in degrees: azimuth from true north over east, altitude with refraction, radius of the disc."""
    azimuth: float
    altitude: float
    refraction: float
    radius: float


def _seconds(time) -> float:
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


def sun(time: Time, longitude: float, latitude: float) -> Sun:
    """Where the sun stands at a time over a place, right to 0.01 degrees from 1950 to 2050.

    time       "2024-06-21T12:00:00Z", a datetime with its zone, or a datetime64 (UTC)
    longitude  east, latitude north, in degrees

        >>> import cellwalk as cw
        >>> s = cw.sun("2024-06-21T12:00:00Z", 0, 51.5)
        >>> round(s.azimuth), round(s.altitude)
        (179, 62)
    """
    return Sun(*_cellwalk.sun(_seconds(time), finite(longitude, "longitude"), finite(latitude, "latitude", -90, 90)))


# As look_along in src/python/extension/views.c counts them.
_places_wrong = ("has no ground under it; absolute=True takes heights themselves", "is too far away from the terrain", "is under the ground")


class LineOfSight(NamedTuple):
    """visible: bool; distance: metres from end to end on the map; blocked_at: x, y, z where the line first meets the surface,
    NaN if it does not; blocked_distance: metres from the first place to there."""
    visible: np.ndarray
    distance: np.ndarray
    blocked_at: np.ndarray
    blocked_distance: np.ndarray


def _result(field, data, name, attrs, every=1, **axis):
    """Data as a DataArray if the field was made of one; of every so many rows and columns."""
    like = field._source.like
    if like is None:
        return data
    if every > 1:
        like = like[::every, ::every]
    keep = {key: like.attrs[key] for key in ("grid_mapping", "crs") if key in like.attrs}
    for key, values in axis.items():
        like = like.expand_dims({key: values})
    out = like.copy(deep=False, data=data)
    out.name, out.attrs, out.encoding = name, {**attrs, **keep}, {}
    return out


def warn_of_night(altitude: float) -> None:
    if altitude <= 0:
        warn(f"altitude: the sun is at {altitude:.3f} degrees, below the horizon")


def distance_of(max_distance) -> float:
    """Metres; 0: no limit."""
    if max_distance is None:
        return 0.0
    distance = finite(max_distance, "max_distance", 0)
    if distance == 0:
        raise ValueError("max_distance: 0, expected metres above 0")
    return distance


def sky_of(directions, max_distance, curvature, start) -> tuple[float, int, float, float]:
    """Arguments of a horizon, checked, in the order of the extension."""
    return start, count(directions, "directions", 1, 3600), distance_of(max_distance), finite(curvature, "curvature", 0)


VISIBILITY = {"a": {"long_name": "ground in sight", "units": "km2"}, "s": {"long_name": "share of the ground in sight"},
              "l": {"long_name": "farthest ground in sight", "units": "m"},
              "z": {"long_name": "azimuth of the farthest ground in sight", "units": "degrees"}}


def look_of(directions, max_distance, observer_height, target_height, curvature, result) -> tuple[int, float, float, float, float, str]:
    """Arguments of visibility, checked, in the order of the extension but for every."""
    kinds = {"area": "a", "share": "s", "longest": "l", "azimuth": "z"}
    if result not in kinds:
        raise ValueError(f"result: {result!r}, expected one of {', '.join(kinds)}")
    return (count(directions, "directions", 1, 3600), distance_of(max_distance), finite(observer_height, "observer_height", 0),
            finite(target_height, "target_height", 0), curvature, kinds[result])


def places_of(x, y, height, elevation, needed) -> tuple[np.ndarray, bool]:
    """Observers, shape (n, 3): x, y, and the eye's height above ground or, True, the height itself."""
    absolute = elevation is not None
    if absolute and height is not None:
        raise ValueError("observer_height: goes without observer_elevation")
    name = "observer_elevation" if absolute else "observer_height"
    height = elevation if absolute else 2.0 if height is None else height
    given = [numbers(value, what).astype(np.float64) for value, what in ((x, "x"), (y, "y"), (height, name))]
    try:
        places = np.stack(np.broadcast_arrays(*given), -1).reshape(-1, 3)
    except ValueError:
        raise ValueError(f"shapes do not broadcast: x {given[0].shape}, y {given[1].shape}, {name} {given[2].shape}") from None
    if not np.isfinite(places).all():
        raise ValueError(f"x, y, {name}: observer {places[~np.isfinite(places).all(1)][0].tolist()} is not finite")
    if not 1 <= len(places) <= 65534:
        raise ValueError(f"x, y: {len(places)} observers, expected 1 to 65534")
    if needed and len(places) > 1:
        raise ValueError(f"needed: the height that is needed is that of one observer, not of {len(places)}")
    return np.ascontiguousarray(places), absolute


class Products:
    """Methods of Field, which has these members."""
    _ground: _cellwalk.Field
    _source: Source
    _samples: np.ndarray
    _threads: int
    shape: tuple[int, int]

    def _placed(self) -> bool:
        return self._source.placed

    def _curvature(self, curvature) -> float:
        if curvature is None:
            return 6.0 / 7 if self._placed() else 0.0
        return finite(curvature, "curvature", 0)

    def _locate(self):
        """Longitude and latitude of the middle; how far the map's north is turned from the true one, toward the west."""
        rows, columns = self.shape
        m, known = self._source.map, self._source.crs
        i, j = 0.5 * (columns - 1), 0.5 * (rows - 1)
        x, y = (float(m[k, 0] * i + m[k, 1] * j + m[k, 3]) for k in range(2))
        degrees = 180 / 3.141592653589793
        if known.geographic:
            unit = known.unit or 3.141592653589793 / 180
            return x * unit * degrees, y * unit * degrees, 0.0
        if known.wkt is None:
            raise ValueError("time: without a coordinate system (crs) nothing says where the sun stands; give azimuth and altitude")
        longitude, latitude = _cellwalk.lon_lat(known.wkt, False, x, y)
        south = latitude - 1e-4
        (x0, y0), (x1, y1) = (_cellwalk.lon_lat(known.wkt, True, longitude, v) for v in (south, south + 2e-4))
        return longitude, latitude, math.atan2(x1 - x0, y1 - y0) * degrees

    def sun(self, time: Time) -> Sun:
        """Where the sun stands at a time over the middle of the field, its azimuth from the map's north."""
        longitude, latitude, turned = self._locate()
        p = sun(time, longitude, latitude)
        return p._replace(azimuth=math.fmod(p.azimuth + turned + 360, 360))

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
            _seconds(time)  # a wrong time is reported before a missing map
            place = self.sun(time)
            azimuth, altitude = place.azimuth, place.altitude
            if disc is True:
                disc = place.radius
        azimuth = finite(225 if azimuth is None else azimuth, "azimuth")
        altitude = finite(30 if altitude is None else altitude, "altitude", -90, 90)
        disc = SUN_RADIUS if disc is True else finite(disc, "disc", 0, 10)
        warn_of_night(altitude)
        data = self._shadow_rows((azimuth, altitude, disc, finite(curvature, "curvature", 0), bool(hillshade)), 0, self.shape[0], progress)
        attrs = {"long_name": "sunlight", "azimuth": azimuth, "altitude": altitude}
        return _result(self, data, "shadow", attrs if data.dtype.kind == "f" else {**attrs, "_FillValue": np.uint8(255)})

    def _shadow_rows(self, light, row, rows, progress=None):
        """light: azimuth, altitude, disc, curvature, hillshade"""
        share = light[2] > 0 or light[4]
        out = np.empty((rows, self.shape[1]), np.float32 if share else np.uint8)
        self._ground.shadow(*light, row, rows, share, out, self._threads, progress_call(progress))
        return out

    def horizon(self, directions: int = 32, max_distance: float | None = None, *, start: float = 0.0, curvature: float = 0.0,
                grid: bool = False, progress=None) -> Any:
        """How high the terrain stands against the sky, in directions all round.

        directions    how many, evenly spaced, 1 to 3600; the first is start, in degrees from the map's north over east
        max_distance  terrain farther away does not count, metres; default: no limit
        curvature     how much of the earth's curvature counts: 0 flat (default), 1 without air, 6/7 with usual refraction
        grid          True: 8, 16 or 32 directions from sample to sample instead, which are as exact, not evenly spaced, and faster
                      on large fields; without start and max_distance, and not on a map in degrees

        Returns float32, shape (directions, rows, columns): degrees above the level of the sample, negative below it, NaN at
        holes and where there is no terrain in that direction, or none within max_distance. A DataArray has the dimension
        `azimuth`.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 8), "float32"); z[:, 5] = 2
            >>> cw.Field(z).horizon(directions=4)[1, 1, 3:5].round(2)      # toward x
            array([45.  , 63.43], dtype=float32)
        """
        sky = self._sky(directions, max_distance, curvature, grid, finite(start, "start"))
        data, azimuths = self._horizon_rows(sky, 0, self.shape[0], progress)
        return _result(self, data, "horizon", {"long_name": "horizon", "units": "degrees"}, azimuth=azimuths)

    def _horizon_rows(self, sky, row, rows, progress=None):
        """sky: start, directions, max_distance, curvature, grid"""
        out, azimuths = np.empty((sky[1], rows, self.shape[1]), np.float32), np.empty(sky[1])
        self._ground.horizon(*sky, row, rows, out, azimuths, self._threads, progress_call(progress))
        return out, azimuths

    def _sky(self, directions, max_distance, curvature, grid, start=0.0):
        sky = sky_of(directions, max_distance, curvature, start)
        if grid and sky[1] not in (8, 16, 32):
            raise ValueError(f"directions: {sky[1]}, expected 8, 16 or 32 with grid")
        if grid and (start != 0 or max_distance is not None):
            raise ValueError("grid: goes without start and max_distance")
        if grid and self._source.crs.geographic:
            raise ValueError("grid: needs a map in metres, and this one is in degrees")
        return (*sky, bool(grid))

    def sky_view(self, directions: int = 32, max_distance: float | None = None, *, curvature: float = 0.0, grid: bool = False,
                 tilted: bool = False, progress=None) -> Any:
        """The share of an evenly bright sky's light that reaches level ground: float32, 0 to 1, NaN at holes.

        It is the mean over the directions of the cosine squared of the horizon's angle above the level. Arguments as for
        horizon; with max_distance, the sky is free where no terrain is within it.

        tilted   True: for the ground as it leans, which is also hidden behind itself; without grid

            >>> import numpy as np, cellwalk as cw
            >>> cw.Field(np.zeros((3, 3), "float32")).sky_view()[1, 1]
            1.0
        """
        if grid and tilted:
            raise ValueError("tilted: goes without grid")
        sky = self._sky(directions, max_distance, curvature, grid)
        data = self._sky_view_rows(sky, bool(tilted), 0, self.shape[0], progress)
        return _result(self, data, "sky_view", {"long_name": "sky-view factor"})

    def _sky_view_rows(self, sky, tilted, row, rows, progress=None):
        out = np.empty((rows, self.shape[1]), np.float32)
        self._ground.sky_view(*sky[1:], tilted, row, rows, out, self._threads, progress_call(progress))
        return out

    def viewshed(self, x: ArrayLike, y: ArrayLike, observer_height: ArrayLike | None = None, target_height: float = 0.0,
                 max_distance: float | None = None, needed: bool = False, *, observer_elevation: ArrayLike | None = None,
                 curvature: float | None = None, progress=None) -> Any:
        """Which samples are seen from a place, or from how many of several.

        x, y                of the observers on the map; scalars, or arrays that broadcast with the heights
        observer_height     of the eye above ground, metres; default: 2
        observer_elevation  in its place: the eye's height itself, metres; the place may then be outside the terrain
        target_height       something of that height on each sample is looked for, metres
        max_distance        nothing farther away is seen, metres; default: no limit
        curvature           how much of the earth's curvature counts: 0 flat, 1 without air, 6/7 with usual refraction. Default:
                            6/7 on a map, else 0
        needed              True: the height above ground that is needed to be seen, from one observer

        Returns uint8, shape (rows, columns): 1 where seen, else 0, 255 at holes. From several observers: how many see it
        (uint16 with 65535 at holes, from 255 observers on). needed: float32 metres, 0 where the ground is seen, NaN at holes
        and farther than max_distance. A line that touches the surface on the way is blocked. Raises ValueError if an observer
        has no ground to stand on, or is under it.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 8), "float32"); z[:, 3] = 5
            >>> cw.Field(z).viewshed(0, 1)[1]
            array([1, 1, 1, 1, 0, 0, 0, 0], dtype=uint8)
        """
        places, absolute = places_of(x, y, observer_height, observer_elevation, needed)
        distance = distance_of(max_distance)
        seen = np.zeros(self.shape, np.float32 if needed else np.uint16)
        self._ground.viewshed(places, absolute, finite(target_height, "target_height"), distance,
                            self._curvature(curvature), bool(needed), seen, self._threads, progress_call(progress))
        if needed:
            return _result(self, seen, "needed_height", {"long_name": "height above ground needed to be seen", "units": "m"})
        nodata = 255 if len(places) <= 254 else 65535
        seen[~np.isfinite(self._samples)] = nodata
        if nodata == 255:
            seen = seen.astype(np.uint8)
        return _result(self, seen, "viewshed", {"long_name": "number of observers that see it", "_FillValue": seen.dtype.type(nodata)})

    def visibility(self, directions: int = 128, max_distance: float | None = None, *, observer_height: float = 2.0,
                   target_height: float = 0.0, curvature: float | None = None, every: int = 1, result: str = "area",
                   progress=None) -> Any:
        """How much of the ground every sample sees, as float32, NaN at holes.

        directions       how many, evenly spaced, 1 to 3600; along each the parts in sight are exact
        max_distance     what is farther away does not count, metres; default: no limit
        observer_height  of the eyes above the ground, metres
        target_height    of what must be seen above the ground, metres
        curvature        how much of the earth's curvature counts; default: 6/7 with a map, else 0
        every            eyes at every so many columns and rows
        result           "area": square kilometres in sight; "share": that area as a share of all within max_distance and
                         the field; "longest": metres to the farthest place in sight; "azimuth": of that place, in degrees

        How exposed a place is, from how much of the ground one sees it, follows by exchanging the two heights.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((9, 9), "float32"); z[:, 5] = 3           # a wall
            >>> cw.Field(z).visibility(result="share")[4, [1, 5]].round(2)
            array([0.63, 1.  ], dtype=float32)
        """
        look = look_of(directions, max_distance, observer_height, target_height, self._curvature(curvature), result)
        gap = count(every, "every", 1, 1 << 20)
        data = self._visibility_rows(look, 0, 0, *self.shape, gap, progress)
        return _result(self, data, "visibility", VISIBILITY[look[-1]], every=gap)

    def _visibility_rows(self, look, row, column, rows, columns, every=1, progress=None):
        out = np.empty((-(-rows // every), -(-columns // every)), np.float32)
        self._ground.visibility(*look[:-1], every, look[-1], row, column, rows, columns, out, self._threads, progress_call(progress))
        return out

    def line_of_sight(self, a: ArrayLike, b: ArrayLike, *, absolute: bool | tuple[bool, bool] = False, curvature: float | None = None,
                      progress=None) -> LineOfSight:
        """Whether places see each other, or where the straight line from a to b first meets the surface.

        a, b       (..., 3): x and y on the map, and metres above ground; (..., 2): on the ground. They broadcast.
        absolute   True: the third number is the height itself; or a pair, for a and for b
        curvature  as for viewshed

        Raises ValueError if a place has no ground under it or is under the ground. The ends themselves block nothing.

            >>> import numpy as np, cellwalk as cw
            >>> z = np.zeros((3, 9), "float32"); z[:, 4] = 3
            >>> s = cw.Field(z).line_of_sight((0, 1, 1), (8, 1, 1))
            >>> bool(s.visible), s.blocked_at.round(3).tolist()
            (False, [3.333, 1.0, 1.0])
        """
        pair = []
        for value, name in ((a, "a"), (b, "b")):
            ends = numbers(value, name).astype(np.float64)
            if ends.ndim == 0 or ends.shape[-1] not in (2, 3):
                raise ValueError(f"{name}: shape {ends.shape}, expected (..., 3) with x, y and height, or (..., 2)")
            if ends.shape[-1] == 2:
                ends = np.concatenate([ends, np.zeros(ends.shape[:-1] + (1,))], -1)
            pair.append(ends)
        try:
            both = np.broadcast_arrays(*pair)
        except ValueError:
            raise ValueError(f"shapes do not broadcast: a {pair[0].shape}, b {pair[1].shape}") from None
        lines = np.ascontiguousarray(np.stack(both, -2))
        shape = lines.shape[:-2]
        above = (absolute, absolute) if isinstance(absolute, (bool, np.bool_)) else tuple(absolute) if np.ndim(absolute) == 1 else ()
        if len(above) != 2:
            raise TypeError(f"absolute: {absolute!r}, expected True, False or a pair of them")
        out = np.full(shape + (6,), np.nan)
        if out.size:
            self._ground.line_of_sight(lines, bool(above[0]), bool(above[1]), self._curvature(curvature), out, self._threads, progress_call(progress))
        wrong = np.isnan(out[..., 0])
        if wrong.any():
            number = int(np.argmax(wrong.ravel()))
            end = int(out.reshape(-1, 6)[number, 1])
            place, reason = lines.reshape(-1, 2, 3)[number, end % 2].tolist(), _places_wrong[end // 2]
            raise ValueError(f"{'ab'[end % 2]}: ({', '.join(format(v, '.10g') for v in place)}) {reason}")
        return LineOfSight(out[..., 0] == 1, out[..., 1], out[..., 2:5], out[..., 5])
