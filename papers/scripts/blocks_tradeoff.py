# SPDX-License-Identifier: Apache-2.0
"""Speed against error: what the results of cellwalk-bench tradeoff come to, and their tables."""

import math
from statistics import median

from blocks_work import places, triangles
from markdown import table
from results import geometric_mean, run_text

AIMED = ("vertices", "edges")  # classes of rays that are made to find leaks; they are not timed
RATES = ("leaks", "phantoms", "wrong", "broken")
ERRORS = ("t_ulp", "t_cells", "off_cells", "normal_degrees")
# A step along a frontier is worth naming if it gains more speed than two runs of one program may differ by.
STEP = 1.02


class Summary:
    """One contender over all groups (fields × classes of rays)."""

    def __init__(self, name, lines, groups, timed):
        ran = [line for line in lines if "left_out_seconds" not in line]
        speeds = [line.number("mrays_per_s") for line in ran if "mrays_per_s" in line]
        self.name, self.mode = name, lines[0].text("mode")
        self.ran, self.partial = bool(ran), len(ran) < groups or len(speeds) < timed
        self.speed = geometric_mean(speeds)
        ordinary = [line for line in ran if line.text("rays") not in AIMED]
        aimed = [line for line in ran if line.text("rays") in AIMED]
        self.rate = {key: _mean([line.number(f"{key}_per_million") for line in (ran if key == "broken" else ordinary)])
                     for key in RATES}
        self.wrong, self.aimed = (_mean([wrong_answers(line) for line in some]) for some in (ran, aimed))
        self.median, self.worst = {}, {}
        for key in ERRORS:
            of = [line for line in ran if f"{key}_worst" in line]
            self.median[key] = median(line.number(f"{key}_median") for line in of) if of else None
            self.worst[key] = max((line.number(f"{key}_worst") for line in of), default=None)


def wrong_answers(line):
    return sum(line.number(f"{key}_per_million") for key in RATES[:3])


def _mean(values):
    return math.fsum(values) / len(values) if values else None


def summaries(results):
    lines = results.of("result")
    groups = {(line.text("field"), line.text("rays")) for line in lines}
    timed = {(line.text("field"), line.text("rays")) for line in lines if "mrays_per_s" in line}
    by_name = {}
    for line in lines:
        by_name.setdefault(line.text("contender"), []).append(line)
    return [Summary(name, of, len(groups), len(timed)) for name, of in by_name.items()]


def frontier(all_of_them, error):
    """Beginning at the fastest of those with the least error: each next one has the least error among those that are
    faster by more than a step."""
    points = [(error(s), s) for s in all_of_them if not s.partial and s.speed and error(s) is not None]
    found, slowest = [], 0
    while faster := [(value, -s.speed, k, s) for k, (value, s) in enumerate(points) if s.speed > slowest]:
        found.append(min(faster)[3])
        slowest = found[-1].speed * STEP
    return found


# What a frontier is about: how it is told, the error, and its unit.
FRONTIERS = {
    "answers": ("wrong answers", lambda s: s.wrong, "wrong answers in a million rays"),
    "place": ("the worst height of a hit off the surface", lambda s: s.worst["off_cells"],
              "cells above or below the surface at worst"),
}


def fastest_of_modes(all_of_them):
    best = {}
    for s in all_of_them:
        if not s.partial and s.speed > (best[s.mode].speed if s.mode in best else 0):
            best[s.mode] = s
    return best


def steps(all_of_them, name):
    _, error, unit = FRONTIERS[name]

    def price(s):
        return f"{error(s):.3g}" if error(s) < 1000 else f"{error(s):.0f}"

    text, before = "", None
    for s in frontier(all_of_them, error):
        if before is None:
            text += (f"- {s.name} is the fastest of those with the least error: {s.speed:.3g} Mrays/s, {price(s)} "
                     f"{unit}.\n")
        else:
            text += (f"- From {before.name} to {s.name}: {100 * (s.speed / before.speed - 1):.1f} % faster, but "
                     f"{price(s)} instead of {price(before)} {unit}.\n")
        before = s
    return text


# ---- blocks ----

def accuracy(data):
    """A line of the summary."""
    names = {"strict": "the default", "moller-trumbore": "with Möller and Trumbore's test instead",
             "embree": "Embree", "embree-robust": "Embree's robust mode"}
    best = fastest_of_modes(summaries(data["tradeoff/tradeoff.json"]))
    return ("- Wrong answers in a million rays aimed at vertices and edges: " +
            ", ".join(f"{best[mode].aimed:.0f} ({name})" for mode, name in names.items() if mode in best) + ".\n")


def modes(data):
    """The frontier block of the report."""
    all_of_them = summaries(data["tradeoff/tradeoff.json"])
    best = fastest_of_modes(all_of_them)
    rows = [[s.name, f"{s.speed:.3g}", f"{s.wrong:.3g}", f"{s.aimed:.0f}", f"{s.worst['off_cells']:.2g}"]
            for s in all_of_them if best.get(s.mode) is s]
    return ("The fastest contender of each mode; wrong answers in a million rays, those aimed at vertices and edges by\n"
            "themselves, and the worst height of a hit off the surface in cells.\n\n" +
            table(["mode / kernel", "Mrays/s", "wrong answers", "of aimed rays", "off the surface"], rows) +
            "\nSpeed against wrong answers:\n\n" + steps(all_of_them, "answers") +
            "\nSpeed against the worst height off the surface:\n\n" + steps(all_of_them, "place"))


def page(results):
    all_of_them = summaries(results)
    text = f"{run_text(results.run)}. {results.run.number('rays_a_class')} rays a class and field.\n\n### The frontier\n\n"
    for name, (title, _, _) in FRONTIERS.items():
        text += f"Speed against {title}:\n\n{steps(all_of_them, name)}\n"
    text += ("### All contenders\n\nSpeed: geometric mean over fields and classes of rays. Leaks, phantoms and wrong "
             "surfaces: in a million rays,\nmean over the same. Aimed: all three, of rays aimed at vertices and edges; "
             "the frontier counts them too. Beyond\nclaim: what the mode's own bound does not explain. Errors of t, "
             "heights off the surface in cells and angles between\nnormals in degrees: median of the groups' medians, "
             "and the worst of all.\n\n" + _contenders(all_of_them) +
             "\n\\* did not run everywhere, for want of time, memory or means; its figures are of where it did.\n\n")
    return text + _scenes(results) + _claims(results)


def _form(value, form):
    return "" if value is None else format(value, form)


def _rate(value):
    return _form(value, ".3g" if value is not None and value < 100 else ".0f")


def _contenders(all_of_them):
    on = {name: frontier(all_of_them, error) for name, (_, error, _) in FRONTIERS.items()}
    forms = {"t_ulp": (".2f", ".3g"), "t_cells": (".2g", ".2g"), "off_cells": (".2g", ".2g"),
             "normal_degrees": (".2g", ".2g")}
    rows = []
    for s in sorted((s for s in all_of_them if s.ran), key=lambda s: (-s.speed, s.name)):
        rows.append([s.name + (" \\*" if s.partial else ""), _form(s.speed or None, ".3g"),
                     ", ".join(name for name in on if any(s is other for other in on[name])),
                     *(_rate(s.rate[key]) for key in RATES[:3]), _rate(s.aimed), _rate(s.rate["broken"]),
                     *(_form(of[key], form) for key in ERRORS
                       for of, form in zip((s.median, s.worst), forms[key]))])
    return table(["mode / kernel", "Mrays/s", "frontier", "leaks", "phantoms", "wrong surface", "aimed", "beyond claim",
                  "t: ULP, median", "worst", "t: cells, median", "worst", "off surface: median", "worst",
                  "normal: median", "worst"], rows, "lrl" + "r" * 13)


def _scenes(results):
    pictures = results.of("picture")
    if not pictures:
        return ""
    rows = [[line.text("scene"), line.text("contender"), f"{line.number('trace_mrays_per_s'):.3g}",
             f"{line.number('rmse'):.2g}", f"{line.number('worst'):.2g}", line.number("pixels_differ"),
             line.number("pixels_visibly")] for line in pictures]
    return ("### The scenes\n\nPictures against strict, values from 0 to 1, Phong normals of the scene's own samples.\n\n" +
            table(["scene", "mode / kernel", "Mrays/s", "RMSE", "worst pixel", "pixels that differ", "visibly"], rows,
                  "llrrrrr") + "\n")


# ---- claims of the coursework ----

EARLY, EXACT = "early/grid3d-early", "moller-trumbore/grid3d"


def _claims(results):
    return "### Three claims\n\n" + _early(results) + _cells(results) + _normals(results)


def _early(results):
    def tally(name):
        lines = [line for line in results.of("result", contender=name, query="closest")
                 if "mrays_per_s" in line and "left_out_seconds" not in line]
        wrong = [sum(line.number(key) for key in RATES[:3]) for line in lines]
        rates = [1e6 * w / line.number("ray_count") for w, line in zip(wrong, lines)]
        return sum(wrong), sum(line.number("ray_count") for line in lines), rates, lines

    claim = "**\"return at the first triangle hit in the 3D grid is safe\": "
    early, early_rays, rates, lines = tally(EARLY)
    exact, exact_rays, _, _ = tally(EXACT)
    if not (early_rays and exact_rays):
        return claim + "not measured.** The modes early and moller-trumbore did not both run.\n\n"
    # Both use the same leaf test, whose own leaks are not the early return's fault.
    safe = early / early_rays <= exact / exact_rays
    worst = lines[rates.index(max(rates))]
    text = claim + (f"{'no counterexample found' if safe else 'refuted'}.** grid3d-early gives a wrong answer for "
                    f"{early:.0f} of {early_rays:.0f} rays, at worst {max(rates):.0f} in a million (field "
                    f"{worst.text('field')}, {worst.text('rays')} rays); grid3d, which goes on until no nearer hit can "
                    f"follow, for {exact:.0f} of {exact_rays:.0f}.\n\n"
                    "Wrong answers of grid3d-early in a million, those of grid3d in brackets:\n\n")
    fields = results.distinct("field")

    def cell(rays, field):
        both = [results.first("result", contender=name, field=field, rays=rays) for name in (EARLY, EXACT)]
        if any(line is None or "leaks_per_million" not in line for line in both):
            return ""
        return "{} ({})".format(*(_rate(wrong_answers(line)) for line in both))

    rows = [[rays, *(cell(rays, field) for field in fields)] for rays in results.distinct("rays")
            if results.first("result", contender=EARLY, rays=rays, query="closest")]
    return text + table(["rays", *fields], rows) + "\n"


def _cells(results):
    claim = "**\"2D-DDA tests fewer cells but more triangles\": "
    counts = results.of("count")
    keys = ("voxels", "voxel_triangles", "cells", "cell_triangles")
    work = [[line.number(key) for key in keys] for line in counts]
    cells = [c / v for v, _, c, _ in work]
    tests = [ct / vt for _, vt, _, ct in work]
    ungated = [2 * c / vt for _, vt, c, _ in work]
    if not work:
        return claim + "not measured.** Nothing was counted.\n\n"
    fewer, more = sum(value < 1 for value in cells), sum(value > 1 for value in tests)
    verdict = ("confirmed" if fewer == more == len(work) else "refuted" if fewer == 0 or more == 0 else
               "true only in part")
    text = claim + (
        f"{verdict}.** The cell walk visits fewer cells than the 3D grid voxels in {fewer} of {len(work)} sets of rays "
        f"({geometric_mean(cells):.3g} times as many, geometric mean). It tests more triangles in {more} of them "
        f"({geometric_mean(tests):.3g} times as many) with its comparison of heights before the test, and in "
        f"{sum(value > 1 for value in ungated)} ({geometric_mean(ungated):.3g} times as many) if it tested both "
        "triangles of every cell that it visits.\n\n"
        "A ray, on average; cell triangles are those tested after the comparison of heights:\n\n")
    rows = [[line.text("where"), line.text("rays"), *(f"{value:.1f}" for value in of)]
            for line, of in zip(counts, work)]
    return (text + table(["field or scene", "rays", "voxels", "triangles", "cells", "triangles"], rows, "llrrrr") +
            f"\nCounted rays that did not end at the kernels' hits: {sum(line.number('astray') for line in counts)}.\n\n")


def _normals(results):
    lines = results.of("normal")
    claim = "**\"barycentric Phong beats bilinear\": "
    if not lines:
        return claim + "not measured.** No normals were measured.\n\n"

    def ratios(key):
        return [line.inner("barycentric").number(key) / line.inner("bilinear").number(key) for line in lines]

    errors, costs = ratios("degrees_rms"), ratios("nanoseconds")
    better, cheaper = (sum(value < 1 for value in values) for values in (errors, costs))
    verdict = ("confirmed" if better == len(lines) else "true only in part" if better else
               "refuted for accuracy, confirmed for cost" if cheaper > len(lines) // 2 else "refuted")
    text = claim + (
        f"{verdict}.** The barycentric normal is nearer to the true one on {better} of {len(lines)} waves (root mean "
        f"square error {geometric_mean(errors):.3g} times that of the bilinear one, geometric mean), and cheaper on "
        f"{cheaper} ({geometric_mean(costs):.3g} times the time).\n\n"
        "Root mean square (worst) error in degrees, and nanoseconds a normal:\n\n")
    rows = [[f"{line.number('wave_length'):g} × {line.number('wave_height'):g}",
             *(text for kind in ("facet", "barycentric", "bilinear") for of in [line.inner(kind)]
               for text in (f"{of.number('degrees_rms'):.3g} ({of.number('degrees_worst'):.3g})",
                            f"{of.number('nanoseconds'):.1f}"))] for line in lines]
    return text + table(["wave: length × height, cells", "facet", "ns", "barycentric", "ns", "bilinear", "ns"], rows) + "\n"
