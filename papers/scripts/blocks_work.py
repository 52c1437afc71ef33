# SPDX-License-Identifier: Apache-2.0
"""Tables of work: what the walks do for a ray, what each lever saves, cache misses, pages, and where the time goes."""

from blocks_speed import matrix, own, speed
from markdown import ratio, table
from results import geometric_mean, run_text


def counts_of(results, field, rays, kernel):
    """What a kernel counted, whatever its leaf test."""
    for line in results.of("counts", field=field, rays=rays):
        if line.text("contender").split("/")[0] == kernel:
            return line
    return None


def a_ray(line, kind, member):
    """Events, or the lanes that took part in them, a ray."""
    counts = line.inner("counts")
    return counts.inner(kind).number(member) / line.number("ray_count") if kind in counts else 0


def places(line):
    """Voxels, cells and nodes that a walk comes to."""
    return (a_ray(line, "voxel", "events") + a_ray(line, "flat", "lanes") + a_ray(line, "node", "lanes") +
            a_ray(line, "round", "lanes") + a_ray(line, "shared_node", "events") +
            a_ray(line, "shared_cell", "events"))


def triangles(line):
    return a_ray(line, "triangle", "events") + 2 * a_ray(line, "leaf", "lanes")


def walks(data):
    results = data["counters.json"]
    kernels = ["grid3d", "cell", "pyramid1"]
    rows, done = [], []
    for field in results.distinct("field", "counts"):
        for rays in results.distinct("rays", "counts"):
            lines = [counts_of(results, field, rays, kernel) for kernel in kernels]
            work = [(places(line), triangles(line)) if line else ("", "") for line in lines]
            rows.append([field, rays, *(text for p, t in work for text in
                                        ((f"{p:.1f}", f"{t:.2f}") if p != "" else ("", "")))])
            if all(lines):
                done.append(work)
    text = "A ray, on average. Places are voxels, cells, or nodes and cells.\n\n"
    text += table(["field", "rays", "`grid3d`: places", "triangles", "`cell`: places", "triangles",
                   "`pyramid1`: places", "triangles"], rows, "llrrrrrr")
    if not done:
        return text

    def means(above, below):
        return [geometric_mean([work[above][k] / work[below][k] for work in done]) for k in (0, 1)]

    to_grid, to_cell = means(1, 0), means(2, 1)
    both = [2 * cell[0] / grid[1] for grid, cell, _ in done]
    return text + (
        f"\n- The cell walk comes to {to_grid[0]:.3g} times as many places as the 3D grid and tests {to_grid[1]:.2g} "
        "times as many triangles (geometric means).\n"
        f"- It comes to fewer places than the grid in {sum(cell[0] < grid[0] for grid, cell, _ in done)} of "
        f"{len(done)} rows and tests fewer triangles in {sum(cell[1] < grid[1] for grid, cell, _ in done)}. If it "
        f"tested both triangles wherever it comes, these would be {geometric_mean(both):.2g} times the grid's "
        f"(geometric mean), at most {max(both):.3g} times.\n"
        f"- The pyramid comes to {to_cell[0]:.3g} times as many places as the cell walk and tests {to_cell[1]:.2g} "
        "times as many triangles (geometric means).\n")


def ablation(data):
    results = data["ablation.json"]
    classes, variants = results.distinct("rays", "ablation"), results.distinct("variant", "ablation")
    first = results.of("ablation")[0]
    of = {(line.text("field"), line.text("variant"), line.text("rays")):
          line.number("instructions") / line.number("ray_count") for line in results.of("ablation")}

    def cell(field, variant, rays):
        value, base = of.get((field, variant, rays)), of.get((field, variants[0], rays))
        if value is None:
            return ""
        return f"{value:.0f} ({value / base:.2f})" if variant != variants[0] and base else f"{value:.0f}"

    text = (f"Instructions a ray inside the query, `{first.text('kernel')}`, in brackets over those of the code as it "
            f"is; counted by callgrind, {first.number('ray_count')} rays a\nclass. All variants gave the same "
            "answers.\n")
    for field in results.distinct("field", "ablation"):
        rows = [[variant, *(cell(field, variant, rays) for rays in classes)] for variant in variants]
        text += f"\n**{field}**\n\n" + table(["", *classes], rows)
    return text


def caches(data):
    results = data["caches.json"]
    columns = [("L2", "reads"), ("L2", "first_misses"), ("L2", "misses"), ("L3", "misses")]
    rows = []
    for field in results.distinct("field", "caches"):
        for rays in results.distinct("rays", "caches"):
            lines = [(results.first("caches", field=field, rays=rays, level=level), key) for level, key in columns]
            rows.append([field, rays, *(f"{line.number(key) / line.number('ray_count'):.2f}" if line else ""
                                        for line, key in lines)])
    first = results.of("caches")[0]
    return (f"A ray on average, `{first.text('kernel')}`, {first.number('ray_count')} rays a class: reads, and the reads "
            "and writes that miss caches of 32 KiB, 512 KiB and\n32 MiB, by callgrind's model, which has no "
            "prefetches.\n\n" +
            table(["field", "rays", "reads", "not in 32 KiB", "not in 512 KiB", "not in 32 MiB"], rows, "llrrrr"))


def pages(data):
    huge, small = data["pages-huge.json"], data["pages-small.json"]
    fields, classes = matrix(huge)
    rows = [[field, *(ratio(speed(own(huge, field, rays)), speed(own(small, field, rays))) for rays in classes)]
            for field in fields]
    return "Speed on huge pages over that on ordinary ones.\n\n" + table(["field", *classes], rows)


# ---- an own run ----

def counters(results):
    """One file of micro --counters, for a page of one's own."""
    text = (f"{run_text(results.run)}.\n\nCounts a ray, in brackets the share of the vector's lanes that took part. A "
            "leaf test is a ray against a cell of two triangles; grids test single triangles.\n")

    def busy(line, kind):
        events, lanes = a_ray(line, kind, "events"), a_ray(line, kind, "lanes")
        return f"{lanes:.2f} ({100 * lanes / (events * line.number('width')):.0f} %)" if events else ""

    def plain(count):
        return f"{count:.2f}" if count else ""

    groups = {}
    for line in results.of("counts"):
        groups.setdefault((line.text("field"), line.text("rays")), []).append(line)
    for (field, rays), lines in groups.items():
        rows = [[line.text("contender"), busy(line, "flat"), busy(line, "node"), busy(line, "leaf"),
                 plain(a_ray(line, "refill", "events")), plain(a_ray(line, "shared_node", "events")),
                 plain(a_ray(line, "voxel", "events")), plain(triangles(line))] for line in lines]
        text += f"\n**{field}, {rays}**, {100 * lines[0].number('hit_share'):.0f} % hit\n\n"
        text += table(["", "cells", "node steps", "leaf tests", "refills", "shared nodes", "voxels", "triangles"], rows)
    return text
