# SPDX-License-Identifier: Apache-2.0
"""The ground in sight along a direction: against all edges of the field in double, with bounds on rounding that are carried through; the same bits for
every instruction set, number of threads, part of the eyes and place of the land."""
import numpy as np
import pytest
from library import MAPS, RADIUS, struct
from program import taken
from test_coarser import SHAPES, made

SIZES = [(2, 2), (2, 41), (41, 2), (17, 17), (65, 65), (31, 12)]
HEIGHTS = [(2, 0), (0.25, 0), (0, 1), (0.5, 3), (3, 0.5), (0, 0)]  # of eye and target
TINY = 2.0**-30
EXACT = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1), (2, 1), (-1, 3), (-3, -1), (3, -2), (1, TINY), (-TINY, 1), (-2, 1),
         (1, -3), (10, -9), (-7, 8), (1, 1 + TINY)]


def direction(r, number):
    """Of the compass, exactly and nearly, whole numbers of cells, and then any."""
    if number < len(EXACT):
        return EXACT[number]
    angle, length = r.uniform(0, 2 * np.pi), 1 if number % 2 else r.uniform(0.01, 100)
    return length * np.cos(angle), length * np.sin(angle)


def lakes(nx, ny, water):
    """Rolling land with ripples, and mountains far away, under water up to some height."""
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    land = 1000 + 40 * np.sin(i / 37) * np.cos(j / 29) + 9 * np.sin((i + 2 * j) / 11) + np.random.default_rng(3).random((ny, nx))
    return np.maximum(land, water).astype("f4")


# ---- brute force ------------------------------------------------------------------------------------------------------------


def crossings(dx, dy, most):
    """Where the line from a sample crosses edges or meets samples, up to so many cells away: steps, column and row of one sample, the way to the
    other one and the share of it, by distance. With coordinates below 1024 rounding is a twentieth of what counts as on the line."""
    n, found, samples = np.arange(1.0, most + 1), [], {}
    for kind, per in enumerate((dx, dy, dx - dy)):
        if per == 0:
            continue
        t, whole = n / abs(per), n * np.sign(per)
        free = t * (dy if kind == 0 else dx)  # the other coordinate along a column; else the column
        places = [[(whole, c), (c, whole), (c, c - whole)][kind] for c in (np.floor(free), np.rint(free))]
        on = np.abs(dx * places[1][1] - dy * places[1][0]) < 1e-11 * np.hypot(dx, dy)
        step = [(0, 1), (1, 0), (1, 1)][kind]
        found += [(at, x, y, *step, f) for at, x, y, f in zip(t[~on], *(c[~on] for c in places[0]), (free - np.floor(free))[~on])]
        samples.update({(x, y): (at, x, y, 0, 0, 0.0) for at, x, y in zip(t[on], *(c[on] for c in places[1]))})
    found = np.array(sorted([*found, *samples.values()]))
    return found[:, 0], found[:, 1:5].astype(int).T, found[:, 5]


def samples_along(z, i, j, x, y, across, down):
    """Of each crossed edge, as seen from samples: the heights of its ends, NaN outside."""
    columns, rows = [i + x[:, None], i + (x + across)[:, None]], [j + y[:, None], j + (y + down)[:, None]]
    inside = np.all([(c >= 0) & (c < z.shape[1]) & (r >= 0) & (r < z.shape[0]) for c, r in zip(columns, rows)], 0)
    return [np.where(inside, z[np.where(inside, r, 0), np.where(inside, c, 0)], np.nan) for c, r in zip(columns, rows)]


def in_sight(t0, t1, w0, w1, m, there, first, reach):
    """The parts of pieces whose slopes, w0 at t0 and w1 at t1, are greater than m: their area, farthest end, and what they lose if each area is cut to a
    multiple of its run's unit."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        d0, d1, span = (w0 - m) * t0, (w1 - m) * t1, t1 - t0
        begin = np.where(d0 > 0, t0, t1 - span * d1 / (d1 - d0))
        end = np.where(d1 > 0, t1, t0 + span * d0 / (d0 - d1))
        there = there & ((d0 > 0) | (d1 > 0))
        begin, end = np.concatenate([0 * first, np.where(there, begin, 0)]), np.concatenate([first, np.where(there, end, 0)])
        end = np.minimum(end, reach) if reach > 0 else end
        seen = end > begin
        area = np.where(seen, (end * end - begin * begin) / 2, 0).sum(0)
        units = np.where(seen, np.maximum(2.0**-20, 2.0**-29 * 129 * (2 * begin + 129)) / 2, 0).sum(0)
    return area, np.where(seen, end, 0).max(0), units


def brute(z, i, j, dx, dy, reach, drop, eye, target):
    """What is in sight at least and at most from eyes over samples, if every slope may be off by its error: with all targets lower and what hides them
    higher, and the other way round. A float's slope is off by 2^-20 of the higher rise at most: eight roundings of 2^-24, of differences that are at
    most twice as large."""
    t, edges, f = crossings(dx, dy, sum(z.shape))
    t, f = t[:, None], f[:, None]
    start = (z[j, i] + np.float32(eye)).astype(float)
    one, other = (heights - start for heights in samples_along(z, i, j, *edges))
    slope = (one + f * (other - one)) / t - drop * t
    error = 2.0**-20 * (np.fmax(np.abs(one), np.abs(other)) + target) / t + 2.0**-22 * drop * t + 2.0**-140
    there = ~np.isnan(slope[1:]) & ~np.isnan(slope[:-1])
    first = np.where(~np.isnan(slope[:1]) & ((start > z[j, i]) | (target > 0)), t[:1], 0)
    bounds = []
    for sign in -1, 1:
        highest = np.fmax.accumulate(slope - sign * error)[:-1]
        seen = slope + target / t + sign * error
        bounds.append(in_sight(t[:-1], t[1:], seen[:-1], seen[1:], np.where(np.isnan(highest), -np.inf, highest), there, first, reach))
    return bounds


class Against:
    """All lines of small fields, some of large ones, in so many directions; and how much the bounds leave open, of how much."""

    def __init__(self, lands):
        self.lands, self.open, self.all = lands, 0, 0

    def check(self, z, directions, seed, eye=0, target=0, reach=0, drop=0):
        z, r = self.lands.land(z), np.random.default_rng(seed)
        for number in taken(range(directions), 10):
            dx, dy = direction(r, number)
            length = np.hypot(dx, dy)
            how = dx, dy, reach / length, drop * length * length, eye, target
            found = [values.ravel() for values in self.lands.visible(how, keep=True)]
            hole = np.isnan(z.ravel())
            assert all(np.isnan(values[hole]).all() for values in found)
            some = np.flatnonzero(~hole)
            some = some if len(some) <= 120 else r.choice(some, 120)
            if len(some) == 0:
                continue
            least, most = brute(z, some % z.shape[1], some // z.shape[1], *how)
            area, far, label = (values[some] for values in found)
            slack, ends = 2.0**-20, 2.0**-22 * how[2]**2  # floats have the ends of the last piece, if the reach ends it
            good = (area >= least[0] * (1 - slack) - least[2] - ends) & (area <= most[0] * (1 + slack) + ends)
            good &= (far >= least[1] * (1 - slack)) & (far <= most[1] * (1 + slack))
            assert good.all(), (z.shape, how, some[~good][:1], [values[~good][:1] for values in (area, far, *least, *most)])
            assert ((label == 7) == (far > 0)).all() and (np.isnan(label) == (far == 0)).all()
            self.open, self.all = self.open + (most[0] - least[0]).sum(), self.all + most[0].sum()


@pytest.fixture
def against(lands):
    return Against(lands)


@pytest.mark.parametrize("shape", [shape for shape in SHAPES if shape not in ("huge", "mixed")])  # whose slopes are no floats
def test_every_line_counts(against, shape):
    for k, (nx, ny) in enumerate(SIZES):
        against.check(made(shape, nx, ny, k), 30, k, *HEIGHTS[(list(SHAPES).index(shape) + k) % len(HEIGHTS)])


def test_little_is_left_to_rounding(against):
    """But by cliffs, and by planes seen edge-on."""
    for k in range(18):
        eye, target = HEIGHTS[k % 5]
        against.check(made(["holes", "random", "integers"][k % 3], 17 + k, 15, k), 40, k, 0.1 * eye, 0.1 * target)
    assert against.open < 1e-3 * against.all


def test_large_land_is_seen_rightly(against):
    for k, (eye, target) in taken(enumerate(HEIGHTS[:5]), 3):
        nx, ny = (255, 130) if k % 2 else (90, 300)
        against.check(lakes(nx, ny, 980), 20, k, eye, target, drop=1e-4 if k % 2 else 0)
    assert against.open < 0.01 * against.all


def test_spikes_are_not_passed_over(against):
    """Single high samples, which a bound must not miss: the earth's curvature hides all flat land that is not near."""
    for k in taken(range(6), 3):
        z, r = np.full((170, 160), 0.375), np.random.default_rng(k)
        z.flat[r.integers(0, z.size, 400)] += r.uniform(0, 60, 400)
        against.check(z, 45, k, 2 if k % 2 else 0.5, 0 if k % 3 else 1, drop=0.005)


def test_reach_and_curvature_count(against):
    """Distances end within pieces, at borders and beyond; the earth is flat, a little curved, and as round as a ball."""
    for k in taken(range(1, 15), 4):
        more = {"reach": (0, 0.3137, 5.2713, 61.317, 1)[k % 5], "drop": (0, 1e-4, 0.05)[k // 5]}
        against.check(lakes(155, 130, 990 if k % 2 else 0), 17, k, *HEIGHTS[k % 6], **more)
        against.check(made("holes", 40, 31, k), 17, k, *HEIGHTS[k % 6], **more)


FALL = np.argmax(-0.02 / np.arange(25, 901, 25) - np.arange(25, 901, 25) / (2 * RADIUS)) * 25 + 25  # the sea is in sight up to there
CREST = 147 / 1.45  # behind the wall, which falls by 15 m in 10 m, targets of 2 m are hidden from an eye at 20 m where 17 - 1.5 (t - 100) = 20 - 0.05 t


@pytest.mark.parametrize("members, ways, behind", [
    ({"height": 2}, (250, 200, 900, 100), 0), ({"height": 2, "max_distance": 300}, (250, 200, 300, 100), 0),
    ({"height": 20, "target": 2}, (250, 200, 900, CREST), 400**2 - 360**2), ({"height": 0.02, "curvature": 1}, (250, 200, FALL, 100), 0)])
def test_sums_and_farthest_places(lands, members, ways, behind):
    """Of a plain in feet with a wall in the west, seen along four directions: the distances in sight, and what is in sight beyond the wall."""
    z = np.zeros((47, 61))
    z[:, 30] = 15 / 0.3048
    lands.land(z, MAPS[1][0])
    desc = struct("cw_visibility_desc", directions=4, every=10, **members)
    found = [lands.product(f"visibility {what}", desc, stride=61)[1, 4] for what in ("area", "share", "farthest", "azimuth")]
    seen, most = np.square(ways).sum() + behind, members.get("max_distance", 900)
    assert found == pytest.approx([np.pi / 4 * seen * 1e-6, seen / np.square(np.fmin((250, 200, 900, 400), most)).sum(), max(ways), 180], rel=1e-5)


# ---- bits -------------------------------------------------------------------------------------------------------------------

NX, NY = 203, 187


def same(found, wanted):
    """Of areas and distances."""
    return all(a.tobytes() == np.ascontiguousarray(b).tobytes() for a, b in zip(found[:2], wanted))


def elsewhere(lands, z, how, wanted, r):
    """The land amid holes, so that blocks begin elsewhere, and bounds are others."""
    i, j = r.integers(0, 40, 2)
    wide = np.full((NY + j + r.integers(0, 10), NX + i + r.integers(0, 10)), np.nan)
    wide[j:j + NY, i:i + NX] = z
    lands.land(wide)
    assert same(lands.visible(how, (i, j, NX, NY)), wanted), (how, i, j)


def test_bits_are_the_same(lands):
    """For every instruction set, on threads; for every k-th eye of some rectangle in two calls; and elsewhere."""
    r = np.random.default_rng(99)
    for number in taken(range(30), 16):
        how = *direction(r, number), 33.3 if number % 5 == 2 else 0, 1e-4 if number % 4 == 1 else 0, *HEIGHTS[number % 6]
        z = lakes(NX, NY, 990 if number % 2 else 0)
        z.flat[r.integers(0, z.size, 300)] = np.nan
        lands.land(z)
        lands.limited(1)
        wanted, sets = lands.visible(how)[:2], 0
        for isa in range(1, 6):
            if not lands.limited(isa):
                continue
            sets, pool = sets + 1, lands.threads * (isa % 2)
            assert same(lands.visible(how, pool=pool), wanted), isa
            for _ in range(4):
                i, j = r.integers(0, NX), r.integers(0, NY)
                nx, ny, every = r.integers(1, NX - i + 1), r.integers(1, NY - j + 1), 1 + r.integers(0, 2) * r.integers(0, 20)
                part = [values[j:j + ny:every, i:i + nx:every] for values in wanted]
                row = r.integers(0, len(part[0]))
                assert same(lands.visible(how, (i, j, nx, ny), every=every, row=row, pool=pool), [values[row:] for values in part])
                assert same(lands.visible(how, (i, j, nx, ny), every=every, count=row, pool=pool), [values[:row] for values in part])
        assert sets > 0
        lands.limited(0)
        elsewhere(lands, z, how, wanted, r)


def test_lakes_are_the_same_elsewhere(lands):
    """Over water that is in sight as a whole, slopes must rise after rounding, too: where crossings nearly coincide, and where curvature or a low eye
    leaves little. Blocks that begin elsewhere have other crossings amid them."""
    r, z = np.random.default_rng(17), lakes(NX, NY, 1035)
    for number in taken(range(108), 16):
        beside = (1 if number // 12 % 2 else -1) * 2.0 ** (-18 - number % 9)  # so crossings come soon after another, or before
        how = ((1 / 3, -0.5, 0.75, -1 / 7)[number % 4] + beside, 1 if number % 8 < 4 else -1, 0, (0, 1e-7, 1e-5)[number % 3],
               (2.0**-10, 2, 300)[number // 3 % 3], 0)
        lands.land(z)
        wanted = lands.visible(how)[:2]
        for _ in range(4):
            elsewhere(lands, z, how, wanted, r)


def test_slack_changes_nothing(lands):
    """Directions close to each other share bounds."""
    lands.land(lakes(NX, NY, 990))
    ways = [(-0.31 + 0.0004 * (k if k < 20 else k - 50), 1, 0, 0, 2, 0) for k in taken(range(40), 5)]  # some on each side
    wanted = [lands.visible(way)[:2] for way in ways]
    for way, one in zip(ways, wanted):
        assert same(lands.visible((*way, 2.0**-7), keep=True), one)
