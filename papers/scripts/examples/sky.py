# SPDX-License-Identifier: Apache-2.0
"""The horizon to the west, and the share of the sky that is seen: python3 sky.py [PICTURE]"""
import sys

import dem
import matplotlib

matplotlib.use("Agg")
f = dem.field()
west = f.horizon(directions=4)[3]  # north, east, south, west
sky = f.sky_view(directions=32)
row, column = divmod(int(sky.argmin()), f.shape[1])
print(f"least sky: {sky.min():.1%} in row {row}, column {column}; there the western horizon is {west[row, column]:.1f} degrees high")
print(f"mean share of the sky: {sky.mean():.2%}")
path = sys.argv[1] if len(sys.argv) > 1 else "sky.png"
dem.show([west, 100 * sky], ["horizon to the west, degrees", "sky that is seen, %"], path)
