# SPDX-License-Identifier: Apache-2.0
"""The table of the six scenes, and the same beside that of the coursework which they come from."""

from markdown import ratio, table
from results import run_text

# What the coursework reports: pbrt-v2 on a 2.7 GHz Core i7, 8 threads, seconds. Triangle mesh, 3D grid, and with Phong
# normals 3D grid and cell walk.
COURSEWORK = {
    "hftest": (3.2, 4.3, 4.4, 3.1), "landsea-0": (18.3, 36.6, 37.1, 63.0), "landsea-1": (10.3, 18.2, 18.5, 21.3),
    "landsea-2": (8.7, 15.0, 16.2, 24.3), "texture": (6.0, 12.9, 13.2, 15.6), "landsea-big": (21.7, 115.8, 117.8, 356.3),
}


def seconds(value):
    return f"{value:.1f}" if value >= 9.995 else f"{value:.2f}" if value >= 0.9995 else f"{value:.3f}"


def _rows(results, cell):
    return [[line.text("scene"), *(cell(path) for path in line.lines("paths"))] for line in results.of("scene")]


def brief(results):
    """The times, and the speed of tracing alone."""
    paths = results.of("scene")[0].lines("paths")
    head = ["scene", *(path.text("title") for path in paths)]

    def time(path):
        to_default = path.number("time_to_default", 0.0)
        both = to_default and not path.text("path").startswith("default")
        return seconds(path.number("seconds_median")) + (f" ({to_default:.2f})" if both else "")

    text = f"{run_text(results.run)}.\n\nSeconds to render, median, CPU time of one thread; building is not in it."
    if results.run.text("embree", ""):
        text += (" In brackets the time over that of Default (Embree's triangle mesh) with the same normals: below 1 is "
                 "faster than Embree.")
    chosen = [path.text("by") for path in paths if path.text("path").startswith("auto")]
    if chosen:
        text += f" *cellwalk* is what the library chooses by itself, on the first scene {chosen[0]}."
    return (text + "\n\n" + table(head, _rows(results, time)) +
            "\nTracing alone, millions of rays a second (a ray counts once for each field that it is asked of):\n\n" +
            table(head, _rows(results, lambda path: f"{path.number('trace_mrays_per_s'):.3g}")))


def coursework(data):
    results = data["scenes/table.json"]
    rows = []
    for line in results.of("scene"):
        mesh, _, grid, cell = COURSEWORK.get(line.text("scene"), (0, 0, 0, 0))
        of = {path.text("path"): path.number("time_to_default", 0.0) for path in line.lines("paths")}
        rows.append([line.text("scene"), ratio(grid, mesh), ratio(cell, mesh),
                     *(ratio(of.get(path), 1) for path in ("grid3d-phong", "cell-phong", "auto-phong"))])
    return ("Time to render with Phong normals over that of a triangle mesh: in the coursework pbrt-v2's, here "
            "Embree's.\n\n" + table(["scene", "coursework: 3D grid", "coursework: cell walk", "`grid3d`", "`cell`",
                                     "what the library chooses"], rows))
