# SPDX-License-Identifier: Apache-2.0
"""Arrays in whatever form they come: the answers are those of the plainest form."""
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hn

import cellwalk as cw
from conftest import random_rays, rough, same, same_hits, share

FIELD = cw.Field(rough())
MAP = np.array([[2, 0.5, 0, 100], [0.25, -3, 0, 500], [0, 0, 1.5, 7]])
MAPPED = cw.Field(rough(), transform=MAP)
HITS = MAPPED.closest(random_rays(MAPPED, 50)).records


def parts(rays):
    return rays[..., 0:3], rays[..., 4:7], rays[..., 3], rays[..., 7]


@pytest.mark.parametrize("field", [FIELD, MAPPED], ids=["plain", "mapped"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_forms_agree(field, dtype):
    rays = random_rays(field, 6000, dtype=dtype)
    wanted = field.closest(rays)
    assert 0.1 < wanted.hit.mean() < 0.95
    o, d, t0, t1 = parts(rays)
    same_hits(field.closest(o, d, t0, t1), wanted)  # views with gaps
    same_hits(field.closest(rays.astype(rays.dtype.newbyteorder())), wanted)  # big-endian
    same_hits(field.closest(np.asfortranarray(rays)), wanted)
    same_hits(field.closest(rays[::-1])[::-1], wanted)
    odd = np.frombuffer(bytearray(rays.nbytes + 1), np.uint8)[1:].view(dtype).reshape(rays.shape)
    odd[:] = rays
    same_hits(field.closest(odd), wanted)
    folded = field.closest(rays.reshape(60, 100, 8))
    assert folded.shape == (60, 100)
    same(folded.t.reshape(-1), wanted.t)
    same_hits(field.closest(rays.astype(np.float64)), wanted)  # widened: the same rays
    six = np.concatenate([o, d], -1)
    same_hits(field.closest(six, tmin=t0, tmax=t1), wanted)
    same(field.occluded(rays), wanted.hit)
    same(field.occluded(o, d, t0, t1), wanted.hit)


@settings(deadline=None, max_examples=share(60))
@given(shapes=hn.mutually_broadcastable_shapes(num_shapes=4, max_dims=3, max_side=4, min_side=0), seed=st.integers(0, 2**31),
       types=st.tuples(*[st.sampled_from(["f4", "f8", ">f4", "f2", "i4"])] * 4))
def test_broadcasting(shapes, seed, types):
    random = np.random.default_rng(seed)
    o, d, t0, t1 = shapes.input_shapes
    arrays = [random.uniform(-3, 60, o + (3,)), random.uniform(-4, 4, d + (3,)), random.uniform(-9, 0, t0), random.uniform(0, 90, t1)]
    arrays = [np.asarray(a).astype(t) for a, t in zip(arrays, types)]
    h = FIELD.closest(*arrays)
    assert h.shape == shapes.result_shape and h.points().shape == (*h.shape, 3)
    full = [np.broadcast_to(a.astype(np.float64), h.shape + (3,) * (k < 2)) for k, a in enumerate(arrays)]
    plain = np.zeros(h.shape + (8,))
    plain[..., 0:3], plain[..., 4:7], plain[..., 3], plain[..., 7] = full
    same_hits(h, FIELD.closest(plain))
    same(FIELD.occluded(*arrays), h.hit)


@settings(deadline=None, max_examples=share(60))
@given(rays=hn.arrays(np.float64, hn.array_shapes(max_dims=1, max_side=8).map(lambda s: s + (8,)),
                      elements=st.floats(width=64, allow_nan=True, allow_infinity=True)))
def test_any_numbers(rays):
    h = FIELD.closest(rays)
    assert (np.isfinite(h.t) == h.hit).all() and ((h.i >= 0) == (h.j >= 0)).all() and (np.isinf(h.t) & (h.t > 0))[~h.hit].all()
    same(FIELD.occluded(rays), h.hit)
    same(np.isnan(h.points()).all(-1), ~h.hit)


def test_truth():
    h = FIELD.closest([[41, 30, 60], [1e6, 0, 0]], [0, 0, -1])
    assert h[0] and not h[1]
    with pytest.raises(ValueError, match="2 rays is ambiguous"):
        bool(h)


def test_many_rays():
    n = 10**7
    eye, v = np.array([41.0, 30, 60]), np.column_stack([np.linspace(-1, 1, n), np.linspace(0.9, -0.9, n), np.full(n, -1)]).astype(np.float32)
    same(FIELD.occluded(eye, v)[:: n // 1000], FIELD.closest(eye, v[:: n // 1000]).hit)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int32, ">f8"])
def test_masked_rays_miss(dtype):
    rays = np.ma.masked_array(np.tile(np.array([3, 3, 90, 0, 0, -1]), (5, 1)).astype(dtype))
    assert FIELD.closest(rays).hit.all()
    rays[1, 2] = rays[3, 5] = np.ma.masked
    assert FIELD.closest(rays).hit.tolist() == [True, False, True, False, True] and FIELD.occluded(rays).tolist() == [True, False, True, False, True]
    assert np.isnan(FIELD.at(np.ma.masked_array([3, 3], [False, True]), 3)).tolist() == [False, True]


@pytest.mark.parametrize("arguments, kind, words", [
    ((np.zeros(3), np.zeros((10, 2))), ValueError, r"directions: shape \(10, 2\), expected \(\.\.\., 3\)"),
    ((np.zeros((4, 3)), np.zeros((5, 3))), ValueError, r"do not broadcast: origins \(4, 3\), directions \(5, 3\)"),
    ((np.zeros((4, 7)),), ValueError, r"rays: shape \(4, 7\), expected \(\.\.\., 6\)"),
    ((5.0,), ValueError, r"rays: shape \(\)"),
    (([[1, 2, 3], [1, 2]], np.zeros(3)), ValueError, "origins: setting an array element"),
    ((np.zeros(3), ["a", "b", "c"]), TypeError, "directions: dtype <U1"),
    ((np.zeros((4, 8)), None, 0), ValueError, "tmin, tmax: rays of shape"),
    ((np.zeros(3), np.zeros(3), np.zeros((2,)), np.zeros((3,))), ValueError, r"do not broadcast.*tmin \(2,\), tmax \(3,\)"),
])
def test_wrong_arguments(arguments, kind, words):
    for call in (FIELD.closest, FIELD.occluded):
        with pytest.raises(kind, match=words):
            call(*arguments)


def test_packed_floats_with_wider_ends():
    """A range that is no float is not rounded, whatever form the rays have."""
    rays = random_rays(FIELD, 500, dtype=np.float32)[:, [0, 1, 2, 4, 5, 6]]
    ends = FIELD.closest(rays).t.astype(np.float64)
    for end in (ends * (1 - 1e-12), 0.3):
        same_hits(FIELD.closest(rays, tmax=end), FIELD.closest(rays[:, :3], rays[:, 3:], tmax=end))


def test_points_and_normals():
    h = MAPPED.closest(random_rays(MAPPED, 500))
    points, flat, smooth = h.points(), h.normals(), h.normals(True)
    assert all((np.isnan(values).any(-1) == ~h.hit).all() for values in (points, flat, smooth))
    # Heights are at most 30 here; a place of at most 600 is off by 2^-52 of it, times slopes of at most 10.
    assert np.nanmax(np.abs(MAPPED.at(points[:, 0], points[:, 1]) - points[:, 2])) < 600 * 2.0**-52 * 100
    assert np.nanmax(np.abs(np.linalg.norm(smooth, axis=-1) - 1)) < 1e-14 and (smooth != flat)[h.hit].any()


@pytest.mark.parametrize("records", [np.zeros(3), HITS.astype(HITS.dtype.newbyteorder()), HITS[["i", "j"]].copy()], ids=["floats", "swapped", "part"])
def test_other_records_are_refused(records):
    """As hits they would be read beyond their end."""
    with pytest.raises(TypeError, match="^records: dtype .*, expected that of"):
        cw.Hits(records, MAPPED).points()


def test_at_is_the_surface():
    z = rough(holes=False)
    field = cw.Field(z)
    same(field.at(*np.mgrid[:z.shape[0], :z.shape[1]][::-1]), z.astype(np.float64))
    assert np.isnan(field.at([-1, 999, np.nan], 5)).all() and field.at([], []).shape == (0,) and isinstance(field.at(1, 1), np.float64)
    with pytest.raises(ValueError, match=r"x \(2,\), y \(3,\)"):
        field.at([1, 2], [1, 2, 3])
