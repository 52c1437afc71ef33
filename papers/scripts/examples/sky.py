# SPDX-License-Identifier: Apache-2.0
"""The sky-view factor of dem.tif: which share of an evenly bright sky lights level ground. Draws sky.png."""
import subprocess
import numpy as np
import rasterio
from matplotlib import pyplot

subprocess.run(["cellwalk", "horizon", "dem.tif", "--directions", "64", "--svf", "-o", "sky.tif"], check=True)
with rasterio.open("sky.tif") as file:
    sky, box = file.read(1), file.bounds

figure, axes = pyplot.subplots(figsize=(7, 6), layout="constrained")
image = axes.imshow(sky, cmap="cividis", vmin=np.percentile(sky, 1),
                    extent=(box.left, box.right, box.bottom, box.top), aspect=1 / np.cos(np.radians((box.top + box.bottom) / 2)))
axes.set(title="Sky-view factor, 64 directions", xlabel="longitude", ylabel="latitude")
axes.ticklabel_format(useOffset=False)
east = 5 / (111.32 * np.cos(np.radians(box.bottom)))  # 5 km in degrees
axes.plot([box.left + 0.01, box.left + 0.01 + east], [box.bottom + 0.01] * 2, color="red", linewidth=3)
axes.text(box.left + 0.01 + east / 2, box.bottom + 0.018, "5 km", ha="center", backgroundcolor="white")
figure.colorbar(image, label="share of the sky", shrink=0.8, extend="min")
figure.savefig("sky.png", dpi=80)
