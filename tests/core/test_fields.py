# SPDX-License-Identifier: Apache-2.0
"""Fields: what can be one; samples that are borrowed, or change; memory; and that the caller's floating-point environment changes no bit of a
field's or of an answer."""
import itertools
import os

import numpy as np
import pytest
from library import ARGUMENT, HIT, OK, RAY, SAMPLE, STRUCTS, USER_RAY, Room, random_rays
from program import takes

ALL = 2**64 - 1


def create(library, **members):
    """The status; only without an error there is a field."""
    status, error, made = library.asked("cw_field_create", library.struct("cw_field_desc", **members), None, Room("u8"))
    assert (made[0] == 0) == (status != OK)
    if status == OK:
        library.call("cw_field_destroy", int(made[0]))
    return status


def test_sizes(library):
    z, most = library.keep(np.zeros(12, "f4")), 1 << 23
    for nx, ny, stride, storage, status in [
            (3, 2, 0, 0, OK), (3, 2, 6, 0, OK), (3, 2, 0, 2, ARGUMENT), (46341, 46341, 0, 0, ARGUMENT),  # the first square above 2^31
            (3, 2, 2, 0, ARGUMENT), (3, 2, 2**62, 0, ARGUMENT), (3, 2, ALL, 0, ARGUMENT), (3, 2, 2**31, 1, ARGUMENT),
            *((nx, ny, 0, 0, ARGUMENT) for side in (0, 1, most + 1, 2**63, ALL) for nx, ny in ((side, 2), (3, side), (side, side)))]:
        assert create(library, samples=z, nx=nx, ny=ny, stride=stride, storage=storage) == status, (nx, ny, stride, storage)
    for threads in 4097, 4000000000, 2**32 - 1:
        status, _, pool = library.asked("cw_pool_create", threads, Room("u8"))
        assert status == ARGUMENT and pool[0] == 0
    pool = int(library.well("cw_pool_create", 0, Room("u8"))[0])
    assert library.number("cw_pool_threads", pool) == min(len(os.sched_getaffinity(0)), 4096) and library.number("cw_pool_threads", None) == 1
    for destroy, made in ("cw_pool_destroy", pool), *((f"cw_{what}_destroy", None) for what in ("pool", "field", "heading", "terrain", "visible")):
        library.call(destroy, made)
    for threads in 0, 4097:
        tasks = library.struct("cw_tasks", threads=threads, run=library.number("run_tasks"))
        assert library.asked("cw_pool_create_on", tasks, Room("u8"))[2][0] == 0


def test_maps(library):
    z = library.keep(np.zeros(4, "f4"))
    rows = [(1, 0, 0, 0), (0, 0, 0, 0), (0, 0, 1, 0)], [(1, 0, 0, 0), (1, 0, 0, 0), (0, 0, 1, 0)], [(0, 0, 0, 1), (0,) * 4, (0,) * 4], np.diag((1, 1, 1e-320, 0))[:3]
    rank_two = [s * np.reshape([1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0], (3, 4)) for s in (1, 0.1)]  # whose determinants are rounded to others
    odd = [np.where(np.arange(12).reshape(3, 4) == k, bad, np.eye(3, 4)) for k in range(12) for bad in (np.nan, np.inf, -np.inf)]
    for map in *rows, *rank_two, *odd:  # a row of zeros, two equal ones, a translation alone, an inverse that overflows; what is not finite
        assert create(library, samples=z, nx=2, ny=2, map=map) == ARGUMENT, map
    assert create(library, samples=z, nx=2, ny=2, map=1e-9 * np.eye(3, 4)) == OK  # nanometres


def test_heights_and_holes(library):
    """Beyond 2^100 strict answers could overflow."""
    most, more = np.float32(2.0**100), np.nextafter(np.float32(2.0**100), np.float32(np.inf))
    for storage in range(2):
        for z, status in [((0, most, -most, np.nan), OK), ((0, more, -most, np.nan), SAMPLE), ((0, most, -np.finfo("f4").max, np.nan), SAMPLE),
                          ((0, np.nan, 1, 2), OK), ((0, -np.inf, 1, 2), SAMPLE if storage else OK)]:
            assert create(library, samples=library.keep(np.array(z, "f4")), nx=2, ny=2, storage=storage) == status, (z, storage)
    for odd in -np.inf, np.inf:
        field = library.field([[0, odd], [1, 2]])
        info = library.describe(field)
        assert (info["holes"], info["low"], info["high"]) == (1, 0, 2)
        assert np.isnan(library.peek(library.number("cw_field_row", field, 0), "f4", 2)[1])
    info = library.describe(library.field([[np.nan] * 2] * 2))
    assert info["holes"] == 4 and info["low"] > info["high"]
    z = np.zeros((140, 200))  # in every tile of a field, which are summed up by rows of tiles
    z.flat[::37] = np.nan
    assert library.describe(library.field(z))["holes"] == np.isnan(z).sum()


def test_borrowed_and_copied(library):
    z = np.array([[1, 1, 9], [1, 1, 9]], "f4")  # 2 × 2 in rows of three
    copied, borrowed = (library.field(z, nx=2, stride=3, storage=storage, samples=address) for address in [library.keep(z)] for storage in range(2))
    assert [library.describe(f)["bytes_samples"] for f in (copied, borrowed)] == [16, 0] and library.describe(borrowed)["high"] == 1
    library.call("poke", library.number("cw_field_row", borrowed, 0), np.array([np.nan, np.nan, 9] * 2, "f4"))
    down = np.array([((0.25, 0.5, 3), 0, (0, 0, -1), np.inf)], STRUCTS["cw_ray"])
    for name, kernel, _ in library.kernels():
        run = library.run(kernel=kernel)
        for field in copied, borrowed:
            library.well("cw_field_build", field, run)
        hit, miss = (library.closest(field, down, run)[0] for field in (copied, borrowed))
        assert abs(hit["t"] - 2) <= 2.0**-22 and hit["triangle"] == 1 and miss["i"] == -1, name


def test_memory_is_the_callers(library):
    """All that a field holds comes from its allocator and goes back to it."""
    count = library.keep(np.zeros(1, "i8"))
    allocator = library.struct("cw_allocator", context=count, **{part: library.number(part) for part in ("allocate", "release")})
    held, side, samples = {}, 1025, library.keep(np.zeros((1025, 1025), "f4"))
    for name, kernel, _ in library.kernels():
        desc = library.struct("cw_field_desc", nx=side, ny=side, samples=samples, allocator=library.keep(allocator))
        field = int(library.well("cw_field_create", desc, library.run(kernel=kernel), Room("u8"))[0])
        library.call("poke", int(desc["allocator"][0]), np.zeros_like(allocator))  # it was copied
        heading = int(library.well("cw_heading_create", field, library.struct("cw_heading_desc", dir=(1, 0.5)), Room("u8"))[0])
        held[name] = library.call("peek", count, Room("i8"))[1][0]
        library.call("cw_heading_destroy", heading)
        library.call("cw_field_destroy", field)
        assert library.call("peek", count, Room("i8"))[1][0] == 0
    assert min(held.values()) >= 5 and held["grid3d"] == held["cell"] + 3


# ---- fields that change --------------------------------------------------------------------------------------------------------


def change(library, field, at, z=None, **more):
    """Status and error."""
    samples = 0 if z is None else library.keep(np.asarray(z, "f4"))
    return library.asked("cw_field_update", field, None, library.struct("cw_update", at=at, samples=samples, **more))


def bits(library, field):
    """All that a field shows of itself."""
    info = library.describe(field)
    rows = [library.call("peek", library.number("cw_field_row", field, j), Room("f4", info["nx"]))[1] for j in range(info["ny"])]
    return info.tobytes(), np.concatenate(rows).tobytes(), library.closest(field, random_rays(500, info["nx"], info["ny"])).tobytes()


def test_updates_that_are_refused_change_nothing(library):
    z = np.random.default_rng(4).random((65, 66)).astype("f4")
    borrowed, copied = library.field(z, storage=1), library.field(z)
    before, at, six = bits(library, copied), (7, 9, 3, 2), [1, 2, 3, 4, 5, 1.125 * 2.0**100]
    assert change(library, copied, at, six)[0] == SAMPLE and change(library, borrowed, at, six)[0] == ARGUMENT
    for wrong in [{}, {"z": six, "stride": 2}, {"z": six, "reserved": np.eye(7, dtype="u8")[2]},
                  *({"z": six, "stride": stride} for stride in (ALL, ALL // 2, ALL // 4 - 5, ALL // 8, 2**63 // 4 - 1)),  # rows that no array can hold
                  *({"z": six, "at": outside} for outside in ((63, 0, 4, 1), (0, 64, 1, 2), (67, 0, 0, 1), (ALL, 0, 2, 1), (1, 0, ALL, 1)))]:
        assert change(library, copied, **{"at": at, **wrong})[0] == ARGUMENT, wrong
    own = library.struct("cw_update", at=(0, 1, 66, 64), samples=library.number("cw_field_row", copied, 0))
    assert "own" in library.fails(ARGUMENT, "cw_field_update", copied, None, own)
    for nothing in (66, 0, 0, 1), (0, 0, 5, 0):
        assert change(library, copied, nothing, six)[0] == OK
    assert bits(library, copied) == before
    sample = library.number("cw_field_row", borrowed, 20) + 4 * 64
    for height, status in (np.inf, SAMPLE), (-1.125 * 2.0**100, SAMPLE), (z[20, 64], OK):
        library.call("poke", sample, np.array(height, "f4"))
        assert change(library, borrowed, (64, 20, 1, 1))[0] == status
    assert bits(library, borrowed)[1:] == before[1:]
    assert change(library, copied, at, [1, 2, 3, 4, 5, -np.inf])[0] == OK  # in a copy an infinity is a hole
    assert library.describe(copied)["holes"] == 1
    assert np.isnan(library.call("peek", library.number("cw_field_row", copied, 10) + 4 * 9, Room("f4"))[1])


def test_refusals_do_not_depend_on_threads(library):
    """Of several samples that are refused the first counts."""
    z, pool = np.zeros((530, 700), "f4"), library.pool(3)
    z[300, 500], z[301, 3] = np.inf, 1.125 * 2.0**100  # the second one in a tile that is looked at before
    for error in "(500, 300) is inf", "(499, 300) is -1.4":
        desc = library.desc(z, storage=1)
        for _ in range(20):
            assert error in library.fails(SAMPLE, "cw_field_create", desc, library.run(pool=pool), Room("u8"))
        z[300, 499] = -1.125 * 2.0**100


def test_fields_move(library):
    """A moved field answers as one that was made there, and keeps its map if the new one is refused."""
    z, far = np.ones((70, 70)), np.array([[2, 0, 0, 5e6], [0, 3, 0, -4e6], [0, 0, 0.5, 100]])
    moved, made = library.field(z), library.field(z, far)
    for map, wait, status in (far, 1, OK), (np.eye(3, 4) * [[1], [0], [0]], 0, ARGUMENT), (far, 2, ARGUMENT):
        assert library.asked("cw_field_move", moved, map, wait)[0] == status
    ray = np.array([((5e6 + 31, -4e6 + 77, 400), 0, (0.25, 0.5, -9), np.inf)], USER_RAY)
    hits = [library.of_each("cw_closest_user", field, ray, HIT) for field in (moved, made)]
    normals = [library.of_each("cw_hit_normals", field, hit, columns=3).tobytes() for field, hit in zip((moved, made), hits)]
    assert hits[0]["i"] >= 0 and hits[0].tobytes() == hits[1].tobytes() and normals[0] == normals[1]
    library.well("cw_field_move", moved, np.zeros((3, 4)), 0)
    assert (library.describe(moved)["map"] == np.eye(3, 4)).all()


# Columns, rows, gap between rows. The last ones are large enough for two levels above tiles.
SIZES = [(2, 2, 0), (2, 70, 3), (20, 31, 0), (65, 65, 1), (66, 64, 0), (129, 65, 7), (257, 258, 0), (40, 1500, 0), (700, 530, 13), (1300, 260, 5)]
KINDS = {
    "noise": lambda x, y, u: u, "land": lambda x, y, u: 40 * np.sin(x / 60) * np.cos(y / 90) + 0.3 * u,
    # Single ones and a lake of them; zeros of either sign.
    "holes": lambda x, y, u: np.where((u < 0.02) | ((x > 100) & (x < 300) & (y > 30)), np.nan, np.where(u < 0.1, -0.0, np.where(u < 0.2, 0.0, u))),
    "plateaus": lambda x, y, u: x // 50 + y // 70, "high up": lambda x, y, u: 1e6 + np.floor(3 * u)}  # where a float tells little apart


def heights(kind, shape, r):
    y, x = np.indices(shape)
    return KINDS[kind](x, y, r.random(shape)).astype("f4")


def each_kind(size):
    """Where time is short each size takes one kind of three, another one than the size before."""
    return [kind for k, kind in enumerate(KINDS) if takes(k + SIZES.index(size), 3)]


def some_rectangle(nx, ny, r):
    """Anywhere: mostly small, on borders, of one sample, or all."""
    most = 1500 if r.integers(4) == 0 else 40
    i, j, wide, high = r.integers(nx), r.integers(ny), r.integers(1, most + 1), r.integers(1, most + 1)
    i, j, wide, high = [(0, 0, nx, ny), (i, j, 1, 1), (i // 64 * 64, j // 64 * 64, 1, high), (0, ny - 1, wide, high), (nx - 1, j, wide, high),
                        *[(i, j, wide, high)] * 3][r.integers(8)]
    return int(i), int(j), int(min(wide, nx - i)), int(min(high, ny - j))


def inside(library, field):
    library.call("inside", field)
    return np.fromfile("inside", "u1").tobytes()


@pytest.mark.parametrize("size", SIZES)
def test_updates_give_what_is_made_anew(library, size):
    """Every byte, by any number of threads; what was lowest is raised and what was highest lowered, and some samples stay."""
    nx, ny, gap = size
    r, pools = np.random.default_rng(nx), list(map(library.pool, (1, 2, 3, 7)))
    for kind in each_kind(size):
        z = heights(kind, (ny, nx + gap), r)
        samples = library.keep(z)
        members = {"nx": nx, "stride": nx + gap, "samples": samples}
        borrowed, copied = (library.field(z, storage=storage, **members) for storage in (1, 0))
        for turn in filter(lambda turn: takes(turn, 12), range(12)):
            at, by = some_rectangle(nx, ny, r), r.uniform(-30, 30)
            part = np.s_[at[1]:at[1] + at[3], at[0]:at[0] + at[2]]
            new = heights(list(KINDS)[turn % 5], z.shape, r)[part]
            z[part] = r.integers(2) * new + np.float32(by)
            library.call("poke", samples, z)
            run = library.run(pool=pools[turn % 4])
            library.well("cw_field_update", borrowed, run, library.struct("cw_update", at=at))
            place = samples + 4 * (at[1] * (nx + gap) + at[0])
            library.well("cw_field_update", copied, run, library.struct("cw_update", at=at, samples=place, stride=nx + gap))
            anew = library.field(z, storage=turn % 2, run=library.run(pool=pools[(turn + 1) % 4]), **members)
            wanted = inside(library, anew)
            assert inside(library, borrowed) == wanted and inside(library, copied) == wanted, (kind, at)
            library.call("cw_field_destroy", library.fields.pop())


def of_nodes(take, z, side):
    """The lowest or highest sample of each node, which has those on its far border too; NaN without one."""
    for axis in 0, 1:
        first = np.arange(0, z.shape[axis] - 1, side)
        last = np.minimum(first + side, z.shape[axis] - 1)
        z = take(take.reduceat(z.take(range(z.shape[axis] - 1), axis), first, axis), z.take(last, axis))
    return z


@pytest.mark.parametrize("size", SIZES)
def test_bounds_are_those_of_the_samples(library, size):
    """Bounds that leave out a sample lose hits, which no other test shows of large nodes; bounds that are too wide only cost time. Nodes have
    exactly their lowest and highest samples, slabs above tiles have all within them: those of smaller nodes are made in float, so samples may be
    beyond them by rounding, for which rays have a pad."""
    nx, ny, gap = size
    r, leaning, kinds = np.random.default_rng(5), 0, each_kind(size)
    for kind in kinds:
        z, level, levels = heights(kind, (ny, nx), r), 0, 1
        field = library.field(z)
        while level < levels:
            across, wide, levels = map(int, library.call("bounds", field, level)[0].split())
            side, ends = 4 << 2 * level, np.fromfile("ends", "f4").reshape(2, -1, across)
            slabs = np.fromfile("slabs", "f4").reshape(-1, wide, 4).astype(float)
            high = len(slabs)
            for found, take in zip(ends, (np.fmin, np.fmax)):
                assert np.array_equal(found[:high, :wide], of_nodes(take, z, side), equal_nan=True), (kind, level)
            assert np.isnan(ends[:, high:]).all() and np.isnan(ends[:, :, wide:]).all()
            around = np.pad(np.where(np.isnan(ends[1]), -np.inf, ends[1]), 1, constant_values=-np.inf)  # the highest of nodes two by two
            ahead = np.fromfile("ahead", "f4").reshape(len(around) - 1, across + 1)
            assert (ahead == np.max([around[:-1, :-1], around[:-1, 1:], around[1:, :-1], around[1:, 1:]], 0)).all(), (kind, level)
            for y, x in np.ndindex(high, wide) if side > 64 else ():
                low, top, slope_x, slope_y = slabs[y, x]
                part = z[y * side:(y + 1) * side + 1, x * side:(x + 1) * side + 1]
                dy, dx = np.indices(part.shape) - side / 2
                above = part - slope_x * dx - slope_y * dy
                assert not ((above < low) | (above > top)).any(), (kind, level, x, y)
                leaning += slope_x != 0
            level += 1
    assert leaning > 2 or nx < 700 or "land" not in kinds


# ---- the caller's floating-point environment -------------------------------------------------------------------------------------


@pytest.fixture
def modes(library):
    """How many there are: bit 0 flushes denormal results, bit 1 operands (or on ARM, every NaN has the same bits), two are the rounding, and bit 4
    makes exceptions trap. After each call library.c looks at the register, and whether the caller's flags are still raised."""
    count = library.number("set_mode", 99)
    if count == 0:
        pytest.skip("this CPU's register is unknown")
    return count


@pytest.mark.parametrize("size", [1e-30, 2.0**-124])
def test_answers_do_not_depend_on_the_environment(library, modes, size):
    """Low heights, whose differences are denormal, and directions with components that are denormal or count as zero."""
    rays, r = random_rays(2000, 31, 12), np.random.default_rng(31)
    rays["org"][:, 2], rays["dir"][:, 2] = rays["org"][:, 2] * size, rays["dir"][:, 2] * size
    rays["dir"][np.arange(0, 2000, 4), r.integers(0, 3, 500)] = np.ldexp(1.0, r.integers(-149, -126, 500))
    field = library.field(size * r.random((12, 31)))
    for kernel, leaf in itertools.product([kernel for name, kernel, _ in library.kernels() if name != "brute"], (1, 2)):
        run = library.run(kernel=kernel, leaf=leaf)
        if library.asked("cw_run_check", None, run)[0] != OK:
            continue
        library.well("cw_field_build", field, run)
        expected = library.closest(field, rays, run)
        assert 200 < (expected["i"] >= 0).sum() < 1950
        for mode in filter(lambda mode: takes(mode, 5), range(modes)):
            library.call("set_mode", mode)
            assert library.closest(field, rays, run).tobytes() == expected.tobytes(), (kernel, leaf, mode)
            assert (library.occluded(field, rays, run) == (expected["i"] >= 0)).all(), (kernel, leaf, mode)
        library.call("set_mode", 99)


def test_fields_do_not_depend_on_the_environment(library, modes):
    """Samples so small that a caller's environment turns them to zero; maps and rays from user space."""
    r, map = np.random.default_rng(14), 0.3 * np.eye(3, 4) + np.outer((1, 1, 1), (0, 0, 0, 0.7))
    z, down = (r.random((9, 9)) - 0.5) * 2.0**-127, np.zeros(500, RAY)
    down["org"], down["dir"], down["tmax"] = r.random((500, 3)) * (8, 8, 0) + (0, 0, 2.0**-126), (0, 0, -2.0**-127), np.inf
    ray, found = np.array([((0.1, 0.2, 0.3), 0, (1 / 3, 0.7, -0.9), 1e3)], USER_RAY), set()
    watched = lambda **how: library.run(watch=library.number("watch"), watch_context=library.keep(np.array([0.0, 2, 0])), **how)  # noqa: E731
    for mode in 99, *range(modes):
        library.call("set_mode", mode)
        field, mapped = library.field(z), library.field(np.ones((3, 3)), map)
        moved = library.of_each("cw_rays_to_field", mapped, ray, RAY).tobytes()
        library.well("cw_field_update", field, None, library.struct("cw_update", at=(1, 1, 5, 5), samples=library.keep(z[2:7, 2:7].astype("f4"))))
        library.well("cw_field_build", field, library.run(kernel="grid3d"))
        coarse = int(library.well("cw_field_coarser", mapped, watched(), 3, 0, Room("u8"), None, 0)[0])
        library.fields.append(coarse)
        heading = library.well("cw_heading_create", mapped, library.struct("cw_heading_desc", dir=(0.1, 1), drop=0.7), Room("u8"))
        seen = library.closest(field, down, watched(kernel="cell"))
        library.call("set_mode", 99)
        hits = [library.closest(field, down, library.run(kernel=kernel)) for _, kernel, _ in library.kernels()]
        assert all((h["i"] >= 0).sum() > 100 for h in hits)
        library.call("cw_heading_destroy", int(heading[0]))
        found.add((*(library.describe(f).tobytes() for f in (field, mapped, coarse)), moved, *(h.tobytes() for h in (seen, *hits))))
    assert len(found) == 1
