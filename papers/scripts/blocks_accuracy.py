# SPDX-License-Identifier: Apache-2.0
"""Speed against error: what the results of cellwalk-bench tradeoff come to, and their tables."""

import math
from statistics import median

import names
from blocks_speed import default_kernel
from blocks_work import mean_ratio, work
from markdown import grouped, table, three
from results import Problem, geometric_mean, run_text

FILE, PRECISION_FILE = "tradeoff/tradeoff.json", "precision/tradeoff.json"
AIMED = ("vertices", "edges")  # classes of rays that are made to find leaks; they are not timed
SHORT = {"within-0.1": "0.01 to 0.1 cells away", "within-2": "0.5 to 2 cells away"}  # for the table of precision alone
RATES = ("leaks", "phantoms", "wrong", "broken")
ERRORS = {"t_ulp": "t in ULP", "t_cells": "t in cells", "off_cells": "off the surface, cells",
          "normal_degrees": "normal, degrees"}
# A step along a frontier is worth naming if it gains more speed than two runs of one program may differ by.
STEP = 1.02


class Summary:
    """One mode with one kernel, or a peer, over all groups (fields × classes of rays)."""

    def __init__(self, name, lines, groups, timed):
        ran = [line for line in lines if "left_out_seconds" not in line]
        speeds = [line.number("mrays_per_s") for line in ran if "mrays_per_s" in line]
        self.name, self.mode, self.kernel = name, lines[0].text("mode"), lines[0].text("kernel")
        self.ran, self.partial = bool(ran), len(ran) < groups or len(speeds) < timed
        self.speed = geometric_mean(speeds)
        ordinary = [line for line in ran if line.text("rays") not in AIMED]
        aimed = [line for line in ran if line.text("rays") in AIMED]
        self.rate = {key: _mean([line.number(f"{key}_per_million") for line in (ran if key == "broken" else ordinary)])
                     for key in RATES}
        self.wrong, self.ordinary, self.aimed = (_mean([wrong_answers(line) for line in some])
                                                 for some in (ran, ordinary, aimed))
        self.median, self.worst = {}, {}
        for key in ERRORS:
            # From afar t is too coarse a float to say where a hit is, whoever finds it.
            of = [line for line in ran if f"{key}_worst" in line and line.text("rays") != "afar"]
            self.median[key] = median(line.number(f"{key}_median") for line in of) if of else None
            self.worst[key] = max((line.number(f"{key}_worst") for line in of), default=None)


def label(summary):
    return names.peer("embree/" + summary.kernel) if summary.mode.startswith("embree") else f"`{summary.kernel}`"


def wrong_answers(line):
    return sum(line.number(f"{key}_per_million") for key in RATES[:3])


def two(number):
    """Two significant digits, three from 1000 on."""
    return three(number) if number >= 1000 else f"{number:.2g}"


def _mean(values):
    return math.fsum(values) / len(values) if values else None


def summaries(results):
    lines = [line for line in results.of("result") if line.text("rays") not in SHORT]
    groups = {(line.text("field"), line.text("rays")) for line in lines}
    timed = {(line.text("field"), line.text("rays")) for line in lines if "mrays_per_s" in line}
    by_name = {}
    for line in lines:
        by_name.setdefault(line.text("contender"), []).append(line)
    return [Summary(name, of, len(groups), len(timed)) for name, of in by_name.items()]


# What a frontier is about: its title, and the error.
FRONTIERS = {
    "answers": ("wrong answers per million rays", lambda s: s.wrong),
    "place": ("cells off the surface at worst", lambda s: s.worst["off_cells"]),
}


def frontier(all_of_them, error):
    """Beginning at the fastest of those with the least error: each next one has the least error among those that are
    faster by more than a step."""
    points = [(error(s), -s.speed, k, s) for k, s in enumerate(all_of_them)
              if not s.partial and s.speed and error(s) is not None]
    found, slowest = [], 0
    while faster := [point for point in points if -point[1] > slowest]:
        found.append(min(faster)[3])
        slowest = found[-1].speed * STEP
    return found


def fastest_of_modes(all_of_them):
    best = {}
    for s in all_of_them:
        if not s.partial and s.speed > (best[s.mode].speed if s.mode in best else 0):
            best[s.mode] = s
    return best


# ---- blocks ----

def accuracy(data):
    """A line of the summary: the default kernel, and the fastest of each other mode."""
    labels = {"moller-trumbore": "with the Möller–Trumbore leaf test", "embree": "for Embree",
              "embree-robust": "for Embree in robust mode"}
    results = data[FILE]
    everyone = summaries(results)
    best = fastest_of_modes(everyone)
    default = default_kernel(data, results.run.text("isa"))
    own = next((s for s in everyone if s.mode == "strict" and s.kernel == default), None)
    if own is None:
        raise Problem(f"{results.path}: has no result of the default kernel {default}")
    rays = results.run.number("rays_a_class") * sum(line.text("rays") in AIMED for line in results.of("result")
                                                    if line.text("contender") == own.name)
    figures = [f"{three(own.aimed)} for the default kernel",
               *(f"{three(best[mode].aimed)} {label}" for mode, label in labels.items() if mode in best)]
    return ("- **Wrong answers** per million rays aimed at vertices and edges: " + ", ".join(figures) +
            f". Each traced {grouped(rays)} rays.\n")


def modes(results):
    """The fastest of each mode, with little beside."""
    all_of_them = summaries(results)
    best = fastest_of_modes(all_of_them)
    rows = [[s.mode, label(s), f"{s.speed:.3g}", three(s.ordinary), three(s.aimed), f"{s.worst['off_cells']:.2g}"]
            for s in all_of_them if best.get(s.mode) is s]
    return table(["mode", "fastest kernel or peer", "Mrays/s", "wrong answers per million rays", "per million aimed rays",
                  "cells off the surface, worst"], rows, "llrrrr")


def frontiers(results):
    """A row a step along each frontier."""
    rows, all_of_them = [], summaries(results)
    for title, error in FRONTIERS.values():
        before = None
        for s in frontier(all_of_them, error):
            gain = f"+{100 * (s.speed / before.speed - 1):.1f} %" if before else ""
            rows.append([title if before is None else "", s.mode, label(s), f"{s.speed:.3g}", gain, three(error(s))])
            before = s
    return (f"{run_text(results.run)}; {results.run.number('rays_a_class')} rays of each class on each field.\n\n" +
            table(["error", "mode", "kernel or peer", "Mrays/s", "speed gained", "its error"], rows, "lllrrr"))


def errors(results):
    """The fastest of each mode, with all of its errors."""
    all_of_them = summaries(results)
    best = fastest_of_modes(all_of_them)
    rows = []
    for s in all_of_them:
        if best.get(s.mode) is s:
            rows.append([s.mode, *(three(s.rate[key]) for key in RATES[:3]), three(s.aimed), three(s.rate["broken"]),
                         *(f"{two(s.median[key])} / {two(s.worst[key])}" for key in ERRORS)])
    return table(["mode", "leaks", "phantoms", "wrong surfaces", "aimed", "beyond claim",
                  *(f"{title}: median / worst" for title in ERRORS.values())], rows)


# What the table of precision compares: key and title.
PRECISE = {"t_relative": "t, relative", "off_cells": "t, cells off the surface", "uv": "u, v", "normal_degrees": "normal, degrees",
           "point_cells": "point, cells"}
SIDES = {"strict": "Cellwalk", "embree": "Embree", "embree-robust": "Embree robust"}


def _least(lines, key):
    """Of a mode's kernels or widths, the best figure."""
    return min(line.number(key) for line in lines)


def precision(results):
    """A table a field, with a row a class of rays and a side: errors of the median and of 99.9 % of all hits; and where Embree's
    are smaller."""
    text, better, compared = "", [], 0
    classes = [*SHORT, *(rays for rays in names.CLASSES if results.first("result", rays=rays, query="closest"))]
    for field in results.distinct("field"):
        rows = []
        for rays in classes:
            sides = {mode: [line for line in results.of("result", field=field, rays=rays, mode=mode) if "uv_most" in line]
                     for mode in SIDES}
            title = SHORT.get(rays, names.CLASSES.get(rays))
            for mode, lines in sides.items():
                if lines:
                    rows.append([title if mode == "strict" else "", SIDES[mode],
                                 *(f"{_least(lines, f'{key}_median'):.1e} / {_least(lines, f'{key}_most'):.1e}" for key in PRECISE),
                                 f"{_least(lines, 'point_cells_worst'):.1e}"])
            for key, column in PRECISE.items():
                for part, of in (("median", "median"), ("most", "99.9 %")):
                    theirs = [_least(sides[mode], f"{key}_{part}") for mode in ("embree", "embree-robust") if sides[mode]]
                    compared += bool(theirs)
                    if theirs and min(theirs) < _least(sides["strict"], f"{key}_{part}"):
                        better.append(f"{column} ({of}), {title}, {names.field(field)}")
        text += (f"\n{names.field(field)} samples, median / 99.9 %:\n\n" +
                 table(["hits", "", *PRECISE.values(), "point, worst"], rows, "ll" + "r" * (len(PRECISE) + 1)))
    return (f"{run_text(results.run)}; {results.run.number('rays_a_class')} rays of each class on each field.\n" + text +
            f"\nEmbree's better mode has a smaller error in {len(better)} of {compared} comparisons" +
            (": " + "; ".join(better) if better else "") + ".\n")


def mode_speeds(results):
    """A row a kernel or width of Embree, a column a mode."""
    ran = [s for s in summaries(results) if s.ran and s.speed]
    modes_of_all = list(dict.fromkeys(s.mode for s in ran))
    labels = {s.kernel: label(s) for s in ran}
    of = {(s.kernel, s.mode): f"{s.speed:.3g}" + (" \\*" if s.partial else "") for s in ran}
    fastest = {kernel: max(s.speed for s in ran if s.kernel == kernel) for kernel in labels}
    rows = [[labels[kernel], *(of.get((kernel, mode), "") for mode in modes_of_all)]
            for kernel in sorted(fastest, key=fastest.get, reverse=True)]
    return table(["kernel or peer", *modes_of_all], rows)


def pictures(results):
    """A row a scene, a column a mode: RMSE / pixels that differ visibly."""
    lines = results.of("picture")
    modes_of_all = [mode for mode in results.distinct("mode")
                    if mode != "strict" and results.first("picture", mode=mode)]
    of = {(line.text("scene"), line.text("mode")): f"{line.number('rmse'):.1g} / {line.number('pixels_visibly')}"
          for line in lines}
    return table(["scene", "pixels", *modes_of_all],
                 [[scene, grouped(results.first("picture", scene=scene).number("pixels")),
                   *(of.get((scene, mode), "") for mode in modes_of_all)] for scene in results.distinct("scene", "picture")])


# ---- claims of the coursework ----

EARLY, EXACT = "early/grid3d-early", "moller-trumbore/grid3d"


def early(results):
    """Whether a 3D grid may return the first triangle hit that it finds."""
    def tally(name):
        lines = [line for line in results.of("result", contender=name, query="closest") if "mrays_per_s" in line]
        wrong = [sum(line.number(key) for key in RATES[:3]) for line in lines]
        return lines, wrong, sum(line.number("ray_count") for line in lines)

    (lines, wrong, rays), (_, wrong_exact, rays_exact) = tally(EARLY), tally(EXACT)
    if not (rays and rays_exact):
        return "Not measured: the modes early and moller-trumbore did not both run.\n"
    # Both use the same leaf test, whose own leaks are not the early return's fault.
    safe = sum(wrong) / rays <= sum(wrong_exact) / rays_exact
    per_million, worst = max((1e6 * count / line.number("ray_count"), k) for k, (count, line) in enumerate(zip(wrong, lines)))
    where = f"{lines[worst].text('rays')} rays, {names.field(lines[worst].text('field'))}"
    return (f"{'No counterexample found' if safe else 'Refuted'}. `grid3d-early` answers {sum(wrong)} of {rays} rays wrongly, "
            f"at worst {per_million:.0f} in a million ({where}). `grid3d`, which goes on until no nearer hit can follow, "
            f"answers {sum(wrong_exact)} of {rays_exact} wrongly.\n")


def cells(data):
    """Whether a cell walk tests fewer cells but more triangles than a 3D grid."""
    found = work(data)
    fewer, more = (sum(f(grid, cell) for grid, cell, _ in found.values()) for f in (
        lambda grid, cell: cell[0] < grid[0], lambda grid, cell: cell[1] > grid[1]))
    verdict = "Confirmed" if fewer == more == len(found) else "True only in part" if fewer and more else "Refuted"
    return (f"{verdict}. The cell walk visits fewer cells than the 3D grid visits voxels in {fewer} of {len(found)} sets of "
            f"rays; the geometric mean is {mean_ratio(found, 1, 0, 0):.1f} times as many. It tests more triangles in {more} "
            f"of them, and {100 * mean_ratio(found, 1, 0, 1):.2g} % as many on average.\n")


def normals(results):
    """Whether barycentric interpolation of normals beats bilinear interpolation."""
    lines = results.of("normal")
    if not lines:
        return "Not measured.\n"

    def ratios(key):
        return [line.inner("barycentric").number(key) / line.inner("bilinear").number(key) for line in lines]

    error, cost = ratios("degrees_rms"), ratios("nanoseconds")
    better, cheaper = (sum(value < 1 for value in values) for values in (error, cost))
    verdict = ("Confirmed" if better == len(lines) else "True only in part" if better else
               "Refuted for accuracy, confirmed for cost" if cheaper > len(lines) // 2 else "Refuted")
    kinds = [kind for kind in ("facet", "barycentric", "bilinear", "central", "central_bilinear")
             if all(line.get(kind) for line in lines)]

    def column(kind):
        return "central, bilinear" if kind == "central_bilinear" else kind

    rows = [[f"{line.number('wave_length'):g} × {line.number('wave_height'):g}",
             *(text for kind in kinds for of in [line.inner(kind)]
               for text in (f"{of.number('degrees_rms'):.3g} / {of.number('degrees_worst'):.3g}",
                            f"{of.number('nanoseconds'):.0f}")),
             *(f"{line.inner('central').number('degrees_to_area_rms'):.3g}" for _ in kinds[3:4])] for line in lines]
    head = ["wave: length × height, cells", *(text for kind in kinds for text in (column(kind), "ns")),
            *("central to area-weighted" for _ in kinds[3:4])]
    return (f"{verdict}. The barycentric normal is more accurate on {better} of {len(lines)} waves (RMS error "
            f"{geometric_mean(error):.2f} times that of the bilinear normal, geometric mean) and cheaper on {cheaper} "
            f"({geometric_mean(cost):.2f} times the time).\n\nError in degrees, RMS / worst, and nanoseconds a normal:\n\n" +
            table(head, rows))


# ---- an own run ----

def page(results):
    """All of one file, for a page of one's own."""
    parts = {"Frontiers": frontiers, "Modes": modes, "Errors": errors, "Speeds in millions of rays a second": mode_speeds,
             "Early return from a 3D grid": early, "Normals": normals}
    if results.first("picture"):
        parts["Pictures: RMSE / pixels that differ visibly"] = pictures
    return "\n".join(f"**{title}**\n\n{make(results)}" for title, make in parts.items())
