# SPDX-License-Identifier: Apache-2.0
"""Every option of the program's products against Python, bit for bit, from one list. An option that --help names and no case has must
be excused here with a reason."""
import csv
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from program import commands, run, sets, write

import cellwalk as cw
from conftest import Places, geotiff, raster, same, tool


def needs_crs(case):
    """A file without a coordinate system is told where it is."""
    return lambda f, p: case(f, {} if p.known else {"lon_lat": (11, 47)})


# Azimuth, altitude, weight.
SUNS = [(225, 20, 2), (100, 35, 0.5), (-20, 3, 1.25), (300, -5, 4), (102, 11, 8), (99, 90, 0)]

MANY = "--from {a},9 --from {b},9 --from {c},9"

# The program's words, and the same in Python.
RASTERS = [
    ("shadow --sun 225,20", lambda f, p: f.shadow(225, 20)),
    ("shadow --sun 225,30", lambda f, p: f.shadow()),
    ("shadow --sun 100,35 --hillshade", lambda f, p: f.shadow(100, 35, hillshade=True)),
    ("shadow --sun 300,15 --sun-disc", lambda f, p: f.shadow(300, 15, disc=True)),
    ("shadow --sun 0,8 --disc 1.5 --hillshade", lambda f, p: f.shadow(0, 8, disc=1.5, hillshade=True)),
    ("shadow --sun 100,1 --curvature 3000", lambda f, p: f.shadow(100, 1, curvature=3000)),
    ("shadow --time 2024-03-01T16:30:00+01:00 --sun-disc", lambda f, p: f.shadow(time="2024-03-01T15:30:00Z", disc=True)),
    ("sun --date 2024-03-20", needs_crs(lambda f, o: f.insolation("2024-03-20", **o))),
    ("sun --date 2024-03-20 --to 2024-03-22 --step 1h --directions 48 --curvature 500",
     needs_crs(lambda f, o: f.insolation("2024-03-20", "2024-03-22", step="1h", directions=48, curvature=500, **o))),
    ("sun --date 2024-03-20 --step 2h --irradiance", needs_crs(lambda f, o: f.insolation("2024-03-20", step=7200, irradiance=True, **o))),
    ("sun --date 2024-03-20 --step 2h --irradiance --linke 5 --sky 9",
     needs_crs(lambda f, o: f.insolation("2024-03-20", step="2h", irradiance=True, linke=5, sky=9, **o))),
    ("sun --suns suns.csv", lambda f, p: f.insolation(suns=SUNS)),
    ("sun --suns suns.csv --irradiance --directions 48 --curvature 500",
     lambda f, p: f.insolation(suns=SUNS, irradiance=True, directions=48, curvature=500)),
    ("horizon", lambda f, p: f.horizon()),
    ("horizon --directions 7 --start 11", lambda f, p: f.horizon(7, start=11)),
    ("horizon --directions 7 --max-distance {far}", lambda f, p: f.horizon(7, p.far)),
    ("horizon --directions 7 --curvature 2000", lambda f, p: f.horizon(7, curvature=2000)),
    ("horizon --directions 5 --distance --max-distance {far} --curvature 500",
     lambda f, p: f.horizon(5, p.far, curvature=500, distance=True)),
    ("horizon --svf", lambda f, p: f.sky_view()),
    ("horizon --directions 12 --svf-tilted", lambda f, p: f.sky_view(12, tilted=True)),
    ("horizon --directions 12 --svf --max-distance {far} --curvature 500", lambda f, p: f.sky_view(12, p.far, curvature=500)),
    ("horizon --directions 9 --openness", lambda f, p: f.openness(9)),
    ("horizon --directions 9 --start 7 --max-distance {far} --openness-negative",
     lambda f, p: f.openness(9, p.far, start=7, negative=True)),
    ("visibility", lambda f, p: f.visibility()),
    ("visibility --directions 9 --max-distance {far} --observer-height 1 --target-height 3 --curvature 0 --share",
     lambda f, p: f.visibility(9, p.far, observer_height=1, target_height=3, curvature=0, result="share")),
    ("visibility --directions 9 --longest", lambda f, p: np.stack([f.visibility(9, result=r) for r in ("longest", "azimuth")])),
    ("visibility --directions 9 --every 3", lambda f, p: f.visibility(9, every=3)),
    ("viewshed --from {a}", lambda f, p: f.viewshed(*p.spot(0))),
    ("viewshed --from {a},3 --target-height 1.5", lambda f, p: f.viewshed(*p.spot(0, 3), 1.5)),
    (f"viewshed {MANY} --curvature 1", lambda f, p: f.viewshed(p.xs, p.ys, 9, curvature=1)),
    (f"viewshed {MANY} --bands", lambda f, p: f.viewshed(p.xs, p.ys, 9, bands=True)),
    ("viewshed --from {a} --coarser 3", lambda f, p: f.coarser(3).viewshed(*p.spot(0))),
    *((f"shadow --sun 300,20 --coarser 3 --filter {name}", lambda f, p, name=name: f.coarser(3, name).shadow(300, 20)) for name in ("highest", "lowest")),
    (f"viewshed {MANY} --needed --bands", lambda f, p: f.viewshed(p.xs, p.ys, 9, needed=True, bands=True)),
    ("viewshed --from {a} --max-distance {far} --window=-1e9,-1e9,1e9,1e9", lambda f, p: f.viewshed(*p.spot(0), max_distance=p.far)),
    ("viewshed --from {a} --max-distance {far} --window=-1e9,-1e9,1e9,1e9 --needed",
     lambda f, p: f.viewshed(*p.spot(0), max_distance=p.far, needed=True)),
    ("viewshed --from {a} --angle", lambda f, p: f.viewshed(*p.spot(0), angle=True)),
    ("viewshed --from {a},6 --min-distance {near} --azimuth 350,120 --vertical -60,20",
     lambda f, p: f.viewshed(*p.spot(0, 6), min_distance=p.near, azimuth=(350, 120), vertical=(-60, 20))),
    (f"viewshed {MANY} --every {{near}}", lambda f, p: f.viewshed(p.xs, p.ys, 9, every=p.near)),
    ("viewshed --observers observers.csv --weights --every {near}", lambda f, p: f.viewshed(p.xs, p.ys, 9, weights=[0.3, 1.7, 0.1], every=p.near)),
    ("viewshed --observers observers.csv --weights", lambda f, p: f.viewshed(p.xs, p.ys, 9, weights=[0.3, 1.7, 0.1])),
]

def skipping(make):
    with pytest.warns(UserWarning, match="are skipped"):
        return make()


def links(f, p, **options):
    return f.line_of_sight([p.spot(0, 9), p.spot(1, 2)], [p.spot(1, 2), p.spot(2, 1)], **options)


SUN = "hours free_hours direct free_direct diffuse free_diffuse"

# Tables: the program's decimals, and numbers of Python in the same columns.
TABLES = [
    ("horizon --at {a} --directions 9 --start 5 --max-distance {far}",
     "angle distance x y", lambda f, p: f.horizon_at(*p.spot(0), directions=9, start=5, max_distance=p.far)),
    ("horizon --at {a},4 --at {b},4 --directions 5 --curvature 500",
     "angle distance x y true_azimuth", lambda f, p: f.horizon_at(p.xs[:2], p.ys[:2], 4, 5, curvature=500)),
    ("viewshed --observers observers.csv --max-distance {far} --window=-1e9,-1e9,1e9,1e9 --table table.csv",
     "samples km2 farthest farthest_x farthest_y", lambda f, p: f.sites(p.xs, p.ys, 9, max_distance=p.far)),
    ("viewshed --observers observers.csv --table table.csv --within area.csv", "samples km2 farthest farthest_x farthest_y",
     lambda f, p: f.sites(p.xs, p.ys, 9, within=p.inside(f))),
    ("viewshed --observers outside.csv --skip-outside --every {near} --table table.csv", "samples km2 farthest farthest_x farthest_y",
     lambda f, p: skipping(lambda: f.sites(*np.append(p.spot(0), p.beyond).reshape(2, 2).T, 9, every=p.near, skip_outside=True))),
    ("sun --at {a},3 --suns suns.csv --tilt 40 --facing 150 --max-distance {near}", "hours free_hours direct free_direct",
     lambda f, p: f.sun_days(*p.spot(0), height=3, suns=SUNS, tilt=40, facing=150, max_distance=p.near)),
    ("sun --at {a},3 --date 2024-03-20 --to 2024-03-22 --step 5min --tilt 40 --facing 150 --linke 4 --sky 9 --curvature 500 --max-distance 90", SUN,
     needs_crs(lambda f, o: f.sun_days(f.bounds[0] + 0.37 * (f.bounds[2] - f.bounds[0]), f.bounds[1] + 0.61 * (f.bounds[3] - f.bounds[1]),
                                       "2024-03-20", "2024-03-22", 3, step="5min", tilt=40, facing=150, linke=4, sky=9, curvature=500, max_distance=90,
                                       **o))),
    ("los --pairs pairs.csv", "visible distance blocked_distance blocked_x blocked_y blocked_height", links),
    ("los --pairs pairs.csv --frequency 2400 --curvature 0.75", "clearance clearance_distance fresnel_radius",
     lambda f, p: links(f, p, curvature=0.75, frequency=2400)),
    ("los {a},9 {b},2 --frequency 900 --profile table.csv", "distance x y ground line seen fresnel_radius",
     lambda f, p: f.profile(p.spot(0, 9), p.spot(1, 2), frequency=900)),
]


def columns_of(p, answer):
    """The numbers of an answer under the names of a table's columns: places in three, and nothing is seen at a hole."""
    out = {}
    for name, value in answer._asdict().items():
        names = [name[:-2] + end for end in ("x", "y", "height")] if name.endswith("at") else [name]
        for part, numbers in zip(names, np.moveaxis(np.asarray(value), -1, 0) if name.endswith("at") else [value]):
            out[part] = p.northward(numbers) if part.split("_")[-1] == "y" else numbers
    return {**out, "seen": np.where(np.isnan(out["ground"]), np.nan, out["seen"])} if "seen" in out else out


# What Python has in another way, or has no use for.
FILES = "arrays and DataArrays take the place of files"
EXCUSED = {
    "output": FILES, "cog": FILES, "co": FILES, "json": FILES, "layer": FILES,
    "quiet": "progress= is the only thing that is told", "help": "help(cellwalk)",
    "band": "cellwalk.open(band=)", "nodata": "cellwalk.open(nodata=)", "zscale": "cellwalk.open(zscale=)",
    "cellsize": "cellwalk.open(cellsize=)", "allow-network": "GDAL's own settings rule in Python (SECURITY.md)",
    "isa": "the variable CELLWALK_ISA, of which no bit depends", "coarser": "Field.coarser(factor)", "filter": "Field.coarser(filter=)",
    "threads": "Field(threads=)", "window": "results are arrays that are cut; cellwalk.open(window=) reads a part",
    "memory": "cellwalk.dask", "places": "arrays of places"}


def long_options(text):
    return set(re.findall(r"--([a-z][a-z-]+)", text))


def line_of(ground, p, text):
    """The words of the program, beside places, lines, suns, and land on one side of a line in files."""
    write("observers.csv", "x,y,height,weight\n" + "".join(f"{at},9,{w}\n" for at, w in zip(p.at, (0.3, 1.7, 0.1))))
    write("outside.csv", f"x,y,height\n{p.at[0]},9\n{p.beyond[0]!r},{p.northward(p.beyond[1])!r},9\n")
    write("suns.csv", "azimuth,altitude,weight\n" + "".join(f"{a},{h},{w}\n" for a, h, w in SUNS))
    write("pairs.csv", f"x1,y1,height1,x2,y2,height2\n{p.at[0]},9,{p.at[1]},2\n{p.at[1]},2,{p.at[2]},1\n")
    (ax, ay), (bx, by) = ((x, p.northward(y)) for x, y in p.side)
    dx, dy = 9 * (bx - ax), 9 * (by - ay)
    side = -1 if p.known else 1
    corners = [[ax - dx, ay - dy], [ax + dx, ay + dy], [ax + dx - side * dy, ay + dy + side * dx], [ax - dx - side * dy, ay - dy + side * dx]]
    write("area.csv", f'id,WKT\n1,"POLYGON (({", ".join(f"{x!r} {y!r}" for x, y in [*corners, corners[0]])}))"\n')
    name, *words = p.words(text)
    return name, ground.path, *words, *(("--lon-lat", "11,47") if name == "sun" and "--date" in words and not p.known else ())


@pytest.mark.parametrize("words, made", RASTERS, ids=[words for words, _ in RASTERS])
def test_rasters(ground, words, made):
    """And a part of each, by another instruction set and on threads."""
    p, out = Places(ground), "out" + ground.path.suffix
    if "--time" in words and not p.known:
        with pytest.raises(ValueError, match="^time: without a coordinate system"):
            made(ground.field, p)
        return
    line = line_of(ground, p, words)
    tool(*line, "-o", out)
    wanted = raster(out)
    assert len(np.unique(wanted[np.isfinite(wanted)])) > 1  # or anything would be the same
    same(made(ground.field, p), wanted)
    if ground.path.parent.name[:6] != "turned" and not re.search("--window|--coarser|visibility.*--every", words):
        part = np.s_[15:40, 20:60]
        assert run(*line, p.window(ground.field, part), "--threads", 3, "-o", out, isa=sets()[len(words) % 2 - 1]).status == 0
        same(raster(out), wanted[(..., *part)])


@pytest.mark.parametrize("words, columns, made", TABLES, ids=[words for words, *_ in TABLES])
def test_tables(ground, words, columns, made):
    p = Places(ground)
    line = line_of(ground, p, words)
    printed = tool(*line, *(("-o", "seen.npy") if line[0] == "viewshed" else ()))
    if "table.csv" in line:
        printed = open("table.csv").read()
    rows, got = list(csv.DictReader(printed.splitlines())), columns_of(p, made(ground.field, p))
    assert rows
    for name in columns.split():
        numbers = np.ravel(got[name]).astype(float)
        assert len(numbers) == len(rows)
        for row, number in zip(rows, numbers.tolist()):
            text = row[name]
            digits = len(text.partition(".")[2])
            close = abs(number - float(text or "nan")) <= 0.500001 * 10.0 ** -digits + 1e-9 * abs(number)
            assert close if text else np.isnan(number), (name, text, number)


def test_every_other_sample(ground):
    same(ground.field.visibility(8, every=3), np.asarray(ground.field.visibility(8))[::3, ::3])


def test_views_are_counted(ground):
    """Sums and bands of several observers, and what each sees, from views of one; the plain ground has cells of one metre."""
    f, p = ground.field, Places(ground)
    alone = np.stack([f.viewshed(*p.spot(k, 9)) for k in range(3)])
    same(f.viewshed(p.xs, p.ys, 9, bands=True), alone)
    total = np.where(np.isnan(f.z), np.nan, np.tensordot([0.5, -3, 1e6], alone == 1, 1)).astype(np.float32)
    same(f.viewshed(p.xs, p.ys, 9, weights=[0.5, -3, 1e6]), total)
    sites, (j, i) = f.sites(p.xs, p.ys, 9), np.mgrid[:f.shape[0], :f.shape[1]]
    assert (sites.samples == (alone == 1).sum((1, 2))).all()
    if not p.known:
        far = [np.hypot(i - x, j - y)[seen == 1].max() for x, y, seen in zip(p.xs, p.ys, alone)]
        assert np.allclose(sites.km2, sites.samples * 1e-6) and np.allclose(sites.farthest, far)
        assert np.allclose(np.hypot(*(sites.farthest_at - np.column_stack([p.xs, p.ys])).T), far)


def test_openness():
    """Of a slope, a pyramid, a pit and a cone; elsewhere the mean of horizons, and of the land upside down."""
    y, x = np.mgrid[-40.0:41, -40:41]
    far, slope = np.maximum(abs(x), abs(y)), np.degrees(np.arctan(1.5))
    for z, directions, wanted, off in ((1.5 * x + 2 * y, 4, 90, 1e-4), (-1.5 * far, 4, 90 + slope, 1e-4), (1.5 * far, 4, 90 - slope, 1e-4),
                                       (-1.5 * np.hypot(x, y), 64, 90 + slope, 0.03)):
        z[3, 5:9] = np.nan
        f, under = (cw.Field(form, transform=(1, 0, 0, 0, -1, 0)) for form in (z, -z))
        assert f.openness(directions)[40, 40] == pytest.approx(wanted, abs=off)
        for distance in (None, 7):
            angles = f.horizon(16, distance, start=3)
            np.testing.assert_allclose(f.openness(16, distance, start=3), np.nanmean(np.where(np.isnan(f.z), 0, 90.0 - angles), 0) + 0 * f.z, atol=2e-5)
            same(f.openness(16, distance, negative=True), under.openness(16, distance))


def test_sun_days_are_those_of_the_raster(ground, monkeypatch):
    """At samples, for the sun over the raster's middle."""
    f = ground.field
    known = ground.path.suffix != ".npy"
    middle = f._locate("date")[:2] if known else (11, 47)
    if ground.path.parent.name.startswith(("turned", "utm", "mercator")):
        middle = None  # the map's north counts too, and the sun stands over the place: the same but for a step
    elif known:
        monkeypatch.setattr(f, "_locate", lambda *_: (*middle, 0.0))
    place = None if known else middle
    if known:
        assert "--lon-lat is for files" in tool("sun", ground.path, "--date", "2024-03-20", "--lon-lat", "11,47", "-o", "o.npy", fails=True)
    hours = f.insolation("2024-03-20", "2024-03-21", step="5min", lon_lat=place)
    energy = f.insolation("2024-03-20", "2024-03-21", step="5min", irradiance=True, lon_lat=place)
    for i, j in ((20, 30), (41, 9), (60, 50)):
        x, y = f.map[:2] @ (i, j, 0, 1)
        d = f.sun_days(x, y, "2024-03-20", "2024-03-21", step="5min", tilt="ground", lon_lat=place)
        assert d.hours.sum() == pytest.approx(hours[j, i], abs=1e-4 if middle else 0.2)
        assert d.direct.sum() == pytest.approx(energy[0, j, i], rel=2e-5 if middle else 0.02, abs=1e-2 if middle else 20)
        assert d.diffuse.sum() == pytest.approx(energy[1, j, i], rel=2e-5 if middle else 0.01)


def test_needed_heights_are_absolute_too(ground):
    """Just above that height a target is in sight, just below it is not."""
    f = ground.field
    x, y = f.map[:2] @ (20, 30, 0, 1)
    heights = f.viewshed(x, y, 2, needed="absolute")
    for j, i in np.argwhere(f.viewshed(x, y, 2, needed=True) > 1)[::1000]:
        for more, visible in (0.05, True), (-0.05, False):
            to = (*f.map[:2] @ (i, j, 0, 1), float(heights[j, i]) + more)
            assert f.line_of_sight((x, y, 2), to, absolute=(False, True)).visible == visible


def test_suns_at_one_place_are_those_of_the_raster(ground):
    """Of which that is a sample. Below the level nothing shines."""
    f, (i, j) = ground.field, (20, 30)
    d, light = f.sun_days(*f.map[:2] @ (i, j, 0, 1), suns=SUNS, tilt="ground"), f.insolation(suns=SUNS, irradiance=True)
    total = sum(weight * (f.shadow(azimuth, altitude)[j, i] == 1) for azimuth, altitude, weight in SUNS if altitude > 0)
    assert d.hours[0] == total == f.insolation(suns=SUNS)[j, i] and d.direct[0] == pytest.approx(light[j, i], rel=1e-4)
    assert d.free_hours[0] == sum(weight for _, altitude, weight in SUNS if altitude > 0) and np.isnat(d.day[0])
    same(f.insolation(suns=np.array(SUNS)[:, :2]), f.insolation(suns=[(a, h, 1) for a, h, _ in SUNS]))


def test_months_of_sun():
    """Sums of days in a pit, each rounded to hundredths of hours and whole watt hours, whose mean rise is the month's; and a pit in which nothing rises."""
    np.save("z.npy", np.pad(np.zeros((5, 5), np.float32), 3, constant_values=0.5))
    words = "sun", "z.npy", "--lon-lat", "10,50", "--at", "5,5", "--step", "1h", "--tilt", "ground"
    months, days = (list(csv.DictReader(tool(*words, "--date", date).splitlines())) for date in ("2024", "2024-02"))
    assert [row["month"] for row in months] == [f"2024-{k:02}" for k in range(1, 13)] and len(days) == 29
    for name in SUN.split():
        assert float(months[1][name]) == pytest.approx(sum(float(row[name]) for row in days), abs=0.15 if "hours" in name else 15)
    assert float(months[11]["hours"]) < float(months[11]["free_hours"])
    rises = [np.datetime64(row["rise"][:-1]) for row in days]
    mean = rises[0] + np.mean([rise - day for rise, day in zip(rises, rises[0] + np.arange(29) * np.timedelta64(1, "D"))])
    assert abs(mean - np.datetime64(f"2024-02-01T{months[1]['rise'][:-1]}")) <= np.timedelta64(1, "m")
    night = cw.Field(np.pad(np.zeros((3, 3), "float32"), 1, constant_values=1000)).sun_days(2, 2, "2024-02-10", lon_lat=(0, 50), step="1h")
    assert night.hours == 0 and np.isnat(night.rise) and np.isnat(night.set) and night.free_direct > 0


# ---- large rasters ----------------------------------------------------------------------------------------------------------


WIDE = 10, 0, 300000, 0, -10, 5900000


@pytest.fixture(scope="module")
def strip(tmp_path_factory):
    """Longer than a piece of a line (line.h), with holes."""
    random = np.random.default_rng(7)
    z = np.cumsum(random.normal(0, 3, (40, 5000)), 1).astype(np.float32)
    z[18:25, 3000:3008] = np.nan
    return geotiff(tmp_path_factory.mktemp("strip") / "strip.tif", z, transform=WIDE, tiled=True)


@pytest.mark.parametrize("row, other, height", [(3, 3, 200), (2.4, 37.7, 500), (39, 0, 5), (20, 21, 60)])
def test_lines_read_in_pieces(strip, row, other, height):
    field, table = cw.open(strip), "profile.csv"
    ends = [(*(field.map[:2] @ place).tolist(), height) for place in ((1, row, 0, 1), (4998, other, 0, 1))]
    for a, b in (ends, ends[::-1]):
        words = [",".join(map(repr, place)) for place in (a, b)]
        said = json.loads(tool("los", strip, *words, "--frequency", "100", "--json", "--profile", table))
        s, p = field.line_of_sight(a, b, frequency=100), field.profile(a, b, frequency=100)
        assert said["visible"] == bool(s.visible) and said["clearance"] == pytest.approx(float(s.clearance), rel=1e-8)
        if not s.visible:
            np.testing.assert_allclose([*said["blocked_at"], said["blocked_height"]], s.blocked_at, rtol=1e-9)
        rows, wanted = list(csv.DictReader(open(table))), {**p._asdict(), "seen": np.where(np.isnan(p.ground), np.nan, p.seen)}
        assert len(rows) == len(p.distance) > 4900
        for name in ("distance", "ground", "line", "seen"):
            np.testing.assert_allclose(np.array([float(row[name] or "nan") for row in rows]), wanted[name].astype(float), atol=0.000501)


@pytest.mark.parametrize("words", [
    ["los", "300105,5899895,4000", "899905,5300105,4000", "--frequency", "400"], ["los", "300105,5899895,40", "899905,5300105,40"],
    ["horizon", "--at", "600000,5600000,10", "--max-distance", "20000"], ["info"],
    ["sun", "--at", "600000,5600000,10", "--max-distance", "20000", "--date", "2024-06-21"],
])
def test_little_is_read_of_a_large_raster(words):
    """60 000 x 60 000 samples are 14.4 GB; less than 300 MB may be held."""
    path = geotiff("large.tif", (60000, 60000), transform=WIDE, tiled=True, SPARSE_OK=True, BIGTIFF="YES", blockxsize=256, blockysize=256)
    code = ("import resource, subprocess, sys; status = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode; "
            "print(status, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
    done = subprocess.run([sys.executable, "-c", code, os.environ["CELLWALK_PROGRAM"], words[0], path, *words[1:]], capture_output=True, text=True)
    status, kilobytes = map(int, done.stdout.split())
    assert status == 0 and kilobytes < 300000, done.stderr


def test_observers_without_ground_are_skipped(ground):
    p, f = Places(ground), ground.field
    hole = f.map[:2] @ (23, 11, 0, 1)
    xs, ys = np.array([p.xs[0], hole[0], p.xs[1], f.bounds[2] + 9 * abs(f.map[0, 0])]), np.array([p.ys[0], hole[1], p.ys[1], p.ys[0]])
    write("towers.csv", "x,y,height\n" + "".join(f"{x!r},{p.northward(y)!r},9\n" for x, y in zip(xs.tolist(), ys.tolist())))
    words = "viewshed", ground.path, "--observers", "towers.csv", "--table", "table.csv", "-o", "seen.npy"
    assert re.search("towers.csv:[35]", tool(*words, fails=True))
    done = run(*words, "--skip-outside")
    said = [line for line in done.err.splitlines() if "skipped" in line]
    assert done.status == 0 and len(said) == 3 and "2 of 4 observers are skipped" in said[-1] and all(f"towers.csv:{k}" in done.err for k in (3, 5))
    assert "table.csv: views from 2 places, " in done.outcome and [row["observer"] for row in csv.DictReader(open("table.csv"))] == ["1", "3"]
    with pytest.warns(UserWarning, match="x, y: 2 of 4 observers .* skipped: 1, 3"):
        same(f.viewshed(xs, ys, 9, skip_outside=True), np.load("seen.npy"))
    same(f.viewshed(p.xs[:2], p.ys[:2], 9), np.load("seen.npy"))


def test_every_option_is_compared_or_excused():
    cases = {}
    for words, *_ in RASTERS + TABLES:
        cases.setdefault(words.split()[0], set()).update(long_options(words))
    cases["sun"].add("lon-lat")
    assert commands() - set(cases) == {"render", "trace", "info"}  # pictures; Field.closest (test_rays.py); Field has what info prints
    for command, compared in cases.items():
        named = long_options(" ".join(re.findall(r"^ +(?:-\w, )?(--[a-z-]+)", tool(command, "--help"), re.M)))
        assert len(named) > 10
        assert named - compared - set(EXCUSED) == set(), f"{command}: neither compared with Python nor excused"
        assert compared <= named
    assert set(EXCUSED) & set.union(*cases.values()) <= {"window", "coarser", "filter"}
