# SPDX-License-Identifier: Apache-2.0
"""One terrain on maps of several kinds: products are those of the ground, not of the map's metre. Heights are a function
of the place, so nothing is resampled: grids differ in where their triangles stand."""
import warnings

import numpy as np
import pytest
from program import commands as every_command, run, write as write_text
from rasterio.transform import Affine
from rasterio.warp import calculate_default_transform, transform

import cellwalk as cw
from conftest import geotiff as write, tool

MIDDLE, HALF = (600000.0, 5206000.0), 5000.0  # UTM zone 32, latitude 47
MAPS = {"utm": "EPSG:32632", "mercator": "EPSG:3857", "degrees": "EPSG:4326",
        "plate": "EPSG:4087",  # a unit is another length along x than along y
        "feet": "+proj=lcc +lat_1=46.5 +lat_2=47.5 +lat_0=46 +lon_0=10 +x_0=500000 +datum=NAD83 +units=us-ft +no_defs"}


def height(east, north):
    """Wavelengths of 1.9 km and more: a grid of 30 m has it to 30² / 8 · 250 · (2 π / 1900)² = 0.3 m."""
    return (900 + 250 * np.sin(2 * np.pi * east / 1900) * np.cos(2 * np.pi * north / 2300) + 120 * np.cos(2 * np.pi * (east + north) / 3100))


def to_space(longitude, latitude):
    """Metres from the middle of WGS 84."""
    a, e2 = 6378137.0, 0.0066943799901413165
    lam, phi = np.radians(longitude), np.radians(latitude)
    across = a / np.sqrt(1 - e2 * np.sin(phi) ** 2)
    return np.stack([across * np.cos(phi) * np.cos(lam), across * np.cos(phi) * np.sin(lam), across * (1 - e2) * np.sin(phi)])


def degrees_of(crs, x, y):
    return transform(crs, "EPSG:4326", list(np.ravel(x)), list(np.ravel(y)))


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


def at_places(field, values, places, crs):
    """A product's first band at the nearest samples."""
    i, j = ~Affine(*field.transform) * tuple(map(np.array, transform("EPSG:32632", crs, *map(list, places))))
    return values.reshape(-1, *field.shape)[0, j.astype(int), i.astype(int)].astype(float)


# With the metre of the map, Mercator had 0.18 less in the shadow, 0.05 more sky, 1 h more sun, a third more ground in sight. Eyes see
# more or less as they stand a cell beside their place, so that only the mean can be compared.
PRODUCTS = {"shadow": (lambda f: f.shadow(time="2024-12-21T09:30:00Z"), 0.02, 0.005), "sky": (lambda f: f.sky_view(16, 2500), 0.003, 0.001),
            "openness": (lambda f: f.openness(16, 1500), 0.4, 0.1), "sun": (lambda f: f.insolation("2024-12-21", step="1h"), 0.15, 0.04),
            "area": (lambda f: f.visibility(32, 1500), 0.3, 0.03), "share": (lambda f: f.visibility(16, 1500, result="share"), 0.05, 0.005),
            "longest": (lambda f: f.visibility(16, 1500, result="longest"), 60, 10)}


@pytest.mark.parametrize("product", PRODUCTS)
def test_products_are_those_of_the_ground(maps, product):
    """Shadows' edges move by a cell at most, and a sample is up to half a cell beside its place. By Python, whose bits are the program's."""
    make, limit, limit_of_mean = PRODUCTS[product]
    places, fields = inside(), {name: cw.open(path) for name, path in maps.items()}
    found = {name: at_places(field, np.asarray(make(field)), places, MAPS[name]) for name, field in fields.items()}
    for name, values in found.items():
        off = values - found["utm"]
        assert abs(off.mean()) < limit_of_mean and np.abs(off).mean() < limit, (name, off.mean(), np.abs(off).mean())
        assert np.std(values) > 0.02


def test_places(maps):
    """What places see, their sun and radio links between them."""
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
def test_areas_far_from_the_observer(crs, affine):
    """Cells in the north are smaller than those in the south: all ground in sight is the ellipsoid's zone."""
    z = np.zeros((200, 50), "float32")
    path = write("tall.tif", z, crs, affine)
    x, y = affine * (25.5, 190.5)
    sites = cw.open(path).sites(x, y, observer_elevation=1e9, curvature=0)
    longitude, edges = degrees_of(crs, [affine.c, affine.c + 50 * affine.a], [affine.f, affine.f + 200 * affine.e])
    a, e = 6378137.0, 0.0818191908426215
    s = e * np.sin(np.radians(edges))
    q = a * a * (1 - e * e) / (2 * e) * (s / (1 - s * s) + np.arctanh(s))  # of the zone from the equator on, for a radian
    assert sites.samples[0] == z.size and abs(sites.km2[0] / ((q[0] - q[1]) * np.radians(np.ptp(longitude)) * 1e-6) - 1) < 2e-4


def test_lines_of_sight(maps):
    """Lengths against chords of the ellipsoid."""
    ends, seen = inside(40, margin=500), []
    for name, path in maps.items():
        x, y = (np.reshape(v, (20, 2)) for v in transform("EPSG:32632", MAPS[name], *map(list, ends)))
        one, other = np.moveaxis(np.stack([x, y, np.full((20, 2), 150)], -1), 1, 0)
        lines = cw.open(path).line_of_sight(one, other)
        spots = to_space(*(np.reshape(v, (20, 2)) for v in degrees_of(MAPS[name], x, y)))
        chords = np.linalg.norm(spots[..., 1] - spots[..., 0], axis=0)
        assert (np.abs(lines.distance / chords - 1) < 2e-5).all(), name
        seen.append(lines.visible)
    assert np.mean(np.all(np.array(seen) == seen[0], axis=0)) >= 0.9 and 3 < sum(seen[0]) < 17


def test_distances_end_after_metres(maps):
    """max_distance counts on the ground: a viewshed's against chords of the ellipsoid; and lines go so far and no farther."""
    most = 1234.0
    for name, path in maps.items():
        field, (x, y) = cw.open(path), np.ravel(transform("EPSG:32632", MAPS[name], *([v] for v in MIDDLE)))
        j, i = np.indices(field.shape) + 0.5
        spots = to_space(*map(np.array, degrees_of(MAPS[name], *(np.append(v, eye) for v, eye in zip(Affine(*field.transform) * (i, j), (x, y))))))
        away = np.linalg.norm(spots[:, :-1] - spots[:, -1:], axis=0).reshape(field.shape)
        inside = np.isfinite(field.viewshed(x, y, 30, max_distance=most, needed=True))
        assert (inside == (away < most))[np.abs(away - most) > 1].all(), name
        for lengths in field.horizon(1, most, distance=True), field.visibility(8, most, result="longest"):
            assert 0.98 * most < np.nanmax(lengths) < most + 1, name


def test_a_scale_that_changes_fast(maps):
    z = np.zeros((40, 40), "float32")
    path = write("tall.tif", z, "EPSG:3857", Affine(5000, 0, 1e6, 0, -5000, 6e6))
    ends = [(1.1e6, 5.9e6), (1.1e6, 5.901e6)]
    chord = np.linalg.norm(np.diff(to_space(*map(np.array, degrees_of("EPSG:3857", *zip(*ends)))), axis=1))
    field = cw.open(path)
    assert abs(field.line_of_sight(*ends, curvature=0).distance / chord - 1) < 1e-4
    # Who sees is seen.
    r = np.random.default_rng(3)
    a, b = np.dstack([r.uniform(1e6 + 2500, 1.2e6 - 2500, (2, 2000)), r.uniform(5.8e6 + 2500, 6e6 - 2500, (2, 2000)), r.uniform(1, 300, (2, 2000))])
    one, other = field.line_of_sight(a, b), field.line_of_sight(b, a)
    assert (one.visible == other.visible).all() and 200 < one.visible.sum() < 1800
    np.testing.assert_allclose(one.distance, other.distance, rtol=1e-12)


@pytest.mark.parametrize("crs, affine, words", [
    ("+proj=sinu +lon_0=0 +datum=WGS84", Affine(100, 0, 8e5, 0, -100, 5.2e6), "distances differ by direction by up to"),
    ("+proj=tmerc +lon_0=10 +datum=WGS84", Affine(30000, 0, -1.2e6, 0, -30000, 6.2e6), "from that of the row's middle"),
    ("+proj=ortho +lon_0=0 +datum=WGS84", Affine(100, 0, 3e7, 0, -100, 5.2e6), "is on the ground is not known")])
def test_what_a_scale_leaves_out_is_said(crs, affine, words):
    path = write("dem.tif", np.zeros((80, 80), "float32"), crs, affine)
    said = run("shadow", path, "--sun", "200,30", "-o", "o.tif").err
    assert words in said and "gdalwarp -t_srs" in said, said
    with pytest.warns(UserWarning, match=words):
        cw.open(path).shadow(200, 30)
    with warnings.catch_warnings():  # once a field, and not for rays
        warnings.simplefilter("error")
        cw.open(path).closest([0, 0, 1], [0, 0, -1])


# ---- guesses, and what looks wrong -------------------------------------------------------------------------------------------

COMMANDS = """info\ninfo --json\ntrace rays.npy --user -o o.npy\nshadow --sun 200,30 -o o.tif\nsun --date 2024-06-21 --step 6h -o o.tif
sun --date 2024-06-21 --step 6h --at 1600500,399500\nhorizon --directions 2 -o o.tif\nhorizon --openness --directions 2 -o o.tif
horizon --at 1600500,399500\nhorizon --places places.csv\nviewshed --from 1600500,399500 -o o.tif
viewshed --observers places.csv --table t.csv -o o.tif\nvisibility --directions 2 -o o.tif\nlos 1600420,399580 1600800,399200
los --pairs pairs.csv\nrender --size 8x8 -o o.png"""


def test_each_command_warns_once():
    """Of each thing that looks wrong, whatever part of the raster it reads, and however often."""
    write_text("places.csv", "x,y\n1600500,399500\n")
    write_text("pairs.csv", "x1,y1,x2,y2\n1600100,399900,1600800,399200\n")
    np.save("rays.npy", np.array([[1600500, 399500, 2e9, 0, 0, 0, -1, 3e9]]))
    z = np.full((10, 10), 1e9, "float32")
    z[4, 4] = -9999
    write("dem.tif", z, MAPS["feet"], Affine(100, 0, 1.6e6, 0, -100, 4e5), units=None)
    lines = list(map(str.split, COMMANDS.splitlines()))
    assert every_command() == {words[0] for words in lines}
    for command, *rest in lines:
        done = run(command, "dem.tif", *rest)
        warned = [done.err.count(words) for words in ("heights taken as US survey ft", "1 samples are -9999", "rounded to multiples of 64")]
        assert done.status == 0 and warned == [1, 1, 1], (command, rest, done.err)
        far = done.err.count("nothing of the terrain is in the picture")  # as high as that
        assert far == (command == "render") and done.err.count("warning:") == 3 + far, done.err


DEGREES, METRES, HILLS = (1 / 1200, 0, 10.5, 0, -1 / 1200, 47.25), (30, 0, 6e5, 0, -30, 5.2e6), np.arange(1, 26, dtype="float32").reshape(5, 5)
TILE = np.random.default_rng(3).uniform(104, 400, (20, 50)).astype("float32")
TILE[:, :14] = 0
STATE = (100, 0, 1.6e6, 0, -100, 4e5), MAPS["feet"]


@pytest.mark.parametrize("z, place, units, words, silent", [
    (HILLS, (DEGREES, None), None, "looks like degrees", {}),
    (np.where(HILLS > 3, HILLS, -9999), (METRES, MAPS["utm"]), "metre", "3 samples are -9999", {"nodata": -9999}),
    (HILLS + 1e9, (METRES, MAPS["utm"]), "metre", "heights are floats, and those up to 1e+09 are rounded to multiples of 64", {}),
    (HILLS, STATE, None, "heights taken as US survey ft, as x and y;", {"zscale": 3.2808}),
    (HILLS, (METRES, None), "ft", "heights are in ft, and x and y are taken as metres", {"zscale": 1}),
    # A part that no file covers reads as 0. A coast, and a plain with towers, look otherwise.
    (TILE, (METRES, MAPS["utm"]), "metre", "28 % of the samples are exactly 0, and the next ones are 104", {"nodata": 0}),
    *((z + (z == 0) * (np.arange(50) % 2) * np.float32(0.5), (METRES, MAPS["utm"]), "metre", None, {})
      for z in (TILE - 104, np.where(TILE > 110, 0, TILE), np.where(TILE > 399.9, TILE, 0).astype("float32"))),
    (HILLS, (DEGREES, "EPSG:4326"), "metre", None, {}), (HILLS, STATE, "metre", None, {}), (HILLS, STATE, "ft", None, {})])
def test_what_looks_wrong(z, place, units, words, silent):
    """Is said once by the program, and by Python at the caller's line; so is what would silence it. Feet for x and y say nothing of heights."""
    path, z = write("dem.tif", z.astype("float32"), place[1], place[0], units), z.astype("float32")
    for more, options, warned in [((), {}, words)] + [((f"--{k}", v), {k: v}, None) for k, v in silent.items()]:
        for command in ("shadow", "--sun", "200,30", "-o", "o.tif"), ("info",):
            said = run(command[0], path, *command[1:], *more).err
            assert said.count("warning:") == (warned is not None) and (warned or "") in said and all(f"--{k} {v}" in said for k, v in silent.items() if warned)
        makers = [lambda: cw.open(path, **options)] + [lambda: cw.Field(z, *place, **options)] * (units is None or units == "metre" and place is not STATE)
        for make in makers:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                make()
            assert len(caught) == (warned is not None) and all(warning.filename == __file__ for warning in caught), caught
            assert all(warned in str(warning.message) and all(f"{k}={v}" in str(warning.message) for k, v in silent.items()) for warning in caught), caught


@pytest.mark.parametrize("arguments", [{}, {"hillshade": True}, {"disc": True}, {"curvature": 1.0}])
def test_night(arguments):
    """Is said, and nothing is lit below what the dip of the horizon explains; at the rim there is some light."""
    y, x = np.mgrid[0:60, 0:60]
    z = (600 + 300 * np.sin(x / 7) * np.cos(y / 5)).astype("float32")
    z[4, 5] = np.nan
    field, dip = cw.Field(z, METRES, MAPS["utm"]), np.degrees(np.arccos(6378137 / (6378137 + z)))
    rim = []
    for azimuth, altitude in ((a, h) for a in range(0, 360, 90) for h in (-89.9, -3.0, -1.5, -0.6, -0.3)):
        with pytest.warns(UserWarning, match=f"sun is at {altitude:.3f} degrees, not above the horizon") as said:
            lit = field.shadow(azimuth, altitude, **arguments)
        assert len(said) == 1 and said[0].filename == __file__ and (lit[4, 5] == 255 if lit.dtype == np.uint8 else np.isnan(lit[4, 5]))
        assert (lit[np.isfinite(z) & (dip < -altitude - ("disc" in arguments) * 0.2666 - 1e-6)] == 0).all()
        rim.append(altitude == -0.3 and (lit[:, [0, -1]] > 0).any())
    assert any(rim)


@pytest.mark.parametrize("name", ["utm", "degrees"])
def test_places_written_to_the_millimetre(name):
    """A sample between holes has no triangle, and its place stays its own."""
    affine = Affine(7.001, 0, 600000.1234, 0, -7.001, 5200000.4321) if name == "utm" else Affine(1e-4 / 3, 0, 10.5, 0, -1e-4 / 3, 47.25)
    digits = 3 if name == "utm" else 8
    z = np.arange(99, dtype="float32").reshape(9, 11)
    z[3:6, 3:6] = np.nan
    z[4, 4] = 50
    field = cw.Field(z, affine, MAPS[name])
    for row, column in ((4, 4), (1, 1), (8, 10), (2, 4)):
        x, y = (round(v, digits) for v in affine * (column + 0.5, row + 0.5))
        assert field.viewshed(x, y, 300)[row, column] == 1
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
    for row, column in np.ndindex(12, 12):
        answers = []
        for field in (here, far):
            x, y = Affine(*field.transform) * (column + 0.5, row + 0.5)
            if np.isfinite(z[row, column]):  # a corner of the raster, or a sample beside the hole
                field.viewshed(x, y, 1)
            answers.append(field.viewshed(x, y, observer_elevation=400 * cell, needed=True, curvature=0))
        assert np.allclose(*answers, rtol=1e-6, atol=1e-6 * cell, equal_nan=True), (row, column)


@pytest.mark.parametrize("tilt", [0, 37, 89.9, 90, 90.1, 135, 180])
def test_the_sky_of_a_leaning_surface(tilt):
    """A surface on a plain sees (1 + cos tilt) / 2 of it; one that overhangs sees less and less, and never less than nothing."""
    day = cw.Field(np.full((7, 9), 300.0)).sun_days(4, 3, "2024-06-21", tilt=tilt, facing=120, step="1h", sky=720, lon_lat=(9, 47))
    assert abs(day.diffuse[0] - day.free_diffuse[0]) < 0.05 and day.free_direct[0] == day.direct[0] >= 0
    hills = cw.Field(np.random.default_rng(1).normal(0, 3, (7, 9))).sun_days(4, 3, "2024-06-21", tilt=tilt, sky=32, step="1h", lon_lat=(9, 47))
    assert 0 <= hills.diffuse[0] <= hills.free_diffuse[0] + 1


def test_days_without_hills():
    """In winter a roof to the south gets most, level ground less, a wall to the north nothing; level land hides no sun."""
    south, level, north = (cw.Field(np.zeros((9, 9))).sun_days(4, 4, "2024-02-10", step="1h", lon_lat=(0, 50), tilt=tilt, facing=facing)
                           for tilt, facing in ((40, 180), (0, 180), (90, 0)))
    assert south.direct > level.direct > north.direct == 0 and level.hours == level.free_hours == (level.set - level.rise) / np.timedelta64(1, "h")
    assert len({cw.Field(np.zeros((9, 9))).sun_days(4, 4, "2024-02-10", lon_lat=(x, 50)).rise.item() for x in (-10, 350)}) == 1


def test_horizons_of_places(maps):
    """A table of places and those of the command line say the same; azimuths of the map and from true north are apart by UTM's formula."""
    east, north = inside(3)
    for name in ("utm", "degrees"):
        crs, words = MAPS[name], ("horizon", maps[name], "--directions", "5", "--start", "7")
        x, y = transform("EPSG:32632", crs, list(east), list(north))
        given = [f"{a!r},{b!r},{k}" for k, (a, b) in enumerate(zip(x, y))]
        write_text("places.csv", "\n".join(["x,y,height", *given, ""]))
        assert tool(*words, "--places", "places.csv", "-o", "out.csv") == ""
        text = open("out.csv").read()
        assert text == tool(*words, *[w for place in given for w in ("--at", place)]) and text.startswith("place,azimuth,true_azimuth,angle,distance,x,y\n")
        rows = np.array([line.split(",") for line in text.splitlines()[1:]], float).reshape(3, 5, 7)
        assert (rows[:, :, 0].T == [1, 2, 3]).all()
        lon, lat = map(np.radians, degrees_of(crs, x, y))
        apart = 0 if name == "degrees" else -np.degrees(np.arctan(np.tan(lon - np.radians(9)) * np.sin(lat)))
        assert np.allclose(rows[:, 0, 1] - rows[:, 0, 2], apart, atol=2e-3)
        noon, middle = "2024-12-21T13:00:00Z", degrees_of(crs, [np.mean(x)], [np.mean(y)])
        true, of_map = cw.sun(noon, float(middle[0][0]), float(middle[1][0])), cw.open(maps[name]).sun(noon)
        assert abs(of_map.azimuth - true.azimuth - np.ravel(np.broadcast_to(apart, 3)).mean()) < 0.2


def test_horizons_of_rough_land_in_degrees():
    """Rows that share a heading are off in proportion to the ground's steepest rise; at a place the row's own scale counts."""
    for north, bumps, azimuth in ((70, 300, 117), (46, 300, 60), (46, 30, 117), (-60, 100, 290)):
        z = np.random.default_rng(2).uniform(0, bumps, (31, 43)).astype("float32")
        field = cw.Field(z, (3e-4, 0, 10, 0, -2e-4, north), "EPSG:4326")
        j, i = np.mgrid[0:31, 0:43].reshape(2, -1) + 0.5
        exact = field.horizon_at(10 + 3e-4 * i, north - 2e-4 * j, directions=1, start=azimuth).angle
        steepest = np.hypot(np.diff(z, axis=0).max() / 22.2, np.diff(z, axis=1).max() / (33.4 * np.cos(np.radians(north))))
        apart = np.nanmax(np.abs(np.ravel(field.horizon(1, start=azimuth)) - np.ravel(exact)))
        assert 5e-4 * steepest < apart < 0.003 * (1 + steepest)


def test_the_nearest_of_equal_rises():
    """On a plane every crossing is as steep as the next one: the first one is the horizon."""
    j, i = np.mgrid[0:60, 0:60]
    for slopes, azimuth in (((3, 2), 200), ((3, 2), 17), ((1, -4), 100.5), ((0, 0), 310)):
        field = cw.Field((1000 + slopes[0] * i + slopes[1] * j).astype("float32"), METRES, MAPS["utm"])
        inner = field.horizon(1, start=azimuth, distance=True)[0, 2:-2, 2:-2]
        assert np.isfinite(inner).all() and np.ptp(inner) < 1e-3 and inner.max() < 42.5


def test_horizons_at_ends():
    """A row between holes, all of one height: the nearest sample counts. A wall is where max_distance ends, or is not. And along an axis of a map
    that is turned and three times as wide as long the last row has the terrain that is there."""
    row = np.full((3, 8), np.nan, "float32")
    row[1] = 60
    assert cw.Field(row).horizon(1, start=90, distance=True)[0, 1, :-1].tolist() == [1] * 7
    wall = np.zeros((2, 12), "float32")
    wall[:, 10] = 5
    field = cw.Field(wall)
    for most, angle, away in (10, np.degrees(np.arctan(0.5)), 10), (9.999995, 0, 1):
        at = field.horizon_at(0, 0, directions=1, start=90, max_distance=most)
        assert abs(field.horizon(1, most, start=90)[0, 0, 0] - angle) < 1e-5 and abs(at.angle[0] - angle) < 1e-9, most
        assert field.horizon(1, most, start=90, distance=True)[0, 0, 0] == away and abs(at.distance[0] - away) < 1e-9, most
    for turn in np.arange(0.1, 90, 3.7):
        s, c = np.sin(np.radians(turn)), np.cos(np.radians(turn))
        angles = cw.Field(np.random.default_rng(1).random((5, 5), "float32"), (c, 3 * s, 0, -s, 3 * c, 0)).horizon(4, start=turn)
        assert (np.isnan(angles).sum((1, 2)) == 5).all(), turn
