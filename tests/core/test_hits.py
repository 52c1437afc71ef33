# SPDX-License-Identifier: Apache-2.0
"""What follows from rays and hits: rays in user space give the answers of the plain functions, as precise as the header says; points and normals
of hits agree with formulas in long double; places on the surface; tiles of a land that overlap."""
import numpy as np
import pytest
from library import HEADERS, HIT, NOTHING, RAY, SOURCE, USER_RAY, Room, random_rays
from program import DIVISOR, SLOW
from test_coarser import made

# MIRRORED shears and turns x and y and reverses z. FAR turns and scales, with its origin millions of units away.
MIRRORED = np.array([[2, -0.5, 0.125, 300], [0.75, 3, 0, -20], [0.25, 0, -1.5, 7]])
FAR = np.array([[30, -5, 0, 3e6], [4, 31, 0, -7e6], [0.5, 0.25, 2, 100]])
LONG = np.longdouble


# ---- points and normals --------------------------------------------------------------------------------------------------------


def unit(v):
    return v / np.sqrt((v * v).sum(-1, keepdims=True))


def area_normals(points, map):
    """Of triangles A and B of each cell, twice the area times the unit normal on the side of growing field z."""
    p00, p10, p01, p11 = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    n = np.stack([np.cross(p10 - p00, p11 - p00), np.cross(p11 - p00, p01 - p00)])
    return np.where((n @ map[:, 2].astype(LONG))[..., None] < 0, -n, n)


def vertex_normals(n):
    """The sum over the triangles that have the sample as a corner; those with a hole count for nothing."""
    ny, nx = n.shape[1] + 1, n.shape[2] + 1
    total = np.zeros((ny, nx, 3), LONG)
    for triangle, down, across in (0, 0, 0), (0, 0, 1), (0, 1, 1), (1, 0, 0), (1, 1, 1), (1, 1, 0):
        total[down:ny - 1 + down, across:nx - 1 + across] += np.where(np.isnan(n[triangle]), 0, n[triangle])
    return total


def off_by(found, wanted):
    return (np.abs(found - wanted).max(-1) / np.abs(wanted).max(-1)).max()


def test_points_and_normals_of_hits(library):
    z = made("holes", 17, 17, 7).astype("f4")
    hits = library.closest(library.field(z), random_rays(20000, 17, 17))
    hits = hits[hits["i"] >= 0]
    assert len(hits) > 5000
    field = library.field(z, MIRRORED)
    found = [library.of_each(f"cw_hit_{what}", field, hits, columns=3) for what in ("points", "normals", "phong_normals")]
    x, y = np.meshgrid(*[np.arange(17, dtype=LONG)] * 2)
    points = np.stack([x, y, z], -1) @ MIRRORED[:, :3].T.astype(LONG) + MIRRORED[:, 3]
    i, j, b = hits["i"], hits["j"], hits["triangle"].astype(int)
    at = (j, i), (j + b, i + 1), (j + 1, i + 1 - b)  # corners: B's second is (1, 1)
    u, v = (hits[c].astype(LONG)[:, None] for c in "uv")
    assert (u >= 0).all() and (v >= 0).all() and (u + v <= 1 + 2.0**-22).all()
    areas = area_normals(points, MIRRORED)
    wanted = [(1 - u - v) * a[at[0]] + u * a[at[1]] + v * a[at[2]] for a in (points, vertex_normals(areas))]
    assert off_by(found[0], wanted[0]) <= 1e-13
    assert off_by(found[1], unit(areas[b, j, i])) <= 1e-13
    assert off_by(found[2], unit(wanted[1])) <= 1e-13
    for exponent in -1010, -600, 600, 1010:  # whatever the user's unit of length is, normals have the same bits
        scaled = library.field(z, np.ldexp(MIRRORED, exponent))
        for what, first in ("normals", found[1]), ("phong_normals", found[2]):
            assert library.of_each(f"cw_hit_{what}", scaled, hits, columns=3).tobytes() == first.tobytes()
    for scale in (1, 1, 1e170), (1e-170, 1e-170, 1):
        flat = library.field(np.zeros((17, 17)), np.diag([*scale, 0])[:3])
        for what in "normals", "phong_normals":
            assert np.abs(library.of_each(f"cw_hit_{what}", flat, hits, columns=3) - (0, 0, 1)).max() <= 2.0**-52


def test_what_follows_from_no_hit(library):
    """A miss, and hits that the field cannot have, or has no longer: a hole is at a vertex."""
    none = np.array([(np.inf, -1, -1, 0, 0, 0), *((0, i, j, k, 0, 0) for i, j, k in (
        (16, 0, 0), (0, 16, 0), (2**31 - 1, 2**31 - 1, 0), (-2**31, 0, 0), (0, 0, 2), (0, 0, 2**32 - 1), (5, 4, 1), (4, 4, 0)))], HIT)
    field = library.field(np.where(np.arange(289).reshape(17, 17) == 5 * 18, np.nan, 0))
    for what in "points", "normals", "phong_normals":
        assert np.isnan(library.of_each(f"cw_hit_{what}", field, none, columns=3)).all()


# ---- places --------------------------------------------------------------------------------------------------------------------


def test_places_on_the_surface(library):
    side, r = 33, np.random.default_rng(11)
    z = made("holes", side, side, 5).astype("f4")
    field = library.field(z, FAR)
    xy = r.uniform(0, side, (20000, 2))
    xy[::2] = np.floor(xy[::2])  # samples, borders and diagonals, the far border, and anything between
    xy[1::4, 1] = xy[1::4, 0]
    hits = library.of_each("cw_surface_at", field, xy, HIT)
    points = library.of_each("cw_hit_points", field, hits, columns=3)
    inside = (xy <= side - 1).all(1)
    i, j = np.minimum(xy, side - 2).astype(int).T
    u, v = (xy - np.stack([i, j], 1)).T
    a = v <= u
    z00, third, z11 = z[j, i].astype(float), np.where(a, z[j, i + 1], z[j + 1, i]).astype(float), z[j + 1, i + 1].astype(float)
    height = z00 + np.where(a, u, v) * (third - z00) + np.where(a, v, u) * (z11 - third)
    there = inside & ~np.isnan(height)
    assert ((hits["i"] >= 0) == there).all() and np.isinf(hits["t"][~inside]).all() and (hits["t"][there] == 0).all()
    wanted = np.stack([*xy.T, height], 1) @ FAR[:, :3].T + FAR[:, 3]
    reach = np.abs(FAR[:, :2]).sum(1) + 2 * np.abs(FAR[:, 2])  # u and v are rounded to float, in a field of heights below 1
    assert (np.abs(points - wanted) <= 2.0**-23 * reach + 2.0**-50 * np.abs(wanted))[there].all() and there.sum() > 5000
    outside = np.array([(-0.001, 1), (1, -1e-300), (32.001, 1), (1, 1e300), (np.nan, 1), (1, np.inf)])
    assert (library.of_each("cw_surface_at", field, outside, HIT)["i"] == -1).all()


@pytest.mark.parametrize("map", [[[2, 0, 0, 10], [0, 0, 3, -5], [0, -2, 0, 7]], [[1, 0, 0.5, 0], [0, 1, -0.25, 0], [0, 0, 1, 0]],
                                 [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]]])
def test_places_along_the_fields_up(library, map):
    """Worlds whose y is up, or whose heights lean. All numbers are exact."""
    field, map, r = library.field(made("holes", 33, 33, 5), map), np.array(map), np.random.default_rng(12)
    places = np.concatenate([r.integers(0, 8 * 33, (2000, 2)) / 8, r.integers(-32, 32, (2000, 1))], 1)
    wanted = library.of_each("cw_surface_at", field, np.ascontiguousarray(places[:, :2]), HIT)
    assert library.of_each("cw_surface_at_user", field, places @ map[:, :3].T + map[:, 3], HIT).tobytes() == wanted.tobytes()


# ---- rays in user space ----------------------------------------------------------------------------------------------------------


def user_rays(n, seed=9):
    """Above 33 × 33 samples on the map FAR."""
    r, rays = np.random.default_rng(seed), np.zeros(n, USER_RAY)
    rays["org"] = np.concatenate([r.uniform(0, 33, (n, 2)), np.full((n, 1), 3)], 1) @ FAR[:, :3].T + FAR[:, 3]
    rays["dir"] = (r.random((n, 3)) * [1, 1, -0.3] - [0.5, 0.5, 0]) @ FAR[:, :3].T
    rays["tmax"] = np.inf
    return rays


def test_rays_in_user_space(library):
    field, given = library.field(made("holes", 33, 33, 5), FAR), user_rays(30000)
    expected = library.closest(field, library.of_each("cw_rays_to_field", field, given, RAY))
    assert 5000 < (expected["i"] >= 0).sum() < 29000
    pool = library.pool(3)
    for n in 0, 1, 511, 512, 513, len(given):
        for run in None, library.run(pool=pool):
            hits = library.well("cw_closest_user", field, run, given[:n], n, Room(HIT, n + 1))
            seen = library.well("cw_occluded_user", field, run, given[:n], n, Room("u1", n + 1))
            assert hits[:n].tobytes() == expected[:n].tobytes() and (seen[:n] == (expected[:n]["i"] >= 0)).all()
            assert (hits[n:].view("u1") == NOTHING).all() and seen[n] == NOTHING


def test_threads_of_the_caller(library):
    field, given, counts = library.field(made("holes", 33, 33, 5)), random_rays(30000, 33, 33), library.keep(np.zeros(2, "u8"))
    tasks = library.struct("cw_tasks", threads=8, run=library.number("run_tasks"), context=counts)
    library.pools = [pool] = library.well("cw_pool_create_on", tasks, Room("u8"))
    assert library.number("cw_pool_threads", pool) == 8
    for n, called in (len(given), [1, 8]), (1023, [1, 8]), (1024, [2, 12]):  # fewer are too few to share
        assert library.closest(field, given[:n], library.run(pool=pool)).tobytes() == library.closest(field, given[:n]).tobytes()
        assert library.call("peek", counts, Room("u8", 2))[1].tolist() == called


def test_every_instruction_set_moves_rays_alike(library):
    """Bit for bit, whatever is in them."""
    n, r = 500, np.random.default_rng(12)
    given = np.zeros(n, USER_RAY)
    given["org"], given["dir"] = r.uniform(-1000, 1000, (n, 3)), r.uniform(-1, 1, (n, 3))
    given["tmin"], given["tmax"] = r.uniform(-1, 1, n), np.where(np.arange(n) % 2, np.inf, r.uniform(1, 1e60, n))
    # Sums that cancel show in what order they were taken.
    given["org"][1::4] = MIRRORED[:, 3] + r.uniform(-1e-12, 1e-12, (125, 3))
    given["dir"][1::4] = MIRRORED[:, 0] + 2 * MIRRORED[:, 1] + r.uniform(-1e-15, 1e-15, (125, 3))
    given["org"][3::16, 0] = given["org"][11::16, 2] = np.inf
    field, moved = library.field(np.zeros((17, 17)), MIRRORED), {}
    for isa in 0, 1, 2, 3, 4, 5:
        library.call("cw_isa_limit", isa)
        moved[isa] = library.of_each("cw_rays_to_field", field, given, RAY)
        moved[isa]["org"][np.isnan(moved[isa]["org"])] = np.nan  # which has no one bit pattern
        assert moved[isa].tobytes() == moved[0].tobytes()
        with np.errstate(over="ignore"):
            assert all((moved[isa][end] == given[end].astype("f4")).all() for end in ("tmin", "tmax"))


def axes(north, east):
    """East, north and up on a sphere."""
    sn, cn, se, ce = np.sin(north), np.cos(north), np.sin(east), np.cos(east)
    return np.array([(-se, ce, 0), (-sn * ce, -sn * se, cn), (cn * ce, cn * se, sn)]).T


ON_EARTH = axes(*np.radians((48, 11)))


@pytest.mark.parametrize("map, cell, reach, most", [
    (np.concatenate([np.eye(3), [[448000], [5411000], [0]]], 1), 1, (10000, 10000, 1000), 5e-4),  # UTM, cells of 1 m
    (np.concatenate([10 * ON_EARTH, 6371000 * ON_EARTH[:, 2:]], 1), 10, (1000, 1000, 70000), 4e-3)])  # a sensor 700 km above the ground
def test_the_precision_that_arrives(library, map, cell, reach, most):
    """What the header says of the one rounding to float, in cells. Doubles are off by 10^-9 cells here."""
    r, given = np.random.default_rng(21), np.zeros(4000, USER_RAY)
    given["org"] = np.round(map[:, 3] + r.uniform(0.5, 1, (4000, 3)) * reach @ map[:, :3].T, 3)  # millimetres
    given["dir"], given["tmax"] = r.uniform(-1, 1, (4000, 3)), 1
    out = library.of_each("cw_rays_to_field", library.field(np.zeros((2, 2)), map), given, RAY)
    inverse = map[:, :3] / cell**2  # its columns are at right angles and as long as a cell
    worst = np.abs(out["org"] - (given["org"] - map[:, 3]) @ inverse).max()
    worst_dir = (np.abs(out["dir"] - given["dir"] @ inverse).max(1) * cell / np.sqrt((given["dir"]**2).sum(1))).max()
    assert most / 4 < worst <= most and 2.0**-26 < worst_dir <= 1.00001 * 2.0**-24


def test_a_far_origin_comes_off_exactly(library):
    """Cells of 1 cm at 5 · 10^6 m: rays have the bits that they have at the origin."""
    r, given = np.random.default_rng(11), np.zeros(2000, USER_RAY)
    given["org"] = np.ldexp(np.floor(r.uniform(-2**18, 2**20, (2000, 3)) * (16, 16, 2)), -27)  # so that adding the origin is exact too
    given["dir"], given["tmax"] = r.uniform(-1, 1, (2000, 3)), np.inf
    moved = []
    for away in 0, 5000000:
        map = np.diag((0.01, 0.01, 0.01, 0))[:3] + np.outer((1, 1, 0), (0, 0, 0, away))
        given["org"][:, :2] += away
        moved.append(library.of_each("cw_rays_to_field", library.field(np.zeros((2, 2)), map), given, RAY))
    assert moved[0].tobytes() == moved[1].tobytes()


# ---- tiles -----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("overlap, corners", [(1, False), (1, True), (0, False)])
def test_no_ray_slips_between_tiles_that_overlap(library, overlap, corners):
    """As papers/using.md advises: by one cell. Rays from above at places on the inner borders, or at their crossings."""
    across, cells, n = 3, 40, 100000 // (10 if corners else min(DIVISOR * SLOW, 4))
    side, r = across * cells + 2, np.random.default_rng(7)
    land = r.uniform(0, 3, (side, side)).astype("f4")
    borders = cells * r.integers(1, across, (n, 2))
    at = np.where(np.eye(2, dtype=bool)[r.integers(0, 2, n)] | corners, borders, r.uniform(1, side - 3, (n, 2)))
    rays = np.zeros(n, USER_RAY)
    rays["org"] = np.concatenate([r.uniform(0, side, (n, 2)), np.full((n, 1), 60)], 1)
    rays["dir"], rays["tmax"] = np.concatenate([at, r.uniform(0, 3, (n, 1))], 1) - rays["org"], np.inf
    entire = library.field(land)
    whole, nearest = library.of_each("cw_closest_user", entire, rays, HIT), np.full(n, np.inf, "f4")
    found = whole.copy()  # the same in tiles, as hits of all
    for x, y in cells * np.argwhere(np.ones((across, across))):
        tile = library.field(land[y:y + cells + 1 + overlap, x:x + cells + 1 + overlap], np.eye(3, 4) + np.outer((x, y, 0), (0, 0, 0, 1)))
        hits = library.of_each("cw_closest_user", tile, rays, HIT)
        hits["i"] += x
        hits["j"] += y
        found = np.where(hits["t"] < nearest, hits, found)
        nearest = np.fmin(nearest, hits["t"])
    through = np.isfinite(whole["t"]) & np.isinf(nearest)
    assert through.any() == (overlap == 0)
    both = np.isfinite(whole["t"]) & ~through
    # In both spaces a coordinate of origin and direction, below 128, is rounded by up to 2^-18, so a place at t by up to 2^-18 (1 + t). Along
    # a triangle's normal that is as far as the ray comes nearer in so much of t. The two t are floats, too.
    t, bound = whole["t"][both], 0
    for hit in whole, found:
        normal = library.of_each("cw_hit_normals", entire, hit[both], columns=3)
        bound = np.maximum(bound, 2 * 2.0**-18 * (1 + t) * np.abs(normal).sum(1) / np.abs((normal * rays["dir"][both]).sum(1)))
    assert (np.abs(nearest[both] - t) <= bound + 2.0**-23 * t).all()


def test_versions_agree(library):
    macros = dict(line.split(None, 2)[1:] for line in HEADERS.splitlines() if line.startswith("#define CW_VERSION"))
    version = library.call("cw_version")[0]
    assert version == macros["CW_VERSION"].strip('"') == ".".join(macros[f"CW_VERSION_{part}"] for part in ("MAJOR", "MINOR", "PATCH"))
    assert f"VERSION {version}" in (SOURCE / "CMakeLists.txt").read_text() and library.number("cw_version_number") == sum(int(part) * 100**k for part, k in zip(version.split("."), (2, 1, 0)))
