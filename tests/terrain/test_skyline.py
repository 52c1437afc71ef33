# SPDX-License-Identifier: Apache-2.0
"""The skyline against all edges one by one: edges anywhere, that share ends, that are narrow or a single place, and that are added from
where a look last was."""
import numpy as np
from program import taken

BLUR = 2.0**-19
NEW, ADD, LOOK, LEAST, CLOSELY = range(5)  # what library_terrain.h does


def check(edges, directions, low, high, error=1e-9):
    """Edges from (u, w) to (u, w). An edge of no width is all between its heights. Returns the lowest that the skyline can be."""
    edges = np.where(edges[:, :1] > edges[:, 2:3], edges[:, [2, 3, 0, 1]], edges)
    (a, wa, b, wb), u = edges.T[..., None].astype(np.longdouble), np.asarray(directions)
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.where(a == b, [np.minimum(wa, wb), np.maximum(wa, wb)], wa + (wb - wa) * ((u - a) / (b - a)))
    lowest, highest = np.where((u >= a) & (u <= b), w, -np.inf).max(1)
    assert (low <= lowest + error).all() and (high >= highest - error).all()
    # Elsewhere than next to an end the two are one.
    near = (u > a - 4 * BLUR) & (u < b + 4 * BLUR)
    near &= (b - a < BLUR) | (np.abs(u - a) < 4 * BLUR) | (np.abs(u - b) < 4 * BLUR)
    plain = ~near.any(0) & (lowest > -np.inf) & (np.abs(u) < 1 - 4 * BLUR)
    assert (high[plain] - low[plain]).max(initial=0) < 1e-2
    return lowest


def test_edges_one_by_one(lands):
    for number in taken(range(400), 80):
        r = np.random.default_rng(number)
        edges, rows, size = [], [[NEW, 0, 0, 0, 0, 0, 0]], 1 if number % 3 else 5 * BLUR  # so that nothing but narrow edges is within reach of a look
        for _ in range(r.integers(1, 61)):
            heights = np.rint(4 * r.random(2)) / 4 if size < 1 else r.random(2)
            u, w = edges[-1][2:] if edges and r.random() < 1 / 3 else (size * r.uniform(-1.2, 1.2), heights[0])
            wide = r.choice([0.01 * BLUR, 0, 3 * BLUR, *[0.4 * size] * 5])
            edges.append([u, w, u + r.uniform(-wide, wide), heights[1]])
            left = min(edges[-1][0], edges[-1][2]) - 1e-3
            rows.append([ADD, *edges[-1], 0, max(left, -1.5) if r.random() < 0.5 else -np.inf])
        edges = np.array(edges)
        far = size * np.cumsum([-1, *r.uniform(0, 0.01, 500)])
        far, ends = far[far <= size], edges[:, ::2][np.abs(edges[:, ::2]) < 1]
        parts = [(k, min(k + r.integers(2, 9), len(far))) for k in range(len(far) - 1)]
        rows += [[LOOK, u, k > 0, 0, 0, 0, 0] for k, u in enumerate(far)] + [[LOOK, u, 0, 0, 0, 0, 0] for u in ends]
        rows += [[CLOSELY, u, 0, 0, 0, 0, 0] for u in far] + [[LEAST, far[k], far[last - 1], 0, 0, 0, 0] for k, last in parts]
        found = lands.table("skyline", rows)[1 + len(edges):]
        looks, closely, least = np.split(found, [len(far) + len(ends), -len(parts)])
        lowest = check(edges, [*far, *ends], *looks.T)
        check(edges, far, *closely.T, error=0)
        assert all(w <= lowest[k:last].min() + 1e-9 for (k, last), w in zip(parts, least[:, 0]))


def test_a_wall_of_single_places(lands):
    """Before a step down. Between those places the truth is the step."""
    edges = np.array([[-1, 0.9, 0, 0.9], [0, 0, 1, 0], *([k * BLUR / 8, 0, k * BLUR / 8, 1] for k in range(-40, 41))])
    places = BLUR * np.arange(-4.03, 4, 0.25)
    rows = [[NEW, *[0] * 6], *([ADD, *edge, 0, -np.inf] for edge in edges), *([LOOK, u, *[0] * 5] for u in places)]
    check(edges, places, *lands.table("skyline", rows)[-len(places):].T)


def test_rows_of_edges(lands):
    """Added from left to right again and again, as rows are, ever wider, with looks that begin at pieces found before."""
    across, rows, edges, r = 50, [[NEW, 0, 0, 0, 0, 0, 0]], [], np.random.default_rng(3)
    places = np.arange(-1, 1, 0.0037)
    for row in range(40):
        u, heights = np.linspace(-1.1, 1.1, across - row + 1), r.random(across - row + 1)
        for i in range(across - row):
            edge = [u[i], heights[i], u[i + 1], heights[i + 1]]
            edges.append(edge)
            rows.append([ADD, *(edge if i % 2 else edge[2:] + edge[:2]), i > 0, u[i] - 1e-2])
        rows += [[LOOK, u, k > 0, 0, 0, 0, 0] for k, u in enumerate(places)]
    edges.append([-1.1, 0.5, 1.1, 0.5])  # is cut into more pieces than there are
    rows += [[ADD, *edges[-1], 0, -1.11], *rows[-len(places):], [NEW, 0, 0, 0, 0, 0, 0]]
    kinds, found, edges = np.array(rows)[:, 0], lands.table("skyline", rows), np.array(edges)
    assert found[-1, 0] < 250, "pieces that are gone are not used again"
    assert (found[kinds == ADD, 0] == 1).all(), "a piece behind is lost"
    looks = found[kinds == LOOK].reshape(41, len(places), 2)
    for row, look in enumerate(looks):
        check(edges[:sum(across - k for k in range(row + 1))], places, *look.T)
