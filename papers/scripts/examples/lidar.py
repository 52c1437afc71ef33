# SPDX-License-Identifier: Apache-2.0
"""Rays of a lidar that flies 2 km above ground, in metres of a local map: python3 lidar.py [PICTURE]"""
import sys

import cellwalk as cw
import dem
import matplotlib
import numpy as np

matplotlib.use("Agg")
f = cw.Field(dem.field().z, transform=(74.5, 0, 0, 0, -92.5, 344 * 92.5))  # metres a sample at 36.6 degrees
track = np.linspace(2000, 28000, 600)  # the aircraft flies east
angle = np.radians(np.linspace(-30, 30, 400))  # and looks from side to side
origins = np.stack([track, np.full(600, 16000), np.full(600, 2500)], -1)[:, None, :]
directions = np.stack([np.zeros(400), np.sin(angle), -np.cos(angle)], -1)
hits = f.closest(origins, directions)
slope = np.degrees(np.arccos(hits.normals()[..., 2]))
print(f"{hits.hit.sum()} of {hits.hit.size} rays hit, {hits.t.min():.1f} to {hits.t[hits.hit].max():.1f} m away")
print(f"lowest and highest ground: {hits.points()[..., 2].min():.1f} and {hits.points()[..., 2].max():.1f} m; slope {slope.mean():.1f} degrees")
dem.show([hits.t.T, slope.T], ["distance, m, by km of track and angle", "slope, degrees"], sys.argv[1] if len(sys.argv) > 1 else "lidar.png",
         extent=(2, 28, -30, 30), aspect="auto")
