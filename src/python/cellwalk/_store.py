# SPDX-License-Identifier: Apache-2.0
"""Dask arrays to GeoTIFFs."""

from __future__ import annotations

import os
from typing import Any, Optional, cast

import dask.array as da
import numpy as np

from ._convert import describe_dataarray
from ._raster import GeoTiff, read_raster

# Tasks are annotated with the file that they read, which no result may replace.
INPUT = "cellwalk_input"


def _write_chunks(array: da.Array, write) -> None:
    """Calls write(slices, block) here for one chunk after another, as they are done. A chunk of a worker that died comes from another."""
    try:
        from distributed import as_completed, get_client
        client = get_client()
    except (ImportError, ValueError):
        class Target:
            def __setitem__(self, index, block) -> None:
                write(index, block)
        da.store(array, cast(Any, Target()), lock=True)
        return
    futures = client.compute(list(array.to_delayed().ravel()))
    places = {future.key: slices for future, slices in zip(futures, da.core.slices_from_chunks(array.chunks))}
    finished = as_completed(futures, with_results=True)
    del futures  # each chunk's memory is free when it is written
    for future, block in finished:
        write(places[future.key], block)


def _place_of(result, like, shape) -> tuple[Optional[np.ndarray], Optional[str]]:
    """Map and coordinate system, from a file or from the result's own coordinates."""
    if like is not None:
        name = os.fspath(like)
        about, _ = read_raster(name, 0)
        if about.shape != shape:
            raise ValueError(f"like: {name!r} has samples of shape {about.shape}, the result {shape}")
        return (about.map, about.crs.wkt) if about.placed else (None, None)
    if not hasattr(result, "dims") or any(name not in result.coords for name in result.dims[-2:]):
        return None, None
    described = describe_dataarray(result[0] if result.ndim == 3 else result)
    return described.map, described.crs.wkt


def _refuse_inputs(array: da.Array, path, like) -> None:
    """The file may be read until the last chunk is done, and the next run would read the result."""
    layers = array.__dask_graph__().layers.values()
    inputs = {(layer.annotations or {}).get(INPUT) for layer in layers} | {like if like is None else os.fspath(like)}
    for name in inputs - {None}:
        try:
            same = os.path.samefile(path, name)
        except OSError:  # one of them is not there, or on the network
            continue
        if same:
            raise ValueError(f"path: {os.fspath(path)!r} is also an input; choose another name for the output")


def to_geotiff(result: Any, path: str | os.PathLike[str], like: str | os.PathLike[str] | None = None) -> None:
    """Computes a result and writes it to a tiled GeoTIFF, chunk by chunk as they are done. Needs GDAL, as cellwalk.open.

    path: ends in .tif or .tiff. A file of that name is replaced, and keeps its owner and permissions, unless it is an input.
    like: a file of the same size whose place and coordinate system the result takes; default: the result's coordinates.

    The file is written by the process that calls this, and gets its name when all of it is on the disk. If anything fails, nothing
    is changed. Many machines write faster to zarr: result.to_dataset().to_zarr(path), where workers write their chunks themselves.
    """
    array = result.data if hasattr(result, "dims") else result
    if not isinstance(array, da.Array) or array.ndim not in (2, 3):
        raise TypeError(f"result: {type(result).__name__}, expected an array of Dask with two or three dimensions, as cellwalk.dask returns")
    if not all(n > 0 for n in array.shape):  # NaN: not known yet
        raise ValueError(f"result: shape {array.shape}, expected numbers above 0")
    _refuse_inputs(array, path, like)
    bands, rows, columns = (1, *array.shape)[-3:]
    # Compressed tiles that are written in parts would leave gaps.
    aligned = all(edge % 256 == 0 for sizes in array.chunks[-2:] for edge in np.cumsum(sizes)[:-1])
    dtype = array.dtype.newbyteorder("=")
    nodata = np.nan if dtype.kind != "u" and dtype.kind != "i" else np.iinfo(dtype).max
    file = GeoTiff(path, bands, rows, columns, dtype.name, nodata, *_place_of(result, like, (rows, columns)), aligned)

    def write(index, block):
        window = [n for s in index[-2:] for n in (s.start, s.stop - s.start)]
        blocks = np.asarray(block).reshape((-1, window[1], window[3]))
        for band, part in enumerate(blocks, index[0].start if array.ndim == 3 else 0):
            file.write(band, window[0], window[2], window[1], window[3], np.ascontiguousarray(part, dtype))

    try:
        _write_chunks(array, write)
        file.commit()
    finally:
        file.discard()
