# SPDX-License-Identifier: Apache-2.0
"""The .pbrt reader: samples to the last bit; each mistake named with file, line and directive; scenes that ask for more than any
honest one soon refused, with the name of the limit. And the bounds on floods in SECURITY.md: each number is that of the code, and
each measured one is kept, but not by far."""
import ctypes
import os
import pathlib
import random
import re

import numpy as np
import pytest
from program import SOURCE, needs_room, write
from test_pictures import write_image
from words import EMULATOR, Scenes

HEAD = 'LookAt 0 0 0 0 0 1 0 1 0\nCamera "perspective"\nWorldBegin\n'
GRID = HEAD + 'Shape "heightfield" "integer nu" 2 "integer nv" 2'
PLAIN = 'Shape "heightfield" "integer nu" 2 "integer nv" 2 "float Pz" [0 0 0 0]\n'


def load(scenes, text, name="a.pbrt"):
    write(name, text)
    return scenes.facts("load", name)


def load_fails(scenes, text, *messages, name="a.pbrt"):
    """The first one begins what is said."""
    write(name, text)
    said = scenes.refused("", "load", name)
    assert said.startswith(messages[0]) and all(part in said for part in messages), (text, said)


@pytest.fixture
def images(folder):
    """One of four pixels, and one that is none."""
    write_image("good.exr", 2, 2, [.5, .5, .5, 1, 1, 1, 0, 0, 0, .25, .5, 1])
    write("broken.exr", "v/1")


def textured(image, name="t"):
    return f'Texture "{name}" "color" "imagemap" "string filename" "{image}"\nMaterial "matte" "texture Kd" "{name}"\n'


# ---- numbers ----------------------------------------------------------------------------------------------------------------


def test_numbers_are_those_of_c(scenes):
    """In any locale: where the point ends one, half a degree is none."""
    for text in "-", ".", "e5", "nan", "inf", "+-1", "1e", "1e+", "1E-", "0x1":
        load_fails(scenes, f"Translate 1 2 {text}\n", "a.pbrt:1: Translate: ")
    for text in ".5", "5.", "+1.5e+1", "5E-1", "05", "0.000000000000000000000000000000000001234567890123456789e36", "1" + 299 * "0" + "e-298":
        load(scenes, HEAD.replace('"perspective"', f'"perspective" "float fov" {text}') + "WorldEnd\n")


def test_samples_are_rounded_once(scenes):
    """They are what strtof says, not a double rounded a second time: beside the points halfway between two floats, by less than a
    double can tell."""
    strtof = ctypes.CDLL(None).strtof
    strtof.restype = ctypes.c_float
    side, r = 40, random.Random(5)
    texts = ["1.000000059604644775390625000000001", "1.000000059604644775390625", "1.000000178813934326171875", "-7.006492321624086e-46",
             "1267650600228229401496703205376", "1e-46", "-0.0", "16777217", ".5", "5.", "+1e+3", "1E-3", "-0", "1e-400", "9007199254740993", "123456789012345678901234567890",
             "0.000000000000000000000000000000000001234567890123456789"]
    while len(texts) < side * side:
        below = np.float32(r.random() * 2.0 ** r.randint(-4, 3))
        middle = (float(below) + float(np.nextafter(below, np.float32(np.inf)))) / 2
        whole = f"{middle:.40f}"  # all digits are exact, and the last one is a zero
        texts.append(["-" + whole, whole[:-1] + "1", whole, f"{middle:.6f}"][len(texts) % 4])
    numbers = "".join(text + ("\t# word\n" if k % 7 == 3 else " ") for k, text in enumerate(texts))
    load(scenes, HEAD + f'Shape "heightfield" "integer nu" {side} "integer nv" {side} "float Pz" [{numbers}]\nWorldEnd\n')
    wanted = np.array([strtof(text.encode(), None) for text in texts], "f4")
    assert np.fromfile("z", "f4").tobytes() == wanted.tobytes()
    assert (np.array([float(text) for text in texts]).astype("f4") != wanted).sum() > side  # so many tell one rounding from two


# ---- mistakes: a whole file, and what is said behind its name ---------------------------------------------------------------

MISTAKES = [
    *((text, ": the file ends without WorldEnd") for text in ("", HEAD, HEAD + 64 * "AttributeBegin ")),
    ('Camra "perspective"', ":1: Camra: this directive is not supported"),
    ("# comment\n\n  Film 5", ":3: Film: a string is expected"),
    ('Film "movie"', ':1: Film: "movie" is not supported, only "image" is'),
    *((f'Film "image"\n"integer xresolution" {number}', ':2: Film: "integer xresolution" must be a whole number') for number in (0, 1.5)),
    ('Film "image"\n\n"float cropwindow" [0 1 0 1]', ':3: Film: parameter "float cropwindow" is not supported'),
    ('Film "image" "xresolution" 5', ':1: Film: "xresolution" is no parameter'),
    ('Film "image" "integer xresolution" 5 "integer xresolution" 6', ':1: Film: "xresolution" is given twice'),
    ('Film "image" "string filename" ["a"', ':1: Film: "filename": the file ends within its values'),
    *((text, ":1: Film: unterminated string") for text in ('Film "image\n', 'Film "image')),
    ('"', ":1: unterminated string"),
    ('""', ":1: a directive is expected"),
    ('Camera "perspective" "float fov" 180', ':1: Camera: "float fov" must lie between 0 and 180 degrees'),
    ('Camera "perspective" "float fov" "a"', ':1: Camera: "float fov" must be one number'),
    ("LookAt 0 0 0 0 0 0 0 1 0", ":1: LookAt: eye and target coincide"),
    ("LookAt 0 0 0 0 0 1", ":1: LookAt: the file ends: number 7 of 9 is expected"),
    ("Translate 1 2 nan", ":1: Translate: not a number: number 3 of 3 is expected"),
    ("Translate 1 2\n3x", ":2: Translate: malformed number: number 3 of 3 is expected"),
    ("Translate 1 2 1e999", ":1: Translate: a number is too large"),
    ("Rotate 10 0 0 0", ":1: Rotate: the axis has no length"),
    *((text, f":1: {text.split()[0]}: no Camera has been set") for text in ("WorldBegin", 'CoordSysTransform "camera"')),
    (HEAD + 'CoordSysTransform "world"', ':4: CoordSysTransform: only "camera" is supported'),
    (HEAD + 'Camera "perspective"', ":4: Camera: it must stand before WorldBegin"),
    (PLAIN, ":1: Shape: it must stand after WorldBegin"),
    (HEAD + "WorldEnd\nWorldEnd", ":5: WorldEnd: nothing may follow WorldEnd"),
    (HEAD + "AttributeEnd", ":4: AttributeEnd: there is no AttributeBegin for it"),
    (HEAD + 65 * "AttributeBegin ", ":4: AttributeBegin: too many levels"),
    (HEAD + "AttributeBegin\nWorldEnd", ":5: WorldEnd: an AttributeBegin has no AttributeEnd"),
    (HEAD + 'Shape "sphere"', ':4: Shape: "sphere" is not supported, only "heightfield" and "cylinder" are'),
    (HEAD + 'Shape "cylinder" "float radius" 2', ':4: Shape "cylinder": parameter "float radius" is not supported'),
    (HEAD + 'Scale 1 0 1\nShape "cylinder"', ':5: Shape "cylinder": the current transform cannot be inverted'),
    (HEAD + 'Scale 1 1 1e-22\nShape "cylinder"', ':5: Shape "cylinder": a unit of the cylinder\'s space is shorter than 1e-18 or longer than 1e18'),
    (HEAD + "Scale 1e25 1 1\n" + PLAIN, ':5: Shape "heightfield": a unit of field space is shorter than 1e-18 or longer than 1e18'),
    ("Scale 1e25 1e25 1e25\n" + HEAD, ":3: Camera: a unit of the camera's space is shorter than 1e-18 or longer than 1e18"),
    (HEAD + "Scale 1 0 1\n" + PLAIN, ':5: Shape "heightfield": map: not finite, or it cannot be inverted'),
    (HEAD + 'Shape "heightfield" "integer nu" 2 "float Pz" [0]', ':4: Shape "heightfield": "integer nv" is missing'),
    (GRID, ':4: Shape "heightfield": "float Pz" with numbers is missing'),
    *((HEAD + f'Shape "heightfield" "integer nu" {nu} "integer nv" 2 "float Pz" [0 0]',
       ':4: Shape "heightfield": "integer nu" must be a whole number from 2 to 8388608') for nu in (1, 10**12)),
    (HEAD + 'Shape "heightfield" "integer nu" 8000000 "integer nv" 8000000\n"float Pz" [0 0]',
     ':5: Shape "heightfield": "float Pz" has 2 values; nu 8000000 times nv 8000000 are 64000000000000'),
    (GRID + '\n"float Pz" [0 0 0\n0 0]', ':5: Shape "heightfield": "float Pz" has 5 values; nu 2 times nv 2 are 4'),
    (GRID + '\n"float Pz" [0 0\nnan 0]', ':6: Shape "heightfield": "Pz": value 3 is not a number but nan'),
    (GRID + ' "float Pz" [0 0\n1e39 0]', ':5: Shape "heightfield": "Pz": 1e39 is too large for a float'),
    (GRID + ' "float Pz" [0 0\n1.2.3 0]', ':5: Shape "heightfield": "Pz": malformed number'),
    (GRID + ' "float Pz" [0 0 0 0', ':4: Shape "heightfield": "Pz": the file ends within its values'),
    (HEAD + 'Material "glass"', ':4: Material: "glass" is not supported, only "matte" and "mirror" are'),
    (HEAD + 'Material "matte" "color Kd" [1 2]', ':4: Material: "color Kd" must be three numbers'),
    (HEAD + 'Material "matte" "float sigma" 20', ':4: Material: "sigma" must be 0'),
    (HEAD + 'Material "matte" "texture Kd" "none"', ':4: Material: texture "none" is not defined'),
    (HEAD + 'AttributeBegin\nTexture "t" "color" "imagemap" "string filename" "a.exr"\nAttributeEnd\nMaterial "matte" "texture Kd" "t"',
     ':7: Material: texture "t" is not defined'),
    (HEAD + 'Texture "t" "color" "checkerboard"', ':4: Texture: "color" "checkerboard" is not supported'),
    (HEAD + 'Texture "t" "color" "imagemap"', ':4: Texture: "string filename" is missing'),
    (HEAD + textured("broken.exr"), ":4: Texture: broken.exr: not a readable OpenEXR picture"),
    (HEAD + textured("gone.exr"), ":4: Texture: gone.exr: "),
    (HEAD + 'LightSource "distant"', ':4: LightSource: "distant" is not supported, only "point" is'),
    (HEAD + 'LightSource "point" "point from" [0 0 0]', ':4: LightSource: parameter "point from" is not supported'),
    (HEAD + "\n]", ":5: ]: a directive is expected"),
    (HEAD + "Include", ":4: Include: a string is expected"),
]


def test_mistakes_are_named(scenes, images):
    os.rename("good.exr", "a.exr")
    for text, message in MISTAKES:
        load_fails(scenes, text, "a.pbrt" + message)
    assert scenes.refused("", "load", "missing.pbrt").startswith("missing.pbrt: cannot read: No such file")
    scenes.refused(".: cannot read: ", "load", ".")


def test_cut_files_are_refused(scenes):
    """Every beginning of a scene is read without harm, and only the whole is a scene."""
    text = (HEAD + 'AttributeBegin # c\nScale 1 1 2\nMaterial "matte" "color Kd" [1 .5 2]\n' + PLAIN +
            'Shape "cylinder"\nAttributeEnd\nLightSource "point" "color I" [1 1 1]\nWorldEnd')
    for n in range(len(text)):
        load_fails(scenes, text[:n], "a.pbrt:")
    load(scenes, text)


def test_includes_are_followed_and_not_in_circles(scenes):
    """A mistake in an included file is named with that file. Names are relative to the folder of the first one."""
    write("plain.pbrt", PLAIN)
    assert load(scenes, HEAD + 2 * 'Include "plain.pbrt"\n' + "WorldEnd\n").fields == 2
    load_fails(scenes, HEAD + '\nInclude "no.pbrt"\n', "a.pbrt:5: Include: no.pbrt: cannot read: No such file or directory")
    load_fails(scenes, HEAD + 'Include "a.pbrt"\n', "a.pbrt:4: Include: a.pbrt includes itself")
    write("second.pbrt", '\nInclude "./a.pbrt"\n')
    load_fails(scenes, HEAD + 'Include "second.pbrt"\n', "second.pbrt:2: Include: ")
    write("wrong.pbrt", "Translate 1\n2\nz")
    load_fails(scenes, HEAD + 'Include "wrong.pbrt"\nWorldEnd', "wrong.pbrt:3: Translate: ")
    os.mkdir("folder")
    write("folder/part.pbrt", PLAIN)
    assert load(scenes, HEAD + 'Include "part.pbrt"\nWorldEnd', name="folder/whole.pbrt").fields == 1
    for k in range(40):
        write(f"chain{k}.pbrt", f'Include "chain{k + 1}.pbrt"\n')
    assert ":1: Include: too many levels" in scenes.refused("", "load", "chain0.pbrt")


def test_the_first_error_is_told(scenes, images):
    """What stands first in the file."""
    for first, second, line, message in [
            ("good", "good", "", None), ("good", "good", "Wrong\n", "Wrong: "), ("broken", "good", "Wrong\n", ": Texture: broken.exr: "),
            ("good", "broken", "Wrong\n", ": Texture: broken.exr: "), ("good", "broken", "", ": Texture: broken.exr: "),
            ("broken", "gone", "", ": Texture: broken.exr: "), ("gone", "broken", "", ": Texture: gone.exr: ")]:
        text = HEAD + textured(f"{first}.exr") + PLAIN + textured(f"{second}.exr") + line + PLAIN + "WorldEnd\n"
        if message:
            load_fails(scenes, text, "a.pbrt:", message)
        else:
            load(scenes, text)


def test_what_changes_nothing_is_a_warning(scenes):
    found = load(scenes, 'Accelerator "grid" "bool refine" "false"\nFilm "image" "bool display" ["true"] "integer xresolution" 12\n'
                 'Sampler "lowdiscrepancy" "integer pixelsamples" [3]\n' + HEAD + "WorldEnd\n")
    assert [warning.split(": ")[:2] for warning in found.warnings] == [["a.pbrt:1", "Accelerator"], ["a.pbrt:2", "Film"], ["a.pbrt:3", "Sampler"]]
    assert (found.width, found.height) == (12, 480)


# ---- floods -----------------------------------------------------------------------------------------------------------------


def test_included_files_are_counted(scenes):
    for level in range(12):
        write(str(level), 10 * f'Include "{level + 1}"\n' if level < 11 else "")
    load_fails(scenes, HEAD + 'Include "0"\nWorldEnd\n', "", "more than 4096 files are included")
    os.truncate("0", 1 << 34)
    load_fails(scenes, HEAD + 'Include "0"\n', "a.pbrt:4: Include: more than 17179869184 bytes are included")


def test_only_files_are_read(scenes):
    os.mkfifo("pipe")
    os.mkfifo("pipe.exr")
    os.symlink("/dev/zero", "zero.exr")
    for lines in *(f'Include "{name}"\n' for name in ("pipe", "/dev/zero")), *(textured(name) + PLAIN for name in ("pipe.exr", "zero.exr")):
        load_fails(scenes, HEAD + lines + "WorldEnd\n", "", "not a regular file")


def test_films_are_bounded(scenes):
    film = 'Film "image" "integer xresolution" {0} "integer yresolution" {0}\n' + HEAD + "WorldEnd\n"
    load_fails(scenes, film.format(65536), "a.pbrt:1: Film: 65536 x 65536 pixels are more than 268435456")
    load(scenes, film.format(16384))


def test_small_files_hold_no_large_pictures(files, scenes, images):
    """A size that a header claims which is whole otherwise. A longer file could hold it, but one image of four pixels leaves no room for it."""
    data = pathlib.Path("good.exr").read_bytes()
    for side in 1600000, 16383:
        box = np.array([0, 0, side, side], "<i4").tobytes()
        claim = re.sub(rb"((?:data|display)Window\0box2i\0....).{16}", lambda match: match[1] + box, data, flags=re.DOTALL)
        assert claim.count(box) == 2
        write("a.exr", claim)
        files.refused("bytes can hold", "image", "a.exr")
    write("a.exr", claim + bytes(1 << 13))
    load_fails(scenes, HEAD + textured("good.exr") + textured("a.exr"), "a.pbrt:6: Texture: a.exr: 16384 x 16384 pixels are more than 268435452,")


def test_warnings_end(scenes):
    """A mistake behind many warnings is named with its line; of these the first hundred are told."""
    write("a.pbrt", 40000 * 'Accelerator "bvh"\n' + HEAD + 'Material "matte" "float first" 1\n"float second" 2\n')
    scenes.refused("a.pbrt:40004: Material: ", "load", "a.pbrt")
    write("a.pbrt", 40000 * 'Accelerator "bvh"\n' + HEAD + "WorldEnd\n")
    *said, last = scenes.facts("load", "a.pbrt").warnings
    assert len(said) == 100 and "further warnings" in last
    assert all(text.startswith(f"a.pbrt:{line}: Accelerator: skipped") for line, text in enumerate(said, 1))


LIGHT = 'LightSource "point" "color I" [8 8 8]\n'
FLOODS = {"render_fields": LIGHT + 10000 * PLAIN, "render_lights": 1000 * LIGHT + 1000 * 'Shape "cylinder"\n'}


def test_the_table_of_bounds_is_true():
    code = "".join(file.read_text() for file in pathlib.Path(SOURCE, "src").rglob("*.h"))
    security = pathlib.Path(SOURCE, "SECURITY.md").read_text().split("\n## Floods\n")[1].split("\n## ")[0]
    table = {name: int(value) for value, name in re.findall(r"^\|[^|]+\| (\d+) \| `([^`]+)` \|", security, re.MULTILINE)}
    assert len(table) == 10 and set(FLOODS) < set(table)
    for name, value in table.items():
        if name not in FLOODS:
            (number, shift), = re.findall(rf"\b{name} = (?:\(uint64_t\))?(\d+)(?: << (\d+))?[ ,;]", code)
            assert int(number) << int(shift or 0) == value, name
            continue
        flooded = Scenes()
        load(flooded, 'LookAt 0 0 -5 0 0 0 0 1 0\nCamera "perspective"\nFilm "image" "integer xresolution" 16 "integer yresolution" 16\n'
             "WorldBegin\n" + FLOODS[name] + "WorldEnd\n")
        flooded.render(threads=1)
        most, = re.findall(r"VmHWM:\s*(\d+) kB", pathlib.Path(f"/proc/{flooded.process.pid}/status").read_text())
        flooded.end()
        if not EMULATOR and not needs_room(flooded.process.args[-2]):
            assert value / 2 < int(most) / 1000 <= value, (name, most)
