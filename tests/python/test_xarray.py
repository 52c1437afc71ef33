# SPDX-License-Identifier: Apache-2.0
"""DataArrays in, DataArrays out."""
import numpy as np
import pytest

xr = pytest.importorskip("xarray")

import cellwalk as cw  # noqa: E402
from conftest import random_rays, rough, same, same_hits  # noqa: E402


def dem(dtype=np.float64, y_step=-30.0, **attrs):
    z = rough()
    x, y = 600015 + 30.0 * np.arange(z.shape[1]), 5199985 + y_step * np.arange(z.shape[0])
    return xr.DataArray(z, dims=("y", "x"), coords={"y": y.astype(dtype), "x": x.astype(dtype)}, name="dem", attrs=attrs)


@pytest.mark.parametrize("y_step", [-30.0, 30.0])
def test_coordinates_are_centres(y_step):
    d = dem(y_step=y_step)
    field = cw.Field(d)
    i, j = 12, 33
    assert field.at(float(d.x[i]), float(d.y[j])) == d.values[j, i]
    assert field.map[:2].tolist() == [[30, 0, 0, 600015], [0, y_step, 0, 5199985]]
    rays = random_rays(field, 1000)
    same_hits(field.closest(rays), cw.Field(d.values, transform=(30, 0, 600000, 0, y_step, 5199985 - y_step / 2)).closest(rays))


def test_results_are_dataarrays():
    d = dem(grid_mapping="spatial_ref").assign_coords(spatial_ref=0)
    field = cw.Field(d)
    plain = cw.Field(d.values, transform=field.map)
    x, y = 601000.0, 5199000.0
    for got, wanted in ((field.shadow(), plain.shadow()), (field.sky_view(8), plain.sky_view(8)),
                        (field.viewshed(x, y), plain.viewshed(x, y)), (field.viewshed(x, y, needed=True), plain.viewshed(x, y, needed=True)),
                        (d.cellwalk.shadow(), plain.shadow()), (d.cellwalk.viewshed(x, y), plain.viewshed(x, y))):
        assert isinstance(got, xr.DataArray) and got.dims == ("y", "x")
        same(got.values, wanted)
        assert (got.x == d.x).all() and (got.y == d.y).all() and "spatial_ref" in got.coords
        assert got.attrs["grid_mapping"] == "spatial_ref"
    h = d.cellwalk.horizon(4)
    assert h.dims == ("azimuth", "y", "x") and h.azimuth.values.tolist() == [0, 90, 180, 270]
    same(h.values, plain.horizon(4))
    assert "Sun and shadow" in d.cellwalk.shadow.__doc__


def test_coarser_keeps_coordinates():
    d = dem(grid_mapping="spatial_ref").assign_coords(spatial_ref=0)
    got = cw.Field(d).coarser(4).shadow()
    assert got.x.values.tolist() == (600015 + 120.0 * np.arange(22)).tolist()
    assert got.y.values.tolist() == (5199985 - 120.0 * np.arange(16)).tolist()
    assert "spatial_ref" in got.coords and got.attrs["grid_mapping"] == "spatial_ref"
    same(got.values, cw.Field(d.values, transform=cw.Field(d).map).coarser(4).shadow())


def test_holes_and_crs():
    z = rough()
    d = dem(_FillValue=-9999.0)
    d = d.copy(data=np.where(np.isnan(z), np.float32(-9999), z))
    same(cw.Field(d).z, z)
    wkt = cw._convert.WGS84
    d = dem().assign_coords(spatial_ref=xr.DataArray(0, attrs={"crs_wkt": wkt}))
    assert cw.Field(d)._source.crs.geographic and cw.Field(d).crs == wkt
    lonlat = xr.DataArray(z, dims=("lat", "lon"), coords={"lat": 47 - np.arange(61) / 1200, "lon": 10 + np.arange(83) / 1200})
    assert cw.Field(lonlat)._source.crs.geographic
    assert cw.Field(xr.DataArray(z, dims=("y", "x"))).map.tolist() == np.eye(3, 4).tolist()


def test_band_and_chunks():
    pytest.importorskip("dask")
    computed = []
    chunked = dem().expand_dims("band").chunk({"x": 20, "y": 20})
    chunked = chunked.copy(data=chunked.data.map_blocks(lambda z: computed.append(z.shape) or z, meta=rough()[None]))
    same(cw.Field(chunked).shadow().values, cw.Field(dem()).shadow().values)
    assert len(computed) == 20  # each chunk once


def test_spacing():
    """Float32 coordinates are rounded; others must be regular."""
    lon = (10 + np.arange(83) / 1200).astype(np.float32)
    d = xr.DataArray(rough(), dims=("lat", "lon"), coords={"lat": 47 - np.arange(61) / 1200, "lon": lon})
    assert abs(cw.Field(d).map[0, 0] * 1200 - 1) < 1e-3
    d = dem()
    for wrong, words in ((d.assign_coords(x=d.x + 2 * (np.arange(83) == 40)), r"z.x: irregular spacing: number 40 is 601217"),
                         (d.transpose("x", "y"), "use .transpose"), (xr.concat([d, d], "time"), "expected .y, x.; choose one")):
        with pytest.raises(ValueError, match=words):
            cw.Field(wrong)
