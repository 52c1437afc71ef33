# SPDX-License-Identifier: Apache-2.0
"""GDAL in a process that is not the program's own, and to_geotiff beside other writers: nothing is lost or half written. Names are files, and GDAL's
settings are left to others. ../tool/test_outputs.py has links, rights and sidecars."""
import errno
import itertools
import os
import pathlib
import resource
import subprocess
import sys

import dask
import dask.array as da
import numpy as np
import pytest
import xarray as xr

import cellwalk as cw
import cellwalk.dask as cwd
from conftest import geotiff, raster as content, rough, same

ROWS, COLUMNS = 300, 270
HILLS = rough(ROWS, COLUMNS, holes=False)
VALUES = np.random.default_rng(1).normal(500, 50, (ROWS, COLUMNS)).astype(np.float32)


@pytest.fixture(autouse=True)
def one_by_one(folder):
    with dask.config.set(scheduler="synchronous"):
        yield


def result(z, chunks=256):
    return da.from_array(z, chunks=chunks)


def bytes_of_all():
    """Each entry of the folder: what a link says, what a file holds."""
    return {p.name: os.readlink(p) if p.is_symlink() else p.read_bytes() if p.is_file() else None for p in pathlib.Path(".").iterdir()}


def test_an_input_is_not_replaced():
    geotiff("dem.tif", HILLS)
    os.symlink("dem.tif", "soft.tif")
    os.link("dem.tif", "hard.tif")
    before = bytes_of_all()
    lit = cwd.shadow("dem.tif", chunks=128)
    array = xr.DataArray(da.from_array(VALUES, chunks=128), dims=("y", "x"))
    array.encoding["source"] = os.path.abspath("dem.tif")  # as rioxarray has it
    results = [(lit, None), (lit.where(lit == 1, 0).astype("uint8"), None), (cwd.shadow(array), None), (result(VALUES), "dem.tif")]
    for name in ("./dem.tif", "soft.tif", "hard.tif", os.path.abspath("dem.tif"), pathlib.Path("dem.tif")):
        for output, like in results:
            with pytest.raises(ValueError, match="path: .*is also an input"):
                cwd.to_geotiff(output, name, like=like)
    assert bytes_of_all() == before
    for _ in range(2):  # a result that is an input of another may be made anew
        cwd.to_geotiff(lit, "lit.tif")
        cwd.to_geotiff(cwd.sky_view("lit.tif", 4, 300, chunks=128), "other.tif")


@pytest.mark.parametrize("chunks", [256, 100], ids=["compressed", "uncompressed"])
def test_a_full_disk_is_an_error(chunks):
    """A limit on the size of files stands for it. Nothing else changes, however late it is found out."""
    cwd.to_geotiff(result(VALUES, chunks), "old.tif")
    size, limits, before = os.path.getsize("old.tif"), resource.getrlimit(resource.RLIMIT_FSIZE), bytes_of_all()
    for room, name in itertools.product([0, 8, *(size * k // 8 for k in range(1, 8, 2)), size - 1], ("old.tif", "new.tif")):
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
        try:
            with pytest.raises(OSError, match=rf"{name}: cannot write: {os.strerror(errno.EFBIG)}"):
                cwd.to_geotiff(result(VALUES, chunks), name)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert bytes_of_all() == before


THREADS = """
import numpy as np, dask, rasterio, cellwalk as cw, cellwalk.dask as cwd
z = np.random.default_rng(1).normal(0, 9, (1500, 1400)).astype("float32")
with rasterio.open("dem.tif", "w", driver="GTiff", width=1400, height=1500, count=1, dtype="float32", crs="EPSG:32632", tiled=True,
                   transform=rasterio.Affine(30, 0, 6e5, 0, -30, 5.2e6), blockxsize=256, blockysize=256) as file:
    file.write(z, 1)
wanted = cw.open("dem.tif").shadow()
with dask.config.set(scheduler="threads", num_workers=4):
    for _ in range(4):
        cwd.to_geotiff(cwd.shadow("dem.tif", chunks=512), "a.tif", like="dem.tif")
        with rasterio.open("a.tif") as file:
            assert (file.read(1) == wanted).all()
"""


def test_threads_read_while_one_writes():
    """GDAL's cache is so small that reading a chunk writes tiles of another. With rasterio that hung."""
    subprocess.run([sys.executable, "-c", THREADS], check=True, env={**os.environ, "GDAL_CACHEMAX": "600000"}, timeout=600)


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_failing_chunk_changes_nothing(failure):
    pathlib.Path("a.tif").write_text("old")

    def fail(block, block_info=None):
        if block_info[0]["chunk-location"] == (1, 1):
            raise failure("no")
        return block
    for name in ("a.tif", "b.tif"):
        with pytest.raises(failure):
            cwd.to_geotiff(result(VALUES).map_blocks(fail, dtype=np.float32), name)
    assert os.listdir(".") == ["a.tif"] and pathlib.Path("a.tif").read_text() == "old"


def test_names_are_only_names():
    for name in ("-a.tif", "a\nb.tif", "\x1b[2J.tif", "GTIFF_DIR:1:a.tif", "MEM:::DATAPOINTER=1.tif", "%d%s.tif", "a.TIFF", b"\xff\xfe.tif", "\udcff.tif",
                 "x" * 251 + ".tif"):
        cwd.to_geotiff(result(VALUES), name)
        assert os.listdir(os.fsencode(".")) == [os.fsencode(name)]
        os.rename(os.fsencode(name), "plain.tif")
        same(content("plain.tif"), VALUES)
        os.unlink("plain.tif")
    os.mkdir("folder.tif")
    for name, kind, reason in [*((name, ValueError, "path: .*expected a name that ends in .tif") for name in ("a.npy", "a.png", "a", "a.tif.part", ".tif")),
                               *((name, OSError, os.strerror(reason)) for name, reason in [
                                   ("nowhere/a.tif", errno.ENOENT), ("/vsimem/a.tif", errno.ENOENT), ("x" * 252 + ".tif", errno.ENAMETOOLONG), ("folder.tif", errno.EISDIR)])]:
        with pytest.raises(kind, match=reason):
            cwd.to_geotiff(result(VALUES), name)
    assert os.listdir(".") == ["folder.tif"] and not os.listdir("folder.tif")


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "int16", "float32", ">f4"])
def test_dtypes(dtype):
    z = VALUES.astype(dtype)
    cwd.to_geotiff(result(z, (256, 100)), "a.tif")
    same(content("a.tif"), z.astype(np.dtype(dtype).newbyteorder("=")))


FORK = """
import os, sys, numpy as np, cellwalk as cw
z = np.arange(512 * 512, dtype="float32").reshape(512, 512)
file = cw._raster.GeoTiff("a.tif", 1, 512, 512, "float32", float("nan"), None, None, True)
file.write(0, 0, 0, 256, 512, z[:256])
child = os.fork()
if child == 0:
    try:
        file.commit()
    except ValueError:
        del file
        sys.exit(7)  # with all that Python and C do at an exit
    sys.exit(8)
assert os.waitpid(child, 0)[1] >> 8 == 7
assert not [name for name in os.listdir(".") if not name.startswith(".")]
file.write(0, 256, 0, 256, 512, z[256:])
file.commit()
"""


def test_a_forked_child_has_no_say():
    subprocess.run([sys.executable, "-c", FORK], check=True)
    assert os.listdir(".") == ["a.tif"]
    same(content("a.tif"), np.arange(512 * 512, dtype="float32").reshape(512, 512))


def test_windows_are_checked():
    file = cw._raster.GeoTiff("a.tif", 2, 20, 30, "uint8", 255.0, None, None, True)
    block = np.zeros((5, 7), np.uint8)
    for window in ((-1, 0, 0, 5, 7), (2, 0, 0, 5, 7), (0, 16, 0, 5, 7), (0, 0, 24, 5, 7), (0, -1, 0, 5, 7), (0, 0, 0, 5, 6), (0, 0, 0, 0, 0),
                   (0, 2 ** 62, 0, 5, 7), (0, 0, 0, 2 ** 62, 2 ** 62)):
        with pytest.raises(ValueError, match="block"):
            file.write(*window, block)
    with pytest.raises(OSError, match="a.tif: rows are missing"):
        file.commit()
    with pytest.raises(ValueError, match="closed"):
        file.commit()
    file.discard()
    assert os.listdir(".") == []


# ---- GDAL's own ---------------------------------------------------------------------------------------------------------


def test_names_of_inputs_are_files():
    """And messages name no options of the program; ../tool/test_gdal.py has more names. A crash is not the end of the tests."""
    subprocess.run([sys.executable, "-c", """
import cellwalk, os
os.environ.update(AWS_NO_SIGN_REQUEST="YES", AWS_EC2_METADATA_DISABLED="true", AWS_CONFIG_FILE="none", AWS_SHARED_CREDENTIALS_FILE="none")
os.mkfifo("pipe")
address, remote = "MEM:::DATAPOINTER=1,PIXELS=4,LINES=4,DATATYPE=Float32", "/vsicurl/http://127.0.0.1:1/a.tif"
text, net = ('<VRTDataset rasterXSize="4" rasterYSize="4"><VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename>' + name +
             "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>" for name in (address, remote))
open("net.vrt", "w").write(net)
for name in address, "vrt://" + address, text, "/dev/zero", "pipe", remote, remote[9:], "net.vrt", "/vsis3/a/b.tif":
    try:
        cellwalk.open(name).z
        raise AssertionError(name)
    except OSError as error:
        assert "cannot read" in str(error) and "--" not in str(error), error
"""], check=True)


def test_settings_are_left():
    subprocess.run([sys.executable, "-c", """
import os, socket
import numpy as np, rasterio
from rasterio.env import get_gdal_config
from rasterio.io import MemoryFile
keys = "GDAL_PAM_ENABLED", "GDAL_NUM_THREADS", "GDAL_CACHEMAX", "GDAL_VRT_ENABLE_PYTHON"
def state():
    with rasterio.Env() as env:
        return sorted(env.drivers()), [get_gdal_config(key) for key in keys], dict(os.environ)
before = state()
with rasterio.open("a.tif", "w", driver="GTiff", width=3, height=3, count=1, dtype="float32") as file:
    file.write(np.ones((1, 3, 3), np.float32))
import cellwalk
do_io, told = cellwalk._raster.do_io, []
cellwalk._raster.do_io = lambda *words, work: setattr(work.c, "next", 0) or do_io(*words, work=work)  # progress is told, however fast it is read
assert cellwalk.open("a.tif", progress=lambda share: told.append(state())).z.shape == (3, 3)
assert len(told) == 3 and told + [state()] == 4 * [before]
with MemoryFile() as memory, memory.open(driver="GTiff", width=3, height=3, count=1, dtype="float32") as file:
    file.write(np.ones((1, 3, 3), np.float32))
socket.socket().close()
"""], check=True)
