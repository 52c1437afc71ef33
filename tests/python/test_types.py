# SPDX-License-Identifier: Apache-2.0
"""The annotations are right: a type checker passes the package and the programs of README and papers/python.md, and refuses one that misuses it."""
import os
import pathlib
import subprocess
import sys

import pytest
from program import write

import cellwalk as cw
from test_examples import FOLDER, SHORT

pytest.importorskip("mypy")

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
f.visibility(64, 5000, result=2)
f.viewshed([1, 2], 3, needed=0.5j)
"""


def test_package_and_programs():
    """Reading what xarray, pandas and Dask declare takes four times as long as all else, and says nothing of this package."""
    for name, text in {"wrong.py": WRONG, "page.py": SHORT, "mypy.ini": "[mypy]\n" + "".join(
            f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in ("xarray", "pandas", "dask", "distributed"))}.items():
        write(name, text)
    # In MYPYPATH the package is checked too.
    done = subprocess.run([sys.executable, "-m", "mypy", "--ignore-missing-imports", "wrong.py", "page.py", *FOLDER.glob("*.py")], capture_output=True, text=True,
                          env={**os.environ, "MYPYPATH": str(pathlib.Path(cw.__file__).parents[1])})
    told = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert {line.split(": ")[0] for line in told} == {f"wrong.py:{k}" for k in range(4, 1 + WRONG.count("\n"))}, done.stdout + done.stderr
