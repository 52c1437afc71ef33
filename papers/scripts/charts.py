# SPDX-License-Identifier: Apache-2.0
"""What the pictures show: one function a chart. Blue is Cellwalk, orange is Embree, grey is everything else. Axes
follow the data; layout.py checks that nothing is cut off and no label lies on another."""

from matplotlib import pyplot
from matplotlib.lines import Line2D

import blocks_tradeoff
import layout
import markdown
import names
from blocks_scenes import BESIDE, COURSEWORK
from blocks_speed import build_of, bytes_a_cell, fastest, own, speed, speed_files
from results import Problem

OURS, OURS_LIGHT, EMBREE, EMBREE_LIGHT, GREY = "#1f6fb4", "#7fb2dc", "#d9731a", "#efb27c", "#8a8a8a"
WIDTH = 8.4  # inches


def canvas(height, rows=1, columns=1, title="", run=None, **adjust):
    """Axes under a title and a line about the run."""
    figure, axes = pyplot.subplots(rows, columns, figsize=(WIDTH, height), squeeze=False)
    place = {"left": 0.08, "right": 0.97, "bottom": 0.5 / height, "top": 1 - 0.75 / height, **adjust}
    figure.subplots_adjust(**place)
    figure.text(0.012, 1 - 0.22 / height, title, fontsize=12, fontweight="bold")
    if run:
        peer = f", Embree {run.text('embree')}" if run.text("embree", "") else ""
        compiler = run.text("compiler").replace("GNU", "GCC")
        figure.text(0.012, 1 - 0.40 / height, f"{run.text('cpu')}, {names.ISAS[run.text('isa')]}, {compiler}, commit "
                    f"{run.text('commit')}{peer}, {run.text('date')[:10]}", fontsize=7.5, color="#666666")
    return figure, axes


def note(axes, text, point, shift, color, **more):
    """A label at a point, shifted by so many points of type."""
    return axes.annotate(text, point, shift, textcoords="offset points", color=color, **{"fontsize": 7.5, **more})


def legend(figure, height, series):
    """Above panels: (text, color, style) of lines that all panels have."""
    figure.legend([Line2D([], [], color=color, marker=style[0], linestyle=style[1:]) for _, color, style in series],
                  [text for text, _, _ in series], labelcolor=[color for _, color, _ in series], loc="center left",
                  bbox_to_anchor=(0.06, 1 - 0.62 / height), ncol=len(series), fontsize=8.5, columnspacing=1.6, borderpad=0)


def panel_rows(classes):
    return (len(classes) + 2) // 3


def panels(axes, classes, draw, y_label, x_label):
    """A panel a class of rays, rows of three; draw(axes, class)."""
    for panel in axes.flat[len(classes):]:
        panel.set_visible(False)
    for k, rays in enumerate(classes):
        panel = axes[k // 3][k % 3]
        panel.set_title(names.CLASSES[rays], pad=3)
        panel.grid(axis="y", color="#e4e4e4", linewidth=0.6)
        panel.set_axisbelow(True)
        draw(panel, rays)
        if k % 3 == 0:
            panel.set_ylabel(y_label)
        if k + 3 >= len(classes):
            panel.set_xlabel(x_label)


# ---- speed ----

def pair(results, field, rays):
    """Cellwalk's speed and Embree's."""
    ours, theirs = own(results, field, rays), fastest(results, field, rays)
    if not (ours and theirs):
        raise Problem(f"{results.path}: has no speeds of both Cellwalk and Embree for {rays} rays on field {field}")
    return speed(ours), speed(theirs)


def speeds(data, field="1025"):
    isa, results = next(iter(speed_files(data).items()))
    title = f"Millions of rays a second, {field} × {field} samples, one thread, {names.ISAS[isa]}"
    classes = names.classes(results)
    figure, ((axes,),) = canvas(0.6 + 0.5 * len(classes), title=title, run=results.run, left=0.17, right=0.95, bottom=0.03)
    most = max(pair(results, field, rays)[0] for rays in classes)
    for k, rays in enumerate(classes):
        ours, theirs = pair(results, field, rays)
        axes.barh(k - 0.19, ours, 0.36, color=OURS)
        axes.barh(k + 0.19, theirs, 0.36, color=EMBREE)
        text = f"{ours:.3g}  ({ours / theirs:.2f} times as fast)" + ("   Cellwalk" if k == 0 else "")
        axes.text(ours + most / 100, k - 0.19, text, va="center", color=OURS, fontweight="bold", fontsize=8.5)
        axes.text(theirs + most / 100, k + 0.19, f"{theirs:.3g}" + ("   Embree, its fastest packet width" if k == 0 else ""),
                  va="center", color=EMBREE, fontsize=8.5)
    axes.set_yticks(range(len(classes)), [names.CLASSES[rays] for rays in classes])
    axes.invert_yaxis()
    axes.set_xlim(0, most * 1.58)
    axes.xaxis.set_visible(False)
    axes.spines["bottom"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    return figure


def scaling(data):
    isa, results = next(iter(speed_files(data).items()))
    classes = names.classes(results)
    rows = panel_rows(classes)
    height = 0.75 + 2.2 * rows
    figure, axes = canvas(height, rows, 3, f"Speed and size of the field, one thread, {names.ISAS[isa]}", results.run,
                          hspace=0.32, wspace=0.16, top=1 - 1.0 / height)
    legend(figure, height, [("Cellwalk, and how many times Embree's speed", OURS, "o-"),
                            ("Embree, its fastest packet width", EMBREE, "s-")])
    fields = [field for field in names.LAND if results.first("field", field=field)]
    pairs = {rays: [pair(results, field, rays) for field in fields] for rays in classes}
    limits = layout.log_limits([value for both in pairs.values() for pair in both for value in pair], 0.05, above=0.12)

    def draw(panel, rays):
        ours, theirs = zip(*pairs[rays])
        panel.plot(ours, "o-", color=OURS)
        panel.plot(theirs, "s-", color=EMBREE)
        for k, (above, below) in enumerate(zip(ours, theirs)):
            note(panel, f"{above / below:.2f}×", (k, max(above, below)), (2, 6), OURS, ha="center")
        layout.log_axis(panel.yaxis, limits)
        panel.set_xlim(-0.45, len(fields) - 0.45)
        panel.set_xticks(range(len(fields)), fields)

    panels(axes, classes, draw, "million rays / s", "samples a side")
    return figure


# ---- memory and building ----

def building(data):
    results = data["building.json"]
    figure, ((memory, time),) = canvas(3.4, 1, 2, "Memory and time to build", results.run, wspace=0.55, right=0.85)
    fields = [line for line in results.of("field") if line.text("field") in names.LAND]
    structures = {"Cellwalk": (OURS, OURS, "o-", lambda field: build_of(results, field)),
                  "3D grid": (GREY, GREY, "^-", lambda field: results.first("kernel_build", field=field, kernel="grid3d")),
                  "Embree, triangles": (EMBREE, EMBREE, "s-", lambda field: results.first("peer_build", field=field,
                                                                                        peer="embree/triangles")),
                  "Embree, grid": (EMBREE_LIGHT, EMBREE, "D-", lambda field: results.first("peer_build", field=field,
                                                                                          peer="embree/grid"))}
    of = {text: [build(line.text("field")) for line in fields] for text, (*_, build) in structures.items()}
    for panel, title, steps, value in (
            (memory, "bytes a cell, samples included", (1, 2, 5), bytes_a_cell),
            (time, "time to build, one thread", (1,), lambda about, line: line.number("build_seconds"))):
        values = {text: [value(*both) for both in zip(fields, lines)] for text, lines in of.items() if all(lines)}
        panel.set_title(title)
        layout.log_axis(panel.yaxis, layout.log_limits([y for line in values.values() for y in line]), steps,
                        markdown.duration if panel is time else "{:g}".format)
        panel.set_xticks(range(len(fields)), [line.text("field") for line in fields])
        panel.set_xlabel("samples a side")
        panel.set_xlim(-0.25, len(fields) - 0.75)
        panel.grid(axis="y", color="#e4e4e4", linewidth=0.6)
        heights = {}
        for text, line in sorted(values.items(), key=lambda item: item[1][-1]):
            color, text_color, style, _ = structures[text]
            panel.plot(line, style, color=color)
            # Names at the ends of lines that meet stand one above the other.
            _, y = panel.transData.transform((0, line[-1])) * 72 / figure.dpi
            heights[text] = max([y, *(height + 9 for height in heights.values())])
            layout.beside(note(panel, text, (len(fields) - 1, line[-1]), (7, heights[text] - y - 3), text_color, fontsize=8))
    return figure


# ---- scenes ----

def coursework(data):
    results = data["scenes/table.json"]
    scenes = results.some("scene")
    figure, ((axes,),) = canvas(3.5, title="Time to render, relative to a triangle mesh (Phong normals)", run=results.run,
                                left=0.11, right=0.98, top=0.70)
    styles = {"coursework: 3D grid": ("^", "none", GREY), "coursework: cell walk": ("o", "none", GREY),
              "3D grid": ("^", OURS_LIGHT, OURS_LIGHT), "cell walk": ("o", OURS_LIGHT, OURS_LIGHT),
              "Cellwalk's choice": ("o", OURS, OURS)}
    drawn = []
    for k, line in enumerate(scenes):
        mesh, *others = COURSEWORK[line.text("scene")]
        of = {path.text("path"): path.number("time_to_default", 0.0) for path in line.lines("paths")}
        values = [other / mesh for other in others] + [of.get(path) for path in BESIDE]
        axes.axhline(k, color="#e4e4e4", linewidth=0.6, zorder=0)
        for (text, (marker, face, edge)), value in zip(styles.items(), values):
            if value:
                drawn.append(value)
                axes.plot(value, k, marker, markersize=7, markerfacecolor=face, markeredgecolor=edge, markeredgewidth=1.4,
                          linestyle="none", label=text if k == 0 else None)
    axes.axvline(1, color="#444444", linewidth=0.8)
    layout.log_axis(axes.xaxis, layout.log_limits(drawn, 0.03), (1, 2, 5),
                    lambda tick: "1: triangle mesh" if tick == 1 else f"{tick:g}")
    axes.set_yticks(range(len(scenes)), [line.text("scene") for line in scenes])
    axes.set_ylim(len(scenes) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1), ncol=5, columnspacing=1.2, handletextpad=0.3, fontsize=8.5)
    return figure


# ---- speed against error ----

# What stands for no error on a logarithmic axis.
NONE = "none"


def _grid(panel):
    panel.grid(color="#eeeeee", linewidth=0.6)
    panel.set_axisbelow(True)


def tradeoff(data):
    """Promises of surfaces, and pictures."""
    rays, results = data[blocks_tradeoff.RAYS_FILE], data[blocks_tradeoff.FILE]
    figure, ((promise, picture),) = canvas(3.9, 1, 2, "Resolution: what is promised, and what a picture makes of it", results.run,
                                           wspace=0.26)
    styles = {"mean": ("o", OURS), "highest": ("^", GREY), "lowest": ("v", GREY)}
    drawn = []
    for filter_, (marker, color) in styles.items():
        pairs = [(line.number(side), line.number("got_" + side)) for line in rays.of("coarser", filter=filter_)
                 for side in ("above", "below") if line.number(side) > 0]
        promise.plot(*zip(*pairs), marker, color=color, linestyle="none", markersize=5, label=filter_)
        drawn += [value for pair in pairs for value in pair]
    limits = layout.log_limits(drawn)
    promise.plot(limits, limits, "-", color="#bbbbbb", zorder=0)
    promise.set_title("cells that a coarser surface is off")
    promise.set_xlabel("promised")
    promise.set_ylabel("worst found")
    for axis in (promise.xaxis, promise.yaxis):
        layout.log_axis(axis, limits, (1, 2, 5))
    promise.legend(loc="lower right", fontsize=8)
    _grid(promise)
    lines = results.some("picture")
    labels, xs, ys = [], [], []
    for factor in blocks_tradeoff.pictures(results):
        points = [(1e3 * line.number("seconds"), line.number("rmse")) for line in sorted(
            lines, key=lambda line: line.number("samples_a_pixel")) if line.number("factor") == factor]
        color = OURS if factor == 1 else OURS_LIGHT
        picture.plot(*zip(*points), "o-", color=color, markersize=3.5)
        labels.append(("full field" if factor == 1 else f"every {factor}.", points[-1], color if factor == 1 else GREY))
        xs += [x for x, _ in points]
        ys += [y for _, y in points]
    picture.set_title("RMS error of a picture")
    picture.set_xlabel("ms; points: 1, 2, 4 … samples a pixel")
    layout.log_axis(picture.xaxis, layout.log_limits(xs, 0.05, above=0.2))
    layout.log_axis(picture.yaxis, layout.log_limits(ys, 0.12))
    _grid(picture)
    layout.label_points(picture, labels, fontsize=8)
    return figure


def tradeoff_rays(data):
    results = data[blocks_tradeoff.RAYS_FILE]
    lands = blocks_tradeoff.lands(results)
    figure, (axes,) = canvas(3.7, 1, len(lands), "A view on coarser fields: speed against error of distances (99 % of the hits)",
                             results.run, wspace=0.12, left=0.105)
    points = {land: [(name, line.number("mrays_per_s"), line.number("t_99")) for name, line in blocks_tradeoff.views(results, land)]
              for land in lands}
    limits = layout.log_limits([y for found in points.values() for _, _, y in found], 0.12)
    for panel, land in zip(axes, lands):
        labels = []
        levels = [(x, y) for name, x, y in points[land] if not name.startswith("Embree")]
        panel.plot(*zip(*levels), "-", color="#bbbbbb", zorder=0)
        for name, x, y in points[land]:
            embree = name.startswith("Embree")
            color = EMBREE if embree else OURS
            panel.plot(x, y, "s" if embree else "o", color=color, markersize=5)
            labels.append((name.replace("coarser ", "1/").replace("Embree grid", "grid"), (x, y), color))
        panel.set_title(names.field(land) + " samples")
        panel.set_xlabel("million rays / s")
        layout.log_axis(panel.xaxis, layout.log_limits([x for _, x, _ in points[land]], 0.3, above=0.35), (1, 2, 5))
        layout.log_axis(panel.yaxis, limits, (1,), lambda tick: f"{100 * tick:g} %" if panel is axes[0] else "")
        _grid(panel)
        layout.label_points(panel, labels, fontsize=7.5)
    return figure


def tradeoff_terrain(data):
    """Horizons and the sky-view factor."""
    results = data[blocks_tradeoff.FILE]
    figure, ((horizon, sky),) = canvas(4.4, 1, 2, "Horizons and sky view: time against error, one thread", results.run, wspace=0.24)
    land = results.distinct("field", "horizon")[0]
    floor, ys, xs, labels = 1e-3, [], [], []

    def spread(name, x, values, color):
        values = [max(value, floor) for value in values]
        horizon.plot([x] * 3, values, "-", color=color, linewidth=1, zorder=0)
        for value, marker in zip(values, ("o", "s", "^")):
            horizon.plot(x, value, marker, color=color, markersize=4.5)
        labels.append((name, (x, values[2]), color))
        xs.append(x)
        ys.extend(values)

    for line in results.of("horizon", field=land):
        known = line.text("method") not in ("exact", "grid")
        values = [line.number("degrees_" + key) if known else 0 for key in ("median", "99", "worst")]
        if known and line.number("ns_an_angle") < 1:
            continue  # every 8th sample: beyond any use
        name = {"grid": f"grid {line.number('directions')}"}.get(line.text("method"), blocks_tradeoff.method(line))
        spread(name.replace("within ", "").replace("coarser ", "every "), line.number("ns_an_angle"), values,
               OURS if not known else OURS_LIGHT if line.text("method") == "max-distance" else GREY)
    peer = blocks_tradeoff.peer_horizon(data)
    if peer:
        spread("r.horizon", peer[0], [peer[1].number(key) for key in ("median_degrees", "most_of_99", "most")], EMBREE)
    horizon.set_title("degrees off: 50 %, 99 % (square), worst (triangle)")
    horizon.set_xlabel(f"ns an angle, {names.field(land)}")
    layout.log_axis(horizon.xaxis, layout.log_limits(xs, 0.12))
    layout.log_axis(horizon.yaxis, layout.log_limits(ys, 0.1), (1,), lambda tick: NONE if tick == floor else f"{tick:g}")
    _grid(horizon)
    layout.label_points(horizon, labels, fontsize=7.5)
    lines, labels, xs, ys = results.some("sky"), [], [], []
    for kind, text, style, color in (("exact", "evenly spaced", "o-", OURS), ("grid", "grid", "s--", OURS),
                                     ("max-distance", "64, within 30, 100, 300 cells", "^-", OURS_LIGHT),
                                     ("coarser", "32, every 2., 4., 8. sample", "D-", GREY)):
        points = sorted((line.number("ns_a_place") / 1000, line.number("share_99")) for line in lines if line.text("method") == kind)
        sky.plot(*zip(*points), style, color=color, linewidth=1.2, label=text)
        xs += [x for x, _ in points]
        ys += [y for _, y in points]
        if kind == "exact":
            labels = [(f"{line.number('directions')}", (line.number("ns_a_place") / 1000, line.number("share_99")), color)
                      for line in lines if line.text("method") == kind]
    sky.set_title("sky-view factor off, 99 % of the places")
    sky.set_xlabel("µs a place")
    layout.log_axis(sky.xaxis, layout.log_limits(xs, 0.08, above=0.12))
    layout.log_axis(sky.yaxis, layout.log_limits(ys, 0.08, below=0.3))
    sky.legend(loc="lower left", fontsize=7.5)
    _grid(sky)
    layout.label_points(sky, labels, fontsize=7.5)
    return figure


# ---- where the time goes ----

GROUPS = {"rays made ready": "#4d4d4d", "climb": "#8c6bb1", "flat steps": "#2b9c8c", "shared walk": OURS,
          "lane walk": "#c9a227", "leaf test": "#b5443c", "misses and hits written": "#9a9a9a", "other": "#dddddd"}


CHARTS = {"speed-1025": speeds, "scaling": scaling, "building": building, "coursework": coursework,
          "tradeoff": tradeoff, "tradeoff-rays": tradeoff_rays,
          "tradeoff-terrain": tradeoff_terrain}
