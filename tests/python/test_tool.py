# SPDX-License-Identifier: Apache-2.0
"""Rays, coarser fields and what the program prints and draws against Python; test_products.py has the products."""
import json
import re

import numpy as np
import pytest

import cellwalk as cw
from conftest import random_rays, raster, real_dem, same


def product(tool, ground, tmp_path, *words):
    out = tmp_path / ("out" + ground.path.suffix)
    tool(words[0], ground.path, *words[1:], "-o", out)
    return raster(out)


def north(ground, y):
    """The program has the first row of a file without a map in the north, and y counts from the last."""
    return y if ground.path.suffix != ".npy" else ground.field.shape[0] - 1 - y


def place(field, across=0.37, down=0.61):
    x0, y0, x1, y1 = field.bounds
    return x0 + across * (x1 - x0), y0 + down * (y1 - y0)


def same_as_traced(h, wanted):
    assert 0 < h.hit.mean() < 0.95
    for name in ("t", "u", "v", "i", "j"):
        same(getattr(h, name), wanted[name])
    assert (h.triangle == wanted["triangle"]).all()


def test_closest_user(tool, ground, tmp_path):
    rays = random_rays(ground.field, 20000)
    np.save(tmp_path / "rays.npy", rays)
    tool("trace", ground.path, tmp_path / "rays.npy", "--user", "--points", "--normals", "-o", tmp_path / "hits.npy")
    wanted = np.load(tmp_path / "hits.npy")
    h = ground.field.closest(rays)
    same_as_traced(h, wanted)
    same(h.points(), np.stack([wanted[n] for n in ("x", "y", "z")], -1))
    same(h.normals().astype(np.float32), np.stack([wanted[n] for n in ("nx", "ny", "nz")], -1))
    tool("trace", ground.path, tmp_path / "rays.npy", "--user", "--occluded", "-o", tmp_path / "any.npy")
    same(ground.field.occluded(rays).view(np.uint8), np.load(tmp_path / "any.npy"))


def test_closest_floats(tool, tmp_path):
    z = real_dem()["elevation"].astype(np.float32)
    rays = random_rays(cw.Field(z), 20000, dtype=np.float32)
    np.save(tmp_path / "z.npy", z)
    np.save(tmp_path / "rays.npy", rays)
    tool("trace", tmp_path / "z.npy", tmp_path / "rays.npy", "-o", tmp_path / "hits.npy")
    same_as_traced(cw.Field(z).closest(rays), np.load(tmp_path / "hits.npy"))


@pytest.mark.parametrize("name", ["mean", "highest", "lowest"])
def test_coarser(tool, ground, tmp_path, name):
    """Shadows and places on a map of cells three times as large, as the program has them."""
    full, wanted = ground.field, product(tool, ground, tmp_path, "shadow", "--sun", "300,20", "--coarser", "3", "--filter", name)
    before = full.z.copy()
    field = full.coarser(3, name)
    assert field.shape == (21, 29)
    same(field.shadow(300, 20), wanted)
    x, y = place(field)
    y_of_file = y if ground.path.suffix != ".npy" else 3 * (field.shape[0] - 1) - y
    if name != "lowest":  # which has a hole there
        seen = product(tool, ground, tmp_path, "viewshed", "--from", f"{x!r},{y_of_file!r},2", "--coarser", "3", "--filter", name)
        same(field.viewshed(x, y), seen)
    same(full.z, before)
    assert full.difference is None and field.difference.rms > 0
    assert (field.difference.below == 0) == (name == "highest") and (field.difference.above == 0) == (name == "lowest")
    column, row = 12, 9
    same(field.at(*field.map[:2] @ (column, row, 0, 1)), full.coarser(3, name).at(*full.map[:2] @ (3 * column, 3 * row, 0, 1)))


def test_sun(tool, ground, tmp_path):
    if ground.path.suffix == ".npy":
        return
    said = tool("shadow", ground.path, "--time", "2024-06-21T09:00:00Z", "-o", tmp_path / "s.npy")
    p = ground.field.sun("2024-06-21T09:00:00Z")
    assert f"({p.azimuth:.3f} on the map), altitude {p.altitude:.3f}" in said


# ---- what a person sees -------------------------------------------------------------------------------------------------


def outcome(program, *words):
    done = program(*words)
    assert done.returncode == 0, done.stderr
    return done.stderr.splitlines()


def test_the_line_at_the_end_says_what_came_out(program, ground, tmp_path):
    out = tmp_path / ("out" + ground.path.suffix)
    x, y = place(ground.field)
    *_, line = outcome(program, "shadow", ground.path, "--sun", "300,20", "-o", out)
    lit = raster(out)
    share = 100 * (lit == 1).sum() / (lit != 255).sum()
    assert line.startswith(f"cellwalk shadow: {out}: {share:.3g} % of {(lit != 255).sum()} samples in the sun, ")
    *_, line = outcome(program, "viewshed", ground.path, "--from", f"{x:.9g},{north(ground, y):.9g},9", "-o", out)
    seen = raster(out)
    assert f": {100 * (seen == 1).sum() / (seen != 255).sum():.3g} % of {(seen != 255).sum()} samples in sight, " in line
    *_, line = outcome(program, "horizon", ground.path, "--svf", "-o", out)
    sky = raster(out)
    sky = sky[np.isfinite(sky)]
    assert f": {sky.min():.3g} to {sky.max():.3g}, median " in line and f", of {sky.size} samples, " in line
    assert not any("samples" in line for line in outcome(program, "horizon", ground.path, "--svf", "--quiet", "-o", out))


@pytest.mark.parametrize("name, words, says", [
    ("horizon", "--at {at} --at {at},9", "horizons of 2 places"), ("sun", "--at {at} --date 2024-03 --lon-lat 9,47", r"31 days at a place, \d+ hours of sun, [\d.]+ kWh/m2"),
    ("sun", "--at {at} --suns {suns}", "the suns of {suns} at a place"), ("los", "--pairs {pairs}", "1 of 2 pairs see each other"),
    ("trace", "{rays} --user", "33.3 % of 3 rays hit"), ("render", "--size 40x30 --samples 1", "40 x 30 pixels")])
def test_so_does_the_line_of_tables_rays_and_pictures(program, ground, tmp_path, name, words, says):
    x, y = place(ground.field)
    at, files = f"{x!r},{north(ground, y)!r}", {key: tmp_path / f"{key}.csv" for key in ("suns", "pairs")}
    files["suns"].write_text("azimuth,altitude\n180,30\n")
    u, v = place(ground.field, 0.8, 0.2)
    far = f"{u!r},{north(ground, v)!r}"
    files["pairs"].write_text(f"x1,y1,height1,x2,y2,height2\n{at},500,{far},500\n{at},0,{far},0\n")
    files["rays"] = tmp_path / "rays.npy"
    np.save(files["rays"], np.array([[x, y, 1e6, 0, dx, 0, -1, np.inf] for dx in (0, 1e9, -1e9)]))
    out = tmp_path / {"trace": "hits.npy", "render": "out.png"}.get(name, "out.csv")
    words = [word.format(at=at, **files) for word in words.split()]
    *_, line = outcome(program, name, ground.path, *words, "-o", out)
    assert re.fullmatch(rf"cellwalk {name}: {re.escape(str(out))}: {says.format(**{key: re.escape(str(path)) for key, path in files.items()})}, \d+\.\d\d s", line)
    assert not any(str(out) in line for line in outcome(program, name, ground.path, *words, "--quiet", "-o", out))


def test_pictures_show_relief_values_and_observers(program, tool, ground, tmp_path):
    image = pytest.importorskip("matplotlib.image")
    x, y = place(ground.field)
    words = ["viewshed", ground.path, "--from", f"{x:.9g},{north(ground, y):.9g},9", "-o"]
    tool(*words, tmp_path / "seen.npy")
    tool(*words, tmp_path / "seen.png")
    seen, picture = np.load(tmp_path / "seen.npy"), (image.imread(tmp_path / "seen.png")[..., :3] * 255).round().astype(int)
    marks = (picture == (213, 94, 0)).all(-1)
    rows, columns = np.nonzero(marks)
    x0, y0, x1, y1 = ground.field.bounds
    if ground.path.parent.name.startswith(("utm", "degrees", "mercator")):  # north is up: places follow from the bounds
        assert abs(columns.mean() - (x - x0) / (x1 - x0) * (seen.shape[1] - 1)) < 1
        assert abs(rows.mean() - (y1 - y) / (y1 - y0) * (seen.shape[0] - 1)) < 1
    assert marks.sum() >= 5
    clear = ~marks & ~(picture == 255).all(-1)
    yellow = picture[..., 0] - picture[..., 2]  # the ramp ends in blue and in yellow
    assert yellow[clear & (seen == 1)].min() > yellow[clear & (seen == 0)].max()
    blue = picture[clear & (seen == 0)].sum(-1)
    assert blue.std() > 10  # the relief shows


def test_pictures_of_windows_and_every_other_sample(tool, ground, tmp_path):
    """The relief is that of the samples that the pixels stand for."""
    image = pytest.importorskip("matplotlib.image")
    tool("visibility", ground.path, "--directions", "8", "-o", tmp_path / "all.npy")
    tool("visibility", ground.path, "--directions", "8", "--every", "3", "-o", tmp_path / "third.npy")
    tool("visibility", ground.path, "--directions", "8", "--every", "3", "-o", tmp_path / "third.png")
    third = np.load(tmp_path / "third.npy")
    picture = image.imread(tmp_path / "third.png")
    same(third, np.load(tmp_path / "all.npy")[::3, ::3])
    assert picture.shape[:2] == third.shape
    holes = (np.abs(picture[..., :3] * 255 - 240) < 0.5).all(-1)
    wanted = np.isnan(third)
    assert (holes <= wanted).all()


# ---- radio links --------------------------------------------------------------------------------------------------------


def test_clearance_over_a_plain_is_least_in_the_middle(tool, tmp_path):
    np.save(tmp_path / "plain.npy", np.zeros((3, 401), np.float32))
    answer = json.loads(tool("los", tmp_path / "plain.npy", "--cellsize", "10", "0,10,12", "4000,10,12", "--frequency", "2400", "--curvature", "0", "--json"))
    radius = np.sqrt(0.299792458 / 2.4 * 4000 / 4)
    assert answer["fresnel_radius"] == pytest.approx(radius, rel=1e-8)  # nine digits are printed
    assert answer["clearance"] == pytest.approx(12 / radius, rel=1e-8) and answer["clearance_distance"] == pytest.approx(2000)
    # From 0.5 to 12 m: between two crossings, where the heights are as the distances to the ends.
    answer = json.loads(tool("los", tmp_path / "plain.npy", "--cellsize", "10", "0,10,0.5", "4000,10,12", "--frequency", "2400", "--curvature", "0", "--json"))
    share = 0.5 / 12.5
    radius = np.sqrt(0.299792458 / 2.4 * np.hypot(4000, 11.5) * share * (1 - share))
    assert answer["clearance_distance"] == pytest.approx(4000 * share, rel=1e-6)
    assert answer["clearance"] == pytest.approx((0.5 + 11.5 * share) / radius, rel=1e-6)


def test_clearance_is_the_least_along_the_profile(tool, ground, tmp_path):
    field, random = ground.field, np.random.default_rng(5)
    solid = np.isfinite(field.z)
    for shift in ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (-1, -1)):  # places round a bit
        solid &= np.roll(solid, shift, (0, 1))
    rows, columns = np.nonzero(solid[1:-1, 1:-1])
    pairs = ["x1,y1,height1,x2,y2,height2"]
    for _ in range(40):
        words = []
        for k in random.integers(len(rows), size=2):
            x, y = field.map[:2, :3] @ (columns[k] + 1, rows[k] + 1, 0) + field.map[:2, 3]
            words += [f"{x:.12g}", f"{north(ground, y):.12g}", f"{random.uniform(1, 60):.3f}"]
        pairs.append(",".join(words))
    (tmp_path / "pairs.csv").write_text("\n".join(pairs) + "\n")
    tool("los", ground.path, "--pairs", tmp_path / "pairs.csv", "--frequency", "868", "--curvature", "0.75", "-o", tmp_path / "a.csv",
         "--profile", tmp_path / "p.csv")
    answers = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    profile = np.genfromtxt(tmp_path / "p.csv", delimiter=",", names=True)
    for answer in answers:
        rows = profile[(profile["pair"] == answer["pair"])]
        s = np.unique(np.r_[rows["distance"], np.linspace(0, answer["distance"], 20001)[1:-1]])
        gap = np.interp(s, rows["distance"], rows["line"] - rows["ground"])
        rise = rows["line"][-1] - rows["line"][0]
        radius = np.sqrt(0.299792458 / 0.868 * np.hypot(answer["distance"], rise) * (s / answer["distance"]) * (1 - s / answer["distance"]))
        inside = (radius > 0.01) & np.isfinite(gap)
        if not inside.any():
            continue
        least = (gap[inside] / radius[inside]).min()
        # The table has millimetres: of heights, of the gap's place, and of what is left out at the ends.
        assert answer["clearance"] <= least + 2e-3 / answer["fresnel_radius"] + 1e-4
        assert answer["clearance"] >= least - 0.02 * abs(least) - 2e-3 / answer["fresnel_radius"] - 1e-4


def test_frequencies_that_are_none(tool, ground):
    x, y = place(ground.field)
    at = f"{x:.9g},{north(ground, y):.9g},9"
    for wrong in ("-1", "0.01", "1e9"):
        assert "--frequency takes megahertz from 0.1 to 1000000" in tool("los", ground.path, at, at, "--frequency", wrong, fails=True)
