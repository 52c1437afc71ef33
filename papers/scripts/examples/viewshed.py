# SPDX-License-Identifier: Apache-2.0
"""The ground in sight from a place of dem.tif, over its relief. Draws viewshed.png."""
import subprocess
import numpy as np
import rasterio
from matplotlib import pyplot
from matplotlib.patches import Patch

EYE, COLOUR = (-84.2308, 36.4850), (1, 0.72, 0.1)
subprocess.run(["cellwalk", "viewshed", "dem.tif", "--from", f"{EYE[0]},{EYE[1]},10", "-o", "seen.tif"], check=True)
subprocess.run(["cellwalk", "shadow", "dem.tif", "--sun", "315,45", "--hillshade", "-o", "relief.tif"], check=True)
with rasterio.open("seen.tif") as file, rasterio.open("relief.tif") as shade:
    seen, relief, box = file.read(1) == 1, shade.read(1), file.bounds

figure, axes = pyplot.subplots(figsize=(7, 6), layout="constrained")
axes.imshow(relief[..., None] * np.where(seen[..., None], COLOUR, 0.8), extent=(box.left, box.right, box.bottom, box.top),
            aspect=1 / np.cos(np.radians(EYE[1])))
eye = axes.plot(*EYE, "o", color="red", markeredgecolor="white", markersize=9, label="the observer, 10 m above ground")
axes.set(title=f"In sight: {seen.mean():.0%} of the ground", xlabel="longitude", ylabel="latitude")
axes.ticklabel_format(useOffset=False)
east = 5 / (111.32 * np.cos(np.radians(box.bottom)))  # 5 km in degrees
axes.plot([box.left + 0.01, box.left + 0.01 + east], [box.bottom + 0.01] * 2, color="red", linewidth=3)
axes.text(box.left + 0.01 + east / 2, box.bottom + 0.018, "5 km", ha="center", backgroundcolor="white")
axes.legend(handles=[*eye, Patch(color=COLOUR, label="in sight"), Patch(color="0.6", label="hidden")],
            loc="upper right")
figure.savefig("viewshed.png", dpi=80)
