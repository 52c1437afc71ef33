# SPDX-License-Identifier: Apache-2.0
import os
import tempfile

import pytest


@pytest.fixture(autouse=True)
def folder():
    """Each test works in a new folder."""
    home = os.getcwd()
    with tempfile.TemporaryDirectory(prefix="cellwalk-test-") as place:
        os.chdir(place)
        yield place
        os.chdir(home)
