# SPDX-License-Identifier: Apache-2.0
"""The functions of cellwalk.h and cellwalk_expert.h, called in another process (library.c). Structs and parameters are those of the headers'
text, so none is left out."""
import os
import pathlib
import re

import numpy as np
import pytest
from words import Program

SOURCE = pathlib.Path(os.environ["CELLWALK_SOURCE"])
HEADERS = "".join((SOURCE / "include" / name).read_text() for name in ("cellwalk.h", "cellwalk_expert.h"))
TYPES = {"float": "f4", "double": "f8", "size_t": "u8", "uint8_t": "u1", "int32_t": "i4", "uint32_t": "u4", "uint64_t": "u8", "bool": "?"}
STRUCTS, POINTERS = {}, set()  # name: a dtype, in which pointers are numbers; struct and member


def read_structs():
    text = re.sub(r"/\*.*?\*/", "", HEADERS, flags=re.S)
    TYPES.update((name, "i4") for name in re.findall(r"typedef int32_t (\w+);", text))
    for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", text, re.S):
        members = []
        for declared in filter(str.strip, body.split(";")):
            if "*" in declared:
                members.append((re.search(r"\*(\w+)", declared)[1], "u8"))
                POINTERS.add((name, members[-1][0]))
                continue
            kind, several = declared.split(None, 1)
            for member in several.split(","):
                members.append((re.match(r"\w+", member.strip())[0], TYPES[kind], tuple(map(int, re.findall(r"\[(\d+)\]", member)))))
        STRUCTS[name] = TYPES[name] = np.dtype(members, align=True)


read_structs()
RAY, USER_RAY, HIT = STRUCTS["cw_ray"], STRUCTS["cw_user_ray"], STRUCTS["cw_hit"]
OK, ARGUMENT, SAMPLE, KERNEL, NOT_BUILT, MEMORY, BUSY, CANCELLED = range(8)
NOTHING = np.uint8(0x5a)  # what stands where the library has written nothing


def random_rays(n, nx, ny):
    """Through a field of heights from 0 to 1; one in 16 straight down, one in 16 no ray."""
    r, rays = np.random.default_rng(n), np.zeros(n, RAY)
    ends = r.random((2, n, 3)) * (nx - 1, ny - 1, 1)
    rays["org"], rays["dir"], rays["tmin"], rays["tmax"] = ends[0], ends[1] - ends[0], -np.inf, np.inf
    rays["dir"][3::16] = 0, -0.0, -1
    rays["dir"][5::16, 1] = np.nan
    return rays


class Room:
    """For so many of a type, which the library fills, at so many bytes behind a multiple of 64."""

    def __init__(self, kind, count=1, offset=0):
        self.kind, self.count, self.offset = np.dtype(kind), int(count), offset


class At(Room):
    """A copy of an array at so many bytes behind a multiple of 64."""

    def __init__(self, array, offset):
        self.array, self.offset = array, offset


class Library(Program):
    """Arguments are numbers, None, text, arrays, which the library gets a copy of, and Room."""
    name = "cellwalk_library"

    def call(self, name, *arguments):
        """What the function returns, as text, and an array for each Room."""
        words, given, rooms = [], [], []
        for a in arguments:
            if isinstance(a, Room) and not isinstance(a, At):
                words.append(f">{a.kind.itemsize * a.count} {a.offset}")
                rooms.append(a)
            elif a is None or isinstance(a, (int, float, np.number)):
                words.append("0" if a is None else repr(float(a)) if isinstance(a, (float, np.floating)) else str(int(a)))
            else:
                offset, a = (a.offset, a.array) if isinstance(a, At) else (0, a)
                given.append(a.encode() + b"\0" if isinstance(a, str) else np.ascontiguousarray(a).tobytes())
                words.append(f"<{len(given[-1])} {offset}")
        with open("in", "wb") as file:
            file.write(b"".join(given))
        said = self(name, *words, *[""] * (6 - len(words)))
        with open("out", "rb") as file:
            return said, *(np.frombuffer(file.read(r.kind.itemsize * r.count), r.kind).copy() for r in rooms)

    def asked(self, name, *arguments):
        """Status, error and what was filled."""
        said, *filled = self.call(name, *arguments)
        status, error = said.split(" ", 1)
        return int(status), error, *filled

    def well(self, name, *arguments):
        """Requires CW_OK; what was filled, alone if it is one thing."""
        status, error, *filled = self.asked(name, *arguments)
        assert status == OK, (name, arguments, error)
        return filled[0] if len(filled) == 1 else filled

    def fails(self, status, name, *arguments):
        found, error, *filled = self.asked(name, *arguments)
        assert found == status, (name, arguments, found, error)
        return error

    def number(self, name, *arguments):
        return int(self.call(name, *arguments)[0])

    def struct(self, name, **members):
        """Zero but for these members."""
        made = np.zeros(1, STRUCTS[name])
        for member, value in members.items():
            made[member] = value
        return made

    def keep(self, array):
        """The address of a copy that stays."""
        return self.number("keep", array)

    def run(self, pool=0, watch=0, reserved=0, **expert):
        """A cw_run, with a kernel's name or number."""
        if isinstance(expert.get("kernel"), str):
            expert["kernel"] = self.number("cw_kernel_find", expert["kernel"])
        run = self.struct("cw_run", pool=pool, watch=watch, reserved=reserved)
        for member, value in expert.items():
            run["expert"][member] = value
        return run

    def desc(self, z, map=None, **members):
        """A cw_field_desc of samples that stay."""
        z = np.asarray(z, "f4")
        members = {"samples": self.keep(z), "nx": z.shape[1], "ny": z.shape[0], **members}
        return self.struct("cw_field_desc", **members, map=np.zeros((3, 4)) if map is None else map)

    def field(self, z, map=None, run=None, **members):
        self.fields.append(int(self.well("cw_field_create", self.desc(z, map, **members), run, Room("u8"))[0]))
        return self.fields[-1]

    def describe(self, field):
        return self.call("cw_field_describe_into", field, Room(STRUCTS["cw_field_info"]), STRUCTS["cw_field_info"].itemsize)[1][0]

    def describe_kernel(self, kernel):
        return self.call("cw_kernel_describe_into", kernel, Room(STRUCTS["cw_kernel_info"]), STRUCTS["cw_kernel_info"].itemsize)[1][0]

    def kernels(self):
        """Name, address and description of those that are available."""
        for k in range(self.number("cw_kernel_count")):
            kernel = self.number("cw_kernel_at", k)
            info = self.describe_kernel(kernel)
            if info["available"]:
                yield self.call("text", int(info["name"]))[0], kernel, info

    def of_each(self, name, field, given, kind="f8", columns=1, run=None):
        """What a query says of each row of an array."""
        found = self.well(name, field, run, given, len(given), Room(kind, len(given) * columns))
        return found.reshape(len(given), columns) if columns > 1 else found

    def closest(self, field, rays, run=None):
        return self.of_each("cw_closest", field, rays, HIT, run=run)

    def occluded(self, field, rays, run=None):
        return self.of_each("cw_occluded", field, rays, "u1", run=run)


@pytest.fixture
def library(folder):
    program = Library()
    program.fields = []
    yield program
    for field in program.fields:
        program("cw_field_destroy", field, *[""] * 5)
    program.end()
