# SPDX-License-Identifier: Apache-2.0
"""Products by chunks go to zarr, where workers write them themselves."""
import numpy as np
import pytest

pytest.importorskip("zarr")
xr = pytest.importorskip("xarray")
pytest.importorskip("dask.array")

import cellwalk as cw  # noqa: E402
import cellwalk.dask as cwd  # noqa: E402
from conftest import rough, same  # noqa: E402


def test_zarr(tmp_path):
    d = xr.DataArray(rough(), dims=("y", "x"), coords={"y": 5e6 - 30.0 * np.arange(61), "x": 6e5 + 30.0 * np.arange(83)})
    np.save(tmp_path / "dem.npy", d.values)
    for k, (result, wanted) in enumerate([
            (cwd.shadow(d.chunk({"x": 32, "y": 32}), 100, 12), cw.Field(d).shadow(100, 12)),
            (cwd.horizon(tmp_path / "dem.npy", 4, 20, chunks=32), cw.open(tmp_path / "dem.npy").horizon(4, 20)),
            (cwd.viewshed(d.chunk({"x": 32, "y": 32}), 601000, 4999000, needed=True), cw.Field(d).viewshed(601000, 4999000, needed=True))]):
        result.to_dataset().to_zarr(tmp_path / f"{k}.zarr")
        back = xr.open_zarr(tmp_path / f"{k}.zarr", mask_and_scale=False)[result.name]
        assert back.chunks == result.chunks
        same(back.values, np.asarray(wanted))
        assert (back.x == result.x).all()
