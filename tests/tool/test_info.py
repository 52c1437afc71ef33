# SPDX-License-Identifier: Apache-2.0
"""`cellwalk info`: kernels, which ../python/test_tool.py has from the library, files, and what this build can do."""
import numpy as np
import pytest
from program import asc, info, library, needs, run, sets, well, write


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
    assert "-o, --output HITS.npy" in well("trace", "--help").out and "Usage: cellwalk info" in well("info", "x", "-h").out
