# SPDX-License-Identifier: Apache-2.0
"""Tables of exactness: the long run of cellwalk-stability; the tests extremes, exhaustive and stress; the cost of the
watertight leaf test."""

from blocks_speed import matrix
from markdown import grouped, table
from results import Problem, run_text

# ---- the long run ----

AIMS = {
    "inside": "inside a triangle", "vertex": "at a sample", "edge": "at a border edge", "diagonal": "at a diagonal",
    "borders": "along grid lines", "axis": "axis-parallel between grid lines", "corners": "over samples in whole steps",
    "vertical": "vertical", "steep": "all but vertical", "long": "across the field, low", "far": "from up to 10^6 cells",
    "grazing": "1 to 10^-6 degrees to a triangle",
}
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
                raise Problem(f"{results.path}:1: batches {a.number('first')} to {a.number('end')} are in {other.path} "
                              "as well")


def stability(files):
    """files: one run, or parts of one whose counts are added up."""
    _check_parts(files)
    role, of = {}, {}
    for line in (line for results in files for line in results.of("result")):
        name, rays = line.text("contender"), line.text("rays")
        if rays not in AIMS:
            raise Problem(f'{line.where}: "rays" is "{rays}", an unknown class')
        role[name] = line.text("role")
        for kind in (rays, "all"):
            of.setdefault((name, kind), Counts()).add(line)
    if not role:
        raise Problem(f"{files[0].path}: has no results")
    reference = next(iter(role))
    seconds = sum(results.run.number("seconds") for results in files)
    return (f"{grouped(of[reference, 'all']['traced'])} rays, of which one in {files[-1].run.number('sample')} was "
            f"judged in full; {seconds:.0f} seconds of CPU time on one thread. {run_text(files[0].run)}.\n\n" +
            _contenders(role, of) + "\n" + _reference(reference, of) + "\n" + _rates(role, of))


def _contenders(role, of):
    rows = []
    for name, kind in role.items():
        counts = of[name, "all"]
        judged = ("pass", "leaks", "phantoms", "sampled", "wrong_surface")
        rows.append([f"`{name}`", grouped(counts["traced"]),
                     *("" if kind == "same-bits" else grouped(counts[key]) for key in judged),
                     "" if kind == "own-rules" else grouped(counts["other_bits"])])
    return table(["contender", "rays", "known to pass", "leaks", "phantoms", "judged in full", "wrong surfaces",
                  "other answers than the reference's"], rows)


def _reference(name, of):
    rows = []
    for kind, text in {**AIMS, "all": "all"}.items():
        c = of.get((name, kind), Counts())
        rows.append([text, grouped(c["traced"]), grouped(c["pass"]), f"**{c['leaks']}**", f"**{c['phantoms']}**",
                     f"{c['residual']:.2f}", f"{c['apart']:.2f}", grouped(c["sampled"]), grouped(c["tie"]),
                     f"**{c['wrong_surface']}**", f"{c['t_error']:.2f}", f"{c.median_ulp():g}"])
    return f"`{name}`, a line a class of rays:\n\n" + table(
        ["rays", "traced", "known to pass", "leaks", "phantoms", "worst \\|d\\| / E", "worst distance / delta",
         "judged in full", "ties", "wrong surface", "worst error of t / bound", "its median, ulp"], rows)


def _rates(role, of):
    names = [name for name, kind in role.items() if kind != "same-bits"]

    def rate(count, out_of):
        return "" if not out_of else f"{1e6 * count / out_of:.3g}" if count else "0"

    def rows(key, out_of):
        return [[text, *(rate(of[name, kind][key], of[name, kind][out_of]) if (name, kind) in of else ""
                         for name in names)] for kind, text in AIMS.items()]

    traced = ["*rays traced*", *(grouped(of[name, "all"]["traced"]) for name in names)]
    wrong = ["*wrong surfaces*, of rays judged in full",
             *(rate(of[name, "all"]["wrong_surface"], of[name, "all"]["sampled"]) for name in names)]
    return ("Leaks per million rays that are known to pass:\n\n" +
            table(["rays", *names], [*rows("leaks", "pass"), traced]) + "\nPhantoms per million hits:\n\n" +
            table(["rays", *names], [*rows("phantoms", "hits"), wrong, traced]))


# ---- extremes ----

def extremes(results):
    rows = []
    for item in results.distinct("item", "extreme"):
        lines = results.of("extreme", item=item)
        rows.append([item, grouped(max(line.number("asked") for line in lines)), lines[0].text("expected")])
    text = table(["extreme", "rays", "what is expected, and why"], rows, "lrl")
    for leaf in ("watertight", "moller-trumbore"):
        text += _answers(results, leaf)
    if results.run.get("emulated"):
        text += "\nThe kernels 16 lanes wide ran through an emulation of AVX-512.\n"
    return text


def _answers(results, leaf):
    kernels, wrong = results.distinct("kernel", "extreme", leaf=leaf), 0
    rows = []
    for item in results.distinct("item", "extreme", leaf=leaf):
        rows.append([item])
        for kernel in kernels:
            line = results.first("extreme", item=item, kernel=kernel, leaf=leaf)
            if line is None or not line.number("asked"):
                rows[-1].append("-")
                continue
            excused = sum(line.number(key) for key in ("slipped", "parallel", "early"))
            expected = line.number("as_expected") + excused
            wrong += line.number("asked") - expected
            rows[-1].append(grouped(expected) + (f" ({excused})" if excused else ""))
    return (f"\nAnswers as expected, leaf test `{leaf}`:\n\n" + table(["extreme", *kernels], rows) +
            f"\nNot as expected: **{wrong}**.\n")


# ---- exhaustive and stress ----

def exhaustive(results):
    rows = []
    for line in results.of("exhaustive"):
        fields, all_of_them = line.number("fields"), line.number("all_fields")
        others = line.number("tie") - line.number("rims") - line.number("thirds")
        rows.append([line.text("field"), line.text("heights"),
                     grouped(fields) + (", all" if fields == all_of_them else f" of {grouped(all_of_them)}"),
                     *(grouped(line.number(key)) for key in ("rays", "hits", "right", "rims", "thirds")), others,
                     *(f"**{line.number(key)}**" for key in ("leak", "phantom", "wrong_surface")),
                     grouped(line.number("same_bits"))])
    return table(["fields", "heights", "fields judged", "rays", "hits", "exact", "ties at a rim", "ties at a third",
                  "other ties", "leaks", "phantoms", "wrong surfaces", "same bits from other kernels"], rows,
                 "ll" + "r" * 11)


def stress(results):
    rows = [[line.text("rays"), *(grouped(line.number(key)) for key in ("traced", "hits", "answers")),
             f"**{line.number('other_bits')}**"] for line in results.of("stress")]
    return table(["rays", "traced", "hits", "answers of other kernels", "with other bits"], rows)


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

    rows = [[field, rays, *(cell(field, rays, kernel) for kernel in kernels)] for field in fields for rays in classes]
    return (f"{run_text(results.run)}. In brackets what the medians' intervals allow.\n\n" +
            table(["field", "rays", *kernels], rows, "ll" + "r" * len(kernels)))
