# SPDX-License-Identifier: Apache-2.0
"""GDAL where threads or memory are short, for each subcommand and for GeoTIFF read and written: the program ends, with the same result as ever or
without one. GDAL would wait for ever for a thread that the system refuses."""
import functools
import signal

import numpy as np
import pytest
from program import PRELOAD, commands, needs, rays, refused, rough, run, take, taken, well, write

# Inputs are compressed. Four bands of large.tif are so many bytes that the program starts threads to compress them.
HORIZON = "horizon", "dem.tif", "--max-distance", 20, "--directions"
COMMANDS = [("info", "dem.tif"), ("trace", "dem.tif", "rays.npy", "-o", "out.npy"), ("shadow", "dem.tif", "--sun", "90,10", "-o", "out.tif"),
            ("sun", "dem.tif", "--lon-lat", "9,47", "--date", "2024-06-21", "--step", "6h", "-o", "out.tif"), (*HORIZON, 4, "--threads", 1, "-o", "out.tif"),
            ("horizon", "large.tif", "--max-distance", 4, "--directions", 4, "-o", "out.tif"),
            (*HORIZON, 1, "--cog", "--co=NUM_THREADS=7", "-o", "out.tif"), (*HORIZON, 1, "--co=NUM_THREADS=7", "-o", "out.tif"),
            ("viewshed", "dem.tif", "--from", "100,100,50", "-o", "out.tif"),
            ("visibility", "dem.tif", "--directions", 2, "--every", 64, "--max-distance", 20, "-o", "out.tif"),
            ("los", "dem.tif", "100,100,50", "200,200,50"), ("render", "dem.tif", "--size", "8x8", "-o", "out.png")]


@pytest.fixture
def inputs(folder):
    needs("GDAL")
    rays("rays.npy", (3.3, 1.5, 1e4))
    for name, side in (("dem", 257), ("large", 1025)):
        np.save("rough.npy", rough(side) / 100)
        well("horizon", "rough.npy", "--cellsize", 1, "--directions", 1, "--max-distance", 4, "-o", f"{name}.tif")


def result(words):
    return take(words[-1]) if "-o" in words else None


@functools.cache
def expected(words):
    done = run(*words)
    assert done.status == 0 or "no library" in done.err, done.err  # for .png
    return result(words)


def samples(tiff):
    """Of the raster and its smaller copies: short of memory, GDAL writes tiles in another order."""
    import rasterio
    if not tiff or tiff[:2] != b"II":
        return tiff
    with rasterio.MemoryFile(tiff) as memory, memory.open() as file:
        copies = [rasterio.open(memory.name, overview_level=k) for k in range(len(file.overviews(1)))]
        return [level.read().tobytes() for level in (file, *copies)]


def ends(words, what, **setting):
    """Whether all went well."""
    wanted, done = expected(words), run(*words, **setting)
    # GDAL and libraries behind it abort a process that has no memory, also while they are loaded. A wrong access would be the program's.
    assert done.status in (0, 1, 128 + signal.SIGABRT), (words, what, done.status, done.err)
    got = result(words)
    assert got == wanted or samples(got) == samples(wanted) if done.status == 0 else got is None, (words, what, done.status)
    return done.status == 0 or (wanted is None and "-o" in words)


def test_few_threads(inputs):
    assert commands() == {words[0] for words in COMMANDS}
    for words in taken(COMMANDS, 4):
        for limit in range(8) if "--co=NUM_THREADS=7" in words else (0, 1, 3, 7) if "large.tif" in words else (0, 7):
            assert ends(words, limit, env={"LD_PRELOAD": PRELOAD, "CELLWALK_THREADS": str(limit)}) or limit < 7, (words, limit)


def test_samples_without_room(inputs):
    """Floats are read into their place, and numbers of other types are converted."""
    for kind in "Float32", "Float64":
        write("huge.vrt", f'<VRTDataset rasterXSize="30000" rasterYSize="30000"><VRTRasterBand dataType="{kind}" band="1"/></VRTDataset>')
        refused(1, "out of memory for 30000 x 30000 samples", "trace", "huge.vrt", "rays.npy", "-o", "out.npy", memory=2 << 30)


def test_little_memory(inputs):
    ended = [0, 0]
    for c, words in taken(list(enumerate(COMMANDS)), 4):
        # Threads that are asked for by name end in GDAL where address space is short, or do not end.
        words = tuple("large.tif" if word == "dem.tif" else word for word in words if word != "--co=NUM_THREADS=7")
        k = c if c % 2 else 23 - c
        ended[ends(words, k, memory=(168 + 8 * k) << 20)] += 1  # GDAL itself takes 175 MB
    assert all(ended), f"{ended[0]} runs ended without a result, {ended[1]} with it"
