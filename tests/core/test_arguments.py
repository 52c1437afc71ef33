# SPDX-License-Identifier: Apache-2.0
"""Wrong, odd and empty arguments. Functions, parameters and members are those that the headers' text has: NULL and NaN fail with
CW_ERROR_ARGUMENT and a sentence that begins with the argument's name, optional pointers may be NULL, and nothing to do, n = 0 or an empty
rectangle, succeeds without arrays. Misuse gives the documented status, and limits on instruction sets hold."""
import os
import re

import numpy as np
import pytest
from library import (ARGUMENT, HEADERS, HIT, KERNEL, NOT_BUILT, NOTHING, OK, POINTERS, SOURCE, STRUCTS, At, Library, Room, random_rays)
from program import takes

FUNCTIONS = dict(re.findall(r"CW_API cw_status (\w+)\((.*?)\);", HEADERS, re.S))
MAY_BE_NULL = {"cw_run_check field", "cw_field_coarser difference", "cw_horizon_angles degrees", "cw_horizon_angles metres"}
SIDE = 5
ALL = 2**64 - 1
KINDS = {"float ": "~", "double ": "~", "cw_rectangle ": "@", "cw_area ": "%"}  # else # is a count, and = what no value is wrong for
EMPTY = [(0, 0, 0, SIDE), (0, 0, SIDE, 0)]


@pytest.fixture
def good(library):
    """Right arguments by the names of parameters; arrays have room for two of anything or for a number for each sample."""
    flat, struct = np.zeros((SIDE, SIDE)), library.struct
    field, ground = library.field(flat), library.keep(flat)
    turn, land = struct("cw_heading_desc", dir=(1, 0.5)), struct("cw_terrain_desc", field=field)
    heading = int(library.well("cw_heading_create", field, turn, Room("u8"))[0])
    terrain = int(library.well("cw_terrain_create", land, None, Room("u8"))[0])
    yield {"field": field, "heading": heading, "run": library.run(), "tasks": struct("cw_tasks", threads=2, run=library.number("run_tasks")),
           "update": struct("cw_update", at=(1, 1, 2, 2), samples=ground), "threads": 2, "n": 2, "wait": 0, "factor": 2, "filter": 0, "size": 8,
           "at": np.array([0, 0, SIDE, SIDE], "u8"), "low": -1.0, "high": 1.0, "slope": 0.0, "map": np.eye(3, 4), "desc": library.desc(flat),
           "cw_heading_create desc": turn, "cw_terrain_create desc": land, "cw_visibility desc": struct("cw_visibility_desc"), "curvature": 0.0,
           "terrain": terrain, "area": np.array([0, 0, SIDE, SIDE, 0], "u8"), "light": struct("cw_light"), "horizon": struct("cw_horizon"), "number": 0,
           "from": struct("cw_observer", limits=3, azimuths=(0, 90), verticals=(-90, 90)), "view": struct("cw_view", sum=ground),
           "lines": np.zeros(2, STRUCTS["cw_sight"]), "cw_visibility answers": struct("cw_visibility_answers", area=ground)}
    library.call("cw_heading_destroy", heading)
    library.call("cw_terrain_destroy", terrain)


def parameters(function, good):
    """Name, kind and right argument of each: ? an optional pointer, * another, & where a result goes, [ an array, or what KINDS has."""
    declared = [re.fullmatch(r"(.*?)(\w+)(\[.*)?", " ".join(p.split())).groups() for p in FUNCTIONS[function].split(",")]
    for kind, name, side in declared:
        value = good.get(f"{function} {name}", good.get(name))
        if "**" in kind:
            yield name, "&", Room("u8")
        elif name == "run" or f"{function} {name}" in MAY_BE_NULL:
            yield name, "?", Room("u1", good["size"] if name == "difference" else 256) if value is None else value
        elif "*" in kind and value is None or (name, kind) == ("slope", "float *"):
            yield name, "[", Room("u1", 256)
        else:
            yield name, "*" if "*" in kind or side else KINDS.get(kind, "#" if name == "n" else "="), value


def call(library, function, arguments):
    status, error, *filled = library.asked(function, *arguments)
    made = re.match(r"cw_(\w+?)_(create|coarser)", function)
    if status == OK and made:
        library.call(f"cw_{made[1]}_destroy", int(filled[0][0]))
    return status, error


def is_fine(library, function, arguments, what):
    status, error = call(library, function, arguments)
    assert status == OK, (function, what, error)


def is_refused(library, function, arguments, name):
    status, error = call(library, function, arguments)
    assert status == ARGUMENT and name in error.partition(":")[0].split(", "), (function, name, status, error)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_each_argument(library, good, function):
    names, kinds, right = zip(*parameters(function, good))
    is_fine(library, function, right, "as it should be")
    for k, (name, kind) in enumerate(zip(names, kinds)):
        def with_one(value, empty=False):
            return [value if p == k else None if empty and kinds[p] == "[" else right[p] for p in range(len(right))]
        if kind == "?":
            is_fine(library, function, with_one(None), name)
        elif kind in "*&[~":
            is_refused(library, function, with_one(np.nan if kind == "~" else None), name)
        if name == "run":  # what a later version would mean by more
            for word in np.eye(6, dtype="u8"):
                is_refused(library, function, with_one(library.run(reserved=word << np.uint64(63))), "cw_run")
        for some in {"#": [0], "@": [*EMPTY, (0, 0, 0, 0)], "%": EMPTY}.get(kind, []):
            is_fine(library, function, with_one(some if kind == "#" else np.array((*some, *right[k][4:]), "u8"), empty=True), f"{name} {some}")


# The last function that takes a struct which callers fill, and as which argument; and the pointers in it that must not be NULL.
FILLED = {name: (function, parameter) for function, text in FUNCTIONS.items() for name, parameter in re.findall(r"const (cw_\w+) \*(\w+)", text)}
FILLED["cw_allocator"] = FILLED["cw_field_desc"]
SAID = {("cw_observer", "height"): "x"}  # of no number there is no place
REQUIRED = {"samples", "field", "allocate", "release", "run"}


@pytest.mark.parametrize("name", [name for name, struct in STRUCTS.items() if "reserved" in struct.names and f"}} {name};" in HEADERS])
def test_each_member(library, good, name):
    function, parameter = FILLED[name]
    allocator = library.struct("cw_allocator", **{part: library.number(part) for part in ("allocate", "release")})
    names, _, right = zip(*parameters(function, good))
    right = dict(zip(names, right))

    def arguments(struct):
        one = struct if name != "cw_allocator" else library.struct("cw_field_desc", allocator=library.keep(struct), **{
            member: right["desc"][member] for member in ("samples", "nx", "ny", "map")})
        return [one if p == parameter else value for p, value in right.items()]
    for member in STRUCTS[name].names:
        struct = (allocator if name == "cw_allocator" else right[parameter]).copy()
        place = STRUCTS[name].fields[member]
        wrong = 0 if (name, member) in POINTERS or member == "at" else 0xff  # all bits set: also a NaN
        struct.view("u1")[place[1]:place[1] + place[0].itemsize] = wrong
        if (name, member) in POINTERS and member not in REQUIRED or member == "at":
            is_fine(library, function, arguments(struct), member)
        else:
            is_refused(library, function, arguments(struct), name if member in ("zero", "reserved") else SAID.get((name, member), member))
        if member == "at":  # empty: then there are no samples either
            struct["samples"] = 0
            is_fine(library, function, arguments(struct), "at and samples")


# ---- queries -----------------------------------------------------------------------------------------------------------------


def test_kernels_that_cannot_answer(library):
    rays = random_rays(2, 5, 5)
    field = library.field(np.random.default_rng(1).random((5, 5)))
    hits, seen = Room(HIT, 2), Room("u1", 2)

    def fails(status, run, field=field):
        for name, room in ("cw_closest", hits), ("cw_occluded", seen):
            found, error, filled = library.asked(name, field, run, rays, 2, room)
            assert found == status and (filled.view("u1") == NOTHING).all(), (name, status, error)
    none = library.run(kernel="packet99")
    for wrong in {"leaf": 3}, {"leaf": -1}, {"isa": 6}:
        fails(ARGUMENT, library.run(**wrong))
    fails(KERNEL, none)
    fails(KERNEL, library.run(kernel="brute", leaf=2))
    library.fails(KERNEL, "cw_closest", field, none, None, 0, None)
    library.fails(KERNEL, "cw_closest_user", field, none, np.zeros(1, STRUCTS["cw_user_ray"]), 1, hits)
    library.fails(KERNEL, "cw_field_build", field, none)
    assert library.number("cw_run_kernel", field, none) == none["expert"]["kernel"][0]
    grid, small = library.run(kernel="grid3d"), library.field(np.zeros((2, 2)))
    fails(NOT_BUILT, grid, small)
    built = [library.describe(small)["bytes_built"]]
    for run in None, grid, grid:  # the default kernel needs the bounds alone
        library.well("cw_field_build", small, run)
        built.append(library.describe(small)["bytes_built"])
    assert built[0] == built[1] > 0 and built[3] == built[2] > built[1]
    library.closest(small, rays, grid)
    library.well("cw_field_update", small, None, library.struct("cw_update", at=(1, 1, 1, 1), samples=library.keep(np.zeros(1, "f4"))))
    fails(NOT_BUILT, grid, small)  # an update drops what it does not keep up to date
    assert library.describe(small)["bytes_built"] == built[0]


def test_errors_say_what_was_wrong(library):
    """The sentence names argument, value and limit."""
    field, rays = library.field(np.zeros((2, 2))), random_rays(1, 2, 2)
    assert library.fails(ARGUMENT, "cw_field_create", library.desc([[0]] * 5), None, Room("u8")) == "nx: 1 samples; a field has 2 to 8388608 a side"
    assert library.fails(KERNEL, "cw_closest", field, library.run(kernel="packet99"), rays, 1, Room(HIT)) == "kernel: there is no kernel of that name"
    assert "of that name" in library.fails(KERNEL, "cw_surface_at", field, library.run(kernel="packet99"), np.zeros(2), 1, Room(HIT))
    assert library.fails(ARGUMENT, "cw_closest", field, None, None, 7, Room(HIT)) == "rays: NULL for 7 rays"
    assert library.asked("cw_closest", field, None, rays, 1, Room(HIT))[:2] == (OK, "rays: NULL for 7 rays")
    assert library.fails(KERNEL, "cw_run_check", None, library.run(kernel="pyramid1", leaf=1)) == "leaf: pyramid1 does not have the leaf test moller-trumbore"


def test_names(library):
    texts = [library.call("cw_status_message", s)[0] for s in (*range(8), -1, 1000)]
    assert len(set(texts[:8])) == 8 and all(len(text) > 5 and text[-1] != "." for text in texts)
    assert [library.call("cw_isa_name", k)[0] for k in (6, -1)] == [library.call("cw_leaf_name", 3)[0]] + ["NULL"]
    assert library.call("cw_leaf_name", 2)[0] == "watertight"
    count = library.number("cw_kernel_count")
    assert library.number("cw_kernel_at", count) == library.number("cw_kernel_at", ALL) == 0
    for k in range(-6, count):
        kernel = library.number("cw_kernel_at", k) if k >= 0 else library.number("cw_kernel_find", [None, "", "packet", "packet99", "none", None][k])
        kernel = 0 if k == -6 else kernel
        info = library.describe_kernel(kernel)
        name, what = (library.call("text", int(info[part]))[0] for part in ("name", "what"))
        assert library.number("cw_kernel_exists", kernel) == (k >= 0) and (kernel != 0) == (k > -6)
        if k < 0:
            assert not info["available"] and name == "none"
        else:
            assert library.number("cw_kernel_find", name) == kernel and info["width"] >= 1 and len(what) > 5 and info["default_leaf"] != 0


def test_structs_that_the_library_fills_grow(library):
    """An older program gets the members that it knows, a newer one zeros for the others."""
    field, info = library.field(np.zeros((3, 4)), np.diag((2, 3, 4, 0))[:3]), STRUCTS["cw_field_info"]
    newer = library.call("cw_field_describe_into", field, Room("u1", info.itemsize + 64), info.itemsize + 64)[1]
    assert newer[:info.itemsize].view(info)["map"][0, 1, 1] == 3 and not newer[info.itemsize:].any()
    older = library.call("cw_field_describe_into", field, Room(info), info.fields["holes"][1])[1]
    assert older["ny"] == 3 and (older["holes"].view("u1") == NOTHING).all()
    kernel = STRUCTS["cw_kernel_info"]
    older = library.call("cw_kernel_describe_into", library.number("cw_kernel_at", 0), Room(kernel), 8)[1]
    assert library.call("text", int(older["name"][0]))[0] == "brute" and older["width"] == 0x5a5a5a5a


def test_arrays_of_any_length_at_any_place(library):
    """Every ray has the answer that it has alone, and nothing is written beside answers (library.c)."""
    most = 67
    z, rays = np.random.default_rng(7).random((17, 17)), random_rays(most, 17, 17)
    field = library.field(z)
    for name, kernel, info in library.kernels():
        run = library.run(kernel=kernel)
        library.well("cw_field_build", field, run)
        single = np.concatenate([library.closest(field, rays[k:k + 1], run) for k in range(most)])
        assert 10 < (single["i"] >= 0).sum() < most - 3
        for n in filter(lambda n: takes(n, 4), range(most + 1)):
            place = 4 * (n % 16)
            hits = library.well("cw_closest", field, run, At(rays[:n], place), n, Room(HIT, n, place))
            seen = library.well("cw_occluded", field, run, At(rays[:n], place), n, Room("u1", n, n % 16))
            assert hits.tobytes() == single[:n].tobytes() and (seen == (single[:n]["i"] >= 0)).all(), (name, n)


# ---- instruction sets --------------------------------------------------------------------------------------------------------

ISAS = ["any", "scalar", "sse4.2", "avx2", "avx512", "neon"]
INCLUDES = {1: [1], 2: [1, 2], 3: [1, 2, 3], 4: [1, 2, 3, 4], 5: [1, 5]}


def common(a, b):
    """The widest set that both include."""
    return max(set(INCLUDES[a]) & set(INCLUDES[b]), key=lambda isa: len(INCLUDES[isa]))


def test_what_includes_what(library):
    for a, b in np.ndindex(6, 6):
        assert library.number("cw_isa_includes", a, b) == (b in INCLUDES.get(a, [])), (a, b)
    assert [library.call("cw_isa_name", k)[0] for k in range(1, 6)] == ISAS[1:]


@pytest.mark.parametrize("value", [None, "", "sse", "AVX2", "avx512 ", "none", *ISAS[1:]])
def test_the_variable_bounds_the_process(folder, value):
    """Names of sets do, and other values do not; a program's limit works within it, whichever comes first."""
    env = {key: text for key, text in os.environ.items() if key != "CELLWALK_ISA"}
    free, bounded, limited = Library(env=env), *(Library(env=env | ({} if value is None else {"CELLWALK_ISA": value})) for _ in range(2))
    machine = free.number("cw_isa_best")
    allowed = common(machine, ISAS.index(value)) if value in ISAS else machine
    limited.call("cw_isa_limit", 0)
    assert bounded.number("cw_isa_best") == limited.number("cw_isa_best") == allowed
    for isa in [k for last in range(1, 6) for other in range(1, 6) for k in (last, other)]:  # down and up
        bounded.call("cw_isa_limit", isa)
        assert bounded.number("cw_isa_best") == common(isa, allowed)
    for isa in 1, allowed, 0:
        bounded.call("cw_isa_limit", isa)
        within = common(isa or allowed, allowed)
        assert all(info["isa"] in INCLUDES[within] for _, _, info in bounded.kernels())
    assert bounded.number("cw_isa_best") == allowed
    bounded.call("setenv", "CELLWALK_ISA", "avx512" if allowed == 1 else "scalar")  # it has been read
    assert bounded.number("cw_isa_best") == allowed
    for program in free, bounded, limited:
        program.end()


def test_a_run_keeps_within_its_limit(library):
    best = library.number("cw_isa_best")
    for isa in range(1, 6):
        used = library.describe_kernel(library.number("cw_run_kernel", None, library.run(isa=isa)))["isa"]
        assert used in INCLUDES[isa] and used in INCLUDES[best]
        for k in range(library.number("cw_kernel_count")):
            kernel = library.number("cw_kernel_at", k)
            info = library.describe_kernel(kernel)
            may = info["available"] and info["isa"] in INCLUDES[isa]
            assert library.asked("cw_run_check", None, library.run(kernel=kernel, isa=isa))[0] == (OK if may else KERNEL)


def test_a_limit_does_not_reach_into_a_query(library):
    """It goes on with the kernel that it has begun with."""
    rays = random_rays(20000, 17, 17)
    field = library.field(np.random.default_rng(7).random((17, 17)))
    run = library.run(kernel=library.number("cw_run_kernel", None, None), watch=library.number("lower_limit"))
    expected = library.closest(field, rays)
    for name, given in ("cw_closest", rays), ("cw_closest_user", rays.astype(STRUCTS["cw_user_ray"])):
        assert library.of_each(name, field, given, HIT, run=run).tobytes() == expected.tobytes()
        assert library.number("cw_isa_best") == 1
        library.call("cw_isa_limit", 0)


def test_every_word_of_the_vocabulary_is_tried():
    """Those that vocabulary.h lists have a row for the test vocabulary, and no others."""
    listed, tried = (set(re.findall(pattern, (SOURCE / file).read_text())) for file, pattern in [
        ("simd/vocabulary/vocabulary.h", r"\bv[fimd]_\w+"), ("tests/core/vocabulary/words.inc.h", r"WORD\((\w+)")])
    assert listed == tried and len(tried) > 50
