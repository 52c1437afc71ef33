# SPDX-License-Identifier: Apache-2.0
"""What the program says to bad input, and that it leaves nothing behind."""
import os
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from program import (PROGRAM, commands, end, entries, info, interrupted, only_hidden, needs_room, npy, rays, read, refused, run, shell, start,
                     wait_for_input, wait_for_output, write)

TRACE = "trace", "field.npy", "rays.npy"


@pytest.fixture(autouse=True)
def inputs(folder):
    np.save("field.npy", np.zeros((4, 5), np.float32))
    rays("rays.npy", [(2.25, 1.5, k + 1) for k in range(1000)])


def fails(status, part, *words, **setting):
    """And prints nothing."""
    assert refused(status, part, *words, **setting).out == ""


@pytest.mark.parametrize("part, words", [
    ("", ()),
    ("did you mean trace?", ("tarce",)),
    ("unknown option '--verbose'", ("--verbose",)),
    ("FIELD is missing", ("trace",)),
    ("RAYS.npy is missing", ("trace", "field.npy")),
    ("nothing to do", TRACE),
    ("'hits.npy' is one argument too many", (*TRACE, "hits.npy")),
    ("--output needs a value", (*TRACE, "-o")),
    ("--output needs a value", (*TRACE, "-o", "")),
    ("unknown option -x\nTry 'cellwalk trace --help'.\n", (*TRACE, "-x")),
    ("--kernal; did you mean --kernel?", (*TRACE, "--kernal=cell")),
    ("--json takes no value", (*TRACE, "--json=yes")),
    ("'celt' is unknown; did you mean cell?", (*TRACE, "--json", "--kernel", "celt")),
    ("there are default, moller-trumbore, watertight", (*TRACE, "--json", "--leaf", "woop")),
    ("scalar, sse4.2, avx2, avx512", (*TRACE, "--json", "--isa", "avx")),
    ("from 1 to 1048576, not '0'", (*TRACE, "--json", "--band", 0)),
    ("from 1 to 1048576, not '1048577'", (*TRACE, "--json", "--band", 1048577)),
    ("not '-1'", (*TRACE, "--json", "--threads", -1)),
    ("not 'two'", (*TRACE, "--json", "--threads", "two")),
    ("not '1.5'", (*TRACE, "--json", "--threads", "1.5")),
    ("not '4x'", (*TRACE, "--json", "--threads", "4x")),
    ("not '99999999999999999999'", (*TRACE, "--json", "--threads=99999999999999999999")),
    ("standard output cannot take both", (*TRACE, "-o", "-", "--json")),
    ("'b' is one argument too many", ("info", "a", "b")),
    ("CELLWALK_ISA 'sse' is unknown; there are scalar,", (*TRACE, "-o", "hits.npy", {"isa": "sse"})),
    ("CELLWALK_ISA '' is unknown; there are scalar,", (*TRACE, "-o", "hits.npy", {"isa": ""})),
    ("brute does not have the leaf test watertight", (*TRACE, "--json", "--kernel", "brute", "--leaf", "watertight"))])
def test_bad_command_lines(part, words):
    setting = words[-1] if words and isinstance(words[-1], dict) else {}
    done = run(*(words[:-1] if setting else words), **setting)
    assert done.status == 2 and part in done.err and done.out == "" and entries() == ["field.npy", "rays.npy"], done.err


def test_two_dashes_end_the_options():
    fails(1, "--json: cannot read", "info", "--", "--json")
    assert commands() == set(LINES)


LINES = {"info": (), "trace": ("rays.npy", "-o", "o.npy"), "shadow": ("--sun", "90,10", "-o", "o.npy"), "horizon": ("-o", "o.npy"),
         "sun": ("--date", "2024-06-21", "--lon-lat", "9,47", "--at", "1,1"), "viewshed": ("--from", "1,1", "-o", "o.npy"), "visibility": ("-o", "o.npy"),
         "los": ("1,1", "2,2"), "render": ("--size", "8x8", "-o", "o.png")}
# Options for which 0 is a number like others, by their help or by what they are.
ZEROS = {"--threads", "--nodata", "--start", "--facing", "--tilt", "--curvature", "--target-height", "--observer-height", "--min-distance",
         "--water", "--at"}


@pytest.mark.parametrize("command", LINES)
def test_zero_is_a_number_or_refused(command):
    """Never what stands for an option that is not given."""
    np.save("field.npy", np.arange(20, dtype=np.float32).reshape(4, 5))
    options = re.findall(r"^      (--[a-z-]+) [A-Z]+$|^      (--[a-z-]+) [A-Z]+  ", run(command, "--help").out, re.M)
    assert options and run(command, "field.npy", *LINES[command]).status == 0
    for option in {one or other for one, other in options} - {"--memory", "--co", "--table", "--profile"}:
        done = run(command, "field.npy", *LINES[command], option, 0)
        assert option in ZEROS if done.status == 0 else done.err.startswith("cellwalk"), (option, done.status, done.err)


def test_eyes_far_apart_take_no_more_memory():
    """One eye is the least; land of 40 x 50 samples asked for gigabytes. Where eyes are few, --memory reckons with the margins beside them."""
    np.save("field.npy", np.arange(2000, dtype=np.float32).reshape(40, 50) % 7)
    for every in 50, 1 << 20:
        assert run("visibility", "field.npy", "--every", every, "-o", f"{every}.npy", memory=0 if needs_room() else 300 << 20).status == 0
    assert read("50.npy") == read(f"{1 << 20}.npy")
    np.save("field.npy", np.zeros((1000, 1000), np.float32))
    words = "visibility", "field.npy", "--directions", 1, "-o", "o.npy"
    fails(1, "matter at once, which need --memory", *words, "--every", 500, "--memory", "90M")


def test_kernels_out_of_reach():
    assert run(*TRACE, "-o", "hits.npy", isa="scalar").status == 0
    if not any(kernel["name"] == "packet4" for kernel in info()["kernels"]):
        return  # a build without them
    packet = *TRACE, "--json", "--kernel", "packet4"
    fails(2, "--kernel packet4 needs sse4.2; this machine, or the limit set by --isa or CELLWALK_ISA, has scalar", *packet, isa="scalar")
    fails(2, "--kernel packet4 needs sse4.2", *packet, "--isa", "scalar")
    # The variable is an upper bound: no option lifts it.
    fails(2, "--isa sse4.2: this machine, or CELLWALK_ISA, allows no more than scalar", *TRACE, "--json", "--isa", "sse4.2", isa="scalar")


SEA = 'Shape "heightfield" "integer nu" [2] "integer nv" [2] "float Pz" [0 1 2 3]\n'


@pytest.mark.parametrize("name, made, part", [
    ("f8.npy", ("<f8", "(2, 8)", 128), "f8.npy: holds elements of type '<f8', not '<f4'"),
    ("seven.npy", ("<f4", "(2, 7)", 56), "seven.npy: shape (2, 7), but rays are (N, 8)"),
    ("flat.npy", ("<f4", "(16,)", 64), "flat.npy: shape (16,), but rays are (N, 8)"),
    ("huge.npy", ("<f4", "(1000000000, 8)", 64), "huge.npy: truncated: shape (1000000000, 8)"),
    (".", None, ".: cannot read: Is a directory"),
    ("/dev/null", None, "/dev/null: cannot read: not a regular file"),
    ("row.npy", ("<f4", "(1, 16)", 64), "row.npy: 16 x 1 samples: "),
    ("none.npy", ("<f4", "(0, 16)", 0), "none.npy: shape (0, 16) holds no samples"),
    ("cube.npy", ("<f4", "(2, 2, 4)", 64), "cube.npy: shape (2, 2, 4), but a raster is (rows, columns)"),
    ("bytes.npy", ("|u1", "(8, 8)", 64), "bytes.npy: holds elements of type '|u1'"),
    ("sea.pbrt", SEA, "cellwalk trace: sea.pbrt: "),
    ("absent.npy", None, "absent.npy: cannot read: No such file"),
    ("field", None, "cellwalk trace: field: ")])
def test_bad_rays_and_fields(name, made, part):
    """What is wrong with an array of rays, or with a field."""
    if isinstance(made, str):
        write(name, made)
    elif made:
        npy(name, *made[:2], bytes(made[2]))
    is_field = "field" in part or "samples" in part or "raster" in part or "|u1" in part or "pbrt" in part
    fails(1, part, "trace", *((name, "rays.npy") if is_field else ("field.npy", name)), "-o", "hits.npy")


# ---- outputs --------------------------------------------------------------------------------------------------------------


def test_full_disks():
    for output, why in ("/dev/full", "No space left on device"), ("absent/hits.npy", "No such file"), (".", "Is a directory"):
        fails(1, f"{output}: cannot write: {why}", *TRACE, "-o", output)
    write("hits.npy", "old")
    # A disk quota shows in the same way as this limit; the file that was there stays.
    fails(1, "hits.npy: cannot write: File too large", *TRACE, "-o", "hits.npy", file_size=8192)
    assert read("hits.npy") == b"old"
    fails(1, "No space left", *TRACE, "-o", "/dev/full", "--json")  # and no time is told of a run that failed


def test_directories_without_permission():
    os.mkdir("closed", 0o555)
    try:
        run("--version", powerless=True)
    except subprocess.SubprocessError:
        pytest.skip("root that may not give up its rights")
    fails(1, "closed/hits.npy: cannot write: Permission denied", *TRACE, "-o", "closed/hits.npy", powerless=True)
    # A file can be replaced wherever its directory may be written to; but its owner wants it to stay.
    write("hits.npy", "old")
    os.chmod("hits.npy", 0o444)
    fails(1, "hits.npy: cannot write: Permission denied", *TRACE, "-o", "hits.npy", powerless=True)


def test_inputs_as_outputs():
    """What is read is never replaced by what is written, by whatever name."""
    before = read("field.npy")
    os.link("field.npy", "again.npy")
    os.symlink("rays.npy", "same.npy")
    for name in "field.npy", "rays.npy", "./field.npy", "again.npy", "same.npy":
        fails(1, f"{name}: is also an input", *TRACE, "-o", name)
    assert read("field.npy") == before


def test_parts_of_a_scene_as_outputs():
    write("scene.pbrt", 'Camera "perspective"\nWorldBegin\nTexture "t" "color" "imagemap" "string filename" "image.exr"\n'
          'Material "matte" "texture Kd" "t"\nInclude "shape.exr"\nWorldEnd\n')
    write("shape.exr", SEA)
    write("image.pbrt", 'Camera "perspective"\nWorldBegin\nWorldEnd\n')
    if run("render", "image.pbrt", "-o", "image.exr").status == 0:  # with OpenEXR
        for output in "shape.exr", "image.exr":
            fails(1, "is also an input", "render", "scene.pbrt", "-o", output)


def test_standard_output_and_closed_streams():
    """A warning that cannot be shown lands in no file either."""
    assert shell("PROGRAM trace field.npy rays.npy -o - > piped.npy && PROGRAM trace field.npy rays.npy -o hits.npy").returncode == 0
    assert read("piped.npy") == read("hits.npy")
    done = shell("PROGRAM info > /dev/full")
    assert done.returncode != 0 and done.stderr == "cellwalk: cannot write to standard output: No space left on device\n"
    z = np.zeros((4, 5), np.float32)
    z[0, 0] = -9999
    np.save("warns.npy", z)
    done = shell("PROGRAM trace warns.npy rays.npy -o hits.npy")
    assert done.returncode == 0 and "-9999" in done.stderr
    for closed in "<&- 2>&-", ">&- 2>&-", "<&- >&- 2>&-", "2>&-":
        assert shell(f"PROGRAM trace warns.npy rays.npy -o again.npy {closed}").returncode == 0
        assert read("again.npy") == read("hits.npy"), closed


# ---- endings --------------------------------------------------------------------------------------------------------------


@pytest.fixture
def minutes():
    """A query by brute force that takes so long."""
    np.save("large.npy", np.zeros((1000, 1000), np.float32))
    rays("many.npy", np.tile([5.5, 5, 1], (100000, 1)))
    return "trace", "large.npy", "many.npy", "-o", "hits.npy", "--kernel", "brute"


def test_killed_programs_leave_no_result(minutes):
    before = entries()
    process = start(*minutes)
    wait_for_output(process)
    process.kill()
    assert end(process).status == 128 + signal.SIGKILL
    only_hidden(before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interruptions_leave_nothing(minutes, number):
    assert "interrupted" in interrupted(*minutes, "--threads", 2, signals=[number]).err


def test_interruptions_do_not_wait(minutes):
    """And a second one is the end."""
    assert "interrupted" in interrupted(*minutes, input="many.npy").err  # rays are read for the query that traces them
    interrupted(*minutes, signals=[signal.SIGINT, signal.SIGTERM])


CONTAINER = """
import ctypes, os, signal, sys, time
if ctypes.CDLL(None).unshare(0x30000000) != 0:  # CLONE_NEWUSER and CLONE_NEWPID
    sys.exit("no namespaces")
process = os.spawnv(os.P_NOWAIT, sys.argv[1], sys.argv[1:])
while not any(name.endswith(".tmp") for name in os.listdir()):
    time.sleep(0.01)
os.kill(process, signal.SIGINT)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]))
"""


def test_the_first_process_of_a_container_ends_too(minutes):
    """The system keeps a signal from it that it sends to itself."""
    before = entries()
    done = subprocess.run([sys.executable, "-c", CONTAINER, PROGRAM, *minutes], stderr=subprocess.PIPE, text=True)
    if "no namespaces" in done.stderr:
        pytest.skip("no namespaces")
    assert done.returncode == 128 + signal.SIGINT and done.stderr == "cellwalk: interrupted\n" and entries() == before


def test_interruptions_while_reading():
    """Here four million numbers of many digits."""
    write("text.asc", "ncols 2000\nnrows 2000\ncellsize 1\n" + "1.2345678901234567890123456789 " * 4000000)
    process = start("info", "text.asc")
    wait_for_input(process, "text.asc")
    process.terminate()
    assert end(process).status == 128 + signal.SIGTERM
