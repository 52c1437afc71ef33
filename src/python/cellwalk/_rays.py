# SPDX-License-Identifier: Apache-2.0
"""Rays as callers have them - origins and directions that broadcast, or packed - as operands of the extension: a contiguous
buffer, an offset and a step in bytes, which is 0 for what all rays share. Nothing is copied that has such a form already."""

from __future__ import annotations

import math

import numpy as np

from ._convert import numbers


def _operand(array: np.ndarray, shape: tuple, width: int):
    """The array broadcast to shape + (width,), or to shape if width is 0."""
    item = array.dtype.itemsize * (width or 1)
    lead = array.shape[:-1] if width else array.shape
    if lead != shape and math.prod(lead) == 1:
        return np.ascontiguousarray(array), 0, 0
    if lead != shape:
        array = np.broadcast_to(array, shape + ((width,) if width else ()))
    return np.ascontiguousarray(array), 0, item


def _packed(rays, tmin, tmax):
    rays = numbers(rays, "rays")
    if rays.ndim == 0 or rays.shape[-1] not in (6, 8):
        raise ValueError(f"rays: shape {rays.shape}, expected (..., 6) with origin and direction, "
                         "or (..., 8) with origin, tmin, direction and tmax")
    rays = np.ascontiguousarray(rays)
    shape, width, size = rays.shape[:-1], rays.shape[-1], rays.dtype.itemsize
    step = width * size
    if width == 8:
        if tmin is not None or tmax is not None:
            raise ValueError("tmin, tmax: rays of shape (..., 8) have theirs already")
        return shape, rays.dtype, [(rays, place * size, step) for place in (0, 4, 3, 7)]
    ends = [numbers(0 if tmin is None else tmin, "tmin"), numbers(np.inf if tmax is None else tmax, "tmax")]
    for end, name in zip(ends, ("tmin", "tmax")):
        if len(end.shape) > len(shape) or any(n not in (1, m) for n, m in zip(end.shape[::-1], shape[::-1])):
            raise ValueError(f"{name}: shape {end.shape} does not broadcast to that of the rays, {shape}")
    if rays.dtype == np.float32 and not all((end.astype(np.float32) == end).all() for end in ends):
        rays, step = rays.astype(np.float64), 2 * step  # doubles that are no floats are not rounded
        size *= 2
    ends = [end.astype(rays.dtype, copy=False) for end in ends]
    return shape, rays.dtype, [(rays, 0, step), (rays, 3 * size, step)] + [_operand(end, shape, 0) for end in ends]


def rays_of(origins, directions, tmin, tmax):
    """Shape of the answer, dtype, operands."""
    if directions is None:
        return _packed(origins, tmin, tmax)
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
    # Floats stay floats: widened, they would give the same rays. Scalars do not decide.
    arrays = [array for array in given if array.ndim > 0]
    dtype = np.dtype(np.float32 if all(array.dtype == np.float32 for array in arrays) else np.float64)
    if dtype == np.float32:
        for array in given:  # a double that is no float must not be rounded here
            if array.ndim == 0 and array.dtype == np.float64 and float(np.float32(array)) != float(array):
                dtype = np.dtype(np.float64)
    return shape, dtype, [_operand(array.astype(dtype, copy=False), shape, width) for array, width in zip(given, (3, 3, 0, 0))]
