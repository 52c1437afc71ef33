# SPDX-License-Identifier: Apache-2.0
"""Shadow, horizon and the sun's disc on land of many kinds, against rays that queries trace one by one, against a look at every
edge, and against closed forms; limits of viewsheds against a look at each sample; profiles against the surface between their
points."""
import numpy as np
import pytest
from library import MAPS, RADIUS, RAY, horizon, light, observer
from program import DIVISOR, SLOW, taken
from test_visible import crossings, samples_along

CELL, SIDE = 10, 97
MIDDLE = SIDE // 2
X, Y = np.meshgrid(CELL * np.arange(SIDE), -CELL * np.arange(SIDE))


def hills(shape, x=X, y=Y):
    return (200 * np.sin(x / 310 + shape) * np.cos(y / 270) + 60 * np.sin(x / 57 + 2 * shape) * np.sin(y / 71 + shape) +
            9 * np.sin(x / 13 + y / 17))


WALL, CLIFF = np.where(Y == -CELL * MIDDLE, 50, 0), np.where(X <= CELL * MIDDLE, 0, -1000)
KNOWN = [hills(0.7), 0.25 * X - 0.5 * Y, np.where(np.hypot(X - CELL * MIDDLE, Y + CELL * MIDDLE) < 300, 0, 170), CLIFF, WALL]


def rough(kind, r, nx=SIDE, ny=SIDE):
    """Smooth, rough, with holes, of spikes, of whole numbers, with no-data values that are read as heights."""
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    if kind == 3:
        return np.where(r.random((ny, nx)) < 1 / 40, r.uniform(0, 90, (ny, nx)), 0)
    a, b = r.uniform(3, 9, 2)
    z = 20 * np.sin(i / a) * np.cos(j / b) + r.uniform(0, 1 if kind == 0 else 15, (ny, nx))
    if kind == 2:
        z[r.random((ny, nx)) < 1 / 12] = np.nan
    if kind == 5:
        z = np.where(r.random((ny, nx)) < 1 / 50, r.choice([-32768, -9999], (ny, nx)), z)
    return np.rint(0.2 * z) if kind == 4 else z


@pytest.mark.parametrize("strips", [4, 16, 64])
def test_a_wall_before_the_disc(lands, strips):
    """A long wall as high as the middle of the sun hides half of it, and more or less by a segment of the disc. The sum over
    strips, in which the part that is seen falls from the middle strip outward, is off by no more than half of the largest strip's
    share on each side. Away from the middle the wall is farther off: each strip is cut at its top on the strip's own azimuth, to the
    rounding of floats, and the disc's part lies between those of the tops before its middle and its outermost strip."""
    lands.land(WALL)
    radius, cases = 2, [(south, u) for south in range(4, 40, 7) for u in np.arange(-1.25, 1.26, 0.25)]  # the top over the middle, in radii
    aside = np.append((2 * np.arange(strips) + 1) / strips - 1, 0)
    half = np.sqrt(1 - aside[:-1]**2)
    for south, u in taken(cases, 7):
        altitude = np.degrees(np.arctan(50 / (CELL * south))) - u * radius
        share = lands.product("sunlight", light(altitude=altitude, radius=radius, strips=strips))[MIDDLE + south, MIDDLE]
        away = np.cos(np.radians(aside * radius / np.cos(np.radians(altitude))))
        tops = (np.degrees(np.arctan(50 / (CELL * south) * away)) - altitude) / radius
        assert abs(share - np.clip(half - tops[:-1], 0, 2 * half).sum() / (2 * half.sum())) < 1e-5, (south, u)
        v = np.clip(tops[[-1, 0]], -1, 1)
        least, most = (np.arccos(v) - v * np.sqrt(1 - v * v)) / np.pi
        assert least - 4 / (np.pi * strips) <= share <= most + 4 / (np.pi * strips), (south, u)


def test_a_tiny_disc_is_a_point(lands):
    """At the rim half of the disc has no wall before it."""
    lands.land(WALL)
    for radius in (1e-5, 1e-9, 1e-300):
        share = lands.product("sunlight", light(altitude=12, radius=radius))
        assert (share == lands.shadow(0, 12))[:, 1:-1].all(), radius


def test_hillshade_of_a_plane(lands):
    """Heights of up to 700 m are rounded by 3 10^-5, differences over 10 m so by 6 10^-6 of a slope."""
    lands.land(0.3 * X + 0.4 * Y)
    for azimuth in range(0, 360, 30):
        a, level = np.radians(azimuth), np.cos(np.radians(50))
        cosine = (np.sin(np.radians(50)) - 0.3 * np.sin(a) * level - 0.4 * np.cos(a) * level) / np.sqrt(1 + 0.3**2 + 0.4**2)
        assert np.abs(lands.product("sunlight", light(azimuth, 50, hillshade=1)) - cosine).max() < 1e-5


def test_no_light_from_behind(lands):
    """At the edge of a cliff the sun is seen, but the mean of the triangles faces away from it: no light, and not less."""
    lands.land(CLIFF)
    share = lands.product("sunlight", light(270, 10, hillshade=1))
    assert (lands.shadow(270, 10)[:, MIDDLE] == 1).all() and (share[:, MIDDLE] == 0).all() and (share[:, MIDDLE - 1] > 0).all()


def test_holes_are_no_ground(lands):
    """A wall that is not there."""
    lands.land(np.where(WALL > 0, np.nan, 0))
    hole, share = WALL > 0, lands.product("sunlight", light(altitude=20, radius=0.3, hillshade=1))
    angles, _ = lands.angles(horizon(count=4))
    assert (lands.shadow(0, 20) == np.where(hole, 255, 1)).all()
    assert (np.isnan(share) == hole).all() and np.isnan(angles[hole]).all() and (share[~hole] > 0.3).all() and not (angles[~hole] > 0).any()


def test_large_areas_are_made_in_pieces(lands):
    """Of a million samples: a wall in the second one shades five rows south of it."""
    z = np.zeros((1100, 1000))
    z[1080] = 50
    lands.land(z)
    lit = lands.shadow(0, 43)
    assert (lit[1081:1086] == 0).all() and lit.sum() == 1095 * 1000


def test_shadow_agrees_with_horizon_and_rays(lands):
    """Also on a curved earth. At night the land's rim hides the sun, too: from a height z a free horizon has the dip acos(R / (R +
    z)). Rays begin 2 mm over the ground, which is far above what rounding does to heights of 300 m; an edge is at least 7 m away,
    where 0.1 degrees are 12 mm. Beside holes, edges without a triangle are ground to horizons and nothing to rays."""
    shadows = nights = 0
    for number in taken(range(60), 15):
        r = np.random.default_rng(number)
        azimuth = 45.0 * (number // 4) if number % 4 == 0 else r.uniform(0, 360)
        altitude = r.uniform(-1.5, 0) if number % 7 == 0 else r.uniform(1, 40)
        curvature = 3000 if number % 5 == 1 and altitude > 0 else 0
        z = lands.land(KNOWN[number % 10] if number % 10 < 5 else rough(number % 5, r))
        lit, (angles, _) = lands.shadow(azimuth, altitude, curvature), lands.angles(horizon(azimuth, count=1, curvature=curvature))
        holes = np.isnan(z)
        shadows, nights = shadows + (lit == 0).sum(), nights + (altitude < 0) * (lit == 1).sum()
        assert (lit[holes] == 255).all() and np.isnan(angles[holes]).all()
        angles = np.where(np.isnan(angles), -90, angles)
        if altitude > 0:
            clear = ~holes & (np.abs(angles - altitude) > 1e-3)
            assert ((lit == 0) == (angles > altitude))[clear].all()
        if curvature > 0:
            continue
        sine, cosine = lands.table("places", [[0, 0, azimuth]])[0, 5:7]  # a ray along the rim stays on it
        rays = np.zeros((SIDE, SIDE), RAY)
        rays["org"], rays["tmax"] = np.dstack([X / CELL, -Y / CELL, z + np.float32(2e-3)]), np.inf
        rays["dir"] = sine, -cosine, np.tan(np.radians(altitude)) * CELL
        hidden = lands.occluded(lands.fields[0], rays.ravel()).reshape(SIDE, SIDE).astype(int)
        night = (altitude < 0) & (z <= RADIUS * (1 / np.cos(np.radians(altitude)) - 1))
        known = night | ((np.abs(angles - altitude) >= 0.1) & ((hidden == 1) | ~holes.any()))
        assert (lit == np.where(night, 0, 1 - hidden))[known & ~holes].all()
    assert shadows > 100 and (nights > 0 or DIVISOR * SLOW > 1)


@pytest.mark.parametrize("curvature", [0, 200, 5000])
@pytest.mark.parametrize("farthest", [0, 61.7, 333.3])
def test_horizons_are_the_steepest_edges(lands, farthest, curvature):
    """Also of an earth so much rounder that it hides what is far. A heading lowers each crossing, this the samples beside it. On an
    edge of at most L = 10 √2 m that differs by up to curvature (L / 2)² / 2 R metres; the nearest crossing is L / 2 away: an angle
    of curvature L / 4 R. On a flat earth the surface rises as steeply at the horizon's distance."""
    z = lands.land(hills(1.1)).astype(float)
    r, near = np.random.default_rng(77), []
    slack = 1e-3 + np.degrees(curvature * CELL * np.sqrt(2) / (4 * RADIUS))
    for number in range(5):
        angles, metres = lands.angles(horizon(11, farthest, curvature, 5), number)
        azimuth = np.radians(11 + 72 * number)
        steps, edges, f = crossings(np.sin(azimuth), -np.cos(azimuth), 2 * SIDE)
        for i, j in r.integers(1, SIDE - 1, (60 if DIVISOR * SLOW == 1 else 12, 2)):
            fall = curvature * CELL * CELL * ((X / CELL - i)**2 + (Y / CELL + j)**2) / (2 * RADIUS)
            one, other = (heights[:, 0] for heights in samples_along(z - z[j, i] - fall, i, j, *edges))
            inside = ((CELL * steps <= farthest) | (farthest == 0)) & ~np.isnan(one + other)
            rise = ((one + f * (other - one)) / (CELL * steps))[inside]
            if len(rise) == 0:
                assert np.isnan(angles[j, i])
                continue
            assert abs(angles[j, i] - np.degrees(np.arctan(rise.max()))) < slack, (i, j)
            assert farthest == 0 or metres[j, i] <= farthest * (1 + 2.0**-19)
            if curvature == 0:
                at = np.abs(CELL * steps[inside] - metres[j, i]).argmin()
                assert abs(CELL * steps[inside][at] - metres[j, i]) < 1e-3 and rise.max() - rise[at] < 2.0**-22
                near.append(metres[j, i] < 100)
    assert farthest > 0 or curvature > 0 or 1 / 9 < np.mean(near) < 8 / 9


def test_the_nearest_of_equal_horizons(lands):
    """Walls 8 and 16 cells east of an eye, the second one twice as high. From the eye 64 steps lead out of the field, so that no
    share of the way is rounded. East of the last column there is no terrain, and so no horizon."""
    eye = CELL * (SIDE - 64)
    lands.land(np.where(X == eye + 80, 20, np.where(X == eye + 160, 40, 0)))
    angles, metres = lands.angles(horizon(90, count=1))
    assert (metres[:, SIDE - 64] == 80).all() and np.isnan(angles[:, -1]).all() and np.isnan(metres[:, -1]).all()


def test_degrees_of_tangents(lands):
    r, count = np.random.default_rng(5), max(1000000 // (DIVISOR * SLOW), 20000)
    x = (r.uniform(-1, 1, count) * 2 ** r.uniform(-30, 30, count)).astype("f4").astype(float)
    assert np.abs(lands.table("degrees", x)[:, 0] - np.degrees(np.arctan(x))).max() < 1e-5
    np.testing.assert_array_equal(lands.table("degrees", [np.inf, -np.inf, 0, np.nan])[:, 0], [90, -90, 0, np.nan])


# ---- limits of viewsheds --------------------------------------------------------------------------------------------------------

NX, NY = 61, 47
I, J = np.meshgrid(np.arange(NX), np.arange(NY))


def some_land(lands, number, r):
    """Its samples and a function of field coordinates: metres east and north from a place."""
    map, geographic = MAPS[number % len(MAPS)]
    z = lands.land(rough(2 if number % 3 == 0 else 1, r, NX, NY), map, geographic=geographic)

    def metres(x, y, i, j):
        scale = lands.table("places", [[x, y, 0]])[0, :2]
        return [scale[k] * (map[k][0] * (i - x) + map[k][1] * (j - y)) for k in range(2)]
    return z.astype(float), np.array(map), metres


def test_limits_sample_by_sample(lands):
    """Samples within 10^-6 of an end are left out, where atan2 and cross products may differ by rounding. A float has 24 bits; what
    the two ways differ by is far less than their last one."""
    r, seen, left_out = np.random.default_rng(2311), 0, 0
    for number in taken(range(160), 7):
        z, map, metres = some_land(lands, number, r)
        x, y = r.integers(-5 * 64, [(NX + 5) * 64, (NY + 5) * 64]) / 64 if number % 2 else r.integers(-5, [NX + 5, NY + 5])
        where = map[:2, :2] @ [x, y] + map[:2, 3]
        base = dict(x=where[0], y=where[1], height=r.uniform(40, 80), target=r.uniform(0, 5), curvature=r.choice([0, 200]), absolute=1)
        nearest, farthest = r.choice([0, 1]) * r.uniform(0, 150), r.choice([0, 1]) * r.uniform(150, 400)
        first, low = r.uniform(-180, 180), r.uniform(-20, 0)
        last, high = first + r.uniform(0, r.choice([20, 359])), low + r.uniform(0, 15)
        last -= 360 if last > 180 and number % 4 < 2 else 0
        flags = int(r.random() < 0.75) + 2 * int(r.random() < 0.5)
        everything, *_ = lands.viewshed(observer(**base))
        limits = dict(nearest=nearest, farthest=farthest, azimuths=(first, last), verticals=(low, high), limits=flags)
        some, angles, sums, *_ = lands.viewshed(observer(**base, **limits))
        east, north = metres(x, y, I, J)
        away, azimuth = np.hypot(east, north), np.degrees(np.arctan2(east, north))
        rise = z * map[2, 2] + base["target"] - base["height"] - base["curvature"] * away**2 / (2 * RADIUS)
        with np.errstate(invalid="ignore"):
            angle = np.degrees(np.arctan2(rise, away))
            turn, wide = (azimuth - first) % 360, last - first if last >= first else last - first + 360
            within = (away >= nearest) & ((farthest == 0) | (away <= farthest))
            within &= (flags % 2 == 0) | (away == 0) | (turn <= wide)
            within &= (flags < 2) | ((angle >= low) & (angle <= high))
            ends = [away - nearest, away - farthest, turn, turn - wide, turn - 360, angle - low, angle - high]
            clear = ~np.isnan(z) & (np.min(np.abs(ends), 0) > 1e-6) & (away > 0)
        wanted = (everything == 1) & within
        assert ((some == wanted) & (sums == 2.5 * wanted))[clear].all(), number
        assert (np.abs(angles - angle) <= 2.0**-23 * (np.abs(angle) + 1e-6))[clear & wanted].all() and np.isnan(angles[clear & ~wanted]).all()
        holes = np.isnan(z)
        assert not some[holes].any() and np.isnan(angles[holes]).all() and not sums[holes].any()
        seen, left_out = seen + wanted.sum(), left_out + (everything - wanted.astype(int))[clear].sum()
    assert min(seen, left_out) > 1000 / min(DIVISOR * SLOW, 7)


def test_limits_include_their_ends(lands):
    """Level ground and an eye over sample (20, 20), 30 m high. The eye's own sample is in all that is about directions."""
    side, at = 41, 20
    lands.land(np.zeros((side, side)))
    x, y = np.meshgrid(np.arange(side) - at, at - np.arange(side))  # east, north
    square = x * x + y * y
    own, sectors = square == 0, {
        (0, 90): (x >= 0) & (y >= 0), (45, 45): (x == y) & (x > 0), (270, 90): y >= 0, (90, 45): ~((x > 0) & (y > 0) & (x > y)), (0, 360): y == y,
        (360, 0): (x == 0) & (y > 0), (-45, 45): y >= abs(x), (225, 135): ~(-y > abs(x)),
        (0, 179.9999999): (x > 0) | ((x == 0) & (y > 0)), (90, 269.9999999): (y < 0) | ((y == 0) & (x > 0))}
    cases = [(dict(azimuths=ends, limits=1), own | wanted) for ends, wanted in sectors.items()]
    cases += [(dict(verticals=ends, limits=2), wanted) for ends, wanted in (
        ((-45, 90), square >= 9), ((-90, -45), square <= 9), ((0, 90), square < 0))]
    for limits, wanted in [*cases, (dict(nearest=50, farthest=130), (square >= 25) & (square <= 169))]:
        seen, *_ = lands.viewshed(observer(CELL * at, -CELL * at, 30, absolute=1, **limits))
        assert (seen == wanted).all(), limits


def surface(z, x, y):
    """Its height on two triangles a cell."""
    i, j = np.clip(np.floor(x).astype(int), 0, NX - 2), np.clip(np.floor(y).astype(int), 0, NY - 2)
    u, v = x - i, y - j
    return np.where(v <= u, z[j, i] + u * (z[j, i + 1] - z[j, i]) + v * (z[j + 1, i + 1] - z[j, i + 1]),
                    z[j, i] + v * (z[j + 1, i] - z[j, i]) + u * (z[j + 1, i + 1] - z[j + 1, i]))


def test_profiles(lands):
    """All points of a profile are on the surface. Between two points the surface is straight, so none is missing; within an edge
    the earth's lowering bends by a quarter of its value at the edge's length. A point is seen if it rises more steeply than all
    before it."""
    r, counts = np.random.default_rng(77), np.zeros(3, int)
    for number in taken(range(120), 5):
        z, map, metres = some_land(lands, number, r)
        ends = np.column_stack([r.uniform(0, NX - 1, 2), r.uniform(0, NY - 1, 2), r.uniform(20, 40, 2)])
        ends[:, :2] = np.rint(ends[:, :2]) if number % 2 else ends[:, :2]
        ends[1, 0] = ends[0, 0] if number % 5 == 0 else ends[1, 0]  # along a column
        if (ends[0, :2] == ends[1, :2]).all():
            ends[1, 1] = 30 if ends[0, 1] < 20 else 3
        curvature = 50 if number % 4 == 1 else 0
        share, ground, line, seen = lands.profile(*ends, curvature)

        def fall(i, j):
            east, north = metres(*ends[0, :2], i, j)
            return curvature * (east**2 + north**2) / (2 * RADIUS * map[2, 2])
        one, two = ends[0, :2]
        bend = 0.25 * (2 * fall(one + 1, two) + 2 * fall(one, two + 1) + fall(one + 1, two + 1))
        assert share[0] == 0 and share[-1] == 1 and (np.diff(share) > 0).all()
        assert np.abs(line[[0, -1]] - ends[:, 2]).max() < 1e-9
        if number % 2 and number % 5:  # ends at samples have their heights, in any unit
            np.testing.assert_array_equal(ground[[0, -1]], z[tuple(ends[:, 1::-1].T.astype(int))])
        f = r.random(len(share) - 1)
        between = share[:-1] + f * np.diff(share)
        height = surface(z, *(ends[0, :2, None] + between * (ends[1, :2] - ends[0, :2])[:, None]))
        off = np.abs(ground[:-1] + f * np.diff(ground) - height)
        assert not (off >= 1e-9 + bend).any(), number  # not a number: an edge beside a hole is ground, too
        at = ends[0, :2, None] + share * (ends[1, :2] - ends[0, :2])[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = (ground - ends[0, 2] - fall(*at)) / share
        before = np.fmax.accumulate(np.where(np.arange(len(share)) == 0, -np.inf, rise))[:-1]
        clear = ~(np.abs(rise[1:] - before) <= 1e-6) & ~np.isnan(rise[1:])
        assert ((seen[1:] == 1) == (rise[1:] > before))[clear].all(), number
        counts += seen.sum().astype(int), (seen == 0).sum(), np.isnan(ground).sum()
    assert (counts > 50 / min(DIVISOR * SLOW, 5)).all()
