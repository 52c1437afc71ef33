# SPDX-License-Identifier: Apache-2.0
"""Calls of the Python module with a million rays, interleaved: prints JSON lines. The tool names the instruction set.

    python3 python_speed.py --tool build/release/src/tool/cellwalk [--rounds 7]
"""
import argparse
import json
import time

import numpy as np

import cellwalk as cw
from terrain import record, said

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--tool", required=True)
options.add_argument("--rounds", type=int, default=7)
o = options.parse_args()
SIDE, VIEW = 1025, 1000  # samples and rays a side

random = np.random.default_rng(1)
y, x = np.mgrid[0:SIDE, 0:SIDE]
z = sum(2.0 ** -k * 60 * np.sin(x * 2 ** k / 97 + k) * np.cos(y * 2 ** k / 83 - k) for k in range(7)).astype("float32")
v, u = np.mgrid[0:VIEW, 0:VIEW] / VIEW
rays = np.zeros((VIEW * VIEW, 8), "float32")  # a view from above one edge
rays[:, 0:3], rays[:, 5], rays[:, 7] = (SIDE / 2, -0.2 * SIDE, 0.35 * SIDE), 1, np.inf
rays[:, 4], rays[:, 6] = (u - 0.5).ravel(), (-0.05 - 0.6 * v).ravel()
wide = rays.astype("float64")
transform = np.array([[30.0, 0, 0, 600015], [0, -30, 0, 5199985], [0, 0, 30, 0]])
user = wide.copy()
user[:, 0:3] = wide[:, 0:3] @ transform[:, :3].T + transform[:, 3]
user[:, 4:7] = wide[:, 4:7] @ transform[:, :3].T
field, mapped = cw.Field(z, threads=1), cw.Field(z, transform=transform, threads=1)
org, dirs, uorg, udirs = (np.ascontiguousarray(a) for a in (rays[:, 0:3], rays[:, 4:7], user[:, 0:3], user[:, 4:7]))


def timed(call):
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


contenders = {
    "closest(rays), float32": lambda: timed(lambda: field.closest(rays)),
    "closest(origins, directions), float32": lambda: timed(lambda: field.closest(org, dirs)),
    "closest(origins, directions), float64 on a map": lambda: timed(lambda: mapped.closest(uorg, udirs)),
    "closest(rays), float64 on a map": lambda: timed(lambda: mapped.closest(user)),
    "occluded(rays), float32": lambda: timed(lambda: field.occluded(rays)),
}
wanted = field.closest(rays)
assert (field.closest(org, dirs).t == wanted.t).all()
about = {"numpy": np.__version__, "rays": len(rays), "side": SIDE, "threads": 1, "hit": float(wanted.hit.mean())}
times = {name: [] for name in contenders}
for _ in range(o.rounds):
    for name in random.permutation(list(contenders)):
        times[name].append(contenders[name]())
print(json.dumps(record("python_speed", f"--tool TOOL --rounds {o.rounds}", json.loads(said(o.tool, "info", "--json"))["isa"], **about)))
for name, t in times.items():
    print(json.dumps({"kind": "call", "call": name, "least": min(t)}))
