#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Products of terrain beside gdal_viewshed, r.viewshed and r.horizon: time, memory, and which cells differ and who is right,
by looking at every edge on the way in double; and the errors of azimuth and distance on maps in degrees. Writes
papers/data/terrain.json. Needs Debian's python3-rasterio,
python3-pyproj, gdal-bin and time and, for r.viewshed and r.horizon, grass-core."""

import argparse
import datetime
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CELL, WEST, NORTH = 10, 600000, 5200000
K = 6 / 7            # of the earth's curvature, with refraction
RADIUS = 6378137.0   # of the ellipsoid at the equator


def land(n, seed=7):
    """Fractal land with a lake: a sum of waves whose height falls with the 1.9th power of their number."""
    rng, m = np.random.default_rng(seed), n - 1
    k = np.hypot(np.fft.fftfreq(m)[:, None] * m, np.fft.rfftfreq(m)[None, :] * m)
    k[0, 0] = np.inf
    z = np.fft.irfft2(k ** -1.9 * (rng.normal(size=k.shape) + 1j * rng.normal(size=k.shape)), (m, m))
    z = (z - z.min()) / np.ptp(z) * 1500 * m / 1024
    z = np.pad(z, ((0, 1), (0, 1)), mode="wrap")
    return np.maximum(z, np.quantile(z, 0.2)).astype("<f4")


def write_dem(z, path, crs=None, box=None):
    """A map whose metre is one on the ground, as the truth has it, about the middle of the land; or another."""
    import rasterio.transform  # not for those who take land() or record() from here
    n = len(z)
    crs = crs or f"+proj=tmerc +lat_0=47 +lon_0=9 +x_0={WEST + CELL * n / 2} +y_0={NORTH - CELL * n / 2} +ellps=WGS84"
    place = rasterio.transform.from_bounds(*(box or [WEST, NORTH - CELL * n, WEST + CELL * n, NORTH]), n, n)
    with rasterio.open(path + ".tif", "w", driver="GTiff", width=n, height=n, count=1, dtype="float32", crs=crs, transform=place,
                       tiled=True) as file:
        file.write(z, 1)


def read(path):
    import rasterio
    with rasterio.open(path) as file:
        return file.read(1).astype("<f4")


def steepest(z, eye, target, k=K):
    """The steepest rise from eye (i, j, height) on the way to target (i, j), ends left out: metres per share of the way."""
    n, d = len(z), np.array(target, float) - np.array(eye[:2], float)
    shares, heights = [], []
    for form, edge in (((1, 0), (0, 1)), ((0, 1), (1, 0)), ((1, -1), (1, 1))):
        start, rate = np.dot(form, eye[:2]), np.dot(form, d)
        if abs(rate) < 1e-12:
            continue
        lines = np.arange(np.ceil(min(start, start + rate)), np.floor(max(start, start + rate)) + 1)
        s = (lines - start) / rate
        s = s[(s > 1e-9) & (s < 1 - 1e-9)]
        at = eye[:2] + s[:, None] * d
        along = at @ edge if edge != (1, 1) else at[:, 0]
        f = along - np.floor(along + 1e-9)
        f[f < 1e-9] = 0
        a = np.rint(at - f[:, None] * edge).astype(int)
        b = np.where(f[:, None] > 0, a + edge, a)
        inside = np.all((a >= 0) & (b < n), axis=1)
        a, b, f, s = a[inside], b[inside], f[inside], s[inside]

        def over(p):
            return z[p[:, 1], p[:, 0]].astype(float) - eye[2] - fall(p, eye, k)

        shares.append(s)
        heights.append(over(a) * (1 - f) + over(b) * f)
    s, h = np.concatenate(shares), np.concatenate(heights)
    return (h / s).max() if len(s) else -np.inf


def fall(p, eye, k=K):
    return k * CELL ** 2 * ((p[..., 0] - eye[0]) ** 2 + (p[..., 1] - eye[1]) ** 2) / (2 * RADIUS)


def hidden_by(z, eye, cells):
    """By how much the ground would have to rise to be seen, or by minus how much it may sink: metres."""
    return np.array([steepest(z, eye, c) - (z[c[1], c[0]] - eye[2] - fall(np.array(c), eye)) for c in cells])


def cost(report):
    """Seconds, those of the CPU, and kilobytes, of GNU time's report."""
    with open(report, encoding="ascii") as file:
        wall, user, system, kilobytes = map(float, file.read().split())
    return np.array([wall, user + system, kilobytes])


def timed(about, side, costs):
    """The line of a program: the least of several times, and the most memory."""
    program, product, part, whole = about
    (wall, cpu, _), kilobytes = np.min(costs, 0), np.max(costs, 0)[2]
    return {"kind": "time", "program": program, "product": f"{product}, {side}²", "part": part, "whole": whole,
            "wall_seconds": wall, "cpu_seconds": cpu, "kilobytes": kilobytes}


TIME = ("/usr/bin/time", "-f", "%e %U %S %M", "-o")


def run_all(runs, side, rounds, folder):
    """runs: (program, product, directions in the run, directions meant, arguments); interleaved."""
    report, costs = os.path.join(folder, "report"), [[] for _ in runs]
    for _ in range(rounds):
        for (*_, arguments), of in zip(runs, costs, strict=True):
            subprocess.run([*TIME, report, *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            of.append(cost(report))
    return [timed(about, side, of) for (*about, _), of in zip(runs, costs, strict=True)]


def grass(script, folder):
    path = os.path.join(folder, "grass.sh")
    with open(path, "w", encoding="ascii") as file:
        file.write("set -e\n" + script)
    subprocess.run(["grass", "--tmp-location", "EPSG:32632", "--exec", "bash", path], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def grass_timed(about, side, dem, command, output, folder):
    """The time of one GRASS module, with its raster already imported; output: map and file."""
    report = os.path.join(folder, "report")
    grass(f"r.in.gdal -o --q input={dem} output=dem\ng.region raster=dem\n{' '.join(TIME[:2])} '{TIME[2]}' -o {report} {command}\n"
          f"r.out.gdal --q -c input={output[0]} output={output[1]} format=GTiff --o\n", folder)
    return timed(about, side, [cost(report)])


def compare_views(z, eye, ours, theirs, program, rng):
    """Cells that differ, and a part of them judged by the truth."""
    lines = []
    for what, mask in (("they see, we do not", (theirs > 0) & (ours == 0)), ("we see, they do not", (theirs == 0) & (ours > 0))):
        cells = np.argwhere(mask)[:, ::-1]
        some = cells[rng.permutation(len(cells))[:2000]]
        needed = hidden_by(z, eye, [tuple(c) for c in some])
        right = np.sum(needed >= 0) if what.startswith("they") else np.sum(needed < 0)
        lines.append({"kind": "view", "program": program, "side": len(z), "class": what, "cells": len(cells),
                      "seen": int(np.sum(ours > 0)), "looked_at": len(some), "we_are_right": int(right),
                      "median_metres": float(np.median(np.abs(needed))) if len(some) else 0.0})
    return lines


def exact_angle(z, i, j, azimuth):
    d = np.array([np.sin(np.radians(azimuth)), -np.cos(np.radians(azimuth))])
    far = min(((len(z) - 1 if v > 0 else 0) - p) / v for p, v in zip((i, j), d) if abs(v) > 1e-12) + 1
    if far <= 1:
        return -90.0
    rise = steepest(z, (i, j, float(z[j, i])), (i + far * d[0], j + far * d[1]), 0)
    return np.degrees(np.arctan(rise / (far * CELL)))


def compare_horizons(z, ours, theirs, azimuth, rng):
    cells = np.argwhere(ours > 0)[:, ::-1]   # r.horizon has nothing below the level
    some = cells[rng.permutation(len(cells))[:2000]]
    truth = np.array([exact_angle(z, i, j, azimuth) for i, j in some])
    out = []
    for program, angles in (("cellwalk horizon", ours), ("r.horizon", theirs)):
        error = np.abs(angles[some[:, 1], some[:, 0]] - truth)
        out.append({"kind": "horizon", "program": program, "side": len(z), "azimuth": azimuth, "looked_at": len(some),
                    "median_degrees": float(np.median(error)), "most_of_99": float(np.quantile(error, 0.99)),
                    "most": float(error.max())})
    return out


def compare_maps(tool, folder):
    """A wall around a place, so many kilometres away on all four sides: where `horizon --at` finds it, beside geodesics."""
    import pyproj
    n, longitude, lines, earth = 101, 10, [], pyproj.Geod(ellps="WGS84")
    z = np.zeros((n, n), "<f4")
    z[[0, -1]] = z[:, [0, -1]] = 3000
    dem = os.path.join(folder, "wall")
    for latitude in (0, 30, 50, 70, 80):
        for km in (1, 5, 20, 50):
            dy = km / 50 / 111.2
            dx = dy / np.cos(np.radians(latitude))
            box = [longitude - dx * n / 2, latitude - dy * n / 2, longitude + dx * n / 2, latitude + dy * n / 2]
            write_dem(z, dem, "EPSG:4326", box)
            rows = subprocess.run([tool, "horizon", dem + ".tif", "--at", f"{longitude},{latitude}", "--directions", "72"],
                                  check=True, capture_output=True, text=True).stdout.splitlines()[1:]
            turned, longer, farthest = [], [], 0
            for _, azimuth, _, _, metres, x, y in (map(float, row.split(",")) for row in rows):
                direction, _, exact = earth.inv(longitude, latitude, x, y)
                turned.append(abs((direction - azimuth + 180) % 360 - 180))
                longer.append(abs(metres / exact - 1))
                farthest = max(farthest, exact)
            lines.append({"kind": "map", "latitude": latitude, "kilometres": km, "directions": len(rows),
                          "farthest": farthest, "azimuth_degrees": max(turned), "distance_share": max(longer)})
    return lines


def compare_needed(z, side, out):
    """Against every edge on the way to some samples. What is seen needs nothing."""
    eye = (side // 2, side // 2, float(z[side // 2, side // 2]) + 2)
    cells = [tuple(c) for c in np.random.default_rng(3).integers(0, side, (20000, 2)) if tuple(c) != eye[:2]]
    truth, lines = np.maximum(hidden_by(z, eye, cells), 0), []
    for program, name in (("cellwalk viewshed --needed", "needed"), ("gdal_viewshed -om DEM", "gdalneeded")):
        values = read(out(name))[tuple(np.array(cells).T[::-1])].astype(float)
        if name == "gdalneeded":  # heights above sea level, of the ground where it is seen
            values = np.maximum(values - z[tuple(np.array(cells).T[::-1])], 0)
        apart = np.abs(values - truth)
        lines.append({"kind": "needed", "program": program, "side": side, "looked_at": len(cells), "median": float(np.median(apart)),
                      "most_of_99": float(np.quantile(apart, 0.99)), "most": float(apart.max())})
    return lines


def measure(tool, side, rounds, folder):
    z = land(side)
    dem = os.path.join(folder, f"land{side}")
    write_dem(z, dem)
    x, y = WEST + CELL * (side // 2 + 0.5), NORTH - CELL * (side // 2 + 0.5)
    out = lambda name: os.path.join(folder, f"{name}{side}.tif")  # noqa: E731
    ours, whole = "cellwalk", "horizon, 32 directions"
    runs = [(ours, "shadow", 1, 1, [tool, "shadow", dem + ".tif", "--sun", "225,20", "--threads", "1", "-o", out("shadow")])]
    for height, of in ((2, ""), *(((100, "100"), (5000, "5000")) if side > 1025 else ())):
        view = [tool, "viewshed", dem + ".tif", "--from", f"{x},{y},{height}", "--threads", "1", "-o"]
        gdal = ["gdal_viewshed", "-q", "-ox", str(x), "-oy", str(y), "-oz", str(height), "-md", "0", "-cc", str(K), dem + ".tif"]
        runs += [(ours, f"viewshed, {height} m", 1, 1, [*view, out("view" + of)]),
                 ("GDAL", f"viewshed, {height} m", 1, 1, [*gdal, out("gdal" + of)]),
                 (ours, f"viewshed --needed, {height} m", 1, 1, [*view, out("needed" + of), "--needed"]),
                 ("GDAL", f"viewshed --needed, {height} m", 1, 1, [*gdal, "-om", "DEM", out("gdalneeded" + of)])]
    if side <= 1025:
        runs.append((ours, whole, 32, 32, [tool, "horizon", dem + ".tif", "--threads", "1", "-o", out("horizon")]))
    lines, rng = run_all(runs, side, rounds, folder), np.random.default_rng(1)
    eye = (side // 2, side // 2, float(z[side // 2, side // 2]) + 2)
    seen = read(out("view"))
    lines += compare_views(z, eye, seen, read(out("gdal")), "gdal_viewshed", rng)
    lines += compare_needed(z, side, out)
    if side <= 1025 and shutil.which("grass"):
        lines.append(grass_timed(("GRASS", "viewshed, 2 m", 1, 1), side, dem + ".tif",
                                 f"r.viewshed --q -b -c -r input=dem output=v coordinates={x},{y} observer_elevation=2 memory=2000",
                                 ("v", out("grass")), folder))
        lines += compare_views(z, eye, seen, read(out("grass")), "r.viewshed", rng)
        lines.append(grass_timed(("GRASS", whole, 2, 32), side, dem + ".tif",
                                 "r.horizon --q -d elevation=dem step=180 start=30 output=h", ("h_030", out("grassh")), folder))
        subprocess.run([tool, "horizon", dem + ".tif", "--directions", "1", "--start", "60", "-o", out("one")], check=True)
        lines += compare_horizons(z, read(out("one")), read(out("grassh")), 60, rng)
    return lines


def said(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def record(command, arguments, isa, **more):
    """The first line of a file of results: what they depend on."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        of = dict(re.findall(r"^(.+?)\s*: (.*)$", file.read(), re.M))
    return {"kind": "run", "command": command, "arguments": arguments, "isa": isa,
            "cpu": f"{of['model name']} (family {of['cpu family']}, model {of['model']})",
            "commit": said("git", "-C", ROOT, "rev-parse", "--short=10", "HEAD"), **more, "load": round(os.getloadavg()[0], 2),
            "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tool", help="the program cellwalk")
    parser.add_argument("--sides", default="1025,4097", help="samples a side (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=7, help="times each run is repeated; the least counts")
    options = parser.parse_args()
    if missing := [program for program in ("gdalinfo", "gdal_viewshed", TIME[0]) if not shutil.which(program)]:
        sys.exit(f"terrain.py: {', '.join(missing)}: not found; Debian's packages gdal-bin and time have these programs")
    tool = os.path.abspath(options.tool)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as folder:
        lines = []
        run = record("terrain", f"--sides {options.sides} --rounds {options.rounds}", json.loads(said(tool, "info", "--json"))["isa"],
                     gdal=said("gdalinfo", "--version").split(",")[0], grass="GRASS " + said("grass", "--config", "version") if shutil.which("grass") else "none")
        for side in map(int, options.sides.split(",")):
            lines += measure(tool, side, options.rounds, folder)
        lines += compare_maps(tool, folder)
    with open(os.path.join(ROOT, "papers/data/terrain.json"), "w", encoding="utf-8") as file:
        for line in [run, *lines]:
            file.write(json.dumps(line, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    sys.exit(main())
