# SPDX-License-Identifier: Apache-2.0
"""The annotations are right: a type checker passes the package and a program that uses it, and refuses one that misuses it."""
import os
import pathlib
import subprocess
import sys

import pytest

import cellwalk as cw

pytest.importorskip("mypy")

GOOD = """
import numpy as np
import cellwalk as cw
import cellwalk.dask as cwd
f = cw.Field(np.zeros((9, 9)), transform=(1, 0, 0, 0, -1, 9), threads=2)
g: cw.Field = cw.open("dem.tif", window=(0, 0, 4, 4)).coarser(2, "highest")
h: cw.Hits = f.closest([0, 0, 1], [[0, 0, -1]], tmax=np.inf)
places: np.ndarray = h[h.hit].points()
lit = f.shadow(azimuth=225, altitude=30, disc=True, curvature=6 / 7)
f.horizon(8, 2000), f.sky_view(max_distance=5.5), f.viewshed([1, 2], 3, needed=False)
f.visibility(64, 5000, observer_height=0, target_height=2, result="share")
blocked: np.ndarray = f.line_of_sight((0, 0, 2), (4, 4, 2)).blocked_at
rows, columns = f.shape
f.update(0, 0, np.ones((2, 2)))
cwd.to_geotiff(cwd.sky_view("dem.tif", 16, 3000, chunks=2048), "sky.tif")
names: list[str] = [k.name for k in cw.kernels()]
"""
WRONG = """
import cellwalk as cw, cellwalk.dask as cwd
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
cwd.viewshed("dem.tif", 1, 2, max_distance="far")
"""


def test_package_and_programs(tmp_path):
    (tmp_path / "good.py").write_text(GOOD)
    (tmp_path / "wrong.py").write_text(WRONG)
    # Reading what xarray, pandas and Dask declare takes four times as long as all else, and says nothing of this package.
    (tmp_path / "mypy.ini").write_text("[mypy]\n" + "".join(f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in ("xarray", "pandas", "dask", "distributed")))
    package = pathlib.Path(cw.__file__).parent
    # In MYPYPATH the package is checked too.
    done = subprocess.run([sys.executable, "-m", "mypy", "--python-version", "3.11", "good.py", "wrong.py"], capture_output=True, text=True,
                          cwd=tmp_path, env={**os.environ, "MYPYPATH": str(package.parent)})
    told = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert {line.split(": ")[0] for line in told} == {f"wrong.py:{k}" for k in range(4, 14)}, done.stdout + done.stderr
