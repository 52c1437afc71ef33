# SPDX-License-Identifier: Apache-2.0
"""A raster by chunks, each a task of Dask's, on one machine or many: python3 chunked.py [PICTURE]"""
import sys

import cellwalk.dask as cwd
import dem
import matplotlib
import numpy as np
import xarray as xr

matplotlib.use("Agg")
f = dem.field()
y, x = (f.map[k, 3] + f.map[k, k] * np.arange(f.shape[k ^ 1]) for k in (1, 0))
land = xr.DataArray(f.z, dims=("lat", "lon"), coords={"lat": y, "lon": x}).chunk(100)  # or a path, such as "land.tif"
lit = cwd.shadow(land, azimuth=240, altitude=10)  # nothing but lowest and highest samples has been looked for yet
print(f"{lit.data.npartitions} chunks of at most {max(map(max, lit.chunks))} x {max(map(max, lit.chunks))} samples")
done = lit.compute()  # cwd.to_geotiff(lit, "shadow.tif") writes chunks as they are done
print(f"{float((done == 0).mean()):.1%} in the shadow; {int((done.values != f.shadow(240, 10)).sum())} samples differ from the whole raster")
dem.show([done], ["sun at azimuth 240°, 10° high"], sys.argv[1] if len(sys.argv) > 1 else "chunked.png", cmap="gray")
