# SPDX-License-Identifier: Apache-2.0
"""Products by chunks have the bits of those of the whole raster, whatever is killed meanwhile."""
import os
import signal

import numpy as np
import pytest

rasterio = pytest.importorskip("rasterio")
xr = pytest.importorskip("xarray")
pytest.importorskip("distributed")

import cellwalk as cw  # noqa: E402
import cellwalk.dask as cwd  # noqa: E402
from conftest import UTM, rough, same  # noqa: E402

ROWS, COLUMNS = 301, 263


def mountains():
    """Long slopes and peaks, so that shadows and horizons reach over many chunks; some holes."""
    y, x = np.mgrid[0:ROWS, 0:COLUMNS]
    z = 12 * rough(ROWS, COLUMNS, holes=False) + 700 * np.exp(-((x - 90) ** 2 + (y - 200) ** 2) / 300) + 2 * x
    z[(x > 200) & (y < 40) & (x < 230)] = np.nan
    return z.astype(np.float32)


@pytest.fixture(scope="module", params=["utm", "turned", "degrees"])
def file(request, tmp_path_factory):
    transform = {"utm": rasterio.Affine(30, 0, 600000, 0, -30, 5200000), "turned": rasterio.Affine(25, 5, 600000, 4, -28, 5200000),
                 "degrees": rasterio.Affine(1 / 360, 0, 10.5, 0, -1 / 120, 67.25)}[request.param]
    path = tmp_path_factory.mktemp(request.param) / "dem.tif"
    with rasterio.open(path, "w", driver="GTiff", width=COLUMNS, height=ROWS, count=1, dtype="float32", transform=transform, nodata=np.nan,
                       crs="EPSG:4326" if request.param == "degrees" else UTM, tiled=True, blockxsize=64, blockysize=64) as f:
        f.write(mountains(), 1)
    return path


def compute(result):
    return np.asarray(result.compute(scheduler="threads"))


@pytest.mark.parametrize("arguments", [
    {"azimuth": 225, "altitude": 30}, {"azimuth": 100, "altitude": 12}, {"azimuth": 340, "altitude": 4, "disc": 1.0},
    {"azimuth": 45, "altitude": 20, "hillshade": True}, {"azimuth": 0, "altitude": 60, "disc": True, "hillshade": True}, {"altitude": -1},
    {"altitude": 90}])
def test_shadow(file, arguments):
    same(compute(cwd.shadow(file, chunks=64, **arguments)), cw.open(file).shadow(**{"azimuth": 225, "altitude": 30, **arguments}))


def test_shadow_reaches_over_chunks(file):
    """The halo matters: without it some sample differs."""
    lit = cw.open(file).shadow(90, 8)
    alone = cw.Field(cw.open(file, (0, 192, 64, 64)).z, transform=cw.open(file, (0, 192, 64, 64)).map, crs=cw.open(file).crs).shadow(90, 8)
    assert (alone != lit[192:256, 0:64]).any()
    window = cwd._sunward(cwd._Raster(file, 64, 1, None, None, None, 2e9).geometry, cwd._Window(0, 0, 64, 64), 0, 800, 90, 30, 0)
    assert window.columns < COLUMNS and window.row == 0 and window.rows < 80  # and it is no more than what is needed


def test_horizon_and_sky_view(file):
    same(compute(cwd.horizon(file, 5, start=3, chunks=100)), cw.open(file).horizon(5, start=3))
    same(compute(cwd.sky_view(file, 6, chunks=100)), cw.open(file).sky_view(6))


def test_viewshed(file):
    field = cw.open(file)
    x0, y0, x1, y1 = field.bounds
    x, y = [x0 + 0.3 * (x1 - x0), x0 + 0.62 * (x1 - x0)], [y0 + 0.33 * (y1 - y0), y0 + 0.7 * (y1 - y0)]
    for arguments in ({}, {"max_distance": 2500.0}, {"max_distance": 900.0, "curvature": 0, "target_height": 5}):
        wanted = field.viewshed(x, y, **arguments)
        assert (wanted == 1).any() and (wanted == 0).any()
        same(compute(cwd.viewshed(file, x, y, chunks=70, **arguments)), wanted)


def test_chunked_dataarray():
    z = mountains()
    d = xr.DataArray(np.where(np.isnan(z), -9999, z), dims=("y", "x"), attrs={"_FillValue": -9999.0},
                     coords={"y": 5e6 - 30.0 * np.arange(ROWS), "x": 6e5 + 30.0 * np.arange(COLUMNS)})
    lit = cwd.shadow(d.chunk({"x": 50, "y": 90}), 100, 10)
    assert isinstance(lit, xr.DataArray) and lit.chunks == ((90, 90, 90, 31), (50, 50, 50, 50, 50, 13))
    wanted = cw.Field(d).shadow(100, 10)
    same(lit.compute(scheduler="threads").values, wanted.values)
    assert (lit.x == d.x).all() and lit.attrs == wanted.attrs
    same(compute(cwd.sky_view(d.chunk({"x": 100, "y": 90}), 4)), cw.Field(d).sky_view(4).values)
    same(compute(cwd.viewshed(d.chunk({"x": 100, "y": 90}), 603000, 4996000, max_distance=1500)),
         cw.Field(d).viewshed(603000, 4996000, max_distance=1500).values)


def test_without_a_map():
    d = xr.DataArray(mountains(), dims=("y", "x"))
    field, chunked = cw.Field(d), d.chunk({"x": 60, "y": 60})
    same(compute(cwd.shadow(chunked, 20, 40)), field.shadow(20, 40).values)
    same(compute(cwd.viewshed(chunked, 100, 190, max_distance=50)), field.viewshed(100, 190, max_distance=50).values)


def test_what_is_too_much_is_said_before(file):
    with pytest.raises(ValueError, match=r"sky_view: far mountains may count: a chunk needs 301 x 263 samples around it, 0.00 GB a task, more than"):
        cwd.sky_view(file, memory=1e5)
    with pytest.raises(ValueError, match="altitude: -1"):
        cwd.shadow(file, altitude=-1, memory=1e5)
    with pytest.raises(ValueError, match="max_distance"):
        cwd.viewshed(file, *cw.open(file).bounds[:2], 5, memory=1e5)
    with pytest.raises(TypeError, match="source: ndarray"):
        cwd.shadow(mountains())


def test_a_worker_is_killed(file, tmp_path):
    """Two processes; the first to be at work is killed. The file is the same, and no unfinished one remains."""
    from distributed import Client, LocalCluster
    wanted = cw.open(file).horizon(8)
    with LocalCluster(2, processes=True, threads_per_worker=1, dashboard_address=None, local_directory=str(tmp_path)) as cluster:
        with Client(cluster) as client:
            before = client.run(os.getpid)
            assert len(set(before.values())) == 2
            result = cwd.horizon(file, 8, chunks=40)
            assert not isinstance(getattr(result, 'data', result), np.ndarray)
            kept = client.persist(result)
            os.kill(next(iter(before.values())), signal.SIGKILL)
            cwd.to_geotiff(kept, tmp_path / "horizon.tif", file)
            client.wait_for_workers(2)
            assert set(client.run(os.getpid).values()) != set(before.values())
    with rasterio.open(tmp_path / "horizon.tif") as f, rasterio.open(file) as source:
        same(f.read(), wanted)
        assert f.transform == source.transform and f.crs == source.crs
    assert not list(tmp_path.glob("*.part"))
