# SPDX-License-Identifier: Apache-2.0
"""The table of the six scenes, and the same beside that of the coursework which they come from."""

from markdown import ratio, table
from results import run_text

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


def brief(results):
    """The times, and the speed of tracing alone."""
    paths = results.some("scene")[0].lines("paths")
    head = ["scene", *(path.text("title") for path in paths)]

    def time(path):
        to_default = path.number("time_to_default", 0.0)
        both = to_default and not path.text("path").startswith("default")
        return seconds(path.number("seconds_median")) + (f" ({to_default:.2f})" if both else "")

    def rows(cell):
        return [[line.text("scene"), *(cell(path) for path in line.lines("paths"))] for line in results.of("scene")]

    text = f"{run_text(results.run)}.\n\nSeconds to render: median CPU time of one thread, building excluded."
    if results.run.text("embree", ""):
        text += (" In brackets: time relative to Default, Embree's triangle mesh, with the same normals; below 1 is faster "
                 "than Embree.")
    chosen = [path.text("by") for path in paths if path.text("path").startswith("auto")]
    if chosen:
        text += f" *cellwalk* is the kernel that the library chooses, in the first scene `{chosen[0].split('/')[0]}`."
    return (text + "\n\n" + table(head, rows(time)) +
            "\nTracing alone, in millions of rays a second (a ray counts once for each field that it is tested against):\n\n"
            + table(head, rows(lambda path: f"{path.number('trace_mrays_per_s'):.3g}")))


def coursework(data):
    rows = []
    for line in data["scenes/table.json"].of("scene"):
        mesh, grid, cell = COURSEWORK.get(line.text("scene"), (0, 0, 0))
        of = {path.text("path"): path.number("time_to_default", 0.0) for path in line.lines("paths")}
        rows.append([line.text("scene"), ratio(grid, mesh), ratio(cell, mesh), *(ratio(of.get(path), 1) for path in BESIDE)])
    return table(["scene", "coursework: 3D grid", "coursework: cell walk", *BESIDE.values()], rows)
