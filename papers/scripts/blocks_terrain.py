# SPDX-License-Identifier: Apache-2.0
"""Products of terrain beside other programs: time and memory, cells that differ, angles that are off."""

from markdown import grouped, table, three
from results import Problem

FILE = "terrain.json"
MORE = "terrain-more.json"
PRODUCTS = ("viewshed", "shadow", "horizon, 32 directions")


def run_text(run):
    return (f"{run.text('cpu')}, {run.text('isa')}, {run.text('gdal')}, {run.text('grass')}, commit {run.text('commit')}, "
            f"load {run.number('load'):.2f}, {run.text('date')}")


def terrain_speed(results):
    """What is a part of the whole counts as often as it goes into it."""
    rows = []
    for product in PRODUCTS:
        for line in results.of("time", product=product):
            side, part, whole = (line.number(key) for key in ("side", "part", "whole"))
            times = whole / part
            program = line.text("program") + (f" ({part} of {whole} measured)" if times > 1 else "")
            rows.append([product, f"{side}²", program, f"{line.number('wall_seconds') * times:.2f}",
                         f"{line.number('cpu_seconds') * times:.2f}",
                         three(side * side * whole / (line.number("cpu_seconds") * times) / 1e6),
                         f"{line.number('kilobytes') / 1024:.0f}"])
    if not rows:
        raise Problem(f"{results.path}: has no line of kind \"time\"")
    return (run_text(results.run) + ".\n\n" +
            table(["product", "samples", "program", "seconds", "CPU seconds", "million angles or cells a CPU second", "MB"], rows,
                  "lllrrrr"))


def terrain_more(results):
    rows = [[line.text("product"), f"{line.number('side')}²", line.text("program"), f"{line.number('wall_seconds'):.2f}",
             f"{line.number('cpu_seconds'):.2f}", f"{line.number('kilobytes') / 1024:.0f}"]
            for line in sorted(results.some("time"), key=lambda line: (line.text("product"), line.number("side")))]
    return (run_text(results.run) + ".\n\n" +
            table(["product", "samples", "program", "seconds", "CPU seconds", "MB"], rows, "lllrrr"))


def terrain_needed(results):
    rows = [[line.text("program"), f"{line.number('side')}²", grouped(line.number("looked_at")),
             *(f"{line.number(key):.2g} m" for key in ("median", "most_of_99", "most"))] for line in results.some("needed")]
    return table(["program", "samples", "looked at", "median error", "of 99 %", "greatest"], rows, "llrrrr")


def terrain_days(results):
    rows = [[line.text("what"), f"{line.number('side')}²", *(f"{line.number(key):.4g}" for key in ("ours", "theirs")),
             *(f"{line.number(key):.2g}" for key in ("median", "most_of_99"))] for line in results.some("day")]
    return table(["a day's", "samples", "mean of `cellwalk sun`", "mean of r.sun", "median difference", "of 99 %"], rows, "llrrrr")


def terrain_areas(results):
    lands = [line.text("land") for line in results.some("land")]
    ways = {}
    for line in results.some("area"):
        ways.setdefault((line.text("way"), line.number("directions")), {})[line.text("land")] = line
    rows = [[way, str(directions or ""), *(cell for land in lands for cell in area_cells(of[land]))]
            for (way, directions), of in ways.items()]
    heads = [f"{land}: {what}" for land in lands for what in ("bias", "RMS", "99 %", "CPU seconds")]
    run = results.run
    return (f"{run.text('cpu')}, {run.text('isa')}, commit {run.text('commit')}, load {run.number('load'):.2f}, {run.text('date')}.\n\n" +
            table(["way", "directions", *heads], rows, "l" + "r" * (1 + len(heads))))


def area_cells(line):
    seconds = line.number("cpu_seconds")
    return [f"{100 * line.number('bias'):+.1f} %", *(f"{100 * line.number(key):.{2 if line.number(key) < 1 else 3}g} %" for key in ("rms", "most_of_99")),
            f"{seconds:.2f}" if seconds else ""]


def terrain_views(results):
    rows = [[line.text("program"), f"{line.number('side')}²", line.text("class"), grouped(line.number("cells")),
             f"{100 * line.number('cells') / line.number('seen'):.2g} %", grouped(line.number("looked_at")),
             grouped(line.number("we_are_right")), f"{line.number('median_metres'):.2g} m"]
            for line in results.some("view")]
    return table(["program", "samples", "class", "cells", "of those seen", "looked at", "Cellwalk is right",
                  "by (median)"], rows, "lllrrrrr")


def terrain_suns(results):
    rows = [[line.text("program"), f"{line.number('side')}²", line.text("class"), grouped(line.number("cells")),
             f"{100 * line.number('cells') / line.number('sunlit'):.2g} %", grouped(line.number("lean_away")),
             grouped(line.number("looked_at")), grouped(line.number("we_are_right")), f"{line.number('median_degrees'):.2g}°"]
            for line in results.some("sun")]
    return table(["program", "samples", "class", "cells", "of those in the sun", "ground leans away", "of the others looked at",
                  "Cellwalk is right", "by (median)"], rows, "lllrrrrrr")


def terrain_horizons(results):
    rows = [[line.text("program"), f"{line.number('side')}²", grouped(line.number("looked_at")),
             f"{line.number('median_degrees'):.2g}°", f"{line.number('most_of_99'):.2g}°", f"{line.number('most'):.2g}°"]
            for line in results.some("horizon")]
    return table(["program", "samples", "angles looked at", "median error", "of 99 %", "greatest"], rows, "llrrrr")


def terrain_maps(results):
    """Greatest errors over all directions, a row for each latitude."""
    lines = results.some("map")
    distances = sorted({line.number("kilometres") for line in lines})
    rows = []
    for latitude in sorted({line.number("latitude") for line in lines}):
        here = {line.number("kilometres"): line for line in lines if line.number("latitude") == latitude}
        rows.append([f"{latitude}°", *(f"{here[km].number('azimuth_degrees'):.2g}°, "
                                       f"{100 * here[km].number('distance_share'):.2g} %" for km in distances)])
    return table(["latitude", *(f"{km} km" for km in distances)], rows, "l" + "r" * len(distances))
