# SPDX-License-Identifier: Apache-2.0
"""The examples of --help run as they stand, on files made here: exit status 0 and nothing on standard error. Examples of cellwalk-bench would take
minutes, so only their command lines are checked, by --help behind all other arguments. No help is wider than 80 columns."""
import json
import os
import re
import subprocess

import numpy as np
import pytest
from program import BENCH, PROGRAM, SCENE, asc, on_map, rays, run, takes, vrt, write

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
        write(f"{name}.gpkg", json.dumps({
            "type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}},
            "features": [{"type": "Feature", "properties": {}, "geometry": {"type": kind, "coordinates": places}}]}))
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
    environment = {"ASAN_OPTIONS": "symbolize=0", **os.environ, "PATH": f"{os.getcwd()}/bin:{os.environ['PATH']}"}
    return subprocess.run(line, shell=True, capture_output=True, text=True, env=environment)


def subcommands(help):
    return re.findall(r"\n  (\S+) ", re.search(r"Commands:((?:\n  .*)+)", help).group(1))


@pytest.fixture(scope="module")
def lacking():
    """Endings of formats that this build lacks."""
    version = run("--version").out
    return [ending for ending, library in {".tif": "GDAL     yes", ".gpkg": "GDAL     yes", ".exr": "OpenEXR  yes", ".png": "libpng   yes"}.items()
            if library not in version]


def run_example(line, lacking):
    if any(ending in line for ending in lacking):
        print(f"skipped: {line}")
        return
    command = re.sub(r" > .*", "", line.split("#")[0])
    more = ""
    if not line.startswith("cellwalk ") or " --isa " in line:  # an instruction set may be missing on this machine
        more = " --help"
    elif line.startswith("cellwalk render "):  # one sample a pixel, and few pixels unless the line crops them: later options win
        more = " --samples 1" + ("" if " --crop " in line else " --size 60x40")
    done = sh(command + more)
    assert done.returncode == 0 and (done.stderr == "" or re.fullmatch(r"cellwalk \w+: \S+: .* s\n", done.stderr)), (command + more, done.stderr)
    written = re.search(r" -o (\S+)", command)
    if written and more != " --help":
        os.unlink(written.group(1))


def run_examples(text, program, lacking):
    """Each line that begins with the program's name, or has it behind a gap; lines that end in a backslash go on."""
    lines = re.findall(rf"(?<=  ){program} .*", text.replace("\\\n", ""))
    for k, line in enumerate(lines):
        if takes(k, 4):
            run_example(line, lacking)
    assert lines


@pytest.mark.parametrize("program", NAMES)
def test_examples(program, lacking):
    help = sh(f"{program} --help").stdout
    run_examples(help.replace("X,Y", "600250,5199800"), program, lacking)  # stands for a place
    for name in subcommands(help):
        run_examples(sh(f"{program} {name} --help").stdout.partition("\nExamples:\n")[2], program, lacking)


@pytest.mark.parametrize("program", NAMES)
def test_helps_fit(program):
    helps = [sh(f"{program} --help").stdout]
    names = subcommands(helps[0])
    helps += [sh(f"{program} {name} --help").stdout for name in names]
    assert len(names) >= 2 and all("\nOptions:\n" in text for text in helps[1:])
    assert max(len(line) for text in helps for line in text.splitlines()) <= 80
    version = re.search(r"VERSION (\S+)", open(f"{os.environ['CELLWALK_SOURCE']}/CMakeLists.txt").read().partition("project(")[2]).group(1)
    assert sh(f"{program} --version").stdout.splitlines()[0].endswith(f" {version}")


@pytest.mark.parametrize("value", ["0", "10.5", "nan", "0.1x"])
def test_ranges_of_real_numbers(value):
    """A bound of them is told by its range."""
    done = sh(f"cellwalk-bench measure --width {value}")
    assert done.returncode == 2 and re.match(f"cellwalk-bench measure: --width takes a number from [0-9.e-]+ to 10, not '{value}'\n", done.stderr)


def test_map_fits_a_screen():
    """Without arguments: all that the program can do, with a task for each command, on a screen of 24 lines."""
    done = run()
    assert done.status != 0 and done.err.count("\n") <= 24
    tasks, names = done.err.partition("By task")[2], subcommands(done.err)
    assert len(names) > 5 and all(f" cellwalk {name} dem.tif" in tasks for name in names)
