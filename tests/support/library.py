# SPDX-License-Identifier: Apache-2.0
"""A plugin of pytest's: the functions of the libraries, called in another process (library.c). Structs and parameters are those of the headers'
text, so none is left out."""
import os
import pathlib
import re

import numpy as np
from words import Program, fixture_of

SOURCE = pathlib.Path(os.environ["CELLWALK_SOURCE"])
HEADERS = "".join((SOURCE / "include" / name).read_text() for name in ("cellwalk.h", "cellwalk_expert.h", "cellwalk_terrain.h"))
INSIDE = "".join((SOURCE / f"src/terrain/{name}.h").read_text() for name in (
    "visible/visible", "sun/sun", "sun/insolation", "sight/sight", "sight/profile"))
TYPES = {"int": "i4", "float": "f4", "double": "f8", "size_t": "u8", "uint8_t": "u1", "int32_t": "i4", "uint32_t": "u4", "uint64_t": "u8", "bool": "?"}
STRUCTS, POINTERS = {}, set()  # name: a dtype, in which pointers are numbers; struct and member


def read_structs():
    text = re.sub(r"/\*.*?\*/", "", HEADERS + INSIDE, flags=re.S)
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


class Both(Room):
    """Room that holds an array before."""

    def __init__(self, array):
        super().__init__(array.dtype, array.size)
        self.array = array


def struct(name, **members):
    """Zero but for these members."""
    made = np.zeros(1, STRUCTS[name])
    for member, value in members.items():
        made[member] = value
    return made


class Library(Program):
    """Arguments are numbers, None, text, arrays, which the library gets a copy of, and Room."""
    name = "cellwalk_library"

    def __init__(self, **setting):
        super().__init__(**setting)
        self.fields, self.pools = [], []

    def call(self, name, *arguments):
        """What the function returns, as text, and an array for each Room."""
        words, given, rooms = [], [], []
        for a in arguments:
            if isinstance(a, Room) and not isinstance(a, At):
                words.append(f"{'=' if isinstance(a, Both) else '>'}{a.kind.itemsize * a.count} {a.offset}")
                rooms.append(a)
                if isinstance(a, Both):
                    given.append(np.ascontiguousarray(a.array).tobytes())
            elif a is None or isinstance(a, (int, float, np.number)):
                words.append("0" if a is None else repr(float(a)) if isinstance(a, (float, np.floating)) else str(int(a)))
            else:
                offset, a = (a.offset, a.array) if isinstance(a, At) else (0, a)
                given.append(a.encode() + b"\0" if isinstance(a, str) else np.ascontiguousarray(a).tobytes())
                words.append(f"<{len(given[-1])} {offset}")
        with open("in", "wb") as file:
            file.write(b"".join(given))
        said = self(name, *words, *[""] * (8 - len(words)))
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

    struct = staticmethod(struct)

    def keep(self, array):
        """The address of a copy that stays."""
        return self.number("keep", array)

    def run(self, pool=0, watch=0, watch_context=0, reserved=0, **expert):
        """A cw_run, with a kernel's name or number."""
        if isinstance(expert.get("kernel"), str):
            expert["kernel"] = self.number("cw_kernel_find", expert["kernel"])
        run = self.struct("cw_run", pool=pool, watch=watch, watch_context=watch_context, reserved=reserved)
        for member, value in expert.items():
            run["expert"][member] = value
        return run

    def pool(self, threads):
        self.pools.append(int(self.well("cw_pool_create", threads, Room("u8"))[0]))
        return self.pools[-1]

    def limited(self, isa):
        """Limits the instruction set; whether this machine has just that."""
        self.call("cw_isa_limit", isa)
        return isa == 0 or self.number("cw_isa_best") == isa

    def desc(self, z, map=None, **members):
        """A cw_field_desc of samples that stay."""
        z = np.asarray(z, "f4")
        members = {"samples": 0, "nx": z.shape[1], "ny": z.shape[0], **members}
        members["samples"] = members["samples"] or self.keep(z)
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

    def peek(self, address, kind, count=1):
        return self.call("peek", int(address), Room(kind, count))[1]

    def end(self):
        for what, made in *(("field", field) for field in self.fields), *(("pool", pool) for pool in self.pools):
            self.call(f"cw_{what}_destroy", made)
        super().end()


# As usual; neither square nor in metres; turned; mirrored; in degrees: and whether it is that.
MAPS = [([[10, 0, 0, 500], [0, -10, 0, 900], [0, 0, 1, 0]], 0), ([[10, 0, 0, 0], [0, -25, 0, 0], [0, 0, 0.3048, 0]], 0),
        ([[8, 6, 0, 100], [6, -8, 0, 100], [0, 0, 1, 0]], 0), ([[-5, 0, 0, 0], [1, 5, 0, 0], [0, 0, 1, 0]], 0),
        ([[0.0002, 0, 0, 7], [0, -0.0001, 0, 47], [0, 0, 1, 0]], 1)]
RADIUS = 6378137.0
WIDTHS = {"places": 8, "suns": 5, "skies": 3, "degrees": 1, "sights": 4, "skyline": 2}  # of rows that library_terrain.h answers


def light(azimuth=0, altitude=0, **members):
    return struct("cw_light", azimuth=azimuth, altitude=altitude, **members)


def horizon(start=0, farthest=0, curvature=0, count=0, flags=0):
    return struct("cw_horizon", start=start, max_distance=farthest, curvature=curvature, count=count, flags=flags)


def observer(x, y, height, **members):
    return struct("cw_observer", x=x, y=y, height=height, **members)


class Lands(Library):
    """One terrain at a time. Samples are 10 m apart, the first row in the north, unless a map says otherwise."""
    land_now = eyes = None
    sums = ()

    def __init__(self):
        super().__init__()
        self.threads = self.pool(4)

    def forget(self):
        made = *(("insolation", sum) for sum in self.sums), ("visible", self.eyes), ("terrain", self.land_now), *(("field", field) for field in self.fields)
        for what, address in made:
            if address:
                self.call(f"cw_{what}_destroy", address)
        self.land_now, self.eyes, self.sums, self.fields = None, None, [], []

    def end(self):
        self.forget()
        super().end()

    def land_desc(self, z, map=((10, 0, 0, 0), (0, -10, 0, 0), (0, 0, 1, 0)), gap=0, **members):
        """gap: of so many numbers behind each row of the samples, which the field borrows then."""
        self.forget()
        self.z, self.up = np.ascontiguousarray(z, "f4"), float(map[2][2])
        (ny, nx), rows = self.z.shape, np.pad(self.z, ((0, 0), (0, gap)), constant_values=1e9)
        desc = self.desc(rows, map, **({"nx": nx, "stride": nx + gap, "storage": 1} if gap else {}))
        self.fields.append(int(self.well("cw_field_create", desc, None, Room("u8"))[0]))
        if not gap:
            self.call("drop", int(desc["samples"][0]))
        return struct("cw_terrain_desc", **{"field": self.fields[-1], **members})

    def land(self, *words, **more):
        """Its samples."""
        self.land_now = int(self.well("cw_terrain_create", self.land_desc(*words, **more), None, Room("u8"))[0])
        return self.z

    def filled(self, members, call):
        """What call gives; the arrays have what is written to a struct of their addresses."""
        at = {name: self.keep(array) for name, array in members.items()}
        found = call(at)
        for name, address in at.items():
            members[name][...] = self.peek(address, members[name].dtype, members[name].size).reshape(members[name].shape)
            self.call("drop", address)
        return found

    def make(self, name, desc, to, number=0, run=None, at=(0, 0, 0, 0), stride=0, land=True, **view):
        """Status and error of a product, which is written to an array."""
        name, _, member = name.partition(" ")
        area, land = np.array([*at, stride], "u8"), self.land_now if land else None
        if name in ("viewshed", "visibility"):
            kind = "cw_view" if name == "viewshed" else "cw_visibility_answers"
            return self.filled({} if to is None else {member: to}, lambda addresses: self.asked(
                f"cw_{name}", land, run, desc, area, struct(kind, **addresses, **view) if addresses else None))
        room = to if to is None else Both(to)
        more = [number] * (name == "horizon_angles"), [None] * (member == "metres"), [None] * (member == "degrees")
        arguments = [run, area] if name.startswith("insolation") else [desc] if name == "horizon_azimuths" else [run, desc, *more[0], area]
        status, error, *found = self.asked(f"cw_{name}", desc if name.startswith("insolation") else land, *arguments, *more[1], room, *more[2])
        if found:
            to[...] = found[0].reshape(to.shape)
        return status, error

    def product(self, name, desc, type="f4", **words):
        """Of the whole field."""
        to = np.zeros(self.z.shape, type)
        status, error = self.make(name, desc, to, **words)
        assert status == OK, (name, error)
        return to.astype(float) if type == "f4" else to

    def shadow(self, azimuth, altitude, curvature=0):
        return self.product("shadow", light(azimuth, altitude, curvature=curvature), "u1")

    def angles(self, desc, number=0):
        """Degrees, metres."""
        return [self.product(f"horizon_angles {kind}", desc, number=number) for kind in ("degrees", "metres")]

    def insolation(self, suns, hours, curvature=0, directions=0):
        """Rows of suns; each stands for so many hours."""
        at = self.keep(np.ascontiguousarray(suns))
        desc = struct("insolation_desc", suns=at, count=len(suns), hours=hours, linke=3, curvature=curvature, directions=directions)
        self.sums.append(int(self.well("cw_insolation_create", self.land_now, desc, Room("u8"))[0]))
        return self.sums[-1]

    def viewshed(self, desc, **before):
        """Whether samples are seen, angles, sums of the weight 2.5 and needed heights, which do not go with vertical limits."""
        to = {"seen": np.zeros(self.z.shape, "u2"), "angle": np.zeros(self.z.shape, "f4"), "sum": np.zeros(self.z.shape),
              **({} if desc["limits"] & 2 else {"needed": np.zeros(self.z.shape, "f4")}), **before}
        self.filled(to, lambda at: self.well("cw_viewshed", self.land_now, None, desc, np.zeros(5, "u8"), struct("cw_view", **at, weight=2.5)))
        return *to.values(),

    def lines(self, curvature, lines):
        """Answers to lines of sight."""
        return self.well("cw_lines_of_sight", self.land_now, None, float(curvature), lines, len(lines), Room(STRUCTS["cw_sight_answer"], len(lines)))

    def round(self, place, height, absolute=1, target=0, curvature=0, farthest=0):
        """A viewshed from a place in field coordinates: which samples are seen, the heights needed, the eye, and how fast the earth falls away."""
        eye = np.array([*place, (height if absolute else self.table("places", [[*place, 0]])[0, 7] + height) / self.up])
        bounds = int(self.well("cw_terrain_bounds", self.land_now, Room("u8"))[0])
        sight = self.call("cw_sight_init", Room(STRUCTS["sight"]), self.land_now, bounds, eye, float(curvature))[1]
        desc = struct("cw_observer", target=target, farthest=farthest)
        to = {"seen": np.zeros(self.z.shape, "u2"), "needed": np.zeros(self.z.shape, "f4")}
        self.filled(to, lambda at: self.well("cw_viewshed_from", sight, desc, None, np.zeros(5, "u8"), struct("cw_view", **at)))
        self.call("cw_terrain_bounds_release", self.land_now, bounds)
        return to["seen"], to["needed"], sight["eye"][0], sight["fall"][0]

    def table(self, name, rows):
        """A row of answers for each."""
        rows = np.array(rows, float)
        return self.call(name, self.land_now, rows, len(rows), Room("f8", len(rows) * WIDTHS[name]))[1].reshape(len(rows), WIDTHS[name])

    def profile(self, start, end, curvature):
        """Share, ground, line and whether it is seen of each point."""
        sight = self.call("cw_sight_init", Room(STRUCTS["sight"]), self.land_now, None, np.array(start), float(curvature))[1]
        made = self.well("cw_profile_make", Both(struct("profile")), sight, *map(float, end))
        points = self.peek(made["points"][0], STRUCTS["profile_point"], int(made["count"][0]))
        self.call("cw_profile_free", made)
        return [points[member].astype(float) for member in ("share", "ground", "line", "seen")]

    def visible(self, how, rectangle=None, every=1, row=0, count=None, pool=0, keep=False):
        """Areas, distances and directions, an eye a number. how: direction x and y, reach, drop, height of the eye and of the target, slack.
        keep: the eyes stay for the next direction."""
        at = rectangle or (0, 0, *self.z.shape[::-1])
        wide, count = -(-at[2] // every), -(-at[3] // every) - row if count is None else count
        desc = struct("cw_visible_desc", dir=how[:2], weight=1, length=1, label=7, **dict(zip(("reach", "drop", "eye", "target", "slack"), how[2:])))
        if not self.eyes:
            self.eyes = int(self.well("cw_visible_create", self.fields[-1], np.array(at, "u8"), every, Room("u8"))[0])
        sums = [Both(np.full(count * wide, fill, type)) for fill, type in ((0, "f8"), (0, "f4"), (np.nan, "f4"))]
        found = self.well("cw_visible_add", self.eyes, self.run(pool=pool), desc, row, count, *sums)
        if not keep:
            self.call("cw_visible_destroy", self.eyes)
            self.eyes = None
        return [values.reshape(-1, wide) for values in found]

    def coarser(self, factor, filter, pool=0):
        """The field, its samples and how far it is."""
        field, difference = self.well("cw_field_coarser", self.fields[-1], self.run(pool=pool), factor, filter, Room("u8"),
                                      Room(STRUCTS["cw_difference"]), STRUCTS["cw_difference"].itemsize)
        self.fields.insert(0, int(field[0]))
        info = self.describe(self.fields[0])
        rows = [self.peek(self.number("cw_field_row", self.fields[0], j), "f4", int(info["nx"])) for j in range(int(info["ny"]))]
        return self.fields[0], np.array(rows), difference[0]


library, lands = map(fixture_of, (Library, Lands))
