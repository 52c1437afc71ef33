# SPDX-License-Identifier: Apache-2.0
"""The trade of speed against accuracy: what the results of cellwalk-bench tradeoff come to, and their tables."""

import textwrap

import names
from blocks_terrain import FILE as TERRAIN_FILE
from markdown import duration, table, three
from results import Problem, run_text

RAYS_FILE, FILE = "rays/tradeoff.json", "tradeoff/tradeoff.json"
# A picture's samples that the table and the chart compare with.
SAMPLES = (1, 2, 4, 8, 16, 32, 64)


def share(number):
    """Of one, as per cent or as a power of ten."""
    return "0" if number == 0 else f"{100 * number:.2g} %" if number >= 1e-5 else f"{number:.1e}"


def lands(results):
    return results.distinct("field", "rays")


def times(above, below):
    return f"{above / below:.2f}" if above < 10 * below else f"{above / below:.3g}"


# ---- lines ----

def strict(results, land):
    return results.first("rays", field=land, contender="strict")


def views(results, land):
    """(name, line) of strict, each level, and the fastest width of each of Embree's meshes."""
    found = [("strict", strict(results, land))]
    found += [(f"coarser {line.number('factor')}", line) for line in results.of("rays", field=land, contender="coarser")]
    for mesh in ("embree", "embree-robust", "embree-grid", "embree-grid-robust"):
        widths = results.of("rays", field=land, contender=mesh)
        if widths:
            found.append((" ".join(["Embree", *mesh.split("-")[1:]]),
                          max(widths, key=lambda line: line.number("mrays_per_s"))))
    return found


def level(results, land, factor):
    """The view and the surface of every factor-th sample."""
    view = next((line for line in results.of("rays", field=land, contender="coarser") if line.number("factor") == factor), None)
    surface = coarser(results, land, "mean", factor)
    if view is None:
        raise Problem(f"{results.path}: has no view of every {factor}. sample of {land}")
    return view, surface


def coarser(results, land, filter_, factor):
    found = [line for line in results.of("coarser", field=land, filter=filter_) if line.number("factor") == factor]
    if not found:
        raise Problem(f"{results.path}: has no surface of every {factor}. sample of {land}, {filter_}")
    return found[0]


def method(line):
    """What the option is called, with its number."""
    kind, cells = line.text("method"), line.number("max_distance_cells")
    directions = line.number("directions")
    return {"grid": f"grid, {directions} directions", "max-distance": f"within {cells:.0f} cells",
            "coarser": f"coarser {line.number('factor')}"}.get(kind, "exact")


def horizon_lines(results):
    """(lines with errors, by method, and the times alone on larger land)"""
    lands_ = results.distinct("field", "horizon")
    return lands_, [[line for line in results.of("horizon", field=land)] for land in lands_]


def peer_horizon(data):
    """Nanoseconds an angle and errors of r.horizon, which another script measures; None where it has not."""
    results = data.get(TERRAIN_FILE)
    clock = results and results.first("time", program="r.horizon")
    error = results and results.first("horizon", program="r.horizon")
    if not (clock and error):
        return None
    angles = clock.number("part") * clock.number("side") ** 2
    return 1e9 * clock.number("cpu_seconds") / angles, error


def picture_of(results, samples, factor):
    for line in results.of("picture"):
        if (line.number("samples_a_pixel"), line.number("factor")) == (samples, factor):
            return line
    return None


def pictures(results):
    """The factors of pictures: the full field, coarser ones."""
    return sorted({line.number("factor") for line in results.of("picture")})


def picture_name(factor):
    return "full" if factor == 1 else f"coarser {factor}"


# ---- blocks ----

HEAD = ["you want", "choose", "it gains", "it costs"]


def choices(data):
    """One screen: what one wants, what one chooses, what it gains and costs."""
    return table(HEAD, choice_rows(data), "llll")


def choices_short(data):
    """The rows for README."""
    wanted = ("`--coarser 2`", "`--coarser 8`", "`horizon --grid --directions 16`",
              "`--svf --directions 16`", "`render --samples 4`")
    rows, title = {}, ""
    for row in choice_rows(data):
        title = row[0] or title
        if row[1] in wanted:
            rows[row[1]] = [title, *row[1:]]  # the last one, which is of the largest land
    missing = [option for option in wanted if option not in rows]
    if missing:
        raise Problem(f"the table of choices has no row {', '.join(missing)}")
    titles = [None] + [rows[option][0] for option in wanted]
    return table(HEAD, [["" if rows[option][0] == before else rows[option][0], *rows[option][1:]]
                        for before, option in zip(titles, wanted)], "llll")


def choice_rows(data):
    rays, rest = data[RAYS_FILE], data[FILE]
    rows = []
    for land in lands(rays)[-2:]:
        for factor in (2, 8):
            view, surface = level(rays, land, factor)
            rows.append([f"a view of {names.field(land)} samples, or depths" if factor == 2 else "", f"`--coarser {factor}`",
                         f"{times(view.number('mrays_per_s'), strict(rays, land).number('mrays_per_s'))} × the rays a second, "
                         f"1/{factor * factor} of the memory",
                         f"distances off by {share(view.number('t_median'))}, 99 %: {share(view.number('t_99'))}; heights by at "
                         f"most {max(surface.number('above'), surface.number('below')):.2g} cells"])
    safe = coarser(rays, "1025", "highest", 2) if "1025" in lands(rays) else None
    if safe:
        rows.append(["no obstacle missed", "`--coarser 2 --filter highest`", "1/4 of the memory",
                     f"the surface is never lower, and up to {safe.number('above'):.2g} cells higher (1025²)"])
    land, *more = rest.distinct("field", "horizon")
    exact = rest.first("horizon", field=land, method="exact")
    large = rest.first("horizon", field=more[0], method="exact") if more else None
    for line in rest.of("horizon", field=land, method="grid"):
        n = line.number("directions")
        twin = next((l for l in rest.of("horizon", field=more[0], method="grid") if l.number("directions") == n), None) if more else None
        gain = times(exact.number("ns_an_angle"), line.number("ns_an_angle"))
        if twin:
            gain += f" to {times(large.number('ns_an_angle'), twin.number('ns_an_angle'))}"
        rows.append(["exact horizons" if n == 8 else "", f"`horizon --grid --directions {n}`", f"{gain} × ({names.field(land)}"
                     + (f", {names.field(more[0])})" if twin else ")"), "no error; directions are not evenly spaced"
                     if n > 8 else "no error; directions every 45°"])
    for line in rest.of("horizon", field=land, method="max-distance")[1:]:
        rows.append(["horizons of what is near" if line.number("max_distance_cells") < 200 else "",
                     f"`--max-distance`, {line.number('max_distance_cells'):.0f} cells",
                     f"{times(exact.number('ns_an_angle'), line.number('ns_an_angle'))} ×",
                     f"angles too low by {line.number('degrees_mean'):.2g}° in the mean, 99 %: {line.number('degrees_99'):.2g}°"])
    best = sky_line(rest, "exact", 64)
    for kind, n in (("exact", 32), ("exact", 16), ("grid", 8)):
        line = sky_line(rest, kind, n)
        option = "`--svf --grid --directions 8`" if kind == "grid" else f"`--svf --directions {n}`"
        rows.append(["a sky-view factor" if n == 32 else "", option, f"{times(best.number('ns_a_place'), line.number('ns_a_place'))} × "
                     "(64 directions = 1)", f"off by {line.number('share_rms'):.1g} (RMS), 99 %: {line.number('share_99'):.1g}"])
    many = picture_of(rest, 64, 1)
    for n in (16, 4):
        line = picture_of(rest, n, 1)
        if many and line:
            rows.append(["a picture" if n == 16 else "", f"`render --samples {n}`",
                         f"{times(many.number('seconds'), line.number('seconds'))} × (64 samples = 1)",
                         f"RMS error {line.number('rmse'):.2g}, beside {many.number('rmse'):.2g}"])
    rows.append(["hits", "nothing", "", "strict hits cost next to nothing ([below](#tried-and-rejected))"])
    return rows


# ---- the program's help ----

def c_text(name, text):
    """A string of lines that fit a terminal, for the option tables of the program."""
    lines = textwrap.wrap(text, 80, break_on_hyphens=False, break_long_words=False)
    return f"#define {name} \\\n" + " \\\n".join(f'    "{line}\\n"' for line in lines) + "\n"


def help_header(data):
    """src/tool/options/trade.h: what each command's choices gain and cost, from the same figures as the pages."""
    rays, rest = data[RAYS_FILE], data[FILE]
    land = lands(rays)[-1]
    of = f"terrain of {land} x {land} samples"

    def gain(line):
        return f"{line.number('mrays_per_s') / strict(rays, land).number('mrays_per_s'):.2g}"

    def off(line):
        return f"{100 * line.number('t_median'):.2g} % (99 % of them: {100 * line.number('t_99'):.2g} %)"

    def picture(samples):
        line = picture_of(rest, samples, 1)
        return (f"{picture_of(rest, 64, 1).number('seconds') / line.number('seconds'):.2g}", f"{line.number('rmse'):.2g}")

    two, eight = (level(rays, land, factor)[0] for factor in (2, 8))
    coarse = (f"--coarser 2 makes rays {gain(two)} times as fast, with distances off by {off(two)}, --coarser 8 {gain(eight)} times and "
              f"{off(eight)}.")
    sixteen, many, grid = sky_line(rest, "exact", 16), sky_line(rest, "exact", 64), rest.of("horizon", method="grid")
    horizon = rest.first("horizon", method="exact")
    grids = [line for line in grid if line.text("field") == horizon.text("field") and line.number("directions") == 16]
    about = f"To save time, measured on rough {of} (papers/tradeoff.md): "
    texts = {
        "TRADE_TRACE": about + coarse,
        "TRADE_RENDER": about + coarse + f" With 4 samples a pixel a picture takes 1/"
                        f"{picture(4)[0]} of the time of 64, and its RMS error is {picture(4)[1]} instead of "
                        f"{picture_of(rest, 64, 1).number('rmse'):.2g}, with 16 1/{picture(16)[0]} and {picture(16)[1]}.",
        "TRADE_HORIZON": f"To save time (papers/tradeoff.md): --grid loses no exactness, and 16 directions are "
                         f"{horizon.number('ns_an_angle') / grids[0].number('ns_an_angle'):.2g} times as fast as others. For --svf, 16 "
                         f"directions take 1/{many.number('ns_a_place') / sixteen.number('ns_a_place'):.2g} of the time of 64, and 99 % of "
                         f"the factors are off by at most {sixteen.number('share_99'):.1g}. --coarser costs more error than it is "
                         "worth here.",
    }
    return ("/* SPDX-License-Identifier: Apache-2.0 */\n"
            "/* What choices of speed gain and cost, for the help of commands. papers/scripts/tables.py writes this file. */\n"
            "/* clang-format off */\n"
            "#ifndef CELLWALK_TOOL_OPTIONS_TRADE_H\n#define CELLWALK_TOOL_OPTIONS_TRADE_H\n\n" +
            "\n".join(c_text(name, text) for name, text in texts.items()) + "\n#endif\n")


def sky_line(results, kind, directions):
    for line in results.of("sky", method=kind):
        if line.number("directions") == directions:
            return line
    raise Problem(f"{results.path}: has no sky-view factor by {directions} directions, {kind}")


def promises(results):
    """Heights in cells: promised and got; one that is broken is an error of the page."""
    rows = []
    for line in results.of("coarser"):
        pairs = [(line.number(key), line.number("got_" + key)) for key in ("above", "below")]
        if any(got > asked for asked, got in pairs):
            raise Problem(f"{results.path}: {line.text('field')}, factor {line.number('factor')}: the surface is farther off than promised")
        rows.append([names.field(line.text("field")), line.text("filter"), f"{line.number('factor')}",
                     *(f"{asked:.4g} / {got:.4g}" for asked, got in pairs),
                     f"{line.number('rms'):.3g} / {line.number('got_rms'):.3g}"])
    return table(["samples", "filter", "every", "above: promised / found", "below", "RMS"], rows, "llrrrr")


def view_trade(results):
    rows = []
    for land in lands(results):
        first = strict(results, land).number("mrays_per_s")
        for name, line in views(results, land):
            speed = line.number("mrays_per_s")
            rows.append([names.field(land) if name == "strict" else "", name, f"{speed:.3g}", times(speed, first),
                         *(share(line.number(f"t_{of}")) for of in ("median", "99")), f"{line.number('cells_median'):.2g}",
                         three(line.number("differ_per_million"))])
    return (f"{run_text(results.run)}; a view of {results.run.number('ray_count')} rays.\n\n" +
            table(["samples", "", "Mrays/s", "strict = 1", "distance off: median", "99 %", "in cells, median",
                   "hit or miss, per million"], rows, "llrrrrrr"))


def horizon_trade(data):
    results = data[FILE]
    fields, (first, *more) = horizon_lines(results)
    exact = first[0].number("ns_an_angle")
    large = {method(line): line.number("ns_an_angle") for lines in more[:1] for line in lines}
    rows = []
    for line in first:
        ns = line.number("ns_an_angle")
        found = line.text("method") not in ("exact", "grid")
        rows.append([method(line), f"{ns:.3g}", f"{exact / ns:.2f}", *(f"{line.number('degrees_' + key):.2g}" if found else "0" for key in (
            "mean", "median", "99", "worst")), f"{large[method(line)]:.3g}" if method(line) in large else "",
            times(large["exact"], large[method(line)]) if method(line) in large else ""])
    peer = peer_horizon(data)
    if peer:
        rows.append(["r.horizon (GRASS), other land", f"{peer[0]:.3g}", f"{exact / peer[0]:.2g}", "",
                     *(f"{peer[1].number(key):.2g}" for key in ("median_degrees", "most_of_99", "most")), "", ""])
    twin = next((line for line in first if "degrees_worst" in line and line.text("method") == "grid"), None)
    text = f"{run_text(results.run)}.\n\n" + table(
        ["horizons", f"ns an angle, {names.field(fields[0])}", "exact = 1", "error in degrees: mean", "50 %", "99 %", "worst",
         *([f"ns an angle, {names.field(fields[1])}", "exact = 1"] if more else ["", ""])], rows, "lrrrrrrrr")
    if twin:
        text += (f"\nExact angles and those of the grid differ by at most {twin.number('degrees_worst'):.1g} degrees in the eight "
                 "directions that both have.\n")
    return text


def sky_trade(results):
    rows = []
    for line in sorted(results.of("sky"), key=lambda line: line.number("ns_a_place")):
        n, kind = line.number("directions"), line.text("method")
        rows.append([f"{n} directions" + (", grid" if kind == "grid" else f", {method(line)}" if kind != "exact" else ""),
                     f"{line.number('ns_a_place') / 1000:.3g}", *(f"{line.number('share_' + key):.1e}" for key in (
                         "rms", "median", "99", "worst"))])
    return table(["sky-view factor", "µs a place", "error: RMS", "median", "99 %", "worst"], rows)


def picture_trade(results):
    factors = pictures(results)
    rows = []
    for samples in SAMPLES:
        lines = [picture_of(results, samples, factor) for factor in factors]
        if any(lines):
            rows.append([f"{samples}", *(f"{line.number('rmse'):.2g} / {duration(line.number('seconds'))}" if line else ""
                                         for line in lines)])
    return table(["samples a pixel", *map(picture_name, factors)], rows)


# ---- an own run ----

def page(results):
    """All of one file that does not need another."""
    parts = [("Promised and found", promises, "coarser"), ("Views", view_trade, "rays"), ("Sky", sky_trade, "sky"),
             ("Pictures", picture_trade, "picture")]
    return "\n".join(f"**{title}**\n\n{make(results)}" for title, make, kind in parts if results.first(kind))
