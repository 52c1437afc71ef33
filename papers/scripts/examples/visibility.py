# SPDX-License-Identifier: Apache-2.0
"""How much of dem.tif each place sees, beside its relief. Draws visibility.png."""
import subprocess
import numpy as np
import rasterio
from matplotlib import colors, pyplot

subprocess.run(["cellwalk", "visibility", "dem.tif", "-o", "km2.tif"], check=True)
subprocess.run(["cellwalk", "shadow", "dem.tif", "--sun", "315,45", "--hillshade", "-o", "relief.tif"], check=True)
with rasterio.open("km2.tif") as file, rasterio.open("relief.tif") as shade:
    area, relief, box = file.read(1), shade.read(1), file.bounds

figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 5.4), layout="constrained", sharey=True)
where = {"extent": (box.left, box.right, box.bottom, box.top), "aspect": 1 / np.cos(np.radians((box.top + box.bottom) / 2))}
left.imshow(relief, cmap="gray", **where)
image = right.imshow(area, cmap="inferno", norm=colors.LogNorm(np.percentile(area, 2), area.max()), **where)
left.set(title="Relief", xlabel="longitude", ylabel="latitude")
right.set(title="Ground in sight from 2 m above it", xlabel="longitude")
east = 5 / (111.32 * np.cos(np.radians(box.bottom)))  # 5 km in degrees
for axes, colour in ((left, "red"), (right, "white")):
    axes.ticklabel_format(useOffset=False)
    axes.plot([box.left + 0.01, box.left + 0.01 + east], [box.bottom + 0.01] * 2, color=colour, linewidth=3)
left.text(box.left + 0.01 + east / 2, box.bottom + 0.018, "5 km", ha="center", backgroundcolor="white")
figure.colorbar(image, label="square kilometres", shrink=0.8, extend="min")
figure.savefig("visibility.png", dpi=80)
