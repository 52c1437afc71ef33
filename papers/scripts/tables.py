#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables of README.md and papers/*.md, from the results in papers/data. A table stands in a page between the lines
<!-- begin:NAME --> and <!-- end:NAME -->; the same results give the same text."""

import argparse
import glob
import os
import sys

import blocks_accuracy
import blocks_python
import blocks_scenes
import blocks_speed
import blocks_stability
import blocks_terrain
import blocks_tradeoff
import names
from markdown import Page, table
from results import Data, Problem, Results

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Blocks of pages that are no tables: commands and a program, which tests read.
NOT_TABLES = {"install", "test", "example", "python"}

# What a file of results becomes, by the command that made it.
OWN = {
    "table": blocks_scenes.times, "tradeoff": blocks_tradeoff.page, "accuracy": blocks_accuracy.page, "micro": blocks_speed.micro,
    "afar": blocks_speed.afar, "leaf": blocks_stability.leaf, "extremes": blocks_stability.extremes,
    "exhaustive": blocks_stability.exhaustive, "stress": blocks_stability.stress,
}
# Files of results, and what makes those that do not say by which arguments they were made.
SOURCES = {
    **dict.fromkeys(names.SPEED_FILES.values()), "peers.json": None, "embree4.json": None, "beside.json": None, "beside-single.json": None,
    "threads.json": None,
    "building.json": None, "python.json": "papers/scripts/python_speed.py",
    "python_dask.json": "papers/scripts/python_dask.py",
    "terrain.json": "papers/scripts/terrain.py",
    "terrain-more.json": "papers/scripts/terrain.py --more", "visibility.json": "papers/scripts/visibility.py", "scenes/table.json": None,
    "scenes/pbrt.json": "papers/scripts/beside_pbrt.py",
    "rays/tradeoff.json": None, "tradeoff/tradeoff.json": None, "accuracy/accuracy.json": None, "afar.json": None,
    "stability/aimed-1.json": "cellwalk-stability run --part 1/2", "stability/aimed-2.json": "cellwalk-stability run --part 2/2",
    "stability/extremes.json": "--target stability-extremes",
    "stability/exhaustive.json": "--target stability-exhaustive", "stability/stress.json": "--target stability-stress",
    "stability/leaf.json": None,
}


def sources(data):
    rows = []
    for name, made_by in SOURCES.items():
        if data.get(name):
            run = data[name].run
            command = made_by or "cellwalk-bench " + run.text("arguments")
            load = f"{run.number('load'):.2f}" if "load" in run else ""
            rows.append([f"[{name}](data/{name})", f"`{command}`", run.text("isa", ""), run.text("commit", "not recorded"), load,
                         run.text("date", "")[:10]])
    unknown = data.files_there() - SOURCES.keys()
    if unknown:
        raise Problem(f"{data.folder}: {', '.join(sorted(unknown))}: no page says what made this")
    return table(["file", "made by", "up to", "commit", "load", "date"], rows, "llllrl")


def from_file(name, make):
    return lambda data: make(data[name])


BLOCKS = {
    "summary": lambda data: blocks_speed.summary(data) + blocks_scenes.beside_pbrt(data) + blocks_accuracy.accuracy(data),
    "table": from_file("scenes/table.json", blocks_scenes.times),
    "stability": lambda data: blocks_stability.stability(
        [data[f"stability/aimed-{part}.json"] for part in (1, 2)],
        # Before version 0.2 the names of pairs had a suffix.
        blocks_speed.default_kernel(data, data["stability/aimed-1.json"].run.text("isa")).removesuffix("x2")),
    **{name: from_file(f"stability/{name}.json", OWN[name]) for name in ("extremes", "exhaustive", "stress", "leaf")},
    "terrain_areas": from_file("visibility.json", blocks_terrain.terrain_areas),
    "afar": from_file("afar.json", blocks_speed.afar),
    "python_chunks": from_file("python_dask.json", blocks_python.python_chunks),
    "python_calls": from_file("python.json", blocks_python.python_calls),
    **{make.__name__: make for make in (
        blocks_speed.speeds, blocks_speed.newer_embree, blocks_speed.beside, blocks_speed.rates, blocks_speed.targets, blocks_speed.peers,
        blocks_speed.threads, blocks_speed.building,
        blocks_scenes.coursework, blocks_scenes.pbrt,
        blocks_tradeoff.choices, blocks_tradeoff.choices_short, blocks_tradeoff.horizon_trade, sources)},
    **{make.__name__: from_file(blocks_accuracy.FILE, make) for make in (
        blocks_accuracy.errors, blocks_accuracy.normals)},
    **{make.__name__: from_file(blocks_tradeoff.RAYS_FILE, make) for make in (
        blocks_tradeoff.promises, blocks_tradeoff.view_trade)},
    **{make.__name__: from_file(blocks_tradeoff.FILE, make) for make in (
        blocks_tradeoff.sky_trade, blocks_tradeoff.picture_trade)},
    **{make.__name__: from_file(blocks_terrain.FILE, make) for make in (
        blocks_terrain.terrain_speed, blocks_terrain.terrain_views, blocks_terrain.terrain_horizons,
        blocks_terrain.terrain_maps, blocks_terrain.terrain_suns)},
    **{make.__name__: from_file(blocks_terrain.MORE, make) for make in (
        blocks_terrain.terrain_more, blocks_terrain.terrain_needed, blocks_terrain.terrain_days)},
}

# Whole files, from the same figures.
FILES = {"src/tool/options/trade.h": blocks_tradeoff.help_header}


class File(Page):
    """A file that is one block."""

    def span(self, name):
        return 0, len(self.text)


def pages(root):
    return [Page(path) for path in [os.path.join(root, "README.md"), *sorted(glob.glob(os.path.join(root, "papers/*.md")))]]


def fill(root, data):
    """All blocks of all pages, in memory: (page, name, text)."""
    fills = [(page, name, None) for page in pages(root) for name in page.names() if name not in NOT_TABLES]
    for page, name, _ in fills:
        if name not in BLOCKS:
            raise Problem(f"{page.path}: there is no table {name}; there are {', '.join(sorted(BLOCKS))}")
    missing = BLOCKS.keys() - {name for _, name, _ in fills}
    if missing:
        raise Problem(f"no page has the table {', '.join(sorted(missing))}")
    made = {name: BLOCKS[name](data) for name in BLOCKS}
    files = [(File(os.path.join(root, name)), name, make(data)) for name, make in FILES.items()]
    return [(page, name, made[name]) for page, name, _ in fills] + files


def check(fills, root):
    stale = 0
    for page, name, text in fills:
        difference = page.difference(name, text)
        if difference:
            number, have, want = difference
            stale += 1
            print(f"{os.path.relpath(page.path, root)}:{number}: {name} is not what the data give\n"
                  f"  page: {have}\n  data: {want}")
    if stale:
        raise Problem(f"{stale} tables are out of date; papers/scripts/tables.py makes them again")


def own_run(paths, into, block):
    """The table of one file, or of several parts of a long run."""
    files = [Results(path) for path in paths]
    name = files[0].run.text("command")
    if name == "stability":
        text = blocks_stability.stability(files)
    else:
        if len(files) > 1:
            raise Problem(f"{paths[1]}: only runs of cellwalk-stability can be added up")
        if block in ("afar",):
            name = block
        elif name == "micro":
            name = "leaf" if block == "leaf" else "micro"
        if name not in OWN:
            raise Problem(f"{paths[0]}:1: results of {name}: there is no table of these")
        text = OWN[name](files[0])
    if into is None:
        print(text, end="")
        return
    page = Page(into)
    page.put(block or name, text)
    page.save()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a page has other figures")
    parser.add_argument("--root", default=ROOT, help="where README.md and papers/ are")
    parser.add_argument("--data", nargs="+", metavar="FILE",
                        help="instead: the table of an own run, such as out/table/table.json, printed unless --into")
    parser.add_argument("--into", metavar="PAGE", help="with --data: the page to put it into")
    parser.add_argument("--block", metavar="NAME", help="with --data: the block's name, if not that of the command")
    options = parser.parse_args()
    if options.data:
        own_run(options.data, options.into, options.block)
        return
    fills = fill(options.root, Data(os.path.join(options.root, "papers/data")))
    if options.check:
        check(fills, options.root)
        return
    for page, name, text in fills:
        page.put(name, text)
    for page in {page.path: page for page, _, _ in fills}.values():
        page.save()


if __name__ == "__main__":
    try:
        main()
    except Problem as problem:
        sys.exit(f"tables.py: {problem}")
