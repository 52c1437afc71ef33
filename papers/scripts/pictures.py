#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the papers as SVG, from the results in papers/data. The same results and the same version of matplotlib give
the same bytes: fixed ids, no date, text as text, a fixed layout. Each file names the version that drew it."""

import argparse
import io
import os
import re
import sys

from results import Data, Problem

SKIPPED = 77  # exit status of --check where it cannot be done
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

try:
    import matplotlib
except ImportError:
    matplotlib = None


def load():
    """What draws, by the picture's name; settings that every picture shares."""
    matplotlib.use("svg")
    matplotlib.rcParams.update({
        "svg.hashsalt": "cellwalk", "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9,
        "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial"], "axes.titlesize": 10, "axes.titleweight": "bold",
        "axes.titlelocation": "left", "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.7,
        "axes.edgecolor": "#666666", "axes.labelcolor": "#444444", "xtick.color": "#444444", "ytick.color": "#444444",
        "xtick.minor.size": 0, "ytick.minor.size": 0, "legend.frameon": False, "lines.linewidth": 1.8,
        "lines.markersize": 4, "figure.facecolor": "white", "savefig.facecolor": "white"})
    import charts
    import figure_cell
    return {**charts.CHARTS, "cell": lambda data: figure_cell.draw()}


def svg(name, figure):
    """The picture's text; fails if something in it is cut off or lies on something else."""
    from matplotlib import pyplot
    import layout
    layout.check(name, figure)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    pyplot.close(figure)
    return "".join(line.rstrip() + "\n" for line in text.getvalue().splitlines())


def read(path):
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except OSError as error:
        raise Problem(f"{path}: {error.strerror}") from None


def drawn_by(text):
    """The version of matplotlib that drew a picture."""
    found = re.search(r"Matplotlib v([\w.]+)", text)
    return found[1] if found else "another program"


def check(folder, data):
    there = sorted(name for name in os.listdir(folder) if name.endswith(".svg"))
    versions = {drawn_by(read(os.path.join(folder, name))) for name in there}
    if matplotlib is None or versions - {matplotlib.__version__}:
        have = matplotlib.__version__ if matplotlib else "missing"
        print(f"pictures.py: not checked: the pictures are by matplotlib {', '.join(sorted(versions))}; here it is {have}")
        return SKIPPED
    pictures, stale = load(), []
    for name in sorted({f"{name}.svg" for name in pictures} | set(there)):
        path = os.path.join(folder, name)
        if name not in there or name[:-4] not in pictures:
            stale.append(f"{path}: {'is missing' if name not in there else 'is none that pictures.py draws'}")
            continue
        have, want = (text.splitlines() for text in (read(path), svg(name[:-4], pictures[name[:-4]](data))))
        differ = [k for k in range(max(len(have), len(want))) if have[k:k + 1] != want[k:k + 1]]
        if differ:
            k = differ[0]
            stale.append(f"{path}:{k + 1}: is not what the data give\n  file: {''.join(have[k:k + 1])[:200]}\n"
                         f"  data: {''.join(want[k:k + 1])[:200]}")
    if stale:
        raise Problem("\n".join([*stale, "papers/scripts/pictures.py draws them again"]))
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true",
                        help=f"write nothing; fail if a picture is not what the data give; status {SKIPPED} if matplotlib is "
                        "missing or of another version")
    parser.add_argument("--root", default=ROOT, help="where papers/ is")
    options = parser.parse_args()
    folder, data = os.path.join(options.root, "papers/pictures"), Data(os.path.join(options.root, "papers/data"))
    if options.check:
        return check(folder, data)
    if matplotlib is None:
        raise Problem("needs matplotlib (Debian: python3-matplotlib)")
    drawn = {name: svg(name, draw(data)) for name, draw in load().items()}
    for name, text in drawn.items():
        with open(os.path.join(folder, f"{name}.svg"), "w", encoding="utf-8") as file:
            file.write(text)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Problem, OSError) as problem:
        sys.exit(f"pictures.py: {problem}")
