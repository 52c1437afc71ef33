# SPDX-License-Identifier: Apache-2.0
"""Rays as callers have them - origins and directions that broadcast, or packed - as operands of the extension: rows of numbers with
any step between them, which is 0 for what all rays share. Nothing is copied that has such a form already."""

from __future__ import annotations

import numpy as np

from ._convert import numbers


def _operand(array: np.ndarray, shape: tuple, width: tuple) -> np.ndarray:
    """The array broadcast to the rays, one after another."""
    rows = np.broadcast_to(array, shape + width).reshape(-1, *width)
    return np.ascontiguousarray(rows) if width and rows.strides[1] != rows.itemsize else rows


def _unpack(rays, tmin, tmax):
    """Origins, directions, tmin and tmax as views of packed rays."""
    rays = numbers(rays, "rays")
    if rays.ndim == 0 or rays.shape[-1] not in (6, 8):
        raise ValueError(f"rays: shape {rays.shape}, expected (..., 6) with origin and direction, "
                         "or (..., 8) with origin, tmin, direction and tmax")
    rays = np.ascontiguousarray(rays)
    if rays.shape[-1] == 8:
        if tmin is not None or tmax is not None:
            raise ValueError("tmin, tmax: rays of shape (..., 8) have theirs already")
        return rays[..., :3], rays[..., 4:7], rays[..., 3], rays[..., 7]
    shape = rays.shape[:-1]
    for end, name in (tmin, "tmin"), (tmax, "tmax"):
        if np.ndim(end) > len(shape) or any(n not in (1, m) for n, m in zip(np.shape(end)[::-1], shape[::-1])):
            raise ValueError(f"{name}: shape {np.shape(end)} does not broadcast to that of the rays, {shape}")
    return rays[..., :3], rays[..., 3:], tmin, tmax


def rays_of(origins, directions, tmin, tmax):
    """Shape of the answer, and operands."""
    if directions is None:
        origins, directions, tmin, tmax = _unpack(origins, tmin, tmax)
    given = [numbers(origins, "origins"), numbers(directions, "directions"), numbers(0 if tmin is None else tmin, "tmin"),
             numbers(np.inf if tmax is None else tmax, "tmax")]
    names = ("origins", "directions", "tmin", "tmax")
    for array, name in zip(given[:2], names):
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"{name}: shape {array.shape}, expected (..., 3)")
    leads = [array.shape[:-1] for array in given[:2]] + [array.shape for array in given[2:]]
    try:
        shape = np.broadcast_shapes(*leads)
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for array, name in zip(given, names))
        raise ValueError(f"shapes do not broadcast: {shapes}") from None
    # Floats stay floats: widened, they would give the same rays. Scalars do not decide, but no double is rounded that is no float.
    narrow = all(array.dtype == np.float32 if array.ndim else float(np.float32(array)) == float(array) for array in given)
    dtype = np.dtype(np.float32 if narrow else np.float64)
    return shape, tuple(_operand(array.astype(dtype, copy=False), shape, width) for array, width in zip(given, ((3,), (3,), (), ())))
