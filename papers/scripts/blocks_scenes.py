# SPDX-License-Identifier: Apache-2.0
"""The table of the six scenes, and the same beside that of the coursework which they come from."""

from markdown import ratio, table
from results import geometric_mean, run_text

# What the coursework reports: pbrt-v2 on a 2.7 GHz Core i7, 8 threads, seconds. Triangle mesh, 3D grid with Phong normals,
# cell walk with Phong normals.
COURSEWORK = {
    "hftest": (3.2, 4.4, 3.1), "landsea-0": (18.3, 37.1, 63.0), "landsea-1": (10.3, 18.5, 21.3),
    "landsea-2": (8.7, 16.2, 24.3), "texture": (6.0, 13.2, 15.6), "landsea-big": (21.7, 117.8, 356.3),
}
# Whose pictures stand beside it: paths of cellwalk-bench table.
BESIDE = {"grid3d-phong": "`grid3d`", "cell-phong": "`cell`", "auto-phong": "Cellwalk's choice"}


def seconds(value):
    return f"{value:.1f}" if value >= 9.995 else f"{value:.2f}" if value >= 0.9995 else f"{value:.3f}"


def _rows(results, cell):
    return [[line.text("scene"), *(cell(path) for path in line.lines("paths"))] for line in results.of("scene")]


def times(results):
    """A row a scene, a column a path."""
    paths = results.some("scene")[0].lines("paths")
    head = ["scene", *(path.text("title") for path in paths)]

    def time(path):
        to_default = path.number("time_to_default", 0.0)
        both = to_default and not path.text("path").startswith("default")
        return seconds(path.number("seconds_median")) + (f" ({to_default:.2f})" if both else "")

    text = f"{run_text(results.run)}.\n\nSeconds to render: median CPU time of one thread, building excluded."
    if results.run.text("embree", ""):
        text += (" In brackets: time relative to *Default*, Embree's triangle mesh with the same normals. Below 1 is faster than "
                 "Embree.")
    chosen = [path.text("by") for path in paths if path.text("path").startswith("auto")]
    if chosen:
        text += f" *cellwalk* is the default kernel, in the first scene `{chosen[0].split('/')[0]}`."
    rows = _rows(results, time)
    facts = results.of("pbrt")
    if facts:
        by = facts[0]
        text += (" *pbrt-v2*: how many times as long as cellwalk its whole process takes, with flat triangles. That was another "
                 f"run: {by.text('cpu')}, {by.text('isa')}, commit {by.text('commit')}, {by.text('date')}. It had pbrt-v2 of "
                 f"{by.text('pbrt')}.")
        rows = [[row[0], f"{line.number('pbrt_ratio'):.1f} x" if line.get("pbrt_ratio") else "", *row[1:]]
                for row, line in zip(rows, results.of("scene"))]
    return text + "\n\n" + table([head[0], "pbrt-v2", *head[1:]] if facts else head, rows)


def coursework(data):
    rows = []
    for line in data["scenes/table.json"].of("scene"):
        mesh, grid, cell = COURSEWORK.get(line.text("scene"), (0, 0, 0))
        of = {path.text("path"): path.number("time_to_default", 0.0) for path in line.lines("paths")}
        rows.append([line.text("scene"), ratio(grid, mesh), ratio(cell, mesh), *(ratio(of.get(path), 1) for path in BESIDE)])
    return table(["scene", "coursework: 3D grid", "coursework: cell walk", *BESIDE.values()], rows)


def pbrt_ratios(data):
    return [line.number("pbrt_seconds") / line.number("cellwalk_seconds") for line in data["scenes/pbrt.json"].some("scene")]


def beside_pbrt(data):
    """One line for the summary."""
    ratios = pbrt_ratios(data)
    return (f"- **Scenes**: {geometric_mean(ratios):.1f} times the speed of pbrt-v2, geometric mean over {len(ratios)} scenes, "
            f"from {min(ratios):.1f} to {max(ratios):.1f}; whole processes on one thread.\n")


def pbrt(data):
    """Whole processes of pbrt-v2 and cellwalk."""
    results, ratios = data["scenes/pbrt.json"], pbrt_ratios(data)
    run, rows = results.run, []
    for line, faster in zip(results.some("scene"), ratios):
        rows.append([line.text("scene"), *(seconds(line.number(f"{program}_seconds")) for program in ("pbrt", "cellwalk")),
                     f"{faster:.1f}",
                     *(seconds(line.number(f"{program}_pixel_seconds")) for program in ("pbrt", "cellwalk")),
                     *(f"{line.number(f'{program}_mib'):.0f}" for program in ("pbrt", "cellwalk"))])
    rounds = min(int(line.number("rounds")) for line in results.some("scene"))
    return (f"{run.text('cpu')}, {run.text('isa')}, commit {run.text('commit')}, load {run.number('load'):.2f}, "
            f"{run.text('date')}. pbrt-v2: {run.text('pbrt')}.\n\nCPU seconds of the whole process on one thread, medians of "
            f"{rounds} interleaved rounds; flat triangles. *1 pixel*: the same for a picture of one pixel, the time of "
            "reading and building.\n\n" +
            table(["scene", "pbrt-v2", "cellwalk", "ratio", "pbrt-v2, 1 pixel", "cellwalk, 1 pixel", "pbrt-v2, MiB",
                   "cellwalk, MiB"], rows) +
            f"\nGeometric mean of the ratios: {geometric_mean(ratios):.1f}.\n")


