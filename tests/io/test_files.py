# SPDX-License-Identifier: Apache-2.0
"""Arrays, tables, pictures and coordinate systems: what is written is read back, and each mistake is named with file and place."""
import os
import struct

import numpy as np
import pytest
from words import Files
from program import entries, header, npy, read, write

# ---- .npy -----------------------------------------------------------------------------------------------------------------

BYTES = header("'|u1'", shape="(200,)")


def test_written_arrays_are_read(files):
    text = "".join(chr(33 + k % 90) for k in range(4000))
    files("npy create", "a.npy", 1000)
    for at in range(0, 4000, 700):
        files("write", 0, text[at:at + 700])
    files("commit", 0)
    assert entries() == ["a.npy"] and np.load("a.npy").tobytes() == text.encode()
    type, offset, shape = files("npy", "a.npy").split()
    assert (type, shape) == ("<f4", "(1000,)") and int(offset) % 64 == 0
    files("rows", 0, 1000)
    assert read("rows") == text.encode()


def test_arrays_that_are_too_long_are_not_created(files):
    files.refused("a.npy", "npy create", "a.npy", 2**63 - 1)
    files("discard", 0)
    assert entries() == []


@pytest.mark.parametrize("version", [1, 2, 3])
@pytest.mark.parametrize("text", [header(shape="(1000, 3)"), header(shape="(1000, 3)") + " ",
                                  '{"shape":(1000L,3,),"fortran_order":False,"descr":"<f4"}\n'])
def test_windows_show_their_rows(files, text, version):
    """At aligned and at odd places of the file."""
    data = bytes(k & 255 for k in range(12000))
    offset = npy(text, data, version)
    assert files("npy", "a.npy") == f"<f4 {offset} (1000, 3)"
    for first, count in (0, 1000), (0, 1), (1, 1), (999, 1), (1000, 0), (341, 400), (342, 399), (342, 399), (0, 0):
        assert files("rows", first, count) == "0" and read("rows") == data[12 * first:12 * (first + count)]


def test_growth_and_replacement_change_nothing(files):
    npy(BYTES, bytes(range(200)))
    files("npy", "a.npy")
    with open("a.npy", "ab") as file:
        file.write(b"\xff" * 10000)
    for _ in range(2):
        for row in range(0, 200, 50):
            files("rows", row, 50)
            assert read("rows") == bytes(range(row, row + 50))
        write("other", "x")
        os.rename("other", "a.npy")
    files.refused("a.npy: not a .npy file", "npy", "a.npy")


def test_shrinking_is_an_error(files):
    offset = npy(BYTES, bytes(200))
    files("npy", "a.npy")
    files("rows", 0, 100)
    os.truncate("a.npy", offset + 150)
    for _ in range(2):
        files.refused("a.npy: the file ends at byte", "rows", 100, 100)


@pytest.mark.parametrize("version", [1, 2, 3])
def test_every_truncation_is_seen(files, version):
    npy(header() + "   \n", bytes(24), version)
    whole = read("a.npy")
    for cut in range(len(whole)):
        write("a.npy", whole[:cut])
        files.refused("a.npy: truncated" if cut else "a.npy: not a .npy file", "npy", "a.npy")
    write("a.npy", whole + b"\0")
    files.refused("a.npy: too long", "npy", "a.npy")


HEADERS = {
    "": "start with {",
    "{}": "missing",
    "{'descr': '<f4', 'fortran_order': False}": "missing",
    "{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (2, 3)}": "second time",
    "{'descr': '<f4', 'colour': False, 'shape': (2, 3)}": "key is unknown",
    "{'descr': '<f4' 'fortran_order': False, 'shape': (2, 3)}": "comma or }",
    "{'descr' '<f4', 'fortran_order': False, 'shape': (2, 3)}": "colon",
    "{'descr': '<f4, \"fortran_order\": False, \"shape\": (2, 3)}": "not closed",
    "{descr: '<f4', 'fortran_order': False, 'shape': (2, 3)}": "quoted word",
    header() + "x": "only blanks",
    header(order="True"): "Fortran order",
    header(order="0"): "True or False",
    header(shape="[2, 3]"): "start with (",
    header(shape="(6)"): "has a comma",
    header(shape="(2 3)"): "comma or )",
    header(shape="(-2, -3)"): "size should stand",
    header(shape="(2.0, 3)"): "comma or )",
    header(shape="(18446744073709551616,)"): "too large",
    header(shape="(4294967296, 4294967296)"): "too large",
    header(shape="(1000000000, 1000000000)"): "truncated",
    header(shape="(1000000000, 8)"): "truncated",
    header(shape="(1, 1, 1, 1, 1, 1, 1, 2, 3)"): "many dimensions",
    header(shape="(2, 2)"): "too long",
    header(shape="(0, 3)"): "too long",
    header("'|O'"): "type '|O'",
    header("'<U4'"): "type '<U4'",
    header("'<f3'"): "type '<f3'",
    header("''"): "type ''",
    header("[('x', '<f4')]"): "records"}


def test_headers_are_read_strictly(files):
    for text, part in HEADERS.items():
        npy(text, bytes(24))
        assert files.refused(part, "npy", "a.npy").startswith("a.npy: "), text
    npy(header(), bytes(24), 4)
    files.refused("version 4.0", "npy", "a.npy")
    long = b"\x93NUMPY\2\0" + struct.pack("<I", 10**9) + b"{"
    write("a.npy", long + b" " * 51)
    files.refused("1000000000 bytes", "npy", "a.npy")
    with open("a.npy", "wb") as file:  # which takes no room on the disk
        file.write(long)
        file.truncate(10**9 + 101)
    files.refused("1000000000 bytes long; no array", "npy", "a.npy")


def test_types_are_told_apart(files):
    npy(header("'>f4'"), bytes(24))
    files("npy", "a.npy")
    files.refused("a.npy: holds elements of type '>f4', not '<f4', '<f8'; in NumPy, a.astype('<f4') converts", "types", "<f4", "<f8")
    files("types", "<f4", ">f4")


def test_only_files_are_read(files):
    for name, part in ("absent.npy", "No such file"), (".", "Is a directory"), ("/dev/null", "not a regular file"):
        assert files.refused(part, "npy", name).startswith(name)


# ---- heights in arrays ------------------------------------------------------------------------------------------------------

HEIGHTS = np.array([[0, 1, 2, 3], [40, 500, 6000, 32767], [8, 9, 10, 11]], float)


@pytest.mark.parametrize("type, first", [("<f4", [0, 1, 2]), ("<f8", [np.nan, np.inf, 1.0000000633]), ("<i2", [-32768]), ("<u2", [65535])])
def test_arrays_of_every_type_are_rasters(files, type, first):
    z = HEIGHTS.copy()
    z.flat[:len(first)] = first  # the ends of the ranges; the last one is rounded
    np.save("a.npy", z.astype(type))
    os.rename("a.npy", "a.NPY")
    found = files.raster("a.NPY")
    np.testing.assert_array_equal(found.z, z.astype("f4"))
    assert (found.map == np.eye(3, 4)).all()


def test_bad_arrays_are_no_rasters(files):
    for type in "|u1", ">f4":
        np.save("a.npy", HEIGHTS.astype(type))
        files.raster_refused(f"'{type}'", "a.npy")
    z = HEIGHTS.copy()
    z[1, 3] = -1e39
    np.save("a.npy", z)
    files.raster_refused("[1, 3] is -1e+39", "a.npy")
    np.save("a.npy", HEIGHTS[0, :2])
    files.raster_refused("shape (2,)", "a.npy")
    files.raster_refused("No such file", "absent.npy")
    for shape in "(9223372036854775807, 0)", "(0, 1000000000)", "(0, 0)":  # however long the other side is
        for type in "<f8", "<i2", "<f4":
            npy(header(f"'{type}'", shape=shape))
            files.raster_refused("holds no samples", "a.npy")


def test_the_caller_may_know_more(files):
    np.save("a.npy", HEIGHTS.astype("f4"))
    found = files.raster("a.npy", nodata=(500, 6000), cellsize=30, zscale=0.5)
    np.testing.assert_array_equal(found.z, np.where((HEIGHTS == 500) | (HEIGHTS == 6000), np.nan, HEIGHTS).astype("f4"))
    assert found.map.tolist() == [[30, 0, 0, 0], [0, -30, 0, 60], [0, 0, 0.5, 0]]  # the first row in the north
    assert (found.placed, found.has_nodata, found.nodata) == (1, 1, 500)
    found = files.raster("a.npy", north_up=1)
    assert found.map.tolist() == [[1, 0, 0, 0], [0, -1, 0, 2], [0, 0, 1, 0]] and found.placed == 0 and found.warnings
    files.raster_refused("has one band", "a.npy", band=2)


@pytest.mark.parametrize("modules", [{"CELLWALK_MODULES": "/nonexistent"}, {}])
def test_without_its_module_gdal_is_named(folder, modules):
    """Which GDAL's own tests have. It is looked for beside the program, too."""
    files = Files(env={**{name: value for name, value in os.environ.items() if name != "CELLWALK_MODULES"}, **modules})
    write("a.tif", "II*")
    for name in "a.tif", "field.asc", "npy":
        files.raster_refused("only .npy is read without GDAL", name)
    files.raster_refused("libgdal-dev", "a.tif")
    files.refused(".npy and .png do without", "can write", "out.tif", 1)
    files.end()


# ---- tables -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text, rows", [
    ("x,y\n1,2\n3,4\n", [(2, "1", "2"), (3, "3", "4")]),
    ("x,y\n1,2", [(2, "1", "2")]),
    ("x,y\n1,", [(2, "1", "")]),
    ("x,y", []),
    (" x\t, y \n 1 ,\t2 \n", [(2, "1", "2")]),
    ("\ufeffx,y\r\n1,2\r\n", [(2, "1", "2")]),
    ("x,y\r1,2\r", [(2, "1", "2")]),
    ('"x","y"\n"1,5","a ""b"""\n', [(2, "1,5", 'a "b"')]),
    ('x,y\n " 1" ,b"c\n', [(2, " 1", 'b"c')]),
    # Lines without cells are passed over; those within cells count.
    ("\n  \nx,y\n\n \t\n1,2\n   ", [(6, "1", "2")]),
    ("\r\n\r\nx,y\r\n\r\n1,2\r\n\r\n", [(5, "1", "2")]),
    *((end.join(["x,y", '"a', 'b",1', "2,3", ""]), [(2, f"a{end}b", "1"), (4, "2", "3")]) for end in ("\n", "\r\n", "\r"))])
def test_cells(files, text, rows):
    write("t.csv", text)
    wanted = "x\x1fy\x1f" + "".join(f"\x1e{line}\x1f{x}\x1f{y}\x1f" for line, x, y in rows)
    assert files("table", "t.csv") == wanted


EMPTY = "is empty; its first line should name the columns"


@pytest.mark.parametrize("text, message", [
    ("", f": {EMPTY}"),
    ("\ufeff", f": {EMPTY}"),
    (" \n\n", f": {EMPTY}"),
    ("x;y\n1;2\n", ":1: cells are separated by semicolons; a comma should stand between them, and a point in decimal numbers"),
    ("x\ty\n", ":1: cells are separated by tabs; a comma should stand between them, and a point in decimal numbers"),
    ("x,y\n1,2\n1,2,\n", ":3: the line has 3 cells where the first one names 2 columns"),
    ("," * 20000, ":1: names more than 16384 columns"),
    ("x,y\n1\n", ":2: the line has 1 cell where the first one names 2 columns"),
    ('x,y\n1,2\n3,"4\n5,6\n', ":3: a quotation mark has no end"),
    ('x,y\n"1"2,3\n', ":2: text stands behind a quotation mark that ends a cell"),
    ("x,y\n1,\0002\n", ": is no text in UTF-8: it has zero bytes, as UTF-16 has")])
def test_mistakes_in_tables(files, text, message):
    write("t.csv", text)
    assert files.refused("", "table", "t.csv") == "t.csv" + message


def test_numbers_in_tables_are_decimal(files):
    for text in "0", "-1.5", "+2", ".5", "5.", "1e3", "1E-3", "1e-400":
        write("t.csv", f"x\n{text}\n")
        files("number", "t.csv")
        assert read("number") == struct.pack("d", float(text)), text
    for text in "nan", "inf", "1e999", "0x10", "1e", "--1", "1.2.3", "1 2", "1_0", "e", ".":
        write("t.csv", f"x\n{text}\n")
        assert files.refused("", "number", "t.csv") == f"t.csv:2: '{text}' stands where a number should, in x"
    write("t.csv", "x,y\n,1\n")
    assert files.refused("", "number", "t.csv") == "t.csv:2: x is empty where a number should stand"


def test_columns_are_found_by_name(files):
    """Whatever the case; those without a meaning are named."""
    write("t.csv", "X,height,y,Y,note\n1,2,3,4,5\n")
    said = "t.csv: passed over: 'height', 'y', 'Y'; columns with a meaning are x, z and note"
    assert files("columns", "t.csv", 3, 1) == f"warning={said}\n0 5 4 "
    assert files.refused("", "columns", "t.csv", 3, 2) == "t.csv: has no column 'z'; its first line names X, height, y, Y, note"
    assert files.refused("", "columns", "t.csv", 4, 1) == "t.csv: two columns have the name 'y'"
    write("t.csv", "X,Z\n1,2\n")
    assert files("columns", "t.csv", 2, 2) == "0 1 "


def test_a_table_may_be_wide(files):
    write("t.csv", 2 * (16384 * ",1" + "\n")[1:])
    assert files("table", "t.csv").count("\x1e") == 1


# ---- pictures ---------------------------------------------------------------------------------------------------------------

WIDTH, HEIGHT = 37, 29


@pytest.fixture
def pixels(files):
    """All sizes that a half can and cannot hold, both signs, and values halfway between two halves."""
    random = np.random.default_rng(7)
    pixels = (random.uniform(-1, 1, (HEIGHT, WIDTH, 3)) * 2 ** random.uniform(-30, 15, (HEIGHT, WIDTH, 3))).astype("f4")
    pixels.flat[:7] = 65504, 65519, 2.0**-24, 1.5 * 2.0**-24, 1.00048828125, 1.00146484375, 0
    write("rgb", pixels.tobytes())
    if "OpenEXR" in files.ask("image write", "a.exr", WIDTH, HEIGHT)[1]:
        pytest.skip("this build lacks OpenEXR")
    return pixels


def test_pictures_are_rounded_to_the_nearest_half(files, pixels):
    files("image write", "a.exr", WIDTH, HEIGHT)
    assert files("image", "a.exr") == f"{WIDTH} {HEIGHT}"
    halves = np.fromfile("halves", "<f2").reshape(HEIGHT, WIDTH, 4)
    with np.errstate(over="ignore"):
        wanted = pixels.astype("<f2")
    assert halves[..., :3].tobytes() == wanted.tobytes() and not halves[..., 3].any()


def test_png_is_whole(files, pixels):
    if not files.ask("image write", "a.png", WIDTH, HEIGHT)[0]:
        pytest.skip("this build lacks libpng")
    data = read("a.png")
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and data[16:26] == struct.pack(">IIBB", WIDTH, HEIGHT, 8, 2) and data[-8:-4] == b"IEND"


def test_damaged_pictures_are_refused(files, pixels):
    files("image write", "whole.exr", WIDTH, HEIGHT)
    write("a.gif", "GIF")
    write("word.exr", "hello")
    for name, part in ("missing.exr", "No such file"), ("a.gif", "unknown kind of picture"), ("word.exr", "not a readable OpenEXR picture"):
        assert files.refused(part, "image", name).startswith(name)
    whole = read("whole.exr")
    for size in range(0, len(whole), 97):
        write("cut.exr", whole[:size])
        assert files.refused("", "image", "cut.exr").startswith("cut.exr")


def exr(width, lines):
    """A picture of one grey channel and as many lines as bytes are given, without compression."""
    window, y = struct.pack("<4i", 0, 0, width - 1, len(lines) - 1), b"Y\0" + struct.pack("<4i", 1, 0, 1, 1) + b"\0"
    head = b"v/1\1\2\0\0\0" + b"".join(b"%s\0%s\0%s" % (name, type, struct.pack("<i", len(value)) + value) for name, type, value in [
        (b"channels", b"chlist", y), (b"compression", b"compression", b"\0"), (b"dataWindow", b"box2i", window), (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", b"\0"), (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        (b"screenWindowCenter", b"v2f", bytes(8)), (b"screenWindowWidth", b"float", struct.pack("<f", 1))]) + b"\0"
    chunks = [struct.pack("<2i", k, len(line)) + line for k, line in enumerate(lines)]
    places = [len(head) + 8 * len(lines) + sum(map(len, chunks[:k])) for k in range(len(lines))]
    return head + struct.pack(f"<{len(lines)}Q", *places) + b"".join(chunks)


def test_lines_of_another_length_are_refused(files, pixels):
    """Of which the library would show the memory behind them."""
    lines = np.arange(12, dtype="<f2").reshape(3, 4)
    write("a.exr", exr(4, [line.tobytes() for line in lines]))
    assert files("image", "a.exr") == "4 3" and np.fromfile("halves", "<f2").reshape(3, 4, 4)[..., 1].tobytes() == lines.tobytes()
    write("a.exr", exr(200, [line.tobytes() for line in lines]))
    files.refused("a.exr: cannot read", "image", "a.exr")


def test_pictures_that_cannot_be_written_leave_nothing(files, pixels):
    for name in "full.png", "full.exr":
        os.symlink("/dev/full", name)
    before = entries()
    files.refused("OpenEXR needs a regular file", "image write", "full.exr", WIDTH, HEIGHT)
    _, said = files.ask("image write", "full.png", WIDTH, HEIGHT)
    assert "No space left" in said or "libpng" in said or "no library for it" in said
    files.refused(".exr", "image write", "a.jpg", WIDTH, HEIGHT)  # says what can be written
    files.refused("none/a.exr", "image write", "none/a.exr", WIDTH, HEIGHT)
    assert entries() == before


# ---- coordinate systems -----------------------------------------------------------------------------------------------------

DEGREE, NEW = 0.0174532925199433, 'DATUM["d",ELLIPSOID["e",6378137,298,LENGTHUNIT["metre",1]]]'
SYSTEMS = {
    "UTM [32]": ('PROJCS["UTM [32]",GEOGCS["WGS",DATUM["D",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0],'
                 'UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["Scale",0.9996],'
                 'UNIT["Foot_US",0.3048006096012192]]', 0.3048006096012192, 6378137),
    "GCS": ('GEOGCS["GCS", DATUM["D", SPHEROID["Sphere", 6371000, 0]], UNIT["Degree", 0.0174532925199433]]', DEGREE, 6371000),
    "both": ('COMPD_CS["both",PROJCS["a",UNIT["m",1]],VERT_CS["h",UNIT["ft",0.3048]]]', 1, 0),
    "no unit": ('PROJCS["no unit",GEOGCS["b",UNIT["Degree",0.0174532925199433]]]', 0, 0),
    "new": (f'PROJCRS["new",BASEGEOGCRS["b",{NEW}],CS[Cartesian,2],AXIS["x",east],LENGTHUNIT["metre",1]]', 1, 6378137),
    "by axis": (f'PROJCRS["by axis",BASEGEOGCRS["b",{NEW}],CONVERSION["c",PARAMETER["p",1,LENGTHUNIT["km",1000]]],CS[Cartesian,2],'
                'AXIS["x",east,LENGTHUNIT["ft",0.3048]],AXIS["y",north,LENGTHUNIT["ft",0.3048]]]', 0.3048, 6378137)}


@pytest.mark.parametrize("name", SYSTEMS)
def test_systems_in_text(files, name):
    """What the Python module takes of coordinate systems that others give it."""
    text, unit, semi_major = SYSTEMS[name]
    found, numbers = files.facts("system", text), np.fromfile("georef")
    assert found.name == name and found.geographic == (name == "GCS") and (numbers[0], numbers[2]) == (unit, semi_major)


def test_texts_without_a_system(files):
    for text in "no system", 'PROJCS["open':
        files.refused("", "system", text)
