# SPDX-License-Identifier: Apache-2.0
"""Shadow at four hours of a winter day: python3 shadows.py [PICTURE]"""
import sys

import dem
import matplotlib
import numpy as np

matplotlib.use("Agg")
f = dem.field()
pictures, titles = [], []
for hour in ("08:30", "11:00", "14:00", "16:30"):
    time = f"2024-12-21T{hour}:00-05:00"
    sun = f.sun(time)
    pictures.append(f.shadow(time=time, hillshade=True, disc=True))
    titles.append(f"{hour}, sun {sun.altitude:.1f}° high")
    print(f"{hour}: sun at azimuth {sun.azimuth:.1f}, altitude {sun.altitude:.1f}; "
          f"{np.mean(f.shadow(time=time) == 0):.1%} in the shadow")
dem.show(pictures, titles, sys.argv[1] if len(sys.argv) > 1 else "shadows.png", cmap="gray", vmin=0, vmax=1)
