# SPDX-License-Identifier: Apache-2.0
"""`cellwalk trace` and `cellwalk info`: kernels, files and words. The hits themselves are judged by ../core; ../python/test_tool.py compares them, and
what is said of kernels, with the library's."""
import json
import os

import numpy as np
import pytest
from program import array, asc, entries, header, info, library, needs, needs_room, npy, rays, read, run, sets, shell, well, write

N = 2000
HIT = np.dtype([("t", "<f4"), ("i", "<i4"), ("j", "<i4"), ("triangle", "<u4"), ("u", "<f4"), ("v", "<f4")])


@pytest.fixture
def table(folder):
    """Rays through hills with holes, that hit or miss."""
    random = np.random.default_rng(1)
    y, x = np.mgrid[:13, :19]
    z = (8 * np.sin(x / 5) * np.cos(y / 4) + random.normal(0, 1, x.shape)).astype(np.float32)
    z[random.random(z.shape) < 0.02] = np.nan
    np.save("field.npy", z)
    origins = random.uniform((-5, -5, -15), (23, 17, 30), (N, 3))
    return rays("rays.npy", origins, random.uniform((0, 0, -8), (18, 12, 8), (N, 3)) - origins, tmax=np.inf).astype(np.float32)


def traced(*words):
    return array("trace", *words, name="hits.npy")


def test_files_of_hits(table):
    """By each kernel; in threads, by other spellings of the options."""
    default, kernels = traced("field.npy", "rays.npy"), info()["kernels"]
    strict, = (kernel["leaf"] for kernel in kernels if kernel["chosen"])
    assert default.dtype == HIT and 0.1 < (default["i"] >= 0).mean() < 0.9 and np.isinf(default["t"][default["i"] < 0]).all()
    for kernel in kernels:
        if kernel["available"]:
            got = traced("field.npy", "rays.npy", "--kernel", kernel["name"], "--leaf", kernel["leaf"], "--threads", 1)
            assert got.tobytes() == default.tobytes() if kernel["leaf"] == strict and kernel["name"] not in ("brute", "grid3d") else \
                np.isclose(got["t"], default["t"], rtol=1e-4).mean() > 0.99
    well("trace", "--threads=3", "-ohits.npy", "--", "field.npy", "rays.npy", isa="scalar")
    assert np.load("hits.npy").tobytes() == default.tobytes()
    assert (traced("--occluded", "field.npy", "rays.npy") == (default["i"] >= 0)).all() and entries() == ["field.npy", "hits.npy", "rays.npy"]
    # A file of the first version, whose data begin at a multiple of 64. More rays than one piece holds, the last piece being short; and none.
    for many in np.tile(table, (270, 1)), table[:0]:
        np.save("many.npy", many)
        assert traced("field.npy", "many.npy", "--json").tobytes() == np.tile(default, 270)[:len(many)].tobytes()
        start = 10 + int.from_bytes(read("hits.npy")[8:10], "little")
        assert read("hits.npy")[:8] == b"\x93NUMPY\x01\x00" and start % 64 == 0 and len(read("hits.npy")) == start + 24 * len(many)


def test_what_is_said_of_rays():
    """Rays that go nowhere near the field are told of, and where it lies; standard output takes hits or words."""
    asc("a.asc", np.array([[0, 1], [2, 7]]), 600000, 5200000)
    rays("far.npy", (0, 0, 100), dtype="<f8")
    rays("near.npy", (600010, 5200010, 100), dtype="<f8")
    rays("above.npy", (600010, 5200010, 100), tmax=50, dtype="<f8")
    rays("lost.npy", (600010, 5200010, 100))
    for words, status, said in [
            (("far.npy", "--user", "-o", "h.npy"), 0, "no ray hits the field, which lies at x 600005 to 600015"),
            (("above.npy", "--user", "-o", "h.npy"), 0, "no ray hits"), (("lost.npy", "-o", "h.npy"), 0, "--user takes them so")]:
        done = run("trace", "a.asc", *words)
        assert done.status == status and said in done.err, words
    traced("a.asc", "near.npy", "--user")
    assert '"rays": 1, "hits": 1' in shell("PROGRAM trace a.asc - --user --json < near.npy").stdout
    well("trace", "a.asc", "above.npy", "--user", "-o", "hits.npy", "--quiet")
    assert run("trace", "a.asc", "near.npy", "--user", "--occluded", "-o", "-").bytes.startswith(b"\x93NUMPY")


def test_json_tells_the_time(table):
    done = run("trace", "field.npy", "rays.npy", "--json", "--kernel", "cell", "--threads", 2)
    told = json.loads(done.out)
    assert done.status == 0 and done.out.startswith('{"kernel": "cell", ') and done.out.count("\n") == 1
    assert told["seconds"] > 0 and abs(told["mrays_per_s"] * told["seconds"] * 1e6 - N) < 1e-3 * N and entries() == ["field.npy", "rays.npy"]
    assert (told["rays"], told["threads"], told["hits"]) == (N, 2, (traced("field.npy", "rays.npy")["i"] >= 0).sum())


def test_rays_need_not_fit(table):
    """128 MiB of rays through 64 MiB of address space. The rays are a hole in the file: all zero, so they miss."""
    if needs_room():
        pytest.skip("AddressSanitizer needs more memory than that")
    n = 4 << 20
    os.truncate("sparse.npy", npy(header(shape=f"({n}, 8)"), name="sparse.npy") + 32 * n)
    done = run("trace", "field.npy", "sparse.npy", "-o", "hits.npy", "--threads", 1, memory=64 << 20)
    assert done.status == 0, done.err
    hits = np.load("hits.npy", mmap_mode="r")
    assert len(hits) == n and set(hits[::1001].tolist()) == {(np.inf, -1, -1, 0, 0, 0)}


# ---- info -----------------------------------------------------------------------------------------------------------------


def test_limits_are_kept():
    for words, isa, known in [((), isa, f" (CELLWALK_ISA={isa})") for isa in sets()] + [(("--isa=scalar",), None, ""), (("--kernel", "cell"), None, None)]:
        said, out = info(*words, isa=isa), well("info", *words, isa=isa).out
        chosen, = [kernel["name"] for kernel in said["kernels"] if kernel["chosen"]]
        assert f"* {chosen} " in out and (known is None or f"instruction set {isa or 'scalar'}{known}" in out) and (known is not None or chosen == "cell")
        assert said["isa"] == (isa or ("scalar" if words == ("--isa=scalar",) else sets()[-1]))


@pytest.mark.parametrize("name, kernel, wanted, says", [
    ('quo"te.npy', "cell", {"path": 'quo"te.npy', "nx": 4, "ny": 3, "low": -5.5, "high": 8, "holes": 2, "bytes_samples": 48}, ("4 x 3 (3 x 2 cells)", "-5.5 to 8")),
    ("holes.npy", "grid3d", {"low": None, "high": None, "holes": 4, "bytes_samples": 16}, ("  extent        no map: ",)),
    ("a.asc", "cell", {"map": [[2, 0, 0, 11], [0, -2, 0, 23], [0, 0, 1, 0]], "extent": [11, 21, 13, 23], "cell_size": [2, 2], "degrees": False}, ("samples",))])
def test_fields_are_described(name, kernel, wanted, says):
    np.save('quo"te.npy', np.array([[3, 1, 2, np.nan], [-5.5, 0, 7.25, 8], [1, 1, np.inf, 2]], np.float32))
    np.save("holes.npy", np.full((2, 2), np.nan, np.float32))
    if name == "a.asc":
        asc(name, np.array([[1, 2], [3, 4]]), 10, 20, 2)
    said, out = info(name, "--kernel", kernel)["field"], well("info", name).out
    assert {key: said[key] for key in wanted} == wanted and said["bytes_built"] >= 0 and all(words in out for words in says)


def test_places_come_first():
    """What people ask of a terrain comes first, and kernels only where no file is asked about."""
    needs("GDAL")
    write("a.asc", "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 20\ncellsize 2\nNODATA_value -9\n1 2 3 4 -9 6\n")
    write("a.prj", 'PROJCS["Somewhere",GEOGCS["g",DATUM["d",SPHEROID["s",6378137,298.257223563]],PRIMEM["Greenwich",0],'
          'UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["foot",0.3048]]')
    done = run("info", "a.asc")
    assert "a.asc: heights taken as ft, as x and y; --zscale 3.2808" in done.err
    assert done.out.startswith("a.asc\n"
                               "  extent        X 101 to 105, Y 21 to 23 (pixels' centres)\n"
                               "  cell size     2 x 2 ft\n"
                               "  coordinates   Somewhere\n"
                               "  heights       1 to 6 ft\n"
                               "  holes         1 (no data: -9)\n"
                               "  samples       3 x 2 (2 x 1 cells)\n")
    assert "leaf test" not in done.out and "instruction set" not in done.out
    assert "  heights       1 to 6 x 0.6096 m\n" in well("info", "a.asc", "--zscale", 2).out


def test_libraries_are_told():
    """What is there can be written; without its module GDAL is not there."""
    np.save("z.npy", np.array([[1, 2], [3, 4]], np.float32))
    for name, output, missing in ("GDAL", "o.tif", "GDAL"), ("libpng", "o.png", "no library"):
        done = run("shadow", "z.npy", "--cellsize", 1, "--sun", "0,9", "-o", output)
        assert library(name) == (done.status == 0) and (done.status == 0 or missing in done.err)
    assert "GDAL     no: " in well("--version", env={"CELLWALK_MODULES": "/nowhere"}).out
    assert "-o, --output HITS.npy" in well("trace", "--help").out and "Usage: cellwalk info" in well("info", "x", "-h").out
