# SPDX-License-Identifier: Apache-2.0
"""Pictures by `cellwalk render` against closed forms: every pixel of level land from straight above, haze, water, sky and sun, and land beyond the
horizon of a sea."""
import re

import numpy as np
import pytest
from program import SCENE, as_half, asc, close, exr, on_map, picture, read, run, vrt, wall, well, write

NX, NY, SIDE = 60, 50, 60
MAP = "--cellsize", 10
# Level land of 590 x 490 m, samples 10 m apart, and with a wall of 40 m along row 20, which is at y = 290. From 1000 m above its middle a pixel of a
# square picture of 60 x 60 is 10 m wide on the ground: the first column begins at x = -5, the first row at y = 545.
ABOVE = *MAP, "--from", "295,245,1000", "--to", "295,245,0", "--fov", "33.398488467987", "--size", "60x60"
SUN, SKY = 0.85, 0.3  # their light
TINTS = np.array([[0.10, 0.24, 0.08], [0.34, 0.40, 0.14], [0.50, 0.37, 0.18], [0.38, 0.30, 0.25], [0.92, 0.92, 0.95]])
GROUND, BROWN = TINTS[0], TINTS[2]
HORIZON, ZENITH, PLAIN, DEPTH = np.array([[0.70, 0.80, 0.93], [0.16, 0.34, 0.70], [0.20, 0.27, 0.16], [0.02, 0.08, 0.11]])
LEVEL = SUN * 0.5 + SKY  # of level ground, with the sun 30 degrees high
Y, X = np.mgrid[:SIDE, :SIDE]
WAY = np.sqrt(1e6 + (10 * (X - 29.5)) ** 2 + (10 * (Y - 29.5)) ** 2)  # to the ground in the middle of a pixel


@pytest.fixture(autouse=True)
def land(folder):
    for name, height, *holes in ("level", 0), ("wall", 40), ("hole", 0, (33, 25)), ("both", 40, (33, 25)):
        wall(f"{name}.npy", *holes, height=height)
    write("scene.pbrt", SCENE)


def mixed(a, b, share):
    return a + np.multiply.outer(share, b - a)


# ---- what stands where ----------------------------------------------------------------------------------------------------


def test_level_land():
    """Everything stands where it should, and is as bright."""
    rgb = picture("level.npy", *ABOVE, "--sun", "225,30")
    assert rgb.shape == (SIDE, SIDE, 3)
    close(rgb[[*range(5), *range(55, 60)]], HORIZON)
    close(rgb[6:54, 1:59], GROUND, LEVEL)


def test_shadow_of_a_wall():
    """The sun in the south, 45 degrees high: from y = 300, where the wall stands, to 330 there is shadow."""
    rgb = picture("wall.npy", *ABOVE, "--sun", "180,45")
    close(rgb[[20, 28], 1:59], GROUND, SUN * np.sqrt(0.5) + SKY)
    close(rgb[22:24, 1:59], GROUND, SKY)


def test_colours_by_height():
    """Colours are spread evenly from the lowest height to the highest, each in its place, up to the border. Steps of a millimetre hardly lean."""
    j, i = np.mgrid[:NY, :NX]
    np.save("steps.npy", (1e-3 * np.where(j < 25, i >= 30, np.where(i < 30, 2, np.where(i < 50, 3, 4)))).astype(np.float32))
    rgb = picture("steps.npy", *ABOVE[:-1], "600x600", "--sun", "225,30")  # 1 m a pixel
    for k, x, y in zip((*range(5), 0, 1, 2, 4), (150, 450, 150, 400, 550, 6, 593, 6, 593), (150, 150, 450, 450, 450, 56, 56, 543, 543)):
        close(rgb[y, x], TINTS[k], LEVEL)


def test_smooth_around_a_hole():
    """Smooth normals at the rim of a hole are made of samples alone, and rays pass through the hole."""
    rgb = picture("hole.npy", *ABOVE, "--sun", "225,30", "--phong", "--samples", 1)
    through = rgb[..., 2] == as_half(HORIZON[2])
    # The first to fifth rows and the last ones, half a row each beside them and half a column at the sides, and of six triangles, three pixels
    # large, what the samples' places make of it.
    assert 600 < through.sum() < 800
    inside, hole = np.zeros((2, SIDE, SIDE), bool)
    inside[8:52, 2:58], hole[37:40, 24:27] = True, True
    assert not (through & inside & ~hole).any()
    close(rgb[inside & ~through], GROUND, LEVEL)


@pytest.mark.parametrize("size", ["90x60", "60x90"])
def test_seen_as_a_whole(size):
    """From wherever nothing is said, all of the terrain is seen: it touches no side of the picture."""
    rgb = picture("wall.npy", *MAP, "--size", size)
    land = rgb[..., 2] <= rgb[..., 1]
    assert not (land[[0, -1]].any() or land[:, [0, -1]].any()) and land.sum() * 8 > land.size


# ---- haze, water, sky and sun ---------------------------------------------------------------------------------------------


def test_haze_by_distance():
    """Of the ground's contrast 0.02^(d / V) is left. Near the middle of the picture the ways to a pixel's samples differ by 7 m times 30 / 1000 at
    most."""
    rgb = picture("level.npy", *ABOVE, "--sun", "225,30", "--haze", 2000)
    middle = np.s_[27:33, 27:33]
    close(rgb[middle], mixed(HORIZON, GROUND * LEVEL, 0.02 ** (WAY[middle] / 2000)), share=np.log(50) / 2000 * 0.3)
    close(rgb[1, 30], HORIZON)  # the sky behind has its own colour


def test_water_from_above():
    """Its own light, and the sky straight up. Below the ground it changes nothing."""
    rgb = picture("wall.npy", *ABOVE, "--sun", "180,45", "--water", 5)
    cosine = (1000 / WAY)[..., None]
    mirrored = 0.02 + 0.98 * (1 - cosine) ** 5
    wanted = (1 - mirrored) * DEPTH * (SUN * np.sqrt(0.5) + SKY) + mirrored * (HORIZON + cosine * (ZENITH - HORIZON))
    for rows in np.s_[8:23], np.s_[29:53]:  # without the wall, and what mirrors it
        close(rgb[rows, 2:58:3], wanted[rows, 2:58:3], share=1e-3)
    assert rgb[25, 30, 0] > 0.05  # the wall
    # Holes are under water too.
    assert (picture("both.npy", *ABOVE, "--sun", "180,45", "--water", 5)[30:50] == rgb[30:50]).all()
    files = []
    for level in "--quiet", "--water=-1":
        picture("wall.npy", *ABOVE, level)
        files.append(read("o.exr"))
    assert files[0] == files[1]
    done = run("render", "wall.npy", *ABOVE, "--water", 1000, "-o", "o.exr")
    assert done.status == 0 and "warning: --water 1000: not drawn, as the eye is at 1000 m, not above it\n" in done.err


def test_water_mirrors_land():
    """A wall in the sun, in water 10 m high: its face from y = 280 to 290 rises by 4 in 1. From 10 m over the water and 120 m before the place the
    mirrored ray, which rises by 1 in 12, meets it above the water at y = 284.255. Its colour there is between those of the texels at y = 275, of the
    lowest ground, and at y = 285, of half the height: brown."""
    rgb = picture("wall.npy", *MAP, "--from", "295,80,=20", "--to", "295,200,=10", "--fov", 0.01, "--size", "3x3", "--sun", "180,45", "--water", 10)
    wall = (SUN * 5 * np.sqrt(0.5) + SKY) / np.sqrt(17)
    y = (10 - 200 / 12 + 4 * 280) / (4 - 1 / 12)
    mirrored = 0.02 + 0.98 * (1 - 10 / np.hypot(10, 120)) ** 5
    close(rgb[1, 1], mirrored * wall * mixed(GROUND, BROWN, (y - 275) / 10) + (1 - mirrored) * DEPTH * (SUN * np.sqrt(0.5) + SKY))


@pytest.mark.parametrize("air, visibility", [("--phong", 12 * 1080), ("--haze=3000", 3000)])
def test_the_plain_below_the_horizon(air, visibility):
    """At the lowest ground, in haze or in air that is twelve times the terrain deep."""
    rgb = picture("level.npy", *ABOVE, "--sun", "225,30", "--sky", air)
    close(rgb[1], mixed(HORIZON, PLAIN, 0.02 ** (WAY[1] / visibility)), share=np.log(50) / 3000 * 7)


@pytest.mark.parametrize("sun, toward", [("225,75", np.sqrt(0.5)), ("225,30", 1), ("45,30", -0.5)])
def test_the_sky_is_brightest_where_the_sun_is(sun, toward):
    """Up by 30 degrees to the south-west, from 45 degrees below the sun to right into it."""
    rgb = picture("level.npy", *MAP, "--from", "295,245,=10", "--to", "195,145,=91.64965809", "--fov", 0.01, "--size", "3x3", "--sky", "--quiet",
                  "--sun", sun)
    near, clear = max(toward, 0), mixed(HORIZON, ZENITH, 1 - 0.5**3)
    close(rgb[1, 1], clear + (0.15 * near**8 + 0.5 * near**128) * np.maximum(np.array([1, 0.95, 0.85]) - clear, 0))


def test_sun_by_time():
    """At a time the sun is where `cellwalk shadow` says, to the digits that it prints."""
    asc("land.asc", np.load("wall.npy"))
    vrt("land.vrt", "land.asc", (NY, NX), on_map(32632, 600000, 10, 0, 5200000, 0, -10))
    time = "--time=2024-06-21T07:00:00Z"
    said = well("shadow", "land.vrt", time, "-o", "s.npy").out
    azimuth, altitude = re.search(r"azimuth \S+ \((\S+) on the map\), altitude (\S+)", said).groups()
    one, same, other = (picture("land.vrt", sun, "--size", "90x60") for sun in (time, f"--sun={azimuth},{altitude}", "--sun=250,30"))
    assert np.abs(same - one).mean() < 1e-4 and np.abs(other - one).mean() > 1e-3


# ---- a curved earth -------------------------------------------------------------------------------------------------------
# The eye is h metres above a sea of level 0. The surface d metres away is lower by k d² / 2 R, so that the sea's horizon is at s = sqrt(2 R h / k), in
# the direction that falls by k s / R a metre. A shore D metres away, with s < D, stands above that line by H - k (D - s)² / 2 R if it is H metres high.
# Samples lie on a parabola, the surface between two of them on its chord, which is below it by k CELL² / 8 R = 2 · 10^-4 m at most. A pixel is 0.14 m
# high on the shore 20 km away.
RADIUS, EYE, ROW, CELL, HIGH = 6378137, 2, 2, 100, 256


def make_land(shore, height):
    """A sea with land of the same height from a column on."""
    z = np.zeros((5, 340), np.float32)
    z[:, shore:] = height
    np.save("land.npy", z)
    return float(z[0, shore])


def look(place, to, factor, sun):
    return picture("land.npy", "--cellsize", CELL, "--from", place, "--to", to, "--fov", 0.1, "--size", "256x256", "--samples", 1, "--sun", sun,
                   "--curvature", factor)


@pytest.mark.parametrize("over", [-0.5, 0.5])
@pytest.mark.parametrize("shore", [202, 302])
@pytest.mark.parametrize("k", [1, 6 / 7])
def test_land_beyond_the_horizon(k, shore, over):
    eye, far = 10, 33000
    s, distance = np.sqrt(2 * RADIUS * eye / k), (shore - EYE) * CELL
    least = k * (distance - s) ** 2 / (2 * RADIUS)
    height = make_land(shore, least + over)
    # A place on the line to the sea's horizon, at the height that curvature lowers onto that line.
    z = eye - k * s / RADIUS * far + k * far**2 / (2 * RADIUS)
    assert z >= height
    rgb = look(f"{EYE * CELL},{ROW * CELL},={eye}", f"{EYE * CELL + far},{ROW * CELL},={z!r}", f"{k:.15g}", "270,40")
    # The middle of the picture is at the sea's horizon. Land ends so many pixels above it. A sample is anywhere in its pixel. Chords move the edge by
    # less than 0.003 of one, and rounding directions to float by four steps of 2^-24 at most, 0.035 of one.
    rise = (height - least) / distance / (2 * np.tan(np.radians(0.1) / 2) / HIGH)
    top, y = HIGH / 2 - max(rise, 0), np.arange(HIGH)
    # No ground is as blue: its brightest tint has 1.04 times as much blue as green, the sky 1.16 times or more.
    sky = (rgb[..., 2] > 1.1 * rgb[..., 1])[:, HIGH // 2 - 1:HIGH // 2 + 1]
    assert sky[y + 1 < top - 0.05].all() and not sky[y > top + 0.05].any()


def test_shadows_are_lowered():
    """Those of the lowered terrain. From the sea 1 km in front of the eye, land of 40 m that is 19 km farther stands 0.12 degrees above the level, and
    0.03 degrees once it is lowered by 31 m. The sun is between the two."""
    make_land(202, 40)
    flat, lowered = (look("200,200,=10", "1200,200,0", factor, "90,0.07")[HIGH // 2, HIGH // 2] for factor in (0, 1))
    assert (lowered > flat).all()


def test_curvature_is_off_by_default():
    """Without the option nothing changes; colours by height stay those of the terrain as it is."""
    make_land(100, 5)
    words = "land.npy", "--cellsize", CELL, "--from", "200,200,=60", "--size", "64x64", "--phong"
    none, flat, curved = (picture(*words, *more) for more in ((), ("--curvature", 0), ("--curvature", 1)))
    assert (none == flat).all() and (none != curved).any()


# ---- scenes ---------------------------------------------------------------------------------------------------------------


def test_parts_of_scenes():
    for name, *words in ("whole.exr",), ("one.exr", "--threads", 1), ("part.exr", "--crop", "30,20,50,41"):
        assert run("render", "scene.pbrt", "--size=80x60", "-o", name, *words).status == 0
    whole, part = map(exr, ("whole.exr", "part.exr"))
    assert whole.shape == (60, 80, 3) and part.shape == (21, 20, 3) and read("whole.exr") == read("one.exr") and whole[30, 40, 0] > 0.1
    assert (part == whole[20:41, 30:50]).all()


def test_quiet_means_no_warning():
    write("odd.pbrt", 'Film "image" "integer xresolution" 4 "integer yresolution" 4\nAccelerator "grid"\nCamera "perspective"\nWorldBegin\nWorldEnd\n')
    done = run("render", "odd.pbrt", "-o", "odd.exr")
    assert done.status == 0 and "warning: " in done.err
    well("render", "odd.pbrt", "-o", "odd.exr", "--quiet")
    make_land(100, 5)
    well("render", "land.npy", "--cellsize", CELL, "--size", "8x8", "--sun", "0,-5", "-o", "odd.exr", "--quiet")
