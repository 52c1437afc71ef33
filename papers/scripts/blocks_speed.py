# SPDX-License-Identifier: Apache-2.0
"""Tables of speed, memory and building: what cellwalk-bench micro measured."""

import math

from markdown import ratio, table
from results import Problem, geometric_mean, run_text

CLASSES = ["primary", "shadow", "ao", "bounce", "random", "grazing"]
LAND = ["65", "257", "1025", "4097", "8193"]
MIDDLE = ["257", "1025", "4097"]
SPEEDS = {"avx512": "speed-avx512.json", "avx2": "speed-avx2.json", "sse4.2": "speed-sse42.json"}


def speed_files(data):
    """The files of speeds that there are, widest instruction set first."""
    found = {isa: data.get(name) for isa, name in SPEEDS.items() if data.get(name)}
    if not found:
        raise Problem(f"{data.folder}: has no file speed-*.json")
    return found


def own(results, field, rays):
    """The result of the kernel that the library chooses, on one thread; None if there is none."""
    about = results.first("field", field=field)
    for line in results.of("result", field=field, rays=rays) if about else []:
        kernel = line.text("contender").split("/")[0]
        if kernel == about.text("default_kernel") and line.number("threads") == 1 and line.get("mrays_per_s"):
            return line
    return None


def fastest(results, field, rays, geometry="triangles"):
    """The fastest of Embree's widths with that geometry; None if there is none."""
    found = [line for line in results.of("result", field=field, rays=rays)
             if line.text("contender").startswith(f"embree/{geometry}/") and line.get("mrays_per_s")]
    return max(found, key=lambda line: line.number("mrays_per_s"), default=None)


def speed(line):
    return line.number("mrays_per_s") if line else 0


def over_embree(results, field, rays):
    """0 if one side is missing."""
    above, below = own(results, field, rays), fastest(results, field, rays)
    return speed(above) / speed(below) if above and below else 0


def matrix(results):
    return results.distinct("field"), results.distinct("rays")


def build_of(results, field):
    about = results.first("field", field=field)
    return results.first("kernel_build", field=field, kernel=about.text("default_kernel")) if about else None


def cells(about):
    return (about.number("nx") - 1) * (about.number("ny") - 1)


def bytes_a_cell(about, build):
    """Embree holds a copy of the samples of its own, a kernel uses the field's."""
    samples = about.number("bytes_samples") if build.get("kind") == "kernel_build" else 0
    return (samples + build.number("bytes")) / cells(about)


# ---- blocks ----

def summary(data):
    text = ""
    for isa, results in speed_files(data).items():
        ratios = {(rays, field): over_embree(results, field, rays) for rays in CLASSES for field in MIDDLE}
        ratios = {place: value for place, value in ratios.items() if value}
        if not ratios:
            continue
        low, high = min(ratios, key=ratios.get), max(ratios, key=ratios.get)
        text += (f"- {isa}: {geometric_mean(ratios.values()):.2f} times the speed of Embree's fastest width, geometric "
                 f"mean over {len(ratios)} pairs of a class of rays and a size of field; from {ratios[low]:.2f} "
                 f"({', '.join(low)}) to {ratios[high]:.2f} ({', '.join(high)}).\n")
    return text + _summary_of_building(data["building.json"])


def _summary_of_building(results):
    """On the largest field that both sides built."""
    fields = [line for line in results.of("field") if build_of(results, line.text("field")) and
              results.first("peer_build", field=line.text("field"), peer="embree/triangles")]
    if not fields:
        return ""
    about = max(fields, key=lambda line: line.number("nx"))
    field = about.text("field")
    ours = build_of(results, field)
    mesh, grid = (results.first("peer_build", field=field, peer=f"embree/{kind}") for kind in ("triangles", "grid"))
    seconds = ours.number("build_seconds")
    text = (f"- Memory at {field} samples a side: {bytes_a_cell(about, ours):.2f} bytes a cell with the samples; "
            f"Embree's triangles take {bytes_a_cell(about, mesh):.0f}")
    text += f", its grid {bytes_a_cell(about, grid):.0f}.\n" if grid else ".\n"
    text += (f"- Building it takes {seconds:.3g} s; Embree's triangles at default quality take "
             f"{mesh.number('build_seconds') / seconds:.0f} times as long")
    return text + (f", its grid {grid.number('build_seconds') / seconds:.1f} times.\n" if grid else ".\n")


def speeds(data):
    return "\n".join(_speeds(isa, results) for isa, results in speed_files(data).items())


def _speeds(isa, results):
    fields, classes = matrix(results)

    def cell(field, rays):
        ours, theirs = own(results, field, rays), fastest(results, field, rays)
        if not ours:
            return ""
        if not theirs:
            return f"({speed(ours):.3g} / -)"
        width = theirs.text("contender").split("/")[-1].split("-")[0]
        return f"{speed(ours) / speed(theirs):.2f} ({speed(ours):.3g} / {speed(theirs):.3g} {width})"

    rows = [[rays, *(cell(field, rays) for field in fields)] for rays in classes]
    return (f"{isa}: speed over that of Embree's best width, in brackets both in millions of rays a second.\n"
            f"{run_text(results.run)}.\n\n" + table(["", *fields], rows, "l" * (len(fields) + 1)))


def peers(data):
    geometries = {"triangles": "triangles", "triangles-robust": "triangles, robust", "grid": "grid",
                  "grid-robust": "grid, robust"}
    results = data["peers.json"]
    fields, classes = matrix(results)
    text = "The library's speed over that of Embree's fastest width.\n"
    for field in fields:
        rows = [[name, *(ratio(speed(own(results, field, rays)), speed(fastest(results, field, rays, geometry)))
                         for rays in classes)] for geometry, name in geometries.items()]
        text += f"\n**{field}**\n\n" + table(["Embree's", *classes], rows)
    return text


def widths(data):
    results = data["widths.json"]
    fields, classes = matrix(results)
    text = "Millions of rays a second.\n"
    for field in fields:
        rows = []
        for name in results.distinct("contender"):
            of = {line.text("rays"): speed(line) for line in results.of("result", field=field, contender=name)}
            label = name if name.startswith("embree/") else name.split("/")[0]
            rows.append([label, *(f"{of[rays]:.3g}" if of.get(rays) else "" for rays in classes)])
        text += f"\n**{field}**\n\n" + table(["", *classes], rows)
    return text


def threads(data):
    results = data["threads.json"]
    fields, classes = matrix(results)
    of = {}
    for line in results.of("result"):
        place = line.number("threads"), line.text("rays"), line.text("field")
        of[place] = max(of.get(place, 0), line.number("mrays_per_s"))
    rows = [[f"{count:.0f}", rays, *(ratio(of.get((count, rays, field)), of.get((1, rays, field))) for field in fields)]
            for count in sorted({place[0] for place in of} - {1}) for rays in classes]
    return (f"Speed of several threads over that of one, by the clock, of {results.run.number('cpus'):.0f} CPUs.\n\n" +
            table(["threads", "rays", *fields], rows, "rl" + "r" * len(fields)))


def building(data):
    results = data["building.json"]
    rows = []
    for line in results.lines:
        about = results.first("field", field=line.get("field"))
        if line.get("kind") not in ("kernel_build", "peer_build") or not about:
            continue
        name = line.text("kernel" if line.get("kind") == "kernel_build" else "peer")
        quality = line.text("quality", "")
        rows.append([line.text("field"), name + (f", quality {quality}" if quality else ""),
                     f"{bytes_a_cell(about, line):.1f}", f"{line.number('build_seconds'):.3g}"])
    return ("Memory with the samples, and CPU seconds of one thread to build.\n\n" +
            table(["field", "", "bytes a cell", "s"], rows, "llrr"))


# ---- what was aimed at ----

def _least(values, most=False):
    """The worst of (value, where) that are there."""
    there = [value for value in values if value[0]]
    return (max if most else min)(there, key=lambda value: value[0], default=(0, ""))


def _mean(results, classes):
    """Over the middle sizes; 0 unless all are there."""
    ratios = [over_embree(results, field, rays) for rays in classes for field in MIDDLE]
    return geometric_mean(ratios) if all(ratios) else 0


def _means(*classes):
    return lambda results: _least((_mean(results, [rays]), rays) for rays in classes)


def _sizes(rays):
    return lambda results: _least((over_embree(results, field, rays), field) for field in LAND)


def _growth(results):
    pairs = {rays: (own(results, "257", rays), own(results, "8193", rays)) for rays in CLASSES}
    return _least(((speed(small) / speed(large), rays) for rays, (small, large) in pairs.items() if small and large),
                  most=True)


def _memory(results):
    """Small fields are all within the first megabyte; what the others need a cell beyond it is what counts."""
    values = []
    for about in results.of("field"):
        build = build_of(results, about.text("field"))
        beyond = about.number("bytes_samples") + build.number("bytes") - 1e6 if build else 0
        if beyond > 0:
            values.append((beyond / cells(about), about.text("field")))
    return _least(values, most=True)


def _build(peer):
    def measured(results):
        pairs = {field: (build_of(results, field), results.first("peer_build", field=field, peer=peer))
                 for field in MIDDLE[1:]}
        return _least((theirs.number("build_seconds") / ours.number("build_seconds"), field)
                      for field, (ours, theirs) in pairs.items() if ours and theirs)
    return measured


def _two_threads(results):
    return _least((speed(line) / speed(own(results, line.text("field"), line.text("rays"))),
                   f"{line.text('rays')}, {line.text('field')}")
                  for line in results.of("result", threads=2) if own(results, line.text("field"), line.text("rays")))


# Title; wanted with AVX-512, AVX2, SSE4.2, or one figure for all and the file that it is measured from; what is measured.
TARGETS = [
    ("all classes, 257² to 4097², geometric mean", (4, 3, 1.5), None, lambda results: (_mean(results, CLASSES), "")),
    ("primary, at every size from 65²", (2, 1.6, 1), None, _sizes("primary")),
    ("shadow, at every size from 65²", (3, 2, 1.2), None, _sizes("shadow")),
    ("ambient occlusion, bounce", (4.5, 3.5, 1.5), None, _means("ao", "bounce")),
    ("random, grazing", (5, 4, 2), None, _means("random", "grazing")),
    ("bytes a cell beyond 1 MB, samples and bounds", -7, "building.json", _memory),
    ("building, 1025² and 4097², against Embree's triangles", 50, "building.json", _build("embree/triangles")),
    ("building, 1025² and 4097², against Embree's grid", 5, "building.json", _build("embree/grid")),
    ("time for a ray, 8193² over 257²", (-3, -3, -3), None, _growth),
    ("two threads over one", 1.9, "threads.json", _two_threads),
]  # below 0: at most


def targets(data):
    there = speed_files(data)
    rows = []
    for title, wanted, file, measure in TARGETS:
        row = [title]
        for isa, results in there.items():
            if file and isa != next(iter(there)):
                row += ["", ""]
                continue
            aim = wanted if file else wanted[list(SPEEDS).index(isa)]
            source = data.get(file) if file else results
            value, where = measure(source) if source else (0, "")
            met = 0 < value <= -aim if aim < 0 else value >= aim
            row += [f"{'≤' if aim < 0 else '≥'} {abs(aim):g}",
                    f"{value:.2f}{f' ({where})' if where else ''}{'' if met else ' **missed**'}" if value else
                    "not measured"]
        rows.append(row)
    head = [text for isa in there for text in (f"{isa}, wanted", "measured")]
    return table(["", *head], rows, "l" + "rl" * len(there))


# ---- an own run ----

def micro(results):
    """The fastest kernel of one file, for a page of one's own."""
    fields, classes = matrix(results)

    def cell(field, rays):
        lines = [line for line in results.of("result", field=field, rays=rays)
                 if not line.text("contender").startswith("embree/") and line.get("mrays_per_s")]
        if not lines:
            return ""
        best = max(lines, key=speed)
        to_embree = best.number("speed_to_embree_best", 0.0)
        return f"{speed(best):.3g} {f'({to_embree:.2f}) ' if to_embree else ''}{best.text('contender').split('/')[0]}"

    return (f"{run_text(results.run)}.\n\nThe fastest kernel in millions of rays a second, median, and its speed over "
            "that of Embree's fastest width on the same rays.\n\n" +
            table(["rays", *fields], [[rays, *(cell(field, rays) for field in fields)] for rays in classes],
                  "l" * (len(fields) + 1)))
