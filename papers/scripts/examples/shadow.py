# SPDX-License-Identifier: Apache-2.0
"""Sunlight on dem.tif on a winter afternoon, shadows of the terrain included. Draws shadow.png."""
import subprocess
import numpy as np
import rasterio
from matplotlib import pyplot

WHEN = "2024-12-21T20:30:00Z"
subprocess.run(["cellwalk", "shadow", "dem.tif", "--time", WHEN, "--hillshade", "--sun-disc", "-o", "light.tif"], check=True)
with rasterio.open("light.tif") as file:
    light, box = file.read(1), file.bounds

figure, axes = pyplot.subplots(figsize=(7, 6), layout="constrained")
image = axes.imshow(light, cmap="gray", vmin=0, vmax=light.max(), extent=(box.left, box.right, box.bottom, box.top),
                    aspect=1 / np.cos(np.radians((box.top + box.bottom) / 2)))
axes.set(title=f"Sunlight, {WHEN}", xlabel="longitude", ylabel="latitude")
axes.ticklabel_format(useOffset=False)
east = 5 / (111.32 * np.cos(np.radians(box.bottom)))  # 5 km in degrees
axes.plot([box.left + 0.01, box.left + 0.01 + east], [box.bottom + 0.01] * 2, color="red", linewidth=3)
axes.text(box.left + 0.01 + east / 2, box.bottom + 0.018, "5 km", ha="center", backgroundcolor="white")
figure.colorbar(image, label="share of the light of a surface that faces the sun", shrink=0.8)
figure.savefig("shadow.png", dpi=80)
