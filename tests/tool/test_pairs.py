# SPDX-License-Identifier: Apache-2.0
"""`cellwalk los` with a table of pairs and with profiles."""
import json
import re

import numpy as np
import pytest
from program import entries, interrupted, read, refused, run, well, write

LOS = "los", "wall.npy", "--cellsize", 10, "--curvature", 0


@pytest.fixture(autouse=True)
def wall(folder):
    """A wall of 40 m along row 20, y = 290, on level ground with a hole at x = 300, y = 250."""
    z = np.zeros((50, 60), np.float32)
    z[20], z[24, 30] = 40, np.nan
    np.save("wall.npy", z)


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
    well("los", "wall.npy", "--cellsize", "1e150", "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv")
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
def test_tables_that_are_refused(text, why):
    write("p.csv", text)
    refused(1, why, *LOS, "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv")


@pytest.mark.parametrize("status, why, words", [
    (1, "p.csv", ("--pairs", "p.csv", "-o", "./p.csv")),
    (2, "do not go together", ("--pairs", "p.csv", "1,2", "3,4")),
    (2, "FROM is missing, or --pairs FILE", ()),
    (2, "TO is missing, or --pairs FILE", ("1,2",)),
    (2, "-o goes with --pairs", ("1,2", "3,4", "-o", "a.csv")),
    (2, "--json goes with two places", ("--pairs", "p.csv", "--json")),
    (2, "--profile needs a file that nothing else is written to", ("--pairs", "p.csv", "--profile", "-"))])
def test_refusals(status, why, words):
    write("p.csv", "x1,y1,x2,y2\n1,2,3,4\n")
    refused(status, why, *LOS, *words)


def test_endings():
    """So many pairs that they take a while: the disk is full, and Ctrl-C."""
    write("p.csv", "x1,y1,x2,y2\n" + "".join(f"0,0,{k % 590},400\n" for k in range(200000)))
    before = entries()
    words = *LOS, "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv"
    done = run(*words, file_size=1000000)
    assert done.status == 1 and "b.csv: cannot write: File too large" in done.err and entries() == before
    interrupted(*words, input="wall.npy")
