# SPDX-License-Identifier: Apache-2.0
"""The annotations are right: a type checker passes the package and a program that uses it, and refuses one that misuses it."""
import pathlib
import subprocess
import sys

import pytest

import cellwalk as cw

pytest.importorskip("mypy")

GOOD = """
import numpy as np
import cellwalk as cw
f = cw.Field(np.zeros((9, 9)), transform=(1, 0, 0, 0, -1, 9), threads=2)
g: cw.Field = cw.open("dem.tif", window=(0, 0, 4, 4)).coarser(2, "highest")
h: cw.Hits = f.closest([0, 0, 1], [[0, 0, -1]], tmax=np.inf)
places: np.ndarray = h[h.hit].points()
lit = f.shadow(azimuth=225, altitude=30, disc=True, curvature=6 / 7)
f.horizon(8, 2000, grid=True), f.sky_view(max_distance=5.5), f.viewshed([1, 2], 3, needed=False)
blocked: np.ndarray = f.line_of_sight((0, 0, 2), (4, 4, 2)).blocked_at
rows, columns = f.shape
f.update(0, 0, np.ones((2, 2)))
names: list[str] = [k.name for k in cw.kernels()]
"""
WRONG = """
import cellwalk as cw
f = cw.open("dem.tif")
f.shadow(azimuth="north")
f.horizon(directions=[1, 2])
f.sky_view(max_distance="far")
f.coarser("2")
f.closest(origin=[0, 0, 1])
f.shape.rows
f.line_of_sight((0, 0), (1, 1)).seen
cw.open(3)
cw.sun(12, 0, 0)
"""


def check(path, *words):
    return subprocess.run([sys.executable, "-m", "mypy", "--python-version", "3.11", *words], capture_output=True, text=True, cwd=path)


def test_package_and_programs(tmp_path):
    (tmp_path / "good.py").write_text(GOOD)
    (tmp_path / "wrong.py").write_text(WRONG)
    package = pathlib.Path(cw.__file__).parent
    done = check(package.parent, "-p", "cellwalk")
    assert done.returncode == 0, done.stdout
    assert check(tmp_path, "good.py").returncode == 0, check(tmp_path, "good.py").stdout
    told = {line.split(":")[1] for line in check(tmp_path, "wrong.py").stdout.splitlines() if ": error:" in line}
    assert told == {str(k) for k in range(4, 13)}
