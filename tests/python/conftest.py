# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python module share: the program to compare with, and fields on maps of some kinds."""
import locale
import os
from types import SimpleNamespace

import numpy as np
import pytest
from program import DIVISOR, TURN, run

import cellwalk as cw

if "CELLWALK_TEST_COMMA" in os.environ:  # a locale
    locale.setlocale(locale.LC_ALL, os.environ["CELLWALK_TEST_COMMA"])
    assert locale.localeconv()["decimal_point"] == ","
UTM = 'EPSG:32632'


def share(examples):
    """How many of them Hypothesis tries, as test_share of ../support/check.h."""
    return max(examples // DIVISOR, 10)


def pytest_collection_modifyitems(items):
    """Words of the program are tried on the plain ground and on one of the others, by turns: it is GDAL's start that takes time. Of
    a test's cases one in four or less is taken where all have run elsewhere, as test_takes of ../support/check.h says."""
    tests, lines = {}, {}
    for item in items:
        words, ground = (getattr(item, "callspec", None) and item.callspec.params.get(name) for name in ("words", "ground"))
        if words and ground and ground != GROUNDS[0]:
            if (lines.setdefault(words, len(lines)) + GROUNDS.index(ground)) % (len(GROUNDS) - 1):
                continue
        tests.setdefault(item.nodeid.split("[")[0], []).append(item)
    items[:] = [item for number, cases in enumerate(tests.values()) for k, item in enumerate(cases)
                if (k + number + TURN) % min(DIVISOR, 4, len(cases)) == 0]


def rough(rows=61, columns=83, seed=1, holes=True):
    """Hills with noise, some holes."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[0:rows, 0:columns]
    z = (8 * np.sin(x / 9) * np.cos(y / 7) + random.normal(0, 0.6, (rows, columns))).astype(np.float32)
    if holes:
        z[random.random(z.shape) < 0.01] = np.nan
        z[10:13, 20:27] = np.nan
    return z


def random_rays(field, n, seed=2, dtype=np.float64):
    """Rays of all kinds across the field's bounds, (n, 8): some start inside, some are vertical, some miss."""
    random = np.random.default_rng(seed)
    x0, y0, x1, y1 = field.bounds
    low, high = (float(np.float64(v(field.z[np.isfinite(field.z)])) * field.map[2, 2] + field.map[2, 3]) for v in (np.min, np.max))
    span = np.array([x1 - x0, y1 - y0, high - low + 1])
    centre = np.array([(x0 + x1) / 2, (y0 + y1) / 2, (low + high) / 2])
    rays = np.empty((n, 8))
    rays[:, 0:3] = centre + span * random.uniform(-0.7, 0.7, (n, 3))
    rays[:, 4:7] = centre + span * random.uniform(-0.5, 0.5, (n, 3)) - rays[:, 0:3]
    rays[::7, 4:6] = 0
    rays[:, 3] = random.uniform(-0.5, 0.5, n)
    rays[:, 7] = random.uniform(0.2, 3, n)
    rays[::5, 3], rays[::5, 7] = 0, np.inf
    return rays.astype(dtype)


def tool(*words, fails=False):
    """The program is run, which must succeed, or must fail: standard output, or what is said of the failure."""
    done = run(*words)
    assert (done.status != 0) == fails, (words, done.err)
    return done.err if fails else done.out


class Places:
    """Of the terrain, as both are given them."""

    def __init__(self, ground):
        f, plain = ground.field, ground.path.suffix == ".npy"
        x0, y0, x1, y1 = f.bounds
        self.xs = np.array([x0 + share * (x1 - x0) for share in (0.37, 0.8, 0.5)])
        self.ys = np.array([y0 + share * (y1 - y0) for share in (0.61, 0.2, 0.45)])
        self.side = [(x0 + s * (x1 - x0), y0 + t * (y1 - y0)) for s, t in ((0.5137, 0.4561), (0.7913, 0.2039))]
        self.far, self.near = (12.5, 4.0) if plain else (410.0, 120.0)
        # The program has the first row of a file without a map in the north, and y counts from the last.
        self.northward = (lambda y: f.shape[0] - 1 - y) if plain else (lambda y: y)
        self.known, self.beyond = not plain, (x1 + 0.2 * (x1 - x0), y1)
        self.at = [f"{x!r},{self.northward(y)!r}" for x, y in zip(self.xs.tolist(), self.ys.tolist())]

    def spot(self, k, *height):
        return (float(self.xs[k]), float(self.ys[k]), *height)

    def inside(self, f):
        """Samples on the right of a line, and so inside what files() writes."""
        x, y = np.moveaxis(np.mgrid[:f.shape[1], :f.shape[0]].T @ f.map[:2, :2].T + f.map[:2, 3], -1, 0)
        (ax, ay), (bx, by) = self.side
        return (bx - ax) * (y - ay) < (by - ay) * (x - ax)

    def words(self, text):
        return text.format(a=self.at[0], b=self.at[1], c=self.at[2], far=self.far, near=self.near).split()

    def window(self, f, part):
        """A part of the rows and columns as the program takes it."""
        (x0, x1), (y0, y1) = f.map[:2, :2] @ [[part[1].start, part[1].stop - 1], [part[0].start, part[0].stop - 1]] + f.map[:2, 3:]
        low, high = sorted((self.northward(y0), self.northward(y1)))
        return f"--window={x0!r},{low!r},{x1!r},{high!r}"


GROUNDS = "plain", "utm", "turned", "degrees", "mercator"


@pytest.fixture(scope="session", params=GROUNDS)
def ground(request, tmp_path_factory):
    """The same terrain as a file and as a field."""
    folder = tmp_path_factory.mktemp(request.param)
    z = rough()
    if request.param == "plain":
        path = folder / "dem.npy"
        np.save(path, z)
        return SimpleNamespace(path=path, field=cw.Field(z))
    transform = {"utm": PLACE, "turned": (25, 5, 600000, 4, -28, 5200000), "degrees": (1 / 1200, 0, 10.5, 0, -1 / 1200, 47.25),
                 "mercator": (40, 0, 1.2e6, 0, -40, 5.95e6)}[request.param]
    path = geotiff(folder / "dem.tif", z * 20 + 500, {"degrees": "EPSG:4326", "mercator": "EPSG:3857"}.get(request.param, UTM), transform, nodata=np.nan)
    return SimpleNamespace(path=path, field=cw.open(path))


PLACE = 30, 0, 600000, 0, -30, 5200000


def geotiff(path, z, crs=UTM, transform=PLACE, units="metre", **options):
    """A file of these samples, or of that many rows and columns without any."""
    rasterio = pytest.importorskip("rasterio")
    shape = z if isinstance(z, tuple) else z.shape
    with rasterio.open(path, "w", driver="GTiff", width=shape[1], height=shape[0], count=1, dtype="float32" if z is shape else z.dtype, crs=crs,
                       transform=rasterio.Affine(*transform[:6]), **options) as file:
        if z is not shape:
            file.write(z, 1)
        file.units = (units,)
    return path


def raster(path):
    if os.fspath(path).endswith(".npy"):
        return np.load(path)
    import rasterio
    with rasterio.open(os.fspath(path)) as file:
        return file.read() if file.count > 1 else file.read(1)


def same(a, b):
    """Equal to the last bit, NaN included."""
    a, b = np.asarray(a), np.asarray(b)
    assert a.dtype == b.dtype and a.shape == b.shape, (a.dtype, b.dtype, a.shape, b.shape)
    bits = np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()
    assert bits, f"{np.sum(~((a == b) | ((a != a) & (b != b))))} of {a.size} differ"


def same_hits(a, b):
    for name in ("t", "u", "v", "i", "j", "triangle"):
        same(getattr(a, name), getattr(b, name))
