# SPDX-License-Identifier: Apache-2.0
"""shadow, horizon, viewshed, sun and los as users run them: files in, files out, on made-up land."""
import re

import numpy as np
import pytest
from program import array, needs, read, refused, run, wall, well, write

NX, NY = 60, 50
ROWS, COLUMNS = np.mgrid[:NY, :NX]
MAP = "--cellsize", 10
FLAT = *MAP, "--curvature", 0


@pytest.fixture(autouse=True)
def land(folder):
    """A wall at y = 290; and with a hole at x = 300, y = 250."""
    wall("wall.npy")
    wall("holed.npy", (24, 30))


SUN = "--sun", "0,45.1"
SOUTH, NORTH = ROWS >= 20, ROWS <= 20


@pytest.mark.parametrize("words, wanted", [
    # The sun in the north, 45 degrees high: 40 m of shadow to the south, over four rows. The ray from the fourth touches the wall's
    # top, to rounding; so the sun is a little higher.
    (("shadow", *SUN), ~((ROWS > 20) & (ROWS < 24))),
    (("shadow", *SUN, "--zscale", 2), ~((ROWS > 20) & (ROWS < 28))),
    (("shadow", *SUN, "--nodata", 40), np.where(ROWS == 20, 255, 1)),
    (("shadow", *SUN, "--nodata", 40, "--nodata", 0), 255),
    # Metres to the nearest of several places as high; from the wall all lies below, and the border is the highest.
    (("horizon", "--directions", 1, "--distance"), np.where(ROWS == 0, np.nan, np.where(ROWS == 20, 200, np.maximum(10 * (ROWS - 20), 10)))),
    # From the south all up to the wall; from the north the rest; both together are counted.
    (("viewshed", "--curvature", 0, "--from", "300,100,1.7"), SOUTH), (("viewshed", "--curvature", 0, "--from", "250,400,1.7"), NORTH),
    (("viewshed", "--curvature", 0, "--from", "300,100,1.7", "--from", "250,400,1.7"), SOUTH * 1 + NORTH)])
def test_a_wall(words, wanted):
    assert np.array_equal(array(words[0], "wall.npy", *MAP, *words[1:]), np.broadcast_to(wanted, (NY, NX)), equal_nan=True)


def test_tables_of_a_wall():
    assert well("horizon", "wall.npy", *MAP, "--directions", 4, "--at", "300,190").out == (
        "place,azimuth,true_azimuth,angle,distance,x,y\n1,0,,21.801409,100.000,300,290\n1,90,,0.000000,10.000,310,190\n"
        "1,180,,0.000000,10.000,300,180\n1,270,,0.000000,10.000,290,190\n")
    # The line rises 28 m in 200; the wall's flank 40 m in the last 10 of 100: they meet at 94.3 m.
    assert well("los", "wall.npy", "300,190,2", "300,390,=30", *FLAT).out == (
        "blocked: 93.782 m from the first place, of 200.000 m, at a height of 15.130 m\nat 300,283.7823834\n")
    assert well("los", "wall.npy", "300,190,+2", "300,390,=85", *FLAT, "--json").out == '{"visible": true, "distance": 200}\n'


def test_coarser_wall():
    """Standard error says how far the coarser terrain lies from the full one."""
    done = run("shadow", "wall.npy", *MAP, *SUN, "-o", "s.npy", "--coarser", 2, "--filter", "highest", "--zscale", 0.5)
    assert done.status == 0 and "31 x 26 samples for 60 x 50" in done.err and "up to 20 above and 0 below" in done.err
    # What needs no field otherwise, and a place on the same map.
    done = run("los", "wall.npy", "50,490,+1", "50,0,+1", *MAP, "--coarser", 2, "--filter", "lowest")
    assert done.status == 0 and "visible" in done.out and "up to 0 above and 40 below" in done.err


def test_large_outputs():
    """Larger than what is written at once, with the wall in the last block."""
    z = np.zeros((600, 2000), np.float32)
    z[590] = 40
    np.save("large.npy", z)
    seen = array("viewshed", "large.npy", *FLAT, "--from", "9000,5990")
    assert (seen == (np.arange(600) <= 590)[:, None]).all()


def test_places_that_are_the_same():
    """A height above ground and the absolute height that it comes to; a place but for a last digit on a row: on the ridge both sides are seen."""
    for words, places in ((FLAT, ("300,290,+3", "300,290,=43")), (FLAT, ("300,100,3", "300,100,=3")),
                          (("--cellsize", 1, "--curvature", 0), ("7,29,0", "7,29.000000001,0", "7,28.999999999,0"))):
        views = [array("viewshed", "wall.npy", *words, "--from", place) for place in places]
        assert all((view == views[0]).all() for view in views)
        assert views[0][[0, 49], 7].all() if words is not FLAT else len({well("los", "wall.npy", *words, place, "300,400,60").out for place in places}) == 1
    for place in "7,1e-320,=2", "7,-1e-320,=2", "1e-300,7,=2":  # one over some distances is no number
        need = array("viewshed", "wall.npy", "--cellsize", 1, "--curvature", 0, "--from", place, "--needed")
        assert ((need >= 0) & (need < 1000)).all()


@pytest.mark.parametrize("words", [
    ("shadow", "--sun", "20,60", "-o", "o.npy"), ("horizon", "--directions", 3, "-o", "o.npy"), ("viewshed", "--from", "7,35,60", "-o", "o.npy"),
    ("render", "--size", "30x20", "-o", "o.exr"), ("los", "7,3,2", "20,40,60"), ("horizon", "--at", "7,3,2")])
def test_rows_without_a_map(words):
    """Row 0 is in the north and cells are 1 wide, as with --cellsize 1, and that is said."""
    results, (command, *more) = [], words
    for given in (), ("--cellsize", 1, *(("--curvature", 0) if command in ("viewshed", "los") else ())):
        done = run(command, "wall.npy", *more, *given)
        assert done.status == 0 and ("cells are read as 1 wide, row 0 as the northernmost" in done.err) == (given == ())
        results.append((done.out, read(more[-1]) if "-o" in more else b""))
    assert results[0] == results[1]


@pytest.mark.parametrize("date, rows", [("0999", 12), ("0999-02", 28), ("2024-02", 29), ("9999", 12)])
def test_months_and_years(date, rows):
    """350 is 10 degrees west."""
    west, same = (well("sun", "wall.npy", *MAP, "--lon-lat", f"{x},47", "--date", date, "--step", "6h", "--at", "5,5").out for x in (-10, 350))
    assert west.count("\n") == 1 + rows and west == same


# ---- pairs and profiles ---------------------------------------------------------------------------------------------------


def test_holes_of_profiles():
    """On a row: a hole has no ground."""
    write("l.csv", "x1,y1,x2,y2,height2\n280,250,320,250,3\n")
    well("los", "holed.npy", *FLAT, "--pairs", "l.csv", "--profile", "p.csv")
    assert read("p.csv").decode() == (
        "pair,distance,x,y,ground,line,seen\n1,0.000,280,250,0.000,0.000,1\n1,10.000,290,250,0.000,0.750,1\n1,20.000,300,250,,1.500,\n"
        "1,30.000,310,250,0.000,2.250,0\n1,40.000,320,250,0.000,3.000,0\n")


def test_rows_are_as_long_as_their_numbers():
    """Metres of 151 digits."""
    write("p.csv", "x1,y1,x2,y2,height1,height2\n2e150,1e150,2e150,40e150,5,1\n")
    well("los", "holed.npy", "--cellsize", "1e150", "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv")
    for name, columns, count in ("a.csv", 11, 2), ("b.csv", 7, 41):
        text = read(name).decode()
        rows = text.splitlines()
        assert re.fullmatch(r"[ -~\n]*", text) and len(rows) == count and {row.count(",") for row in rows} == {columns - 1}
        assert sum(c.isdigit() for c in text) > 150 * (count - 1)


# ---- GDAL ---------------------------------------------------------------------------------------------------------------

SHADOW, VIEW, HORIZON = (("shadow", *MAP, "--sun", "225.5,30"), ("viewshed", *MAP, "--from", "300,100"), ("horizon", *MAP, "--directions", 3))


@pytest.mark.parametrize("words, says", [
    (SHADOW, [">225.5<", "SUN_ALTITUDE", "1 where the sun is seen, 0 in the shadow", "cellwalk VERSION"]),
    ((*SHADOW, "--hillshade"), ["cosine of the angle between sun and normal"]),
    ((*VIEW, "--from", "310,100,=7"), [">300,100,2<", ">310,100,=7<", "OBSERVER_2", "number of observers that see the target", "CURVATURE"]),
    ((*VIEW, "--needed", "--azimuth", "10,200"), ["height above ground that is needed to be seen", ">m<", "AZIMUTH", ">10,200<"]),
    (HORIZON, ["azimuth 240", ">degree<", "DIRECTIONS"]),
    ((*HORIZON, "--distance"), ["distance to the horizon", ">metre<", " m, median"]), ((*HORIZON, "--svf"), ["sky-view factor"]),
    ((*HORIZON, "--svf-tilted"), ["reaches the leaning ground"]),
    (("sun", *MAP, "--lon-lat", "7,47", "--date", "2024-06-21", "--irradiance"),
     ["Rigollier", ">2024-06-21<", "diffuse light on the ground", "LINKE", ">Wh/m2<"])])
def test_geotiffs_say_how_they_were_made(words, says):
    """Metadata are text in the file; the line at the end has units."""
    needs("GDAL")
    version = run("--version").out.split()[1]
    done = well(words[0], "wall.npy", *words[1:], "-o", "o.tif")
    for words in says:
        assert words.replace("VERSION", version).encode() in read("o.tif") + done.outcome.encode(), words


def test_creation_options():
    needs("GDAL")
    words = "shadow", "wall.npy", *MAP, "--sun", "0,30", "--co"
    for option, magic in ("BIGTIFF=YES", 43), ("BIGTIFF=NO", 42):
        well(*words, option, "--co", "compress=LZW", "-o", "s.tif")
        assert read("s.tif")[2] == magic
    lossy = [("or leave a second file", option) for option in ("tfw=yes", "NBITS=1", "COMPRESS=JPEG")]
    for why, *more in *lossy, ("creation option FOO", "FOO=1"), ("--co takes NAME=VALUE, not 'BIGTIFF'", "BIGTIFF"), ("creation option TILED", "TILED=NO", "--cog"):
        refused(1, why, *words, *more, "-o", "no.tif")
