# SPDX-License-Identifier: Apache-2.0
"""Rays, and what the program prints and draws, against Python; test_products.py has the products."""
import csv
import json
import pathlib
import re

import numpy as np
import pytest
from program import feature, geojson, run, well, write

import cellwalk as cw
from conftest import Places, geotiff, random_rays, raster, rough, same, tool


def traced(h, path, rays, *words):
    """The hits are those of the program."""
    np.save("rays.npy", rays)
    tool("trace", path, "rays.npy", *words, "-o", "hits.npy")
    wanted = np.load("hits.npy")
    assert 0 < h.hit.mean() < 0.95 and (h.triangle == wanted["triangle"]).all()
    for name in ("t", "u", "v", "i", "j"):
        same(getattr(h, name), wanted[name])
    return wanted


def test_rays_of_maps(ground):
    rays = random_rays(ground.field, 20000)
    h = ground.field.closest(rays)
    wanted = traced(h, ground.path, rays, "--user", "--points", "--normals")
    same(h.points(), np.stack([wanted[n] for n in ("x", "y", "z")], -1))
    same(h.normals().astype(np.float32), np.stack([wanted[n] for n in ("nx", "ny", "nz")], -1))
    tool("trace", ground.path, "rays.npy", "--user", "--occluded", "-o", "any.npy")
    same(ground.field.occluded(rays).view(np.uint8), np.load("any.npy"))


def test_kernels():
    """The program has some more, to compare with."""
    said, z = {tuple(k[name] for name in ("name", "width", "isa", "available")) for k in json.loads(tool("info", "--json"))["kernels"]}, rough(holes=False)
    assert {(k.name, k.width, k.isa, k.available) for k in cw.kernels()} < said
    np.save("z.npy", z)
    rays = random_rays(cw.Field(z), 2000, dtype=np.float32)
    for name in (k.name for k in cw.kernels() if k.available):
        traced(cw.Field(z).closest(rays, kernel=name), "z.npy", rays, "--kernel", name)


def test_sun(ground):
    if ground.path.suffix != ".npy":
        p = ground.field.sun("2024-06-21T09:00:00Z")
        assert f"({p.azimuth:.3f} on the map), altitude {p.altitude:.3f}" in tool("shadow", ground.path, "--time", "2024-06-21T09:00:00Z", "-o", "s.npy")


def says(wanted, name, path, *words, out):
    """The line at the end, unless --quiet is given."""
    said = run(name, path, *words, "-o", out).outcome
    assert re.fullmatch(rf"cellwalk {name}: {re.escape(out)}: {wanted}, \d+\.\d\d s\n", said), (wanted, said)
    assert run(name, path, *words, "--quiet", "-o", out).outcome == ""


def test_lines_of_products(ground):
    out, at = "out" + ground.path.suffix, Places(ground).at[0]
    for words, part in (("shadow", "--sun", "300,20"), "in the sun"), (("viewshed", "--from", f"{at},9"), "in sight"):
        tool(words[0], ground.path, *words[1:], "-o", out)
        seen = raster(out)
        says(f"{100 * (seen == 1).sum() / (seen != 255).sum():.3g} % of {(seen != 255).sum()} samples {part}", words[0], ground.path, *words[1:], out=out)
    tool("horizon", ground.path, "--svf", "-o", out)
    sky = raster(out)
    sky = sky[np.isfinite(sky)]
    says(rf"{sky.min():.3g} to {sky.max():.3g}, median [\d.]+, of {sky.size} samples", "horizon", ground.path, "--svf", out=out)


@pytest.mark.parametrize("name, words, wanted", [
    ("horizon", "--at {at} --at {at},9", "horizons of 2 places"), ("sun", "--at {at} --date 2024-03 {where}", r"31 days at a place, \d+ hours of sun, [\d.]+ kWh/m2"),
    ("sun", "--at {at} --suns suns.csv", "the suns of suns.csv at a place"), ("los", "--pairs pairs.csv", "1 of 2 pairs see each other"),
    ("trace", "rays.npy --user", "33.3 % of 3 rays hit"), ("render", "--size 40x30 --samples 1", "40 x 30 pixels")])
def test_lines_of_tables_rays_and_pictures(ground, name, words, wanted):
    p = Places(ground)
    write("suns.csv", "azimuth,altitude\n180,30\n")
    write("pairs.csv", f"x1,y1,height1,x2,y2,height2\n{p.at[0]},500,{p.at[1]},500\n{p.at[0]},0,{p.at[1]},0\n")
    np.save("rays.npy", np.array([[p.xs[0], p.ys[0], 1e6, 0, dx, 0, -1, np.inf] for dx in (0, 1e9, -1e9)]))
    says(wanted, name, ground.path, *words.format(at=p.at[0], where="" if p.known else "--lon-lat 9,47").split(), out={"trace": "hits.npy", "render": "out.png"}.get(name, "out.csv"))


def test_pictures_show_relief_values_and_observers(ground):
    image, p = pytest.importorskip("matplotlib.image"), Places(ground)
    for out in "seen.npy", "seen.png":
        tool("viewshed", ground.path, "--from", f"{p.at[0]},9", "-o", out)
    seen, picture = np.load("seen.npy"), (image.imread("seen.png")[..., :3] * 255).round().astype(int)
    marks = (picture == (213, 94, 0)).all(-1)
    at = np.linalg.inv(np.array(ground.field.map)[:2, :2]) @ (p.spot(0) - np.array(ground.field.map)[:2, 3])
    assert marks.sum() >= 5 and np.abs(np.argwhere(marks).mean(0)[::-1] - at).max() < 1
    clear = ~marks & ~(picture == 255).all(-1)
    yellow = picture[..., 0] - picture[..., 2]  # the ramp ends in blue and in yellow
    assert yellow[clear & (seen == 1)].min() > yellow[clear & (seen == 0)].max()
    south, east = np.gradient(ground.field.z)
    shown = clear & (seen == 0) & np.isfinite(south + east)  # the relief: light comes from the northwest
    assert np.corrcoef(picture[shown].sum(-1), (south + east)[shown])[0, 1] > 0.5, np.corrcoef(picture[shown].sum(-1), (south + east)[shown])
    tool("visibility", ground.path, "--directions", "1", "--every", "3", "-o", "third.png")
    assert image.imread("third.png").shape[:2] == seen[::3, ::3].shape


@pytest.fixture(scope="module")
def hills(tmp_path_factory):
    return geotiff(tmp_path_factory.mktemp("hills") / "dem.tif", 10 * rough(333, 333, holes=False), transform=(30, 0, 595000, 0, -30, 5211000))


def test_degrees_for_metres(hills):
    for words in ("viewshed", hills, "--from", "10.3,47", "-o", "o.tif"), ("los", hills, "10.3,47", "10.4,47"):
        assert "10.3,47: lies outside and looks like longitude and latitude" in tool(*words, fails=True).replace(",2:", ":").replace(",0:", ":")


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (9, 9)])
def test_least_terrain(shape):
    """One row is none. Level land a hair below 0 is not at minus zero."""
    path, at = geotiff("line.tif", np.full(shape, -1e-4, "float32")), ("600015,5199985,0", "600200,5199830,0")
    write("pairs.csv", "x1,y1,height1,x2,y2,height2\n" + ",".join(at) + "\n")
    for words in (["shadow", path, "--sun", "9,9", "-o", "o.tif"], ["los", path, *at, "--curvature", 0, "--profile", "p.csv"],
                  ["los", path, "--pairs", "pairs.csv", "--curvature", 0]):
        done = run(*words)
        if shape != (9, 9):
            assert done.status == 1 and f"{shape[1]} x {shape[0]} samples; a terrain has at least 2 x 2" in done.err
        else:
            said = done.out + (pathlib.Path("p.csv").read_text() if "--profile" in words else "")
            assert done.status == 0 and "-0.000" not in said and (words[0] == "shadow" or "0.000" in said)


# ---- observers of files --------------------------------------------------------------------------------------------------------


KML = ('<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>Mast</name><ExtendedData><Data name="height"><value>30</value>'
       '</Data></ExtendedData><Point><coordinates>10.32,47.0</coordinates></Point></Placemark></Document></kml>')
HERE = [600000.1, 5206000.3]


@pytest.mark.parametrize("name, place, attributes, height, warned", [
    ("a.geojson", HERE, {"OFFSETA": 30.0, "name": "Mast"}, 30, None),
    ("a.geojson", HERE + [1500.0], {"height": 30.0, "OFFSETA": 1.0, "AZIMUTH1": 20, "RADIUS2": None}, 30, "'OFFSETA', 'AZIMUTH1', z of places; attributes"),
    ("a.geojson", HERE + [0.0], {}, 2, None), ("a.kml", HERE, {}, 30, None)])
def test_attributes_of_observers(hills, name, place, attributes, height, warned):
    """What is known counts; what is passed over is said."""
    geojson("a.geojson", feature("Point", place, **attributes))
    write("a.kml", KML)
    made = run("viewshed", hills, "--observers", name, "-o", "o.tif")
    assert made.status == 0 and ((warned or "passed over") in made.err) == (warned is not None), made.err
    with pytest.importorskip("rasterio").open("o.tif") as file:
        x, y, z = map(float, file.tags()["OBSERVER_1"].split(","))
        assert z == height and (file.read(1) == cw.open(hills).viewshed(x, y, height)).all()


def test_names_of_observers(hills):
    write("towers.csv", "name,x,y\nHigh Mast,601000.639,5206000.639\n,600000,5205000\n\"a\nb\",600500,5204000\n" + "ä" * 40 + ",600500,5205500\n")
    well("viewshed", hills, "--observers", "towers.csv", "--bands", "-o", "o.tif")
    with pytest.importorskip("rasterio").open("o.tif") as file:
        assert file.descriptions[:3] == ("observer 1 (High Mast) at 601000.639,5206000.639", "observer 2 at 600000,5205000",
                                         "observer 3 (a b) at 600500,5204000")
        tags = file.tags()
        assert tags["OBSERVER_1"] == "601000.639,5206000.639,2" and tags["OBSERVER_1_NAME"] == "High Mast"
        assert "OBSERVER_2_NAME" not in tags and set(tags["OBSERVER_4_NAME"]) == {"ä"}
    write("towers.csv", "name,x,y,x1,y1,x2,y2\n" + "".join(f'{name},600500,5204000,600000,5205000,600100,5205000\n' for name in ("High Mast", "", '"a, ""b"""')))
    for words in (("viewshed", hills, "--observers", "towers.csv", "--table", "-", "-o", "o.tif"), ("horizon", hills, "--places", "towers.csv", "--directions", 1),
                  ("los", hills, "--pairs", "towers.csv", "--frequency", 900)):
        assert [row["name"] for row in csv.DictReader(tool(*words).splitlines())] == ["High Mast", "", 'a, "b"']


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
        radius, exact = (np.sqrt(0.299792458 / 0.868 * np.hypot(length, p.line[-1] - p.line[0]) * (at / length) * (1 - at / length)) for at in (s, p.distance))
        np.testing.assert_allclose(p.fresnel_radius, exact, rtol=1e-6, atol=1e-4)
        inside = (radius > 0.01) & np.isfinite(gap)
        if inside.any():
            least = (gap[inside] / radius[inside]).min()
            assert least - 0.02 * abs(least) - 1e-4 <= answers.clearance[k] <= least + 1e-4
