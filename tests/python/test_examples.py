# SPDX-License-Identifier: Apache-2.0
"""The scripts of papers/python.md run, print what the page says, and are short enough to copy; everything public has a docstring, and its examples run."""
import doctest
import importlib
import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest

import cellwalk as cw

SOURCE = pathlib.Path(os.environ.get("CELLWALK_SOURCE", pathlib.Path(__file__).parents[2]))
FOLDER = SOURCE / "papers/scripts/examples"
PAGE = (SOURCE / "papers/python.md").read_text()


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.py")))
def test_example(name, tmp_path):
    script = FOLDER / f"{name}.py"
    assert len(script.read_text().splitlines()) <= 25
    if name == "dem":  # what the others share
        return
    done = subprocess.run([sys.executable, "-B", script, tmp_path / "picture.png"], capture_output=True, text=True,
                          env={**os.environ, "MPLCONFIGDIR": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    said = re.search(rf"python3 papers/scripts/examples/{name}\.py.*?```\n\n```text\n(.*?)```", PAGE, re.S)
    assert said, f"papers/python.md does not say what {name}.py prints"
    assert done.stdout == said[1]


def test_the_page_runs():
    """The page's Python, from top to bottom in one go."""
    code = "\n".join(re.findall(r"```python\n(.*?)```", PAGE, re.S))
    done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, cwd=FOLDER)
    assert done.returncode == 0, done.stderr


def test_readme(tmp_path):
    part = re.search(r"<!-- begin:python -->(.*?)<!-- end:python -->", (SOURCE / "README.md").read_text(), re.S)[1]
    code = re.search(r"```python\n(.*?)```", part, re.S)[1]
    assert len(code.splitlines()) <= 10
    done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"It prints `{done.stdout.strip()}`" in part
    assert (tmp_path / "light.png").exists()


@pytest.mark.parametrize("module", ["cellwalk", "cellwalk._field", "cellwalk._hits", "cellwalk._light", "cellwalk._sight"])
def test_doctests(module):
    result = doctest.testmod(importlib.import_module(module))
    assert result.failed == 0 and result.attempted > 2


def test_everything_public_is_described():
    for name in cw.__all__:
        if name != "__version__":
            assert inspect.getdoc(getattr(cw, name)), name
    for kind in (cw.Field, cw.Hits):
        for name, member in vars(kind).items():
            if not name.startswith("_") and callable(member):
                assert inspect.getdoc(member) and len(inspect.getdoc(member)) > 30, name
    for name in ("closest", "occluded", "at", "update", "shadow", "viewshed", "horizon", "sky_view", "visibility", "line_of_sight"):
        assert ">>>" in getattr(cw.Field, name).__doc__, name
    documented = [cw, *(getattr(cw, name) for name in cw.__all__ if name != "__version__"), *vars(cw.Field).values(), *vars(cw.Hits).values()]
    widest = max((line for thing in documented for line in (inspect.getdoc(thing) or "").splitlines()), key=len)
    assert len(widest) <= 130, widest
