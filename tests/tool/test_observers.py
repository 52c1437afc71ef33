# SPDX-License-Identifier: Apache-2.0
"""Observers of a viewshed from tables, files of features and along lines, and what is written of them."""
import json
import os

import numpy as np
import pytest
from program import asc, interrupted, needs, on_map, read, refused, run, taken, vrt, write

NX, NY = 60, 50
ROWS, COLUMNS = np.mgrid[:NY, :NX]
UTM, DEGREES = on_map(32632, 500000, 10, 0, 5200500, 0, -10), on_map(4326, 9, 0.00013, 0, 46.95, 0, -0.00009)
PLACES = "100,100,3", "250.5,321.25,2", "400,20,=90"
TABLE = "x,y,height\n100,100,3\n250.5,321.25,2\n400,20,=90\n"


@pytest.fixture(autouse=True)
def land(folder):
    """Hills with a hole; on a map in metres of UTM, and on one in degrees."""
    z = np.rint(8 * (30 + 20 * np.sin(COLUMNS / 6) * np.cos(ROWS / 5) + 3 * np.sin(COLUMNS + 2 * ROWS))) / 8
    z[7, 9] = np.nan
    np.save("land.npy", z.astype(np.float32))
    asc("land.asc", z, 500000, 5200000)
    vrt("utm.vrt", "land.asc", z.shape, UTM)
    vrt("degrees.vrt", "land.asc", z.shape, DEGREES)


def view(dem, *words, says=None):
    """Messages must be those words, or none."""
    done = run("viewshed", dem, *words, *(("--cellsize", 10) if dem.endswith(".npy") else ()), "-o", "v.npy")
    assert done.status == 0 and (says in done.err if says else done.err == ""), done.err
    return np.load("v.npy")


def same(dem, one, other, says=None):
    a, b = view(dem, *one), view(dem, *other, says=says)
    assert a.dtype == b.dtype and a.tobytes() == b.tobytes(), other


def from_each(*places):
    return [word for place in places for word in ("--from", place)]


# ---- tables ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text, says", [
    (TABLE, None),
    ("x,y,height\n100,100,3\n250.5,321.25,\n400,20,=90", None),
    ("\ufeffX,Y,Height\r\n100,100,3\r\n250.5,321.25,2\r\n400,20,=90\r\n", None),
    ('\n"height" , "y",\tx\n3,100,100\n\n 2.0 , 3.2125e2 ,"250.5"\n"=90",20,400\n  \n', None),
    ('label,x,y,height\n"a, ""b""\nc",100,100,3\nd,250.5,321.25,2\n,400,20,=90\n',
     "t.csv: passed over: 'label'; columns with a meaning are x, y, height, weight and name")])
def test_the_same_places_whatever_the_table_looks_like(text, says):
    write("t.csv", text)
    same("land.npy", from_each("100,100,3", "250.5,321.25", "400,20,=90"), ["--observers", "t.csv"], says)


def test_a_table_of_views():
    """A line for each observer, by the samples of its own view; the raster is the same as without a table. Row 0 of an array lies in the
    north, so sample (i, j) is at (10 i, 490 - 10 j)."""
    write("t.csv", TABLE)
    same("land.npy", ["--observers", "t.csv"], ["--observers", "t.csv", "--table", "seen.csv"])
    head, *lines = read("seen.csv").decode().splitlines()
    assert head == "observer,x,y,samples,km2,farthest,farthest_x,farthest_y" and len(lines) == 3
    for k, (place, line) in enumerate(zip(PLACES, lines), 1):
        seen = view("land.npy", "--from", place) == 1
        x, y = map(float, place.split(",")[:2])
        far = np.hypot(10 * COLUMNS - x, 490 - 10 * ROWS - y)[seen].max()
        number, at_x, at_y, samples, km2, farthest, far_x, far_y = map(float, line.split(","))
        assert (number, at_x, at_y, samples) == (k, x, y, seen.sum()) and abs(km2 - 1e-4 * seen.sum()) < 1e-9
        assert abs(farthest - far) < 1e-3 and abs(np.hypot(far_x - x, far_y - y) - far) < 1e-3
    refused(2, "--table lists what is seen", "viewshed", "land.npy", "--cellsize", 10, "--observers", "t.csv", "--table", "no.csv", "--bands",
            "-o", "o.npy")


def test_weights_and_bands():
    write("t.csv", "x,y,height,weight\n100,100,3,0.5\n250.5,321.25,2,-3\n400,20,=90,1e6\n")
    for option in "--threads=2", "--angle", "--needed":
        bands = view("land.npy", "--observers", "t.csv", "--bands", option)
        alone = np.stack([view("land.npy", "--from", place, option) for place in PLACES])
        assert bands.dtype == alone.dtype and bands.tobytes() == alone.tobytes(), option
        if option == "--threads=2":
            wanted = np.tensordot([0.5, -3, 1e6], alone == 1, 1).astype(np.float32)
    sums = view("land.npy", "--observers", "t.csv", "--weights")
    wanted[7, 9] = np.nan
    assert sums.dtype == np.float32 and np.array_equal(sums, wanted, equal_nan=True)
    # Sums of 8 bytes a sample count against the memory: with 4 bytes of samples, 36 kB of 150, of which a quarter may be used.
    words = "viewshed", "land.npy", "--cellsize", 10, "--observers", "t.csv"
    refused(1, "60 x 50 samples matter at once, which need --memory 1M", *words, "--weights", "--memory", "100K", "-o", "o.npy")
    same("land.npy", ["--observers", "t.csv", "--weights"], ["--observers", "t.csv", "--weights", "--memory", "150K"])
    same("land.npy", ["--observers", "t.csv"], ["--observers", "t.csv", "--memory", "100K"])


def test_along_a_line():
    """500 m in two legs: an observer each 50 m, with heights and weights between those of corners."""
    write("line.csv", "x,y,height,weight\n100,100,2,1\n400,100,8,4\n400,300,4,0\n")
    along = [(min(100 + 50 * k, 400), max(100, 50 * k - 200), 2 + k if k <= 6 else 14 - k, 1 + 0.5 * k if k <= 6 else 10 - k) for k in range(11)]
    write("places.csv", "x,y,height,weight\n" + "".join("%g,%g,%g,%g\n" % place for place in along))
    same("land.npy", ["--observers", "places.csv"], ["--observers", "line.csv", "--every", 50])
    same("land.npy", ["--observers", "places.csv", "--weights"], ["--observers", "line.csv", "--every", 50, "--weights"])
    same("land.npy", ["--observers", "places.csv"], [*from_each("100,100", "400,100,8", "400,300,4"), "--every", 50])
    # The last 20 m are less than a step, and a step longer than the line leaves its beginning.
    line = from_each("100,100", "300,100")
    same("land.npy", from_each("100,100", "160,100", "220,100", "280,100"), [*line, "--every", 60])
    same("land.npy", ["--from", "100,100"], [*line, "--every", 1000])


def test_any_number():
    """All see all of level ground: counts are of two bytes, and from 65 535 observers on floats."""
    np.save("level.npy", np.zeros((12, 12), np.float32))
    for number, kind in taken([(10000, np.uint16), (65535, np.float32)], 2):
        k = np.arange(number)
        x, y = k % 7, k // 7 % 12
        write("many.csv", "x,y\n" + "".join(f"{10 * a},{10 * b}\n" for a, b in zip(x, y)))
        # In a sector of no width, so that most parts of a sweep are left out: the column to the north.
        got = view("level.npy", "--observers", "many.csv", "--azimuth", "0,0")
        wanted = np.zeros((12, 12))
        np.add.at(wanted, (11 - y, x), 1)
        wanted = np.cumsum(wanted[::-1], 0)[::-1]
        assert got.dtype == kind and (got == wanted).all()


# ---- on maps --------------------------------------------------------------------------------------------------------------


def feature(kind, places, **properties):
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": places}}


def geojson(name, *features, crs="EPSG::32632"):
    write(name, json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": f"urn:ogc:def:crs:{crs}"}},
                            "features": features}))


LINE = [[500100, 5200100], [500400, 5200100]]


def test_features():
    needs("GDAL")
    geojson("p.geojson", feature("Point", LINE[0], height=3, weight=2.5),
            feature("MultiPoint", [[500250.5, 5200321.25], [500400, 5200020]], height=None, weight=1))
    write("p.csv", "x,y,height,weight\n500100,5200100,3,2.5\n500250.5,5200321.25,,1\n500400,5200020,,1\n")
    same("utm.vrt", ["--observers", "p.csv", "--weights"], ["--observers", "p.geojson", "--weights"])
    geojson("q.geojson", feature("Point", [9.004, 46.9498]), crs="OGC:1.3:CRS84")
    same("degrees.vrt", ["--observers", "q.geojson"], ["--from", "9.004,46.9498"])
    # The middle of zone 32 is 9 degrees east: 500 000 m, beside the first column of samples.
    geojson("q.geojson", feature("Point", [9, 46.9535]), crs="OGC:1.3:CRS84")
    refused(1, "q.geojson: feature 0: 500000,", "viewshed", "utm.vrt", "--observers", "q.geojson", "-o", "o.npy")
    geojson("l.geojson", feature("LineString", LINE, height=4),
            feature("MultiLineString", [[[500200, 5200300], [500200, 5200360]], [[500300, 5200300], [500300, 5200340]]], height=6))
    # 95 m of ground are 0.9996 times as much on the map, in the middle of UTM's zone.
    write("l.csv", "x,y,height\n500100,5200100,4\n500194.962,5200100,4\n500289.924,5200100,4\n500384.886,5200100,4\n500200,5200300,6\n500300,5200300,6\n")
    same("utm.vrt", ["--observers", "l.csv"], ["--observers", "l.geojson", "--every", 95])


def test_polygons():
    """Only samples in them count in the table, and the raster is that without them. A triangle and a square with a hole."""
    needs("GDAL")
    square, hole = ([[500000 + x, 5200000 + y] for x, y in ((a, a), (b, a), (b, b), (a, b), (a, a))] for a, b in ((303, 447), (341, 399)))
    triangle = [[500102, 5200103], [500298, 5200107], [500201, 5200388], [500102, 5200103]]
    geojson("a.geojson", feature("Polygon", [triangle]), feature("MultiPolygon", [[square, hole]]))
    write("t.csv", "x,y,height\n500100,5200100,9\n500250.5,5200321.25,30\n")
    x, y = 500005 + 10 * COLUMNS, 5200495 - 10 * ROWS

    def inside(corners):
        return np.all([(bx - ax) * (y - ay) > (by - ay) * (x - ax) for (ax, ay), (bx, by) in zip(corners, corners[1:])], 0)
    wanted = inside(triangle) | inside(square) & ~inside(hole)
    words = "--observers", "t.csv", "--table", "s.csv", "--within", "a.geojson"
    same("utm.vrt", words[:2], words)
    bands = view("utm.vrt", *words[:2], "--bands")

    def around(far):
        return feature("Polygon", [[[a, b] for a, b in ((-far, -far), (far, -far), (far, far), (-far, far), (-far, -far))]])
    geojson("all.geojson", around(1e9))
    geojson("far.geojson", feature("Polygon", [[[9, 40], [9.1, 40], [9, 40.1], [9, 40]]]), crs="OGC:1.3:CRS84")
    part = wanted & (x > 500100) & (x < 500250) & (y > 5200200) & (y < 5200390)
    for file, samples, says, more in (("a.geojson", wanted, None, ()), ("a.geojson", part, None, ("--window", "500100,5200200,500250,5200390")),
                                      ("all.geojson", x > 0, None, ()), ("far.geojson", x < 0, "far.geojson: no sample that is looked at lies inside", ())):
        view("utm.vrt", *words[:5], file, *more, says=says)
        assert [int(line.split(",")[3]) for line in read("s.csv").decode().splitlines()[1:]] == [(samples & (band == 1)).sum() for band in bands]
    assert min((wanted & (band == 1)).sum() for band in bands) > 9
    for features, why in [([feature("Point", LINE[0])], "feature 0: is a POINT, no polygon"), ([feature("LineString", LINE)], "feature 0: is a LINESTRING, no polygon"),
                          ([], "holds no polygons"), *(([around(far)], "feature 0: reaches too far away from the terrain") for far in (1e12, 1e300))]:
        geojson("w.geojson", *features)
        refused(1, f"w.geojson: {why}", "viewshed", "utm.vrt", *words[:5], "w.geojson", "-o", "o.npy")
    refused(1, "t.csv: holds no polygons", "viewshed", "utm.vrt", *words[:5], "t.csv", "-o", "o.npy")
    refused(1, "none.gpkg: ", "viewshed", "utm.vrt", *words[:5], "none.gpkg", "-o", "o.npy")


def test_features_that_are_refused():
    needs("GDAL")
    point = feature("Point", LINE[0])
    for features, more, why in taken([
            ([feature("LineString", LINE)], (), "holds lines, and --every D"),
            ([feature("Polygon", [[*LINE, [500400, 5200400], LINE[0]]])], (), "feature 0: is a POLYGON, neither points nor a line"),
            ([point, feature("LineString", LINE)], ("--every", 9), "has points and lines"),
            ([feature("Point", LINE[0], height="high")], (), "feature 0: 'high' stands where a number should, in height"),
            ([feature("Point", [500100, 5200900])], (), "feature 0: 500100,5200900,2: lies outside"),
            ([], (), "holds no places"), ([point], ("--layer", "other"), "has no layer 'other'; there are w"),
            ([point], ("--weights",), "has no column 'weight'")], 3):
        geojson("w.geojson", *features)
        refused(1, f"w.geojson: {why}", "viewshed", "utm.vrt", "--observers", "w.geojson", *more, "-o", "o.npy")
    # Doors: no network, no waiting for a pipe, no input overwritten.
    os.mkfifo("pipe.geojson", 0o600)
    for name, why in [("http://127.0.0.1:9/a.geojson", "--allow-network"), ("WFS:http://127.0.0.1:9/a", "--allow-network"),
                      ("pipe.geojson", "not a regular file")]:
        refused(1, why, "viewshed", "utm.vrt", "--observers", name, "-o", "o.npy")


# ---- refusals -------------------------------------------------------------------------------------------------------------

LAND = "viewshed", "land.npy", "--cellsize", 10


@pytest.mark.parametrize("text, why", [
    ("", "t.csv: is empty; its first line should name the columns"),
    ("x,y\n", "t.csv: holds no places"),
    ("a,y\n1,2\n", "t.csv: has no column 'x'; its first line names a, y"),
    ("100,200\n1,2\n", "t.csv: has no column 'x'; its first line names 100, 200"),
    ("x,y\n100,100\n100,two\n", "t.csv:3: 'two' stands where a number should, in y"),
    ("x,y\n0x10,100\n", "t.csv:2: '0x10' stands where a number should, in x"),
    ("x,y\nnan,100\n", "t.csv:2: 'nan' stands where a number should, in x"),
    ("x,y\n,100\n", "t.csv:2: x is empty where a number should stand"),
    ("x,y,height\n100,100,=\n", "t.csv:2: '=' stands where a height, as 2 or =1250, should, in height"),
    ("x,y,weight\n100,100,heavy\n", "t.csv:2: 'heavy' stands where a number should, in weight"),
    ("x,y\r\n100,100\r\n\r\n700,100\r\n", "t.csv:4: 700,100,2: lies outside"),
    ("x;y\n100;100\n", "t.csv:1: cells are separated by semicolons; a comma should stand between them"),
    ("x,y\n1e300,1\n", "t.csv:2: 1e+300,1,2: is too far away"),
    ("x,y,height\n100,100,=-500\n", "t.csv:2: 100,100,=-500: is under the ground"),
    (b"\xff\xfex", "t.csv: has no column 'x'"),
    (None, "t.csv: cannot read: No such file")])
def test_tables_that_are_refused(text, why):
    if text is not None:
        write("t.csv", text)
    refused(1, why, *LAND, "--observers", "t.csv", "-o", "o.npy")


FILE = "--observers", "t.csv"


@pytest.mark.parametrize("status, why, words", [
    (2, "do not go together", (*FILE, "--from", "1,2")),
    (2, "--layer goes with --observers", ("--layer", "a", "--from", "1,2")),
    (2, "takes two places or more", ("--from", "1,2", "--every", 5)),
    (2, "--every takes metres above 0, not -5", (*FILE, "--every", -5)),
    (1, "more than 16777216 observers", (*FILE, "--every", 1e-9)),
    (1, "9,2,=400: heights along a line are all above", (*from_each("1,2", "9,2,=400"), "--every", 5)),
    (2, "--within goes with --table", (*FILE, "--within", "a.gpkg")),
    (2, "--weights goes with --observers", ("--from", "1,2", "--weights")),
    (1, "t.csv: has no column 'weight'", (*FILE, "--weights")),
    (2, "keeps them apart", (*FILE, "--weights", "--bands")),
    (2, "one can be written", (*FILE, "--weights", "--angle")),
    (1, "is that of one observer, not of 2; --bands", (*FILE, "--angle")),
    (2, "is that of one observer, not of 2; --bands", (*from_each("1,2", "9,2"), "--needed")),
    (1, "a table has no layers", (*FILE, "--layer", "a")),
    (2, "--azimuth takes two angles", ("--from", "1,2", "--azimuth", 1)),
    (2, "--azimuth takes two angles", ("--from", "1,2", "--azimuth", "1,400")),
    (2, "the lower one first, not '5,-5'", ("--from", "1,2", "--vertical", "5,-5")),
    (2, "--vertical takes two angles", ("--from", "1,2", "--vertical", "-91,0")),
    (2, "--needed looks for that height", ("--from", "1,2", "--vertical", "-9,0", "--needed")),
    (2, "--min-distance takes metres, not -1", ("--from", "1,2", "--min-distance", -1)),
    (2, "--min-distance 9 is more than", ("--from", "1,2", "--min-distance", 9, "--max-distance=5")),
    (1, "t.npy: is also an input", (*FILE, "-o", "t.npy")),
    (1, "no room for 2 bands", (*FILE, "--bands", "-o", "o.png"))])
def test_refusals(status, why, words):
    write("t.csv", "x,y\n100,100\n200,100\n")
    os.link("t.csv", "t.npy")
    refused(status, why, *LAND, "-o", "o.npy", *words)


@pytest.mark.parametrize("bands", [(), ("--bands",)])
def test_interruptions(bands):
    write("t.csv", "x,y\n100,100\n400,100\n")
    interrupted(*LAND, *FILE, "--every", 0.005, "-o", "o.npy", *bands, input="land.npy", writes=bool(bands))
