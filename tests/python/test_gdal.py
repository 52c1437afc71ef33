# SPDX-License-Identifier: Apache-2.0
"""GDAL in a process that is not the program's own: names are files, and GDAL's settings are left to others."""
import subprocess
import sys

ADDRESS = "MEM:::DATAPOINTER=1,PIXELS=4,LINES=4,DATATYPE=Float32"
REMOTE = "/vsicurl/http://127.0.0.1:1/a.tif"
TEXT, NET = (f'<VRTDataset rasterXSize="4" rasterYSize="4"><VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename>{name}'
             "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>" for name in (ADDRESS, REMOTE))


def python(code, folder):
    """A crash of it is not the end of the tests."""
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


NAMES = [ADDRESS, ADDRESS.lower(), "DERIVED_SUBDATASET:AMPLITUDE:" + ADDRESS, "vrt://" + ADDRESS, TEXT, " " + TEXT, "/dev/zero", "pipe",
         REMOTE, REMOTE[9:], "net.vrt", "/vsis3/a/b.tif"]


def test_names_are_files(tmp_path):
    """And messages name no options of the program."""
    (tmp_path / "net.vrt").write_text(NET)
    said = python(f"""
import cellwalk, os
os.mkfifo("pipe")
for name in {NAMES!r}:
    print("opening", name, flush=True)
    try:
        cellwalk.open(name).z
    except OSError as error:
        assert "cannot read" in str(error) and "--" not in str(error), error
        print("refused")
""", tmp_path)
    assert said.count("refused\n") == len(NAMES)


def test_settings_are_left(tmp_path):
    said = python("""
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
assert cellwalk.open("a.tif").z.shape == (3, 3)
assert state() == before
with MemoryFile() as memory, memory.open(driver="GTiff", width=3, height=3, count=1, dtype="float32") as file:
    file.write(np.ones((1, 3, 3), np.float32))
socket.socket().close()
print("left")
""", tmp_path)
    assert said == "left\n"
