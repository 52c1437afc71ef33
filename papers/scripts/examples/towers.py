# SPDX-License-Identifier: Apache-2.0
"""What two towers see, and whether they see each other: python3 towers.py [PICTURE]"""
import sys

import dem
import matplotlib
import numpy as np

matplotlib.use("Agg")
f = dem.field()
x, y = [-84.2417, -84.2308], [36.5567, 36.4850]
seen = f.viewshed(x, y, observer_height=30, target_height=2, max_distance=20000)
for count, words in enumerate(("nothing", "one tower", "both towers")):
    print(f"{np.mean(seen == count):.1%} of the land is seen by {words}")
line = f.line_of_sight((x[0], y[0], 30), (x[1], y[1], 30))
print(f"{line.distance / 1000:.2f} km apart,", "in sight" if line.visible else f"blocked after {line.blocked_distance / 1000:.2f} km")
needed = f.viewshed(x[0], y[0], observer_height=30, needed=True)
dem.show([seen, needed], ["towers that see it", "height needed to be seen from the first, m"],
         sys.argv[1] if len(sys.argv) > 1 else "towers.png")
