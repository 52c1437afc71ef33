# SPDX-License-Identifier: Apache-2.0
"""`cellwalk trace`: hits in a file that NumPy can read, judged by every triangle in double; ../python/test_tool.py has the library's own bits."""
import json

import numpy as np
import pytest
from program import asc, entries, info, needs_room, npy, rays, read, run, well

N = 2000
HIT = np.dtype([("t", "<f4"), ("i", "<i4"), ("j", "<i4"), ("triangle", "<u4"), ("u", "<f4"), ("v", "<f4")])


@pytest.fixture
def field():
    random = np.random.default_rng(1)
    y, x = np.mgrid[:13, :19]
    z = (8 * np.sin(x / 5) * np.cos(y / 4) + random.normal(0, 1, x.shape)).astype(np.float32)
    z[random.random(z.shape) < 0.02] = np.nan
    np.save("field.npy", z)
    return z


@pytest.fixture
def table(field):
    """Rays of all kinds: from above and inside, level, vertical, along rows, with short ranges, past the field."""
    random = np.random.default_rng(2)
    rays = np.empty((N, 8))
    rays[:, :3] = random.uniform((-5, -5, -15), (23, 17, 30), (N, 3))
    rays[:, 4:7] = random.uniform((0, 0, -8), (18, 12, 8), (N, 3)) - rays[:, :3]
    rays[:, 3], rays[:, 7] = 0, np.inf
    rays[::7, 4:6] = 0
    rays[1::7, 5], rays[1::7, 1] = 0, np.rint(rays[1::7, 1])
    rays[2::7, 6] = 0
    rays[3::7, 3], rays[3::7, 7] = random.uniform(-0.5, 0.5, len(rays[3::7])), random.uniform(0.2, 3, len(rays[3::7]))
    rays = rays.astype(np.float32)
    np.save("rays.npy", rays)
    return rays


def check(got, z, rays):
    """Hits are the nearest of all triangles, but for rays that pass as near to an edge, or to an end of their range, as rounding explains. The nearest
    triangle's edges, in samples."""
    rows, columns = z.shape
    y, x = np.mgrid[:rows - 1, :columns - 1]
    a, b, c, d = (np.stack([x + i, y + j, z[j:rows - 1 + j, i:columns - 1 + i]], -1).reshape(-1, 3) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    corner, one, other = np.r_[a, a], np.r_[b - a, c - a], np.r_[c - a, d - a]
    start, way, tmin, tmax = rays[:, None, :3].astype(float), rays[:, None, 4:7].astype(float), rays[:, 3:4], rays[:, 7:8]
    with np.errstate(all="ignore"):
        across, side = np.cross(way, other), np.cross(start - corner, one)
        volume = (one * across).sum(-1)
        u, v, t = ((p * q).sum(-1) / volume for p, q in ((start - corner, across), (way, side), (other, side)))
        inside, within = np.min([u, v, 1 - u - v], 0), np.minimum(t - tmin, tmax - t)
        unclear = ((np.abs(inside) < 1e-4) & (within > -1e-3) | (inside > -1e-4) & (np.abs(within) < 1e-3)).any(1)
    t[~((inside > 0) & (within > 0))] = np.inf
    nearest, t = t.argmin(1), t.min(1)
    hit = np.isfinite(t) & ~unclear
    assert ((got["i"] >= 0) == np.isfinite(t))[~unclear].all() and hit.mean() > 0.1 and (got["i"] < 0).mean() > 0.01 and unclear.mean() < 0.3
    assert np.allclose(got["t"][hit], t[hit], rtol=1e-4, atol=1e-4) and np.isinf(got["t"][got["i"] < 0]).all()
    cell = nearest % len(a)
    for name, wanted in ("i", cell % (columns - 1)), ("j", cell // (columns - 1)), ("triangle", nearest // len(a)):
        assert (got[name] == wanted)[hit].all(), name
    return hit, one[nearest], other[nearest]


def traced(*words):
    well("trace", *words, "-o", "hits.npy")
    return np.load("hits.npy")


def test_hits_are_the_nearest(field, table):
    """By each kernel; the default one also in threads, by other spellings of the options."""
    default, kernels = traced("field.npy", "rays.npy"), info()["kernels"]
    strict, = (kernel["leaf"] for kernel in kernels if kernel["chosen"])
    for kernel in kernels:
        if kernel["available"]:
            got = traced("field.npy", "rays.npy", "--kernel", kernel["name"], "--leaf", kernel["leaf"], "--threads", 1)
            check(got, field, table)
            assert got.tobytes() == default.tobytes() or kernel["leaf"] != strict or kernel["name"] in ("brute", "grid3d")
    well("trace", "--threads=3", "-ohits.npy", "--", "field.npy", "rays.npy")
    assert np.load("hits.npy").tobytes() == default.tobytes() and default.dtype == HIT
    assert (traced("--occluded", "field.npy", "rays.npy") == (default["i"] >= 0)).all() and entries() == ["field.npy", "hits.npy", "rays.npy"]
    # A file of the first version, whose data begin at a multiple of 64. More rays than one piece holds, the last piece being short; and none.
    for many in np.tile(table, (270, 1)), table[:0]:
        np.save("many.npy", many)
        assert traced("field.npy", "many.npy", "--json").tobytes() == np.tile(default, 270)[:len(many)].tobytes()
        start = 10 + int.from_bytes(read("hits.npy")[8:10], "little")
        assert read("hits.npy")[:8] == b"\x93NUMPY\x01\x00" and start % 64 == 0 and len(read("hits.npy")) == start + 24 * len(many)


def test_rays_of_the_map():
    """In coordinates far from the origin; with places and normals."""
    z, scale, origin = np.array([[0, 1, 2], [7, 5, 3], [9, 9, 1]]), np.array([10, -10, 1]), np.array([600005, 5200025, 0])
    asc("a.asc", z, 600000, 5200000)
    random = np.random.default_rng(4)
    user = rays("user.npy", np.c_[random.uniform((600000, 5200000), (600030, 5200030), (500, 2)), np.full(500, 20)], dtype="<f8", tmax=np.inf)
    user[:, 4:7] = np.c_[random.uniform(-1, 1, 500), np.full(500, 0.25), np.full(500, -1)]
    np.save("user.npy", user)
    own = user.copy()
    own[:, :3], own[:, 4:7] = (user[:, :3] - origin) / scale, user[:, 4:7] / scale
    plain, got = traced("a.asc", "user.npy", "--user"), traced("a.asc", "user.npy", "--user", "--points", "--normals")
    assert got.dtype.descr == HIT.descr + [(c, "<f8") for c in "xyz"] + [("n" + c, "<f4") for c in "xyz"]
    assert all((got[name] == plain[name]).all() for name in HIT.names)
    hit, one, other = check(got, z, own)
    normals = -np.cross(one * scale, other * scale)
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    for k, c in enumerate("xyz"):
        assert np.abs(got[c] - user[:, k] - got["t"] * user[:, 4 + k])[hit].max() < 1e-4 and np.abs(got["n" + c] - normals[:, k])[hit].max() < 1e-6
        assert np.isnan(got[c][got["i"] < 0]).all() and np.isnan(got["n" + c][got["i"] < 0]).all()
    assert (traced("a.asc", "user.npy", "--user", "--occluded") == (got["i"] >= 0)).all()


def test_what_is_said_of_rays():
    """Rays that go nowhere near the field are told of, and where it lies; standard output takes hits or words."""
    asc("a.asc", np.array([[0, 1], [2, 7]]), 600000, 5200000)
    rays("far.npy", (0, 0, 100), dtype="<f8")
    rays("near.npy", (600010, 5200010, 100), dtype="<f8")
    rays("above.npy", (600010, 5200010, 100), tmax=50, dtype="<f8")
    rays("lost.npy", (600010, 5200010, 100))
    for words, status, said in [
            (("far.npy", "--user", "-o", "h.npy"), 0, "no ray hits the field, which lies at x 600005 to 600015"),
            (("above.npy", "--user", "-o", "h.npy"), 0, "no ray hits"),
            (("lost.npy", "-o", "h.npy"), 0, "--user takes them so"),
            (("near.npy", "-o", "h.npy"), 1, "'<f8', not '<f4'"),
            (("near.npy", "--user", "-o", "-", "--json"), 2, "cannot take both"),
            (("near.npy", "--occluded", "--points", "-o", "h.npy"), 2, "--occluded finds no hit")]:
        done = run("trace", "a.asc", *words)
        assert done.status == status and said in done.err, words
    traced("a.asc", "near.npy", "--user")
    assert '"rays": 1, "hits": 1' in well("trace", "a.asc", "near.npy", "--user", "--json").out
    well("trace", "a.asc", "above.npy", "--user", "-o", "hits.npy", "--quiet")
    assert run("trace", "a.asc", "near.npy", "--user", "--occluded", "-o", "-").bytes.startswith(b"\x93NUMPY")


def test_formats_agree():
    """The same heights in each kind of file."""
    z = np.array([[0, 1, 2], [7, 5, 3]], np.float32)
    np.save("f4.npy", z)
    np.save("u2.npy", z.astype("<u2"))
    asc("a.asc", z, cell=1)
    random = np.random.default_rng(3)
    rays("rays.npy", np.c_[random.uniform((0, 0), (2, 1), (1000, 2)), np.full(1000, 9)], (0.1, 0.05, -1), tmax=np.inf)
    results = [traced(name, "rays.npy") for name in ("f4.npy", "u2.npy", "a.asc")]
    check(results[0], z, np.load("rays.npy"))
    assert len({got.tobytes() for got in results}) == 1


def test_json_tells_the_time(field, table):
    done = run("trace", "field.npy", "rays.npy", "--json", "--kernel", "cell", "--threads", 2)
    told = json.loads(done.out)
    assert done.status == 0 and done.out.startswith('{"kernel": "cell", ') and done.out.count("\n") == 1
    assert told["seconds"] > 0 and abs(told["mrays_per_s"] * told["seconds"] * 1e6 - N) < 1e-3 * N
    assert entries() == ["field.npy", "rays.npy"]
    assert (told["rays"], told["threads"], told["hits"]) == (N, 2, (traced("field.npy", "rays.npy")["i"] >= 0).sum())


def test_rays_need_not_fit(field):
    """128 MiB of rays through 64 MiB of address space. The rays are a hole in the file: all zero, so they miss."""
    if needs_room():
        pytest.skip("AddressSanitizer needs more memory than that")
    n = 4 << 20
    npy("sparse.npy", "<f4", f"({n}, 8)")
    with open("sparse.npy", "r+b") as file:
        file.truncate(len(read("sparse.npy")) + 32 * n)
    done = run("trace", "field.npy", "sparse.npy", "-o", "hits.npy", "--threads", 1, memory=64 << 20)
    assert done.status == 0, done.err
    hits = np.load("hits.npy", mmap_mode="r")
    assert len(hits) == n and set(hits[::1001].tolist()) == {(np.inf, -1, -1, 0, 0, 0)}
