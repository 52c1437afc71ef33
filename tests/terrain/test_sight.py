# SPDX-License-Identifier: Apache-2.0
"""Viewsheds and lines of sight against whole numbers over all edges, sample by sample, on land of many kinds: also where a line touches
the surface, or passes it by less than doubles can tell. On larger land most samples are held to their own lines, which are judged
elsewhere. A row of ROWS is a test; then closed forms of what the judge takes as given."""
import signal

import numpy as np
import pytest
from library import MAPS, observer
from program import DIVISOR, SLOW, taken
from test_light import rough

SIDE = 24
BITS, FEWER = 256, 64  # of heights and of coordinates behind the point

# ---- the judge --------------------------------------------------------------------------------------------------------------


def whole(numbers, bits):
    """Times 2^bits, as Python's integers; none where that is no whole number."""
    scaled = np.ldexp(np.asarray(numbers, float), bits)
    assert (scaled == np.rint(scaled)).all()
    return np.frompyfunc(int, 1, 1)(scaled)


def lowered(fall, x, y):
    return fall[0] * x * x + fall[1] * x * y + fall[2] * y * y


class Judge:
    """Looks along lines from eyes to targets, x, y, z and what stands above it: at each crossing with columns, rows and diagonals
    through samples in double, and in whole numbers where rounding leaves it open. highest is 1 if something between the ends is above
    the line, 0 if something touches it, else -1. A sample alone is ground, too."""

    def __init__(self, z, eyes, fall, targets):
        self.z, self.fall, self.targets = z, fall, np.array(targets, float).reshape(-1, 4)
        self.eyes = np.broadcast_to(np.asarray(eyes, float), (len(self.targets), 3))
        self.highest, (ny, nx), self.met = np.full(len(self.targets), -1), z.shape, []
        open = [self.look(kind, lines) for kind, lines in enumerate((np.arange(nx), np.arange(ny), np.arange(1 - ny, nx)))]
        for kind, (target, n) in enumerate(open):
            left = self.highest[target] < 1
            self.decide(kind, target[left], n[left])

    def ground(self, i, j):
        """Samples, NaN where there are none."""
        inside = (i >= 0) & (j >= 0) & (i < self.z.shape[1]) & (j < self.z.shape[0])
        return np.where(inside, self.z[np.where(inside, j, 0), np.where(inside, i, 0)], np.nan)

    def ends(self, kind, n, step):
        """The two samples beside a place on the line, step cells along it."""
        return [[(n, m), (m, n), (m, m - n)][kind] for m in (step, step + 1)]

    def look(self, kind, n):
        """Targets and lines about which a crossing leaves something open. Where a way crosses lines by a thousandth of a cell in all, its
        places are too uncertain; elsewhere they are right to 10^-11, and heights below 10^5 to 10^-6."""
        (ex, ey, ez), (x, y, z, above) = (columns.T[..., None] for columns in (self.eyes, self.targets))
        start, across = [(ex, x - ex), (ey, y - ey), (ex - ey, x - y - (ex - ey))][kind]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (n - start) / across
            place = ey + share * (y - ey) if kind == 0 else ex + share * (x - ex)
            vague = (np.abs(across) < 1e-3) & (np.abs(n - start) < 2e-3)
            met = ~vague & (np.abs(across) >= 1e-3) & (share > -1e-3) & (share < 1 + 1e-3)
            place = np.where(met, place, 0)
            step = np.floor(place).astype(int)
            a, b = (self.ground(i, j) - ez - lowered(self.fall, i - ex, j - ey) for i, j in self.ends(kind, n + 0 * step, step))
            off = a + (place - step) * (b - a) - share * (z + above - ez - lowered(self.fall, x - ex, y - ey))
            near = np.abs(place - np.rint(place)) < 1e-6
            self.met.append((np.where(met & (share > 0) & (share < 1), share, 2), off, vague | met & near & (place != np.rint(place))))
            open = met & ((np.abs(share - 0.5) > 0.499) | near | (np.abs(off) < 1e-4))
            self.highest[(met & ~open & (off > 0)).any(1)] = 1
        target, line = np.nonzero(vague | open)
        return target, n[line]

    def check_places(self, blocks):
        """Where lines are blocked, in double: at a crossing that is not below the line or, between neighbours, where the surface rises through
        it, and nothing before stands above it. Without lines that pass samples by a hair. The number of lines."""
        share, off, hair = (np.concatenate(parts, 1) for parts in zip(*self.met))
        share, off = (np.take_along_axis(of, np.argsort(share, 1), 1) for of in (share, off))
        after, lines = (share < blocks[:, None] - 1e-9).sum(1), np.flatnonzero((blocks < np.inf) & ~hair.any(1))
        for k in lines:
            n, s = after[k], np.append(share[k], 2)
            there = off[k, np.abs(share[k] - blocks[k]) < 1e-9]
            assert not (off[k, :n] > 1e-4).any(), k
            if len(there):
                assert np.nanmax(there) > -1e-4, k
            elif n > 0:
                at = (blocks[k] - s[n - 1]) / (s[n] - s[n - 1])
                assert abs((1 - at) * off[k, n - 1] + at * off[k, n]) < 1e-4, k
        return len(lines)

    def decide(self, kind, target, n):
        """The same for one crossing each, exactly."""
        eye, to, lines = whole(self.eyes[target, :2], FEWER), whole(self.targets[target, :2], FEWER), whole(n, FEWER)
        start, end = ([of[:, kind] if kind < 2 else of[:, 0] - of[:, 1] for of in (eye, to)])
        sign = np.where(end < start, -1, 1)
        way, across = (lines - start) * sign, (end - start) * sign
        met = (way > 0) & (way < across)
        target, n, way, across, eye, to = (of[met] for of in (target, n, way, across, eye, to))
        along, unit = 1 if kind == 0 else 0, across << FEWER
        place = eye[:, along] * across + way * (to[:, along] - eye[:, along])
        step = place // unit
        part = place - step * unit  # of a cell
        heights, there = [], np.ones(len(target), bool)
        (ex, ey, ez), (x, y, z, above) = self.eyes[target].T, self.targets[target].T
        for (i, j), counts in zip(self.ends(kind, n, step.astype(int)), (there, part > 0)):
            ground = self.ground(i, j)
            there = there & (~counts.astype(bool) | np.isfinite(ground))
            ground = np.where(np.isfinite(ground), ground, 0)
            heights.append(whole(ground, BITS) - whole(ez, BITS) - whole(lowered(self.fall, i - ex, j - ey), BITS))
        top = whole(z, BITS) + whole(above, BITS) - whole(ez, BITS) - whole(lowered(self.fall, x - ex, y - ey), BITS)
        over = heights[0] * unit + part * (heights[1] - heights[0]) - ((way * top) << FEWER)
        np.maximum.at(self.highest, target[there], np.sign(over[there]).astype(int))


# ---- land and observers -------------------------------------------------------------------------------------------------------


def land(height, nx, ny, *shape):
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    return height(i, j, *shape) + 0.0 * i


def slope_of_whole_numbers(r, nx, ny):
    """Some samples in a plane, the others far below it, a few above it and holes; the plane."""
    slope = r.integers(0, 5, 3) - [2, 2, 0]
    kind, plane = r.integers(0, 100, (ny, nx)), land(lambda i, j: slope[0] * i + slope[1] * j + slope[2], nx, ny)
    return np.select([kind == 0, kind < 4, kind < 40], [np.nan, plane + 1, plane], plane - 50), slope


def small_land(n, r):
    """On a sample, on a border, anywhere, outside; with curvature 3000, that it be seen on a few hundred metres."""
    place, size = n % 6, n // 6
    nx, ny = [(2, 2), (3, 17), (23, 9), (41, 38)][size % 4]
    z = rough(size // 4 % 6, r, nx, ny).astype("f4")
    at = r.uniform(-30, 60, 2) if place == 3 else r.uniform(0, [nx - 1, ny - 1])
    at = np.floor(at) if place in (0, 5) else [np.floor(at[0]), at[1]] if place == 1 else at
    i, j = np.floor(at).astype(int)
    absolute = place == 3 or np.isnan(z[j:j + 2, i:i + 2]).any()
    return z, MAPS[(size + size // 4) % 4][0], dict(
        place=at, height=r.uniform(0.5, 30) + 20 * absolute, absolute=absolute, target=r.uniform(0, 10) * (place % 2),
        farthest=r.uniform(20, 200) * (place == 4), curvature=[0, 0, 0, 6 / 7, 0, 3000][place])


def large_land(n, r):
    """With everything that bounds pass over."""
    return rough(0, r, 200, 197), MAPS[0][0], dict(place=r.uniform(0, [199, 196]), height=r.uniform(1, 40), absolute=0, curvature=n)


def spike_beside_eye(n, r):
    """It hides what its edges cross, though they end at the eye's own row or column, a hair beside it, or behind it."""
    eyes = [(20.2, 20), (20, 20.2), (19.8, 20), (20, 19.8), (20.3, 20.6), (20 + 1e-10, 20.3), (20.3, 20 - 1e-10), (20 + 1e-12, 20 + 1e-12),
            (20.3, 20.3 + 1e-13)]
    return land(lambda i, j: 1000.0 * ((i == 19 + n % 3) & (j == 19 + n // 3 % 3)), 41, 41), MAPS[0][0], dict(place=eyes[n // 9], height=5)


def behind_a_tip(n, r):
    """A bowl around the eye, ever steeper outward, and a spike close by. The tip of the spike alone hides what is behind it: its flanks, a hair
    to the side, do not."""
    def height(i, j):
        ring = np.maximum(np.abs(i - 20.3), np.abs(j - 20.2))
        return np.where(ring >= 2.5, ring * (100 / 0.7 - 0.1 + 0.001 * ring), np.where((i == 21) & (j == 20), 100, -1000))
    return land(height, 41, 41), MAPS[0][0], dict(place=(20.3, 20.2), height=0)


def behind_a_lone_sample(n, r):
    """Without edges, among holes: it hides what is exactly behind it."""
    z = np.zeros((31, 41))
    z[9:12, 11:14] = np.nan
    z[10, 12] = 100
    return z, MAPS[0][0], dict(place=[(4, 10), (8, 8), (12, 2), (9, 7), (16, 12), (15, 13)][n], height=5)


def in_a_plane(n, r):
    z, slope = slope_of_whole_numbers(r, SIDE, SIDE - n % 5)
    place = 0.5 * r.integers(0, 2 * (SIDE - 5), 2)
    return z, MAPS[0][0], dict(place=place, height=slope[2] + place @ slope[:2], target=0.5 * (n % 3 == 2))


def ridges(i, j, across, down, kind):
    """A plane, and which ridges come up to it: all, columns, rows, oblique ones."""
    return across * i + down * j - 10 * ([0 * i, i, j, i + 2 * j][kind] % 4 != 0)


def last_digits(n, r):
    """With the eye in that plane: but for the rounding of the eye's height and the samples', all are ties, and the last digits decide."""
    across, down = r.uniform(-1, 1, 2) if n % 2 else (0.5, 0.25)
    x, y = r.uniform(-3, SIDE + 3, 2)
    y = np.floor(y) if n % 3 == 0 else y
    x = np.floor(x) + 1e-12 if n % 6 == 3 else x  # within rounding of a row: what is between eye and row counts
    return land(ridges, SIDE, SIDE, across, down, 3), MAPS[0][0], dict(place=(x, y), height=across * x + down * y, curvature=n % 5 == 4)


def large_ties(n, r):
    x, y = r.uniform([40, 30], [80, 60])
    return land(ridges, 150, 90, 0.5, 0.25, n % 4), MAPS[0][0], dict(place=(x, y), height=0.5 * x + 0.25 * y)


def shore(n, r):
    """Land on one side of a line of samples along x, along y or a diagonal, with holes on its other side or where the raster ends; and an eye
    that is next to the line, on either side or on it."""
    kind, after, on_holes, thin = r.integers(0, 3), r.random() < 0.5, r.random() < 2 / 3, 3
    nx, ny = [(90, thin), (thin, 90), (SIDE, SIDE)][kind]
    line = r.integers(-2, 3) if kind == 2 else 1 if on_holes else 0 if after else thin - 1
    side = land(lambda i, j: [j, i, j - i][kind] - line, nx, ny) * (1 if after else -1)
    place = r.uniform(-2, [nx + 1, ny + 1])
    off = r.choice([-1, 1]) * 2.0**-r.integers(18, 61)
    place[kind == 0 or kind == 2] = place[0] + line + off if kind == 2 else line + off * (n % 8 != 7)
    return np.where(side < 0, np.nan, r.uniform(0, 10, (ny, nx))), MAPS[0][0], dict(
        place=place, height=10 * r.uniform(-0.2, 1.5), curvature=n % 7 == 6)


NX, NY = 330, 250


def wide_land(n, r):
    """Also from under the ground, and with targets in it."""
    place = r.uniform(0, [NX - 1, 12])
    return rough(n // 5, r, NX, NY), MAPS[0][0], dict(
        place=np.floor(place) if n % 2 else place, height=[50, 60, 70, 80, -3][n % 5], target=[0, 0, 3, -1, 0][n % 5], curvature=100 * (n % 5 == 2))


def steps(n, r):
    """Steps and lakes: many edges on one line, whose pieces of the skyline become one."""
    size, turn, phase = r.uniform(0.02, [0.06] * 4 + [0.4] * 8), r.uniform(0, 6.3, 12), r.uniform(0, 6.3, 12)
    waves = sum(land(lambda i, j: np.sin(s * np.cos(t) * i + s * np.sin(t) * j + p), NX, NY) / (1 + 20 * s) for s, t, p in zip(size, turn, phase))
    place = r.uniform(0, [NX - 1, NY - 1])
    return (2000 if n % 3 == 0 else 100) * np.maximum(waves, -0.4), MAPS[0][0], dict(
        place=np.floor(place) if n % 4 else place, height=0.5 if n % 2 else 2, absolute=0)


def behind_a_joined_piece(n, r):
    """A dam as high as the eye in row 16, then a cliff, and a shore at that height again in the last two rows, whose end is a tower before the
    cliff. An edge of the shore joins an edge of the dam, as both are on one line as seen from the eye, and the dam's piece of the skyline is
    gone. Bins of directions farther right must not look for the cliff from that piece. There are enough bins from row 257 on."""
    def height(i, j):
        behind = np.where(j < 257, -100, np.where(i < 15, 0, np.where(i < 38, -100, 3000)))
        return np.where((j == 16) & (i >= 10), np.where(i < 12, 0, 500), behind)
    return land(height, 43, 259), MAPS[0][0], dict(place=(9.75, 0), height=0)


def towers_at_an_end(n, r):
    """Level strips with towers along one side: the last of a row's bins, of a sample or three, is often hidden, and the bin beyond the row's end is
    not. In the first a tower of 1 m behind one of 32 m took the place of a higher piece of the skyline."""
    nx, ny = (21, 600) if n == 0 else (r.integers(5, 35), 600)
    z = np.where(r.random((ny, nx)) < 1 / r.integers(10, 110), 2.0 ** r.integers(0, 12, (ny, nx)), 0) * (np.arange(nx) > nx - 10)
    place = np.array([7, 75]) if n == 0 else r.integers(0, [nx, ny])
    if n == 0:
        z[:], z[435, 18], z[453, 19], z[474, 18] = 0, 8, 32, 1
    height = 12 if n == 0 else z[place[1], place[0]] + 2 + 10 * r.integers(3)
    z, place = (z, place) if n % 2 == 0 else (z.T, place[::-1])
    return z, MAPS[0][0], dict(place=place, height=height, absolute=1, target=1.5 * (n % 3 == 0))


# ---- the rows -----------------------------------------------------------------------------------------------------------------


def by_judge(lands, z, map, how, eye, fall, targets, seen, need):
    """Nothing is above the line to what is needed and a little more, and something is above that to a little less; both by more than floats
    and the search's rounding leave open. An edge may be so near to the eye that its share of the way, known to 2^-49, is far below 1.
    Returns how many lines touch something."""
    highest, bare = (Judge(z, eye, fall, rows).highest for rows in (targets, targets * [1, 1, 1, 0]))
    assert (seen == (highest < 0)).all() and ((need > 0) == (bare > 0)).all()
    block = lands.table("sights", np.hstack([np.broadcast_to([*eye, how.get("curvature", 0)], (len(targets), 4)), targets]))[:, 0]
    assert ((block < np.inf) == (bare >= 0)).all()
    some = (targets[:, :2].sum(1).astype(int) % 4 == 0) & (need <= 1e6 * map[2][2])
    needed = need[some] / map[2][2]
    slack = 1e-5 + 1e-6 * needed
    more, less = (Judge(z, eye, fall, np.column_stack([targets[some, :3], needed + off])).highest for off in (slack, -slack))
    assert (more <= 0).all() and ((less >= 0) | (needed <= slack)).all()
    return (highest == 0).sum()


def by_lines(lands, z, map, how, eye, fall, targets, seen, need):
    """Needs that are read off the skyline are those of the lines to 2^-17 m, and the same floats where those are coarser."""
    rows = np.hstack([np.broadcast_to([*eye, how.get("curvature", 0)], (len(targets), 4)), targets])
    _, sees, right, steepest = lands.table("sights", rows).T
    right = right.astype("f4").astype(float)
    assert (seen == (sees == 1)).all() and (np.abs(need - right) <= 2.0**-17).all()
    x, y, height, _ = targets.T
    base = height - eye[2] - lowered(fall, x - eye[0], y - eye[1])
    assert (np.abs(np.maximum(steepest - base, 0) - right) <= 2.0**-17 + 1e-6 * right).all()
    return 0


def check_view(lands, case, some, r, check):
    """About so many samples of a viewshed, evenly; all if that is 0. Returns how many are seen, touched, hidden and need much."""
    z, map, how = case
    z = lands.land(z, map).astype(float)
    seen, needs, eye, fall = lands.round(**how)
    x, y = np.meshgrid(np.arange(z.shape[1]), np.arange(z.shape[0]))
    away, most = np.hypot(*(map[c][0] * (x - eye[0]) + map[c][1] * (y - eye[1]) for c in range(2))), how.get("farthest", 0)
    lost, own = np.isnan(z) | ((most > 0) & (away > most)), away == 0
    clear = (most == 0) | (np.abs(away - most) >= 1e-6)
    assert (seen[lost & clear] == 0).all() and np.isnan(needs[lost & clear]).all()
    assert (seen[own & ~lost] == 1).all() and (needs[own & ~lost] == 0).all()
    every = z.size // some + 1 if some else 1
    at = np.flatnonzero(clear & ~lost & ~own & ((np.arange(z.size) - r.integers(every)) % every == 0).reshape(z.shape))
    targets = np.column_stack([of.flat[at] for of in (x, y, z)] + [np.full(len(at), how.get("target", 0) / map[2][2])])
    seen, needs = seen.flat[at] == 1, needs.flat[at].astype(float)
    touched = check(lands, z, map, how, eye, fall, targets, seen, needs) if len(at) > 0 else 0
    return np.array([seen.sum(), touched, (~seen).sum(), (needs > 1024).sum()])


# Cases, of which one in so many at least is taken where time is short; how they are checked, and how many samples of a case, 0 for all; how many
# of all must be seen, touched, hidden and need much for the test to mean something.
ROWS = {small_land: (576, 48, by_judge, 80, 1500, 0, 1500, 0), large_land: (4, 2, by_judge, 1000, 50, 0, 250, 0),
        spike_beside_eye: (81, 7, by_judge, 280, 2500, 0, 250, 0), behind_a_tip: (1, 1, by_judge, 0, 50, 0, 0, 0),
        behind_a_lone_sample: (6, 3, by_judge, 0, 1000, 0, 3, 0), in_a_plane: (60, 8, by_judge, 575, 1000, 1000, 1000, 0),
        last_digits: (30, 4, by_judge, 575, 500, 0, 500, 0), shore: (80, 16, by_judge, 0, 800, 0, 200, 0),
        wide_land: (30, 10, by_lines, 3000, 2000, 0, 2000, 0), large_ties: (16, 16, by_lines, 1500, 0, 0, 500, 0),
        steps: (25, 24, by_lines, 5000, 500, 0, 500, 500), behind_a_joined_piece: (1, 1, by_lines, 0, 50, 0, 50, 0),
        towers_at_an_end: (100, 50, by_lines, 0, 2000, 0, 2000, 0)}


@pytest.mark.parametrize("row", ROWS)
def test_every_sample(lands, row):
    cases, step, check, samples, *least = ROWS[row]
    found, short = np.zeros(4, int), min(DIVISOR * SLOW, 10) if cases > 1 and samples else 1
    for n in taken(range(cases), step):
        r = np.random.default_rng([2024, n])
        found += check_view(lands, row(n, r), samples // short, r, check)
    assert (found >= least).all() or DIVISOR * SLOW > 1, found  # a share of the cases may lack some


def test_lines_between_places(lands):
    counts, blocked = np.zeros(3, int), 0
    for number in taken(range(40), 4):
        r = np.random.default_rng([13, number])
        z, slope = slope_of_whole_numbers(r, SIDE, SIDE)
        z[3:3 + r.integers(0, 12), 5:5 + r.integers(0, 12)] = np.nan
        z = lands.land(z).astype(float)
        at = [r.uniform(0, SIDE - 1, (20, 2, 2)), 0.25 * r.integers(0, 4 * SIDE - 4, (20, 2, 2)),
              np.floor(r.uniform(0, SIDE - 1, (20, 2, 2))) + 2.0**-43 * np.array([[0], [1]])]
        at = np.rint(np.concatenate(at) * 2.0**44) * 2.0**-44  # see sight.h
        at[1::6, :, 1] = at[1::6, :, 0] + [-2.0**-40, 2.0**-40]  # all but along a diagonal
        at = at[(at[:, 0] != at[:, 1]).any(1)]
        ends = np.dstack([at, slope[2] + at @ slope[:2]])
        judge = Judge(z, ends[:, 0], np.zeros(3), np.column_stack([ends[:, 1], np.zeros(len(ends))]))
        highest = judge.highest
        blocks = lands.table("sights", np.column_stack([ends[:, 0], np.zeros(len(ends)), ends[:, 1], np.zeros(len(ends))]))[:, 0]
        assert ((blocks < np.inf) == (highest >= 0)).all()
        blocked += judge.check_places(blocks)
        counts += np.bincount(highest + 1, minlength=3)
    assert (np.append(counts, blocked) * min(DIVISOR * SLOW, 4) > 40).all(), (counts, blocked)


# ---- closed forms ---------------------------------------------------------------------------------------------------------------


def test_first_blocks(lands):
    """A wall's flank rises from 0 at row 9 to 40 at row 10: the line at 20 m meets it halfway, the one at 41 m passes."""
    lands.land(land(lambda i, j: 40.0 * (j == 10), 20, 100))
    rows = [[7.5, 2, 20, 0, 7.5, 82, 20, 0], [7.5, 2, 20, 0, 7.5, 8, -20, 0], [7.5, 2, 20, 0, 7.5, 82, 20 + 20 * 10 + 11, 0]]
    np.testing.assert_allclose(lands.table("sights", rows)[:, 0], [7.5 / 80, 0.5, np.inf], atol=1e-12)


def test_the_horizon_of_the_sea(lands):
    """On a sphere an eye at height h sees the ground up to sqrt(2 R h), in the parabola that stands for it here. Between samples the ground is
    lower than the parabola by at most a diagonal squared over 8 R, and something d beyond the farthest visible place is hidden by d² / 2 R, so
    that nothing is seen from d = 7.1 m on."""
    lands.land(np.zeros((200, 200)))
    seen, _, _, _ = lands.round((100, 100), 0.03, absolute=0, curvature=6 / 7)
    away, far = 10 * np.hypot(*np.meshgrid(np.arange(200) - 100, np.arange(200) - 100)), np.sqrt(2 * 6378137 * 7 / 6 * 0.03)
    assert 500 < far < 900 and (seen[away < far] == 1).all() and (seen[away > far + 7.2] == 0).all()


@pytest.mark.parametrize("along, length, wide, height, high, product", [
    (0, 40000, 2, 7, 5, "viewshed needed"), (1, 40000, 2, 7, 5, "viewshed needed"), (0, 800000, 6, 3000, 0.02, "viewshed seen")])
def test_a_strip_is_no_square(lands, along, length, wide, height, high, product):
    """Where every sample stands beside a hole, one way after the other to the eye would take the square of the length: ten minutes here, and
    half a second now. So would, from high up, a skyline that keeps all that was seen beside the strip: nine minutes, and three seconds."""
    signal.alarm(120)
    z = np.random.default_rng(along).uniform(0, high, (length // min(DIVISOR * SLOW, 8), wide))
    z[:, 1] = np.nan if wide == 2 else z[:, 1]
    z = lands.land(z.T if along else z).astype(float)
    found = lands.product(product, observer(0, 0, height, absolute=1), "f4" if product == "viewshed needed" else "u2")
    z, found = (of[0] if along else of[:, 0] for of in (z, found))
    k, over = np.arange(1, len(z)), z[1:] - height
    steepest = np.maximum.accumulate(np.append(-np.inf, over / k))[:-1]
    needed = np.maximum(steepest * k - over, 0)
    assert (found[1:] == (needed == 0) if product == "viewshed seen" else np.abs(found[1:] - needed) <= 1e-6 * (1 + needed)).all()
    signal.alarm(0)
