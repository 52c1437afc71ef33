# SPDX-License-Identifier: Apache-2.0
"""DataArrays in, DataArrays out. Products by chunks have the bits of those of the whole raster, whatever is killed meanwhile."""
import contextlib
import itertools
import os
import signal
import weakref

import dask
import dask.array as da
import numpy as np
import pytest
import rasterio
import xarray as xr

import cellwalk as cw
import cellwalk.dask as cwd
from cellwalk._convert import read_crs
from conftest import PLACE, UTM, geotiff, random_rays, raster, rough, same, same_hits

ROWS, COLUMNS = 301, 263


def mountains():
    """Long slopes and peaks, so that shadows and horizons reach over many chunks; some holes."""
    y, x = np.mgrid[0:ROWS, 0:COLUMNS]
    z = 12 * rough(ROWS, COLUMNS, holes=False) + 700 * np.exp(-((x - 90) ** 2 + (y - 200) ** 2) / 300) + 2 * x
    z[(x > 200) & (y < 40) & (x < 230)] = np.nan
    return z.astype(np.float32)


@pytest.fixture(scope="module", params=["utm", "turned", "degrees"])
def file(request, tmp_path_factory):
    transform = {"utm": PLACE, "turned": (25, 5, 600000, 4, -28, 5200000), "degrees": (1 / 360, 0, 10.5, 0, -1 / 120, 67.25)}[request.param]
    return geotiff(tmp_path_factory.mktemp(request.param) / "dem.tif", mountains(), "EPSG:4326" if request.param == "degrees" else UTM, transform,
                   nodata=np.nan, tiled=True, blockxsize=64, blockysize=64)


def compute(result):
    return np.asarray(result.compute(scheduler="threads"))


SUNS = [(100, 12, 2.5), (101, 30, 0.25), (240, 3, 1)]


@pytest.mark.parametrize("name, arguments", [
    *(("shadow", arguments) for arguments in [
        {"azimuth": 225, "altitude": 30}, {"azimuth": 100, "altitude": 12}, {"azimuth": 340, "altitude": 4, "disc": 1.0}, {"azimuth": 45, "hillshade": True},
        {"azimuth": 0, "altitude": 60, "disc": True, "hillshade": True}, {"altitude": -1}, {"altitude": 90}, {"azimuth": 100, "altitude": 5, "curvature": 300}]),
    # Lower suns of a direction need more than higher ones: the chunk's window holds all that any of them needs.
    *(("insolation", arguments) for arguments in [
        {"date": "2024-12-21", "step": "1h"}, {"date": "2024-12-21", "to": "2024-12-23", "step": 3600, "directions": 30, "curvature": 300}, {"suns": SUNS},
        {"suns": [(90, 8), (0, -3)], "irradiance": True}, {"suns": [(9, -1)]}, {"date": "2024-06-21", "step": "4h", "irradiance": True, "sky": 5}]),
    ("horizon", {"directions": 5, "start": 3}), ("sky_view", {"directions": 6, "curvature": 50}), ("visibility", {"directions": 5}),
    # Within a distance a chunk needs less than the raster.
    *(("horizon", {"directions": 5, "start": 3, "curvature": 20, "max_distance": d}) for d in (700.0, 3000.0)),
    *(("sky_view", {"directions": 6, "tilted": True, "max_distance": d}) for d in (700.0, 3000.0)),
    *(("visibility", {"directions": 5, "max_distance": 900.0, "target_height": 3, "result": r}) for r in ("area", "share", "longest", "azimuth")),
    *(("viewshed", arguments) for arguments in [{}, {"max_distance": 2500.0}, {"max_distance": 900.0, "curvature": 0, "target_height": 5}]),
    *(("viewshed", {"needed": True, **arguments}) for arguments in [{}, {"max_distance": 2500.0}, {"max_distance": 900.0, "observer_elevation": 900}])])
def test_products(file, name, arguments):
    field, places = cw.open(file), ()
    if name == "viewshed":
        x0, y0, x1, y1 = field.bounds
        places = np.array([[x0 + 0.3 * (x1 - x0), x0 + 0.62 * (x1 - x0)], [y0 + 0.33 * (y1 - y0), y0 + 0.7 * (y1 - y0)]])
        places = places[:, 0] if "needed" in arguments else places
    wanted = getattr(field, name)(*places, **arguments)
    level = arguments.get("altitude") == 90 or arguments.get("suns") == [(9, -1)] or "observer_elevation" in arguments
    assert len(np.unique(wanted[np.isfinite(wanted)])) > 1 or level  # or anything would be the same
    same(compute(getattr(cwd, name)(file, *places, chunks=64, **arguments)), wanted)


def test_lowest_suns_of_directions():
    suns = np.array([(2, 9), (359, 4), (50, 60), (3, -9)], float)
    plan = cwd.Plan("insolation", None, {"directions": 8, "curvature": 7}, "", {}, inputs=(suns,))
    assert cwd._lights_of(plan) == [{"azimuth": azimuth, "altitude": altitude, "curvature": 7} for azimuth, altitude in ((0, 4), (45, 60))]


def blocks_of(file, chunks=64):
    return cwd._Raster(file, chunks, 1, None, None, None, 2e9)


def test_land_far_below_zero_and_a_file_written_again(tmp_path):
    """A step of half a metre 5 km away in 8000 m deep land throws a shadow over many chunks."""
    deep = np.full((4, 5200), -8000, "float32")
    deep[:, 4864] = -7999.5
    d = xr.DataArray(deep, dims=("y", "x"), coords={"y": [3.0, 2, 1, 0], "x": np.arange(5200.0)})
    low = np.degrees(np.arctan(0.5 / 4853.5))
    same(compute(cwd.shadow(d.chunk({"x": 32, "y": 4}), 90, low)), cw.Field(d).shadow(90, low).values)
    for z in mountains(), mountains()[::-1]:
        file = geotiff(tmp_path / "again.tif", z)
        same(compute(cwd.shadow(file, 225, 9, chunks=301)), np.asarray(cw.open(file).shadow(225, 9)))


def test_shadow_reaches_over_chunks(file):
    """The halo matters: without it some sample differs. And it is no more than the sun's side, and so high as shadows reach."""
    whole, chunk = cw.open(file), cw.open(file, (0, 192, 64, 64))
    assert (cw.Field(chunk.z, transform=chunk.map, crs=whole.crs).shadow(90, 8) != whole.shadow(90, 8)[192:256, 0:64]).any()
    (low, high), z = blocks_of(file).block_ranges(), whole.z
    assert low.shape == (2, 2) and low[0, 0] == np.nanmin(z[:256, :256]) and high[1, 0] == np.nanmax(z[256:, :256])
    reach = blocks_of(file).reach
    window = reach.matters(cwd._Window(0, 0, 64, 64), 0, (low, high, float(high.max())), [{"azimuth": 90, "altitude": 30}])
    assert window.columns < COLUMNS and window.row == 0 and window.rows < 80
    near = reach.matters(cwd._Window(64, 128, 64, 64), 700)
    assert near.rows * near.columns < ROWS * COLUMNS / 2 and near.row < 128 and near.row + near.rows > 192
    for chunks in (-1, 100, (301, 1), (37, 260)):  # blocks are those of the raster, however it is cut
        same(blocks_of(file, chunks).block_ranges(), (low, high))


def test_blocks_out_of_reach_are_not_looked_at():
    """The highest sample limits which blocks are looked at, and changes no window; too low a one does."""
    random = np.random.default_rng(3)
    place = ((10.0, 1, 0, 6e5), (0.5, -12, 0, 5e6), (0, 0, 1, 0))
    reach = cwd._Reach(cwd.Source(None, (40 * 256 + 9, 50 * 256 - 3), place, True, read_crs(None)._replace(unit=1.0), None))
    low = random.uniform(0, 300, (41, 50)).astype(np.float32)
    high = low + random.uniform(0, 900, low.shape).astype(np.float32) * (random.random(low.shape) < 0.2)
    differ = 0
    for _ in range(300):
        azimuth, altitude, disc = random.uniform(0, 360), random.choice([-2, 3, 10, 25, 60, 90]), random.choice([0, 1])
        window = cwd._Window(int(random.integers(0, 9000)), int(random.integers(0, 9000)), 700, 512)
        light = {"azimuth": azimuth, "altitude": altitude, "radius": disc}
        every, some, none = (reach.matters(window, 0, (low, high, top), [light]) for top in (1e30, float(high.max()), 310))
        assert every == some
        differ += none != every
    assert differ > 50


@pytest.mark.parametrize("placed", [True, False])
def test_chunked_dataarray(placed):
    """With coordinates, and without a map; a GeoTIFF has the place of the result."""
    z = mountains()
    d = xr.DataArray(np.where(np.isnan(z), -9999, z), dims=("y", "x"), attrs={"_FillValue": -9999.0},
                     coords={"y": 5e6 - 30.0 * np.arange(ROWS), "x": 6e5 + 30.0 * np.arange(COLUMNS)} if placed else None)
    chunked, field = d.chunk({"x": 50, "y": 90}), cw.Field(d)
    lit, wanted = cwd.shadow(chunked, 100, 10), field.shadow(100, 10)
    assert isinstance(lit, xr.DataArray) and lit.chunks == ((90, 90, 90, 31), (50, 50, 50, 50, 50, 13)) and lit.attrs == wanted.attrs
    same(lit.compute(scheduler="threads").values, wanted.values)
    assert (lit.x == d.x).all()
    packed = xr.DataArray(np.arange(9.0).reshape(3, 3), dims=("y", "x"))
    packed.encoding = {"_FillValue": 4, "scale_factor": 0.1}  # of what the file stores
    assert cw.Field(packed.assign_attrs(scale_factor=1.0, add_offset=0.0)).z[1, 1] == 4
    with pytest.raises(ValueError, match="mask_and_scale"):
        cw.Field(packed.assign_attrs(scale_factor=0.1))
    with pytest.warns(match="x and y are taken as metres") if placed else contextlib.nullcontext():
        feet = cw.Field(d.assign_attrs(units="ft"))
    assert feet.map[2, 2] == (0.3048 if placed else 1)
    x, y, near = (603000, 4996000, 1500) if placed else (100, 190, 50)
    same(compute(cwd.viewshed(chunked, x, y, max_distance=near)), field.viewshed(x, y, max_distance=near).values)
    same(compute(cwd.sky_view(chunked, 4)), field.sky_view(4).values)
    if placed:
        cwd.to_geotiff(cwd.shadow(d.chunk({"x": 256, "y": 256})), "shadow.tif")
        with rasterio.open("shadow.tif") as f:
            assert f.transform == rasterio.Affine(30, 0, 6e5 - 15, 0, -30, 5e6 + 15) and (f.nodata, f.compression.value) == (255, "PACKBITS")
            same(f.read(1), field.shadow().values)


@pytest.mark.parametrize("file", ["utm"], indirect=True)
@pytest.mark.parametrize("call, kind, words", [
    (lambda f: cwd.sky_view(f, memory=1e5), ValueError,
     "max_distance: None, so far mountains may count: a chunk needs 301 x 263 samples around it, 0.00 GB a task, more than"),
    (lambda f: cwd.horizon(f, 4, 2000, memory=1e5), ValueError, "max_distance: 2000: a chunk needs"),
    (lambda f: cwd.shadow(f, altitude=-1, memory=1e5), ValueError, "altitude: -1"),
    (lambda f: cwd.viewshed(f, *cw.open(f).bounds[:2], 5, memory=1e5), ValueError, "max_distance"),
    (lambda f: cwd.viewshed(f, 11, 47, max_distance=900), ValueError, r"x, y: \(11, 47\) has no ground under it within"),
    (lambda f: cwd.shadow(mountains()), TypeError, "source: ndarray"),
    (lambda f: cwd.viewshed(f, [1, 2], 3, needed=True), ValueError, "needed: that of one observer, not of 2"),
    *((lambda f, chunks=chunks: cwd.shadow(f, chunks=chunks), ValueError, "^chunks: .*for a raster of 301 x 263") for chunks in (0, -5, "many", (3, 3, 3))),
    (lambda f: cwd.shadow(f, nodata="none"), TypeError, "nodata: 'none'"),
    (lambda f: cwd.to_geotiff(da.zeros((10, 20), dtype="uint8"), "a.tif", like=f), ValueError, r"like: .* shape \(301, 263\), the result \(10, 20\)"),
    (lambda f: cwd.to_geotiff(da.zeros((0, 20), dtype="uint8"), "a.tif"), ValueError, r"result: shape \(0, 20\), expected numbers above 0"),
    (lambda f: cwd.to_geotiff(da.zeros((10, 20)), "a.tif"), TypeError, "result: dtype float64, expected uint8"),
    (lambda f: cwd.to_geotiff(3, "nowhere.tif"), TypeError, "result: int, expected an array of Dask")])
def test_what_is_too_much_is_said_before(file, call, kind, words):
    with pytest.raises(kind, match=words):
        call(file)


def test_chunks_are_written_as_they_are_done():
    """When a chunk is computed, the one before it is in the file, and its memory free."""
    made, alive = [], []

    def make(block_id):
        alive.append(sum(chunk() is not None for chunk in made))
        chunk = np.full((256, 256), sum(block_id), np.float32)
        made.append(weakref.ref(chunk))
        return chunk
    with dask.config.set(scheduler="synchronous"):
        cwd.to_geotiff(da.map_blocks(make, chunks=((256,) * 4, (256,) * 4), dtype=np.float32, meta=np.empty((0, 0), np.float32)), "a.tif")
    assert len(alive) == 16 and max(alive) <= 1
    same(raster("a.tif"), np.kron(np.add.outer(range(4), range(4)), np.ones((256, 256))).astype(np.float32))


@pytest.mark.parametrize("file", ["utm"], indirect=True)
def test_a_worker_is_killed(file):
    """Two processes; one is killed when it has computed a chunk and begun another. The file is the same, and no unfinished one remains."""
    from distributed import Client, LocalCluster, futures_of
    here = os.getcwd()
    os.mkfifo("pipe")

    def wait_in_the_second_chunk():
        """Runs in the worker. Both ends of a pipe open together."""
        rows, calls = cw.Field._rows, itertools.count(1)

        def held(self, *arguments):
            if next(calls) == 2:
                open(here + "/pipe").read()
            return rows(self, *arguments)
        cw.Field._rows = held

    with LocalCluster(n_workers=2, processes=True, threads_per_worker=1, dashboard_address=None, local_directory=here) as cluster, Client(cluster) as client:
        client.wait_for_workers(2)
        (victim, process), (_, other) = client.run(os.getpid).items()
        client.run(wait_in_the_second_chunk, workers=[victim])
        kept = client.persist(cwd.horizon(file, 16, chunks=40))
        with open("pipe", "w"):
            assert process != other and not all(chunk.done() for chunk in futures_of(kept))
            os.kill(process, signal.SIGKILL)
        cwd.to_geotiff(kept, "horizon.tif", file)
        assert process not in client.run(os.getpid).values()
    with rasterio.open("horizon.tif") as f, rasterio.open(file) as source:
        same(f.read(), cw.open(file).horizon(16))
        assert f.transform == source.transform and f.crs == source.crs
    assert not [name for name in os.listdir() if name.endswith((".part", ".tmp"))]


def test_zarr():
    """Workers write chunks there themselves."""
    d = dem()
    np.save("dem.npy", d.values)
    for k, (result, wanted) in enumerate([
            (cwd.shadow(d.chunk({"x": 32, "y": 32}), 100, 12), cw.Field(d).shadow(100, 12)),
            (cwd.horizon("dem.npy", 4, 20, chunks=32), cw.open("dem.npy").horizon(4, 20))]):
        result.to_dataset().to_zarr(f"{k}.zarr")
        back = xr.open_zarr(f"{k}.zarr", mask_and_scale=False)[result.name]
        assert back.chunks == result.chunks and (back.x == result.x).all()
        same(back.values, np.asarray(wanted))


# ---- DataArrays -----------------------------------------------------------------------------------------------------------


def dem(dtype=np.float64, y_step=-30.0, **attrs):
    z = rough()
    x, y = 600015 + 30.0 * np.arange(z.shape[1]), 5199985 + y_step * np.arange(z.shape[0])
    return xr.DataArray(z, dims=("y", "x"), coords={"y": y.astype(dtype), "x": x.astype(dtype)}, name="dem", attrs=attrs)


@pytest.mark.parametrize("y_step", [-30.0, 30.0])
def test_coordinates_are_centres(y_step):
    d = dem(y_step=y_step)
    field = cw.Field(d)
    i, j = 12, 33
    assert field.at(float(d.x[i]), float(d.y[j])) == d.values[j, i] and field.map[:2].tolist() == [[30, 0, 0, 600015], [0, y_step, 0, 5199985]]
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
        assert (got.x == d.x).all() and (got.y == d.y).all() and "spatial_ref" in got.coords and got.attrs["grid_mapping"] == "spatial_ref"
    h = d.cellwalk.horizon(4)
    assert h.dims == ("azimuth", "y", "x") and h.azimuth.values.tolist() == [0, 90, 180, 270]
    same(h.values, plain.horizon(4))
    assert "Sun and shadow" in d.cellwalk.shadow.__doc__
    coarse = field.coarser(4).shadow()
    assert coarse.x.values.tolist() == (600015 + 120.0 * np.arange(22)).tolist()
    assert coarse.y.values.tolist() == (5199985 - 120.0 * np.arange(16)).tolist()
    assert "spatial_ref" in coarse.coords and coarse.attrs["grid_mapping"] == "spatial_ref"
    same(coarse.values, plain.coarser(4).shadow())


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
