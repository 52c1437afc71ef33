# SPDX-License-Identifier: Apache-2.0
"""The program cellwalk as users run it. Tests work in a folder of their own (conftest.py), where its files are."""
import ctypes
import errno
import functools
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import tempfile

import numpy as np
import pytest
from words import Files, wait_until

PROGRAM, BENCH, PRELOAD, SOURCE = (os.environ.get(f"CELLWALK_{name}", "") for name in ("PROGRAM", "BENCH", "PRELOAD", "SOURCE"))
DIVISOR, TURN, SLOW = (int(os.environ.get(f"CELLWALK_TEST_{name}", least)) for name, least in (("DIVIDE", 1), ("TURN", 0), ("SLOW", 1)))
SANITIZER = 99  # the exit status of a program that a sanitizer ends
SANITIZERS = f"symbolize=0:exitcode={SANITIZER}"
SCENE = """Film "image" "integer xresolution" 40 "integer yresolution" 30
LookAt 0 0 0 0 0 1 0 1 0
Camera "perspective"
WorldBegin
LightSource "point" "color I" [9 9 9]
Translate -1 -1 2
Scale 2 2 1
Shape "heightfield" "integer nu" 2 "integer nv" 2 "float Pz" [0 0 .3 0]
WorldEnd
"""


def needs_room(program=PROGRAM):
    """Sanitizers take memory of their own: AddressSanitizer does not start under a small limit."""
    with open(program, "rb") as file:
        text = file.read()
    return b"__asan_init" in text or b"__tsan_init" in text


def takes(k, most):
    """Whether case k is one of those that are taken of so many, as test_takes of ../support/check.h."""
    return (k + TURN) % min(DIVISOR * SLOW, most) == 0


def taken(cases, most):
    return [case for k, case in enumerate(cases) if takes(k, most)]


signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started the tests with it ignored, as the program would


# ---- runs ---------------------------------------------------------------------------------------------------------------


class Done:
    """How a run ended: 128 + the number of the signal that ended it, if one did. Lines that say what was written are in outcome."""

    def __init__(self, status, out, err):
        self.status, self.bytes = status if status >= 0 else 128 - status, out
        self.out, text = out.decode(errors="replace"), err.decode(errors="replace")
        lines = text.splitlines(keepends=True)
        written = [line.startswith("cellwalk ") and line.endswith(" s\n") and re.search(" (samples|places?|days|pairs|rays|pixels)[ ,]", line) is not None for line in lines]
        self.err, self.outcome = ("".join(line for line, is_one in zip(lines, written) if is_one == wanted) for wanted in (False, True))
        if "LeakSanitizer has encountered a fatal error" in text:
            raise ChildProcessError(text)
        assert self.status != SANITIZER and "Sanitizer" not in text and "runtime error" not in text, text


def without_filters():
    """The system call seccomp fails with EINVAL from now on, as in some emulators."""
    number = {"x86_64": 317, "aarch64": 277}[os.uname().machine]
    LOAD, EQUAL, RETURN, ERROR, ALLOW = 0x20, 0x15, 0x06, 0x00050000, 0x7fff0000
    rules = (LOAD, 0, 0, 0), (EQUAL, 0, 1, number), (RETURN, 0, 0, ERROR | errno.EINVAL), (RETURN, 0, 0, ALLOW)
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *rule) for rule in rules))
    NO_NEW_PRIVS, SECCOMP, BY_FILTER = 38, 22, 2
    prctl, program = ctypes.CDLL(None).prctl, struct.pack("HP", len(rules), ctypes.addressof(code))
    assert prctl(NO_NEW_PRIVS, 1, 0, 0, 0) == 0 and prctl(SECCOMP, BY_FILTER, program) == 0


def start(*words, env=(), isa=None, file_size=0, memory=0, powerless=False, no_filters=False):
    """env: variables beside the tests' own; isa: CELLWALK_ISA; then bytes of a file and of memory, no rights of root, no filters of
    calls. Python copies this process's page tables for a preexec_fn, which takes several times
    as long as the program: only what no command does is done by one."""
    environment = {"ASAN_OPTIONS": SANITIZERS, **os.environ, **dict(env), **({} if isa is None else {"CELLWALK_ISA": isa})}
    limits = [f"--{name}={limit}" for name, limit in (("fsize", file_size), ("as", memory)) if limit]
    before = ["prlimit", *limits] if limits else []
    if powerless and os.geteuid() == 0:  # who may write anywhere
        before += ["setpriv", "--inh-caps=-all", "--bounding-set=-all"]
    streams = tempfile.TemporaryFile(), tempfile.TemporaryFile()
    process = subprocess.Popen([*before, PROGRAM, *map(str, words)], stdin=subprocess.DEVNULL, stdout=streams[0], stderr=streams[1], env=environment,
                               preexec_fn=without_filters if no_filters else None)
    process.streams = streams
    return process


def end(process):
    status, texts = process.wait(), []
    for stream in process.streams:
        stream.seek(0)
        texts.append(stream.read())
        stream.close()
    return Done(status, *texts)


def run(*words, env=(), **setting):
    try:
        return end(start(*words, env=env, **setting))
    except ChildProcessError:  # stopping threads to look for leaks, LeakSanitizer crashed, and the status is lost: the same without
        return end(start(*words, env={**dict(env), "ASAN_OPTIONS": f"{SANITIZERS}:detect_leaks=0"}, **setting))


def well(*words, **setting):
    """A run without an error or a warning."""
    done = run(*words, **setting)
    assert (done.status, done.err) == (0, ""), words
    return done


def refused(status, part, *words, **setting):
    """A run that fails with these words and leaves nothing behind."""
    before = entries()
    done = run(*words, **setting)
    assert done.status == status and part in done.err and done.err.startswith("cellwalk"), (words, done.status, done.err)
    assert entries() == before, words
    return done


def array(*words, name="out.npy", **setting):
    """What a run without messages writes."""
    well(*words, "-o", name, **setting)
    return np.load(name)


def shell(line):
    """PROGRAM is the program's name there."""
    return subprocess.run(line.replace("PROGRAM", f"'{PROGRAM}'"), shell=True, capture_output=True, text=True)


# ---- runs that do not come to their end -----------------------------------------------------------------------------------


def open_files(process):
    """Names below the working directory of what the program has open."""
    names, here = [], os.getcwd() + "/"
    try:
        for descriptor in os.listdir(f"/proc/{process.pid}/fd"):
            names.append(os.readlink(f"/proc/{process.pid}/fd/{descriptor}"))
    except OSError:  # it has ended, or closed the file meanwhile
        pass
    return [name[len(here):] for name in names if name.startswith(here)]


def is_read(process, name):
    """Whether it has read as many bytes as the file has, of whatever files."""
    try:
        read = re.search(r"rchar: (\d+)", pathlib.Path(f"/proc/{process.pid}/io").read_text())
    except OSError:
        return False
    return int(read[1]) >= os.stat(name).st_size


def catches(process, number):
    """Whether it handles the signal: while it is loaded, it does not."""
    try:
        caught = re.search(r"SigCgt:\s*(\w+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())
    except OSError:
        return False
    return bool(int(caught[1], 16) >> number - 1 & 1)


def interrupted(*words, input=None, writes=True, signals=(signal.SIGINT,)):
    """A long run is told to stop as soon as it has read an input and opened its output. It does, and leaves nothing but, if it is killed,
    hidden files."""
    before = entries()
    process = start(*words)
    wait_until(process, lambda: all(catches(process, number) for number in signals if number != signal.SIGKILL))
    wait_until(process, lambda: not input or is_read(process, input))
    wait_until(process, lambda: not writes or any(".tmp" in name for name in open_files(process)))
    for number in signals:
        process.send_signal(number)
    done = end(process)
    assert done.status - 128 in signals, (done.status, done.err)
    assert "interrupted" in done.err or set(signals) != {signal.SIGINT}
    for name in set(entries()) - set(before):
        assert signal.SIGKILL in signals and name.startswith(".") and ".tmp" in name, name
        os.unlink(name)
    assert entries() == before
    return done


# ---- files --------------------------------------------------------------------------------------------------------------


def entries():
    return sorted(os.listdir())


def write(name, text):
    pathlib.Path(name).write_bytes(text if isinstance(text, bytes) else text.encode())


def read(name):
    return pathlib.Path(name).read_bytes()


def take(name):
    """The file's content, if there is one; it is removed, and so is a picture's world file."""
    if not os.path.exists(name):
        return None
    content = read(name)
    os.unlink(name)
    if os.path.exists("out.pgw"):
        os.unlink("out.pgw")
    return content


def rough(side):
    """Land that no compression makes small."""
    k = np.arange(side * side, dtype=np.uint32)
    return ((k * np.uint32(2654435761) >> 7) % 1000).astype(np.float32).reshape(side, side)


def wall(name, *holes, height=40):
    """Level land of 60 x 50 samples with a wall along row 20, and holes at rows and columns."""
    z = np.zeros((50, 60), np.float32)
    z[20] = height
    for hole in holes:
        z[hole] = np.nan
    np.save(name, z)


def header(descr="'<f4'", order="False", shape="(2, 3)"):
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"


def npy(text, data=b"", version=1, name="a.npy"):
    """A file with this header, which need not fit the data; its size without them."""
    start = b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H" if version == 1 else "<I", len(text)) + text.encode()
    write(name, start + data)
    return len(start)


def rays(name, origins, direction=(0, 0, -1), tmin=0, tmax=1e9, dtype="<f4"):
    origins = np.atleast_2d(np.asarray(origins, float))
    table = np.zeros((len(origins), 8))
    table[:, :3], table[:, 3], table[:, 4:7], table[:, 7] = origins, tmin, direction, tmax
    np.save(name, table.astype(dtype))
    return table


def asc(name, z, x=0, y=0, cell=10):
    needs("GDAL")
    z = np.where(np.isnan(z), -9999, z)
    rows = "\n".join(" ".join(f"{v:.9g}" for v in row) for row in z)
    write(name, f"ncols {z.shape[1]}\nnrows {z.shape[0]}\nxllcorner {x}\nyllcorner {y}\ncellsize {cell}\nnodata_value -9999\n{rows}\n")


def vrt(name, source, shape, place, sides=None, at=0):
    """A raster for GDAL of that many rows and columns at that place, its SRS and GeoTransform; the source begins at sample (at, at)."""
    (ny, nx), (rows, columns) = shape, sides or shape
    write(name, f'<VRTDataset rasterXSize="{columns}" rasterYSize="{rows}">{place}<VRTRasterBand dataType="Float32" band="1">'
                f'<NoDataValue>-9999</NoDataValue><ComplexSource><SourceFilename relativeToVRT="1">{source}</SourceFilename>'
                f'<SrcRect xOff="0" yOff="0" xSize="{nx}" ySize="{ny}"/><DstRect xOff="{at}" yOff="{at}" xSize="{nx}" ySize="{ny}"/>'
                '<NODATA>-9999</NODATA></ComplexSource></VRTRasterBand></VRTDataset>')


def feature(kind, places, **properties):
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": places}}


def geojson(name, *features, crs="EPSG::32632"):
    write(name, json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": f"urn:ogc:def:crs:{crs}"}},
                            "features": features}))


def on_map(crs, *transform):
    return (f"<SRS>EPSG:{crs}</SRS>" if crs else "") + f"<GeoTransform>{','.join(map(str, transform))}</GeoTransform>"


def library(name):
    """Whether this build has an optional library."""
    return any(line.split()[:2] == [name, "yes"] for line in run("--version").out.splitlines())


def needs(name):
    if not library(name):
        pytest.skip(f"this build lacks {name}")


# ---- pictures -----------------------------------------------------------------------------------------------------------


def exr(name):
    """The pixels of a picture, (rows, columns, RGB) in floats."""
    files = Files()
    width, height = map(int, files("image", name).split())
    files.end()
    return np.fromfile("halves", "<f2").reshape(height, width, 4)[..., :3].astype(np.float32)


def picture(*words, **setting):
    """The picture that `cellwalk render` makes without messages."""
    well("render", *words, "-o", "o.exr", **setting)
    return exr("o.exr")


def as_half(value):
    """As a picture's file holds it."""
    return np.asarray(value).astype(np.float32).astype(np.float16).astype(np.float32)


def close(pixels, colour, light=1, share=0):
    """Pixels are a colour times light. Colours of the ground are kept as halves, which are off by 2^-11 of themselves; what is computed
    in floats is smaller. share: how much more the samples of a pixel may differ from its middle, of the colour. The file's rounding to
    halves is monotone: what is between two bounds stays between these rounded."""
    wanted = np.asarray(colour) * light
    off = (6e-4 + share) * wanted
    good = (pixels >= as_half(wanted - off)) & (pixels <= as_half(wanted + off))
    assert good.all(), (pixels[~good.all(-1)], np.broadcast_to(wanted, pixels.shape)[~good.all(-1)])


# ---- what `cellwalk info` says -------------------------------------------------------------------------------------------------


def info(*words, **setting):
    return json.loads(well("info", *words, "--json", **setting).out)


def commands(help=None):
    """Subcommands that --help lists, each of which some tests have to try."""
    return set(re.findall(r"^  (\S+) ", re.search(r"Commands:\n((?:  .*\n)+)", help or run("--help").out)[1], re.M))


@functools.cache
def sets():
    """Instruction sets up to the best one of this machine, or of CELLWALK_ISA."""
    every = ["scalar", "sse4.2", "avx2", "avx512"]
    return every[:every.index(info()["isa"]) + 1]
