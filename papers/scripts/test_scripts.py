#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the scripts, on small made-up results: what tables say, what wrong input gives, and that --check notices an
edited figure."""

import contextlib
import io
import json
import os
import struct
import sys
import tempfile
import unittest
import zlib
from unittest import mock

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import beside_pbrt
import blocks_accuracy
import blocks_scenes
import blocks_speed
import blocks_stability
import blocks_tradeoff
import links
import markdown
import names
import pictures
import prose
import renders
import results
import tables

RUN = {"kind": "run", "command": "micro", "cpu": "Abacus", "isa": "avx2", "compiler": "GNU 12", "build_type": "Release",
       "commit": "abc", "seed": 1, "load": 0.5, "date": "2026-01-02T03:04:05Z", "embree": "3.13.5", "embree_assertions": True}


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

    def results(self, *lines, name="data.json", run=None):
        path = self.write(name, "".join(json.dumps(line) + "\n" for line in (run or RUN, *lines)))
        return results.Results(path)

    def fails(self, text, call, *arguments):
        with self.assertRaises(results.Problem) as caught:
            call(*arguments)
        self.assertIn(text, str(caught.exception))


def speed(field, rays, contender, mrays, threads=1):
    return {"kind": "result", "field": field, "rays": rays, "contender": contender, "threads": threads, "mrays_per_s": mrays,
            "seconds_min": 1 / mrays}


class ReadingResults(Folder):
    def test_names_file_line_and_key(self):
        read = self.results({"kind": "result", "field": "65", "mrays_per_s": "fast"})
        line = read.of("result")[0]
        self.fails('data.json:2: has no key "rays"', line.text, "rays")
        self.fails('data.json:2: "mrays_per_s" is "fast"; want a number', line.number, "mrays_per_s")
        self.fails('data.json:2: "field" is "65"; want a number', line.number, "field")
        self.assertEqual(line.number("absent", 7), 7)

    def test_wrong_files(self):
        self.fails("is not JSON", results.Results, self.write("a.json", json.dumps(RUN) + "\n{nonsense\n"))
        self.fails("b.json:1: not results", results.Results, self.write("b.json", '{"kind":"result"}\n'))
        self.fails("c.json:2: is not a JSON object", results.Results, self.write("c.json", json.dumps(RUN) + "\n[1]\n"))
        self.fails("none.json: No such file", results.Results, self.path("none.json"))
        self.fails("empty.json:1: not results", results.Results, self.write("empty.json", ""))


class Markdown(Folder):
    def test_tables_and_numbers(self):
        self.assertEqual(markdown.table(["", "n"], [["a", 1], ["b", ""]]), "| | n |\n|---|--:|\n| a | 1 |\n| b | |\n")
        self.assertEqual([markdown.grouped(1234567), markdown.three(0.1284), markdown.three(999.7), markdown.three(51172)],
                         ["1 234 567", "0.128", "1 000", "51 200"])
        self.assertEqual([markdown.listed("abc"), markdown.listed({"a": 1})], ["a, b and c", "a"])
        self.assertEqual([markdown.duration(0.0000347), markdown.duration(0.134), markdown.duration(105.2)],
                         ["34.7 µs", "134 ms", "105 s"])
        self.assertEqual([markdown.ratio(3, 2), markdown.ratio(3, 0), markdown.ratio(None, 1)], ["1.50", "", ""])

    def test_pages(self):
        page = markdown.Page(self.write("page.md", "top\n<!-- begin:x -->\nold\n<!-- end:x -->\nend\n"))
        self.assertEqual(page.names(), ["x"])
        self.assertIsNone(page.difference("x", "old\n"))
        self.assertEqual(page.difference("x", "new\n"), (3, "old", "new"))
        self.assertEqual(page.difference("x", "old\nmore\n"), (4, "", "more"))
        page.put("x", "new\n")
        page.save()
        self.assertEqual(markdown.Page(page.path).text, "top\n<!-- begin:x -->\nnew\n<!-- end:x -->\nend\n")
        self.fails("has 0 lines <!-- begin:y -->", page.span, "y")
        self.fails("stands before", markdown.Page(self.write("b.md", "<!-- end:x -->\n<!-- begin:x -->\n")).span, "x")


class Speeds(Folder):
    def test_own_kernel_over_the_fastest_width(self):
        read = self.results(
            {"kind": "field", "field": "65", "default_kernel": "pyramid8"},
            speed("65", "ao", "pyramid8/watertight", 8, threads=2), speed("65", "ao", "pyramid8/watertight", 6),
            speed("65", "ao", "pyramid8x2/watertight", 9), speed("65", "ao", "embree/triangles/w1", 2),
            speed("65", "ao", "embree/triangles/w8", 3), speed("65", "ao", "embree/triangles-robust/w8", 100))
        self.assertEqual(blocks_speed.over_embree(read, "65", "ao"), 2)
        self.assertEqual(blocks_speed.over_embree(read, "65", "primary"), 0)
        self.assertEqual(blocks_speed.micro(read).splitlines()[-1], "| ao | 9 `pyramid8x2` |")

    def test_the_lowest_is_the_lowest_of_all_fields(self):
        of = {("65", "ao"): 0.5, ("257", "ao"): 2, ("sea-calm", "ao"): 4}
        lines = [{"kind": "field", "field": field, "default_kernel": "k"} for field, _ in of]
        for (field, rays), value in of.items():
            lines += [speed(field, rays, "k/w", value), speed(field, rays, "embree/triangles/w8", 1)]
        self.results(*lines, name="speed-avx2.json")
        self.results(name="building.json")
        text = blocks_speed.summary(results.Data(self.folder.name))
        self.assertIn("1.59 times that of Embree 3.13.5 (Debian's build, with assertions) with AVX2", text)
        self.assertIn("Lowest of all: 0.50 (ambient occlusion, 65²). Highest: 4.00 (ambient occlusion, calm sea).", text)
        self.assertIn("Embree is faster in 1 of 3 cases", text)

    def test_afar(self):
        text = blocks_speed.afar(self.results(speed("65", "random", "k/w", 10), speed("65", "random+5", "k/w", 8)))
        self.assertIn("| field | 0 | 5 |", text)
        self.assertIn("| 65² | 10 | 8 (1.25) |", text)
        self.assertIn("at most 1.25 (65², 5)", text)

    def test_classes_that_older_results_lack(self):
        self.assertEqual(names.classes(self.results(speed("65", "random", "k/w", 1), speed("65", "ao", "k/w", 1))), ["ao", "random"])

    def test_threads(self):
        self.results(speed("65", "ao", "k/w", 10), speed("65", "ao", "k/w", 19, threads=2), name="threads.json",
                     run={**RUN, "cpus": 2})
        self.assertIn("| 2 | ao | 1.90 |", blocks_speed.threads(results.Data(self.folder.name)))


class Accuracy(Folder):
    def line(self, mode, rays, wrong, off, kernel="k"):
        zero = {f"{key}_per_million": 0 for key in ("leaks", "phantoms", "wrong", "broken")}
        spread = {f"{key}_{of}": off for key in blocks_accuracy.ERRORS for of in ("median", "worst")}
        return {"kind": "result", "contender": f"{mode}/{kernel}", "mode": mode, "kernel": kernel, "field": "65", "rays": rays,
                **zero, **spread, "leaks_per_million": wrong}

    def test_means_and_the_best_of_each_mode(self):
        lines = []
        for mode, kernel, wrong in (("exact", "k", 0), ("embree", "w4", 100), ("embree", "w8", 90)):
            lines += [self.line(mode, "ao", wrong, 1e-4, kernel), self.line(mode, "edges", 3 * wrong, 1e-4, kernel)]
        lines.append(self.line("part", "ao", 0, 1e-4))
        read = self.results(*lines, run={**RUN, "rays_a_class": 8})
        best = blocks_accuracy.best_of_modes(blocks_accuracy.summaries(read))
        self.assertEqual({mode: s.kernel for mode, s in best.items()}, {"exact": "k", "embree": "w8"})  # part: not everywhere
        self.assertEqual((best["embree"].ordinary, best["embree"].aimed, best["embree"].wrong), (90, 270, 180))
        self.assertIn("| embree | 90 | 0 | 0 | 270 |", blocks_accuracy.errors(read))

    def test_the_summary_is_about_the_default_kernel(self):
        def lines(kernel, aimed):
            return [self.line("strict", rays, aimed, 1, kernel) for rays in ("ao", "edges")]
        self.results(*lines("fast", 5), *lines("k", 2), name=blocks_accuracy.FILE, run={**RUN, "rays_a_class": 8})
        data = results.Data(self.folder.name)
        self.fails("no result of the default kernel", blocks_accuracy.accuracy, data)
        self.results({"kind": "field", "field": "1025", "default_kernel": "k"}, name="speed-avx2.json")
        self.assertIn("edges: 2 for the default kernel. Each traced 8 rays.",
                      blocks_accuracy.accuracy(results.Data(self.folder.name)))

    def test_from_afar_t_tells_no_place_and_short_rays_are_for_precision(self):
        read = self.results(self.line("exact", "ao", 0, 1e-4), self.line("exact", "afar", 0, 1), self.line("exact", "within-2", 5, 9))
        (exact,) = blocks_accuracy.summaries(read)
        self.assertEqual((exact.worst["off_cells"], exact.ordinary, exact.partial), (1e-4, 0, False))


class Tradeoff(Folder):
    def surface(self, asked, got):
        return {"kind": "coarser", "field": "65", "filter": "mean", "factor": 2, "above": asked, "got_above": got, "below": 0,
                "got_below": 0, "rms": 1, "got_rms": 1}

    def test_a_broken_promise_is_an_error(self):
        self.assertIn("| 65² | mean | 2 | 0.5 / 0.4 |", blocks_tradeoff.promises(self.results(self.surface(0.5, 0.4))))
        self.fails("factor 2: the surface is farther off than promised", blocks_tradeoff.promises,
                   self.results(self.surface(0.5, 0.6)))

    def test_views_stand_beside_strict_and_embrees_fastest_width(self):
        def line(contender, factor, mrays):
            return {"kind": "rays", "field": "65", "contender": contender, "factor": factor, "mrays_per_s": mrays, "t_median": 0.02,
                    "t_99": 1e-7, "cells_median": 1, "differ_per_million": 3}
        read = self.results(line("strict", 1, 10), line("coarser", 2, 25), line("embree", 0, 4), line("embree", 0, 5),
                            run={**RUN, "ray_count": 8})
        text = blocks_tradeoff.view_trade(read)
        self.assertIn("| | coarser 2 | 25 | 2.50 | 2 % | 1.0e-07 | 1 | 3 |", text)
        self.assertIn("| | Embree | 5 | 0.50 |", text)

    def test_pictures_stand_by_resolution(self):
        def line(samples, factor, rmse):
            return {"kind": "picture", "field": "65", "samples_a_pixel": samples, "factor": factor, "rmse": rmse,
                    "seconds": 0.002}
        text = blocks_tradeoff.picture_trade(self.results(line(1, 2, 0.3), line(1, 1, 0.1)))
        self.assertIn("| samples a pixel | full | coarser 2 |", text)
        self.assertIn("| 1 | 0.1 / 2 ms | 0.3 / 2 ms |", text)

    def test_the_help_is_a_string_of_short_lines(self):
        text = blocks_tradeoff.c_text("NAME", "word " * 40)
        self.assertTrue(text.startswith('#define NAME \\\n    "word word'))
        self.assertTrue(text.endswith('word\\n"\n'))
        self.assertTrue(all(len(line) < 90 for line in text.split("\n")))


class Stability(Folder):
    def part(self, name, first, end, **counts):
        line = {"kind": "result", "contender": "k/watertight", "role": "reference", "rays": "vertex", "traced": 10, "hits": 10,
                "pass": 10, "leaks": 0, "phantoms": 0, "sampled": 2, "residual": 0.5, "apart": 0.1, "t_error": 0.2,
                "other_bits": 0, "verdicts": {"right": 2, "tie": 0, "wrong_surface": 0}, "t_error_ulp": [1, 1], **counts}
        run = {**RUN, "command": "stability", "part": 1, "parts": 1, "first": first, "end": end, "sample": 5, "seconds": 1}
        return self.results(line, name=name, run=run)

    def test_parts_add_up_and_never_twice(self):
        a, b = self.part("a.json", 0, 4, residual=0.9), self.part("b.json", 4, 8, leaks=1)
        text = blocks_stability.stability([a, b])
        self.assertIn("| `k` | 20 | 20 | 1 | 0 | 4 | 0 |", text)
        self.assertIn("| at a sample | 0.90 | 0.10 | 0.20 | 0.5 | 50 000 |", text)
        self.fails("c.json:1: batches 2 to 3 are also in", blocks_stability.stability, [a, self.part("c.json", 2, 3)])
        self.fails('"rays" is "odd", an unknown class', blocks_stability.stability, [self.part("d.json", 0, 1, rays="odd")])

    def test_says_whether_the_default_kernel_took_part(self):
        a = self.part("a.json", 0, 4)
        self.assertNotIn("default", blocks_stability.stability([a], "k"))
        self.assertIn("another default kernel, `other`. It took no part", blocks_stability.stability([a], "other"))

    def test_files_without_commit_say_so(self):
        line = {"kind": "stress", "rays": "ao", "traced": 1, "hits": 1, "answers": 1, "other_bits": 0}
        text = blocks_stability.stress(self.results(line, run={"kind": "run", "command": "stress"}))
        self.assertIn("records neither commit nor machine", text)
        run = {"kind": "run", "command": "stress", "commit": "abc", "date": "2026-01-02T03:04:05Z"}
        self.assertIn("Commit abc, 2026-01-02", blocks_stability.stress(self.results(line, run=run)))

    def test_extremes_count_what_is_not_as_expected(self):
        line = {"kind": "extreme", "item": "spikes", "expected": "a hit", "kernel": "k", "leaf": "watertight", "asked": 10,
                "as_expected": 9, "slipped": 0, "parallel": 0}
        self.assertIn("10 answers, **1** not as expected", blocks_stability.extremes(self.results(line)))
        self.fails("is excused", blocks_stability.extremes, self.results({**line, "slipped": 1}))


class Checking(Folder):
    """tables.py as it is called, on a page with one table."""

    def setUp(self):
        super().setUp()
        self.results(speed("65", "ao", "k/w", 10), speed("65", "ao", "k/w", 19, threads=2), name="papers/data/threads.json",
                     run={**RUN, "cpus": 2})
        self.write("README.md", "intro\n<!-- begin:install -->\nsh\n<!-- end:install -->\n")
        self.write("papers/page.md", "text\n<!-- begin:threads -->\n<!-- end:threads -->\n")

    def call(self, *arguments):
        out = io.StringIO()
        with mock.patch.object(tables, "BLOCKS", {"threads": blocks_speed.threads}), \
                mock.patch.object(tables, "FILES", {}), contextlib.redirect_stdout(out), \
                mock.patch.object(sys, "argv", ["tables.py", "--root", self.folder.name, *arguments]):
            tables.main()
        return out.getvalue()

    def test_check_agrees_then_notices_an_edited_figure(self):
        self.call()
        self.assertEqual(self.call("--check"), "")
        page = self.path("papers/page.md")
        with open(page, encoding="utf-8") as file:
            text = file.read()
        self.write("papers/page.md", text.replace("1.90", "2.90"))
        out = io.StringIO()
        with contextlib.redirect_stdout(out), self.assertRaises(results.Problem):
            tables.check([(markdown.Page(page), "threads", text.split("-->\n")[1].split("<!--")[0])], self.folder.name)
        self.assertIn("papers/page.md:7: threads is not what the data give\n"
                      "  page: | 2 | ao | 2.90 |\n  data: | 2 | ao | 1.90 |", out.getvalue())
        self.fails("1 tables are out of date", self.call, "--check")

    def test_a_misspelt_or_lost_block(self):
        self.write("papers/page.md", "<!-- begin:thread -->\n<!-- end:thread -->\n")
        self.fails("there is no table thread", self.call, "--check")
        self.write("papers/page.md", "nothing\n")
        self.fails("no page has the table threads", self.call, "--check")

    def test_an_own_run_goes_into_a_page(self):
        data = self.results(speed("65", "ao", "k/w", 10), name="own.json").path
        page = self.write("own.md", "<!-- begin:micro -->\n<!-- end:micro -->\n")
        self.call("--data", data, "--into", page)
        self.assertIn("| ao | 10 `k` |", markdown.Page(page).text)
        self.assertIn("| ao | 10 `k` |", self.call("--data", data))
        self.fails("there is no table of these", self.call, "--data", self.results(run={**RUN, "command": "odd"}).path)


class Pictures(Folder):
    def test_check_notices_an_edited_picture(self):
        if pictures.matplotlib is None:
            self.skipTest("matplotlib is missing")
        with mock.patch.object(pictures, "load", lambda: {"a": lambda data: "figure"}), \
                mock.patch.object(pictures, "svg", lambda name, figure: version + "<b/>\n"):
            version = f"<Matplotlib v{pictures.matplotlib.__version__}>\n"
            self.write("a.svg", version + "<b/>\n")
            self.assertEqual(pictures.check(self.folder.name, None), 0)
            self.write("a.svg", version + "<c/>\n")
            self.fails("a.svg:2: is not what the data give", pictures.check, self.folder.name, None)
            self.write("b.svg", version)
            self.fails("b.svg: is none that pictures.py draws", pictures.check, self.folder.name, None)

    def test_another_version_is_skipped(self):
        self.write("a.svg", "Matplotlib v0.0.1\n")
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(pictures.check(self.folder.name, None), pictures.SKIPPED)


class Layout(Folder):
    """What the check of a picture's layout finds, on small pictures with one fault each."""

    def setUp(self):
        super().setUp()
        if pictures.matplotlib is None:
            self.skipTest("matplotlib is missing")
        pictures.load()
        import layout
        from matplotlib import pyplot
        self.layout = layout
        self.figure, self.axes = pyplot.subplots(figsize=(4, 3))
        self.addCleanup(pyplot.close, self.figure)
        self.axes.plot([1, 2, 3], [1, 2, 3], "o-")

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
        first = self.axes.annotate("first", (2, 2), (6, -10), textcoords="offset points")
        self.finds()
        second = self.axes.annotate("second", (2, 2), (9, -12), textcoords="offset points")
        self.finds('"second" overlaps "first"')
        second.remove()
        first.set_position((-130, 0))  # upon the numbers of the axis
        self.finds('"first" lies outside its axes', '"2.00" overlaps "first"')
        self.layout.beside(first)
        self.finds('"2.00" overlaps "first"')
        first.set_position((-500, 0))
        self.finds('"first" lies outside the picture')

    def test_labels_find_free_places(self):
        self.axes.margins(0.3)
        points = [(2, 2), (2.05, 2.05), (2, 2.1)]
        for point in points:
            self.axes.plot(*point, "o")
        self.layout.label_points(self.axes, [(f"label {k}", point, "black") for k, point in enumerate(points)], fontsize=8)
        self.finds()
        with self.assertRaisesRegex(results.Problem, "no free place"):
            self.layout.label_points(self.axes, [("wide " * 40, (2, 2), "black")])

    def test_limits_hold_the_values(self):
        low, high = self.layout.log_limits([1, 100])
        self.assertTrue(0 < low < 1 and high > 100)


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
    def png(self, name, rows, kinds):
        """Rows of bytes, each already filtered as its kind says."""
        raw = b"".join(bytes([kind]) + bytes(row) for kind, row in zip(kinds, rows))
        parts = [(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(raw)),
                 (b"IEND", b"")]
        with open(self.path(name), "wb") as file:
            file.write(b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(body)) + kind + body + bytes(4)
                                                       for kind, body in parts))
        return self.path(name)

    def test_every_filter_and_one_pixel_that_differs(self):
        rows = [[1, 2, 3, 4, 6, 8], [1, 2, 3, 3, 4, 5], [9, 9, 9, 9, 9, 9], [5, 5, 5, 1, 1, 1], [252, 0, 0, 0, 0, 3]]
        wanted = [(1, 2, 3, 4, 6, 8), (1, 2, 3, 4, 6, 8), (10, 11, 12, 13, 15, 17), (10, 10, 11, 12, 13, 15),
                  (6, 10, 11, 6, 13, 18)]  # Paeth's guess for the fourth: left and corner are as near, left is first
        width, height, found = renders.pixels(self.png("a.png", rows, range(5)))
        self.assertEqual((width, height, [tuple(row) for row in found]), (2, 5, wanted))
        other = [list(row) for row in wanted]
        other[3][4] += 2
        with contextlib.redirect_stdout(io.StringIO()):
            renders.compare("a.png", self.path("a.png"), self.png("same.png", wanted, [0] * 5))
        self.fails("1 pixels differ from what is rendered, by at most 2 of 255; the first is (1, 3)", renders.compare, "a.png",
                   self.path("a.png"), self.png("other.png", other, [0] * 5))


class Links(Folder):
    def test_links_headings_paths_and_names(self):
        self.write("src/a.c", "int cw_there(void);")
        self.write("papers/b.md", "# One thing: two\n")
        page = self.write("papers/a.md", "[b](b.md) [h](b.md#one-thing-two) `src/a.c` `src/*.c`\n```\n[x](gone.md)\n```\n"
                          "[no](b.md#three)\n[gone](c.md) `src/gone.c` [web](https://x.org/)\n"
                          "`cw_there`, `CW_NEEDS_...` and `cw_gone()`\n")
        self.assertEqual(list(links.missing(page, self.folder.name, links.known_names(self.folder.name))),
                         [(5, "b.md#three"), (6, "c.md"), (6, "src/gone.c"), (7, "cw_gone")])


class BesidePbrt(Folder):
    SCENE = ('Film "image" "string filename" ["a.exr"] \n"integer xresolution" [40] "integer yresolution" 30\n'
             'Camera "perspective"\n')

    def test_film_is_replaced_and_nothing_else(self):
        for one_pixel, x, y in ((False, 40, 30), (True, 1, 1)):
            self.assertEqual(beside_pbrt.with_film(self.SCENE, one_pixel, "b.exr"),
                             f'Film "image" "string filename" ["b.exr"] "integer xresolution" [{x}] '
                             f'"integer yresolution" [{y}]\nCamera "perspective"\n')
        self.fails("2 films", beside_pbrt.with_film, self.SCENE * 2, False, "b.exr")

    def test_table(self):
        line = {"kind": "scene", "scene": "sea", "rounds": 9, "pbrt_seconds": 4.0, "pbrt_pixel_seconds": 1.0,
                "pbrt_mib": 700.4, "cellwalk_seconds": 0.25, "cellwalk_pixel_seconds": 0.05, "cellwalk_mib": 20.0}
        name = "scenes/pbrt.json"
        self.results(line, line | {"scene": "land", "pbrt_seconds": 1.0}, name=name, run=RUN | {"pbrt": "built so"})
        text = blocks_scenes.pbrt(results.Data(self.folder.name))
        self.assertIn("| sea | 4.00 | 0.250 | 16.0 | 1.00 | 0.050 | 700 | 20 |", text)
        self.assertIn("pbrt-v2: built so.", text)
        self.assertIn("Geometric mean of the ratios: 8.0.", text)
        self.assertIn("8.0 times the speed of pbrt-v2, geometric mean over 2 scenes, from 4.0 to 16.0",
                      blocks_scenes.beside_pbrt(results.Data(self.folder.name)))

    def test_column_beside_the_scenes(self):
        path = {"path": "auto-phong", "title": "cellwalk, Phong", "by": "cell/watertight", "seconds_median": 0.5,
                "time_to_default": 0.8, "trace_mrays_per_s": 40.0}
        lines = [{"kind": "scene", "scene": name, "paths": [path]} for name in ("sea", "land")]
        self.assertIn("| sea | 0.500 (0.80) |", blocks_scenes.times(self.results(*lines)))
        lines[0]["pbrt_ratio"] = 16.04
        text = blocks_scenes.times(self.results(RUN | {"kind": "pbrt", "pbrt": "built so"}, *lines))
        self.assertIn("| scene | pbrt-v2 | cellwalk, Phong |", text)
        self.assertIn("| sea | 16.0 x | 0.500 (0.80) |", text)
        self.assertIn("| land | | 0.500 (0.80) |", text)
        self.assertIn("another run: Abacus, avx2, commit abc", text)


if __name__ == "__main__":
    unittest.main()
