#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far the area in sight from a place is off, and what it costs, by the number of directions; beside nearest samples and interpolated
heights at unit steps. Truth: the viewshed of the same triangles on a lattice four times as fine, by those of its samples that lie inside
triangles, since edges stick out. Prints papers/data/visibility.json, with --time papers/data/visibility-time.json. Needs NumPy, Debian's
python3-matplotlib for its elevation model, and the Python module (PYTHONPATH)."""

import argparse
import itertools
import json
import math
import os
import subprocess
import tempfile
import time

import numpy as np

import cellwalk as cw
import terrain

EYE = 2.0
JACKSBORO = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"


def lands():
    """Name, heights, width of cells in metres."""
    yield "Jacksboro", np.load(JACKSBORO)["elevation"].astype(np.float32), 83.0
    yield "fractal", terrain.land(513), 10.0


def ridged(n, seed=7):
    """Ridges and valleys without lakes: a sum of octaves of (1 - |noise|)^2, the noise of one interpolated between random numbers."""
    rng, z = np.random.default_rng(seed), np.zeros((n, n))
    for octave in range(max(1, math.ceil(math.log2(n / 64)) + 3)):
        at = np.arange(n) * 8 * 2 ** octave / n
        k, u = at.astype(int), at % 1
        u = u ** 3 * (u * (u * 6 - 15) + 10)
        random = rng.random((k[-1] + 2, k[-1] + 2)) * 2 - 1
        rows = random[k] + u[:, None] * (random[k + 1] - random[k])
        z += 0.5 ** (octave + 1) * (1 - np.abs(rows[:, k] + u * (rows[:, k + 1] - rows[:, k]))) ** 2
    return (z * 1500 * n / 1025).astype("<f4")


def field(z, cell):
    return cw.Field(z, transform=(cell, 0, 0, 0, -cell, 0), threads=1)


def finer(z, n=4):
    """The same triangles on a lattice n times as fine."""
    rows, columns = z.shape
    y, x = np.meshgrid(np.arange(n * (rows - 1) + 1) / n, np.arange(n * (columns - 1) + 1) / n, indexing="ij")
    j, i = np.minimum(y.astype(int), rows - 2), np.minimum(x.astype(int), columns - 2)
    v, u = y - j, x - i
    z = z.astype(float)
    side = np.where(u > v, z[j, i + 1], z[j + 1, i])
    return (z[j, i] + np.maximum(u, v) * (side - z[j, i]) + np.minimum(u, v) * (z[j + 1, i + 1] - side)).astype(np.float32)


def inside(shape, n=4):
    j, i = np.indices(shape)
    return (j % n != 0) & (i % n != 0) & ((i - j) % n != 0)


def truth(z, cell, eyes, n=4):
    """Square kilometres by area, and by counting the samples of z itself."""
    fine, coarse, area, counted = field(finer(z, n), cell / n), field(z, cell), [], []
    some = inside(fine.shape, n)
    for j, i in eyes:
        x, y = (i + 0.5) * cell, -(j + 0.5) * cell
        # Samples stand at the pixels' centres, which begin elsewhere with smaller pixels.
        seen = fine.viewshed((i * n + 0.5) * cell / n, -(j * n + 0.5) * cell / n, EYE, curvature=0)
        area.append(np.count_nonzero(seen[some]) * cell * cell / (n - 1) / (n - 2) / 1e6)
        counted.append(np.count_nonzero(coarse.viewshed(x, y, EYE, curvature=0)) * cell * cell / 1e6)
    return np.array(area), np.array(counted)


def by_samples(z, cell, eyes, directions, interpolated):
    """Heights at unit steps, as rotated rasters have them."""
    rows, columns = z.shape
    steps, out = np.arange(1, rows + columns), []
    angle = 2 * np.pi * np.arange(directions)[:, None] / directions
    for j, i in eyes:
        y, x = j + np.cos(angle) * steps, i + np.sin(angle) * steps
        there = (y >= 0) & (x >= 0) & (y <= rows - 1) & (x <= columns - 1)
        y, x = np.where(there, y, 0), np.where(there, x, 0)
        if interpolated:
            b, a = np.minimum(y.astype(int), rows - 2), np.minimum(x.astype(int), columns - 2)
            v, u = y - b, x - a
            h = (1 - v) * ((1 - u) * z[b, a] + u * z[b, a + 1]) + v * ((1 - u) * z[b + 1, a] + u * z[b + 1, a + 1])
        else:
            h = z[np.rint(y).astype(int), np.rint(x).astype(int)]
        slope = np.where(there, (h - z[j, i] - EYE) / (steps * cell), -np.inf)
        before = np.maximum.accumulate(np.pad(slope, ((0, 0), (1, 0)), constant_values=-np.inf), 1)[:, :-1]
        out.append(((slope > before) * steps).sum() * 2 * np.pi / directions * cell * cell / 1e6)
    return np.array(out)


def line(land, way, directions, got, wanted, seconds):
    off = (got - wanted) / wanted.mean()
    return {"kind": "area", "land": land, "way": way, "directions": directions, "bias": off.mean(), "rms": np.sqrt((off ** 2).mean()),
            "most_of_99": np.quantile(np.abs(off), 0.99), "cpu_seconds": seconds}


def pairs(n, directions):
    """Of an eye and a row or column that its rays cross on their way out of n x n samples."""
    way, total = np.arange(n), 0
    for k in range(directions):
        turn = 2 * math.pi * k / directions
        aside = min(abs(math.sin(turn)), abs(math.cos(turn))) / max(abs(math.sin(turn)), abs(math.cos(turn)))
        # Row by row of eyes: as far as the last row, or as the last column from each column.
        across = np.sort(np.ceil(way / aside)) if aside > 1e-9 else np.full(n, n)
        before = np.concatenate(([0], np.cumsum(across)))
        short = np.searchsorted(across, way)
        total += (before[short] + way * (n - short)).sum()
    return int(total)


def times(tool, sides, rounds, folder):
    """Rounds that take turns."""
    isas = [isa for isa in ("avx512", "avx2") if subprocess.run([tool, "info", "--isa", isa], capture_output=True).returncode == 0]
    for n, name in itertools.product(sides, ("ridged", "fractal")):
        z, high = ridged(n) if name == "ridged" else terrain.land(n), n == 6000  # 9 km of relief and cells of 30 m, for the case that CacheTVS publishes
        if high and name == "ridged":
            continue
        np.save(f"{folder}/land.npy", (z - z.min()) * np.float32(9000 / np.ptp(z)) if high else z)
        taken = {isa: [] for isa in isas}
        for isa in isas * rounds:
            before = os.times().elapsed
            subprocess.run([tool, "visibility", f"{folder}/land.npy", "--cellsize", "30" if high else "10", "--threads", "1",
                            "--isa", isa, "--quiet", "-o", f"{folder}/area.npy"], check=True)
            taken[isa].append(os.times().elapsed - before)
        for isa, seconds in taken.items():
            print(json.dumps({"kind": "time", "land": name, "side": n, "isa": isa, "directions": 128, "rounds": rounds,
                              "seconds": float(np.median(seconds)), "least": min(seconds), "most": max(seconds), "pairs": pairs(n, 128), "load": os.getloadavg()[0]}), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--eyes", type=int, default=300)
    parser.add_argument("--time", metavar="TOOL", help="instead: seconds of whole rasters by the program, on one thread")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--sides", type=int, nargs="+", default=[1025, 4097, 6000])
    options = parser.parse_args()
    how = f"--time TOOL --rounds {options.rounds} --sides {' '.join(map(str, options.sides))}" if options.time else f"--eyes {options.eyes}"
    print(json.dumps(terrain.record("visibility", how, [k.isa for k in cw.kernels() if k.available][-1])))
    if options.time:
        with tempfile.TemporaryDirectory() as folder:
            times(options.time, options.sides, options.rounds, folder)
        return
    for name, z, cell in lands():
        random = np.random.default_rng(5)
        eyes = list(zip(random.integers(0, z.shape[0], options.eyes), random.integers(0, z.shape[1], options.eyes)))
        wanted, counted = truth(z, cell, eyes)
        print(json.dumps({"kind": "land", "land": name, "rows": z.shape[0], "columns": z.shape[1], "cell": cell, "eyes": len(eyes),
                          "mean": wanted.mean()}))
        print(json.dumps(line(name, "samples counted", 0, counted, wanted, 0)))
        for interpolated in (False, True):
            got = by_samples(z, cell, eyes, 360, interpolated)
            print(json.dumps(line(name, "interpolated heights" if interpolated else "nearest samples", 360, got, wanted, 0)))
        ground = field(z, cell)
        for directions in (16, 32, 64, 128, 256, 512):
            before = time.process_time()
            all_of_it = ground.visibility(directions, observer_height=EYE, curvature=0)
            seconds = time.process_time() - before
            got = np.array([all_of_it[j, i] for j, i in eyes], float)
            print(json.dumps(line(name, "exact", directions, got, wanted, seconds)), flush=True)


if __name__ == "__main__":
    main()
