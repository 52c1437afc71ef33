# SPDX-License-Identifier: Apache-2.0
"""Tables of work: what the walks do for a ray, what each part of a kernel saves, cache misses, pages, and where the time
goes."""

import names
from blocks_speed import matrix, own, speed
from markdown import ratio, table
from results import Problem, geometric_mean, run_text


def counts_of(results, field, rays, kernel):
    """What a kernel counted, whatever its leaf test."""
    return next((line for line in results.of("counts", field=field, rays=rays)
                 if names.kernel(line.text("contender")) == kernel), None)


def a_ray(line, kind, member="events"):
    """Events, or the lanes that took part in them, a ray."""
    counts = line.inner("counts")
    return counts.inner(kind).number(member) / line.number("ray_count") if kind in counts else 0


def busy(line, kind):
    """Lanes a ray, and in brackets which share of the vector's lanes that is."""
    events, lanes = a_ray(line, kind), a_ray(line, kind, "lanes")
    return f"{lanes:.2f} ({100 * lanes / (events * line.number('width')):.0f} %)" if events else ""


def count(line, kind):
    return f"{a_ray(line, kind):.2f}" if a_ray(line, kind) else ""


def places(line):
    """Voxels, cells and nodes that a walk visits."""
    return (sum(a_ray(line, kind, "lanes") for kind in ("flat", "node", "round")) +
            sum(a_ray(line, kind) for kind in ("voxel", "shared_node", "shared_cell")))


def triangles(line):
    return a_ray(line, "triangle") + 2 * a_ray(line, "leaf", "lanes")


# ---- what the walks do ----

WALKS = ("grid3d", "cell", "pyramid1")


def work(data):
    """(places, triangles) of each of WALKS, for each field and class of rays that all have."""
    results = data["counters.json"]
    found = {}
    for field in results.distinct("field", "counts"):
        for rays in results.distinct("rays", "counts"):
            lines = [counts_of(results, field, rays, kernel) for kernel in WALKS]
            if all(lines):
                found[field, rays] = [(places(line), triangles(line)) for line in lines]
    if not found:
        raise Problem(f"{results.path}: has no counts of all of {', '.join(WALKS)}")
    return found


def mean_ratio(found, above, below, k):
    return geometric_mean([of[above][k] / of[below][k] for of in found.values()])


def walks(data):
    found = work(data)
    fewer = [sum(cell[k] < grid[k] for grid, cell, _ in found.values()) for k in (0, 1)]
    both = [2 * cell[0] / grid[1] for grid, cell, _ in found.values()]
    return (
        f"- The cell walk visits {mean_ratio(found, 1, 0, 0):.1f} times as many cells as the 3D grid visits voxels, but "
        f"tests only {100 * mean_ratio(found, 1, 0, 1):.2g} % as many triangles (geometric means over {len(found)} sets of "
        "rays).\n"
        f"- It visits fewer cells than the grid visits voxels in {fewer[0]} of these sets, and tests fewer triangles in "
        f"{fewer[1]}. If it tested both triangles of every cell that it visits, it would test up to {max(both):.1f} times as "
        f"many as the grid.\n"
        f"- The pyramid visits {100 * mean_ratio(found, 2, 1, 0):.2g} % as many nodes and cells as the cell walk visits "
        f"cells, and tests {100 * mean_ratio(found, 2, 1, 1):.2g} % as many triangles (geometric means).\n")


def visits(data):
    rows = [[names.field(field), rays, *(text for p, t in of for text in (f"{p:.1f}", f"{t:.2f}"))]
            for (field, rays), of in work(data).items()]
    return table(["field", "rays", "`grid3d`: voxels", "triangles", "`cell`: cells", "triangles",
                  "`pyramid1`: nodes and cells", "triangles"], rows, "llrrrrrr")


def steps(data):
    results = data["counters.json"]
    rows = []
    for about in results.of("field"):
        kernel = about.text("default_kernel")
        for rays in results.distinct("rays", "counts"):
            line = counts_of(results, about.text("field"), rays, kernel)
            if line:
                rows.append([names.field(about.text("field")), rays, count(line, "shared_node"), busy(line, "flat"),
                             busy(line, "node"), busy(line, "leaf"), count(line, "refill")])
    return (f"`{kernel}`, per ray. In brackets: the share of the vector's lanes that took part.\n\n" +
            table(["field", "rays", "nodes opened together", "flat steps", "lane walk: node steps", "leaf tests",
                   "refills"], rows, "llrrrrr"))


# ---- where the time goes ----

def profile(data):
    results = data["profile.json"]
    phases = list(dict.fromkeys(phase for line in results.of("profile") for phase in line.inner("shares")))
    phases.sort(key=lambda phase: phase == "other")
    text = f"{run_text(results.run)}. `{results.some('profile')[0].text('kernel')}`, per cent of the samples in it.\n"
    for field in results.distinct("field", "profile"):
        of = {line.text("rays"): line.inner("shares") for line in results.of("profile", field=field)}
        rows = [[phase, *(f"{100 * shares.number(phase, 0.0):.0f}".removeprefix("0")
                          for shares in of.values())] for phase in phases]
        text += f"\n**{names.field(field)}**\n\n" + table(["phase", *of], rows)
    return text


def neon(data):
    results = data["neon.json"]
    kernels = results.distinct("kernel", "neon")
    text = f"{results.run.text('emulator')}, {results.run.text('compiler')}, commit {results.run.text('commit')}.\n"
    for field in results.distinct("field", "neon"):
        lines = {(line.text("kernel"), line.text("rays")): line for line in results.of("neon", field=field)}
        rows = []
        for rays in dict.fromkeys(rays for _, rays in lines):
            row = [rays]
            for line in (lines[kernel, rays] for kernel in kernels):
                x86, arm = line.number("sse42"), line.number("neon")
                row += [f"{x86 / line.number('ray_count'):.0f}", f"{arm / line.number('ray_count'):.0f}", f"{arm / x86:.2f}"]
            rows.append(row)
        head = [f"{kernel}{what}" for kernel in kernels for what in (", SSE4.2", ", NEON", ": ratio")]
        text += f"\n**{names.field(field)}**\n\n" + table(["rays", *head], rows)
    return text


def ablation(data):
    results = data["ablation.json"]
    classes, variants = results.distinct("rays", "ablation"), results.distinct("variant", "ablation")
    first = results.some("ablation")[0]
    of = {(line.text("field"), line.text("variant"), line.text("rays")):
          line.number("instructions") / line.number("ray_count") for line in results.of("ablation")}

    def cell(field, variant, rays):
        value, base = of.get((field, variant, rays)), of.get((field, variants[0], rays))
        if value is None:
            return ""
        return f"{value:.0f} ({value / base:.2f})" if variant != variants[0] and base else f"{value:.0f}"

    text = (f"Instructions per ray inside the query, `{first.text('kernel')}`, {first.number('ray_count')} rays a class, "
            "counted by callgrind.\nIn brackets: relative to the unchanged kernel. All variants gave the same answers.\n")
    for field in results.distinct("field", "ablation"):
        rows = [[variant, *(cell(field, variant, rays) for rays in classes)] for variant in variants]
        text += f"\n**{names.field(field)}**\n\n" + table(["", *classes], rows)
    return text


def caches(data):
    results = data["caches.json"]
    columns = [("L2", "reads"), ("L2", "first_misses"), ("L2", "misses"), ("L3", "misses")]
    rows = []
    for field in results.distinct("field", "caches"):
        for rays in results.distinct("rays", "caches"):
            lines = [(results.first("caches", field=field, rays=rays, level=level), key) for level, key in columns]
            rows.append([names.field(field), rays, *(f"{line.number(key) / line.number('ray_count'):.2f}" if line else ""
                                                     for line, key in lines)])
    first = results.some("caches")[0]
    return (f"Per ray, `{first.text('kernel')}`, {first.number('ray_count')} rays a class.\n\n" +
            table(["field", "rays", "reads", "misses of 32 KiB", "of 512 KiB", "of 32 MiB"], rows, "llrrrr"))


def pages(data):
    huge, small = data["pages-huge.json"], data["pages-small.json"]
    fields, classes = matrix(huge)
    rows = [[names.field(field), *(ratio(speed(own(huge, field, rays)), speed(own(small, field, rays)))
                                   for rays in classes)] for field in fields]
    return table(["field", *classes], rows)


# ---- an own run ----

def counters(results):
    """One file of cellwalk-bench micro --counters, for a page of one's own."""
    text = (f"{run_text(results.run)}.\n\nCounts per ray. In brackets: the share of the vector's lanes that took part. A "
            "leaf test is a ray against the two triangles of a cell; grids test single triangles.\n")
    groups = {}
    for line in results.of("counts"):
        groups.setdefault((line.text("field"), line.text("rays")), []).append(line)
    for (field, rays), lines in groups.items():
        rows = [[names.label(line.text("contender")), busy(line, "flat"), busy(line, "node"), busy(line, "leaf"), count(line, "refill"),
                 count(line, "shared_node"), count(line, "voxel"), f"{triangles(line):.2f}"] for line in lines]
        text += f"\n**{names.field(field)}, {rays}**, {100 * lines[0].number('hit_share'):.0f} % hit\n\n"
        text += table(["", "flat steps", "node steps", "leaf tests", "refills", "nodes opened together", "voxels",
                       "triangles"], rows)
    return text
