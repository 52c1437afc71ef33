# SPDX-License-Identifier: Apache-2.0
"""Long runs that are told to stop, or are killed: they end soon, and nothing is left under an output's name."""
import os
import signal
import subprocess
import types

import numpy as np
import pytest
from program import PROGRAM, SCENE, end, entries, interrupted, needs, open_files, rays, read, rough, start, write
from words import wait_until

TRACE = "trace", "large.npy", "many.npy", "--kernel", "brute", "--threads", 2, "-o", "o.npy"
SKY, SCENES = ("horizon", "rough.npy", "--directions", 30), ("render", "scene.pbrt", "--samples", 65536)
# On so little land that bands do not fill the disk, as 30 directions do not.
SEEN = "viewshed", "small.npy", "--cellsize", 10, "--observers", "t.csv", "--every", 0.005, "-o", "o.npy"


@pytest.fixture(autouse=True)
def inputs(folder):
    np.save("large.npy", np.zeros((1000, 1000), np.float32))
    np.save("rough.npy", rough(1000))
    np.save("small.npy", rough(50))
    rays("many.npy", np.tile([5.5, 5, 1], (100000, 1)))
    write("scene.pbrt", SCENE)
    write("t.csv", "x,y\n100,100\n400,100\n")
    write("pairs.csv", "x1,y1,x2,y2\n" + "".join(f"0,0,{k % 990},900\n" for k in range(200000)))


@pytest.mark.parametrize("words, needed, input", [
    (TRACE, None, "many.npy"), ((*SKY, "-o", "o.npy"), None, "rough.npy"), ((*SKY, "--svf", "-o", "o.npy"), None, "rough.npy"),
    ((*SKY, "-o", "o.tif"), "GDAL", "rough.npy"), ((*SKY, "--cog", "-o", "o.tif"), "GDAL", "rough.npy"), ((*SEEN, "--bands"), None, "small.npy"),
    (("los", "rough.npy", "--pairs", "pairs.csv", "-o", "o.csv", "--profile", "p.csv"), None, "rough.npy"),
    ((*SCENES, "-o", "o.png"), "libpng", None), ((*SCENES, "-o", "o.exr"), "OpenEXR", None)])
def test_results_do_not_begin_to_exist(words, needed, input):
    """Ctrl-C leaves nothing, and a kill no more than hidden files."""
    if needed:
        needs(needed)
    for number in signal.SIGINT, signal.SIGKILL:
        interrupted(*words, input=input, signals=[number])


def test_before_anything_is_written():
    """A viewshed writes nothing before it is done."""
    for words in ("viewshed", "rough.npy", *["--from", "500,500,100000"] * 99, "-o", "o.npy", "--threads", 1), SEEN:
        interrupted(*words, input=words[1], writes=False)


@pytest.mark.parametrize("signals", [[signal.SIGTERM], [signal.SIGHUP], [signal.SIGQUIT], [signal.SIGINT, signal.SIGTERM]])
def test_signals(signals):
    """A second one is the end."""
    assert "interrupted" in interrupted(*TRACE, signals=signals).err or len(signals) > 1


def test_the_first_process_of_a_container_ends_too():
    """The system keeps a signal from it that it sends to itself."""
    container, before = ("unshare", "--map-root-user", "--pid", "--fork"), entries()
    if subprocess.run([*container, "true"], stderr=subprocess.DEVNULL).returncode != 0:
        pytest.skip("no namespaces")
    outer = subprocess.Popen([*container, PROGRAM, *map(str, TRACE)], stderr=subprocess.PIPE, text=True)
    children = f"/proc/{outer.pid}/task/{outer.pid}/children"
    wait_until(outer, lambda: read(children))
    inner = types.SimpleNamespace(pid=int(read(children)))
    wait_until(outer, lambda: any(".tmp" in name for name in open_files(inner)))
    os.kill(inner.pid, signal.SIGINT)
    assert outer.communicate()[1] == "cellwalk: interrupted\n" and outer.returncode == 128 + signal.SIGINT and entries() == before


def test_while_reading():
    """Here four million numbers of many digits."""
    needs("GDAL")
    write("text.asc", "ncols 2000\nnrows 2000\ncellsize 1\n" + "1.2345678901234567890123456789 " * 4000000)
    process = start("info", "text.asc")
    wait_until(process, lambda: "text.asc" in open_files(process))
    process.terminate()
    assert end(process).status == 128 + signal.SIGTERM
