# SPDX-License-Identifier: Apache-2.0
"""The files that the program writes, in every format: whose they are, what goes with the file that they replace, full disks, and that no result takes
the name of an input or of another. ../io/test_outputs.py has the rules."""
import os
import stat
import subprocess

import numpy as np
import pytest
from program import PROGRAM, SCENE, asc, entries, needs, rays, read, refused, run, shell, vrt, write

MAP = "--cellsize", 10
SHADOW = "shadow", "field.npy", *MAP, "--sun", "225,30"
PICTURE = "render", "field.npy", *MAP, "--size", "8x8"
LOS = "los", "field.npy", *MAP, "--pairs", "pairs.csv"
FORMATS = {"hits.npy": ("trace", "field.npy", "rays.npy"), "light.npy": SHADOW, "light.png": SHADOW, "light.tif": SHADOW,
           "light.tiff": ("horizon", "field.npy", *MAP, "--directions", 4, "--cog"), "answers.csv": (*LOS, "--profile", "profile.csv"),
           "view.png": PICTURE, "view.exr": PICTURE}
BESIDE = {"light.png": ["light.pgw"], "answers.csv": ["profile.csv"]}
# Statistics, smaller copies, masks and places of the file before would be read with the new one.
SIDECARS = {"light.tif": ["light.tif.aux.xml", "light.tif.ovr", "light.tif.msk", "light.tfw", "light.tifw"],
            "light.png": ["light.png.aux.xml", "light.png.ovr", "light.png.msk", "light.pngw"]}


@pytest.fixture(autouse=True)
def inputs(folder):
    np.save("field.npy", (np.arange(320) * 7919 % 23).astype(np.float32).reshape(16, 20))
    rays("rays.npy", [(2.25, 1.5, k + 90) for k in range(10)])
    write("pairs.csv", "x1,y1,x2,y2\n10,10,150,120\n30,20,90,100\n")


def make(output):
    """Skips where this build lacks the format's library."""
    done = run(*FORMATS[output], "-o", output)
    if "has no library" in done.err or "needs GDAL" in done.err:
        pytest.skip(done.err)
    assert done.status == 0, done.err


@pytest.mark.parametrize("output", FORMATS)
def test_rights_stay_and_none_are_added(output):
    """Root's result over another's file stays that user's, and never takes a bit that gives rights; with other users, only the mode can be looked
    at."""
    owner = 65534 if os.geteuid() == 0 else os.geteuid()
    if os.geteuid() != 0:
        print("left out: owners, which only root can change")
    make(output)
    for mode in 0o600, 0o4777, 0o6755:
        files = [output, *BESIDE.get(output, [])]
        for name in files:
            write(name, "old")
            os.chown(name, owner, os.getegid())
            os.chmod(name, mode)
        make(output)
        for name in files:
            now = os.stat(name)
            assert now.st_size > 3 and stat.S_IMODE(now.st_mode) == mode & 0o777 and now.st_uid == owner, name


@pytest.mark.parametrize("output", FORMATS)
def test_full_disks(output):
    """A limit on the size of files stands for one; a quota shows in the same way. The file that was there stays, however late it is found out."""
    make(output)
    last = [output, *BESIDE.get(output, [])][-1]
    size = os.path.getsize(output)
    for name in [output, *BESIDE.get(output, [])]:
        write(name, "old")
    for room in {100, size // 2, size - 1} if last == output else {100}:  # a limit on what is said, too
        refused(1, "cannot write: File too large", *FORMATS[output], "-o", output, file_size=room)
        assert read(output) == read(last) == b"old"


def test_targets_that_cannot_be_written_to():
    trace = "trace", "field.npy", "rays.npy", "-o"
    for output, why in ("/dev/full", "No space left on device"), ("absent/hits.npy", "No such file"), (".", "Is a directory"):
        refused(1, f"{output}: cannot write: {why}", *trace, output)
    assert refused(1, "No space left", *trace, "/dev/full", "--json").out == ""  # no time is told of a run that failed
    os.symlink("/dev/full", "full.exr")
    refused(1, "full.exr: cannot write: OpenEXR needs a regular file", *PICTURE, "-o", "full.exr")
    os.mkdir("closed", 0o555)
    write("hits.npy", "old")
    os.chmod("hits.npy", 0o444)  # a file can be replaced wherever its directory may be written to; but its owner wants it to stay
    for output in "closed/hits.npy", "hits.npy":
        refused(1, f"{output}: cannot write: Permission denied", *trace, output, powerless=True)


def test_standard_output_and_closed_streams():
    """A warning that cannot be shown lands in no file either."""
    assert shell("PROGRAM trace field.npy rays.npy -o - > piped.npy && PROGRAM trace field.npy rays.npy -o hits.npy").returncode == 0
    assert read("piped.npy") == read("hits.npy")
    unread, pipe = os.pipe()  # who reads no further is no fault, but nor is it a success
    os.close(unread)
    done = subprocess.run([PROGRAM, "info", "--help"], stdout=pipe, stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (1, b"")
    done = shell("PROGRAM info > /dev/full")
    assert done.returncode != 0 and done.stderr == "cellwalk: cannot write to standard output: No space left on device\n"
    z = np.load("field.npy")
    z[0, 0] = -9999
    np.save("warns.npy", z)
    done = shell("PROGRAM trace warns.npy rays.npy -o hits.npy")
    assert done.returncode == 0 and "-9999" in done.stderr
    for closed in "<&- 2>&-", ">&- 2>&-", "<&- >&- 2>&-", "2>&-":
        assert shell(f"PROGRAM trace warns.npy rays.npy -o again.npy {closed}").returncode == 0
        assert read("again.npy") == read("hits.npy"), closed


@pytest.mark.parametrize("output", SIDECARS)
def test_sidecars_go_with_the_old_file(output):
    """Also if they are links, whose ends stay, and beside either name of a link. Without an old file, nobody knows whose they are: they are neither
    removed nor read with the new file."""
    make(output)
    write("kept", "old")
    before = entries()
    for place in write, lambda name, _: os.symlink("kept", name), lambda name, _: os.symlink("nothing", name), lambda name, _: os.link("kept", name):
        for name in SIDECARS[output]:
            place(name, "old")
        make(output)
        assert entries() == before and read("kept") == b"old"
    os.unlink(output)
    for name in SIDECARS[output]:
        write(name, "old")
        assert "remove that first" in refused(1, name, *FORMATS[output], "-o", output).err
        os.unlink(name)
    os.mkdir("elsewhere")
    os.symlink(f"elsewhere/{output}", output)
    beside = SIDECARS[output][0], f"elsewhere/{output}.ovr"
    for name in (f"elsewhere/{output}", *beside):
        write(name, "old")
    make(output)
    assert not any(map(os.path.exists, beside))
    if output == "light.png":  # a terrain without a map has no world file; the old one would place the new picture
        write("light.pgw", "old")
        assert run("shadow", "field.npy", "--sun", "225,30", "-o", "light.png").status == 0 and not os.path.exists("light.pgw")


def test_a_sidecar_that_is_the_terrain_itself():
    make("light.tif")
    os.rename("light.tif", "sky.tif.ovr")
    write("sky.tif", "old")
    refused(1, "is also an input", "shadow", "sky.tif.ovr", "--sun", "225,30", "-o", "sky.tif")


def test_two_results_do_not_take_one_name():
    """Names are compared by ../io/test_outputs.py; here are the outputs and inputs of each command, new ones and in place of old ones."""
    write("places.csv", "x,y\n20,20\n")
    os.link("places.csv", "view.pgw")
    os.symlink("out.npy", "out.csv")
    seen, at = ("viewshed", "field.npy", *MAP, "--observers", "places.csv"), ("horizon", "field.npy", *MAP, "--places", "places.csv")
    day = "sun", "field.npy", *MAP, "--lon-lat", "9,47", "--date", "2024-06-21", "--step", "6h", "--at", "20,20"
    for _ in range(2):
        for words in (*LOS, "-o", "a.csv", "--profile", "./a.csv"), (*seen, "-o", "out.npy", "--table", "./out.csv"), (*seen, "-o", "out.png", "--table", "out.pgw"):
            refused(1, "is also another output", *words)
            write(words[-3], "old")
    for words in (*seen, "-o", "out.npy", "--table", "field.npy"), (*seen, "-o", "out.npy", "--table", "places.csv"), (*at, "-o", "field.npy"), \
            (*at, "-o", "places.csv"), (*day, "-o", "field.npy"), (*seen, "-o", "view.png"), *(("trace", "field.npy", "rays.npy", "-o", name) for name in ("field.npy", "rays.npy")):
        refused(1, "view.pgw: is also an input" if words[-1] == "view.png" else f"{words[-1]}: is also an input", *words)
    for words in (*seen, "-o", "out.npy", "--table"), (*at, "-o"), (*day, "-o"), (*LOS, "--profile"):
        done = shell(f"PROGRAM {' '.join(map(str, words))} all.csv > all.csv")
        assert done.returncode == 1 and "all.csv: is also where standard output leads" in done.stderr


def test_parts_of_inputs_are_not_replaced():
    """What a VRT is made of, however deep, and a scene: whatever its name says, GDAL knows an ASCII grid by its content."""
    write("scene.pbrt", 'Camera "perspective"\nWorldBegin\nTexture "t" "color" "imagemap" "string filename" "image.exr"\n'
          'Material "matte" "texture Kd" "t"\nInclude "shape.exr"\nWorldEnd\n')
    write("shape.exr", SCENE.splitlines()[-2])
    write("image.pbrt", SCENE)
    if run("render", "image.pbrt", "-o", "image.exr").status == 0:  # with OpenEXR
        for output in "shape.exr", "image.exr":
            refused(1, "is also an input", "render", "scene.pbrt", "-o", output)
    needs("GDAL")
    z, place = np.arange(1.0, 10).reshape(3, 3), "<GeoTransform>0,10,0,30,0,-10</GeoTransform>"
    asc("grid.npy", z)
    vrt("inner.npy", "grid.npy", z.shape, place)
    vrt("outer.vrt", "inner.npy", z.shape, place)
    for to in "inner.npy", "grid.npy", "./grid.npy":
        for command, *more in ("shadow", "--sun", "0,30"), ("horizon",), ("viewshed", "--from", "15,15,2"), ("trace", "rays.npy"):
            refused(1, "is also an input", command, "outer.vrt", *more, "-o", to)
