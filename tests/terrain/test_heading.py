# SPDX-License-Identifier: Apache-2.0
"""Headings: the steepest rise from every sample, against all edges of the field one by one in double; the same bits for every instruction set,
number of threads and rectangle; whether a ray hits, and how steep the rise is, said alike."""
import contextlib
import functools
from mmap import PAGESIZE

import numpy as np
import pytest
from library import ARGUMENT, KERNEL, Room
from program import taken, takes
from test_visible import SHAPES, SIZES, crossings, direction, lakes, made, samples_along

INF = np.inf
crossings = functools.cache(crossings)


class Headings:
    """On a field, with a reach and a drop."""

    def __init__(self, library, z, run=None):
        self.library, self.z = library, np.asarray(z, "f4")
        self.field, self.all = library.field(z, run=run), (0, 0, *self.z.shape[::-1])

    @contextlib.contextmanager
    def along(self, dir, **ends):
        desc = self.library.struct("cw_heading_desc", dir=dir, **ends)
        heading = int(self.library.well("cw_heading_create", self.field, desc, Room("u8"))[0])
        yield heading
        self.library.call("cw_heading_destroy", heading)

    def steepest(self, heading, low=-INF, high=INF, at=None, run=None):
        at = np.array(at or self.all, "u8")
        found = self.library.well("cw_heading_steepest", heading, run, float(low), float(high), at, Room("f4", int(at[2] * at[3])))
        return found.reshape(at[3], at[2])

    def occluded(self, heading, slope, run=None):
        found = self.library.well("cw_heading_occluded", heading, run, float(slope), np.array(self.all, "u8"), Room("u1", self.z.size))
        return found.reshape(self.z.shape)


def between_gaps(library, z):
    """A field whose rows are the caller's and end where memory ends: no answer may need more."""
    (ny, nx), page = z.shape, 2 * PAGESIZE
    at = library.number("pages", page * ny) + PAGESIZE - 4 * nx
    for j in range(ny):
        library.call("poke", at + page * j, z[j].astype("f4"))
        assert library.number("forbid", at + page * j + 4 * nx, PAGESIZE) == 0
    return library.field(z, stride=page // 4, storage=1, samples=at)


def brute(z, i, j, dx, dy, reach=0, drop=0):
    """The steepest rises from samples, and what they may be off by: 2^-21 of the steeper of the rises to an edge's samples."""
    t, edges, f = crossings(dx, dy, sum(z.shape))
    near = (t <= reach) | (reach == 0)
    t, f = t[near][:, None], f[near][:, None]
    one, other = (heights.astype(float) - z[j, i] for heights in samples_along(z, i, j, *edges[:, near]))
    slope = (one + f * (other - one)) / t - drop * t
    error = np.where(np.isnan(slope), 0, 2.0**-21 * np.maximum(np.abs(one), np.abs(other)) / t + 2.0**-23 * drop * t)
    return np.fmax.reduce(slope, 0, initial=-INF), np.max(error, 0, initial=0)


def check_samples(z, slopes, some, dir, **ends):
    i, j = some % z.shape[1], some // z.shape[1]
    wanted, allowed = brute(z, i, j, *dir, **ends)
    got = slopes[j, i].astype(float)
    with np.errstate(invalid="ignore"):
        good = np.where(np.isnan(z[j, i]), np.isnan(got), (got == wanted) | (np.abs(got - wanted) <= allowed + 2.0**-140))
    assert good.all(), (z.shape, dir, ends, some[~good][:3], got[~good][:3], wanted[~good][:3])


def check_against_brute(library, z, seed, **ends):
    """Without bounds, where nothing is passed over, the bits are the same from every sample."""
    r, land = np.random.default_rng(seed), Headings(library, z)
    bare = Headings(library, z, library.run(kernel="cell"))
    for number in range(20):
        dir = direction(r, number)
        if not takes(number, 10):
            continue
        with land.along(dir, **ends) as heading, bare.along(dir, **ends) as plain:
            slopes = land.steepest(heading)
            assert slopes.tobytes() == bare.steepest(plain).tobytes()
        n = slopes.size
        check_samples(land.z, slopes, np.arange(n) if n <= 200 else r.choice(n, 200), dir, **ends)


@pytest.mark.parametrize("shape", [shape for shape in SHAPES if shape not in ("huge", "mixed")])  # whose slopes are no floats
def test_every_edge_counts(library, shape):
    for k, (nx, ny) in enumerate(SIZES):
        check_against_brute(library, made(shape, nx, ny, 7 + k), k)


@pytest.mark.parametrize("nx", [17, 33, 49])
def test_walls_on_the_border_count(library, nx):
    """A wall on the far border, 16 k columns from the first one. By rounding its crossing may be the first one of the next stretch, of whose
    samples no other lies in the field."""
    z, r = made("random", nx, 30, nx), np.random.default_rng(nx)
    z[:, -1] += 4 * nx
    land = Headings(library, z)
    for angle in taken(r.uniform(-0.7, 0.7, 40), 4):
        dir = np.cos(angle), np.sin(angle)
        with land.along(dir) as heading:
            check_samples(land.z, land.steepest(heading), np.arange(0, 30 * nx, 16), dir)


@pytest.mark.parametrize("nx, ny", [(255, 256), (1000, 60), (230, 150)])
def test_stretches_are_passed_over_rightly(library, nx, ny):
    z = lakes(nx, ny, 0)
    if nx == 230:  # single high samples in level land are what a bound must not miss
        z[:] = 0.375
        z.flat[(np.arange(4) * 9001 + 77) % z.size] += 4 + np.arange(4)
    check_against_brute(library, z, nx)


@pytest.mark.parametrize("k", range(1, 12))
def test_ends_and_curvature_count(library, k):
    """Headings that end after some cells, on an earth that is flat, a little curved, and as round as a ball. No crossing lies within rounding of
    these ends."""
    if takes(k, 4):
        ends = {"reach": [0, 0.3137, 5.2713, 61.317][k % 4], "drop": [0, 1e-4, 0.05][k // 4]}
        check_against_brute(library, lakes(255, 130, 0), 20 + k, **ends)
        check_against_brute(library, made("holes", 40, 31, k), 40 + k, **ends)


@pytest.mark.parametrize("first, ends", [(0, {}), (5, {"drop": 0.001}), (10, {"drop": 0.001, "reach": 33})])
def test_bits_are_the_same(library, first, ends):
    """For every instruction set, threads and ways to cut the field up."""
    nx, ny, r, z = 203, 187, np.random.default_rng(99 + first), lakes(203, 187, 0)
    z.flat[r.choice(z.size, 300)] = np.nan
    land, pool = Headings(library, z), library.pool(3)
    land.field = between_gaps(library, z)
    for number in range(24):
        dir, wanted = direction(r, number), None
        if not takes(first + number, 16):
            continue
        with land.along(dir, **ends) as heading:
            for isa in range(1, 6):
                if not library.limited(isa):
                    continue
                run = library.run(pool=pool if isa % 2 else 0)
                slopes = land.steepest(heading, run=run)
                wanted = slopes if wanted is None else wanted
                assert slopes.tobytes() == wanted.tobytes()
                threshold = wanted.flat[r.choice(wanted.size)]  # equal to one: a touch is a hit
                if not np.isfinite(threshold):
                    continue
                assert (land.occluded(heading, threshold, run) == (wanted >= threshold)).all()
                low, high = np.float32(-0.5), max(threshold, np.float32(-0.5))  # told apart from low to high
                assert land.steepest(heading, low, high, run=run).tobytes() == np.where(
                    np.isnan(wanted), wanted, np.clip(wanted, low, high)).tobytes()
                i, j = int(r.integers(nx)), int(r.integers(ny))
                wide, tall = int(r.integers(1, nx - i + 1)), int(r.integers(1, ny - j + 1))
                assert land.steepest(heading, at=(i, j, wide, tall), run=run).tobytes() == wanted[j:j + tall, i:i + wide].tobytes()
            library.call("cw_isa_limit", 0)


def test_rounding_above_both_samples_counts(library):
    """From the first sample, at -2^23, the ray along (1, 3/4) crosses one edge, at t = 5, three quarters of the way from a to a + 2. Both rise from
    the start by a tie, which rounds to 2^24 + 4: up from a, down from a + 2. With the step along the edge the rise is 2^24 + 6, above that to
    the higher sample. A bound that leaves rounding out passes the stretch over."""
    z = np.full((16, 20), np.nan)
    z[0, 0], z[3, 5], z[4, 5] = -2.0**23, 2.0**23 + 3, 2.0**23 + 5
    known = np.float32(2**24 + 4) / np.float32(5)  # the rise to the higher sample: anything steeper counts
    land = Headings(library, z)
    with land.along((1, 0.75)) as heading:
        for isa in range(1, 6):
            library.call("cw_isa_limit", isa)
            assert land.steepest(heading, known)[0, 0] == known + np.float32(0.5)


def test_misuse_is_refused(library):
    land = Headings(library, made("random", 5, 4, 1))
    for wrong in [{"dir": (0, 0)}, {"dir": (np.nan, 1)}, {"dir": (1, INF)}, {"dir": (2.0**41, 0)}, {"dir": (2.0**-41, 0)}, {"reach": -1}, {"drop": -1},
                  {"reach": INF}, {"drop": 2.0**80}]:
        status, _, heading = library.asked("cw_heading_create", land.field, library.struct("cw_heading_desc", **{"dir": (1, 0), **wrong}), Room("u8"))
        assert (status, heading[0]) == (ARGUMENT, 0), wrong
    with land.along((1, 0)) as heading:
        for status, low, high, at, run in [(ARGUMENT, 1, 0, land.all, None), (ARGUMENT, -INF, INF, (1, 0, 5, 4), None),
                                           (ARGUMENT, -INF, INF, (0, 2**64 - 1, 5, 4), None), (KERNEL, 0, 1, land.all, library.run(kernel="packet99"))]:
            library.fails(status, "cw_heading_steepest", heading, run, float(low), float(high), np.array(at, "u8"), Room("f4", 20))
        land.steepest(heading, at=(5, 4, 0, 0))
        assert (land.occluded(heading, -INF) == [1, 1, 1, 1, 0]).all()  # the last column sees nothing
        assert not land.occluded(heading, INF).any()
