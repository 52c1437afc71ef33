# SPDX-License-Identifier: Apache-2.0
"""The examples of --help run as they stand, on files made here: exit status 0 and nothing on standard error. Examples of cellwalk-bench would take
minutes, so only their command lines are checked, by --help behind all other arguments. No help is wider than 80 columns."""
import os
import re

import numpy as np
import pytest
from program import BENCH, PROGRAM, SCENE, SOURCE, asc, commands, feature, geojson, library, on_map, rays, run, shell, takes, vrt, write

NAMES = {"cellwalk": PROGRAM, "cellwalk-bench": BENCH}


@pytest.fixture(autouse=True)
def inputs(folder):
    """Land around the places of the examples: 5 km, below 1250 m. The GeoTIFF is a VRT by content, so no library is needed to write it, and roads
    and towns are GeoJSON for the same reason."""
    y, x = np.mgrid[:100, :100]
    z = (1000 + 150 * np.sin(x / 9) * np.cos(y / 7)).astype(np.float32)
    np.save("terrain.npy", z)
    asc("dem.asc", np.round(z, 2), 599000, 5199000, 50)
    vrt("dem.tif", "dem.asc", z.shape, on_map(32632, 599000, 50, 0, 5204000, 0, -50))
    write("towers.csv", "x,y,height,weight\n600250,5199800,30,1\n602000,5201000,20,2\n")
    write("links.csv", "x1,y1,height1,x2,y2,height2\n600250,5199800,2,601500,5200100,30\n")
    write("moon.csv", "azimuth,altitude,weight\n120,20,1\n200,5,1\n")
    corners = [[600250, 5199800], [600400, 5199900], [600400, 5200100], [600250, 5199800]]
    for name, kind, places in ("road", "LineString", corners[:2]), ("towns", "Polygon", [corners]):
        geojson(f"{name}.gpkg", feature(kind, places))
    at = 0.9 * np.arange(100)
    rays("rays.npy", np.c_[at, at, np.full(100, 2000)], tmax=np.inf)
    rays("lidar.npy", np.c_[599100 + 40 * at, 5199100 + 40 * at, np.full(100, 2000)], tmax=np.inf, dtype="<f8")
    sun = rays("sun.npy", np.c_[599100 + 40 * at, 5199100 + 40 * at, np.full(100, 1300)], (1, 1, 1), tmax=np.inf)
    sun[0] = 0, 0, 2000, 0, 0, 0, -1, np.inf  # one hit: a run in which no ray meets the field's bounds prints a warning
    np.save("sun.npy", sun.astype("<f4"))
    write("landsea-0.pbrt", SCENE)
    write("texture.pbrt", SCENE)
    os.mkdir("bin")
    for name, path in NAMES.items():
        os.symlink(path, f"bin/{name}")


def sh(line):
    return shell(f"PATH={os.getcwd()}/bin:$PATH; {line}")


@pytest.mark.parametrize("program", NAMES)
def test_examples(program):
    """Each line that begins with the program's name, or has it behind a gap; lines that end in a backslash go on. Formats may be missing."""
    lacking = [ending for ending, name in {".tif": "GDAL", ".gpkg": "GDAL", ".exr": "OpenEXR", ".png": "libpng"}.items() if not library(name)]
    help = sh(f"{program} --help").stdout
    texts = [help.replace("X,Y", "600250,5199800")]  # stands for a place
    texts += [sh(f"{program} {name} --help").stdout.partition("\nExamples:\n")[2] for name in sorted(commands(help))]
    for text in texts:
        lines = re.findall(rf"(?<=  ){program} .*", text.replace("\\\n", ""))
        assert lines
        for line in [line for k, line in enumerate(lines) if takes(k, 4) and not any(ending in line for ending in lacking)]:
            command, more = re.sub(r" > .*", "", line.split("#")[0]), ""
            plan = re.match(r"cellwalk-bench measure (\w+) ", line)
            assert not plan or os.path.exists(f"{SOURCE}/bench/plans/{plan[1]}.plan"), line
            if not line.startswith("cellwalk ") or " --isa " in line:  # an instruction set may be missing on this machine
                more = " --help"
            elif line.startswith("cellwalk render "):  # one sample a pixel, and few pixels unless the line crops them
                command = re.sub(r" --samples \S+" + ("" if " --crop " in line else r"| --size \S+"), "", command)
                more = " --samples 1" + ("" if " --crop " in line else " --size 60x40")
            done = sh(command + more)
            assert done.returncode == 0 and (done.stderr == "" or re.fullmatch(r"(cellwalk \w+: \S+: .* s\n)+", done.stderr)), (command + more, done.stderr)
            written = re.search(r" -o (\S+)", command)
            if written and more != " --help":
                os.unlink(written.group(1))


@pytest.mark.parametrize("program", NAMES)
def test_helps_fit(program):
    helps = [sh(f"{program} --help").stdout]
    names = commands(helps[0])
    helps += [sh(f"{program} {name} --help").stdout for name in names]
    assert len(names) >= 2 and all("\nOptions:\n" in text for text in helps[1:])
    assert max(len(line) for text in helps for line in text.splitlines()) <= 80
    version = re.search(r"project\(.*?VERSION (\S+)", open(f"{SOURCE}/CMakeLists.txt").read(), re.S).group(1)
    assert sh(f"{program} --version").stdout.splitlines()[0].endswith(f" {version}")


def test_map_fits_a_screen():
    """Without arguments: all that the program can do, with a task for each command, on a screen of 24 lines."""
    done = run()
    assert done.status != 0 and done.err.count("\n") <= 24
    tasks, names = done.err.partition("By task")[2], commands(done.err)
    assert len(names) > 5 and all(f" cellwalk {name} dem.tif" in tasks for name in names)
    for value in "0", "10.5", "nan", "0.1x":  # a bound of real numbers is told by its range
        done = sh(f"cellwalk-bench measure --width {value}")
        assert done.returncode == 2 and re.match(f"cellwalk-bench measure: --width takes a number from [0-9.e-]+ to 10, not '{value}'\n", done.stderr)
