# SPDX-License-Identifier: Apache-2.0
"""Hours and energy of sunlight, and the sky over leaning ground, against an almanac, closed forms, numbers worked out by hand from
the published formulas, and sums of single shadows; metres, directions, times and the sun against known numbers."""
import numpy as np
import pytest
from library import ARGUMENT, Room, horizon, light
from program import taken
from test_light import CELL, hills

SIDE = 49
X, Y = np.meshgrid(CELL * np.arange(SIDE), -CELL * np.arange(SIDE))


def seconds_of(lands, text):
    good, seconds = lands.call("cw_sun_parse_time", text, Room("f8"))
    return seconds[0] if good == "1" else None


def suns_of(lands, midnight, days, minutes, longitude, latitude):
    """From a midnight of UTC on, in the middle of steps: azimuth, altitude, refraction, radius, distance."""
    seconds = seconds_of(lands, midnight) + (np.arange(days * 1440 // minutes) + 0.5) * 60 * minutes
    return lands.table("suns", [[second, longitude, latitude] for second in seconds])


def sunlight(lands, suns, hours, curvature=0, directions=0):
    """Hours, direct and diffuse energy."""
    sum = lands.insolation(suns, hours, curvature, directions)
    products = [lands.product(f"insolation_{kind}", sum) for kind in ("hours", "direct")]
    return *products, float.fromhex(lands.call("cw_insolation_diffuse", sum)[0])


def slopes(z):
    """Of the mean of the triangles at each sample, eastward and northward."""
    sums, counts = np.zeros((2, *z.shape)), np.zeros(z.shape)
    steps = z[:, 1:] - z[:, :-1], z[1:] - z[:-1]
    for corner, rises in ((0, 1), (steps[0][:-1], steps[1][:, 1:])), ((1, 0), (steps[0][1:], steps[1][:, :-1])):
        there = ~np.isnan(rises[0] + rises[1])
        for j, i in (0, 0), (1, 1), corner:
            at = np.s_[j:j + there.shape[0], i:i + there.shape[1]]
            counts[at] += there
            for k in range(2):
                sums[(k, *at)] += np.where(there, rises[k], 0)
    with np.errstate(invalid="ignore"):
        return sums[0] / counts / CELL, -sums[1] / counts / CELL


@pytest.mark.parametrize("minutes", [1, 15])
@pytest.mark.parametrize("midnight, longitude, latitude, declination, day", [
    ("2024-06-21T00:00:00Z", -0.1257, 51.5085, 23.44, 16 + 38 / 60),  # London, longest and shortest day; Quito at the equinox
    ("2024-12-21T00:00:00Z", -0.1257, 51.5085, -23.44, 7 + 50 / 60), ("2024-03-20T05:00:00Z", -78.52, -0.23, 0, 12 + 7 / 60)])
def test_a_day_of_an_almanac(lands, midnight, longitude, latitude, declination, day, minutes):
    """Level ground is lit from sunrise to sunset. The almanac's are those of the sun's upper rim, with a refraction of 34 minutes
    of arc; ours of its middle, a radius of 16 minutes higher: later and earlier by that over the speed at which the sun rises, 15
    degrees an hour times cos(latitude) cos(declination) sin(hour angle). The almanac's times are rounded to a minute each, so that
    its day is right to one; a sum over steps is right to one step; our refraction differs by 0.1 minutes of arc at the horizon
    (28.98 at 0 degrees of true altitude, 34 at -0.57), hence 3 seconds, and the speed changes by less than 1 % on the way."""
    lands.land(np.zeros((SIDE, SIDE)))
    speed = 15 * np.cos(np.radians(latitude)) * np.cos(np.radians(declination)) * np.sin(np.radians(day * 7.5))
    hours, _, _ = sunlight(lands, suns_of(lands, midnight, 1, minutes, longitude, latitude), minutes / 60)
    assert np.abs(hours - (day - 2 * 0.2666 / speed)).max() <= minutes / 60 + 1 / 60 + 2 * 0.01


@pytest.mark.parametrize("directions", [0, 45, 90])
def test_sums_of_shadows(lands, directions):
    """Exact sums are those of single shadows; suns that share a direction get what single shadows of suns in that direction get,
    bit for bit. Hence the horizon between two suns decides as the shadow does. Energy is the sum of the light of suns that are
    seen, times the cosine. It is off by 0.006 W/m² of each sun for the heights between levels, and by rounding: cosines by 2^-21,
    the light and its product with them by eight roundings, 2^-21. The diffuse light is the sum of the formula."""
    z = hills(400, X, Y) + 900
    alone = z[20, 30]
    z[7, 9] = z[19:22, 29:32] = np.nan
    z[20, 30] = alone
    z = lands.land(z).astype(float)
    east, north = slopes(z)
    suns, wanted, energy, slack = suns_of(lands, "2024-05-01T00:00:00Z", 3, 20, 7, 47), 0, 0, 0
    diffuse = 0.5 * lands.table("skies", [[3, sun[4], sun[1] - sun[2], 0] for sun in suns])[:, 2].sum()
    for azimuth, altitude, _, _, distance in suns[suns[:, 1] > 0]:
        turn = 360 / directions if directions else 0
        lit = lands.shadow(np.rint(azimuth / turn) % directions * turn if turn else azimuth, altitude) == 1
        direct = lands.table("skies", np.column_stack([np.broadcast_to([3, distance, altitude], (z.size, 3)), z.ravel()]))[:, 1].reshape(z.shape)
        a, level = np.radians(azimuth), np.cos(np.radians(altitude))
        up = np.sin(np.radians(altitude)) - (east * np.sin(a) + north * np.cos(a)) * level
        wanted = wanted + 0.5 * lit
        energy = energy + np.where(lit, 0.5 * direct * np.fmax(up, 0) / np.sqrt(1 + east**2 + north**2), 0)
        slack = slack + np.where(lit, 0.5 * (0.006 + 2.0**-20 * direct), 0)
    hours, got, sky = sunlight(lands, suns, 0.5, directions=directions)
    hole = np.isnan(z)
    assert (np.isnan(hours) == hole).all() and (np.isnan(got) == np.isnan(east)).all() and (hours == wanted)[~hole].all()
    hole[20, 30] = True  # no triangle, no lean
    assert (np.abs(got - energy) <= slack)[~hole].all() and abs(sky - diffuse) <= 1e-9 * diffuse and diffuse > 500
    assert (wanted != wanted[0, 0]).mean() > 0.5


def test_light_by_hand(lands):
    """From the published formulas with a calculator of 30 digits: linke, astronomical units, altitude with refraction, height; air
    mass, direct light; diffuse light."""
    rows = np.array([[3, 1, 30, 0, 1.99429285253, 800.918095209, 89.7986187764], [2, 0.9833, 5.5, 2000, 7.51081678533, 605.462573656, 22.3460018542],
                     [4.5, 1.0167, 62.3, 350, 1.08291796033, 799.776038047, 168.460596838],
                     [6.8, 1, 1.5, 0, 22.4415126997, 9.34406617092, 15.2675348468], [3, 1, 0.4, 4000, 20.2446973911, 165.775115119, 13.2132600102]])
    np.testing.assert_allclose(lands.table("skies", rows[:, :4]), rows[:, 4:], rtol=1e-9)
    assert (lands.table("skies", [[3, 1, 0, 0], [3, 1, -5, 0]])[:, 1] == 0).all() and lands.table("skies", [[3, 1, -0.01, 0]])[0, 2] == 0


@pytest.mark.parametrize("tilt", taken(range(0, 75, 15), 3))
def test_the_sky_over_a_plane(lands, tilt):
    """It sees (1 + cos tilt) / 2 of it. The sum over directions is the trapezoidal rule for a periodic function whose slope jumps
    where the plane meets the level, twice: by at most 2 tan(tilt) there, so it is off by less than 2 · jump · step² / 8 / (2 π).
    Samples at the border see as much, but for the corners that lack neighbours."""
    steep, step = np.tan(np.radians(tilt)), 2 * np.pi / 180
    lands.land(steep * (np.cos(1) * X + np.sin(1) * Y))
    tilted, level = (lands.product("sky_view", horizon(0.7, count=180, flags=flags)) for flags in (1, 0))
    assert np.abs(tilted - (1 + np.cos(np.radians(tilt))) / 2).max() <= 2 * 2 * steep * step * step / 8 / (2 * np.pi) + 1e-5
    assert tilt > 0 or (tilted == level).all()


@pytest.mark.parametrize("count", [1, 3, 7, 32, 360, 3599])
def test_the_sky_of_a_plain_is_whole(lands, count):
    lands.land(np.full((7, 9), 300))
    for flags in 0, 1:
        assert (lands.product("sky_view", horizon(count=count, flags=flags)) == 1).all()


def test_the_sky_over_land(lands):
    """Against the integral, summed up over the sky in small pieces from the horizon's angles, on land that leans; as on a level, in
    closed form: the mean of the squared cosines of those angles. Pieces of angle e are off by e times the steepness of what is
    summed, which is at most 2 in each direction."""
    z, directions, pieces = lands.land(hills(0, X, Y)).astype(float), 16, 2000
    some = np.s_[4::13, 4::13]
    share, flat = (lands.product("sky_view", horizon(count=directions, flags=flags))[some] for flags in (1, 0))
    east, north = (slope[some] for slope in slopes(z))
    up, piece = 1 / np.sqrt(1 + east**2 + north**2), np.pi / 2 / pieces
    x, total, squares = (np.arange(pieces) + 0.5) * piece, 0, 0
    for number in range(directions):
        angle, a = np.radians(lands.angles(horizon(count=directions), number)[0][some].astype(float)), 2 * np.pi * number / directions
        cosine = up[..., None] * (np.sin(x) - (east * np.sin(a) + north * np.cos(a))[..., None] * np.cos(x))
        total = total + np.where((x > angle[..., None]) & (cosine > 0), cosine * np.cos(x), 0).sum(-1) * piece * 2 / directions
        squares = squares + np.cos(np.fmax(angle, 0))**2 / directions
    assert np.abs(share - total).max() < 2 * piece + 1e-5 and np.abs(flat - squares).max() < 1e-5
    assert np.degrees(np.arccos(up)).max() > 30


# ---- the map and the sun ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("latitude, east, north", [(0, 111319.491, 110574.276), (45, 78846.806, 111131.778), (-45, 78846.806, 111131.778)])
def test_metres_in_a_degree(lands, latitude, east, north):
    """On WGS 84, from the formulas of its radii: National Geospatial-Intelligence Agency, TR8350.2. North-east by the compass is
    more columns than rows, where a column is shorter."""
    lands.land(np.zeros((2, 3)), [[0.5, 0, 0, 10], [0, -0.5, 0, latitude], [0, 0, 1, 0]], geographic=1)
    mx, my, dx, dy, length, *_ = lands.table("places", [[1, 0, 45]])[0]
    assert abs(mx - east) < 0.05 and abs(my - north) < 0.05 and abs(dx / -dy - my / mx) < 1e-9
    assert abs(length - np.hypot(dx * 0.5 * mx, dy * 0.5 * my)) < 1e-6


def test_units_of_a_map(lands):
    lands.land(np.full((2, 3), 5), [[30, 0, 0, 1000], [0, -30, 0, 2000], [0, 0, 1, 0]], unit=0.3048)
    place = lands.table("places", [[1, 1, 0]])[0]
    assert (place[:2] == 0.3048).all() and abs(place[7] - 5 * 0.3048) < 1e-12
    flat = lands.desc(np.zeros((2, 3)), [[1, 2, 0, 0], [2, 4, 0, 0], [0, 0, 1, 0]])
    assert "map" in lands.fails(ARGUMENT, "cw_field_create", flat, None, Room("u8"))


def test_multiples_of_45_degrees_go_through_samples(lands):
    lands.land(np.zeros((2, 3)))
    k = np.arange(-16, 17)
    sine, cosine = lands.table("places", np.column_stack([0 * k, 0 * k, 45.0 * k]))[:, 5:7].T
    assert (sine[k % 4 == 0] == 0).all() and (cosine[k % 4 == 2] == 0).all() and (abs(sine) == abs(cosine))[k % 2 == 1].all()
    assert np.abs(sine - np.sin(np.radians(45.0 * k))).max() < 1e-15 and np.abs(cosine - np.cos(np.radians(45.0 * k))).max() < 1e-15


def test_the_sun_of_an_almanac(lands):
    """Meeus, Astronomical Algorithms, example 25.a: 1992 October 13, 0h, declination -7.78507. Over the pole that is the altitude;
    less the parallax of 0.00243; in a minute, by which his time differs from the clock's, it changes by less than 0.0003. 959.63
    arc seconds over 0.99766 units."""
    _, altitude, refraction, radius, _ = lands.table("suns", [[seconds_of(lands, "1992-10-13T00:00:00Z"), 0, 90]])[0]
    assert abs(altitude - refraction + 7.78507 + 0.00243) < 0.0005 and abs(radius - 0.26734) < 1e-3


def test_times(lands):
    for text, seconds in [("1970-01-01T00:00:00Z", 0), ("2000-02-29T00:00:00Z", 951782400), ("2000-03-01T00:00:00Z", 951868800),
                          ("2024-06-21T12:00:00+02:00", 1718964000), ("2024-06-21T12:00Z", 1718971200)]:
        assert seconds_of(lands, text) == seconds
    for text in ("", "noon", "2024-06-21T12:00:00", "2024-13-01T00:00Z", "2024-02-30T00:00Z", "1900-02-29T00:00Z", "2023-02-29T00:00Z",
                 "2024-06-21T25:00Z", "2024-06-21T12:00:00Zx"):
        assert seconds_of(lands, text) is None
