# SPDX-License-Identifier: Apache-2.0
"""A plugin of pytest's: folders for tests, and programs in C that do what they are told (words.h)."""
import os
import subprocess
import tempfile
import time
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
        assert said, f"{words[0]}: the program ended with status {self.process.wait()}"  # its last words are on standard error
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


def wait_until(process, is_so):
    """The pause leaves the CPU to the program and decides nothing: only its end ends the wait before its time."""
    while True:
        over = process.poll() is not None
        if is_so():
            return
        assert not over, "the program ended too early"
        time.sleep(0.001)


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


def fixture_of(kind):
    def start(folder):
        program = kind()
        yield program
        program.end()
    return pytest.fixture(start)


files, scenes = map(fixture_of, (Files, Scenes))
