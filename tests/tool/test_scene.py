# SPDX-License-Identifier: Apache-2.0
"""The program's render command from outside: exit statuses, messages, and what it leaves behind."""
import os
import signal

import pytest
from program import exr, interrupted, library, read, refused, run, well, write

WORLD = """LookAt 0 0 0 0 0 1 0 1 0
Camera "perspective"
WorldBegin
LightSource "point" "color I" [9 9 9]
Translate -1 -1 2
Scale 2 2 1
Shape "heightfield" "integer nu" 2 "integer nv" 2 "float Pz" [0 0 .3 0]
WorldEnd
"""


@pytest.fixture(autouse=True)
def scene(folder):
    write("scene.pbrt", 'Film "image" "integer xresolution" 40 "integer yresolution" 30\n' + WORLD)


def test_pictures():
    assert run("render", "scene.pbrt", "-o", "a.exr").status == 0
    rgb = exr("a.exr")
    assert rgb.shape == (30, 40, 3) and rgb[15, 20, 0] > 0.1
    assert run("render", "scene.pbrt", "-o", "b.exr", "--threads", 1).status == 0 and read("a.exr") == read("b.exr")


def test_a_crop_of_a_size_is_a_part_of_it():
    for name, *words in ("whole.exr", "--size", "80x60"), ("part.exr", "--size=80x60", "--crop", "30,20,50,41"):
        assert run("render", "scene.pbrt", "-o", name, *words).status == 0
    whole, part = map(exr, ("whole.exr", "part.exr"))
    assert whole.shape == (60, 80, 3) and part.shape == (21, 20, 3) and (part == whole[20:41, 30:50]).all()


def test_quiet_means_no_warning():
    write("odd.pbrt", 'Film "image" "integer xresolution" 4 "integer yresolution" 4\nAccelerator "grid"\nCamera "perspective"\nWorldBegin\nWorldEnd\n')
    done = run("render", "odd.pbrt", "-o", "odd.exr")
    assert done.status == 0 and "warning: " in done.err
    well("render", "odd.pbrt", "-o", "odd.exr", "--quiet")


SIZES = "80", "80x", "x60", "80x0", "0x60", "80x60x", "-80x60", " 80x60", "80x65537"
CROPS = "1,2,3", "1,2,3,4,", "3,2,3,4", "1,4,3,4", "1 2 3 4", "0,0,99999999999999999999,9"


@pytest.mark.parametrize("status, why, words", [
    (1, "missing.pbrt: cannot read: No such file", ("missing.pbrt", "-o", "b.exr")),
    (1, "broken.pbrt:1: WorldBegin: no Camera", ("broken.pbrt", "-o", "b.exr")),
    (2, "-o IMAGE is missing", ("scene.pbrt",)),
    (2, "unknown kind of picture", ("scene.pbrt", "-o", "b.jpeg")),
    (1, "cannot write: No such file", ("scene.pbrt", "-o", "none/b.exr")),
    (2, "'nothing' is unknown", ("scene.pbrt", "-o", "b.exr", "--kernel", "nothing")),
    (2, "samples", ("scene.pbrt", "-o", "b.exr", "--samples", 0)),
    *((2, "not a width and a height", ("scene.pbrt", "-o", "b.exr", "--size", size)) for size in SIZES),
    *((2, "not X0,Y0,X1,Y1", ("scene.pbrt", "-o", "b.exr", "--crop", crop)) for crop in CROPS),
    (1, "no part of 40 x 30 pixels", ("scene.pbrt", "-o", "b.exr", "--crop", "0,0,41,30"))])
def test_mistakes_leave_nothing(status, why, words):
    write("broken.pbrt", "WorldBegin")
    refused(status, why, "render", *words)


def test_a_full_disk_is_a_failure():
    os.symlink("/dev/full", "full.exr")
    refused(1, "full.exr: cannot write: No space left on device", "render", "scene.pbrt", "-o", "full.exr")


@pytest.mark.parametrize("name, needed", [("d.png", "libpng"), ("d.exr", "OpenEXR")])
def test_a_picture_that_does_not_fit_leaves_nothing(name, needed):
    """Which shows while it is being put into its file, not only when that is closed."""
    if not library(needed):
        pytest.skip(f"this build lacks {needed}")
    refused(1, name, "render", "scene.pbrt", "-o", name, file_size=64)  # less than any of them takes


def test_ctrl_c_leaves_nothing():
    """Minutes of work, unless it is stopped as soon as its output is open."""
    done = interrupted("render", "scene.pbrt", "-o", "c.exr", "--samples", 65536)
    assert done.status == 128 + signal.SIGINT
