# SPDX-License-Identifier: Apache-2.0
"""The Python of papers/python.md and README runs and prints what the page says; its scripts are short enough to copy; everything public has a docstring,
and its examples run."""
import doctest
import importlib
import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest
from program import write

import cellwalk as cw

SOURCE = pathlib.Path(os.environ["CELLWALK_SOURCE"])
FOLDER, PAGE = SOURCE / "papers/scripts/examples", (SOURCE / "papers/python.md").read_text()
README = re.search(r"<!-- begin:python -->(.*?)<!-- end:python -->", (SOURCE / "README.md").read_text(), re.S)[1]
CODE, SHORT = ("\n".join(re.findall(r"```python\n(.*?)```", text, re.S)) for text in (PAGE, README))
SCRIPTS = {path.stem: path.read_text() for path in FOLDER.glob("*.py") if path.stem != "dem"}  # which the others share


@pytest.mark.parametrize("code, most, said", [
    *((code, 25, re.search(rf"python3 papers/scripts/examples/{name}\.py.*?```\n\n```text\n(.*?)```", PAGE, re.S)[1]) for name, code in SCRIPTS.items()),
    (CODE, None, None), (SHORT, 10, re.search(r"It prints `(.*?)`", README)[1] + "\n")], ids=[*SCRIPTS, "page", "README"])
def test_program(code, most, said):
    """Each from top to bottom in one go; the last argument names a picture."""
    done = subprocess.run([sys.executable, "-B", "-c", code, "light.png"], capture_output=True, text=True,
                          env={**os.environ, "MPLCONFIGDIR": os.getcwd(), "PYTHONPATH": f"{os.environ['PYTHONPATH']}:{FOLDER}"})
    assert done.returncode == 0, done.stderr
    if most:
        assert done.stdout == said and len(code.splitlines()) <= most and open("light.png", "rb").read(4) == b"\x89PNG"


@pytest.mark.parametrize("module", ["cellwalk", "cellwalk._field", "cellwalk._rays", "cellwalk._light", "cellwalk._sight"])
def test_doctests(module):
    result = doctest.testmod(importlib.import_module(module))
    assert result.failed == 0 and result.attempted > 2


def test_everything_public_is_described():
    things = {name: getattr(cw, name) for name in cw.__all__ if name != "__version__"}
    members = {name: member for kind in (cw.Field, cw.Hits) for name, member in vars(kind).items() if not name.startswith("_") and callable(member)}
    for name, thing in {**things, **members}.items():
        assert len(inspect.getdoc(thing) or "") > (30 if name in members else 0), name
    for name in ("closest", "occluded", "at", "update", "shadow", "viewshed", "horizon", "sky_view", "visibility", "line_of_sight"):
        assert ">>>" in getattr(cw.Field, name).__doc__, name
    widest = max((line for thing in [cw, *things.values(), *vars(cw.Field).values(), *vars(cw.Hits).values()]
                  for line in (inspect.getdoc(thing) or "").splitlines()), key=len)
    assert len(widest) <= 130, widest


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


def test_types():
    """A type checker passes the package and these programs, and refuses one that misuses it. Reading what xarray, pandas and Dask declare takes four times as
    long as all else, and says nothing of this package."""
    for name, text in {"wrong.py": WRONG, "page.py": SHORT, "mypy.ini": "[mypy]\n" + "".join(
            f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in ("xarray", "pandas", "dask", "distributed"))}.items():
        write(name, text)
    # In MYPYPATH the package is checked too.
    done = subprocess.run([sys.executable, "-m", "mypy", "--ignore-missing-imports", "wrong.py", "page.py", *FOLDER.glob("*.py")],
                          capture_output=True, text=True, env={**os.environ, "MYPYPATH": str(pathlib.Path(cw.__file__).parents[1])})
    told = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert {line.split(": ")[0] for line in told} == {f"wrong.py:{k}" for k in range(4, 1 + WRONG.count("\n"))}, done.stdout + done.stderr
