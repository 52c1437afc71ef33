# SPDX-License-Identifier: Apache-2.0
"""How high the terrain of dem.tif stands against the sky toward the south-east. Draws horizon.png."""
import subprocess
import numpy as np
import rasterio
from matplotlib import pyplot

subprocess.run(["cellwalk", "horizon", "dem.tif", "--directions", "1", "--start", "135", "-o", "angles.tif"], check=True)
with rasterio.open("angles.tif") as file:
    angles, box = file.read(1), file.bounds

figure, axes = pyplot.subplots(figsize=(7, 6), layout="constrained")
image = axes.imshow(angles, cmap="magma", vmin=0, extent=(box.left, box.right, box.bottom, box.top),
                    aspect=1 / np.cos(np.radians((box.top + box.bottom) / 2)))
axes.set(title="Horizon toward azimuth 135°", xlabel="longitude", ylabel="latitude")
axes.ticklabel_format(useOffset=False)
east = 5 / (111.32 * np.cos(np.radians(box.bottom)))  # 5 km in degrees
axes.plot([box.left + 0.01, box.left + 0.01 + east], [box.bottom + 0.01] * 2, color="red", linewidth=3)
axes.text(box.left + 0.01 + east / 2, box.bottom + 0.018, "5 km", ha="center", backgroundcolor="white")
figure.colorbar(image, label="degrees above the level of the place", shrink=0.8, extend="min")
figure.savefig("horizon.png", dpi=80)
