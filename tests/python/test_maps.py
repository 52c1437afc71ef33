# SPDX-License-Identifier: Apache-2.0
"""One terrain on maps of several kinds: products are those of the ground, not of the map's metre. Heights are a function
of the place, so nothing is resampled: grids differ in where their triangles stand."""
import csv
import io
import json
import re
import warnings

import numpy as np
import pytest

import cellwalk as cw

rasterio = pytest.importorskip("rasterio")
from rasterio.transform import Affine  # noqa: E402
from rasterio.warp import calculate_default_transform, transform  # noqa: E402

MIDDLE, HALF = (600000.0, 5206000.0), 5000.0  # UTM zone 32, latitude 47
MAPS = {
    "utm": "EPSG:32632",
    "mercator": "EPSG:3857",
    "degrees": "EPSG:4326",
    "plate": "EPSG:4087",  # a unit is another length along x than along y
    "feet": "+proj=lcc +lat_1=46.5 +lat_2=47.5 +lat_0=46 +lon_0=10 +x_0=500000 +datum=NAD83 +units=us-ft +no_defs",
}


def height(east, north):
    """Wavelengths of 1.9 km and more: a grid of 30 m has it to 30² / 8 · 250 · (2 π / 1900)² = 0.3 m."""
    return (900 + 250 * np.sin(2 * np.pi * east / 1900) * np.cos(2 * np.pi * north / 2300)
            + 120 * np.cos(2 * np.pi * (east + north) / 3100))


def to_space(longitude, latitude):
    """Metres from the middle of WGS 84."""
    a, e2 = 6378137.0, 0.0066943799901413165
    lam, phi = np.radians(longitude), np.radians(latitude)
    across = a / np.sqrt(1 - e2 * np.sin(phi) ** 2)
    return np.stack([across * np.cos(phi) * np.cos(lam), across * np.cos(phi) * np.sin(lam), across * (1 - e2) * np.sin(phi)])


def degrees_of(crs, x, y):
    return transform(crs, "EPSG:4326", list(np.ravel(x)), list(np.ravel(y)))


def write(path, z, crs, affine):
    with rasterio.open(path, "w", driver="GTiff", width=z.shape[1], height=z.shape[0], count=1, dtype="float32", crs=crs,
                       transform=affine) as file:
        file.write(z, 1)
        file.units = ("metre",)
    return path


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    (x, y), n = MIDDLE, int(2 * HALF / 30)
    made = {}
    for name, crs in MAPS.items():
        affine, columns, rows = calculate_default_transform("EPSG:32632", crs, n, n, x - HALF, y - HALF, x + HALF, y + HALF)
        j, i = np.mgrid[0:rows, 0:columns] + 0.5
        east, north = transform(crs, "EPSG:32632", *(list(v.ravel()) for v in affine * (i, j)))
        z = height(np.array(east), np.array(north)).reshape(rows, columns).astype("float32")
        made[name] = write(folder / f"{name}.tif", z, crs, affine)
    return made


def inside(n=4000, margin=3000, seed=4):
    """Places whose surroundings all maps have."""
    random = np.random.default_rng(seed)
    return [m + random.uniform(margin - HALF, HALF - margin, n) for m in MIDDLE]


def at_places(path, places, crs):
    """A product's first band at the nearest samples."""
    with rasterio.open(path) as file:
        x, y = transform("EPSG:32632", crs, *map(list, places))
        i, j = ~file.transform * (np.array(x), np.array(y))
        return file.read(1)[j.astype(int), i.astype(int)].astype(float)


# With the metre of the map, Mercator had 0.18 less in the shadow, 0.05 more sky, 1 h more sun, a third more ground in sight. Eyes see
# more or less as they stand a cell beside their place, so that only the mean can be compared.
PRODUCTS = {
    "shadow": (["shadow", "--time", "2024-12-21T09:30:00Z"], 0.02, 0.005),
    "sky": (["horizon", "--svf", "--directions", "16", "--max-distance", "2500"], 0.003, 0.001),
    "openness": (["horizon", "--openness", "--directions", "16", "--max-distance", "1500"], 0.4, 0.1),
    "sun": (["sun", "--date", "2024-12-21", "--step", "1h"], 0.15, 0.04),
    "area": (["visibility", "--max-distance", "1500", "--directions", "32"], 0.3, 0.03),
    "share": (["visibility", "--max-distance", "1500", "--directions", "16", "--share"], 0.05, 0.005),
    "longest": (["visibility", "--max-distance", "1500", "--directions", "16", "--longest"], 60, 10),
}


@pytest.mark.parametrize("product", PRODUCTS)
def test_products_are_those_of_the_ground(tool, maps, tmp_path, product):
    """Shadows' edges move by a cell at most, and a sample is up to half a cell beside its place."""
    words, limit, limit_of_mean = PRODUCTS[product]
    places, found = inside(), {}
    for name, path in maps.items():
        out = tmp_path / f"{name}.tif"
        tool(words[0], path, *words[1:], "-o", out)
        found[name] = at_places(out, places, MAPS[name])
    for name, values in found.items():
        off = values - found["utm"]
        assert abs(off.mean()) < limit_of_mean and np.abs(off).mean() < limit, (name, off.mean(), np.abs(off).mean())
        assert np.std(values) > 0.02


def test_places(maps):
    """What places see, their sun and radio links between them, by Python, whose bits are the program's."""
    east, north = inside(12)
    found = {}
    for name, path in maps.items():
        places, field = np.array(transform("EPSG:32632", MAPS[name], list(east), list(north))), cw.open(path)
        sites = field.sites(*places, 30, max_distance=2500)
        days = [field.sun_days(*place, "2024-03-20", step="5min", tilt=30) for place in places.T[:4]]
        ends = np.column_stack([places.T, np.full(12, 150)])
        links = field.line_of_sight(ends[1:], ends[:-1], frequency=900)
        found[name] = {"km2": (sites.km2, 0.09), "farthest": (sites.farthest, 60), "hours": ([day.hours[0] for day in days], 0.3),
                       "direct": ([day.direct[0] for day in days], 200), "clearance": (links.clearance, 0.15), "radius": (links.fresnel_radius, 0.3)}
    for name, values in found.items():
        for what, (value, limit) in values.items():
            off = np.abs(np.array(value) - found["utm"][what][0])
            assert off.max() < limit < np.ptp(value), (name, what, off, value)


@pytest.mark.parametrize("crs, affine", [("EPSG:4326", Affine(0.1, 0, 0, 0, -0.1, 70)), ("EPSG:3857", Affine(2e4, 0, 0, 0, -2e4, 9.6e6))])
def test_areas_far_from_the_observer(tool, tmp_path, crs, affine):
    """Cells in the north are smaller than those in the south: all ground in sight is the ellipsoid's zone."""
    z = np.zeros((200, 50), "float32")
    path = write(tmp_path / "tall.tif", z, crs, affine)
    x, y = affine * (25.5, 190.5)
    tool("viewshed", path, "--from", f"{x},{y},=1e9", "--curvature", 0, "--table", tmp_path / "t.csv", "-o", tmp_path / "o.tif")
    longitude, edges = degrees_of(crs, [affine.c, affine.c + 50 * affine.a], [affine.f, affine.f + 200 * affine.e])
    a, e = 6378137.0, 0.0818191908426215
    s = e * np.sin(np.radians(edges))
    q = a * a * (1 - e * e) / (2 * e) * (s / (1 - s * s) + np.arctanh(s))  # of the zone from the equator on, for a radian
    table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    assert table["samples"] == z.size and abs(table["km2"] / ((q[0] - q[1]) * np.radians(np.ptp(longitude)) * 1e-6) - 1) < 2e-4


def test_lines_of_sight(tool, maps, tmp_path):
    """Lengths against chords of the ellipsoid; the line's scale is that of its beginning, so that it is off by up to
    half of the distance over the earth's radius times the tangent of the latitude."""
    east, north = inside(40, margin=500)
    ends = np.array([east, north]).T.reshape(20, 2, 2)
    seen = {}
    for name, path in maps.items():
        crs, table = MAPS[name], tmp_path / "pairs.csv"
        x, y = (np.array(v).reshape(20, 2) for v in transform("EPSG:32632", crs, *(list(v) for v in ends.reshape(40, 2).T)))
        table.write_text("x1,y1,height1,x2,y2,height2\n" + "".join(
            f"{a!r},{b!r},150,{c!r},{d!r},150\n" for a, b, c, d in np.stack([x[:, 0], y[:, 0], x[:, 1], y[:, 1]], 1).tolist()))
        rows = list(csv.DictReader(io.StringIO(tool("los", path, "--pairs", table))))
        assert len(rows) == 20
        for k, said in enumerate(rows):
            lon, lat = degrees_of(crs, x[k], y[k])
            chord, distance = np.linalg.norm(np.diff(to_space(np.array(lon), np.array(lat)), axis=1)), float(said["distance"])
            share = 1.1 * chord / (2 * 6.37e6) + 1e-6
            assert abs(distance / chord - 1) < share, (name, distance, chord)
            if name == "utm":  # where the scale grows by its distance from the zone's middle over R²
                assert abs(distance / chord - 1) < 2e-5
            seen.setdefault(k, []).append(said["visible"] == "1")
    agree = [len(set(answers)) == 1 for answers in seen.values()]
    assert np.mean(agree) >= 0.9 and 3 < sum(answers[0] for answers in seen.values()) < 17


def test_max_distance(tool, maps, tmp_path):
    distance, eye = 3000.0, (MIDDLE[0] + 200, MIDDLE[1] - 300)
    for name, path in maps.items():
        crs, out = MAPS[name], tmp_path / f"{name}.tif"
        (x,), (y,) = transform("EPSG:32632", crs, [eye[0]], [eye[1]])
        tool("viewshed", path, "--from", f"{x!r},{y!r}", "--max-distance", distance, "--needed", "--window=-1e9,-1e9,1e9,1e9", "-o", out)
        with rasterio.open(out) as file:
            near = np.isfinite(file.read(1))
            j, i = np.mgrid[0:file.height, 0:file.width] + 0.5
            xs, ys = file.transform * (i, j)
        here = to_space(*map(np.array, degrees_of(crs, [x], [y])))
        away = np.linalg.norm(to_space(*map(np.array, degrees_of(crs, xs, ys))) - here, axis=0).reshape(near.shape)
        doubt = 1.1 * distance ** 2 / (2 * 6.37e6) + 1e-6 * distance
        assert near[away < distance - doubt].all() and not near[away > distance + doubt].any(), name
        assert near.sum() > 20000


def test_a_scale_that_changes_fast(tool, maps, tmp_path):
    z = np.zeros((40, 40), "float32")
    path = write(tmp_path / "tall.tif", z, "EPSG:3857", Affine(5000, 0, 1e6, 0, -5000, 6e6))
    ends = [(1.1e6, 5.9e6), (1.1e6, 5.901e6)]
    chord = np.linalg.norm(np.diff(to_space(*map(np.array, degrees_of("EPSG:3857", *zip(*ends)))), axis=1))
    assert abs(cw.open(path).line_of_sight(*ends, curvature=0).distance / chord - 1) < 1e-4


@pytest.mark.parametrize("crs, affine, words", [
    ("+proj=sinu +lon_0=0 +datum=WGS84", Affine(100, 0, 8e5, 0, -100, 5.2e6), "distances differ by direction by up to"),
    ("+proj=tmerc +lon_0=10 +datum=WGS84", Affine(30000, 0, -1.2e6, 0, -30000, 6.2e6), "from that of the row's middle"),
    ("+proj=ortho +lon_0=0 +datum=WGS84", Affine(100, 0, 3e7, 0, -100, 5.2e6), "is on the ground is not known"),
])
def test_what_a_scale_leaves_out_is_said(program, tmp_path, crs, affine, words):
    path = write(tmp_path / "dem.tif", np.zeros((80, 80), "float32"), crs, affine)
    said = program("shadow", path, "--sun", "200,30", "-o", tmp_path / "o.tif").stderr
    assert words in said and "gdalwarp -t_srs" in said, said
    with pytest.warns(UserWarning, match=words):
        cw.open(path).shadow(200, 30)
    with warnings.catch_warnings():  # once a field, and not for rays
        warnings.simplefilter("error")
        cw.open(path).closest([0, 0, 1], [0, 0, -1])


# ---- guesses, and what looks wrong -------------------------------------------------------------------------------------------

FEET = MAPS["feet"]


@pytest.fixture
def commands(program, tmp_path):
    """Each subcommand, with each kind of place, on a raster of cells of 100 units with its north-west corner there."""
    (tmp_path / "places.csv").write_text("x,y\n1600500,399500\n")
    (tmp_path / "pairs.csv").write_text("x1,y1,x2,y2\n1600100,399900,1600800,399200\n")
    np.save(tmp_path / "rays.npy", np.array([[1600500, 399500, 2e9, 0, 0, 0, -1, 3e9]]))
    out, here = ("-o", tmp_path / "o.tif"), "1600500,399500"
    lines = [("info",), ("info", "--json"), ("trace", tmp_path / "rays.npy", "--user", "-o", tmp_path / "o.npy"), ("shadow", "--sun", "200,30", *out),
             ("sun", "--date", "2024-06-21", "--step", "6h", *out), ("sun", "--date", "2024-06-21", "--step", "6h", "--at", here),
             ("horizon", "--directions", 2, *out), ("horizon", "--openness", "--directions", 2, *out), ("horizon", "--at", here),
             ("horizon", "--places", tmp_path / "places.csv"), ("viewshed", "--from", here, *out),
             ("viewshed", "--observers", tmp_path / "places.csv", "--table", tmp_path / "t.csv", *out), ("visibility", "--directions", 2, *out),
             ("los", "1600420,399580", "1600800,399200"), ("los", "--pairs", tmp_path / "pairs.csv"), ("render", "--size", "8x8", "-o", tmp_path / "o.png")]
    listed = re.search(r"Commands:\n((?:  .*\n)+)", program("--help").stdout).group(1)
    assert {line.split()[0] for line in listed.splitlines()} == {words[0] for words in lines}
    return lines


def test_each_command_warns_once(program, commands, tmp_path):
    """Of each thing that looks wrong, whatever part of the raster it reads, and however often."""
    z = np.full((10, 10), 1e9, "float32")
    z[4, 4] = -9999
    path = write(tmp_path / "dem.tif", z, FEET, Affine(100, 0, 1.6e6, 0, -100, 4e5))
    with rasterio.open(path, "r+") as file:
        file.units = (None,)
    for command, *rest in commands:
        done = program(command, path, *rest)
        warned = [done.stderr.count(words) for words in ("heights taken as US survey ft", "1 samples are -9999", "rounded to multiples of 64")]
        assert done.returncode == 0 and warned == [1, 1, 1], (command, rest, done.stderr)
        assert done.stderr.count("warning:") == 3 + (command == "render"), done.stderr  # nothing of land as high as that is in the picture


def test_guessed_heights(program, tmp_path):
    """Feet for x and y say nothing of heights."""
    place = Affine(100, 0, 1.6e6, 0, -100, 4e5)
    for units, words, warned in ((None, [], True), (None, ["--zscale", "3.2808"], False), ("metre", [], False), ("ft", [], False)):
        path = write(tmp_path / "feet.tif", np.zeros((9, 9), "float32"), FEET, place)
        with rasterio.open(path, "r+") as file:
            file.units = (units,)
        said = program("shadow", path, "--sun", "200,30", "-o", tmp_path / "o.tif", *words).stderr
        assert ("heights taken as US survey ft, as x and y; --zscale 3.2808 if they are metres" in said) == warned, said
        assert said.count("warning:") == warned
    with pytest.warns(UserWarning, match="^crs: heights taken as US survey ft"):
        cw.Field(np.zeros((9, 9)), place, rasterio.crs.CRS.from_string(FEET))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cw.Field(np.zeros((9, 9)), place, rasterio.crs.CRS.from_string(FEET), zscale=3.2808)
        cw.Field(np.zeros((9, 9)), Affine(100, 0, 6e5, 0, -100, 5e6), "EPSG:32632")


DEGREES, METRES = (1 / 1200, 0, 10.5, 0, -1 / 1200, 47.25), (30, 0, 6e5, 0, -30, 5.2e6)
WARNED = {
    "degrees": (lambda z: cw.Field(z, DEGREES), "looks like degrees"),
    "no data": (lambda z: cw.Field(np.where(z > 2, z, -9999), METRES), "3 samples are -9999.*nodata=-9999"),
    "rounded": (lambda z: cw.Field(z + 1e9, METRES), "up to 1e.09 are rounded to multiples of 64"),
    "night": (lambda z: cw.Field(z, METRES).shadow(200, -3), "sun is at -3.000 degrees, below the horizon"),
}


@pytest.mark.parametrize("name", WARNED)
def test_what_looks_wrong(name):
    """Said at the caller's line."""
    make, words = WARNED[name]
    z = np.arange(25.0).reshape(5, 5)
    with pytest.warns(UserWarning, match=words) as said:
        make(z)
    assert len(said) == 1 and said[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cw.Field(z, METRES).shadow(200, 3)
        cw.Field(z, DEGREES, "EPSG:4326")
        cw.Field(np.where(z > 2, z, -9999), METRES, nodata=-9999)


def test_rounded_heights_in_the_program(program, tmp_path):
    path = write(tmp_path / "high.tif", np.full((5, 5), 1e9, "float32"), MAPS["utm"], Affine(*METRES))
    said = program("shadow", path, "--sun", "200,30", "-o", tmp_path / "o.tif").stderr
    assert "heights are floats, and those up to 1e+09 are rounded to multiples of 64" in said


def test_a_missing_tile(program, tmp_path):
    """A part that no file covers reads as 0."""
    random = np.random.default_rng(3)
    z = random.uniform(104, 400, (20, 50)).astype("float32")
    z[:, :14] = 0
    path = write(tmp_path / "tile.tif", z, MAPS["utm"], Affine(*METRES))
    words = "28 % of the samples are exactly 0, and the next ones are 104"
    for name, arguments, warned in (("shadow", ["--sun", "200,30", "-o", tmp_path / "o.tif"], True), ("info", [], True),
                                    ("info", ["--nodata", "0"], False)):
        said = program(name, path, *arguments).stderr
        assert (words in said) == warned and said.count("warning:") == warned, said
    with pytest.warns(UserWarning, match=f"^z: {words}.*nodata=0"):
        cw.Field(z, METRES)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for usual in (z - 104, np.where(z > 110, 0, z), np.where(z > 399.9, z, 0)):  # a coast, a plain with towers
            cw.Field(usual + (usual == 0) * (np.arange(50) % 2) * 0.5, METRES)
        cw.Field(z, METRES, nodata=0)


@pytest.mark.parametrize("arguments", [{}, {"hillshade": True}, {"disc": True}, {"curvature": 1.0}])
def test_night_at_the_rim(tool, tmp_path, arguments):
    """Nothing is lit below what the dip of the horizon explains."""
    y, x = np.mgrid[0:60, 0:60]
    z = (600 + 300 * np.sin(x / 7) * np.cos(y / 5)).astype("float32")
    z[4, 5] = np.nan
    field = cw.Field(z, METRES, MAPS["utm"])
    dip = np.degrees(np.arccos(6378137 / (6378137 + z)))
    for azimuth in range(0, 360, 40):
        for altitude in (-89.9, -30.0, -3.0, -1.5, -0.6, -0.3):
            with pytest.warns(UserWarning, match="below the horizon"):
                lit = field.shadow(azimuth, altitude, **arguments)
            top = altitude + (0.2666 if "disc" in arguments else 0)
            dark = np.isfinite(z) & (dip < -top - 1e-6)
            assert (lit[dark] == 0).all() and dark.sum() in ((3599,) if top < -1 else range(3600))
            assert lit[4, 5] == 255 if lit.dtype == np.uint8 else np.isnan(lit[4, 5])
    with pytest.warns(UserWarning):
        assert any((field.shadow(azimuth, -0.3, **arguments) > 0)[:, [0, -1]].any() for azimuth in range(0, 360, 90))


# ---- places ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["utm", "degrees"])
def test_places_written_to_the_millimetre(name, tool, tmp_path):
    """A sample between holes has no triangle, and its place stays its own."""
    affine = Affine(7.001, 0, 600000.1234, 0, -7.001, 5200000.4321) if name == "utm" else Affine(1e-4 / 3, 0, 10.5, 0, -1e-4 / 3, 47.25)
    digits = 3 if name == "utm" else 8
    z = np.arange(99, dtype="float32").reshape(9, 11)
    z[3:6, 3:6] = np.nan
    z[4, 4] = 50
    path = write(tmp_path / "dem.tif", z, MAPS[name], affine)
    field = cw.open(path)
    for row, column in ((4, 4), (1, 1), (8, 10), (2, 4)):
        x, y = (round(v, digits) for v in affine * (column + 0.5, row + 0.5))
        seen = field.viewshed(x, y, 300)
        assert seen[row, column] == 1
        tool("viewshed", path, "--from", f"{x},{y},300", "-o", tmp_path / "seen.tif")
        with rasterio.open(tmp_path / "seen.tif") as file:
            assert file.read(1).tobytes() == seen.tobytes()
    with pytest.raises(ValueError, match="no ground"):
        field.viewshed(*(affine * (4.5 + 0.02, 4.5 - 0.02)), 2)  # 0.2 m or 0.07 m off: in a hole


@pytest.mark.parametrize("cell", [0.1, 0.03, 0.01])
@pytest.mark.parametrize("turned", [False, True])
def test_small_cells_far_from_the_origin(cell, turned):
    """Coordinates of 5.2e6 m have no digits for 2^-28 of a cell: answers are those with the origin at 0, 0."""
    random = np.random.default_rng(8)
    z = (300 * random.random((12, 12))).astype("float32") * cell
    z[3, 3] = np.nan
    here, far = (cw.Field(z, Affine.translation(x, y) * Affine.rotation(20 if turned else 0) * Affine.scale(cell, -cell), MAPS["utm"])
                 for x, y in ((0, 0), (633333.3, 5.2e6 + 1 / 3)))
    for row in range(12):
        for column in range(12):
            answers = []
            for field in (here, far):
                x, y = Affine(*field.transform) * (column + 0.5, row + 0.5)
                if np.isfinite(z[row, column]):  # a corner of the raster, or a sample beside the hole
                    field.viewshed(x, y, 1)
                answers.append(field.viewshed(x, y, observer_elevation=400 * cell, needed=True, curvature=0))
            assert np.allclose(*answers, rtol=1e-6, atol=1e-6 * cell, equal_nan=True), (row, column)


# ---- sums -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("directions", [1, 3, 7, 32, 360, 720, 3599])
def test_the_sky_of_a_plain_is_whole(directions):
    plain = cw.Field(np.full((7, 9), 300.0))
    assert (plain.sky_view(directions) == 1).all() and (plain.sky_view(directions, tilted=True) == 1).all()
    rough = cw.Field(np.random.default_rng(1).normal(0, 1e-4, (7, 9)))
    assert (rough.sky_view(directions) <= 1).all()


@pytest.mark.parametrize("tilt", [0, 37, 89.9, 90, 90.1, 135, 180])
def test_the_sky_of_a_leaning_surface(tilt):
    """A surface on a plain sees (1 + cos tilt) / 2 of it; one that overhangs sees less and less, and never less than nothing."""
    day = cw.Field(np.full((7, 9), 300.0)).sun_days(4, 3, "2024-06-21", tilt=tilt, facing=120, step="1h", sky=720, lon_lat=(9, 47))
    assert abs(day.diffuse[0] - day.free_diffuse[0]) < 0.05 and day.free_direct[0] == day.direct[0] >= 0
    hills = cw.Field(np.random.default_rng(1).normal(0, 3, (7, 9))).sun_days(4, 3, "2024-06-21", tilt=tilt, sky=32, step="1h", lon_lat=(9, 47))
    assert 0 <= hills.diffuse[0] <= hills.free_diffuse[0] + 1


# ---- horizons of places ------------------------------------------------------------------------------------------------------


def test_horizons_of_places(program, tool, maps, tmp_path):
    """All that are given, in order; azimuths of the map and from true north; a table of places, and JSON, say the same."""
    east, north = inside(3)
    for name in ("utm", "degrees"):
        crs, path = MAPS[name], maps[name]
        x, y = transform("EPSG:32632", crs, list(east), list(north))
        given = [f"{a!r},{b!r},{k}" for k, (a, b) in enumerate(zip(x, y))]
        single = [tool("horizon", path, "--at", place, "--directions", "5", "--start", "7").splitlines() for place in given]
        words = "horizon", path, *(w for place in given for w in ("--at", place)), "--directions", "5", "--start", "7"
        lines = tool(*words).splitlines()
        assert lines[0] == "place,azimuth,true_azimuth,angle,distance,x,y" and len(lines) == 16
        assert [line.split(",", 1) for line in lines[1:]] == [[str(k + 1), line.split(",", 1)[1]] for k in range(3) for line in single[k][1:]]
        table = tmp_path / "places.csv"
        table.write_text("x,y,height\n" + "".join(f"{place}\n" for place in given))
        rest = "--directions", "5", "--start", "7"
        assert program("horizon", path, "--places", table, *rest, "-o", tmp_path / "out.csv").stdout == ""
        assert (tmp_path / "out.csv").read_text().splitlines() == lines
        # The way to a place 1 km north, and east, on the ground.
        lon, lat = (np.array(v) for v in degrees_of(crs, x, y))
        true, of_map = (np.array([[float(line.split(",")[c]) for line in lines[1:]]]).reshape(3, 5)[:, 0] for c in (2, 1))
        if name == "degrees":
            assert (true == of_map).all()
        else:
            assert np.allclose(of_map - true, -np.degrees(np.arctan(np.tan(np.radians(lon - 9)) * np.sin(np.radians(lat)))), atol=2e-3)
    for wrong, words in ((["--at", "1,2", "--places", "p.csv"], "do not go together"), (["--at", "1,2", "--svf"], "go with none of --svf")):
        assert words in tool("horizon", maps["utm"], *wrong, fails=True)


# ---- distances ---------------------------------------------------------------------------------------------------------------


def test_the_nearest_of_equal_rises(tool, tmp_path):
    """On a plane every crossing is as steep as the next one: the first one is the horizon."""
    j, i = np.mgrid[0:60, 0:60]
    for slopes, azimuth in (((3, 2), 200), ((3, 2), 17), ((1, -4), 100.5), ((0, 0), 310)):
        path = write(tmp_path / "ramp.tif", (1000 + slopes[0] * i + slopes[1] * j).astype("float32"), MAPS["utm"], Affine(*METRES))
        tool("horizon", path, "--directions", "1", "--start", azimuth, "--distance", "-o", tmp_path / "d.tif")
        with rasterio.open(tmp_path / "d.tif") as file:
            metres = file.read(1)
        inner = metres[2:-2, 2:-2]
        assert np.isfinite(inner).all() and np.ptp(inner) < 1e-3 and inner.max() < 42.5


def test_angle_and_distance_are_of_one_ground(tool, tmp_path):
    """On a curved earth, the place that the distance tells is as high as the angle says."""
    z = np.random.default_rng(6).normal(500, 0.02, (80, 80)).astype("float32")
    path = write(tmp_path / "level.tif", z, MAPS["utm"], Affine(*METRES))
    words = "horizon", path, "--directions", "1", "--start", "73", "--curvature", "1"
    found = []
    for more in ([], ["--distance"]):
        tool(*words, *more, "-o", tmp_path / "o.tif")
        with rasterio.open(tmp_path / "o.tif") as file:
            found.append(file.read(1))
    field, (angle, metres) = cw.open(path), found
    scale = np.linalg.norm(np.diff(to_space(*(np.array(v) for v in degrees_of(MAPS["utm"], [6e5 + 1200, 6e5 + 1230], [5.2e6 - 1200] * 2))), axis=1)) / 30
    for row, column in np.random.default_rng(7).integers(5, 60, (200, 2)):
        x, y = Affine(*METRES) * (column + 0.5, row + 0.5)
        d = metres[row, column]
        ground = field.at(x + d / scale * np.sin(np.radians(73)), y + d / scale * np.cos(np.radians(73)))
        rise = (ground - d * d / (2 * 6378137) - z[row, column]) / d
        if np.isnan(ground):
            continue  # on the border but for rounding
        # Places are known to a part in 10⁷, floats of 500 m to 3e-5 m.
        assert abs(rise - np.tan(np.radians(angle[row, column]))) < 1e-4 / d + 2e-7, (row, column, d)


# ---- what is said --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("words, said", [
    (["shadow", "--sun", "30,225", "-o", "o.tif"], "--sun 30,225: the second number is the altitude, and 225 degrees is none; the azimuth is first"),
    (["render", "--sun", "30,225", "-o", "o.png"], "--sun 30,225: the second number is the altitude"),
    (["viewshed", "--from", "600500,5205000", "--max-distance", "0", "-o", "o.tif"], "--max-distance takes metres above 0, not 0"),
    (["horizon", "--max-distance", "0", "-o", "o.tif"], "--max-distance takes metres above 0, not 0"),
    (["visibility", "--max-distance", "0", "-o", "o.tif"], "--max-distance takes metres above 0, not 0"),
    (["viewshed", "--from", "600500,5205000", "--every", "0", "-o", "o.tif"], "--every takes metres above 0, not 0"),
    (["los", "600500,5205000", "600500,5205000", "--frequency", "0"], "--frequency takes megahertz from 0.1 to 1000000, not 0"),
    (["viewshed", "--from", "10.3,47", "-o", "o.tif"], "10.3,47: lies outside and looks like longitude and latitude"),
    (["los", "10.3,47", "10.4,47"], "looks like longitude and latitude"),
    (["viewshed", "--from", "600500,5205000", "--height", "3", "-o", "o.tif"],
     "unknown option --height; the height of a place is its third number: X,Y,H"),
    (["shadow", "--sun", "225,30", "--memory", "0.15M", "--window", "0,0,1e7,1e7", "-o", "o.tif"], "there is 0.15M"),
    (["trace", "rays.npy", "--any", "-o", "o.npy"], "unknown option --any"),
])
def test_messages(tool, maps, tmp_path, words, said):
    words = [tmp_path / word if word.startswith("o.") else word for word in words]
    assert said in tool(words[0], maps["utm"], *words[1:], fails=True)


@pytest.mark.parametrize("shape", [(1, 9), (9, 1)])
def test_one_row_is_no_terrain(tool, tmp_path, shape):
    path = write(tmp_path / "line.tif", np.zeros(shape, "float32"), MAPS["utm"], Affine(*METRES))
    for words in (["shadow", path, "--sun", "9,9", "-o", tmp_path / "o.tif"], ["los", path, "600015,5199985", "600015,5199985"]):
        assert f"{shape[1]} x {shape[0]} samples; a terrain has at least 2 x 2" in tool(*words, fails=True)


def test_profiles_have_no_minus_zero(tool, tmp_path):
    z = np.full((9, 9), -1e-4, "float32")
    path = write(tmp_path / "flat.tif", z, MAPS["utm"], Affine(*METRES))
    tool("los", path, "600030,5199970,1", "600200,5199830,1", "--curvature", "0", "--profile", tmp_path / "p.csv")
    assert "-0.000" not in (tmp_path / "p.csv").read_text() and ",0.000," in (tmp_path / "p.csv").read_text()
    (tmp_path / "pairs.csv").write_text("x1,y1,height1,x2,y2,height2\n600030,5199970,0,600200,5199830,0\n")
    for words in (["600030,5199970,0", "600200,5199830,0"], ["--pairs", tmp_path / "pairs.csv"]):
        out = tool("los", path, *words, "--curvature", "0")
        assert "-0.000" not in out and "0.000" in out


# ---- observers of files --------------------------------------------------------------------------------------------------------


def points(*rows):
    return json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}},
                       "features": [{"type": "Feature", "properties": properties, "geometry": {"type": "Point", "coordinates": place}}
                                    for place, properties in rows]})


KML = ('<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>Mast</name><ExtendedData><Data name="height"><value>30</value>'
       '</Data></ExtendedData><Point><coordinates>10.32,47.0</coordinates></Point></Placemark></Document></kml>')
HERE = [600000.1, 5206000.3]


@pytest.mark.parametrize("name, text, height, warned", [
    ("a.geojson", points((HERE, {"OFFSETA": 30.0, "name": "Mast"})), 30, None),
    ("a.geojson", points((HERE, {"height": 30.0, "OFFSETA": 1.0, "AZIMUTH1": 20, "RADIUS2": None})), 30, "'OFFSETA', 'AZIMUTH1'; attributes"),
    ("a.geojson", points((HERE + [1500.0], {"height": 30.0, "RADIUS2": 90})), 30, "'RADIUS2', z of places; attributes"),
    ("a.geojson", points((HERE + [0.0], {})), 2, None),
    ("a.kml", KML, 30, None),
])
def test_attributes_of_observers(program, maps, tmp_path, name, text, height, warned):
    """What is known counts; what is passed over is said."""
    (tmp_path / name).write_text(text)
    made = program("viewshed", maps["utm"], "--observers", tmp_path / name, "-o", tmp_path / "o.tif")
    assert made.returncode == 0 and ((warned or "passed over") in made.stderr) == (warned is not None), made.stderr
    with rasterio.open(tmp_path / "o.tif") as file:
        assert file.tags()["OBSERVER_1"].endswith(f",{height}")
        seen = file.read(1)
        x, y, _ = map(float, file.tags()["OBSERVER_1"].split(","))
    assert (seen == cw.open(maps["utm"]).viewshed(x, y, height)).all()


def test_names_of_observers(program, maps, tmp_path):
    table = tmp_path / "towers.csv"
    table.write_text("name,x,y\nHigh Mast,601000.639,5206000.639\n,600000,5205000\n\"a\nb\",600500,5204000\n" + "ä" * 40 + ",600500,5205500\n")
    assert "warning" not in program("viewshed", maps["utm"], "--observers", table, "--bands", "-o", tmp_path / "o.tif").stderr
    with rasterio.open(tmp_path / "o.tif") as file:
        assert file.descriptions[:3] == ("observer 1 (High Mast) at 601000.639,5206000.639", "observer 2 at 600000,5205000",
                                         "observer 3 (a b) at 600500,5204000")
        tags = file.tags()
        assert tags["OBSERVER_1"] == "601000.639,5206000.639,2" and tags["OBSERVER_1_NAME"] == "High Mast"
        assert "OBSERVER_2_NAME" not in tags and set(tags["OBSERVER_4_NAME"]) == {"ä"}
    table.write_text("name,x,y\nHigh Mast,601000.639,5206000.639\n,600000,5205000\n\"a, \"\"b\"\"\",600500,5204000\n")
    names = ["High Mast", "", 'a, "b"']
    program("viewshed", maps["utm"], "--observers", table, "--table", tmp_path / "t.csv", "-o", tmp_path / "o.tif")
    assert [row["name"] for row in csv.DictReader((tmp_path / "t.csv").read_text().splitlines())] == names
    said = program("horizon", maps["utm"], "--places", table, "--directions", 1).stdout
    assert [row["name"] for row in csv.DictReader(said.splitlines())] == names
    table.write_text("x1,y1,x2,y2,name\n600000,5205000,600100,5205000,\"a, \"\"b\"\"\"\n")
    done = program("los", maps["utm"], "--pairs", table, "--frequency", 900)
    assert [row["name"] for row in csv.DictReader(done.stdout.splitlines())] == ['a, "b"'] and "warning" not in done.stderr
    table.write_text("name,x,y\nFar Mast,1,1\n")
    assert "towers.csv:2 (Far Mast)" in program("viewshed", maps["utm"], "--observers", table, "-o", tmp_path / "p.tif").stderr
