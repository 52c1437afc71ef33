# SPDX-License-Identifier: Apache-2.0
"""Tables of exactness: the long run of cellwalk-stability; the tests extremes, exhaustive and stress; the cost of the
watertight leaf test."""

import names
from blocks_speed import matrix
from markdown import grouped, table, three
from results import Problem, run_text

# ---- the long run ----

AIMS = {
    "inside": "inside a triangle", "vertex": "at a sample", "edge": "at a border edge", "diagonal": "at a diagonal",
    "borders": "along grid lines", "axis": "axis-parallel between grid lines", "corners": "over samples in whole steps",
    "vertical": "vertical", "steep": "all but vertical", "long": "across the field, low",
    "grazing": "1 to 10^-6 degrees to a triangle",
}
STARTS = {"over": "starting over the field", "afar": "starting afar", "near": "starting within two cells",
          "behind": "with a range that begins far behind"}
SUMS = ("traced", "hits", "other_bits", "pass", "leaks", "phantoms", "sampled")
MOST = ("residual", "apart", "t_error")


class Counts:
    """Counts of one contender, of one class of rays or of several added up."""

    def __init__(self):
        self.sum, self.verdicts, self.ulp = dict.fromkeys(SUMS + MOST, 0), {}, []

    def add(self, line):
        for key in SUMS:
            self.sum[key] += line.number(key, 0)
        for key in MOST:
            self.sum[key] = max(self.sum[key], line.number(key, 0))
        for key, count in line.get("verdicts", {}).items():
            self.verdicts[key] = self.verdicts.get(key, 0) + count
        ulp = line.get("t_error_ulp", [])
        self.ulp = [a + b for a, b in zip(self.ulp, ulp)] if self.ulp else ulp

    def __getitem__(self, key):
        return self.sum[key] if key in self.sum else self.verdicts.get(key, 0)

    def median_ulp(self):
        """The error of t that half of the right hits do not exceed."""
        below = 0
        for k, count in enumerate(self.ulp):
            below += count
            if 2 * below >= sum(self.ulp):
                return 2.0 ** (k - 1)
        return 0


def _check_parts(files):
    """No batch of rays may count twice."""
    for k, results in enumerate(files):
        a = results.run
        for other in files[:k]:
            b = other.run
            parts_differ = a.number("parts") == b.number("parts") and a.number("part") != b.number("part")
            if not parts_differ and a.number("first") < b.number("end") and b.number("first") < a.number("end"):
                raise Problem(f"{results.path}:1: batches {a.number('first')} to {a.number('end')} are also in "
                              f"{other.path}")


def stability(files, default=""):
    """files: one run, or parts of one whose counts are added up. default: the kernel that the library chooses today."""
    _check_parts(files)
    role, of = {}, {}
    for line in (line for results in files for line in results.of("result")):
        name, rays = line.text("contender"), line.text("rays")
        if rays not in AIMS:
            raise Problem(f'{line.where}: "rays" is "{rays}", an unknown class')
        role[name] = line.text("role")
        for kind in (rays, *([line.text("start")] if "start" in line else []), "all"):
            of.setdefault((name, kind), Counts()).add(line)
    if not role:
        raise Problem(f"{files[0].path}: has no results")
    reference = next(iter(role))
    seconds = sum(results.run.number("seconds") for results in files)
    return (f"{grouped(of[reference, 'all']['traced'])} rays, one in {files[-1].run.number('sample')} of them judged in full; "
            f"{seconds:.0f} s of CPU time on one thread. {run_text(files[0].run)}.\n\n" +
            _contenders(role, of) + _about_default(default, reference, role) + "\n" + _classes(reference, of))


def _about_default(default, reference, role):
    """Whether these counts are the default kernel's."""
    if not default or names.kernel(reference) == default:
        return ""
    took_part = f"{default}/watertight" in role
    return (f"\nThe speeds on these pages are those of another default kernel, `{default}`. " +
            ("Its bits were compared in this run.\n" if took_part else
             "It took no part in this run; the test `lanes` compares its bits.\n"))


def _contenders(role, of):
    """Kernels that only have to return the reference's bits share a row."""
    rows, same = [], [name for name, kind in role.items() if kind == "same-bits"]
    for name, kind in role.items():
        counts = of[name, "all"]
        if kind != "same-bits":
            rows.append([names.label(name), grouped(counts["traced"]), *(grouped(counts[key]) for key in (
                "pass", "leaks", "phantoms", "sampled", "wrong_surface"))])
    text = table(["kernel or peer", "rays", "known to pass", "leaks", "phantoms", "judged in full", "wrong surfaces"], rows)
    if same:
        rays = sum(of[name, "all"]["traced"] for name in same)
        other = sum(of[name, "all"]["other_bits"] for name in same)
        text += (f"\n{', '.join(map(names.label, same))} answered {grouped(rays)} rays in all; "
                 f"**{grouped(other)}** of the answers differed from the reference's in any bit.\n")
    return text


# Whose leaks are shown by class, beside the reference's: a name's beginning and a title.
BESIDE = {"/moller-trumbore": "Möller–Trumbore", "embree/w8": "Embree", "embree-robust/w8": "Embree robust"}


def _classes(reference, of):
    """How close the reference's hits come to their bounds, and how often others leak."""
    others = {reference.split("/")[0] + name if name.startswith("/") else name: title for name, title in BESIDE.items()}
    others = {name: title for name, title in others.items() if (name, "all") in of}

    def leaks(name, kind):
        counts = of.get((name, kind))
        return three(1e6 * counts["leaks"] / counts["pass"]) if counts and counts["pass"] else ""

    rows = []
    for kind, text in {**AIMS, **STARTS, "all": "all"}.items():
        if (reference, kind) not in of:
            continue
        c = of[reference, kind]
        rows.append([text, f"{c['residual']:.2f}", f"{c['apart']:.2f}", f"{c['t_error']:.2f}", f"{c.median_ulp():g}",
                     *(leaks(name, kind) for name in (reference, *others))])
    return (f"By class of rays: how close the hits of `{names.kernel(reference)}` come to their error bounds, and leaks per "
            "million rays that are known to pass.\n\n" +
            table(["rays", "worst \\|d\\| / E", "worst distance / delta", "worst error of t / bound", "median error of t, ULP",
                   "leaks: Cellwalk", *others.values()], rows))


# ---- extremes ----

def extremes(results):
    """A row an item. Watertight kernels have no excuse; of the others' answers, what rounding excuses is counted."""
    rows, kernels, wrong, answers = [], {}, 0, 0
    for item in results.distinct("item", "extreme"):
        excused, asked = [], 0
        for line in results.of("extreme", item=item):
            kernels.setdefault(line.text("leaf"), {})[line.text("kernel")] = True
            excuses = sum(line.number(key, 0) for key in ("slipped", "parallel", "early"))  # early: of grid3d-early, in older files
            if line.text("leaf") == "watertight" and excuses:
                raise Problem(f"{line.where}: a watertight kernel is excused")
            wrong += line.number("asked") - line.number("as_expected") - excuses
            answers += line.number("asked")
            asked = max(asked, line.number("asked"))
            if line.text("leaf") == "moller-trumbore" and line.number("asked"):
                excused.append(100 * excuses / line.number("asked"))
        rows.append([item, grouped(asked), results.first("extreme", item=item).text("expected"),
                     f"up to {max(excused):.1f} %" if any(excused) else ""])
    counts = " and ".join(f"{len(of)} kernels with the {leaf} leaf test" for leaf, of in sorted(kernels.items()))
    text = (f"{run_text(results.run)}.\n\n" +
            table(["extreme", "rays", "expected, and why", "Möller–Trumbore: excused"], rows, "lrlr") +
            f"\nAsked were {counts}: {grouped(answers)} answers, **{grouped(wrong)}** not as expected.")
    if results.run.get("emulated"):
        text += " The kernels 16 lanes wide ran through an emulation of AVX-512."
    return text + "\n"


# ---- exhaustive and stress ----

def exhaustive(results):
    rows = []
    for line in results.of("exhaustive"):
        fields, all_of_them = line.number("fields"), line.number("all_fields")
        others = line.number("tie") - line.number("rims") - line.number("thirds")
        rows.append([line.text("field"), line.text("heights"),
                     grouped(fields) + ("" if fields == all_of_them else f" of {grouped(all_of_them)}"),
                     *(grouped(line.number(key)) for key in ("rays", "hits", "rims", "thirds")), grouped(others),
                     "**" + " / ".join(str(line.number(key)) for key in ("leak", "phantom", "wrong_surface")) + "**",
                     grouped(line.number("same_bits"))])
    return f"{run_text(results.run)}.\n\n" + table(
        ["samples", "heights", "fields", "rays", "hits", "ties at a rim", "at a third", "other ties",
         "leaks / phantoms / wrong surfaces", "bit-identical answers of other kernels"], rows, "ll" + "r" * 8)


def stress(results):
    rows = [[line.text("rays"), *(grouped(line.number(key)) for key in ("traced", "hits", "answers")),
             f"**{line.number('other_bits')}**"] for line in results.of("stress")]
    return f"{run_text(results.run)}.\n\n" + table(["rays", "traced", "hits", "answers of other kernels",
                                                  "of these, with other bits"], rows)


# ---- the cost of being watertight ----

def leaf(results):
    fields, classes = matrix(results)
    kernels = [name.split("/")[0] for name in results.distinct("contender") if name.endswith("/moller-trumbore")]

    def cell(field, rays, kernel):
        other, ours = (results.first("result", field=field, rays=rays, contender=f"{kernel}/{name}")
                       for name in ("moller-trumbore", "watertight"))
        if not (other and ours):
            return ""
        return "{:.2f} ({:.2f} to {:.2f})".format(*(
            other.number(f"seconds_{above}") / ours.number(f"seconds_{below}")
            for above, below in (("median", "median"), ("low", "high"), ("high", "low"))))

    rows = [[names.field(field), rays, *(cell(field, rays, kernel) for kernel in kernels)]
            for field in fields for rays in classes]
    return (f"{run_text(results.run)}. In brackets: the range that the medians' confidence intervals allow.\n\n" +
            table(["field", "rays", *(f"`{kernel}`" for kernel in kernels)], rows, "ll" + "r" * len(kernels)))
