# SPDX-License-Identifier: Apache-2.0
"""Every subcommand on a terminal, with names, options and files that hold commands to it: nothing but text arrives there."""
import contextlib
import os
import pty
import re
import subprocess
import unicodedata

import numpy as np
import pytest
from program import PROGRAM, SOURCE, commands, rays, run, takes, write

# ESC with a title, C1 in UTF-8 (CSI, NEL), a bare C1 byte, text turned round, DEL, CR, a line's end.
HOSTILE = b"\33]0;t\7\33[31m\302\233m\302\205\233\342\200\256\342\201\246\177\r\n"
LOCAL = b'LOCAL_CS["' + HOSTILE + b'",UNIT["metre",1]]'
FIELDS = [HOSTILE + b".npy", b"no" + HOSTILE + b".npy", HOSTILE + b".asc", HOSTILE + b".pbrt", b"word.asc", b"crs.vrt", b"source.vrt",
          HOSTILE + b".h5", HOSTILE + b".nc", b"no" + HOSTILE + b".tif", b"word.npy", b"url.vrt"]
COMMANDS = [  # @ stands for each of the fields
    "info @", "info @ --coarser 2", "info @ --json", "trace @ rays.npy --user -o out.npy", "trace z.npy @ -o out.npy",
    "shadow @ --sun 90,10 -o out.npy", "shadow @ --time 2024-06-21T12:00Z --lon-lat 9,47 -o out.npy",
    "sun @ --date 2024-06-21 --lon-lat 9,47 --step 6h -o out.npy", "horizon @ --directions 4 -o out.npy", "viewshed @ --from 1,1,2 -o out.npy",
    "viewshed z.npy --observers @ -o out.npy", "horizon z.npy --places @", "visibility @ --directions 4 -o out.npy", "los @ 1,1,2 2,2,2", "los z.npy --pairs @ -o out.csv",
    "render @ --size 8x8 -o out.png"]


def vrt(crs, source):
    return (b'<VRTDataset rasterXSize="3" rasterYSize="3"><SRS>' + crs + b"</SRS><GeoTransform>0,1,0,3,0,-1</GeoTransform>"
            b'<VRTRasterBand dataType="Float32" band="1"><UnitType>' + HOSTILE + b"</UnitType><SimpleSource><SourceFilename>" + source
            + b"</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>")


@pytest.fixture(autouse=True)
def inputs(folder):
    z = np.array([[0, 1, 2], [3, 9, 3], [2, 1, 0]], np.float32)
    np.save("z.npy", z)
    rays("rays.npy", (1.3, 1.5, 1e4))
    for name, text in {HOSTILE + b".npy": open("z.npy", "rb").read(), HOSTILE + b".asc": b"ncols 3\nnrows 3\ncellsize 1\n0 1 2\n3 9 3\n2 1 0\n",
            b"word.asc": b"ncols 3\nnrows 3\ncellsize 1\n0 1 2\n3 " + HOSTILE + b"x\n",
            b"word.npy": b"\x93NUMPY\1\0\x40\0{'descr': '" + HOSTILE + b"', 'fortran_order': False, 'shape': (3, 3), }\n",
            HOSTILE + b".pbrt": b'Shape "' + HOSTILE + b'" "float ' + HOSTILE + b'" [0]\n' + HOSTILE + b"\n",
            b"crs.vrt": vrt(LOCAL, HOSTILE + b".asc"), b"source.vrt": vrt(LOCAL, b"no" + HOSTILE + b".tif"),
            b"url.vrt": vrt(b"", b"NETCDF:&quot;http://nowhere.invalid/" + HOSTILE + b"&quot;:" + HOSTILE),
            HOSTILE + b".h5": b"\211HDF\r\n\32\n\2\10\10\0" + 3 * HOSTILE, HOSTILE + b".nc": b"CDF\1\0\0\0\0" + 2 * HOSTILE,
            b"o.csv": b"x,y," + HOSTILE + b"\n1," + HOSTILE + b",2\n", HOSTILE + b".csv": b"x,y,height,name\n1,1,2," + HOSTILE + b"\n99,99,2,b\n",
            HOSTILE + b".geojson": b'{"type":"FeatureCollection","features":[{"type":"Feature","geometry":null,' + HOSTILE}.items():
        write(os.fsdecode(name), text)


def shown(*words, **env):
    """Exit status, and what arrives at a terminal. Reading fails when the program has ended, which alone has the other side."""
    terminal, side = pty.openpty()
    environment = {"ASAN_OPTIONS": "symbolize=0:detect_leaks=0", **os.environb, **{k.encode(): v for k, v in env.items()}}
    process, parts = subprocess.Popen(["timeout", "--foreground", "60", PROGRAM, *words], stdin=side, stdout=side, stderr=side, env=environment), []
    os.close(side)
    with contextlib.suppress(OSError):
        while True:
            parts.append(os.read(terminal, 1 << 16))
    os.close(terminal)
    return process.wait(), b"".join(parts)


def check_text(*words, **env):
    """Whether hostile text arrived without its commands. A line of progress comes by the clock: "\\r", text, and "\\33[K", which clears the rest."""
    status, bytes = shown(*words, **env)
    bytes = re.sub(rb"\r[^\x00-\x1f\x7f]*\x1b\[K", b"", bytes)
    text = bytes.decode().replace("\r\n", "\n")  # text in UTF-8; the terminal makes "\r\n" of a line's end
    assert status in (0, 1, 2) and (status == 0 or text), (words, status)
    odd = [c for c in text if c != "\n" and unicodedata.category(c) in ("Cc", "Cf", "Cs", "Co", "Zl", "Zp")]
    assert not odd, (words, odd, text)
    if status != 0:  # all lines are the program's, and none is a library's
        assert all(line.startswith(("cellwalk", "Try '", "sun at")) for line in text.splitlines()), text
    return "0;t?" in text


def test_fields_of_every_kind():
    """The first commands with each field, the others, which open it in the same way, with every second one by turns."""
    assert commands() == {command.split()[0] for command in COMMANDS}
    masked = 0
    for c, command in enumerate(COMMANDS):
        for f, field in enumerate(FIELDS):
            if c < 3 or ((c + f) % 2 == 0 and takes((c * len(FIELDS) + f) // 2, 3)):
                masked += check_text(*(field if word == "@" else word.encode() for word in command.split()))
    assert masked > len(COMMANDS) * len(FIELDS) / 8


def test_options_and_outputs():
    check_text(HOSTILE, "x")
    check_text(b"--" + HOSTILE, "x")
    check_text("info", "z.npy", HOSTILE)
    for table in b"o.csv", HOSTILE + b".csv", HOSTILE + b".geojson":
        check_text("viewshed", "z.npy", "--observers", table, "-o", "out.npy")
        check_text("los", "z.npy", "--pairs", table, "-o", "out.csv")
    named = b'name,x,y,x1,y1,x2,y2\n"A ' + HOSTILE[:-2] + b'",1,1,1,1,2,2\nB,1,1.5,1,1,2,1\n'
    write("named.csv", named)
    for words in (("viewshed", "z.npy", "--observers", "named.csv", "--table", "-", "-o", "out.npy"), ("horizon", "z.npy", "--places", "named.csv"),
                  ("los", "z.npy", "--pairs", "named.csv")):
        assert b"A " in shown(*words)[1]
        check_text(*words)
    tried = set()  # an option is the same in each command that has it
    for name in sorted({command.split()[0] for command in COMMANDS}):
        check_text(name, "z.npy", b"--" + HOSTILE)
        check_text(name, "z.npy", "--threads", HOSTILE)
        check_text(name, "z.npy", "--sun", HOSTILE, "--from", HOSTILE, "-o", HOSTILE + b".xyz")
        for k, option in enumerate(re.findall(r"^      (--[a-z-]+) [A-Z]", run(name, "--help").out, re.M)):
            if option not in tried and takes(k, 8):
                tried.add(option)
                check_text(name, "z.npy", option, HOSTILE, "-o", "out.npy")
        check_text(name, "z.npy", "--nodata", HOSTILE, "-o", b"none" + HOSTILE + b"/out.npy")
    for words in ("info", "--json"), ("info", "z.npy"):
        check_text(*words, CELLWALK_ISA=HOSTILE)


def test_one_place_writes_messages():
    """These files write to standard error: that place, usage and progress."""
    found = [f"{folder}/{name}" for part in ("tool", "ground", "io", "scene", "terrain", "base") for folder, _, names in os.walk(f"{SOURCE}/src/{part}")
             for name in names if name.endswith(".c") and re.search(r"[(,] *stderr *[,)]|perror *\(", open(f"{folder}/{name}").read())]
    assert sorted(os.path.relpath(name, f"{SOURCE}/src") for name in found) == ["tool/options/command.c", "tool/options/options.c"]
