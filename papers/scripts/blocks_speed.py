# SPDX-License-Identifier: Apache-2.0
"""Tables of speed, memory and building: what cellwalk-bench micro measured."""

import names
from markdown import duration, listed, ratio, table
from results import Problem, geometric_mean, run_text


def speed_files(data):
    """The files of speeds that there are, by instruction set."""
    found = {isa: data.get(name) for isa, name in names.SPEED_FILES.items() if data.get(name)}
    if not found:
        raise Problem(f"{data.folder}: has no file speed-*.json")
    return found


def default_kernel(data, isa, field="1025"):
    """Which kernel the library chooses up to this instruction set, by the file of speeds; empty if there is none."""
    results = data.get(names.SPEED_FILES.get(isa, ""))
    about = results.first("field", field=field) if results else None
    return about.text("default_kernel") if about else ""


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
    return max(found, key=speed, default=None)


def speed(line):
    return line.number("mrays_per_s") if line else 0


def over_embree(results, field, rays):
    """0 if one side is missing."""
    above, below = own(results, field, rays), fastest(results, field, rays)
    return speed(above) / speed(below) if above and below else 0


def matrix(results):
    return results.distinct("field"), results.distinct("rays")


def by_field(results, first, cell):
    """A table with a row a class of rays and a column a field."""
    fields, classes = matrix(results)
    return table([first, *map(names.field, fields)], [[rays, *(cell(field, rays) for field in fields)] for rays in classes])


def build_of(results, field):
    about = results.first("field", field=field)
    return results.first("kernel_build", field=field, kernel=about.text("default_kernel")) if about else None


def cells(about):
    return (about.number("nx") - 1) * (about.number("ny") - 1)


def bytes_a_cell(about, build):
    """Embree holds its own copy of the samples, a kernel uses the field's."""
    samples = about.number("bytes_samples") if build.get("kind") == "kernel_build" else 0
    return (samples + build.number("bytes")) / cells(about)


# ---- blocks ----

def all_ratios(results):
    """Speed over Embree's, by (class of rays, field): all that was measured, small fields and seas included."""
    fields, classes = matrix(results)
    found = {(rays, field): over_embree(results, field, rays) for rays in classes for field in fields}
    return {place: value for place, value in found.items() if value}


def place(rays, field):
    return f"{names.CLASSES[rays]}, {names.field(field)}"


def embree_text(run):
    return f"Embree {run.text('embree')}" + (" (Debian's build, with assertions)" if run.get("embree_assertions") else "")


def summary(data):
    """Ratios to Embree's fastest packet width, an instruction set after the other."""
    means, lowest, highest, slower, counts, embree = {}, [], [], [], set(), set()
    for isa, results in speed_files(data).items():
        ratios = all_ratios(results)
        if not ratios:
            continue
        means[names.ISAS[isa]] = geometric_mean(ratios.values())
        low, high = min(ratios, key=ratios.get), max(ratios, key=ratios.get)
        lowest.append(f"{ratios[low]:.2f} ({place(*low)})")
        highest.append(f"{ratios[high]:.2f} ({place(*high)})")
        slower.append(str(sum(value < 1 for value in ratios.values())))
        counts.add((len({rays for rays, _ in ratios}), len({field for _, field in ratios})))
        embree.add(embree_text(results.run))
    text = ""
    if means:
        cases = listed(f"{classes} classes of rays on {fields} fields" for classes, fields in sorted(counts))
        each = listed(str(classes * fields) for classes, fields in sorted(counts))
        text = (f"- **Speed**: {listed(f'{mean:.2f}' for mean in means.values())} times that of {listed(sorted(embree))} with "
                f"{listed(means)}, on one thread. These are geometric means over {cases}. For each case Embree's fastest packet "
                f"width counts. Lowest of all: {listed(lowest)}. Highest: {listed(highest)}. Embree is faster in "
                f"{listed(slower)} of {each} cases.\n")
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
    text = (f"- **Memory** at {names.field(field)}: {bytes_a_cell(about, ours):.2f} bytes a cell, samples included. "
            f"Embree's triangles take {bytes_a_cell(about, mesh):.0f}")
    text += f", its grid geometry {bytes_a_cell(about, grid):.0f}.\n" if grid else ".\n"
    text += (f"- **Building** at {names.field(field)}: {seconds:.3g} s on one thread. Embree's triangles take "
             f"{mesh.number('build_seconds') / seconds:.0f} times as long at its default quality")
    return text + (f", its grid geometry {grid.number('build_seconds') / seconds:.0f} times.\n" if grid else ".\n")


def speeds(data):
    return "\n".join(
        f"**{names.ISAS[isa]}**: speed relative to Embree's fastest packet width; above 1 Cellwalk is faster.\n\n" +
        by_field(results, "rays", lambda field, rays: ratio(speed(own(results, field, rays)),
                                                            speed(fastest(results, field, rays))))
        for isa, results in speed_files(data).items())


def rates(data):
    def cell(results, field, rays):
        ours, theirs = own(results, field, rays), fastest(results, field, rays)
        width = theirs.text("contender").split("/")[-1].split("-")[0] if theirs else ""
        return f"{speed(ours):.3g} / {speed(theirs):.3g} {width}" if ours and theirs else ""

    return "\n".join(f"**{names.ISAS[isa]}**. {run_text(results.run)}.\n\n" +
                     by_field(results, "rays", lambda field, rays: cell(results, field, rays))
                     for isa, results in speed_files(data).items())


def _back(rays):
    """random+1e+06: 10⁶."""
    return (rays.partition("+")[2] or "0").replace("1e+06", "10⁶")


def afar(results):
    """How fast rays are that start farther and farther back, and how much slower than from the field's border."""
    of = {(line.text("field"), line.text("rays")): speed(line) for line in results.of("result")}
    fields, classes = matrix(results)
    rows = []
    for field in fields:
        near = of[field, classes[0]]
        rows.append([names.field(field), *(f"{of[field, rays]:.3g}" + (f" ({near / of[field, rays]:.2f})" if k else "")
                                           for k, rays in enumerate(classes))])
    worst, where = max((of[field, classes[0]] / of[field, rays], f"{names.field(field)}, {_back(rays)}")
                       for field in fields for rays in classes[1:])
    return (f"{run_text(results.run)}.\n\n" + table(["field", *map(_back, classes)], rows) +
            f"\nIn brackets: the time of a ray over that from the border, at most {worst:.2f} ({where}).\n")


def newer_embree(data):
    """Another version of Embree beside the same kernel, and what it changes where Debian's was measured, too."""
    results, debian = data["embree4.json"], data[names.SPEED_FILES[data["embree4.json"].run.text("isa")]]
    fields, classes = matrix(results)
    places = [(field, rays) for field in fields for rays in classes]
    both = [(over_embree(results, *at), over_embree(debian, *at)) for at in places]
    both = [(newer, older) for newer, older in both if newer and older]
    mean, there = geometric_mean([newer for newer, _ in both]), geometric_mean([older for _, older in both])
    return (f"{run_text(results.run)}.\n\n" +
            by_field(results, "rays", lambda field, rays: ratio(over_embree(results, field, rays), 1)) +
            f"\nThe geometric mean of these {len(both)} ratios is {mean:.2f}, and {there:.2f} beside {embree_text(debian.run)}.\n")


def beside(data):
    """Rays parallel to a surface, in one call and in calls of one ray, as Embree's width of 1 is."""
    batch, single = data["beside.json"], data["beside-single.json"]
    rows = []
    for name in batch.distinct("field"):
        row = [names.field(name)]
        one = single.first("result", field=name, contender="embree/triangles/w1")
        for results, below in ((batch, fastest(batch, name, "beside")), (single, one)):
            above = own(results, name, "beside")
            row += [f"{1 / speed(line):.2g}" if line else "" for line in (above, below)] + [ratio(speed(above), speed(below))]
        rows.append(row)
    heads = [f"{head}{where}" for where in ("in one call", "one ray a call") for head in ("Cellwalk, ", "Embree, ", "ratio, ")]
    return f"{run_text(batch.run)}.\n\n" + table(["field", *heads], rows)


def peers(data):
    geometries = {"triangles": "triangles", "triangles-robust": "triangles, robust", "grid": "grid",
                  "grid-robust": "grid, robust"}
    results = data["peers.json"]
    fields, classes = matrix(results)
    rows = [[names.field(field), name, *(ratio(speed(own(results, field, rays)),
                                               speed(fastest(results, field, rays, geometry))) for rays in classes)]
            for field in fields for geometry, name in geometries.items()]
    return (f"**{names.ISAS[results.run.text('isa')]}**: speed relative to Embree's fastest packet width.\n\n" +
            table(["field", "Embree geometry", *classes], rows, "ll" + "r" * len(classes)))


def threads(data):
    results = data["threads.json"]
    fields, classes = matrix(results)
    of = {}
    for line in results.of("result"):
        # The shortest times: what other programs take of two CPUs is no share of ours.
        of[line.number("threads"), line.text("rays"), line.text("field")] = 1 / line.number("seconds_min")
    rows = [[count, rays, *(ratio(of.get((count, rays, field)), of.get((1, rays, field))) for field in fields)]
            for count in sorted({place[0] for place in of} - {1}) for rays in classes]
    return (f"Speed relative to one thread, by the shortest wall-clock times, on a machine with {results.run.number('cpus')} CPUs.\n\n" +
            table(["threads", "rays", *map(names.field, fields)], rows, "rl" + "r" * len(fields)))


def building(data):
    """Bytes a cell / time to build, a row a field and a column a structure; and the time of an update of 64 x 64 samples."""
    results = data["building.json"]
    structures = list(dict.fromkeys((line.get("kind"), line.text(line.get("kind").split("_")[0])) for line in results.lines
                                    if line.get("kind") in ("kernel_build", "peer_build")))
    rows = []
    for about in results.of("field"):
        of = [results.first(kind, field=about.text("field"), **{kind.split("_")[0]: name}) for kind, name in structures]
        rows.append([names.field(about.text("field")),
                     *(f"{bytes_a_cell(about, line):.1f} / {duration(line.number('build_seconds'))}" if line else ""
                       for line in of),
                     next((duration(line.number("update_seconds")) for line in of if line and "update_seconds" in line), "")])
    titles = [name.replace("embree/", "Embree ") if kind == "peer_build" else f"`{name}`" for kind, name in structures]
    return table(["field", *titles, "64 × 64 samples updated"], rows)


# ---- what was aimed at ----

def _worst(values, most=False):
    """Of (value, where), those that are there."""
    there = [value for value in values if value[0]]
    return (max if most else min)(there, key=lambda value: value[0], default=(0, ""))


def _mean(results, classes):
    """Over the middle sizes; 0 unless all are there."""
    ratios = [over_embree(results, field, rays) for rays in classes for field in names.MIDDLE]
    return geometric_mean(ratios) if all(ratios) else 0


def _growth(results):
    pairs = {rays: (own(results, "257", rays), own(results, "8193", rays)) for rays in names.classes(results)}
    return _worst(((speed(small) / speed(large), rays) for rays, (small, large) in pairs.items() if small and large),
                  most=True)


def _memory(results):
    """Small fields fit into the first megabyte as a whole; what the others need a cell beyond it is what counts."""
    values = []
    for about in results.of("field"):
        build = build_of(results, about.text("field"))
        beyond = about.number("bytes_samples") + build.number("bytes") - 1e6 if build else 0
        values.append((max(beyond, 0) / cells(about), names.field(about.text("field"))))
    return _worst(values, most=True)


def _build(peer):
    def measured(results):
        pairs = {field: (build_of(results, field), results.first("peer_build", field=field, peer=peer))
                 for field in names.MIDDLE[1:]}
        return _worst((theirs.number("build_seconds") / ours.number("build_seconds"), names.field(field))
                      for field, (ours, theirs) in pairs.items() if ours and theirs)
    return measured


def _two_threads(results):
    return _worst((own(results, line.text("field"), line.text("rays")).number("seconds_min") / line.number("seconds_min"),
                   f"{line.text('rays')}, {names.field(line.text('field'))}")
                  for line in results.of("result", threads=2) if own(results, line.text("field"), line.text("rays")))


def _beside_default(scenes, measure):
    """Of the library's choice over Embree's mesh with the same normals, the highest on those scenes."""
    def measured(results):
        found = []
        for line in results.of("scene"):
            paths = {path.text("path").split("-")[0]: path for path in line.lines("paths")}
            if line.text("scene") in scenes and "auto" in paths and "default" in paths:
                found.append((measure(paths["auto"]) / measure(paths["default"]), line.text("scene")))
        return _worst(found, most=True)
    return measured


def _tracing_time(path):
    return 1 / path.number("trace_mrays_per_s")


def _render_time(path):
    return path.number("seconds_median")


# All but those from afar, which came later.
SEAS = ("landsea-0", "landsea-1", "landsea-2")
SIX = ("primary", "shadow", "ao", "bounce", "random", "grazing")


def _lowest(results):
    ratios = all_ratios(results)
    where = min(ratios, key=ratios.get, default=None)
    return (ratios[where], place(*where)) if where else (0, "")


# Title; wanted with AVX-512, AVX2 and SSE4.2, or one figure for all and the file that tells it, below 0 for at most; what is
# measured, and where.
TARGETS = [
    ("speed over Embree, all classes but from afar, 257² to 4097², geometric mean", (3, 2.4, 1.9), None,
     lambda results: (_mean(results, SIX), "")),
    ("the same, lowest of all classes on all fields", (1.5, 1.4, 1.2), None, _lowest),
    ("time to trace a scene over Embree's: hftest", -0.7, "scenes/table.json", _beside_default(("hftest",), _tracing_time)),
    ("the same, landsea-0, -1, -2, highest", -0.65, "scenes/table.json", _beside_default(SEAS, _tracing_time)),
    ("time to render over Embree's, all but landsea-big, highest", -0.8, "scenes/table.json",
     _beside_default(("hftest", *SEAS, "texture"), _render_time)),
    ("the same, landsea-big", -0.6, "scenes/table.json", _beside_default(("landsea-big",), _render_time)),
    ("bytes a cell beyond the first MB, samples and bounds", -7, "building.json", _memory),
    ("building speed over Embree's triangles, 1025² and 4097²", 50, "building.json", _build("embree/triangles")),
    ("building speed over Embree's grid, 1025² and 4097²", 5, "building.json", _build("embree/grid")),
    ("time for a ray at 8193² over that at 257²", (-3, -3, -3), None, _growth),
    ("speed of two threads over one", 1.9, "threads.json", _two_threads),
]


def targets(data):
    there = speed_files(data)
    rows = []
    for title, wanted, file, measure in TARGETS:
        row = [title]
        for isa, results in there.items():
            if file and isa != next(iter(there)):
                row += ["", ""]
                continue
            aim = wanted if file else wanted[list(names.SPEED_FILES).index(isa)]
            source = data.get(file) if file else results
            value, where = measure(source) if source else (0, "")
            met = value <= -aim if aim < 0 else value >= aim
            row += [f"{'≤' if aim < 0 else '≥'} {abs(aim):g}",
                    f"{value:.2f}{f' ({where})' if where else ''}{'' if met else ', **missed**'}" if value else
                    "not measured"]
        rows.append(row)
    head = [text for isa in there for text in (f"{names.ISAS[isa]}: target", "measured")]
    return table(["", *head], rows, "l" + "rl" * len(there))


# ---- an own run ----

def micro(results):
    """One file of cellwalk-bench micro, for a page of one's own."""
    def cell(field, rays):
        lines = [line for line in results.of("result", field=field, rays=rays)
                 if not line.text("contender").startswith("embree/") and line.get("mrays_per_s")]
        best = max(lines, key=speed, default=None)
        to_embree = best.number("speed_to_embree_best", 0.0) if best else 0
        return f"{speed(best):.3g}{f' ({to_embree:.2f})' if to_embree else ''} `{names.kernel(best.text('contender'))}`" \
            if best else ""

    return (f"{run_text(results.run)}.\n\nThe fastest kernel in millions of rays a second, median. In brackets: speed "
            "relative to Embree's fastest packet width on the same rays.\n\n" + by_field(results, "rays", cell))
