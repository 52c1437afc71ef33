# SPDX-License-Identifier: Apache-2.0
"""Every public name has a docstring, and its examples run."""
import doctest
import importlib
import inspect

import pytest

import cellwalk as cw


@pytest.mark.parametrize("module", ["cellwalk", "cellwalk._field", "cellwalk._hits", "cellwalk._light", "cellwalk._sight"])
def test_examples(module):
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
