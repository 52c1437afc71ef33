# SPDX-License-Identifier: Apache-2.0
"""A process with a decimal comma, as Qt and GTK set it: CELLWALK_TEST_COMMA names a locale that has one."""
import locale
import os

import numpy as np
import pytest

import cellwalk as cw
from conftest import UTM

WKT = ('PROJCS["metres and a half",GEOGCS["sphere",DATUM["sphere",SPHEROID["sphere",6371000.5,298.25]],PRIMEM["Greenwich",0],'
       'UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["half",0.5]]')


@pytest.fixture(autouse=True)
def comma():
    before = locale.setlocale(locale.LC_ALL)
    locale.setlocale(locale.LC_ALL, os.environ["CELLWALK_TEST_COMMA"])
    assert locale.localeconv()["decimal_point"] == ","
    yield
    locale.setlocale(locale.LC_ALL, before)


def test_numbers_have_a_point(tmp_path):
    path = tmp_path / "z.asc"
    path.write_text("ncols 3\nnrows 2\nxllcorner 10.25\nyllcorner -3.5\ncellsize 0.5\nnodata_value -9999.5\n1.5 2.25 -9999.5\n-0.125 1e-1 7\n")
    (tmp_path / "z.prj").write_text(WKT)
    field = cw.open(path)
    assert np.array_equal(field.z, np.float32([[1.5, 2.25, np.nan], [-0.125, 0.1, 7]]), equal_nan=True)
    assert field.bounds == (10.5, -3.25, 11.5, -2.75)
    assert cw._cellwalk.describe_crs(WKT) == (WKT, False, 0.5, 6371000.5, 298.25)


def test_places_are_the_same():
    """Through GDAL and PROJ."""
    z = np.add.outer(np.arange(40.0), np.arange(50.0) % 7).astype(np.float32)
    field = cw.Field(z, transform=(30.5, 0, 600000.25, 0, -30.5, 5200000.75), crs=UTM)
    light = field.shadow(time="2024-06-21T08:30Z").tobytes()
    locale.setlocale(locale.LC_ALL, "C")
    assert cw.Field(z, transform=(30.5, 0, 600000.25, 0, -30.5, 5200000.75), crs=UTM).shadow(time="2024-06-21T08:30Z").tobytes() == light
