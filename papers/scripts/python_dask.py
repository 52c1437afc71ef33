# SPDX-License-Identifier: Apache-2.0
"""Products of a large raster by chunks, on one or more worker processes: prints JSON lines with seconds, bytes read and the
greatest memory of a worker.

    python3 python_dask.py --raster dem.tif --workers 2 [--side 8193] [--tool build/release/src/tool/cellwalk]

The raster is made first if there is none. With --tool, results are compared with the program's, which uses no chunks.
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile
import time

import numpy as np
import rasterio
from distributed import Client, LocalCluster
from rasterio.windows import Window

import cellwalk as cw
import cellwalk.dask as cwd
from terrain import record

PRODUCTS = {
    "shadow": ({"azimuth": 250, "altitude": 12}, ["shadow", "--sun", "250,12"]),
    "sky_view": ({"directions": 4, "max_distance": 2000}, ["horizon", "--svf", "--directions", "4", "--max-distance", "2000"]),
}


def make_raster(path, side):
    """Hills in eight octaves, cells of 10 m, written band by band."""
    profile = {"driver": "GTiff", "width": side, "height": side, "count": 1, "dtype": "float32", "crs": "EPSG:32632", "tiled": True,
               "blockxsize": 256, "blockysize": 256, "transform": rasterio.Affine(10, 0, 400000, 0, -10, 5300000)}
    octaves = [(600 * 1.9 ** -k, 2 ** k / 700.0, k) for k in range(8)]
    x = np.arange(side)
    with rasterio.open(path, "w", **profile) as file:
        for row in range(0, side, 256):
            y = np.arange(row, min(row + 256, side))[:, None]
            z = np.full((len(y), side), 1500, np.float32)
            for height, wave, k in octaves:
                z += (height * np.sin(y * wave + k)).astype(np.float32) * np.cos(x * wave * 1.07 - k).astype(np.float32)
            file.write(z, 1, window=Window(0, row, side, len(y)))


def usage():
    """Most memory and bytes read so far, of this process. Its ru_maxrss would be the parent's."""
    with open("/proc/self/io") as file:
        read = int(file.readline().split()[1])
    with open("/proc/self/status") as file:
        most = next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
    return most * 1024, read


def run(product, source, out, workers):
    """Each product gets new workers, so that their memory is that of one product."""
    with LocalCluster(n_workers=workers, processes=True, threads_per_worker=1, dashboard_address=None, local_directory=out.parent) as cluster:
        with Client(cluster) as client:
            before = client.run(usage)
            start = time.perf_counter()
            result = getattr(cwd, product)(source, **PRODUCTS[product][0])
            begun = time.perf_counter()
            cwd.to_geotiff(result, out, source)
            end = time.perf_counter()
            after = client.run(usage)
    return {"workers": workers, "seconds": end - start, "first_pass_seconds": begun - start, "chunks": int(np.prod(result.data.numblocks)),
            "bytes_read": sum(after[w][1] - before[w][1] for w in after),
            "worker_bytes_idle": max(v[0] for v in before.values()), "worker_bytes_most": max(v[0] for v in after.values())}


def differing(product, source, out, tool):
    """Samples that differ from the program's."""
    wanted = out.with_name(f"whole-{product}.tif")
    subprocess.run([tool, PRODUCTS[product][1][0], source, *PRODUCTS[product][1][1:], "-o", wanted], check=True, stdout=subprocess.DEVNULL)
    with rasterio.open(out) as a, rasterio.open(wanted) as b:
        return sum(int((a.read(1, window=w).view(np.uint8) != b.read(1, window=w).view(np.uint8)).sum()) for _, w in a.block_windows(1))


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--raster", required=True)
    options.add_argument("--side", type=int, default=8193)
    options.add_argument("--workers", type=int, nargs="*", default=[1, 2])
    options.add_argument("--tool")
    o = options.parse_args()
    if not os.path.exists(o.raster):
        make_raster(o.raster, o.side)
    with rasterio.open(o.raster) as file:
        shape = file.shape
    isa = [k.isa for k in cw.kernels() if k.available][-1]
    print(json.dumps(record("python_dask", f"--raster RASTER --side {o.side} --workers {' '.join(map(str, o.workers))}", isa, cellwalk=cw.__version__, shape=list(shape), raster_bytes=4 * shape[0] * shape[1])))
    with tempfile.TemporaryDirectory(dir=pathlib.Path(o.raster).parent) as folder:
        for product in PRODUCTS:
            out = pathlib.Path(folder) / f"{product}.tif"
            for workers in o.workers:
                print(json.dumps({"kind": "chunks", "product": product, "arguments": PRODUCTS[product][0], **run(product, o.raster, out, workers)}))
            if o.tool:
                print(json.dumps({"kind": "compared", "product": product, "bytes_that_differ": differing(product, o.raster, out, o.tool)}))


if __name__ == "__main__":
    main()
