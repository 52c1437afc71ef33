# SPDX-License-Identifier: Apache-2.0
"""`cellwalk info` says what the library says."""
import json

import numpy as np
import pytest
from program import asc, kernels, library, needs, refused, run, sets, well, write

INF = np.inf


def info(*words, **setting):
    return json.loads(well("info", *words, "--json", **setting).out)


def test_kernels_are_listed():
    wanted, best = kernels()
    said = info()
    assert [tuple(k[name] for name in ("name", "width", "isa", "leaf", "available", "chosen")) for k in said["kernels"]] == wanted
    assert said["isa"] == best
    chosen, = [name for name, *_, is_chosen in wanted if is_chosen]
    assert f"* {chosen} " in well("info").out


def test_limits_are_kept():
    for isa in sets():
        out = well("info", isa=isa).out
        chosen, = [name for name, *_, is_chosen in kernels(isa)[0] if is_chosen]
        assert f"instruction set {isa} (CELLWALK_ISA={isa})\n" in out and f"* {chosen} " in out
    assert info(isa="scalar")["isa"] == "scalar"
    assert "instruction set scalar" in well("info", "--isa=scalar").out
    assert "* cell " in well("info", "--kernel", "cell").out


def test_fields_are_described():
    np.save('quo"te.npy', np.array([[3, 1, 2, np.nan], [-5.5, 0, 7.25, 8], [1, 1, INF, 2]], np.float32))
    said = info('quo"te.npy', "--kernel", "cell")["field"]
    assert {key: said[key] for key in ("path", "nx", "ny", "low", "high", "holes", "bytes_samples")} == {
        "path": 'quo"te.npy', "nx": 4, "ny": 3, "low": -5.5, "high": 8, "holes": 2, "bytes_samples": 48}
    assert said["bytes_built"] >= 0
    out = well("info", 'quo"te.npy').out
    assert "4 x 3 (3 x 2 cells)" in out and "-5.5 to 8" in out
    np.save("holes.npy", np.full((2, 2), np.nan, np.float32))
    said = info("holes.npy", "--kernel", "grid3d")["field"]
    assert (said["low"], said["high"], said["holes"], said["bytes_samples"]) == (None, None, 4, 16)
    asc("a.asc", np.array([[1, 2], [3, 4]]), 10, 20, 2)
    said = info("a.asc")["field"]
    assert said["map"] == [[2, 0, 0, 11], [0, -2, 0, 23], [0, 0, 1, 0]]
    assert (said["extent"], said["cell_size"], said["degrees"]) == ([11, 21, 13, 23], [2, 2], False)


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
    np.save("z.npy", np.array([[1, 2], [3, 4]], np.float32))
    out = well("info", "z.npy").out
    assert "z.npy\n  extent        no map: " in out and "  heights       1 to 4\n" in out


@pytest.mark.parametrize("name, output, missing", [("GDAL", "o.tif", "GDAL"), ("libpng", "o.png", "no library")])
def test_libraries_are_told(name, output, missing):
    """What is there can be written."""
    np.save("z.npy", np.array([[1, 2], [3, 4]], np.float32))
    done = run("shadow", "z.npy", "--cellsize", 1, "--sun", "0,9", "-o", output)
    there = done.status == 0
    assert there or missing in done.err
    assert library(name) == there


def test_without_its_module_gdal_is_not_there():
    assert "GDAL     no: " in well("--version", env={"CELLWALK_MODULES": "/nowhere"}).out


def test_help_is_printed():
    assert "  trace " in well("--help").out
    assert "-o, --output HITS.npy" in well("trace", "--help").out
    assert "Usage: cellwalk info" in well("info", "x", "-h").out
