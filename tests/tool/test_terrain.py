# SPDX-License-Identifier: Apache-2.0
"""shadow, horizon, viewshed, sun and los as users run them: files in, files out, on made-up land and on a real one."""
import json
import re

import numpy as np
import pytest
from program import REAL, array, asc, entries, interrupted, needs, needs_real, rays, read, refused, rough, run, vrt, well, write

NX, NY = 60, 50
ROWS, COLUMNS = np.mgrid[:NY, :NX]
MAP = "--cellsize", 10
FLAT = *MAP, "--curvature", 0


@pytest.fixture(autouse=True)
def wall(folder):
    """A wall of 40 m along row 20, y = 290, on level ground; and the same with a hole at x = 300, y = 250."""
    z = np.zeros((NY, NX), np.float32)
    z[20] = 40
    np.save("wall.npy", z)
    holed = z.copy()
    holed[24, 30] = np.nan
    np.save("holed.npy", holed)
    return z


def test_shadow_of_a_wall():
    # The sun in the north, 45 degrees high: 40 m of shadow to the south, over four rows. The ray from the fourth touches the wall's
    # top, to rounding; so the sun is a little higher.
    sun = "--sun", "0,45.1"
    assert (array("shadow", "wall.npy", *MAP, *sun) == ~((ROWS > 20) & (ROWS < 24))).all()
    assert (array("shadow", "wall.npy", *MAP, "--zscale", 2, *sun) == ~((ROWS > 20) & (ROWS < 28))).all()
    light = array("shadow", "wall.npy", *MAP, "--nodata", 40, *sun, "--hillshade")
    assert np.isnan(light[20]).all() and np.allclose(np.delete(light, 20, 0), np.sin(np.radians(45.1)), atol=1e-6)
    assert (array("shadow", "wall.npy", *MAP, "--nodata", 40, "--nodata", 0, *sun) == 255).all()


def test_coarser_wall():
    """Every second row: the wall is as high two rows on, and three coarser rows thick. Each output has as many samples as the coarser
    terrain, and standard error says how far that lies from the full one."""
    words = "shadow", "wall.npy", *MAP, "--sun", "0,45.1", "-o", "s.npy"
    done = run(*words, "--coarser", 2, "--filter", "highest", "--zscale", 0.5)
    assert done.status == 0 and "31 x 26 samples for 60 x 50" in done.err and "up to 20 above and 0 below" in done.err
    lit = np.load("s.npy")
    assert lit.shape == (26, 31) and (lit == 1).all()
    run(*words, "--coarser=2", "--filter=highest")
    assert (np.load("s.npy") == (np.arange(26) != 12)[:, None]).all()
    # What needs no field otherwise, and a place on the same map.
    done = run("los", "wall.npy", "50,490,+1", "50,0,+1", *MAP, "--coarser", 2, "--filter", "lowest")
    assert done.status == 0 and "visible" in done.out and "up to 0 above and 40 below" in done.err


def test_horizon_at_a_wall():
    words = "horizon", "wall.npy", *MAP, "--directions", 4
    row, column, up = 30, 30, np.degrees(np.arctan(40 / 100))  # x = 300, y = 190
    angles = array(*words)  # there is no data beyond the border, and no angle that statistics would count
    assert np.isnan(angles[0, 0]).all() and (angles[0, 1:] > -89).all()
    at = angles[:, row, column]
    assert abs(at[0] - up) < 1e-3 and (at[1:] == 0).all()
    assert well(*words, "--at", "300,190").out == (
        "place,azimuth,true_azimuth,angle,distance,x,y\n1,0,,21.801409,100.000,300,290\n1,90,,0.000000,10.000,310,190\n"
        "1,180,,0.000000,10.000,300,180\n1,270,,0.000000,10.000,290,190\n")
    metres = array(*words, "--distance")  # of several places the nearest
    assert metres[:, row, column].tolist() == [100, 10, 10, 10] and np.isnan(metres[0, 0]).all()
    sky = array(*words, "--svf")[row, column]
    assert abs(sky - (3 + np.cos(np.radians(up)) ** 2) / 4) < 1e-6


def test_view_of_a_wall():
    """From the south all up to the wall; from the north the rest; both together are counted."""
    places = "300,100,1.7", "250,400,1.7"
    seen = [array("viewshed", "wall.npy", *FLAT, "--from", place) for place in places]
    assert (seen[0] == (ROWS >= 20)).all() and (seen[1] == (ROWS <= 20)).all()
    assert (array("viewshed", "wall.npy", *FLAT, "--from", places[0], "--from", places[1]) == seen[0] + seen[1]).all()
    # What stands 10 rows behind the wall, 20 from the eye, must be 80 m high less what the eye is.
    needed = array("viewshed", "wall.npy", *FLAT, "--from", "300,190,0", "--needed")
    assert abs(needed[10, 30] - 80) < 1e-4
    # Larger than what is written at once, with the wall in the last block.
    z = np.zeros((600, 2000), np.float32)
    z[590] = 40
    np.save("large.npy", z)
    seen = array("viewshed", "large.npy", *FLAT, "--from", "9000,5990")
    assert (seen == (np.arange(600) <= 590)[:, None]).all()


def test_sun_at_a_wall():
    """At the pole the sun turns about at one height, 20 degrees in late May: all sides of the wall have shadow for a while; level ground
    far from it has the whole day. With --irradiance the bands are direct and diffuse light."""
    words = "sun", "wall.npy", *MAP, "--lon-lat", "0,90", "--date", "2024-05-21"
    hours = array(*words, "--step", "1h")[:, NX // 2]
    # 40 m at 20.2 degrees are 109 m of shadow, 10.9 rows; the wall as seen 8 rows off fills nearly half of the round.
    off = np.abs(np.arange(NY) - 20)
    assert (hours[(off == 0) | (off > 10)] == 24).all()
    assert ((hours >= 12) & (hours < 20))[(off > 0) & (off < 9)].all() and (hours[(off == 9) | (off == 10)] < 24).all()
    direct, diffuse = array(*words, "--to", "2024-05-22", "--irradiance", "--linke", 2)[:, :, 30]
    # By the formulas at the almanac's mean declination, 20 degrees 20.7', with 1.0122 astronomical units and 0.045 degrees of
    # refraction. From that the declination strays by 12' on either side, and light with it by 1.4 % at most.
    assert abs(direct[45] / (48 * 294.1) - 1) < 0.02 and abs(diffuse[45] / (48 * 44.7) - 1) < 0.02
    assert direct[22] < 0.8 * direct[45] and diffuse[22] < 0.8 * diffuse[45]


def test_lines_at_a_wall():
    done = well("los", "wall.npy", "300,190,2", "300,390,=30", *FLAT)
    # The line rises 28 m in 200; the wall's flank 40 m in the last 10 of 100: they meet at 94.3 m.
    met = (90 * 4 + 2) / (4 - 0.14)
    says = r"blocked: (\S+) m from the first place, of (\S+) m, at a height of (\S+) m\nat (\S+),(\S+)\n"
    away, of, z, x, y = map(float, re.match(says, done.out).groups())
    assert x == 300 and of == 200 and max(abs(z - 2 - 0.14 * met), abs(away - met), abs(y - 190 - met)) < 1e-3
    assert well("los", "wall.npy", "300,190,+2", "300,390,=85", *FLAT, "--json").out == '{"visible": true, "distance": 200}\n'


@pytest.mark.parametrize("same", [("300,290,+3", "300,290,=43"), ("300,100,3", "300,100,=3")])
def test_heights_of_places(same):
    """A height above ground and the absolute height that it comes to are the same place."""
    views = [array("viewshed", "wall.npy", *MAP, "--from", place) for place in same]
    lines = [well("los", "wall.npy", *MAP, place, "300,400,60").out for place in same]
    assert (views[0] == views[1]).all() and lines[0] == lines[1]


def test_a_place_next_to_a_row_is_on_it():
    """But for a last digit: on the ridge of the wall both sides are seen, not one. One over some distances is no number."""
    words = "viewshed", "wall.npy", "--cellsize", 1, "--curvature", 0, "--from"
    seen = [array(*words, place) for place in ("7,29,0", "7,29.000000001,0", "7,28.999999999,0")]
    assert seen[0][0, 7] == 1 and seen[0][49, 7] == 1 and (seen[1] == seen[0]).all() and (seen[2] == seen[0]).all()
    for place in "7,1e-320,=2", "7,-1e-320,=2", "1e-300,7,=2":
        need = array(*words, place, "--needed")
        assert ((need >= 0) & (need < 1000)).all()


RUNS = [("shadow", "--sun", "20,60", "-o", "o.npy"), ("horizon", "--directions", 3, "-o", "o.npy"), ("viewshed", "--from", "7,35,60", "-o", "o.npy"),
        ("render", "--size", "30x20", "-o", "o.exr"), ("los", "7,3,2", "20,40,60"), ("horizon", "--at", "7,3,2")]


@pytest.mark.parametrize("words", RUNS)
def test_rows_without_a_map(words):
    """Row 0 is in the north and cells are 1 wide, as with --cellsize 1, and that is said."""
    results, (command, *more) = [], words
    for given in (), ("--cellsize", 1, *(("--curvature", 0) if command in ("viewshed", "los") else ())):
        done = run(command, "wall.npy", *more, *given)
        assert done.status == 0 and ("cells are read as 1 wide, row 0 as the northernmost" in done.err) == (given == ())
        results.append((done.out, read(more[-1]) if "-o" in more else b""))
    assert results[0] == results[1]


@pytest.mark.parametrize("date, rows", [("0999", 12), ("0999-02", 28), ("2024-02", 29), ("9999", 12)])
def test_months_and_years(wall, date, rows):
    assert well("sun", "wall.npy", *MAP, "--lon-lat", "9,47", "--date", date, "--step", "6h", "--at", "5,5").out.count("\n") == 1 + rows


# ---- pairs and profiles ---------------------------------------------------------------------------------------------------

LOS = "los", "holed.npy", *FLAT


def test_each_row_is_answered_as_its_places_alone():
    ends = ("200,190,2", "200,390,=30"), ("200,190,2", "200,390,85"), ("10,20,0", "333.3,401.5,1"), ("5,5,=3", "580,5,3")
    write("p.csv", "x1,y1,height1,height2,x2,y2\n200,190,2,=30,200,390\n200,190,2,85,200,390\n10,20,,1,333.3,401.5\n5,5,=3,3,580,5\n")
    well(*LOS, "--pairs", "p.csv", "-o", "a.csv")
    head, *lines = read("a.csv").decode().splitlines()
    assert head == "pair,x1,y1,x2,y2,visible,distance,blocked_distance,blocked_x,blocked_y,blocked_height" and len(lines) == 4
    for k, (places, line) in enumerate(zip(ends, lines), 1):
        wanted = json.loads(well(*LOS, "--json", *places).out)
        cells = line.split(",")
        assert cells[0] == str(k) and int(cells[5]) == wanted["visible"]
        assert np.allclose(np.array(cells[1:5], float), [float(c) for place in places for c in place.split(",")[:2]], rtol=0, atol=1e-6)
        assert abs(float(cells[6]) - wanted["distance"]) < 6e-4
        if wanted["visible"]:
            assert cells[7:] == [""] * 4
        else:
            off = np.abs(np.array(cells[7:], float) - [wanted["blocked_distance"], *wanted["blocked_at"], wanted["blocked_height"]])
            assert (off < [6e-4, 1e-6, 1e-6, 6e-4]).all()
    assert well(*LOS, "--pairs", "p.csv").out == read("a.csv").decode()


def test_profile_over_a_wall():
    """Over level ground, up and down the wall, and into its shadow: heights are known at every crossing."""
    assert well(*LOS, "200,190,2", "200,390,=30", "--profile", "p.csv").out.startswith("blocked: ")
    rows = [f"1,{10 * k:.3f},200,{190 + 10 * k},{40 * (k == 10):.3f},{2 + 1.4 * k:.3f},{int(k <= 10)}\n" for k in range(21)]
    assert read("p.csv").decode() == "pair,distance,x,y,ground,line,seen\n" + "".join(rows)
    # Between two rows: columns and diagonals in turn. On a row: a hole has no ground.
    write("l.csv", "x1,y1,x2,y2,height2\n100,255,500,255,3\n280,250,320,250,3\n")
    well(*LOS, "--pairs", "l.csv", "--profile", "p.csv")
    text = read("p.csv").decode()
    assert ("\n2,0.000,280,250,0.000,0.000,1\n2,10.000,290,250,0.000,0.750,1\n2,20.000,300,250,,1.500,\n"
            "2,30.000,310,250,0.000,2.250,0\n2,40.000,320,250,0.000,3.000,0\n") in text
    assert text.count("\n") == 1 + 81 + 5  # every 10 m a column, halfway between a diagonal


def test_rows_are_as_long_as_their_numbers():
    """Metres of 151 digits."""
    write("p.csv", "x1,y1,x2,y2,height1,height2\n2e150,1e150,2e150,40e150,5,1\n")
    well("los", "holed.npy", "--cellsize", "1e150", "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv")
    for name, columns, count in ("a.csv", 11, 2), ("b.csv", 7, 41):
        text = read(name).decode()
        rows = text.splitlines()
        assert re.fullmatch(r"[ -~\n]*", text) and len(rows) == count and {row.count(",") for row in rows} == {columns - 1}
        assert sum(c.isdigit() for c in text) > 150 * (count - 1)


@pytest.mark.parametrize("text, why", [
    ("x1,y1,x2\n1,2,3\n", "p.csv: has no column 'y2'; its first line names x1, y1, x2"),
    ("x1,y1,x2,y2\n", "p.csv: holds no pairs"),
    ("x1,y1,x2,y2\n1,2,3,4\n1,2,b,4\n", "p.csv:3: 'b' stands where a number should, in x2"),
    ("x1,y1,x2,y2\n1,2,3,4\n1,2,3,999\n", "p.csv:3: 3,999,0: lies outside"),
    ("x1,y1,height1,x2,y2\n1,2,low,3,4\n", "p.csv:2: 'low' stands where a height")])
def test_pairs_that_are_refused(text, why):
    write("p.csv", text)
    refused(1, why, *LOS, "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv")


def test_many_pairs():
    """So many pairs that they take a while: the disk is full, and Ctrl-C."""
    write("p.csv", "x1,y1,x2,y2\n" + "".join(f"0,0,{k % 590},400\n" for k in range(200000)))
    before = entries()
    words = *LOS, "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv"
    done = run(*words, file_size=1000000)
    assert done.status == 1 and "b.csv: cannot write: File too large" in done.err and entries() == before
    interrupted(*words, input="holed.npy")


# ---- refusals -----------------------------------------------------------------------------------------------------------

REFUSED = [
    (2, "--distance goes with none of", "horizon", "--distance", "--svf", "-o", "no.npy"),
    (1, "no room for 32 bands", "horizon", "-o", "h.png"),
    (2, "--cog goes with -o FILE.tif", "shadow", "--sun", "0,9", "--cog", "-o", "no.npy"),
    (2, "--co goes with -o FILE.tif", "shadow", "--sun", "0,9", "--co", "A=B", "-o", "no.npy"),
    (1, "names no coordinate system, so the sun's place at a time is not known; give --sun", "shadow", "--time", "2024-06-21T12:00:00Z", "-o", "no.npy"),
    (2, "either --sun or --time", "shadow", "-o", "s.npy"),
    (1, "s.png: is a raster's name, and the result is a table; give -o FILE.csv", "sun", "--at", "5,5,2", "--lon-lat", "9,47", "--date", "2024-06-21", "-o", "s.png"),
    (1, "s.tif: is a raster's name", "horizon", "--at", "5,5", "-o", "s.tif"),
    (2, "--sun 0,91: the second number is the altitude", "shadow", "--sun", "0,91", "-o", "s.npy"),
    (2, "give -o FILE", "shadow", "--sun", "0,30"),
    (2, "not 'noon'", "shadow", "--time", "noon", "-o", "s.npy"),
    (1, "the name's ending tells no format", "shadow", "--sun", "0,30", "-o", "s.xyz"),
    (1, "is the terrain itself", "shadow", "--sun", "0,30", "-o", "./wall.npy"),
    (2, "--cellsize takes a number above 0", "shadow", "--sun", "0,30", "--cellsize", "0", "-o", "s.npy"),
    (1, "has one band, not 2", "shadow", "--sun", "0,30", "--band", "2", "-o", "s.npy"),
    (2, "--nodata takes a number, not 'x'", "shadow", "--nodata", "x", "--sun", "0,45", "-o", "s.npy"),
    (2, "--from X,Y is missing", "viewshed", "-o", "v.npy"),
    (2, "not '3;4'", "viewshed", "--from", "3;4", "-o", "v.npy"),
    (1, "is too far away", "viewshed", "--from", "3,1e308,=9", "-o", "v.npy"),
    (2, "not '5'", "los", "5", "10,10,+2"),
    (2, "not '1,2,='", "los", "1,2,=", "10,10,2"),
    (2, "not '1,=2'", "los", "1,=2", "10,10,2"),
    # Farther away than lines of sight are computed, where numbers no longer fit.
    (1, "is too far away", "los", "1e308,1e308,=9", "10,10,2"),
    (1, "is too far away", "los", "10,10,2", "1e8,3,=9"),
    (1, "pairs.csv", "los", "--pairs", "pairs.csv", "-o", "./pairs.csv"),
    (2, "do not go together", "los", "--pairs", "pairs.csv", "1,2", "3,4"),
    (2, "FROM is missing, or --pairs FILE", "los"),
    (2, "TO is missing, or --pairs FILE", "los", "1,2"),
    (2, "-o goes with --pairs", "los", "1,2", "3,4", "-o", "a.csv"),
    (2, "--json goes with two places", "los", "--pairs", "pairs.csv", "--json"),
    (2, "--profile needs a file that nothing else is written to", "los", "--pairs", "pairs.csv", "--profile", "-"),
    *((status, why, "sun", *MAP, "-o", "s.csv" if "--at" in more else "s.npy", *more) for status, why, *more in [
        (2, "--date is missing"),
        (2, "--suns goes with none of --date", "--suns", "no.csv", "--date", "2024"),
        (2, "--suns goes with none of --date", "--suns", "no.csv", "--irradiance", "--linke", "3"),
        (1, "no.csv: cannot read", "--suns", "no.csv"),
        (1, "suns.csv:3: '91' stands where an angle from -90 to 90 degrees should, in altitude", "--suns", "suns.csv"),
        (1, "suns.csv:3: '91' stands", "--suns", "suns.csv", "--at", "9,9"),
        (1, "head.csv: holds no places of the sun", "--suns", "head.csv"),
        (2, "--max-distance goes with --at", "--suns", "suns.csv", "--max-distance", "9"),
        (2, "--max-distance takes metres above 0", "--suns", "suns.csv", "--at", "9,9", "--max-distance=-9"),
        (2, "--max-distance takes metres above 0", "--suns", "suns.csv", "--at", "9,9", "--max-distance", "0"),
        (2, "not 'yesterday'", "--date", "yesterday"),
        (2, "not '2024-02-30'", "--date", "2024-02-30"),
        (1, "names no coordinate system", "--date", "2024-06-21"),
        (2, "is before", "--date", "2024-06-21", "--to", "2024-06-20"),
        (2, "divides a day", "--date", "2024-06-21", "--step", "7min"),
        (2, "not '15'", "--date", "2024-06-21", "--step", "15"),
        (2, "go with --irradiance", "--date", "2024-06-21", "--linke", "3"),
        (2, "from 1 to 10, not 0", "--date", "2024-06-21", "--irradiance", "--linke", "0"),
        (2, "not '7'", "--date", "2024-06-21", "--lon-lat", "7"),
        (2, "longer --step", "--date", "2000-06-21", "--to", "2024-06-20", "--step", "30s")])]


@pytest.mark.parametrize("status, why, command, more", [(*case[:3], case[3:]) for case in REFUSED])
def test_refusals(status, why, command, more):
    write("suns.csv", "azimuth,altitude\n1,90\n2,91\n")
    write("head.csv", "azimuth,altitude,weight\n")
    write("pairs.csv", "x1,y1,x2,y2\n1,2,3,4\n")
    refused(status, why, command, "wall.npy", *more)


@pytest.mark.parametrize("place, why", [
    # Column 70 does not exist, nor does row 55 from below; (5, 29) is on the wall.
    ("70,5,2", "70,5,2: lies outside: the samples, which are the pixels' centres, go from X 0 to 59 and Y 0 to 49"),
    ("-300,4", "-300,4: lies outside"),
    ("20,55,+1", "20,55,+1: lies outside, but with X and Y exchanged it would not"),
    ("59.4,5,2", "59.4,5,2: lies in the outer half of a pixel"),
    ("3,4,2", "3,4,2: there is no data at that place"),
    ("5,29,=39", "5,29,=39: is under the ground, which is 40.000 m high there: X,Y,H counts H from the ground"),
    ("5,29,-1", "5,29,-1: is under the ground, which is 40.000 m high there")])
def test_places_that_are_refused(wall, place, why):
    """One meaning of a place for all: H above ground, =Z absolute, and what is wrong with one is said."""
    wall[45, 3] = np.nan
    np.save("holed.npy", wall)
    for command, *more in [("viewshed", "--from", place, "-o", "v.npy"), ("horizon", "--at", place), ("los", "10,10,2", place),
                           ("los", place, "10,10,2"), ("render", "--from", place, "-o", "v.exr"), ("render", "--to", place, "-o", "v.exr")]:
        refused(1, why, command, "holed.npy", *more)


def test_interruptions():
    """Ctrl-C in the middle of a long run: no file remains."""
    np.save("rough.npy", rough(2000))
    # A viewshed writes nothing before it is done.
    interrupted("viewshed", "rough.npy", *["--from", "1000,1000,100000"] * 4, "-o", "o.npy", "--threads", 1, input="rough.npy", writes=False)
    for more in (), ("--svf",):
        interrupted("horizon", "rough.npy", "--directions", 3600, *more, "-o", "o.npy", input="rough.npy")


# ---- GDAL ---------------------------------------------------------------------------------------------------------------

SHADOW, VIEW, HORIZON = (("shadow", *MAP, "--sun", "225.5,30"), ("viewshed", *MAP, "--from", "300,100"), ("horizon", *MAP, "--directions", 3))


@pytest.mark.parametrize("words, says", [
    (SHADOW, [">225.5<", "SUN_ALTITUDE", "1 where the sun is seen, 0 in the shadow", "cellwalk VERSION"]),
    ((*SHADOW, "--hillshade"), ["cosine of the angle between sun and normal"]),
    ((*VIEW, "--from", "310,100,=7"), [">300,100,2<", ">310,100,=7<", "OBSERVER_2", "number of observers that see the target", "CURVATURE"]),
    ((*VIEW, "--needed", "--azimuth", "10,200"), ["height above ground that is needed to be seen", ">m<", "AZIMUTH", ">10,200<"]),
    (HORIZON, ["azimuth 240", ">degree<", "DIRECTIONS"]),
    ((*HORIZON, "--svf"), ["sky-view factor"]),
    ((*HORIZON, "--svf-tilted"), ["reaches the leaning ground"]),
    (("sun", *MAP, "--lon-lat", "7,47", "--date", "2024-06-21", "--irradiance"),
     ["Rigollier", ">2024-06-21<", "diffuse light on the ground", "LINKE", ">Wh/m2<"])])
def test_geotiffs_say_how_they_were_made(words, says):
    """Metadata are text in the file."""
    needs("GDAL")
    version = run("--version").out.split()[1]
    well(words[0], "wall.npy", *words[1:], "-o", "o.tif")
    for words in says:
        assert words.replace("VERSION", version).encode() in read("o.tif"), words


def test_creation_options():
    needs_real()
    words = "shadow", REAL, "--sun", "0,30"
    for option, magic in ("--co=BIGTIFF=YES", 43), ("--co=BIGTIFF=NO", 42):
        well(*words, option, "--co", "compress=LZW", "-o", "s.tif")
        assert read("s.tif")[2] == magic
    refused(1, "creation option FOO", *words, "--co", "FOO=1", "-o", "no.tif")
    refused(1, "--co takes NAME=VALUE, not 'BIGTIFF'", *words, "--co", "BIGTIFF", "-o", "no.tif")
    refused(1, "creation option TILED", *words, "--cog", "--co", "TILED=NO", "-o", "no.tif")


def test_sources_are_not_replaced():
    """What a VRT is made of is an input, too, however deep: whatever its name says, GDAL knows an ASCII grid by its content."""
    needs("GDAL")
    z = np.arange(1.0, 10).reshape(3, 3)
    asc("grid.npy", z)
    place = "<GeoTransform>0,10,0,30,0,-10</GeoTransform>"
    vrt("inner.npy", "grid.npy", z.shape, place)
    vrt("outer.vrt", "inner.npy", z.shape, place)
    rays("rays.npy", (1, 1, 9))
    before = read("grid.npy")
    for to in "inner.npy", "grid.npy", "./grid.npy":
        for command, *more in ("shadow", "--sun", "0,30"), ("horizon",), ("viewshed", "--from", "15,15,2"), ("trace", "rays.npy"):
            refused(1, "is also an input", command, "outer.vrt", *more, "-o", to)
    assert read("grid.npy") == before
