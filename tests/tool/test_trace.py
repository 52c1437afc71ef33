# SPDX-License-Identifier: Apache-2.0
"""`cellwalk trace` gives what the library gives, bit for bit, in a file that NumPy can read."""
import json

import numpy as np
import pytest
from program import HIT, answers, asc, entries, kernels, needs_room, npy, rays, read, refused, run, well

N = 20000


@pytest.fixture
def field():
    random = np.random.default_rng(1)
    y, x = np.mgrid[:33, :49]
    z = (8 * np.sin(x / 5) * np.cos(y / 4) + random.normal(0, 1, x.shape)).astype(np.float32)
    z[random.random(z.shape) < 0.02] = np.nan
    np.save("field.npy", z)
    return z


@pytest.fixture
def table(field):
    """Rays of all kinds: from above and inside, level, vertical, along rows, with short ranges, past the field."""
    random = np.random.default_rng(2)
    rays = np.empty((N, 8))
    rays[:, :3] = random.uniform((-5, -5, -15), (53, 37, 30), (N, 3))
    rays[:, 4:7] = random.uniform((0, 0, -8), (48, 32, 8), (N, 3)) - rays[:, :3]
    rays[:, 3], rays[:, 7] = 0, np.inf
    rays[::7, 4:6] = 0
    rays[1::7, 5], rays[1::7, 1] = 0, np.rint(rays[1::7, 1])
    rays[2::7, 6] = 0
    rays[3::7, 3], rays[3::7, 7] = random.uniform(-0.5, 0.5, len(rays[3::7])), random.uniform(0.2, 3, len(rays[3::7]))
    rays = rays.astype(np.float32)
    np.save("rays.npy", rays)
    return rays


def same(name, wanted):
    got = np.load(name)
    assert got.dtype == wanted.dtype and got.shape == wanted.shape and got.tobytes() == wanted.tobytes(), name


def test_header(field, table):
    """Of the first version, and the data begin at a multiple of 64."""
    well("trace", "field.npy", "rays.npy", "-o", "hits.npy")
    text = f"{{'descr': {HIT.descr}, 'fortran_order': False, 'shape': ({N},), }}"
    start = 10 + int.from_bytes(read("hits.npy")[8:10], "little")
    assert read("hits.npy")[:8] == b"\x93NUMPY\x01\x00" and read("hits.npy")[10:start].decode().rstrip(" \n") == text
    assert start % 64 == 0 and read("hits.npy")[start - 1:start] == b"\n" and len(read("hits.npy")) == start + 24 * N


def test_closest_is_the_librarys(field, table):
    for name, _, _, leaf, available, _ in kernels()[0]:
        if available:
            well("trace", "field.npy", "rays.npy", "-o", "hits.npy", "--kernel", name, "--leaf", leaf, "--threads", 1)
            same("hits.npy", answers(field, table, name)[0])
    # The default kernel, in threads, by other spellings of the options.
    wanted = answers(field, table)[0]
    assert N / 10 < (wanted["i"] >= 0).sum() < N * 9 / 10
    well("trace", "--threads=3", "-ohits.npy", "--", "field.npy", "rays.npy")
    same("hits.npy", wanted)
    assert entries() == ["field.npy", "hits.npy", "rays.npy"]


def test_any_marks_the_occluded(field, table):
    well("trace", "--occluded", "field.npy", "rays.npy", "--output=hits.npy")
    same("hits.npy", answers(field, table)[1])


def test_pieces_join(field, table):
    """More rays than one piece holds, the last piece being short."""
    np.save("many.npy", np.tile(table, (27, 1)))
    well("trace", "field.npy", "many.npy", "-o", "hits.npy")
    same("hits.npy", np.tile(answers(field, table)[0], 27))


def test_no_rays_no_hits(field, table):
    np.save("none.npy", table[:0])
    well("trace", "field.npy", "none.npy", "-o", "hits.npy", "--json")
    same("hits.npy", np.empty(0, HIT))


def test_rays_of_the_map():
    """In coordinates far from the origin, against the library's own way there; with places and normals."""
    z, map = np.array([[0, 1, 2], [7, 5, 3], [9, 9, 1]]), [[10, 0, 0, 600005], [0, -10, 0, 5200025], [0, 0, 1, 0]]
    asc("a.asc", z, 600000, 5200000)
    random = np.random.default_rng(4)
    user = rays("user.npy", np.c_[random.uniform((600000, 5200000), (600030, 5200030), (500, 2)), np.full(500, 20)], dtype="<f8", tmax=np.inf)
    user[:, 4:7] = np.c_[random.uniform(-1, 1, 500), np.full(500, 0.25), np.full(500, -1)]
    np.save("user.npy", user)
    hits, occluded, points, normals = answers(z, user, map=map)
    well("trace", "a.asc", "user.npy", "--user", "-o", "hits.npy")
    same("hits.npy", hits)
    well("trace", "a.asc", "user.npy", "--user", "--points", "--normals", "-o", "hits.npy")
    got, found = np.load("hits.npy"), hits["i"] >= 0
    assert got.dtype.descr == HIT.descr + [(c, "<f8") for c in "xyz"] + [("n" + c, "<f4") for c in "xyz"]
    same_hits = np.empty(500, HIT)
    for name in HIT.names:
        same_hits[name] = got[name]
    assert same_hits.tobytes() == hits.tobytes() and 500 / 4 < found.sum() < 500 - 20
    for k, c in enumerate("xyz"):
        assert (got[c][found] == points[found, k]).all() and np.isnan(got[c][~found]).all()
        assert (got["n" + c][found] == normals[found, k].astype(np.float32)).all() and np.isnan(got["n" + c][~found]).all()
    well("trace", "a.asc", "user.npy", "--user", "--occluded", "-o", "hits.npy")
    same("hits.npy", occluded)


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
    well("trace", "a.asc", "near.npy", "--user", "-o", "hits.npy")
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
    table = rays("rays.npy", np.c_[random.uniform((0, 0), (2, 1), (1000, 2)), np.full(1000, 9)], (0.1, 0.05, -1), tmax=np.inf).astype("<f4")
    wanted = answers(z, table)[0]
    assert (wanted["i"] >= 0).sum() > 100
    for name in "f4.npy", "u2.npy", "a.asc":
        well("trace", name, "rays.npy", "-o", "hits.npy")
        same("hits.npy", wanted)


def test_json_tells_the_time(field, table):
    done = run("trace", "field.npy", "rays.npy", "--json", "--kernel", "cell", "--threads", 2)
    told = json.loads(done.out)
    assert done.status == 0 and done.out.startswith('{"kernel": "cell", ') and done.out.count("\n") == 1
    assert (told["rays"], told["threads"], told["hits"]) == (N, 2, (answers(field, table)[0]["i"] >= 0).sum())
    assert told["seconds"] > 0 and abs(told["mrays_per_s"] * told["seconds"] * 1e6 - N) < 1e-3 * N
    assert entries() == ["field.npy", "rays.npy"]


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
