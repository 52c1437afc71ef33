# SPDX-License-Identifier: Apache-2.0
"""GDAL where threads or memory are short, for each subcommand and for GeoTIFF read and written: the program ends, with the same result as ever or
without one. GDAL would wait for ever for a thread that the system refuses."""
import re
import signal

import numpy as np
import pytest
from program import PRELOAD, needs, rays, rough, run, take, well

# dem.tif is compressed, and results of four bands are large enough for threads that compress.
HORIZON = "horizon", "dem.tif", "--max-distance", 20, "--directions"
COMMANDS = [("info", "dem.tif"), ("trace", "dem.tif", "rays.npy", "-o", "out.npy"), ("shadow", "dem.tif", "--sun", "90,10", "-o", "out.tif"),
            ("sun", "dem.tif", "--lon-lat", "9,47", "--date", "2024-06-21", "--step", "6h", "-o", "out.tif"), (*HORIZON, 4, "-o", "out.tif"),
            (*HORIZON, 4, "--threads", 1, "-o", "out.tif"), (*HORIZON, 4, "--cog", "-o", "out.tif"), (*HORIZON, 1, "--co=NUM_THREADS=7", "-o", "out.tif"),
            ("viewshed", "dem.tif", "--from", "500,500,50", "-o", "out.tif"),
            ("visibility", "dem.tif", "--directions", 2, "--every", 64, "--max-distance", 20, "-o", "out.tif"),
            ("los", "dem.tif", "500,500,50", "600,600,50"), ("render", "dem.tif", "--size", "8x8", "-o", "out.png")]
SECONDS = 60  # a run takes one; only one that hangs is ended by the alarm


@pytest.fixture(autouse=True)
def inputs(folder):
    needs("GDAL")
    np.save("rough.npy", rough(1025) / 100)
    rays("rays.npy", (3.3, 1.5, 1e4))
    well("horizon", "rough.npy", "--cellsize", 1, "--directions", 1, "-o", "dem.tif")


def result(words):
    return take(words[-1]) if "-o" in words else None


def expected(words):
    done = run(*words)
    assert done.status == 0 or "no library" in done.err, done.err  # for .png
    return result(words)


def ends(words, wanted, what, **setting):
    """Whether all went well."""
    done = run(*words, seconds=SECONDS, **setting)
    got = result(words)
    assert done.status != 128 + signal.SIGALRM, (words, what, "hangs")
    # GDAL and libraries behind it end a process that has no memory by a signal, also while they are loaded.
    assert done.status in (0, 1, 128 + signal.SIGABRT, 128 + signal.SIGSEGV), (words, what, done.status, done.err)
    assert got == (wanted if done.status == 0 else None), (words, what, done.status)
    return done.status == 0


def test_few_threads():
    for words in COMMANDS:
        wanted = expected(words)
        for limit in range(8) if words[0] == "horizon" else (0, 7):
            good = ends(words, wanted, limit, env={"LD_PRELOAD": PRELOAD, "CELLWALK_THREADS": str(limit)})
            assert good or limit < 7 or (wanted is None and "-o" in words), (words, limit)


def test_little_memory():
    ended = [0, 0]
    for c, words in enumerate(COMMANDS):
        wanted = expected(words)
        for k in range(-c % 8, 24, 8):
            ended[ends(words, wanted, k, memory=(120 + 12 * k) << 20)] += 1
    print(f"{ended[0]} runs ended without a result, {ended[1]} with it")
    assert ended[0] > 0


def test_all_commands_are_tried():
    """A new subcommand has to have its line above."""
    listed = re.search(r"Commands:\n((?:  .*\n)+)", run("--help").out).group(1)
    assert {line.split()[0] for line in listed.splitlines()} == {words[0] for words in COMMANDS}
