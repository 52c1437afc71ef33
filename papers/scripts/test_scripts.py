#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the scripts, on small made-up results: what blocks say, what wrong input gives, and that --check notices an edited figure."""

import contextlib
import io
import json
import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import draw
import links
import prose
import renders

RUN = {"kind": "run", "command": "measure", "arguments": "measure x", "cpu": "Abacus", "isa": "avx2", "commit": "abc", "load": 0.5,
       "date": "2026-01-02T03:04:05Z"}


def line(contender, seconds, field="65", item="ao", converged=True, **more):
    group = contender.rsplit(":w", 1)[0]
    return {"kind": "result", "workload": f"{field}/{item}", "isa": "avx2", "field": field, "item": item, "contender": contender,
            "group": group, "line": 1, "items": 100, "seconds_median": seconds, "per_second": 100 / seconds, "converged": converged, **more}


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def fails(self, text, call, *arguments):
        with self.assertRaises(draw.Problem) as caught:
            call(*arguments)
        self.assertIn(text, str(caught.exception))

    def data(self, *lines, run=RUN):
        self.write("papers/data/a.jsonl", "".join(json.dumps(one) + "\n" for one in (run, *lines)))
        return draw.Data(self.path("papers/data"))


class Blocks(Folder):
    LINES = (line("default", 2), line("embree:w4", 6), line("embree:w8", 5), line("default", 3, field="257"),
             line("embree:w8", 9, field="257", converged=False))

    def test_ratios_take_the_fastest_width_and_leave_out_what_has_not_converged(self):
        query = 'file=a rows=item cols=field value="faster()" '
        self.assertIn("| ambient occlusion | 2.5 | n. c. |", draw.made("table", query, self.data(*self.LINES)))
        self.assertEqual(draw.made("text", "file=a\nLowest {lowest(ratios())}, mean {digits(mean(ratios()))}.", self.data(*self.LINES)),
                         "Lowest 2.5 (ambient occlusion, 65²), mean 2.5.\n")

    def test_a_pair_is_of_one_line_of_the_plan(self):
        data = self.data(line("default", 1, line=0), line("default", 2), line("embree:w8", 8))
        self.assertEqual(draw.made("text", "file=a\n{digits(faster())}", data), "4.0\n")

    def test_a_width_that_has_ended_is_not_the_best_and_wrong_answers_are_not_quoted(self):
        ended, wrong = line("embree:w4", 6, best_of_group=False), line("cell", 1, agreement={"why": {"other": 1}})
        data = self.data(line("default", 2), ended, line("embree:w8", 8, best_of_group=True), wrong)
        self.assertEqual(draw.made("text", "file=a\n{digits(faster())}, {digits(faster('cell'))}", data), "4.0, n. c.\n")

    def test_sums_and_titles_of_columns(self):
        data = self.data({"kind": "x", "by": "a", "n": 1200}, {"kind": "x", "by": "a", "n": 34, "m": {"k": 5}}, {"kind": "y"})
        query = """file=a where="kind == 'x'" rows=by head=by columns="n|grouped(total('n'))" """
        self.assertEqual(draw.made("table", query, data), "| by | n |\n|---|--:|\n| a | 1 234 |\n")
        query = """file=a where="kind == '{}'" cols="by|by; n|grouped(n); m|m and m['k'] or ''" """
        self.assertEqual(draw.made("list", query.format("x"), data), "| by | n | m |\n|---|--:|--:|\n| a | 1 200 | |\n| a | 34 | 5 |\n")
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(draw.made("list", query.format("z"), data), "–\n")
        self.assertIn("no line of a has", said.getvalue())

    def test_numbers(self):
        for number, text in ((0, "0"), (0.0123, "0.012"), (1, "1.0"), (5.88, "5.9"), (167, "170"), (12345, "12 000"), (1e-7, "1e-07")):
            self.assertEqual(draw.digits(number), text)
        self.assertEqual([draw.dur(s) for s in (3.2e-5, 0.0081, 12)], ["32 µs", "8.1 ms", "12 s"])
        self.assertEqual([draw.digits(None), draw.lowest([]), draw.dur(draw.mean([]))], ["–"] * 3)
        self.assertFalse((draw.Number(1) / draw.Number.of(2, {"sure": False})).sure)

    def test_wrong_files(self):
        self.write("papers/data/b.jsonl", "{}\n")
        self.write("papers/data/c.jsonl", json.dumps(RUN) + "\n{\n")
        data = draw.Data(self.path("papers/data"))
        self.fails("results begin with", data.__getitem__, "b")
        self.fails("c.jsonl:2: is not JSON", data.__getitem__, "c")
        self.fails("No such file", data.__getitem__, "d")


class Checking(Folder):
    def run_draw(self, *words):
        return subprocess.run([sys.executable, "-B", draw.__file__, "--root", self.folder.name, "--only", "text", *words],
                              capture_output=True, text=True)

    def test_check_agrees_then_notices_an_edited_figure_and_unused_data(self):
        self.data(*Blocks.LINES)
        self.write("README.md", "")
        page = self.write("papers/page.md", '<!-- table file=a rows=item cols=field value="faster()" -->\n<!-- end -->\n')
        self.assertEqual(self.run_draw().returncode, 0)
        self.assertEqual(self.run_draw("--check").returncode, 0)
        with open(page, encoding="utf-8") as file:
            text = file.read()
        self.write("papers/page.md", text.replace("2.5", "2.6"))
        done = self.run_draw("--check")
        self.assertEqual(done.returncode, 1)
        self.assertIn("page.md:4: not what the data give", done.stdout)
        self.write("papers/page.md", text.replace("faster()", "slower()"))
        self.assertIn("page.md:1: NameError", self.run_draw("--check").stderr)
        self.write("papers/page.md", text)
        self.write("papers/data/other.jsonl", json.dumps(RUN) + "\n")
        self.assertIn("other.jsonl: no page uses this", self.run_draw("--check").stderr)


class Layout(Folder):
    """What the check of a picture's layout finds, on small pictures with one fault each."""

    def setUp(self):
        super().setUp()
        try:
            import charts
            import layout
        except ImportError:
            self.skipTest("matplotlib is missing")
        from matplotlib import pyplot
        self.layout, self.charts = layout, charts
        self.figure, self.axes = pyplot.subplots(figsize=(4, 3))
        self.addCleanup(pyplot.close, self.figure)
        self.axes.plot([1, 2, 3], [1, 2, 3], "o-")

    def test_a_slower_width_does_not_stand_in_for_one_that_has_not_converged(self):
        a = {"kind": "bars", "title": "Bars", "rows": "item", "series": "Cellwalk|default|ours; Embree|embree|embree"}
        rows = [{**one, "sure": one["converged"]} for one in (line("default", 2), line("embree:w8", 4, converged=False), line("embree:w4", 5))]
        self.assertIn("(n. c. times as fast)", self.charts.svg("bars", a, RUN, draw.Rows(rows)))

    def finds(self, *texts):
        found = self.layout.faults(self.figure)
        self.assertEqual(len(found), len(texts), found)
        for text, fault in zip(texts, found):
            self.assertIn(text, fault)

    def test_points_and_bars(self):
        self.finds()
        self.axes.set_xlim(0.5, 2.5)
        self.finds("the point (3, 3) lies outside the axes")
        self.fails("chart: the point (3, 3)", self.layout.check, "chart", self.figure)
        self.axes.set_xlim(0.5, 3)  # the marker is cut in half
        self.finds("the point (3, 3)")
        self.axes.set_xlim(0.5, 3.5)
        self.axes.bar(2, 9)
        self.axes.set_ylim(-1, 5)
        self.finds("a bar lies outside")

    def test_labels(self):
        first = self.axes.text(2, 1.5, "first")
        self.finds()
        second = self.axes.text(2.05, 1.52, "second")
        self.finds('"second" overlaps "first"')
        second.remove()
        first.set_x(0.8)  # upon the numbers of the axis
        self.finds('"first" lies outside its axes', '"1.50" overlaps "first"')
        first.set_x(-9)
        self.finds('"first" lies outside the picture')


class Prose(unittest.TestCase):
    def test_finds_long_sentences_and_tics(self):
        page = ("# What\n\nA short one. " + "Word " * 36 + "end. Short, `a b c`.\n\n```\n" + "code " * 50 +
                "\n```\n\n| what | table |\n\n- It says what it does.\n- It skips what is far.\n- One: two; three.\n")
        found, counts = prose.warnings(page)
        self.assertEqual([line for line, _ in found], [3, 12, 13])
        self.assertEqual(counts, [3, 37, 2, 5, 5, 3])
        self.assertIn("a sentence of 37 words", found[0][1])
        self.assertIn('"what" as a noun', found[1][1])
        self.assertIn("a chain", found[2][1])


class Renders(Folder):
    def test_one_pixel_that_differs(self):
        if renders.image is None:
            self.skipTest("matplotlib is missing")
        picture = renders.np.random.default_rng(1).integers(0, 255, (5, 2, 3), "uint8")
        for name in ("a.png", "same.png", "other.png"):
            picture[3, 1] += name == "other.png"
            renders.image.imsave(self.path(name), picture)
        with contextlib.redirect_stdout(io.StringIO()):
            renders.compare("a.png", self.path("a.png"), self.path("same.png"))
        self.fails("1 pixels differ from what is rendered, by at most 1 of 255; the first is (1, 3)", renders.compare, "a.png",
                   self.path("a.png"), self.path("other.png"))


class Links(Folder):
    def test_links_headings_paths_and_names(self):
        self.write("src/a.c", "int cw_there(void);")
        self.write("papers/b.md", "# One thing: two\n")
        page = self.write("papers/a.md", "[b](b.md) [h](b.md#one-thing-two) `src/a.c` `src/*.c`\n```\n[x](gone.md)\n```\n"
                          "[no](b.md#three)\n[gone](c.md) `src/gone.c` [web](https://x.org/)\n"
                          "`cw_there`, `CW_NEEDS_...` and `cw_gone()`\n")
        self.assertEqual(list(links.missing(page, self.folder.name, links.known_names(self.folder.name))),
                         [(5, "b.md#three"), (6, "c.md"), (6, "src/gone.c"), (7, "cw_gone")])


if __name__ == "__main__":
    unittest.main()
