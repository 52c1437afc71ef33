#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables, sentences and charts of README.md and papers/*.md from the results in papers/data. A block in a page is its own query:

<!-- table file=release where="isa == 'avx512'" rows=item cols=field value="faster('embree', 'default')" --> … <!-- end -->
<!-- list file=terrain where="kind == 'time'" cols="program|program; product|product; seconds|dur(wall_seconds)" --> … <!-- end -->
<!-- text file=release
Sentences with {expressions} in braces. --> … <!-- end -->
<!-- chart speed-1025 kind=bars file=release … -->        draws pictures/speed-1025.svg (charts.py)

about=1 begins a block with the run's machine, commit and date. Expressions are Python. where and the columns of a list see a
result's members, value and text the functions of Rows. A figure that has not converged is written "n. c.", one that was not
measured "–"."""

import argparse
import builtins
import json
import math
import os
import re
import shlex
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SKIPPED = 77  # exit status of --check where charts cannot be compared
BLOCK = re.compile(r"(<!-- (table|list|text|files) (.*?)-->\n)(.*?)(<!-- end -->)", re.DOTALL)
CHART = re.compile(r"<!-- chart (.*?)-->", re.DOTALL)
CLASSES = ("primary", "shadow", "ao", "bounce", "random", "grazing", "afar")
DESIGNS = {"(family 25, model 17)": "a Zen 4", "(family 26, ": "a Zen 5", "(family 6, model 173)": "a Granite Rapids",
           "(family 6, model 207)": "an Emerald Rapids"}
LANDS = ("65", "257", "1025", "4097", "sea-calm", "sea-rough", "jacksboro")
ABSENT, WIDE = "–", "n. c."  # not measured; not converged
NAMES = {"ao": "ambient occlusion", "afar": "from afar", "within-2": "from within 2 cells", "sea-calm": "calm sea",
         "sea-rough": "rough sea", "jacksboro": "Jacksboro"}
ISAS = {"avx512": "AVX-512", "avx2": "AVX2", "sse4.2": "SSE4.2", "scalar": "no vector instructions"}


sys.modules.setdefault("draw", sys.modules[__name__])  # for charts.py, if this is the program


class Problem(Exception):
    """What is wrong, for the user."""


class Number(float):
    """A figure; sure is False if it has not converged. item names what it is of."""
    sure, item = True, ""

    @staticmethod
    def of(value, *parts, item=""):
        """parts: the lines or figures that it comes from."""
        number = Number(value)
        number.item = item
        number.sure = all(part.get("sure", True) if isinstance(part, dict) else getattr(part, "sure", True) for part in parts)
        return number

    def __truediv__(self, other):
        return Number.of(float(self) / other, self, other, item=self.item)

    def __rtruediv__(self, other):
        return Number.of(other / float(self), self, item=self.item)


def mark(number, text):
    return text if getattr(number, "sure", True) else WIDE


# ---- how numbers are written ----

def grouped(number):
    if number is None:
        return ABSENT
    return f"{int(number):,}".replace(",", " ")


def digits(number, count=2):
    """So many significant digits, and no exponent from 1000 on."""
    if number is None:
        return ABSENT
    text = grouped(float(f"{number:.{count}g}")) if abs(number) >= 999.5 else f"{float(f'{number:.{count}g}'):g}"
    if "e" not in text and " " not in text and abs(number) >= 0.1 and len(re.sub(r"[-.]|^0\.", "", text)) < count:
        text = f"{number:.{max(0, count - 1 - math.floor(math.log10(abs(number))))}f}"
    return mark(number, text)


def three(number):
    return digits(number, 3)


def dur(seconds, count=2):
    if seconds is None:
        return ABSENT
    scale, unit = (1, "s") if seconds >= 1 else (1e3, "ms") if seconds >= 1e-3 else (1e6, "µs")
    return mark(seconds, f"{float(f'{seconds * scale:.{count}g}'):g} {unit}")


def share(value):
    if value is None:
        return ABSENT
    return mark(value, f"{float(f'{100 * value:.2g}'):g} %")


def name(text):
    """What pages call a field, a class of rays or a workload."""
    parts = reversed(str(text).split("/"))
    return ", ".join(NAMES.get(part) or (f"{part}²" if part.isdigit() and int(part) > 64 else part) for part in parts)


def table(head, rows):
    align = ["r" if all(re.match(r"^([-−<≤≥]?[\d.]|n\. c\.|–|$)", str(row[k])) for row in rows) and k else "l" for k in range(len(head))]
    lines = [head, None, *rows]
    return "".join("|" + "".join("---|" if a == "l" else "--:|" for a in align) + "\n" if line is None else
                   "|" + "".join(f" {cell} |" if str(cell) != "" else " |" for cell in line) + "\n" for line in lines)


# ---- results ----

def right(line):
    """Whether rounding explains all of a contender's answers that differ."""
    return not line.get("agreement", {}).get("why", {}).get("other")


def alone(line):
    """The line for a figure that is no ratio: it may be quoted only if its own interval is narrow, too."""
    narrow = line.get("seconds_high", 1) <= 1.25 * line.get("seconds_low", 1)
    return {"sure": line.get("sure", True) and narrow}


class Rows(list):
    """Lines of results, and what text and values ask of them."""

    def where(self, test):
        code = compile(test, test, "eval")
        return Rows(line for line in self if of_line(code, line))

    def total(self, key):
        """Of a member, or of one in an object, as in verdicts.leak."""
        outer, _, inner = key.partition(".")
        return sum(line[outer][inner] if inner else line.get(key, 0) for line in self)

    def best(self, contender, **members):
        """The contender's line, of packet widths the best; of several lines of the plan the first. None if it was left out."""
        found = [line for line in self if contender in (line.get("contender"), line.get("group")) and "left_out" not in line and
                 all(line.get(key) == value for key, value in members.items())]
        first = min((line.get("line", 0) for line in found), default=0)
        return min((line for line in found if line.get("line", 0) == first),
                   key=lambda line: (not line.get("best_of_group", True), line.get("seconds_median", 0)), default=None)

    def faster(self, a="embree", b="default", **members):
        """How many times as long a takes as b, measured in turns; None if they were not."""
        for line in sorted({line.get("line", 0) for line in self if "seconds_median" in line}):
            pair = [self.best(name, line=line, **members) for name in (a, b)]
            if all(pair) and all("seconds_median" in of for of in pair):
                # The median of the rounds' ratios, which the machine's changes from round to round do not enter.
                above, below = (of.get("time_to_first", of["seconds_median"] / of.get("items", 1)) for of in pair)
                return Number.of(above / below, *pair, item=f"{name(pair[0]['item'])}, {name(pair[0]['field'])}")
        return None

    def ratios(self, a="embree", b="default", **members):
        """faster() for each workload that both have."""
        works = dict.fromkeys((line.get("workload"), line.get("isa")) for line in self)
        found = [self.faster(a, b, **{"workload": work, "isa": isa, **members}) for work, isa in works if isa == members.get("isa", isa)]
        return [number for number in found if number is not None]

    def timed(self, isa):
        """The cases that the headline is of: seven classes of rays on seven fields."""
        return Rows(line for line in self if line.get("item") in CLASSES and line.get("field") in LANDS).ratios(isa=isa)

    def value(self, contender, key, **members):
        line = self.best(contender, **members)
        return None if line is None or line.get(key) is None else Number.of(line[key], alone(line) if key.startswith(("s", "per_s")) else {})

    def rate(self, contender, **members):
        """Millions of items a second."""
        line = self.best(contender, **members)
        return None if line is None or "per_second" not in line else Number.of(line["per_second"] / 1e6, alone(line))

    def micro(self, contender, **members):
        """Microseconds an item."""
        rate = self.rate(contender, **members)
        return None if rate is None else 1 / rate

    def distinct(self, key):
        return list(dict.fromkeys(line[key] for line in self if key in line))


class Names(dict):
    """Members of a line, and the functions below; others are None."""
    def __missing__(self, key):
        return HELPERS.get(key, getattr(builtins, key, None))


def of_line(code, line):
    """An expression's value for a line; ABSENT where a member is needed that it has not."""
    try:
        return eval(code, {"__builtins__": {}}, Names(line))
    except TypeError:
        return None


def quotable(numbers):
    return [number for number in numbers if number.sure]


def lowest(numbers):
    return named(min(quotable(numbers), default=None))


def highest(numbers):
    return named(max(quotable(numbers), default=None))


def mean(numbers):
    """The geometric mean of those that have converged."""
    numbers = quotable(numbers)
    return Number(math.exp(sum(map(math.log, numbers)) / len(numbers))) if numbers else None


def named(number):
    return ABSENT if number is None else f"{digits(number)} ({number.item})"


def design(run):
    """What a run's CPU is called, whose own name may tell nothing."""
    return next((design for model, design in DESIGNS.items() if model in run["cpu"]), "an unknown design")


HELPERS = {f.__name__: f for f in (design, digits, three, dur, share, name, grouped, mean, quotable, lowest, highest)}
HELPERS.update(CLASSES=CLASSES, LANDS=LANDS)


class Data:
    """Files of papers/data, read once. The first line is the run."""

    def __init__(self, folder):
        self.folder, self.files, self.used = folder, {}, set()

    def path(self, file):
        path = os.path.join(self.folder, file + ".jsonl")
        return path if os.path.exists(path) else path[:-1]

    def __getitem__(self, file):
        self.used.add(os.path.relpath(self.path(file), self.folder))
        return self.read(self.path(file))

    def read(self, path):
        if path not in self.files:
            lines = []
            try:
                with open(path, encoding="utf-8") as text:
                    for number, line in enumerate(text, 1):
                        lines.append(json.loads(line))
            except json.JSONDecodeError as error:
                raise Problem(f"{path}:{number}: is not JSON: {error.msg}") from None
            except OSError as error:
                raise Problem(f"{path}: {error.strerror}") from None
            if not lines or lines[0].get("kind") != "run":
                raise Problem(f'{path}:1: results begin with an object of kind "run"')
            # sure: whether it may be quoted.
            self.files[path] = lines[0], Rows({**line, "sure": line.get("converged", True) and right(line)} for line in lines[1:])
        return self.files[path]

    def there(self):
        return sorted(os.path.relpath(os.path.join(at, file), self.folder) for at, _, files in os.walk(self.folder) for file in files)


def run_text(run):
    about = [run.get("cpu"), ISAS.get(run.get("isa"), run.get("isa")), "commit " + run["commit"] if run.get("commit") else None,
             f"Embree {run['embree']}" if run.get("embree") else
             None, f"load {run['load']:.2f}" if "load" in run else None, run.get("date", "")[:10]]
    return ", ".join(text for text in about if text)


# ---- blocks ----

def attributes(text):
    words = shlex.split(text)
    return {key: value for key, _, value in (word.partition("=") for word in words)}


def columns(text):
    return [tuple(part.strip().split("|", 1)) for part in text.split(";")]


def evaluate(code, rows, runs):
    methods = {method: getattr(rows, method) for method in ("faster", "ratios", "value", "timed", "micro", "rate", "total")}
    try:
        return eval(code, {**HELPERS, **methods, "run": runs[0], "runs": runs, "R": rows})
    except (TypeError, ValueError):  # a figure that is absent: sums with None, and the least of none
        return ABSENT


def written(value):
    return value if isinstance(value, str) else digits(value)


def pivot(rows, runs, a):
    def group(**members):
        return Rows(line for line in rows if all(str(line.get(a[key])) == str(of) for key, of in members.items()))

    rows_of, cols_of = (a[key + "_order"].split(",") if key + "_order" in a else rows.distinct(a.get(key)) for key in ("rows", "cols"))
    if "columns" in a:
        titles, codes = zip(*columns(a["columns"]), strict=True)
        body = [[written(evaluate(code, group(rows=row), runs)) for code in codes] for row in rows_of]
    else:
        titles, cells = map(name, cols_of), [[group(rows=row, cols=column) for column in cols_of] for row in rows_of]
        body = [[written(evaluate(a["value"], cell, runs) if cell else None) for cell in line] for line in cells]
    return table([a.get("head", ""), *titles], [[row if a["rows"] == "contender" else name(row), *line] for row, line in zip(rows_of, body, strict=True)])


def listing(rows, runs, a):
    titles, codes = zip(*columns(a["cols"]), strict=True)
    body = []
    for line in rows:
        cells = [of_line(code, {"run": runs[0], **line}) for code in codes]
        body.append(["" if cell is None else digits(Number.of(cell, line)) if isinstance(cell, float) else cell for cell in cells])
    return table(titles, body)


def made(kind, query, data):
    """The text of a block."""
    if kind == "files":
        return sources(data)
    first, _, template = query.partition("\n") if kind == "text" else (query, "", "")
    a = attributes(first)
    found = [data[file] for file in a["file"].split(",")]
    runs, rows = [run for run, _ in found], Rows(line for _, lines in found for line in lines)
    if "where" in a:
        rows = rows.where(a["where"])
    about = f"{run_text(runs[0])}.\n\n" if "about" in a else ""
    if kind == "text":
        return about + re.sub(r"\{(.+?)\}", lambda m: str(evaluate(m[1], rows, runs)), template.strip()) + "\n"
    if not rows:
        print(f'draw.py: no line of {a["file"]} has {a.get("where")}', file=sys.stderr)
        return ABSENT + "\n"
    return about + (pivot if kind == "table" else listing)(rows, runs, a)


def sources(data):
    """A line a file, by whom, of which commit and when."""
    body = []
    for file in data.there():
        run = data.read(os.path.join(data.folder, file))[0]
        made_by = f"{'cellwalk-bench' if run['command'] == 'measure' else run['command']} {run.get('arguments', '')}"
        load = f"{run['load']:.2f}" if "load" in run else ""
        body.append([f"[{file}](data/{file})", made_by, run.get("commit", "not recorded"), load, run.get("date", "")[:10]])
    return table(["file", "made by", "commit", "load", "date"], body)


def pages(root):
    return [os.path.join(root, "README.md"), *sorted(os.path.join(root, "papers", page) for page in os.listdir(
        os.path.join(root, "papers")) if page.endswith(".md"))]


def fill(path, data):
    """A page's text, and the same with all of its blocks made anew."""
    with open(path, encoding="utf-8") as file:
        text = file.read()

    def replace(match):
        try:
            return match[1] + made(match[2], match[3], data) + match[5]
        except Problem as problem:
            raise Problem(f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {problem}") from None
        except Exception as error:  # whatever an expression does
            raise Problem(f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {type(error).__name__}: {error}") from error
    return text, BLOCK.sub(replace, text)


def charts_of(text):
    for match in CHART.finditer(text):
        first, _, rest = match[1].strip().partition(" ")
        yield first, attributes(rest.replace("\n", " "))


def draw(root, data, found, check):
    """All charts; status."""
    try:
        import charts
    except ImportError:
        print("draw.py: charts are left out: they need matplotlib (Debian: python3-matplotlib)")
        return SKIPPED
    stale, folder = 0, os.path.join(root, "papers/pictures")
    for chart, a in found:
        run, rows = data[a["file"]]
        path = os.path.join(folder, chart + ".svg")
        text = charts.svg(chart, a, run, rows.where(a["where"]) if "where" in a else rows)
        try:
            with open(path, encoding="utf-8") as file:
                have = file.read()
        except OSError:
            have = ""
        if check and re.findall(r"Matplotlib v[\w.]+", have) != re.findall(r"Matplotlib v[\w.]+", text):
            print("draw.py: charts are not compared: another version of matplotlib drew them")
            return SKIPPED
        if check and have != text:
            print(f"{path}: is not what the data give")
            stale += 1
        elif have != text:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
    return 1 if stale else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a page or chart has other figures")
    parser.add_argument("--root", default=ROOT, help="where README.md and papers/ are")
    parser.add_argument("--only", choices=["text", "charts"], help="pages or pictures alone")
    o = parser.parse_args()
    data, stale, found = Data(os.path.join(o.root, "papers/data")), 0, []
    for path in pages(o.root):
        old, new = fill(path, data)
        found += charts_of(new)
        if o.only == "charts" or old == new:
            continue
        if not o.check:
            with open(path, "w", encoding="utf-8") as file:
                file.write(new)
            continue
        pairs = list(zip(old.split("\n"), new.split("\n"), strict=False))
        number, (have, want) = next(((k, pair) for k, pair in enumerate(pairs, 1) if pair[0] != pair[1]), (0, ("", "")))
        print(f"{path}:{number}: not what the data give\n  page: {have}\n  data: {want}")
        stale += 1
    status = draw(o.root, data, found, o.check) if o.only != "text" else 0
    unused = set(data.there()) - data.used
    if unused:
        raise Problem(f"{data.folder}: {', '.join(sorted(unused))}: no page uses this")
    return 1 if stale else status


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(f"draw.py: {problem}")
