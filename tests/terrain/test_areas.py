# SPDX-License-Identifier: Apache-2.0
"""All products: parts of a field, with a stride, on threads, by every instruction set, and of a field that borrows rows with gaps, have
the bits of the whole; a watch ends each product; wrong calls name argument, value and limit."""
from functools import partial

import numpy as np
import pytest
from library import ARGUMENT, CANCELLED, MAPS, OK, STRUCTS, Room, horizon, light, observer, struct
from program import takes
from test_light import NX, NY, I, J

STRIDE, sight = 66, partial(struct, "cw_visibility_desc")
Z = 40 * np.sin(I / 7) * np.cos(J / 5) + np.random.default_rng(31).uniform(0, 8, I.shape)
Z[20, 30] = np.nan


def eye(map, **more):
    """On a hill."""
    return observer(map[0][0] * 30 + map[0][3], map[1][1] * 21 + map[1][3], **{"height": 3, "target": 1, **more})


def make(lands, number):
    """Products, each with its description, its type and what else it takes, of the same land in metres or in degrees."""
    map, geographic = MAPS[number]
    lands.land(Z, map, geographic=geographic, gap=16)
    suns, seen, see = lands.table("suns", [[1.7e9 + 1800 * k, 11, 46] for k in range(48)]), eye(map), sight(height=2, directions=9)
    return [("shadow", light(200, 15), "u1", {}), ("sunlight", light(200, 15, radius=1, hillshade=1), "f4", {}),
            ("horizon_angles degrees", horizon(13, curvature=1), "f4", {"number": 5}), ("horizon_angles metres", horizon(count=7), "f4", {"number": 2}),
            ("sky_view", horizon(count=11, farthest=150), "f4", {}), ("sky_view", horizon(flags=1), "f4", {}),
            ("openness", horizon(count=8, flags=2), "f4", {}), ("viewshed needed", seen, "f4", {}), ("viewshed angle", seen, "f4", {}),
            ("viewshed seen", seen, "u2", {}), ("viewshed sum", seen, "f8", {"weight": 2.5}), ("visibility area", see, "f4", {}),
            ("visibility share", see, "f4", {}), ("insolation_hours", lands.insolation(suns, 0.5, 1, 100), "f4", {}),
            ("insolation_direct", lands.insolation(suns, 0.5, 1), "f4", {})]


@pytest.mark.parametrize("number", [0, 4])
def test_parts_have_the_bits_of_the_whole(lands, number):
    """In any floating-point environment. Nothing is written behind their rows. Views add to what is there, others need not care."""
    parts = [(0, 0, NX, NY), (0, 5, 20, 30), (NX - 9, NY - 3, 9, 3), (31, 0, 1, NY)]
    products = make(lands, number)
    kernels = [None] + [f"pyramid{k}" for k in (1, 4, 8, 16)]
    modes = lands.number("set_mode", 99)
    kernels = [k for k in kernels if k is None or lands.describe_kernel(lands.number("cw_kernel_find", k))["available"]]
    assert kernels[1] == "pyramid1"
    for p, (name, desc, type, more) in enumerate(products):
        whole = np.zeros((NY, NX), type)
        assert lands.make(name, desc, whole, **more)[0] == OK
        for k, kernel in enumerate(kernels[1:]):
            for n, (i, j, nx, ny) in enumerate(parts):
                for used in [None] * (n == k) + [kernel] * takes(n + k + p, 4):
                    wanted = np.full((NY, STRIDE), 0 if name in ("viewshed seen", "viewshed sum") else 77, type)
                    found, run = wanted.copy(), lands.run(pool=lands.threads * (k % 2), kernel=used or 0)
                    lands.call("set_mode", (7 * k + 5 * n + p) % modes if modes else 99)
                    assert lands.make(name, desc, found, run=run, at=(i, j, nx, ny), stride=STRIDE, **more)[0] == OK
                    lands.call("set_mode", 99)
                    wanted[:ny, :nx] = whole[j:j + ny, i:i + nx]
                    assert found.tobytes() == wanted.tobytes(), (name, used, (i, j, nx, ny))


def test_watches_see_shares_and_end_products(lands):
    for name, desc, type, more in make(lands, 0):
        for most, wanted in (2, OK), (0, CANCELLED):
            context = lands.keep(np.array([0.0, most, 0 if name == "openness" else lands.fields[0]]))  # that copies the land
            run = lands.run(watch=lands.number("watch"), watch_context=context)
            assert lands.make(name, desc, np.zeros((NY, NX), type), run=run, **more)[0] == wanted, name
            assert wanted == CANCELLED or lands.peek(context, "f8")[0] > 0.9, name


def test_outputs_go_together(lands):
    """Of several observers: each adds. One call for several outputs is several calls. Lines say the same."""
    make(lands, 0)
    map, from_hill = np.array(MAPS[0][0]), eye(MAPS[0][0])
    one, need = lands.product("viewshed seen", from_hill, "u2"), lands.product("viewshed needed", from_hill)
    both, angle, sums, needed = lands.viewshed(from_hill, seen=one.copy(), sum=2.5 * one)
    assert (both == 2 * one).all() and (sums == 5 * one).all() and (np.isnan(angle) == (one == 0)).all() and 100 < one.sum() < one.size - 100
    np.testing.assert_array_equal(needed, need)
    lines = np.zeros(NX * NY, STRUCTS["cw_sight"])
    lines["from"], lines["to"][:, 2] = [from_hill[name][0] for name in ("x", "y", "height")], 1
    lines["to"][:, :2] = np.column_stack([I.flat, J.flat]) @ map[:2, :2].T + map[:2, 3]
    answers = lands.lines(0, lines).reshape(NY, NX)
    states = answers["state"]
    assert (states[20, 30], answers["end"][20, 30]) == (2, 1) and ((states == 1) == (one == 1)).all() and (np.delete(states, 20 * NX + 30) < 2).all()


def test_lines_in_a_plane_in_feet(lands):
    """From the ground of a plane all is touched: lines say it as viewsheds do, though metres of samples, and these back in feet, are rounded."""
    z, map = (3 * I + 7 * J + 1).astype("f4"), np.array(MAPS[1][0])
    lands.land(z, MAPS[1][0])
    at = np.column_stack([I.flat, J.flat]) @ map[:2, :2].T + map[:2, 3]
    seen = lands.product("viewshed seen", observer(*at[0], 0), "u2")
    lines = np.zeros(NX * NY, STRUCTS["cw_sight"])
    lines["from"][:, :2], lines["to"][:, :2] = at[0], at
    assert (lands.lines(0, lines)["state"].reshape(NY, NX) == seen).all() and seen.sum() < 20


def wrong_products(map):
    """What is said, the product, its description, and what else it takes. What core_arguments has of each function is not here."""
    yield from [("altitude 91 90", "shadow", light(altitude=91), {}), ("radius 11 10", "sunlight", light(radius=11), {}),
                ("strips 65 64", "sunlight", light(strips=65), {}), ("curvature -1", "sunlight", light(curvature=-1), {}),
                ("area 61 x 1", "sunlight", light(), {"at": (1, 0, NX, 1)}), ("stride 60 61", "sunlight", light(), {"at": (0, 0, NX, 1), "stride": 60}),
                (f"such rows {2**64 - 1}", "sunlight", light(), {"stride": 2**64 - 1}),
                ("number 32 31", "horizon_angles degrees", horizon(), {"number": 32}), ("degrees NULL", "horizon_angles degrees", horizon(), {"to": None}),
                ("count 3601 3600", "sky_view", horizon(count=3601), {}), ("flags 4 3", "sky_view", horizon(flags=4), {}),
                ("curvature", "openness", horizon(flags=2, curvature=1), {}), ("stride 30 31", "visibility area", sight(every=2), {"stride": 30}),
                ("directions 3601 3600", "visibility area", sight(directions=3601), {}), ("height", "visibility area", sight(height=-1), {}),
                ("height", "visibility area", sight(height=1e38), {}), ("curvature", "visibility area", sight(curvature=1e99), {})]
    ranges = "azimuths verticals from -90 up to 90"
    for said, more in [("limits 4 3", {"limits": 4}), ("height under the ground", {"height": -0.0011}), ("nearest -1", {"nearest": -1}), ("nearest 9 0 8", {"nearest": 9, "farthest": 8}),
                       ("farthest nan", {"farthest": np.nan}), (ranges, {"azimuths": (0, np.inf), "limits": 1}),
                       (ranges, {"verticals": (1, 0), "limits": 2}), (ranges, {"verticals": (-91, 0), "limits": 2})]:
        yield said, "viewshed angle", eye(map, **more), {}
    yield "x, y no ground", "viewshed angle", observer(1e4, 0, 3), {}
    yield "x, y too far", "viewshed angle", observer(1e12, 0, 3), {}


def wrong_calls(lands):
    """What is said, the function and its arguments."""
    good, field, room = lands.land_desc(Z), lands.fields[0], Room("u8")
    land = lands.land_now = int(lands.well("cw_terrain_create", good, None, room)[0])
    scale = lands.keep(np.ones((65, 9, 2)))
    leaning = [(lands.field(Z[:2, :2], np.eye(3, 4) + (np.arange(12) == at).reshape(3, 4)), {}) for at in (2, 6, 8, 9, 11)]
    for said, field_of, more in [("unit -1", field, {"unit": -1}), ("geographic 2 1", field, {"geographic": 2}), ("latitudes", field, {"geographic": 1, "unit": 1}),
                                 ("scale in degrees", field, {"geographic": 1, "scale": scale})] + [("field map", *one) for one in leaning]:
        yield said, "cw_terrain_create", struct("cw_terrain_desc", field=field_of, **more), None, room
    for said, factor, filter in ("factor 1 2", 1, 0), ("filter 3 2", 2, 3), ("factor 8388609", 2**23 + 1, 0):
        yield said, "cw_field_coarser", field, None, factor, filter, room, None, 0
    for said, curvature, lines, n in [("curvature -1 1e+09", -1.0, None, 0), ("absolute 4", 0.0, struct("cw_sight", absolute=4), 1),
                                      ("zero 1", 0.0, struct("cw_sight", zero=1), 1)]:
        yield said, "cw_lines_of_sight", land, None, curvature, lines, n, Room(STRUCTS["cw_sight_answer"])


def test_wrong_calls_are_told(lands):
    for said, *call in wrong_calls(lands):
        message = lands.fails(ARGUMENT, *call)
        assert all(part in message for part in said.split()), (said, message)
    make(lands, 0)
    for said, name, desc, more in wrong_products(MAPS[0][0]):
        status, message = lands.make(name, desc, **{"to": np.zeros((NY, NX), "f4"), **more})
        assert status == ARGUMENT and all(part in message for part in said.split()), (said, message)
    # Nothing to do is no error, and within 1 mm of a sample an eye is on it.
    lands.well("cw_lines_of_sight", lands.land_now, None, 0.0, None, 0, None)
    lands.land(100 * ((I == 30) & (J == 21)))
    for off, wanted in (0.0009, ARGUMENT), (0.005, OK):
        assert lands.make("viewshed seen", observer(300 + off, -210, 99.9985, absolute=1), np.zeros((NY, NX), "u2"))[0] == wanted


def test_zero_is_the_usual(lands):
    """Of each member for which it stands for another number, and no other number gives the same; a terrain has the ellipsoid and the scale that it
    is given."""
    lands.land(Z, MAPS[0][0])
    for name, desc, members, member, usual in [
            ("sunlight", light, {"altitude": 15, "radius": 5}, "strips", 16), ("sky_view", horizon, {}, "count", 32),
            ("visibility area", sight, {"height": 2, "every": 16}, "directions", 128), ("visibility area", sight, {"height": 2}, "every", 1)]:
        found = [lands.product(name, desc(**members, **{member: value})).tobytes() for value in (0, usual, usual + 1)]
        assert found[0] == found[1] != found[2], (name, member)
    assert (lands.product("viewshed sum", eye(MAPS[0][0]), "f8") == lands.product("viewshed sum", eye(MAPS[0][0]), "f8", weight=1)).all()
    degree, middle = np.pi / 180, [30, 21, 0]
    for desc, metres in [({"scale": lands.keep(np.full((65, 9, 2), (2.0, 3.0)))}, (2, 3)), ({"unit": 0.5, "semi_major": 7.0}, (0.5, 0.5)),
                         ({"geographic": 1, "semi_major": 5e6}, (5e6 * degree, 5e6 * degree)),
                         ({"geographic": 1, "semi_major": 5e6, "inverse_flattening": 100}, (5e6 * degree, 5e6 * degree * 0.99**2))]:
        lands.land(Z, [[1e-9, 0, 0, 0], [0, -1e-9, 0, 0], [0, 0, 1, 0]], **desc)
        assert lands.table("places", [middle])[0, :2] == pytest.approx(metres, rel=1e-12)
