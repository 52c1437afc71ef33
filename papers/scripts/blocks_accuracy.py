# SPDX-License-Identifier: Apache-2.0
"""Errors of hits: what the results of cellwalk-bench accuracy come to, and their tables."""

import math
from statistics import median

import names
from blocks_speed import default_kernel
from markdown import grouped, table, three
from results import Problem, geometric_mean, run_text

FILE = "accuracy/accuracy.json"
AIMED = ("vertices", "edges")  # classes of rays that are made to find leaks; they are not timed
SHORT = {"within-0.1": "0.01 to 0.1 cells away", "within-2": "0.5 to 2 cells away"}  # for the table of precision alone
RATES = ("leaks", "phantoms", "wrong", "broken")
ERRORS = {"t_ulp": "t in ULP", "t_cells": "t in cells", "off_cells": "off the surface, cells",
          "normal_degrees": "normal, degrees"}


class Summary:
    """One mode with one kernel, or a peer, over all groups (fields × classes of rays)."""

    def __init__(self, name, lines, groups):
        ran = [line for line in lines if "left_out_seconds" not in line]
        self.name, self.mode, self.kernel = name, lines[0].text("mode"), lines[0].text("kernel")
        self.partial = len(ran) < groups
        ordinary = [line for line in ran if line.text("rays") not in AIMED]
        aimed = [line for line in ran if line.text("rays") in AIMED]
        self.rate = {key: _mean([line.number(f"{key}_per_million") for line in (ran if key == "broken" else ordinary)])
                     for key in RATES}
        self.wrong, self.ordinary, self.aimed = (_mean([wrong_answers(line) for line in some])
                                                 for some in (ran, ordinary, aimed))
        self.median, self.worst = {}, {}
        for key in ERRORS:
            # From afar no float t is fine enough to say where a hit is.
            of = [line for line in ran if f"{key}_worst" in line and line.text("rays") != "afar"]
            self.median[key] = median(line.number(f"{key}_median") for line in of) if of else None
            self.worst[key] = max((line.number(f"{key}_worst") for line in of), default=None)


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
    by_name = {}
    for line in lines:
        by_name.setdefault(line.text("contender"), []).append(line)
    return [Summary(name, of, len(groups)) for name, of in by_name.items()]


def best_of_modes(all_of_them):
    """Of a mode's kernels or of Embree's widths, the one with the fewest wrong answers."""
    best = {}
    for s in all_of_them:
        if not s.partial and (s.mode not in best or s.wrong < best[s.mode].wrong):
            best[s.mode] = s
    return best


# ---- blocks ----

def accuracy(data):
    """A line of the summary: the default kernel, and the best of each other mode."""
    labels = {"moller-trumbore": "with the Möller–Trumbore leaf test", "embree": "for Embree",
              "embree-robust": "for Embree in robust mode"}
    results = data[FILE]
    everyone = summaries(results)
    best = best_of_modes(everyone)
    # Before version 0.2 the names of pairs had a suffix.
    default = default_kernel(data, results.run.text("isa")).removesuffix("x2")
    own = next((s for s in everyone if s.mode == "strict" and s.kernel == default), None)
    if own is None:
        raise Problem(f"{results.path}: has no result of the default kernel {default}")
    rays = results.run.number("rays_a_class") * sum(line.text("rays") in AIMED for line in results.of("result")
                                                    if line.text("contender") == own.name)
    figures = [f"{three(own.aimed)} for the default kernel",
               *(f"{three(best[mode].aimed)} {label}" for mode, label in labels.items() if mode in best)]
    return ("- **Wrong answers** per million rays aimed at vertices and edges: " + ", ".join(figures) +
            f". Each traced {grouped(rays)} rays.\n")


def errors(results):
    """The best of each mode, with all of its errors."""
    all_of_them = summaries(results)
    best = best_of_modes(all_of_them)
    rows = []
    for s in all_of_them:
        if best.get(s.mode) is s:
            rows.append([s.mode, *(three(s.rate[key]) for key in RATES[:3]), three(s.aimed), three(s.rate["broken"]),
                         *(f"{two(s.median[key])} / {two(s.worst[key])}" for key in ERRORS)])
    return (f"{run_text(results.run)}; {grouped(results.run.number('rays_a_class'))} rays of each class on each field.\n\n" +
            table(["mode", "leaks", "phantoms", "wrong surfaces", "aimed", "beyond claim",
                   *(f"{title}: median / worst" for title in ERRORS.values())], rows))


# What the table of precision compares: key and title.
PRECISE = {"t_relative": "t, relative", "off_cells": "t, cells off the surface", "uv": "u, v", "normal_degrees": "normal, degrees",
           "point_cells": "point, cells"}
SIDES = {"strict": "Cellwalk", "embree": "Embree", "embree-robust": "Embree robust"}


# ---- claims of the coursework ----

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
    parts = {"Errors": errors, "Precision": precision, "Normals": normals}
    return "\n".join(f"**{title}**\n\n{make(results)}" for title, make in parts.items())
