# SPDX-License-Identifier: Apache-2.0
"""All products: parts of a field, with a stride, on threads, by every instruction set, and of a field that borrows rows with gaps, have
the bits of the whole; a watch ends each product; wrong calls name argument, value and limit."""
import struct

import numpy as np
import pytest
from program import read, takes
from words import MAPS, horizon, light, observer, visibility

NX, NY, STRIDE = 61, 47, 66
I, J = np.meshgrid(np.arange(NX), np.arange(NY))
Z = 40 * np.sin(I / 7) * np.cos(J / 5) + np.random.default_rng(31).uniform(0, 8, I.shape)
Z[20, 30] = np.nan


def eye(map, **more):
    """On a hill."""
    return observer(map[0][0] * 30 + map[0][3], map[1][1] * 21 + map[1][3], **{"height": 3, "target": 1, **more})


def make(lands, number):
    """Products, each with its description, its type and what else it takes, of the same land in metres or in degrees."""
    map, geographic = MAPS[number]
    lands.land(Z, map, geographic, gap=16)
    lands.table("suns", [[1.7e9 + 1800 * k, 11, 46] for k in range(48)]).tofile("suns")
    seen, light_of_days = eye(map), [struct.pack("4d", 0.5, 3, 1, directions) for directions in (100, 0)]
    return [("shadow", light(200, 15), "u1", {}), ("sunlight", light(200, 15, radius=1, hillshade=1), "f4", {}),
            ("angles", horizon(13, curvature=1), "f4", {"number": 5}), ("metres", horizon(count=7), "f4", {"number": 2}),
            ("sky", horizon(count=11, farthest=150), "f4", {}), ("sky", horizon(flags=1), "f4", {}),
            ("openness", horizon(count=8, flags=2), "f4", {}), ("view needed", seen, "f4", {}), ("view angle", seen, "f4", {}),
            ("view seen", seen, "u2", {}), ("view sum", seen, "f8", {}), ("area", visibility(2, directions=9), "f4", {}),
            ("share", visibility(2, directions=9), "f4", {}), ("sun hours", light_of_days[0], "f4", {}), ("sun direct", light_of_days[1], "f4", {})]


@pytest.mark.parametrize("number", [0, 4])
def test_parts_have_the_bits_of_the_whole(lands, number):
    """Nothing is written behind their rows. Views add to what is there, others need not care."""
    parts = [(0, 0, NX, NY), (0, 5, 20, 30), (NX - 9, NY - 3, 9, 3), (31, 0, 1, NY)]
    products = make(lands, number)
    kernels = [k for k in (1, 4, 8, 16) if lands.ask(*lands.product_words(*products[0][:2], bytes(NX * NY), kernel=k))[0]]
    assert kernels[0] == 1
    for p, (name, desc, type, more) in enumerate(products):
        size, fill = np.dtype(type).itemsize, 0 if name in ("view seen", "view sum") else 0xa5
        lands(*lands.product_words(name, desc, bytes(size * NX * NY), **more))
        whole = np.fromfile("out", "u1").reshape(NY, NX, size)
        for k, kernel in enumerate(kernels):
            for n, (i, j, nx, ny) in enumerate(parts):
                for used in [0] * (n == k) + [kernel] * takes(n + k + p, 4):
                    wanted = np.full((NY, STRIDE, size), fill, "u1")
                    lands(*lands.product_words(name, desc, wanted.tobytes(), left=i, top=j, wide=nx, high=ny, stride=STRIDE, kernel=used,
                                               pool=k % 2, **more))
                    wanted[:ny, :nx] = whole[j:j + ny, i:i + nx]
                    assert read("out") == wanted.tobytes(), (name, used, (i, j, nx, ny))


def test_watches_see_shares_and_end_products(lands):
    for name, desc, type, more in make(lands, 0):
        words = name, desc, bytes(8 * NX * NY)
        assert float(lands(*lands.product_words(*words, watch=1, **more))) > 0.9, name
        lands.refused("cancelled", *lands.product_words(*words, watch=2, **more))


def test_outputs_go_together(lands):
    """Of several observers: each adds. One call for several outputs is several calls. Lines say the same."""
    products = {name: (desc, type) for name, desc, type, _ in make(lands, 0)}
    one, need = (lands.product(name, *products[name]) for name in ("view seen", "view needed"))
    lands.viewshed(products["view seen"][0])
    both, angle, sums, needed = lands.viewshed(products["view seen"][0], read("out"))
    assert (both == 2 * one).all() and (sums == 5 * one).all() and (np.isnan(angle) == (one == 0)).all() and 100 < one.sum() < one.size - 100
    np.testing.assert_array_equal(needed, need)
    map, lines = np.array(MAPS[0][0]), b""
    for i, j in zip(I.flat, J.flat):
        lines += eye(map)[:24] + struct.pack("3d2I", *(map[:2, :2] @ [i, j] + map[:2, 3]), 1, 0, 0)
    states = lands.lines(0, lines)["state"].reshape(NY, NX)
    assert states[20, 30] == 2 and lands.lines(0, lines)["end"].reshape(NY, NX)[20, 30] == 1
    assert ((states == 1) == (one == 1)).all() and (np.delete(states, 20 * NX + 30) < 2).all()


def wrong_products(map):
    """What is said, the product, its description, and what else it takes."""
    large = {"left": 1, "top": 0, "wide": NX, "high": 1}
    yield from [("terrain NULL", "shadow", light(), {"null": 1}), ("light NULL", "shadow", light(), {"null": 2}),
                ("lit NULL", "shadow", light(), {"null": 3}), ("altitude 91 90", "shadow", light(altitude=91), {}),
                ("azimuth nan", "shadow", light(np.nan), {}), ("radius 11 10", "sunlight", light(radius=11), {}),
                ("strips 65 64", "sunlight", light(strips=65), {}), ("curvature -1", "sunlight", light(curvature=-1), {}),
                ("area 61 x 1", "sunlight", light(), large), ("stride 60 61", "sunlight", light(), {**large, "left": 0, "stride": 60}),
                ("number 32 31", "angles", horizon(), {"number": 32}), ("degrees NULL", "angles", horizon(), {"null": 3}),
                ("count 3601 3600", "sky", horizon(count=3601), {}), ("flags 4 3", "sky", horizon(flags=4), {}),
                ("azimuths NULL", "azimuths", horizon(), {"null": 3}), ("view NULL", "view seen", eye(map), {"null": 3}),
                ("weight nan", "view angle", eye(map), {"number": 1}), ("directions 3601 3600", "area", visibility(directions=3601), {}),
                ("height", "area", visibility(-1), {}), ("answers NULL", "area", visibility(), {"null": 3})]
    ranges = "nearest verticals out of range"
    for said, more in [("limits 4 3", {"limits": 4}), ("height under the ground", {"height": -1}), (ranges, {"nearest": -1}),
                       (ranges, {"farthest": np.nan}), (ranges, {"azimuths": (0, np.inf), "limits": 1}),
                       (ranges, {"verticals": (1, 0), "limits": 2}), (ranges, {"verticals": (-91, 0), "limits": 2})]:
        yield said, "view angle", eye(map, **more), {}
    yield "x, y no ground", "view angle", observer(1e4, 0, 3), {}
    yield "x, y too far", "view angle", observer(1e12, 0, 3), {}


def test_wrong_calls_are_told(lands):
    def refused(said, *words):
        message = lands.refused("argument", *words)
        assert all(part in message for part in said.split()), (said, message)
    for said, more in [("field NULL", {"null": 1}), ("desc NULL", {"null": 2}), ("terrain NULL", {"null": 3}), ("unit -1", {"unit": -1}),
                       ("geographic 2 1", {"geographic": 2}), ("cw_terrain_desc reserved", {"zero": 1}), ("reserved", {"reserved": 1})]:
        refused(said, *lands.land_words(Z, **more))
    make(lands, 0)
    for said, name, desc, more in wrong_products(MAPS[0][0]):
        refused(said, *lands.product_words(name, desc, bytes(8 * NX * NY), **more))
    for said, words in [("factor 1 2", "factor=1"), ("filter 3 2", "factor=2 filter=3"), ("factor 8388609", "factor=8388609"),
                        ("cw_run", "factor=2 reserved=1")]:
        refused(said, "coarser", words)
    for said, curvature, lines, words in [("curvature -1 1e+09", -1, b"", ""), ("lines NULL", 0, bytes(56), "null=1"),
                                          ("absolute 4", 0, struct.pack("6d2I", *np.zeros(6), 4, 0), "")]:
        refused(said, *lands.lines_words(curvature, lines, words))
    # Nothing to do is no error.
    assert len(lands.lines(0, b"", "null=1")) == 0
    lands(*lands.product_words("shadow", light(), left=3, top=3, wide=0, high=2, null=3))
