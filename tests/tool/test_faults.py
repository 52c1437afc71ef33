# SPDX-License-Identifier: Apache-2.0
"""Each call to the system that each subcommand makes fails once: the n-th allocation, write, rename, opening, reading or thread, for every n
(../faults/preload.c). The program then says what went wrong and ends with a status; or, where it can do without, does all that it was asked.
Nothing else changes in the folder, and no memory is lost."""
import os

import numpy as np
import pytest
from program import PRELOAD, SCENE, entries, needs, rays, read, run, take, write

KINDS = "memory", "write", "rename", "open", "read", "thread"
SCENE = SCENE.replace("40", "8").replace("30", "8").replace("Translate -1 -1 2", """Texture "t" "color" "imagemap" "string filename" ["sand.exr"]
Material "matte" "texture Kd" ["t"]
Translate -1 -1 2""").replace('Shape "heightfield" "integer nu" 2 "integer nv" 2 "float Pz" [0 0 .3 0]', 'Include "sea.pbrt"')


@pytest.fixture(autouse=True)
def inputs(folder):
    z = (np.arange(30) * 7 % 5).astype(np.float32).reshape(5, 6)
    np.save("field.npy", z)
    np.save("wide.npy", z.astype("<f8"))
    rays("rays.npy", [(0.1 * k, 1.5, 9) for k in range(40)])
    write("nothing.pbrt", 'Camera "perspective"\nWorldBegin\nWorldEnd\n')
    assert run("render", "nothing.pbrt", "--size", "2x2", "-o", "sand.exr").status == 0
    write("scene.pbrt", SCENE)
    write("sea.pbrt", 'Shape "heightfield" "integer nu" [3] "integer nv" [2] "float Pz" [0 1 2 3 0 1]\n')
    write("places.csv", "name,x,y,height\na,20,20,2\n\"b, c\",30,10,3\n")
    write("pairs.csv", "x1,y1,x2,y2\n10,10,30,20\n")
    write("counts", "")


def run_with(fault, words):
    """Without GDAL: how it ended, each file that it wrote, how many calls there were of each kind, and how many blocks were lost."""
    environment = {"LD_PRELOAD": PRELOAD, "CELLWALK_MODULES": "/nowhere", "CELLWALK_FAULT_COUNTS": "counts", **({"CELLWALK_FAULT": fault} if fault else {})}
    done = run(*words, env=environment)
    *calls, blocks = map(int, read("counts").split())
    files = [take(name) for option, name in zip(words, words[1:]) if option in ("-o", "--table", "--profile")]
    return done, files, calls, blocks


MANY = 80
LAND = "field.npy", "--cellsize", 10
PNG, ONE = ("-o", "out.png"), ("--threads", 1)


@pytest.mark.parametrize("words", [
    ("trace", "field.npy", "rays.npy", "-o", "hits.npy", "--threads", 3),
    ("trace", "wide.npy", "rays.npy", "-o", "hits.npy", "--occluded", "--kernel", "pyramid1", "--json"),
    ("info",), ("info", "field.npy", "--kernel", "grid3d"),
    ("shadow", *LAND, "--sun", "90,10", *ONE, *PNG),  # a picture and its world file come together, or neither comes
    ("viewshed", *LAND, "--observers", "places.csv", "--table", "table.csv", *ONE, "-o", "out.npy"),
    ("visibility", *LAND, "--longest", "--directions", 5, *ONE, "-o", "out.npy"), ("horizon", *LAND, "--places", "places.csv", "--directions", 3, "-o", "out.csv"),
    ("sun", *LAND, "--lon-lat", "9,47", "--date", "2024-06-21", "--step", "6h", "--at", "20,20", "--tilt", "ground", "-o", "out.csv"),
    ("los", *LAND, "--pairs", "pairs.csv", "--frequency", 900, "--profile", "profile.csv", "-o", "out.csv"),
    ("render", *LAND, "--size", "8x8", "--sky", "--haze", 9, "--water", 4, *ONE, "-o", "out.exr"),
    ("render", "scene.pbrt", "-o", "out.exr", "--threads", 3), ("render", "scene.pbrt", "-o", "out.exr", *ONE),
    ("render", "scene.pbrt", *PNG)], ids=lambda words: " ".join(map(str, words)))
def test_every_fault(words):
    if "out.png" in words:
        needs("libpng")
    before = entries()
    done, wanted, calls, lost = run_with(None, words)
    assert done.status == 0, done.err
    tried = survived = 0
    for kind, count in zip(KINDS, calls):
        for n in (*range(1, min(count, MANY) + 1), *range(MANY + 1, count + 1, 7)):  # of many that are alike, some
            tried += 1
            what = f"{kind}:{n}"
            done, got, _, blocks = run_with(what, words)
            if done.status == 0:
                survived += 1
                assert got == wanted, what
            else:
                assert done.status == 1 and done.err.startswith("cellwalk") and len(done.err) > 20, (what, done.status, done.err)
                # What is printed comes last, when the file is whole, and so does a picture's world file; of two files one is renamed first.
                whole = [have for have in got if have is not None]
                assert all(have in wanted for have in whole), what
                last = any(name in done.err for name in (".pgw: ", "out.csv: ", "table.csv: ", "profile.csv: "))
                assert not whole or "standard output" in done.err or (last and (len(whole) < len(wanted) or "out.png" in words)), (what, done.err)
            assert entries() == before and blocks <= lost, what
    assert tried > survived, f"{tried} faults, {survived} without consequence"


def test_rights_of_a_file_that_is_replaced():
    """They are the old file's; less those of a group that cannot be kept; or where none can be set those of any new file."""
    os.umask(0o22)
    own, group = os.getegid(), os.getegid() if os.geteuid() else 12345
    for n in range(1, 9):
        write("old.npy", "")
        os.chown("old.npy", -1, group)
        os.chmod("old.npy", 0o640)
        done, now = run_with(f"write:{n}", ("shadow", *LAND, "--sun", "90,10", *ONE, "--output=old.npy"))[0], os.stat("old.npy")
        assert (now.st_mode & 0o777, now.st_gid) in ((0o640, group), (0o600, own), (0o644, own)), (n, done.err)
