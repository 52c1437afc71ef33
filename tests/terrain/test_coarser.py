# SPDX-License-Identifier: Apache-2.0
"""Coarser fields against definitions in whole numbers: heights, holes, and how far the two surfaces lie apart. All heights are
taken times 2^149, which makes them whole. The difference is compared at points inside each triangle, found on both surfaces without
use of how they overlap, and at the triangle's corners."""
import itertools
from fractions import Fraction

import numpy as np
import pytest
from library import struct
from program import taken

MEAN, HIGHEST, LOWEST = range(3)
CASES = [(2, 2, 2), (3, 2, 2), (5, 9, 4), (9, 8, 2), (17, 12, 4), (13, 14, 3), (7, 21, 5), (5, 4, 100), (25, 3, 8)]
SHAPES = {
    "random": lambda i, j, x, y: x, "flat": lambda i, j, x, y: 0.375 + 0 * x, "plane": lambda i, j, x, y: 3.0 * i - 2 * j,
    "cliff": lambda i, j, x, y: 1e6 * ((i + j) // 2 % 2), "spikes": lambda i, j, x, y: np.where(x < 0.1, 1000 * y, 0),
    "checker": lambda i, j, x, y: (i + j) % 2.0, "integers": lambda i, j, x, y: np.floor(5 * x) - 2, "tiny": lambda i, j, x, y: 1e-30 * x, "huge": lambda i, j, x, y: 1e30 * x,
    "gentle": lambda i, j, x, y: 5e-5 * i + 3e-5 * j + 1e-7 * x, "mixed": lambda i, j, x, y: np.where(y < 0.5, -1, 1) * 10 ** (60 * x - 30),
    "holes": lambda i, j, x, y: np.where(y < 1 / 7, np.nan, x)}
PARTS = 64  # places are in units of so many to a cell of the full field


def made(shape, nx, ny, seed):
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    return SHAPES[shape](i, j, *np.random.default_rng(seed).random((2, ny, nx)))


def exact(z):
    """None at a hole."""
    return [[None if np.isnan(h) else int(Fraction(float(h)) * 2**149) for h in row] for row in z]


def plane(z, x, y, parts, triangle):
    """The height of a triangle's plane at a place, times parts, the places to a cell; None if it is not there."""
    i, j, lower = triangle
    corners = z[j][i], z[j + lower][i + 1 - lower], z[j + 1][i + 1]
    if None in corners:
        return None
    along, across = (y - j * parts, x - i * parts) if lower else (x - i * parts, y - j * parts)
    return corners[0] * (parts - along) + corners[1] * (along - across) + corners[2] * across


def triangle_at(z, x, y, parts):
    i, j = min(x // parts, len(z[0]) - 2), min(y // parts, len(z) - 2)
    return i, j, int(y - j * parts > x - i * parts)


def look(full, coarse, factor, above, below):
    """Triangles lost and made, the largest and the least difference and the sum of squares' integrals times 12, each in units of
    heights; no point may lie farther apart than reported."""
    lost = made = both = squares = 0
    unit, most, least = PARTS * factor, None, None
    limits = Fraction(above) * 2**149 * unit, -Fraction(below) * 2**149 * unit
    for j, i, lower in np.ndindex(len(full) - 1, len(full[0]) - 1, 2):
        corners = [(i, j), (i + 1 - lower, j + lower), (i + 1, j + 1)]
        inside = [tuple(sum(w * c[a] for w, c in zip(weights, corners)) for a in range(2))
                  for weights in ((62, 1, 1), (1, 62, 1), (1, 1, 62), (20, 21, 23))]
        middle = triangle_at(coarse, *inside[3], unit)
        here, there = (plane(z, *inside[3], parts, t) is not None for z, parts, t in (
            (full, PARTS, (i, j, lower)), (coarse, unit, middle)))
        lost, made, both = lost + (here and not there), made + (there and not here), both + (here and there)
        if not (here and there):
            continue
        places = [(x, y, triangle_at(coarse, x, y, unit)) for x, y in inside] + [(PARTS * x, PARTS * y, middle) for x, y in corners]
        d = [plane(coarse, x, y, unit, t) - factor * plane(full, x, y, PARTS, (i, j, lower)) for x, y, t in places]
        assert max(d) <= limits[0] and min(d) >= limits[1]
        a, b, c = d[4:]
        most, least = max(d[4:] + [a if most is None else most]), min(d[4:] + [a if least is None else least])
        squares += a * a + b * b + c * c + a * b + b * c + a * c
    return lost, made, both, *(float(Fraction(n or 0, 2**149 * unit)) for n in (most, least)), Fraction(squares, (2**149 * unit)**2)


def mean_at(full, i, j, factor):
    """The mean around a sample by definition, None at a hole; and the largest height that counted."""
    terms = [((factor - abs(x - i * factor)) * (factor - abs(y - j * factor)), full[y][x])
             for y in range(max(0, j * factor - factor + 1), min(len(full), j * factor + factor))
             for x in range(max(0, i * factor - factor + 1), min(len(full[0]), i * factor + factor))]
    there = [(weight, h) for weight, h in terms if h is not None]
    if 2 * sum(weight for weight, _ in there) < sum(weight for weight, _ in terms):
        return None, 0
    total = Fraction(sum(weight * h for weight, h in there), sum(weight for weight, _ in there) * 2**149)
    return float(total), max(abs(h) for _, h in there) / 2**149


@pytest.mark.parametrize("size, shape, filter", taken(itertools.product(CASES, SHAPES, (MEAN, HIGHEST, LOWEST)), 7))
def test_definitions(lands, size, shape, filter):
    """The reported difference is off by at most 14 · 2^-53 of the largest difference between a sample and a corner
    (src/terrain/coarser/difference.c); the mean square by sums of n squares with n + 64 roundings. A mean is rounded to float once;
    sums in double of fewer than 2^11 terms before."""
    nx, ny, factor = size
    full = lands.land(made(shape, nx, ny, CASES.index(size) + list(SHAPES).index(shape)), np.eye(3, 4))
    _, coarse, (above, below, rms, lost, gained) = lands.coarser(factor, filter)
    assert coarse.shape == (-(-(ny - 1) // factor) + 1, -(-(nx - 1) // factor) + 1)
    whole = exact(full)
    for b, a in np.ndindex(coarse.shape):
        z = coarse[b, a]
        if filter == MEAN:
            right, scale = mean_at(whole, a, b, factor)
            assert (right is None) == np.isnan(z)
            assert right is None or abs(float(z) - right) <= 2.0**-24 * abs(right) + 2.0**-41 * scale + 2.0**-149
            continue
        window = full[max(0, (b - 1) * factor):(b + 1) * factor + 1, max(0, (a - 1) * factor):(a + 1) * factor + 1]
        wanted = (np.nan if np.isnan(window).all() else np.nanmax(window)) if filter == HIGHEST else np.min(window)
        assert z == wanted or np.isnan([z, wanted]).all()
    found = look(whole, exact(coarse), factor, above, below)
    assert found[:2] == (lost, gained)
    known = np.concatenate([full[~np.isnan(full)], coarse[~np.isnan(coarse)]]).astype(float)
    slack = 2.0**-49 * np.ptp(known) if found[2] else 0
    right = np.sqrt(float(found[5] / (6 * max(found[2], 1))))
    assert above <= max(found[3], 0) + slack and below <= max(-found[4], 0) + slack
    assert abs(rms - right) <= slack + right * (found[2] + 64) * 2.0**-53
    assert filter != HIGHEST or (below, lost) == (0, 0)
    assert filter != LOWEST or (above, gained) == (0, 0)
    assert shape != "flat" or (above, below, rms) == (0, 0, 0)


@pytest.mark.parametrize("filter, factor", taken(itertools.product((MEAN, HIGHEST, LOWEST), (2, 5)), 3))
def test_threads_change_no_bit(lands, filter, factor):
    random = np.random.default_rng(7)
    z = 100 * random.random((409, 613))
    z[330:][random.random((79, 613)) < 0.01] = np.nan
    lands.land(z)
    one, other = (lands.coarser(factor, filter, pool) for pool in (0, lands.threads))
    assert one[1].tobytes() == other[1].tobytes() and one[2] == other[2]


def test_places_stay(lands):
    """A place has the same user coordinates in both, and the field owns its samples: one is changed."""
    map = np.array([[3, 0.5, 0.25, 100], [-1, 2, 0, 200], [0.125, 0, 0.5, 7]])
    lands.land_desc([[1, 2, 3], [4, 5, 6]], map)
    field, coarse, _ = lands.coarser(2, HIGHEST)
    assert (lands.of_each("cw_hit_points", field, struct("cw_hit", u=1), columns=3) == map @ [2, 0, coarse[0, 1], 1]).all()
    lands.well("cw_field_update", field, None, struct("cw_update", at=(1, 0, 1, 1), samples=lands.keep(np.full(1, 9, "f4"))))
    assert lands.peek(lands.number("cw_field_row", field, 0), "f4", 2)[1] == 9
