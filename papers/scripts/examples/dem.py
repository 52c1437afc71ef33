# SPDX-License-Identifier: Apache-2.0
"""A real elevation model as dem.tif: the Jacksboro fault in Tennessee, 3 seconds of arc, out of Debian's python3-matplotlib."""
import numpy as np
import rasterio

data = np.load("/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz")
heights = data["elevation"]
rows, columns = heights.shape
west, north = data["xmin"], max(data["ymin"], data["ymax"])
with rasterio.open("dem.tif", "w", driver="GTiff", width=columns, height=rows, count=1, dtype="int16", crs="EPSG:4326",
                   transform=rasterio.transform.from_origin(west, north, data["dx"], data["dy"])) as file:
    file.write(heights, 1)
