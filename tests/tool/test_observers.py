# SPDX-License-Identifier: Apache-2.0
"""Observers of a viewshed from tables, files of features and along lines; ../python/test_products.py has what is counted and written of them."""
import numpy as np
import pytest
from program import asc, feature, geojson, needs, on_map, read, refused, run, taken, vrt, write

NX, NY = 60, 50
ROWS, COLUMNS = np.mgrid[:NY, :NX]
UTM, DEGREES = on_map(32632, 500000, 10, 0, 5200500, 0, -10), on_map(4326, 9, 0.00013, 0, 46.95, 0, -0.00009)


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


@pytest.mark.parametrize("text, says", [
    ("x,y,height\n100,100,3\n250.5,321.25,\n400,20,=90", None),
    ('label,"height" , "Y",\tx\n"a, ""b""\nc",3,100,100\n\nd, 2.0 , 3.2125e2 ,"250.5"\n,"=90",20,400\n  \n',
     "t.csv: passed over: 'label'; columns with a meaning are x, y, height, weight and name")])
def test_the_same_places_whatever_the_table_looks_like(text, says):
    write("t.csv", text)
    same("land.npy", from_each("100,100,3", "250.5,321.25", "400,20,=90"), ["--observers", "t.csv"], says)


def test_memory_for_sums():
    """Sums of 8 bytes a sample count against the memory: with 4 bytes of samples, 36 kB of 150, of which a quarter may be used."""
    write("t.csv", "x,y,height,weight\n100,100,3,0.5\n250.5,321.25,2,-3\n400,20,=90,1e6\n")
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
    """All see all of level ground: counts are of one byte, above 254 observers of two, and from 65 535 on floats."""
    np.save("level.npy", np.zeros((12, 12), np.float32))
    for number, kind in taken([(254, np.uint8), (10000, np.uint16), (65535, np.float32)], 2):
        k = np.arange(number)
        x, y = k % 7, k // 7 % 12
        write("many.csv", "x,y\n" + "".join(f"{10 * a},{10 * b}\n" for a, b in zip(x, y)))
        # In a sector of no width, so that most parts of a sweep are left out: the column to the north.
        got = view("level.npy", "--observers", "many.csv", "--azimuth", "0,0", says="0,0 is a single direction")
        wanted = np.zeros((12, 12))
        np.add.at(wanted, (11 - y, x), 1)
        wanted = np.cumsum(wanted[::-1], 0)[::-1]
        assert got.dtype == kind and (got == wanted).all()


# ---- on maps --------------------------------------------------------------------------------------------------------------


LINE = [[500100, 5200100], [500400, 5200100]]


def test_features():
    needs("GDAL")
    geojson("p.geojson", feature("Point", LINE[0], height=3, weight=2.5),
            feature("MultiPoint", [[500250.5, 5200321.25], [500400, 5200020]], height=None, weight=1))
    write("p.csv", "x,y,height,weight\n500100,5200100,3,2.5\n500250.5,5200321.25,,1\n500400,5200020,,1\n")
    same("utm.vrt", ["--observers", "p.csv", "--weights"], ["--observers", "p.geojson", "--weights"])
    geojson("q.geojson", feature("Point", [9.004, 46.9498]), crs="OGC:1.3:CRS84")
    same("degrees.vrt", ["--observers", "q.geojson"], ["--from", "9.004,46.9498"])
    # Longitudes may count from elsewhere.
    vrt("round.vrt", "land.asc", ROWS.shape, on_map(4326, 369, 0.00013, 0, 46.95, 0, -0.00009))
    geojson("r.geojson", feature("Polygon", [[[9.002, 46.946], [9.007, 46.946], [9.004, 46.951], [9.002, 46.946]]]), crs="OGC:1.3:CRS84")
    seen, counts = view("degrees.vrt", "--observers", "q.geojson"), set()
    for dem, place in (("degrees.vrt", "369.004,46.9498"), ("round.vrt", "9.004,46.9498"), ("round.vrt", "-350.996,46.9498")):
        assert (view(dem, "--from", place) == seen).all() and (view(dem, "--observers", "q.geojson", "--table", "s.csv", "--within", "r.geojson") == seen).all()
        counts.add(int(read("s.csv").split(b",")[10]))
    assert len(counts) == 1 and 9 < counts.pop() < (seen == 1).sum()
    refused(1, "is too far away", "viewshed", "round.vrt", "--from", "36009.004,46.9498", "-o", "o.npy")
    refused(1, "with X 360 degrees away it would not", "los", "round.vrt", "9.004,46.9498", "369.003,46.949")
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
    words = "--observers", "t.csv", "--table", "s.csv", "--within"
    same("utm.vrt", words[:2], (*words, "a.geojson"))
    bands = view("utm.vrt", *words[:2], "--bands")
    assert min((wanted & (band == 1)).sum() for band in bands) > 9

    def around(far):
        return feature("Polygon", [[[a, b] for a, b in ((-far, -far), (far, -far), (far, far), (-far, far), (-far, -far))]])
    geojson("all.geojson", around(1e9))
    geojson("far.geojson", feature("Polygon", [[[9, 40], [9.1, 40], [9, 40.1], [9, 40]]]), crs="OGC:1.3:CRS84")
    part = wanted & (x > 500100) & (x < 500250) & (y > 5200200) & (y < 5200390)
    for samples, says, *more in ((wanted, None, "a.geojson"), (part, None, "a.geojson", "--window", "500100,5200200,500250,5200390"), (x > 0, None, "all.geojson"),
                                 (x < 0, "far.geojson: no sample that is looked at lies inside", "far.geojson")):
        view("utm.vrt", *words, *more, says=says)
        assert [int(line.split(",")[3]) for line in read("s.csv").decode().splitlines()[1:]] == [(samples & (band == 1)).sum() for band in bands]
    for features, why in [([feature("Point", LINE[0])], "feature 0: is a POINT, no polygon"), ([feature("LineString", LINE)], "feature 0: is a LINESTRING, no polygon"),
                          ([], "holds no polygons"), *(([around(far)], "feature 0: reaches too far away from the terrain") for far in (1e12, 1e300))]:
        geojson("w.geojson", *features)
        refused(1, f"w.geojson: {why}", "viewshed", "utm.vrt", *words, "w.geojson", "-o", "o.npy")
    for name, why in ("t.csv", "t.csv: holds no polygons"), ("none.gpkg", "none.gpkg: "):
        refused(1, why, "viewshed", "utm.vrt", *words, name, "-o", "o.npy")


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
