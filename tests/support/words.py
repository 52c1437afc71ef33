# SPDX-License-Identifier: Apache-2.0
"""A plugin of pytest's: folders for tests, and programs in C that do what they are told (words.h)."""
import os
import struct
import subprocess
import tempfile
import types

import numpy as np
import pytest

EMULATOR = os.environ.get("CELLWALK_EMULATOR", "")  # of the programs' machine


@pytest.fixture(autouse=True)
def folder():
    """Each test works in a new folder, which other users may enter."""
    home = os.getcwd()
    with tempfile.TemporaryDirectory(prefix="cellwalk-test-") as place:
        os.chmod(place, 0o755)
        os.chdir(place)
        yield place
        os.chdir(home)


def options(words):
    return " ".join(f"{key}={value}" for key, value in words.items())


class Program:
    """A small C program that obeys commands. Calling an object sends a command and returns the answer."""
    name, has_kernels = None, True

    def __init__(self, pass_fds=(), **setting):
        answers, to = os.pipe()
        twin = os.environ.get("CELLWALK_TWIN", "") if self.has_kernels else ""
        program = os.path.join(os.environ["CELLWALK_PROGRAMS"], self.name + twin)
        self.process = subprocess.Popen([*EMULATOR.split(), program, str(to)], stdin=subprocess.PIPE, pass_fds=[to, *pass_fds],
                                        restore_signals=False, **setting)  # SIGXFSZ stays ignored, as Python has it
        os.close(to)
        self.answers = os.fdopen(answers, "rb")

    def ask(self, *words):
        words = [word if isinstance(word, bytes) else str(word).encode() for word in words]
        self.process.stdin.write(b"".join(word + b"\0" for word in [b"%d" % len(words), *words]))
        self.process.stdin.flush()
        said = b"".join(iter(lambda: self.answers.read(1) or b"\0", b"\0"))
        assert said, "the program ended"
        return said[:1] == b"+", said[1:].decode()

    def __call__(self, *words):
        good, said = self.ask(*words)
        assert good, (words, said)
        return said

    def refused(self, part, *words):
        """Requires that the command fails with a message that contains part, and returns the message."""
        good, said = self.ask(*words)
        assert not good and part in said, (words, said)
        return said

    def facts(self, *words):
        """The answer's lines KEY=VALUE as attributes, numbers where they are numbers. The key "warning" may occur several times."""
        pairs = [line.split("=", 1) for line in self(*words).splitlines()]
        return types.SimpleNamespace(**{key: int(value) if value.isdigit() else value for key, value in pairs},
                                     warnings=[value for key, value in pairs if key == "warning"])

    def end(self):
        self.process.stdin.close()
        assert self.process.wait() == 0
        self.answers.close()


class Files(Program):
    """io/files.c"""
    name, has_kernels = "cellwalk_files", False

    def raster_words(self, name, nodata=(), cellsize=0, zscale=0, **words):
        np.array([*nodata, *[0] * (2 - len(nodata)), cellsize, zscale], float).tofile("options")
        return "raster", name, options({**words, "nodata": len(nodata)})

    def raster(self, name, **options):
        found = self.facts(*self.raster_words(name, **options))
        found.z, found.map = np.fromfile("z", "f4").reshape(found.ny, found.nx), np.fromfile("map").reshape(3, 4)
        found.unit, found.height_unit, *found.ellipsoid, found.nodata = np.fromfile("georef")
        return found

    def raster_refused(self, part, name, **options):
        assert name in self.refused(part, *self.raster_words(name, **options))


class Scenes(Program):
    """scene/scenes.c"""
    name = "cellwalk_scenes"

    def render(self, general=0, **words):
        """The picture of the scene that was loaded last, (rows, columns, RGB), and the facts."""
        found = self.facts("render", options({**words, "general": general}))
        return np.fromfile("pixels", "f4").reshape(found.height, found.width, 3), found


# As usual; neither square nor in metres; turned; mirrored; in degrees: and whether it is that.
MAPS = [([[10, 0, 0, 500], [0, -10, 0, 900], [0, 0, 1, 0]], 0), ([[10, 0, 0, 0], [0, -25, 0, 0], [0, 0, 0.3048, 0]], 0),
        ([[8, 6, 0, 100], [6, -8, 0, 100], [0, 0, 1, 0]], 0), ([[-5, 0, 0, 0], [1, 5, 0, 0], [0, 0, 1, 0]], 0),
        ([[0.0002, 0, 0, 7], [0, -0.0001, 0, 47], [0, 0, 1, 0]], 1)]
RADIUS = 6378137.0


def light(azimuth=0, altitude=0, radius=0, curvature=0, strips=0, hillshade=0):
    """cw_light, and so on."""
    return struct.pack("4d2I64x", azimuth, altitude, radius, curvature, strips, hillshade)


def horizon(start=0, farthest=0, curvature=0, count=0, flags=0):
    return struct.pack("3d2I64x", start, farthest, curvature, count, flags)


def observer(x, y, height, target=0, curvature=0, nearest=0, farthest=0, azimuths=(0, 0), verticals=(0, 0), absolute=0, limits=0):
    return struct.pack("11d2I64x", x, y, height, target, curvature, nearest, farthest, *azimuths, *verticals, absolute, limits)


def visibility(height=0, target=0, farthest=0, curvature=0, directions=0, every=0):
    return struct.pack("4d2I64x", height, target, farthest, curvature, directions, every)


class Lands(Program):
    """terrain/lands.c. Samples are 10 m apart, the first row in the north, unless a map says otherwise."""
    name = "cellwalk_lands"

    def land_words(self, z, map=((10, 0, 0, 0), (0, -10, 0, 0), (0, 0, 1, 0)), geographic=0, unit=0, gap=0, **words):
        """gap: of so many numbers behind each row of the samples."""
        self.z = np.ascontiguousarray(z, "f4")
        np.pad(self.z, ((0, 0), (0, gap)), constant_values=1e9).tofile("z")
        np.array([*np.ravel(map), unit], float).tofile("map")
        ny, nx = self.z.shape
        return "land", options({"nx": nx, "ny": ny, "stride": gap and nx + gap, "geographic": geographic, **words})

    def land(self, *words, **more):
        """Its samples."""
        self(*self.land_words(*words, **more))
        return self.z

    def product_words(self, name, desc, to=b"", **words):
        for file, content in ("desc", desc), ("to", to):
            with open(file, "wb") as file:
                file.write(content)
        return name, options(words)

    def product(self, name, desc, type="f4", **words):
        """Of the whole field."""
        self(*self.product_words(name, desc, bytes(self.z.size * np.dtype(type).itemsize), **words))
        out = np.fromfile("out", type).reshape(self.z.shape)
        return out.astype(float) if type == "f4" else out

    def shadow(self, azimuth, altitude, curvature=0):
        return self.product("shadow", light(azimuth, altitude, curvature=curvature), "u1")

    def angles(self, desc, number=0):
        """Degrees, metres."""
        return [self.product(name, desc, number=number) for name in ("angles", "metres")]

    def viewshed(self, desc, to=None):
        """Whether samples are seen, angles, sums of the weight 2.5, needed heights; to: where they go."""
        n = self.z.size
        self(*self.product_words("view all", desc, to or bytes(18 * n)))
        out = np.fromfile("out", "u1")
        return [out[begin * n:end * n].view(type).reshape(self.z.shape) for begin, end, type in ((16, 18, "u2"), (8, 12, "f4"), (0, 8, float), (12, 16, "f4"))]

    def lines_words(self, curvature, lines, words=""):
        with open("desc", "wb") as file:
            file.write(struct.pack("d", curvature) + lines)
        return "lines", words

    def lines(self, *words):
        """Answers to lines, each the bytes of a cw_sight."""
        self(*self.lines_words(*words))
        return np.fromfile("out", [("metres", "f8"), ("blocked", "3f8"), ("distance", "f8"), ("state", "u4"), ("end", "u4")])

    def round(self, place, height, absolute=1, target=0, curvature=0, farthest=0):
        """From a place in field coordinates: what is seen, what is needed, the eye, the earth's fall."""
        with open("desc", "wb") as file:
            file.write(struct.pack("7d", *place, height, absolute, target, curvature, farthest))
        self("round")
        return [np.fromfile(name, type).reshape(self.z.shape) for name, type in (("seen", "u2"), ("needed", "f4"))] + [np.fromfile(name) for name in ("eye", "fall")]

    def table(self, name, rows, columns=None):
        """A row of answers for each, or all that is found in so many columns."""
        rows = np.array(rows, float)
        rows.tofile("desc")
        self(name)
        return np.fromfile("out").reshape((-1, columns) if columns else (len(rows), -1))

    def rays(self, rays):
        np.ascontiguousarray(rays, "f4").tofile("desc")
        self("rays")
        return np.fromfile("out", "u1").astype(int)

    def visible_words(self, how, rectangle=None, every=1, row=0, count=None, **words):
        """how: direction x and y, reach, drop, height of the eye and of the target, slack."""
        np.array([*how, *[0] * (7 - len(how))], float).tofile("desc")
        left, top, wide, high = rectangle or (0, 0, *self.z.shape[::-1])
        words = {"left": left, "top": top, "wide": wide, "high": high, "every": every, "row": row, **words,
                 "count": -(-high // max(every, 1)) - row if count is None else count}
        return "visible", options(words)

    def visible(self, how, rectangle=None, **words):
        """Areas, distances and directions, an eye a number."""
        self(*self.visible_words(how, rectangle, **words))
        wide = -(-(rectangle[2] if rectangle else self.z.shape[1]) // words.get("every", 1))
        return [np.fromfile(name, type).reshape(-1, wide) for name, type in (("area", float), ("far", "f4"), ("direction", "f4"))]

    def coarser(self, **words):
        """Samples; above, below, rms; lost, made."""
        found = self.facts("coarser", options(words))
        difference = np.fromfile("difference", "u1").tobytes()
        return np.fromfile("out", "f4").reshape(found.ny, found.nx), np.frombuffer(difference, float, 3), np.frombuffer(difference, "u8", 2, 24)


def fixture_of(kind):
    def start(folder):
        program = kind()
        yield program
        program.end()
    return pytest.fixture(start)


files, scenes, lands = map(fixture_of, (Files, Scenes, Lands))
