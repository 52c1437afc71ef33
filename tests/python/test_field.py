# SPDX-License-Identifier: Apache-2.0
"""What a field is made of, its holes, its map, its updates."""
import copy
import inspect
import pickle

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hn
from program import write

import cellwalk as cw
from conftest import UTM, geotiff, random_rays, rough, same, same_hits, share


def ask(field):
    return field.closest(random_rays(field, 2000))


def test_forms_of_samples():
    z = rough(holes=False)
    wanted = ask(cw.Field(z))
    padded = np.zeros((z.shape[0], z.shape[1] + 5), np.float32)
    padded[:, 2:-3] = z
    for form in (z.astype(">f4"), np.asfortranarray(z), padded[:, 2:-3], z.astype(np.float64), z[::-1][::-1], z.tolist()):
        same_hits(ask(cw.Field(form)), wanted)
    whole = np.round(z * 100)
    for dtype in (np.int16, np.int32, np.int64, np.float64):
        same_hits(ask(cw.Field(whole.astype(dtype))), ask(cw.Field(whole)))


def test_contiguous_floats_are_not_copied_nor_changed():
    z = rough()
    before = z.copy()
    field = cw.Field(z)
    assert np.shares_memory(field.z, z) and not np.shares_memory(cw.Field(z, copy=True).z, z)
    ask(field)
    field.shadow()
    field.update(0, 0, np.ones((4, 4)))
    same(z, before)
    assert not np.shares_memory(field.z, z)
    with pytest.raises(ValueError):
        field.z[0, 0] = 1


def test_holes():
    z, lowest = rough(), np.finfo(np.float32).min
    wanted, (filled, low, infinite) = ask(cw.Field(z)), (np.where(np.isnan(z), np.float32(value), z) for value in (-9999, lowest, np.inf))
    for form, nodata in ((filled, -9999), (np.ma.masked_invalid(z), None), (np.ma.MaskedArray(filled, filled == -9999), None), (infinite, None),
                         (filled.astype(np.float64), -9999), (low, -3.4028234663852886e38)):  # the last as headers spell it in double
        before = form.copy()
        same_hits(ask(cw.Field(form, nodata=nodata)), wanted)
        same(np.ma.getdata(form), np.ma.getdata(before))
    assert cw.Field(z).shadow()[11, 22] == 255


@settings(deadline=None, max_examples=share(40))
@given(z=hn.arrays(st.sampled_from([np.float32, np.float64, np.int16, np.uint8]), st.tuples(st.integers(2, 40), st.integers(2, 40)),
                   elements={"min_value": 0, "max_value": 200}), data=st.data())
def test_update_is_a_new_field(z, data):
    field = cw.Field(z)
    row, column = data.draw(st.integers(0, z.shape[0] - 1)), data.draw(st.integers(0, z.shape[1] - 1))
    block = data.draw(hn.arrays(np.float32, st.tuples(st.integers(0, z.shape[0] - row), st.integers(0, z.shape[1] - column)),
                                elements=st.floats(0, 300, width=32)))
    field.update(row, column, block)
    changed = z.astype(np.float32)
    changed[row:row + block.shape[0], column:column + block.shape[1]] = block
    same(field.z, changed)
    same_hits(ask(field), ask(cw.Field(changed)))
    assert repr(field) == repr(cw.Field(changed))


def test_an_update_copies_samples_of_others(monkeypatch):
    """Also where it had no memory for that before, and where they came read-only, as from Dask."""
    z, buffers = np.zeros((9, 9), "f4"), []
    field = cw.Field(z)
    sent = pickle.loads(pickle.dumps(field, 5, buffer_callback=buffers.append), buffers=map(bytes, buffers))
    with monkeypatch.context() as patch, pytest.raises(MemoryError):
        patch.setattr(cw._field, "Core", lambda *_: (_ for _ in ()).throw(MemoryError()))
        field.update(0, 0, [[1]])
    for one in field, sent:
        one.update(0, 0, [[1]])
        assert one.at(0, 0) == 1 and z[0, 0] == 0


def test_update_that_is_refused():
    field = cw.Field(rough(holes=False))
    wanted = ask(field)
    for row, block, words in ((3, np.full((5, 5), 2e30, np.float32), r"block: sample \(3, 3\) is 2e"), (-1, np.zeros((5, 5)), "row: -1"),
                              (60, np.zeros((5, 5)), r"block: shape \(5, 5\) at \(60, 3\) goes beyond the field's \(61, 83\)")):
        with pytest.raises(ValueError, match=words):
            field.update(row, 3, block)
        same_hits(ask(field), wanted)
    field.update(0, 0, np.full((1, 3), np.inf))
    assert np.isnan(field.z[0, :3]).all()


def test_maps():
    z, affine = rough(), pytest.importorskip("affine").Affine(30, 2, 600000, 1, -30, 5200000)
    field = cw.Field(z, transform=affine, crs=UTM)
    for form in (tuple(affine)[:6], np.array(affine).reshape(3, 3), field.map):
        same_hits(ask(cw.Field(z, transform=form)), ask(field))
    assert field.transform == pytest.approx(tuple(affine)[:6], rel=1e-14) and field.at(*affine * (10.5, 20.5)) == pytest.approx(z[20, 10], abs=1e-4)


@pytest.mark.parametrize("call, kind, words", [
    (lambda f: cw.Field(np.zeros((3, 3, 3))), ValueError, r"z: shape \(3, 3, 3\), expected \(rows, columns\)"),
    (lambda f: cw.Field(np.zeros((1, 3))), ValueError, r"z: shape \(1, 3\), expected at least 2 rows"),
    (lambda f: cw.Field(np.broadcast_to(np.float32(0), (2, 2**23 + 1))), ValueError, r"z: shape \(2, 8388609\), expected .* at most 8388608"),
    (lambda f: cw.Field(np.array([["a", "b"], ["c", "d"]])), TypeError, "z: dtype <U1"),
    (lambda f: cw.Field(np.array([[0, 1e300], [0, 0]])), ValueError, r"z: the sample at \(0, 1\) is 1e\+300, beyond the range"),
    (lambda f: cw.Field(np.full((3, 3), 1e35, np.float32)), ValueError, "z: sample"),
    (lambda f: cw.Field(np.zeros((3, 3)), transform=(1, 2, 3)), ValueError, r"transform: shape \(3,\)"),
    (lambda f: cw.Field(np.zeros((3, 3)), transform=(0, 0, 3, 0, 0, 3)), ValueError, r"transform: \(0.0, 0.0, 3.0, 0.0, 0.0, 3.0\), expected finite"),
    (lambda f: cw.Field(np.zeros((3, 3)), transform=(1, 0, np.nan, 0, 1, 3)), ValueError, "transform: "),
    (lambda f: cw.Field(np.zeros((3, 3)), transform=(600000, 10, 0, 5200000, 0, -10)), ValueError, "Affine.from_gdal"),
    (lambda f: cw.Field(np.zeros((3, 3)), transform="abc"), TypeError, "transform: 'abc', expected an Affine or numbers"),
    (lambda f: cw.Field(np.zeros((3, 3)), nodata="none"), TypeError, "nodata: 'none', expected a number"),
    (lambda f: cw.Field(np.zeros((3, 3)), band=2), ValueError, "band: 2, but z is an array"),
    (lambda f: cw.Field(np.zeros((3, 3)), threads=-1), ValueError, "threads: -1, expected 0 to 4096"),
    (lambda f: f.horizon(np.arange(2)), TypeError, r"directions: array\(\[0, 1\]\), expected an integer"),
    (lambda f: cw.Field(np.zeros((3, 3)), zscale=0), ValueError, "zscale: 0"),
    (lambda f: cw.Field(np.zeros((3, 3)), progress=3), TypeError, "progress: 3"),
    (lambda f: cw.Field("dem.tif"), TypeError, "z: 'dem.tif' is a path; use cellwalk.open"),
    (lambda f: f.shadow(altitude=91), ValueError, "altitude: 91, expected a finite number from -90 to 90"),
    (lambda f: f.shadow(5, 5, time="2024-01-01T00:00:00Z"), ValueError, "time: goes without"),
    (lambda f: f.coarser(1), ValueError, "factor: 1, expected 2 to"),
    (lambda f: f.shadow(1e300, 5), ValueError, r"^shadow: azimuth: 1e\+300"),
    (lambda f: f.visibility(4, curvature=1e300), ValueError, "^curvature: 1e.300, expected a finite number from 0 to 1e"),
    (lambda f: f.viewshed(1e9, 5), ValueError, r"x, y: \(1000000000, 5, 2\) is too far"),
    (lambda f: f.viewshed(-5, 5), ValueError, r"x, y: \(-5, 5, 2\) has no ground"),
    (lambda f: f.viewshed([1, 2], 3, needed=True), ValueError, "needed: .* not of 2"),
    (lambda f: f.line_of_sight((1, 2, 3, 4), (1, 2)), ValueError, r"a: shape \(4,\)"),
    (lambda f: f.line_of_sight((1, 2, 3), (-7, 2)), ValueError, r"b: \(-7, 2, 0\) has no ground under it"),
    (lambda f: f.line_of_sight((1e12, 2, 3), (7, 2)), ValueError, r"a: \(1e\+12, 2, 3\) is too far away"),
    (lambda f: f.line_of_sight((1, 2), [(7, 2, 1), (8, 2, -3)]), ValueError, r"b: \(8, 2, -3\) is under the ground"),
    (lambda f: f.line_of_sight((1, 2), (7, 2), absolute=(True,)), TypeError, r"absolute: \(True,\), expected"),
    (lambda f: f.viewshed(5, 5, weights=1, bands=True), ValueError, "weights: adds observers up"),
    (lambda f: f.viewshed(5, 5, azimuth=90), ValueError, "azimuth: 90, expected two angles"),
    (lambda f: f.viewshed(5, 5, needed=True, target_height=3), ValueError, "^target_height: .* needed looks for"),
    (lambda f: f.viewshed(5, 5, vertical=(9, 3)), ValueError, "vertical: .* the lower angle first"),
    (lambda f: f.sites(5, 5, within=np.ones((2, 2))), ValueError, r"within: shape \(2, 2\), expected the field's"),
    (lambda f: f.line_of_sight((1, 2), (3, 4), frequency=0), ValueError, "frequency: 0"),
    (lambda f: f.viewshed(5, 5, -3), ValueError, r"x, y: \(5, 5, -3\) is under the ground"),
    (lambda f: f.viewshed(5, 5, observer_elevation=-99), ValueError, r"x, y: \(5, 5, -99\) is under the ground"),
    (lambda f: f.viewshed([5, 6], [1, 2, 3]), ValueError, r"x \(2,\), y \(3,\), observer_height \(\)"),
    (lambda f: f.viewshed(5, 5, target_height=-5), ValueError, "target_height: -5, expected a finite number from 0 on"),
    (lambda f: cw.open("z.npy", cellsize=0), ValueError, "cellsize: 0, expected a number above 0"),
    (lambda f: f.horizon(8, max_distance=0), ValueError, "max_distance: 0, expected metres above 0"),
    (lambda f: f.sky_view(8, curvature=-1), ValueError, "curvature: -1, expected"),
    (lambda f: f.closest(np.zeros((3, 6)), tmin=[1, 2]), ValueError, r"tmin: shape \(2,\) does not broadcast to that of the rays, \(3,\)"),
    (lambda f: f.sun_days(5, 5, "2024-06-21", height=2.0, elevation=9, lon_lat=(9, 47)), ValueError, "^height: goes without elevation"),
    (lambda f: f.viewshed(5, 5, 2.0, observer_elevation=9), ValueError, "^observer_height: goes without"),
    (lambda f: f.viewshed([1, 8], 1, every=0), ValueError, "metres above 0"),
    (lambda f: f.viewshed(3, 1, every=1), ValueError, "two corners"),
    (lambda f: f.viewshed([1, 8], 1, every=1e-9), ValueError, "every: there are more"),
    (lambda f: f.viewshed([1, 8], 1, every=1e-4), ValueError, "at most 65534"),
    (lambda f: f.insolation(suns=[(1, 91)]), ValueError, "^suns: .*altitudes from -90"),
    (lambda f: f.insolation(suns=np.empty((0, 3))), ValueError, "^suns: .*shape"),
    (lambda f: cw.Field(f.z, transform=(1e-3, 0, 7, 0, -1e-3, 47), crs="EPSG:4326").insolation("2024", lon_lat=(1, 2)), ValueError, "^lon_lat: is for fields without"),
    (lambda f: f.insolation("2024", suns=[(1, 2)]), ValueError, "^suns: goes without date"),
    (lambda f: cw.Field(np.zeros((9, 9)), transform=(1, 0, 0, 0, -1, 99), crs="EPSG:4326").viewshed(4, 94), ValueError, "latitudes beyond 90 degrees$"),
    (lambda f: cw.Field(f.z, crs="EPSG:4326"), ValueError, "^crs: is in degrees, and without a transform"),
    (lambda f: cw.sun("yesterday\0", 0, 0), ValueError, r"time: 'yesterday\\x00'"),
    (lambda f: cw.sun(np.datetime64(2**62, "s"), 0, 0), ValueError, "time: .* expected one of the years 0 to 9999"),
    (lambda f: cw.open(b"z\0.npy"), ValueError, r"path: 'z\\x00.npy' has a null"),
    (lambda f: cw.open(3), TypeError, "path: 3, expected a path"),
])
def test_wrong_questions(call, kind, words):
    with pytest.raises(kind, match=words):
        call(cw.Field(rough(holes=False)))


def test_a_coordinate_system_has_its_whole_name():
    pytest.importorskip("pyproj")  # rasterio looks up no names
    with pytest.raises(ValueError, match="^crs: 'foo' is the name of no coordinate system; 'Amersfoort' is the nearest"):
        cw.Field(rough(), crs="foo")


PLACE, DAY, LINE, RAY = {"x": 5, "y": 5}, {"date": "2024-06-21", "step": "6h", "lon_lat": (9, 47)}, {"a": (1, 2), "b": (7, 2)}, {"origins": (1, 1, 9), "directions": (0, 0, -1)}
CALLS = {"closest": RAY, "occluded": RAY, "at": PLACE, "coarser": {"factor": 2}, "update": {"row": 1, "column": 1, "block": [[1]]}, "shadow": {}, "insolation": DAY,
         "sun_days": {**PLACE, **DAY}, "horizon": {}, "sky_view": {}, "openness": {}, "horizon_at": PLACE, "visibility": {}, "viewshed": PLACE, "sites": PLACE,
         "line_of_sight": LINE, "profile": LINE}
SWITCHES = {"hillshade", "irradiance", "distance", "tilted", "negative", "angle", "bands", "skip_outside"}


@pytest.mark.parametrize("name", CALLS)
def test_each_argument_is_checked(name):
    """A word, NaN and infinity are refused, and the error begins with the argument's name. Rays and places may have NaN."""
    field = cw.Field(rough(holes=False))
    for parameter in list(inspect.signature(getattr(cw.Field, name)).parameters.keys() - SWITCHES - {"self"}):
        for wrong in ["wrong", np.nan, np.inf][:1 if parameter in ("tmin", "tmax", "nodata") or name == "at" else 3]:
            with pytest.raises((TypeError, ValueError), match=rf"^([xy], )*{parameter}\b.*: "):
                getattr(field, name)(**{**CALLS[name], parameter: wrong})


def test_open(tmp_path):
    z = rough()
    np.save(tmp_path / "z.npy", z)
    field = cw.open(str(tmp_path / "z.npy").encode(), window=(5, 7, 40, 30))
    same(field.z, z[7:37, 5:45])
    assert field.map[:2, 3].tolist() == [5, 7]
    same_hits(ask(pickle.loads(pickle.dumps(field))), ask(field))
    field.update(0, 0, np.zeros((2, 2)))  # a mapped file stays as it is
    same(np.load(tmp_path / "z.npy"), z)
    np.save(tmp_path / "low.npy", np.where(z > 0, z, -9999))
    with pytest.warns(UserWarning, match="which often stands for no data; nodata=-9999 makes them holes"):
        cw.open(tmp_path / "low.npy")
    with pytest.raises(OSError, match="no part of 83 x 61"):
        cw.open(tmp_path / "z.npy", window=(80, 0, 9, 9))
    with pytest.raises(ValueError, match=r"window: 3, expected"):
        cw.open(tmp_path / "z.npy", window=3)
    with pytest.raises(OSError, match="missing.npy"):
        cw.open(tmp_path / "missing.npy")


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda f: pickle.loads(pickle.dumps(f))])
def test_copies(again):
    """Of a field made of an array: the same answers, and neither changes with the other."""
    field = cw.Field(rough(), transform=(10, 0, 500, 0, -10, 800), threads=2)
    field.update(3, 3, np.full((2, 2), 4.0))
    other = again(field)
    same_hits(ask(other), ask(field))
    before = ask(field)
    other.update(0, 0, np.full((20, 20), 30.0))
    same_hits(ask(field), before)
    assert other.transform == field.transform and other.at(510, 790) == 30
    coarse = again(field.coarser(2))
    assert coarse.difference == field.coarser(2).difference


@pytest.mark.parametrize("name", ["mean", "highest", "lowest"])
def test_coarser(name):
    full = cw.Field(rough(holes=False), transform=(10, 0, 500, 0, -10, 800))
    before, coarse = full.z.copy(), full.coarser(3, name)
    assert coarse.shape == (21, 29) and full.difference is None and coarse.difference.rms > 0
    assert (coarse.difference.below == 0) == (name == "highest") and (coarse.difference.above == 0) == (name == "lowest")
    assert coarse.at(505 + 30 * 12, 795 - 30 * 9) == coarse.z[9, 12]
    same(full.z, before)


def test_repr():
    z = np.arange(6.0).reshape(2, 3)
    assert repr(cw.Field(z)) == "<cellwalk.Field: 2 rows of 3 samples, heights 0 to 5, 0 holes, cells 1 x 1, no crs>"
    assert "no heights, 6 holes" in repr(cw.Field(z * np.nan))
    assert repr(cw.Field(z, (30, 0, 6e5, 0, -20, 5e6), 'PROJCS["Zone",GEOGCS["g",DATUM["d",SPHEROID["s",6378137,298.25]]],UNIT["metre",1]]')
                ).endswith("cells 30 x 20 m, Zone>")
    assert repr(cw.Field(z, (0.5, 0, 7, 0, -0.5, 47), 4326)).endswith("cells 0.5 x 0.5 degrees, WGS 84>")


def test_open_geotiff_window(tmp_path):
    """Or a dataset of rasterio's."""
    rasterio = pytest.importorskip("rasterio")
    z = rough()
    path = geotiff(tmp_path / "z.tif", np.where(np.isnan(z), -9999, np.round(z * 10)).astype(np.int16), nodata=-9999, tiled=True, blockxsize=16, blockysize=16)
    whole, part = cw.open(path), cw.open(path, window=rasterio.windows.Window(9, 5, 33, 44))
    same(part.z, whole.z[5:49, 9:42])
    same(part.map[:, :3], whole.map[:, :3])
    assert part.bounds[0] == whole.bounds[0] + 9 * 30
    with rasterio.open(path) as f:
        dataset, highest = cw.Field(f), float(np.nanmax(whole.z))
        same(cw.Field(f, nodata=highest).z, np.where(whole.z == highest, np.nan, whole.z))
    same(dataset.z, whole.z)
    same(dataset.map, whole.map)
    same(dataset.viewshed(600900.0, 5199000.0), whole.viewshed(600900.0, 5199000.0))


def test_numbers_have_a_point():
    """In files, also in a process with a decimal comma, as Qt and GTK set it."""
    pytest.importorskip("rasterio")  # with GDAL
    wkt = ('PROJCS["metres and a half",GEOGCS["sphere",DATUM["sphere",SPHEROID["sphere",6371000.5,298.25]],PRIMEM["Greenwich",0],'
           'UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["half",0.5]]')
    write("z.asc", "ncols 3\nnrows 2\nxllcorner 10.25\nyllcorner -3.5\ncellsize 0.5\nnodata_value -9999.5\n1.5 2.25 -9999.5\n-0.125 1e-1 7\n")
    write("z.prj", wkt)
    field = cw.open("z.asc")
    assert np.array_equal(field.z, np.float32([[1.5, 2.25, np.nan], [-0.125, 0.1, 7]]), equal_nan=True)
    assert field.bounds == (10.5, -3.25, 11.5, -2.75) and repr(cw.Field(field.z, (1, 0, 0, 0, -1, 0), wkt)).endswith("cells 1 x 1 x 0.5 m, metres and a half>")
    sun = cw.Field(np.zeros((9, 9)), (30.5, 0, 600000.25, 0, -30.5, 5200000.75), UTM).sun("2024-06-21T08:30:00.5Z")
    assert sun.azimuth == pytest.approx(107.5, abs=3) and sun.altitude == pytest.approx(45, abs=5)
    with pytest.warns(UserWarning, match=r"16\.7 % of the samples are exactly 0, and the next ones are 10\.5 from it"):
        cw.Field(np.float32([[0, 10.5, 20], [30, 40, 50]]))
