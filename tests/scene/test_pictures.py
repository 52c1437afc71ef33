# SPDX-License-Identifier: Apache-2.0
"""Pictures against closed formulas. The renderer leaves out what a scene does not require: that changes no pixel. Nor do kernels,
threads, instruction sets, and what part of a picture is rendered."""
import os

import numpy as np
import pytest
from program import taken, takes, write
from words import Files

SIDE = 64
HEAD = ('Film "image" "integer xresolution" 64 "integer yresolution" 64\nSampler "bestcandidate" "integer pixelsamples" 16\n'
        'LookAt 0 0 0 0 0 1 0 1 0\nCamera "perspective" "float fov" 90\nWorldBegin\n')
INTENSITY = np.array([3, 2, 1])
LIGHT = 'LightSource "point" "color I" [3 2 1]\n'
FLAT = 'Shape "heightfield" "integer nu" 2 "integer nv" 2 "float Pz" [0 0 0 0]\n'
SQUARE = "Translate -1 -1 2\nScale 2 2 1\n" + FLAT
TUBE = 'Rotate 90 1 0 0\nScale 1 1 0.5\nShape "cylinder"\n'


def within(*lines):
    return "AttributeBegin\n" + "".join(lines) + "AttributeEnd\n"


def load(scenes, text):
    write("a.pbrt", text)
    scenes("load", "a.pbrt")


def picture(scenes, *lines):
    load(scenes, HEAD + "".join(lines) + "WorldEnd\n")
    return scenes.render(threads=1)


def write_image(name, width, height, rgb):
    np.asarray(rgb, "f4").tofile("rgb")
    files = Files()
    if "OpenEXR" in files.ask("image write", name, width, height)[1]:
        pytest.skip("this build lacks OpenEXR")
    files.end()


# ---- closed formulas ----------------------------------------------------------------------------------------------------------


def compare(pixels, formula):
    """Light from the direction (x, y, 1), before intensity. Pixels that are cut by an edge are left out, where the formula jumps:
    the mean over a pixel is the formula at nine points by Simpson's rule; sixteen samples a pixel are within a hundredth of it."""
    at = np.arange(2 * SIDE + 1) / SIDE - 1
    light = formula(*np.meshgrid(at, -at))
    nine = np.array([light[j:j + 2 * SIDE:2, i:i + 2 * SIDE:2] for j in range(3) for i in range(3)])
    mean = np.tensordot(np.outer([1, 4, 1], [1, 4, 1]).ravel() / 36, nine, 1)
    whole = nine.max(0) - nine.min(0) <= 0.2 * nine.max(0)
    wanted = mean[whole, None] * INTENSITY
    assert (np.abs(pixels[whole] - wanted) <= 0.01 * wanted).all() and whole.sum() > SIDE * SIDE / 2


def square_light(x, y):
    """A square of side 2 at z = 2 with Kd 0.5, light at the eye: Kd / pi · I cos / d²."""
    slant = x * x + y * y + 1
    return np.where((abs(2 * x) <= 1) & (abs(2 * y) <= 1), 0.5 / np.pi / (4 * slant**1.5), 0)


def tube_light(x, y):
    """Inside of a cylinder of radius 1 along the y axis: it stands square to the ways from the axis to it."""
    t = 1 / np.sqrt(x * x + 1)
    return np.where(abs(y * t) <= 0.5, 0.5 / np.pi / (t * t * (x * x + y * y + 1)) ** 1.5, 0)


def shadowed_light(x, y):
    """The square in the shadow of a smaller one at z = 1, the light at x = -1."""
    def lit(px, py, z):
        return 0.5 / np.pi * z / ((1 + px) ** 2 + py**2 + z * z) ** 1.5
    px, py = 2 * x, 2 * y
    hidden = (abs((px - 1) / 2) <= 0.25) & (abs(py / 2) <= 0.25)  # where the way to the light passes z = 1
    behind = np.where((abs(px) <= 1) & (abs(py) <= 1) & ~hidden, lit(px, py, 2), 0)
    return np.where((abs(x) <= 0.25) & (abs(y) <= 0.25), lit(x, y, 1), behind)


def test_a_flat_field_under_a_point_light(scenes):
    """Seen from behind it is lit just as well; with the light on the other side it is black and no ray is spent."""
    pixels, found = picture(scenes, LIGHT, SQUARE)
    compare(pixels, square_light)
    rays = SIDE * SIDE * 16
    assert (found.camera, found.mirror, found.shadow) == (rays, 0, rays // 4)  # a quarter of the view is hit
    compare(picture(scenes, LIGHT, "Translate 1 -1 2\nRotate 180 0 1 0\nScale 2 2 1\n", FLAT)[0], square_light)
    pixels, found = picture(scenes, within("Translate 0 0 3\n", LIGHT), SQUARE)
    assert not pixels.any() and found.shadow == 0


def test_shadows_and_cylinders(scenes):
    compare(picture(scenes, within("Translate -1 0 0\n", LIGHT), within("Translate -0.25 -0.25 1\nScale 0.5 0.5 1\n", FLAT), within(SQUARE))[0],
            shadowed_light)
    for far in "1", "1e160", "1e-170":  # only directions count
        compare(picture(scenes, LIGHT, f"LookAt 0 0 0 0 0 {far} 0 {far} 0\n", TUBE.replace("1", far, 1))[0], tube_light)


def test_a_mirror_shows_what_lies_behind_the_eye(scenes):
    """A wall at z = -1 in a mirror at z = 2, lit from the eye: 0.9 of what the wall sends. The way is unfolded: to the wall it is 2
    + 3. At the centre the light is a point's distance away and changes too fast for sixteen samples."""
    pixels, found = picture(scenes, LIGHT, within("Translate -20 -20 -1\nScale 40 40 1\n", FLAT),
                            'Material "mirror"\nTranslate -20 -20 2\nScale 40 40 1\n', FLAT)
    at = (np.arange(SIDE) + 0.5) / (SIDE / 2) - 1
    x, y = np.meshgrid(at, -at)
    wanted = 3 * 0.9 * 0.5 / np.pi / (25 * (x * x + y * y) + 1) ** 1.5
    outer = (abs(x) > 0.5) | (abs(y) > 0.5)
    assert (abs(pixels[..., 0] - wanted) <= 0.04 * wanted)[outer].all() and found.mirror == SIDE * SIDE * 16


def test_each_mirror_takes_its_share(scenes):
    """Two in a row: the wall at z = 3 is seen by way of z = 2 and z = -1, past the edge of the first mirror. A path meets four at
    most."""
    def row(first, second):
        return picture(scenes, 'LightSource "point" "color I" [1 1 1]\n',
                       within(f'Material "mirror" "color Kr" [{first}]\nTranslate -1 -50 2\nScale 2 100 1\n', FLAT),
                       within(f'Material "mirror" "color Kr" [{second}]\nTranslate -50 -50 -1\nScale 100 100 1\n', FLAT),
                       "Translate 1.5 -50 3\nScale 50 100 1\n", FLAT)[0][SIDE // 2]
    whole, shares = row("1 1 1", "1 1 1"), row("1 .5 .25", ".25 .5 1")
    x = np.arange(SIDE) / (SIDE / 2) - 1
    twice = (x + 2 / SIDE <= 0.5) & (9 * x >= 1.5)  # unfolded, the ray is at 2x on the first mirror and at 9x on the wall
    assert twice.sum() > 4 and (whole[twice] > 0).all() and (abs(shares - whole / 4) <= whole * 1e-5)[twice].all()
    wide = "Translate -500 -500 {}\nScale 1000 1000 1\n" + FLAT
    found = picture(scenes, LIGHT, 'Material "mirror"\n', within(wide.format(-1)), wide.format(1))[1]
    assert found.mirror == 4 * found.camera and found.shadow == 0


def test_images_lie_on_shapes_as_they_should(scenes):
    """An image of one colour acts as that colour. One of four shows which way it lies: u grows to the right, v upwards, from the
    lower left corner; row 0 of the image is at v = 0. Texel centres are at a quarter and three quarters of the square."""
    write_image("one.exr", 8, 4, 96 * [0.5])
    write_image("four.exr", 2, 2, [1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1])
    image = within(LIGHT) + 'Texture "t" "color" "imagemap" "string filename" "{}.exr"\nMaterial "matte" "texture Kd" "t"\n'
    compare(picture(scenes, image.format("one"), SQUARE)[0], square_light)
    compare(picture(scenes, image.format("one"), TUBE)[0], tube_light)
    corners = picture(scenes, image.format("four"), SQUARE)[0][[39, 39, 24, 24], [24, 39, 24, 39]]
    assert ((corners > 0.02 * INTENSITY) == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]).all()


@pytest.mark.parametrize("nu, nv", [(40, 40), *((nu, nv) for nu in range(2, 6) for nv in range(2, 6) if takes(nu + nv, 4))])
def test_all_normals_of_a_plane_are_its_own(scenes, nu, nv):
    """Up to its border, also if the samples around a cell are more than there are. The samples are exact and so are their
    differences; a light has some twenty roundings."""
    z = " ".join(f"{k % nu / 64 - k // nu / 128:.7f}" for k in range(nu * nv))
    load(scenes, HEAD.replace('pixelsamples" 16', 'pixelsamples" 4').replace('fov" 90', 'fov" 40') +
         'LightSource "point" "color I" [30 20 10]\nTranslate -1 -1 3\nScale 2 2 1\n'
         f'Shape "heightfield" "integer nu" {nu} "integer nv" {nv} "float Pz" [{z}]\nWorldEnd\n')
    flat, smooth = (scenes.render(threads=1, phong=phong)[0] for phong in (0, 1))
    assert (abs(smooth - flat) <= 40 * 2.0**-24 * flat).all() and (flat > 0).sum() > SIDE * SIDE


# ---- what changes no pixel ------------------------------------------------------------------------------------------------------


def field(seed, nu, nv, *before):
    z = " ".join(f"{height:.4f}" for height in np.random.default_rng(seed).uniform(-1, 1, nu * nv))
    return within(*before, f'Shape "heightfield" "integer nu" {nu} "integer nv" {nv} "float Pz" [{z}]\n')


ROUGH = ('Film "image" "integer xresolution" 70 "integer yresolution" 50\nLookAt 0 -1 1.5 0 1 0 0 0 1\nCamera "perspective" "float fov" 60\n'
         "WorldBegin\n" + within("Translate 1 -1 2\n", LIGHT, "Translate -2 0 0\n", LIGHT) +
         field(11, 17, 15, "Translate -1 -1 0\nScale 2 2 0.5\n") +
         field(12, 17, 15, 'Material "mirror"\nTranslate -1 -1 0\nScale 2 2 0.1\n') + "WorldEnd\n")
# All that a scene can require: matte, textured and mirroring fields of several sizes, a textured cylinder around them and a mirroring one among
# them, turned and stretched, under three lights of which one is outside.
FULL = ('Film "image" "integer xresolution" 70 "integer yresolution" 50\nSampler "bestcandidate" "integer pixelsamples" 6\n'
        'LookAt 0 -1.2 1 0 1 0.1 0 0 1\nCamera "perspective" "float fov" 70\nWorldBegin\n'
        'Texture "t" "color" "imagemap" "string filename" "image.exr"\n' +
        within("Translate 1 -1 2\n", LIGHT, "Translate -2 0.5 -1\n", LIGHT, "Translate 0 9 3\n", LIGHT) +
        within('Material "matte" "texture Kd" "t"\nRotate 20 1 0 1\nScale 3 3.5 4\nShape "cylinder"\n') +
        within('Material "mirror" "color Kr" [.7 .8 .9]\nTranslate 0.6 0.2 0\nScale 0.2 0.3 0.6\nShape "cylinder"\n') +
        field(13, 17, 15, "Translate -1 -1 0\nRotate 10 0 0 1\nScale 2 2 0.5\n") +
        field(14, 40, 37, 'Material "mirror"\nTranslate -1 -1.1 0.1\nScale 2 2.5 0.1\n') +
        field(15, 2, 3, 'Material "matte" "texture Kd" "t"\nTranslate -1.5 1 0\nRotate 60 1 0.2 0\nScale 3 1 0.1\n') +
        field(16, 9, 4, 'Material "mirror" "color Kr" [1 .5 0]\nTranslate -2 -1 0.2\nRotate 70 0 1 0\nScale 1 3 0.05\n') + "WorldEnd\n")


def make(scenes, kind):
    if kind == "landscape":
        scenes("landscape")
        return
    if kind == "full":
        write_image("image.exr", 45, 28, np.random.default_rng(17).uniform(0, 1.5, 45 * 28 * 3))
    load(scenes, FULL if kind == "full" else ROUGH)


@pytest.mark.parametrize("phong", [0, 1])
@pytest.mark.parametrize("kind", ["rough", "full", "landscape"])
def test_neither_plan_nor_instruction_set_changes_a_pixel(scenes, kind, phong):
    """Fields are asked about rays through their boxes alone, and about fewer with a plan. A scene of each kind is worth its name:
    all kinds of rays occur, and many pixels are lit."""
    make(scenes, kind)
    pixels, planned = scenes.render(threads=1, phong=phong)
    assert planned.mirror > planned.camera / 10 and planned.shadow > planned.camera / 2 and (pixels[..., 0] > 0.01).mean() > 1 / 3
    whole, general = scenes.render(threads=1, phong=phong, general=1)
    assert whole.tobytes() == pixels.tobytes()
    assert (planned.shadow, planned.mirror) == (general.shadow, general.mirror) and planned.queries < general.queries
    sets = 0
    for isa in range(1, 6):
        if scenes.ask("render", f"width=1 height=1 isa={isa}")[0]:
            assert scenes.render(threads=1, phong=phong, isa=isa)[0].tobytes() == pixels.tobytes(), isa
            sets += 1
    assert sets > 0
    watched, found = scenes.render(threads=1, phong=phong, tracer=1)
    assert watched.tobytes() == pixels.tobytes() and found.asked == found.queries > found.camera / 2 and found.outside == 0
    for threads in 2, 3:
        assert scenes.render(threads=threads, phong=phong)[0].tobytes() == pixels.tobytes(), threads


def test_a_tracer_is_asked_instead_of_the_library(scenes):
    """It finds nothing, so nothing is shadowed."""
    make(scenes, "rough")
    pixels, found = scenes.render(threads=1, general=1, tracer=2)
    assert found.asked == found.queries == 2 * 70 * 50 * 4 and not pixels.any()


def test_kernels_and_threads_change_no_pixel(scenes):
    make(scenes, "rough")
    kernels = [line.split() for line in scenes("kernels").splitlines()]
    for phong in 0, 1:
        for leaf in 1, 2:
            first = None
            for k, (name, available) in enumerate(kernels, 1):
                for threads in 1, 3:
                    if available == "0" or (first and not takes(k + leaf + phong + threads // 2, 3)):
                        continue
                    words = {"kernel": k, "leaf": leaf, "phong": phong, "threads": threads}
                    good, said = scenes.ask("render", " ".join(f"{key}={value}" for key, value in words.items()))
                    if not good:
                        assert "does not have the leaf test" in said
                        continue
                    pixels, found = scenes.render(**words)
                    now = pixels.tobytes(), found.shadow, found.mirror, found.queries
                    first = first or now
                    assert now == first and found.mirror > 0 and found.shadow > 0 and found.whole == 1, (name, words)
            assert first, leaf
    scenes.refused("kernel ", "render", "leaf=99")
    if ["packet4", "1"] in kernels:  # is there when the rendering begins, and not until its end
        scenes.refused("the limit on instruction sets, has scalar", "render", f"vanish=1 threads=1 kernel={kernels.index(['packet4', '1']) + 1}")


def test_a_crop_is_a_part_of_the_whole(scenes):
    make(scenes, "full")
    whole, _ = scenes.render(threads=1, phong=1)
    for x0, y0, x1, y1 in taken([(0, 0, 70, 50), (0, 0, 1, 1), (69, 49, 70, 50), (31, 31, 33, 33), (3, 7, 60, 41), (33, 0, 35, 50), (0, 30, 70, 34)], 3):
        part, found = scenes.render(threads=2, phong=1, x0=x0, y0=y0, x1=x1, y1=y1)
        assert (part == whole[y0:y1, x0:x1]).all() and found.camera == part.size // 3 * 6
    for x0, y0, x1, y1 in (0, 0, 71, 50), (0, 0, 70, 51), (5, 5, 5, 9), (9, 5, 5, 9), (5, 9, 9, 9):
        scenes.refused("no part of 70 x 50", "render", f"x0={x0} y0={y0} x1={x1} y1={y1}")


def test_seeds_sizes_and_samples(scenes):
    """Seeds can be repeated; a size that is given is the film's; any number of samples makes the same picture up to noise; smooth
    normals show."""
    make(scenes, "rough")
    one, other, same, last, without, smooth, many = (scenes.render(**words)[0] for words in (
        {"seed": 0}, {"seed": 1}, {"seed": 1, "threads": 3}, {"seed": 2**32 - 1}, {}, {"phong": 1}, {"samples": 257}))
    assert (other == same).all() and (one == without).all() and (one != other).any() and (other != last).any() and (one != smooth).any()
    differences = [np.sqrt(np.mean((scenes.render(samples=samples)[0].astype(float) - many) ** 2)) for samples in (1, 7, 64)]
    assert all(b < a / 2 for a, b in zip(differences, differences[1:])) and differences[-1] < 0.01
    text = HEAD.replace("64", "{}") + LIGHT + SQUARE + "WorldEnd\n"
    pictures = []
    for width, height, given in (50, 34, {}), (5, 9, {"width": 50, "height": 34}):
        load(scenes, text.format(width, height))
        pictures.append(scenes.render(threads=1, **given)[0])
    assert (pictures[0] == pictures[1]).all()


SIX = [("hftest", 256, 1, False), ("landsea-0", 400, 2, True), ("landsea-1", 400, 2, True), ("landsea-2", 400, 2, True),
       ("texture", 400, 1, False), ("landsea-big", 600, 2, True)]


@pytest.mark.parametrize("name, side, fields, mirror", taken(SIX, 3))
def test_the_six_scenes_render(scenes, name, side, fields, mirror):
    """The project's own scenes load, and each shows what it is about."""
    found = scenes.facts("load", os.path.join(os.environ["CELLWALK_SCENES"], f"{name}.pbrt"))
    assert (found.width, found.height, found.fields) == (side, side, fields)
    pixels, found = scenes.render(samples=1, phong=side // 200 % 2)
    assert 0.02 < pixels.mean() < 1 and (found.mirror > found.camera / 20) == mirror and found.shadow > found.camera / 6
