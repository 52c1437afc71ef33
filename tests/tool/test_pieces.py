# SPDX-License-Identifier: Apache-2.0
"""Rasters larger than memory, by bands: the same bits as in one piece, with another instruction set, and threads. ../python/test_products.py has
windows."""
import numpy as np
import pytest
from program import array, asc, library, needs, on_map, refused, sets, taken, takes, vrt

NX, NY = 300, 260
UTM, DEGREES = on_map(32632, 600000, 10, 0, 5200000, 0, -10), on_map(4326, 7, 0.0003, 0, 47, 0, -0.0002)
TURNED = on_map(32632, 600000, 8, 6, 5200000, 6, -8)
MAPS = {"land.npy": "1500,1450,10", "utm.vrt": "601505,5198995,10", "degrees.vrt": "7.0452,46.9799,10"}  # and a place


@pytest.fixture(autouse=True)
def land(folder):
    """Hills, holes, and a peak in the northwest that throws long shadows."""
    y, x = np.mgrid[:NY, :NX]
    z = 120 + 60 * np.sin(x / 9) * np.cos(y / 13) + 25 * np.sin((x + 2 * y) / 5) + np.maximum(900 - 25 * np.hypot(x - 20, y - 15), 0)
    z[101:130, 141:150] = np.nan
    z = z.astype(np.float32)
    np.save("land.npy", z)
    asc("land.txt", z)
    for name, place in ("utm.vrt", UTM), ("degrees.vrt", DEGREES), ("turned.vrt", TURNED):
        vrt(name, "land.txt", z.shape, place)


def product(file, command, *words, **setting):
    return array(command, file, *words, *(("--cellsize", 10) if file.endswith(".npy") else ()), **setting)


def same(file, words, *more, at=np.s_[...], whole=None):
    """The product with more words is that part of the one without."""
    whole, part = product(whole or file, *words)[at], product(file, *words, *more, "--threads", 3, isa=sets()[len(words) % 2 - 1])
    assert whole.dtype == part.dtype and whole.shape == part.shape and whole.tobytes() == part.tobytes(), (file, words)


def test_bands():
    """So little memory that each band has 32 rows, or a few more."""
    for m, file in enumerate([*MAPS, "turned.vrt"] if library("GDAL") else ["land.npy"]):
        for k, words in enumerate([("shadow", "--sun", "340,35"), ("shadow", "--sun", "5,30", "--hillshade"), ("shadow", "--sun", "200,60", "--sun-disc"),
                                   ("shadow", "--sun", "45,89", "--disc", 4), ("horizon", "--svf", "--max-distance", 300),
                                   ("visibility", "--longest", "--max-distance", 100), ("visibility", "--every", 3, "--directions", 3, "--max-distance", 100)]):
            if ((m + k) % 2 == 0 or m == 0) and takes((m + k) // 2, 6):
                same(file, words, "--memory", "6M" if "--every" in words else "2.4M")


DAY = "sun", "--date", "2024-06-21", "--step", "6h", "--lon-lat", "7,47"


@pytest.fixture
def strip():
    """A long strip with ridges, seen over more than two blocks of 256 rows, in which a curvature of 100 and more earths bounds how far there
    is to see."""
    y, x = np.mgrid[:3300, :40]
    ridge = 400 - 40 * np.abs((y + 200) % 900 - 450)  # row 250, 1150 and so on
    np.save("strip.npy", (200 + 8 * np.sin(y / 9) * np.cos(x / 5) + np.maximum(ridge, 0)).astype(np.float32))


def test_far_horizons(strip):
    """Bands that are proved by the raster's own highest and lowest samples."""
    for words in taken([("horizon", "--directions", 4, "--curvature", 1000), ("horizon", "--directions", 5, "--svf", "--curvature", 100),
                        ("horizon", "--directions", 4, "--svf-tilted", "--curvature", 100), DAY,
                        (*DAY, "--directions", 8, "--irradiance", "--sky", 4, "--curvature", 100)], 3):
        same("strip.npy", words, "--memory", "3.9M")


def test_horizons_below_the_level():
    """Down stairs, of a height for each block of 256 rows: the horizon is often on a step that is lower and farther than one that bounds it."""
    for seed in taken(range(60), 10):
        r = np.random.default_rng([5, seed])
        drops = r.exponential(20, 8) * r.choice([1, 1, 0.1, -0.5], 8)
        z = np.repeat(500 - np.cumsum(drops), 256)[:, None] + np.where(r.random() < 0.5, r.uniform(0, 3, (2048, 30)), 0)
        z[:256] += np.where(np.arange(256) % 50 == 49, r.exponential(50), 0)[:, None]
        np.save("stairs.npy", z.astype("f4"))
        # Rows 150 to 255 of the northernmost block.
        same("stairs.npy", ("horizon", "--directions", 4, "--curvature", [0, 30][seed % 2]), "--window", "0,17920,290,18970", at=np.s_[..., 150:256, :])


@pytest.mark.parametrize("why, command, words", [
    # On a flat earth summits see all of it.
    ("40 x 3300 samples matter at once, which need --memory 5M or more; there is 2M", "horizon", ("--memory", "2M")),
    ("samples matter at once", "horizon", ("--memory", "1M", "--curvature", 100)),
    ("40 x 3300 samples matter at once", "sun", (*DAY[1:], "--memory", "2M", "--irradiance"))])
def test_bands_that_would_be_too_large(strip, why, command, words):
    refused(1, why, command, "strip.npy", "--cellsize", 10, "-o", "no.npy", *words)


# Samples 10 m apart on UTM's map, 10.004 on the ground, from (150, 100); or 0.0003 and 0.0002 degrees, 22.8 and 22.2 m.
@pytest.mark.parametrize("file, distance, side", [("utm.vrt", 600.3, 60), ("degrees.vrt", 600, 26)])
def test_near_views(file, distance, side):
    """The output is as near as --max-distance, and what the full raster has there; elsewhere there is nothing."""
    needs("GDAL")
    words = "viewshed", "--from", MAPS[file], "--max-distance", distance
    near = np.s_[100 - side:101 + side, 150 - side:151 + side]
    for more in taken([(), ("--needed",), ("--needed", "--curvature", 0)], 3):
        whole, part = product(file, *words, *more, "--window=-1e9,-1e9,1e9,1e9"), product(file, *words, *more)
        assert whole[near].tobytes() == part.tobytes()
        if not more:
            whole[near] = 0
            assert np.isin(whole, (0, 255)).all()


def test_huge():
    """4 10^10 samples, of which the land is a small part in the middle, and the rest holes."""
    needs("GDAL")
    vrt("huge.vrt", "land.txt", (NY, NX), on_map(None, 0, 10, 0, 0, 0, -10), (200000, 200000), 100032)
    vrt("small.vrt", "land.txt", (NY, NX), on_map(None, 1000320, 10, 0, -1000320, 0, -10))
    memory = "--memory", "60M"
    shadow, view = ("shadow", "--sun", "315,12"), ("viewshed", "--from", "1001825,-1001325,10", "--max-distance", 600)
    same("huge.vrt", shadow, "--window", "1001320,-1001620,1002320,-1001170", *memory, at=np.s_[85:130, 100:200], whole="small.vrt")
    same("huge.vrt", view, *memory, whole="small.vrt")
