# SPDX-License-Identifier: Apache-2.0
"""Rays, coarser fields and what the program prints and draws against Python; test_products.py has the products."""
import csv
import json
import re

import numpy as np
import pytest

import cellwalk as cw
from conftest import geotiff, random_rays, raster, rough, same


def product(tool, ground, tmp_path, *words):
    out = tmp_path / ("out" + ground.path.suffix)
    tool(words[0], ground.path, *words[1:], "-o", out)
    return raster(out)


def north(ground, y):
    """The program has the first row of a file without a map in the north, and y counts from the last."""
    return y if ground.path.suffix != ".npy" else ground.field.shape[0] - 1 - y


def place(field, across=0.37, down=0.61):
    x0, y0, x1, y1 = field.bounds
    return x0 + across * (x1 - x0), y0 + down * (y1 - y0)


def test_kernels(tool):
    """The program has some more, to compare with."""
    said = {tuple(k[name] for name in ("name", "width", "isa", "available")) for k in json.loads(tool("info", "--json"))["kernels"]}
    assert {(k.name, k.width, k.isa, k.available) for k in cw.kernels()} < said


def same_as_traced(h, wanted):
    assert 0 < h.hit.mean() < 0.95
    for name in ("t", "u", "v", "i", "j"):
        same(getattr(h, name), wanted[name])
    assert (h.triangle == wanted["triangle"]).all()


def test_closest_user(tool, ground, tmp_path):
    rays = random_rays(ground.field, 20000)
    np.save(tmp_path / "rays.npy", rays)
    tool("trace", ground.path, tmp_path / "rays.npy", "--user", "--points", "--normals", "-o", tmp_path / "hits.npy")
    wanted = np.load(tmp_path / "hits.npy")
    h = ground.field.closest(rays)
    same_as_traced(h, wanted)
    same(h.points(), np.stack([wanted[n] for n in ("x", "y", "z")], -1))
    same(h.normals().astype(np.float32), np.stack([wanted[n] for n in ("nx", "ny", "nz")], -1))
    tool("trace", ground.path, tmp_path / "rays.npy", "--user", "--occluded", "-o", tmp_path / "any.npy")
    same(ground.field.occluded(rays).view(np.uint8), np.load(tmp_path / "any.npy"))


def test_closest_floats(tool, tmp_path):
    z = rough(holes=False)
    rays = random_rays(cw.Field(z), 2000, dtype=np.float32)
    np.save(tmp_path / "z.npy", z)
    np.save(tmp_path / "rays.npy", rays)
    for kernel in [k for k in cw.kernels() if k.available]:
        tool("trace", tmp_path / "z.npy", tmp_path / "rays.npy", "--kernel", kernel.name, "-o", tmp_path / "hits.npy")
        same_as_traced(cw.Field(z).closest(rays, kernel=kernel.name), np.load(tmp_path / "hits.npy"))


@pytest.mark.parametrize("name", ["mean", "highest", "lowest"])
def test_coarser(tool, ground, tmp_path, name):
    """Shadows and places on a map of cells three times as large, as the program has them."""
    full, wanted = ground.field, product(tool, ground, tmp_path, "shadow", "--sun", "300,20", "--coarser", "3", "--filter", name)
    before = full.z.copy()
    field = full.coarser(3, name)
    assert field.shape == (21, 29)
    same(field.shadow(300, 20), wanted)
    x, y = place(field)
    y_of_file = y if ground.path.suffix != ".npy" else 3 * (field.shape[0] - 1) - y
    if name != "lowest":  # which has a hole there
        seen = product(tool, ground, tmp_path, "viewshed", "--from", f"{x!r},{y_of_file!r},2", "--coarser", "3", "--filter", name)
        same(field.viewshed(x, y), seen)
    same(full.z, before)
    assert full.difference is None and field.difference.rms > 0
    assert (field.difference.below == 0) == (name == "highest") and (field.difference.above == 0) == (name == "lowest")
    column, row = 12, 9
    same(field.at(*field.map[:2] @ (column, row, 0, 1)), full.coarser(3, name).at(*full.map[:2] @ (3 * column, 3 * row, 0, 1)))


def test_sun(tool, ground, tmp_path):
    if ground.path.suffix == ".npy":
        return
    said = tool("shadow", ground.path, "--time", "2024-06-21T09:00:00Z", "-o", tmp_path / "s.npy")
    p = ground.field.sun("2024-06-21T09:00:00Z")
    assert f"({p.azimuth:.3f} on the map), altitude {p.altitude:.3f}" in said


# ---- what a person sees -------------------------------------------------------------------------------------------------


def outcome(program, *words):
    done = program(*words)
    assert done.returncode == 0, done.stderr
    return done.stderr.splitlines()


def test_the_line_at_the_end_says_what_came_out(program, ground, tmp_path):
    out = tmp_path / ("out" + ground.path.suffix)
    x, y = place(ground.field)
    *_, line = outcome(program, "shadow", ground.path, "--sun", "300,20", "-o", out)
    lit = raster(out)
    share = 100 * (lit == 1).sum() / (lit != 255).sum()
    assert line.startswith(f"cellwalk shadow: {out}: {share:.3g} % of {(lit != 255).sum()} samples in the sun, ")
    *_, line = outcome(program, "viewshed", ground.path, "--from", f"{x:.9g},{north(ground, y):.9g},9", "-o", out)
    seen = raster(out)
    assert f": {100 * (seen == 1).sum() / (seen != 255).sum():.3g} % of {(seen != 255).sum()} samples in sight, " in line
    *_, line = outcome(program, "horizon", ground.path, "--svf", "-o", out)
    sky = raster(out)
    sky = sky[np.isfinite(sky)]
    assert f": {sky.min():.3g} to {sky.max():.3g}, median " in line and f", of {sky.size} samples, " in line
    assert not any("samples" in line for line in outcome(program, "horizon", ground.path, "--svf", "--quiet", "-o", out))


@pytest.mark.parametrize("name, words, says", [
    ("horizon", "--at {at} --at {at},9", "horizons of 2 places"), ("sun", "--at {at} --date 2024-03 --lon-lat 9,47", r"31 days at a place, \d+ hours of sun, [\d.]+ kWh/m2"),
    ("sun", "--at {at} --suns {suns}", "the suns of {suns} at a place"), ("los", "--pairs {pairs}", "1 of 2 pairs see each other"),
    ("trace", "{rays} --user", "33.3 % of 3 rays hit"), ("render", "--size 40x30 --samples 1", "40 x 30 pixels")])
def test_so_does_the_line_of_tables_rays_and_pictures(program, ground, tmp_path, name, words, says):
    x, y = place(ground.field)
    at, files = f"{x!r},{north(ground, y)!r}", {key: tmp_path / f"{key}.csv" for key in ("suns", "pairs")}
    files["suns"].write_text("azimuth,altitude\n180,30\n")
    u, v = place(ground.field, 0.8, 0.2)
    far = f"{u!r},{north(ground, v)!r}"
    files["pairs"].write_text(f"x1,y1,height1,x2,y2,height2\n{at},500,{far},500\n{at},0,{far},0\n")
    files["rays"] = tmp_path / "rays.npy"
    np.save(files["rays"], np.array([[x, y, 1e6, 0, dx, 0, -1, np.inf] for dx in (0, 1e9, -1e9)]))
    out = tmp_path / {"trace": "hits.npy", "render": "out.png"}.get(name, "out.csv")
    words = [word.format(at=at, **files) for word in words.split()]
    *_, line = outcome(program, name, ground.path, *words, "-o", out)
    assert re.fullmatch(rf"cellwalk {name}: {re.escape(str(out))}: {says.format(**{key: re.escape(str(path)) for key, path in files.items()})}, \d+\.\d\d s", line)
    assert not any(str(out) in line for line in outcome(program, name, ground.path, *words, "--quiet", "-o", out))


def test_pictures_show_relief_values_and_observers(program, tool, ground, tmp_path):
    image = pytest.importorskip("matplotlib.image")
    x, y = place(ground.field)
    words = ["viewshed", ground.path, "--from", f"{x:.9g},{north(ground, y):.9g},9", "-o"]
    tool(*words, tmp_path / "seen.npy")
    tool(*words, tmp_path / "seen.png")
    seen, picture = np.load(tmp_path / "seen.npy"), (image.imread(tmp_path / "seen.png")[..., :3] * 255).round().astype(int)
    marks = (picture == (213, 94, 0)).all(-1)
    rows, columns = np.nonzero(marks)
    x0, y0, x1, y1 = ground.field.bounds
    if ground.path.parent.name.startswith(("utm", "degrees", "mercator")):  # north is up: places follow from the bounds
        assert abs(columns.mean() - (x - x0) / (x1 - x0) * (seen.shape[1] - 1)) < 1
        assert abs(rows.mean() - (y1 - y) / (y1 - y0) * (seen.shape[0] - 1)) < 1
    assert marks.sum() >= 5
    clear = ~marks & ~(picture == 255).all(-1)
    yellow = picture[..., 0] - picture[..., 2]  # the ramp ends in blue and in yellow
    assert yellow[clear & (seen == 1)].min() > yellow[clear & (seen == 0)].max()
    blue = picture[clear & (seen == 0)].sum(-1)
    assert blue.std() > 10  # the relief shows
    third, *_ = tmp_path / "third.png", tool("visibility", ground.path, "--directions", "1", "--every", "3", "-o", tmp_path / "third.png")
    assert image.imread(third).shape[:2] == seen[::3, ::3].shape


@pytest.fixture(scope="module")
def hills(tmp_path_factory):
    return geotiff(tmp_path_factory.mktemp("hills") / "dem.tif", 10 * rough(333, 333, holes=False), transform=(30, 0, 595000, 0, -30, 5211000))


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
    (["horizon", "--at", "1,2", "--places", "p.csv"], "do not go together"),
    (["horizon", "--at", "1,2", "--svf"], "go with none of --svf"),
])
def test_messages(tool, hills, tmp_path, words, said):
    words = [tmp_path / word if word.startswith("o.") else word for word in words]
    assert said in tool(words[0], hills, *words[1:], fails=True)


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (9, 9)])
def test_least_terrain(tool, tmp_path, shape):
    """One row is none. Level land a hair below 0 is not at minus zero."""
    path, at = geotiff(tmp_path / "line.tif", np.full(shape, -1e-4, "float32")), ("600015,5199985,0", "600200,5199830,0")
    (tmp_path / "pairs.csv").write_text("x1,y1,height1,x2,y2,height2\n" + ",".join(at) + "\n")
    for words in (["shadow", path, "--sun", "9,9", "-o", tmp_path / "o.tif"], ["los", path, *at, "--profile", tmp_path / "p.csv"],
                  ["los", path, "--pairs", tmp_path / "pairs.csv"]):
        said = tool(*words, *(["--curvature", "0"] if words[0] == "los" else []), fails=shape != (9, 9))
        assert f"{shape[1]} x {shape[0]} samples; a terrain has at least 2 x 2" in said if shape != (9, 9) else "-0.000" not in said
        assert words[0] == "shadow" or shape != (9, 9) or "0.000" in said
    assert shape != (9, 9) or ("-0.000" not in (tmp_path / "p.csv").read_text() and ",0.000," in (tmp_path / "p.csv").read_text())


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
def test_attributes_of_observers(program, hills, tmp_path, name, text, height, warned):
    """What is known counts; what is passed over is said."""
    (tmp_path / name).write_text(text)
    made = program("viewshed", hills, "--observers", tmp_path / name, "-o", tmp_path / "o.tif")
    assert made.returncode == 0 and ((warned or "passed over") in made.stderr) == (warned is not None), made.stderr
    with pytest.importorskip("rasterio").open(tmp_path / "o.tif") as file:
        assert file.tags()["OBSERVER_1"].endswith(f",{height}")
        seen = file.read(1)
        x, y, _ = map(float, file.tags()["OBSERVER_1"].split(","))
    assert (seen == cw.open(hills).viewshed(x, y, height)).all()


def test_names_of_observers(program, hills, tmp_path):
    table = tmp_path / "towers.csv"
    table.write_text("name,x,y\nHigh Mast,601000.639,5206000.639\n,600000,5205000\n\"a\nb\",600500,5204000\n" + "ä" * 40 + ",600500,5205500\n")
    assert "warning" not in program("viewshed", hills, "--observers", table, "--bands", "-o", tmp_path / "o.tif").stderr
    with pytest.importorskip("rasterio").open(tmp_path / "o.tif") as file:
        assert file.descriptions[:3] == ("observer 1 (High Mast) at 601000.639,5206000.639", "observer 2 at 600000,5205000",
                                         "observer 3 (a b) at 600500,5204000")
        tags = file.tags()
        assert tags["OBSERVER_1"] == "601000.639,5206000.639,2" and tags["OBSERVER_1_NAME"] == "High Mast"
        assert "OBSERVER_2_NAME" not in tags and set(tags["OBSERVER_4_NAME"]) == {"ä"}
    table.write_text("name,x,y\nHigh Mast,601000.639,5206000.639\n,600000,5205000\n\"a, \"\"b\"\"\",600500,5204000\n")
    names = ["High Mast", "", 'a, "b"']
    program("viewshed", hills, "--observers", table, "--table", tmp_path / "t.csv", "-o", tmp_path / "o.tif")
    assert [row["name"] for row in csv.DictReader((tmp_path / "t.csv").read_text().splitlines())] == names
    said = program("horizon", hills, "--places", table, "--directions", 1).stdout
    assert [row["name"] for row in csv.DictReader(said.splitlines())] == names
    table.write_text("x1,y1,x2,y2,name\n600000,5205000,600100,5205000,\"a, \"\"b\"\"\"\n")
    done = program("los", hills, "--pairs", table, "--frequency", 900)
    assert [row["name"] for row in csv.DictReader(done.stdout.splitlines())] == ['a, "b"'] and "warning" not in done.stderr
    table.write_text("name,x,y\nFar Mast,1,1\n")
    assert "towers.csv:2 (Far Mast)" in program("viewshed", hills, "--observers", table, "-o", tmp_path / "p.tif").stderr


# ---- radio links --------------------------------------------------------------------------------------------------------


def test_clearance_over_a_plain():
    """Is least in the middle; from 0.5 to 12 m it is least where the heights are as the distances to the ends, between two crossings."""
    f = cw.Field(np.zeros((3, 401), np.float32), transform=np.diag([10, 10, 1, 0])[:3])
    for height, share in ((12, 0.5), (0.5, 0.04)):
        s = f.line_of_sight((0, 10, height), (4000, 10, 12), frequency=2400, curvature=0)
        radius = np.sqrt(0.299792458 / 2.4 * np.hypot(4000, 12 - height) * share * (1 - share))
        assert s.clearance_distance == pytest.approx(4000 * share, rel=1e-6) and s.fresnel_radius == pytest.approx(radius, rel=1e-6)
        assert s.clearance == pytest.approx((height + (12 - height) * share) / radius, rel=1e-6)


def test_clearance_is_the_least_along_the_profile(ground):
    f, random = ground.field, np.random.default_rng(5)
    solid = np.argwhere(np.lib.stride_tricks.sliding_window_view(np.isfinite(f.z), (3, 3)).all((2, 3))) + 1
    ends = np.empty((2, 40, 3))
    for end in ends:
        j, i = solid[random.integers(len(solid), size=40)].T
        end[:, :2], end[:, 2] = (f.map[:2, :2] @ (i, j)).T + f.map[:2, 3], random.uniform(1, 60, 40)
    options = {"frequency": 868, "curvature": 0.75}
    answers = f.line_of_sight(*ends, **options)
    for k, (a, b) in enumerate(zip(*ends)):
        p, length = f.profile(a, b, **options), answers.distance[k]
        s = np.unique(np.r_[p.distance, np.linspace(0, length, 20001)[1:-1]])
        gap = np.interp(s, p.distance, p.line - p.ground)
        radius = np.sqrt(0.299792458 / 0.868 * np.hypot(length, p.line[-1] - p.line[0]) * (s / length) * (1 - s / length))
        inside = (radius > 0.01) & np.isfinite(gap)
        if inside.any():
            least = (gap[inside] / radius[inside]).min()
            assert least - 0.02 * abs(least) - 1e-4 <= answers.clearance[k] <= least + 1e-4


def test_frequencies_that_are_none(tool, ground):
    x, y = place(ground.field)
    at = f"{x:.9g},{north(ground, y):.9g},9"
    for wrong in ("-1", "0.01", "1e9"):
        assert "--frequency takes megahertz from 0.1 to 1000000" in tool("los", ground.path, at, at, "--frequency", wrong, fails=True)
