#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures in papers/pictures that the program makes, of scenes and by README's commands: makes them again, or with --check
compares every pixel. Pixels depend neither on the kernel nor on the number of threads, so the bound is 0: one pixel that
differs is a failure."""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile

from draw import SKIPPED, Problem

try:
    import numpy as np
    from matplotlib import image
except ImportError:
    image = None

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Picture: scene and options of cellwalk render; or the output of the README's command that makes it.
RENDERS = {"landsea-0.png": ("landsea-0.pbrt", ["--phong", "--samples", "16", "--size", "800x400"]), "jacksboro.png": "view.png",
           "jacksboro-seen.png": "seen.png", "jacksboro-shadow.png": "shadow.png", "jacksboro-area.png": "area.png"}
# The terrain of README's commands.
TERRAIN = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"


def command_for(output, root):
    """The words of the README's command that writes that file, without the program and the output."""
    with open(os.path.join(root, "README.md"), encoding="utf-8") as page:
        words = next((line.split("#")[0].split() for line in page if line.startswith("cellwalk ") and f" -o {output}" in line), None)
    if words is None:
        raise Problem(f"README.md: no command writes {output}")
    del words[words.index("-o"):words.index("-o") + 2]
    return words[1:]


def render(tool, scenes, name, output, root):
    folder, made_by = os.path.dirname(output), RENDERS[name]
    if isinstance(made_by, str):
        words = command_for(made_by, root)
        np.save(os.path.join(folder, "dem.npy"), np.load(TERRAIN)["elevation"])
    else:
        words = ["render", os.path.join(scenes, made_by[0]), *made_by[1]]
    done = subprocess.run([os.path.abspath(tool), *words, "-o", output], capture_output=True, text=True,
                          cwd=folder if isinstance(made_by, str) else None)
    if done.returncode != 0:
        raise Problem(f"{tool} {' '.join(words)} failed with status {done.returncode}: {done.stderr.strip()}")


def compare(name, wanted, rendered):
    have, want = (np.rint(255 * image.imread(path)).astype(int) for path in (wanted, rendered))
    if have.shape != want.shape:
        raise Problem(f"{wanted}: has {have.shape[1]} x {have.shape[0]} pixels, rendered are {want.shape[1]} x {want.shape[0]}")
    differ = np.argwhere((have != want).any(axis=2))
    if len(differ):
        y, x = differ[0]
        raise Problem(f"{wanted}: {len(differ)} pixels differ from what is rendered, by at most {np.abs(have - want).max()} of 255; the first "
                      f"is ({x}, {y}). papers/scripts/renders.py renders it again")
    print(f"{name}: all {have.shape[1]} x {have.shape[0]} pixels are equal")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a pixel differs")
    parser.add_argument("--tool", default="build/release/src/tool/cellwalk", help="the program cellwalk")
    parser.add_argument("--scenes", default="build/release/bench/scenes", help="the folder of scenes in the build tree")
    parser.add_argument("--root", default=ROOT, help="where papers/ is")
    options = parser.parse_args()
    if image is None:
        print("renders.py: pictures are left out: they need matplotlib (Debian: python3-matplotlib)")
        return SKIPPED
    for name in RENDERS:
        picture = os.path.join(options.root, "papers/pictures", name)
        with tempfile.TemporaryDirectory() as folder:
            rendered = os.path.join(folder, name)
            render(options.tool, options.scenes, name, rendered, options.root)
            if options.check:
                compare(name, picture, rendered)
            else:
                shutil.copyfile(rendered, picture)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Problem, OSError) as problem:
        sys.exit(f"renders.py: {problem}")
