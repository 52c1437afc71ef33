# SPDX-License-Identifier: Apache-2.0
"""The two kinds of charts: bars and lines. Blue is Cellwalk, orange Embree. Axes follow the
data; layout.py checks that nothing is cut off and no label lies on another. The same results and version of matplotlib give the same
bytes: fixed ids, no date, text as text."""

import io

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({
    "svg.hashsalt": "cellwalk", "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9,
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial"], "axes.titlesize": 9.5, "axes.titleweight": "bold",
    "axes.titlelocation": "left", "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.7,
    "axes.edgecolor": "#666666", "axes.labelcolor": "#444444", "xtick.color": "#444444", "ytick.color": "#444444",
    "xtick.minor.size": 0, "ytick.minor.size": 0, "legend.frameon": False, "lines.linewidth": 1.8,
    "lines.markersize": 4, "figure.facecolor": "white", "savefig.facecolor": "white"})
from matplotlib import pyplot  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import LogLocator, NullLocator  # noqa: E402

import draw  # noqa: E402
import layout  # noqa: E402

COLORS = {"ours": "#1f6fb4", "embree": "#d9731a"}
MARKS = {"ours": "o", "embree": "s"}
WIDTH = 8.4  # inches


class Series:
    """label|contender|color of a chart's query."""

    def __init__(self, text):
        self.label, self.contender, self.style = (part.strip() for part in text.split("|"))
        self.color, self.mark = COLORS[self.style], MARKS[self.style]


def canvas(a, run, height, columns=1, rows=1, **adjust):
    figure, axes = pyplot.subplots(rows, columns, figsize=(WIDTH, height), squeeze=False)
    figure.subplots_adjust(**{"left": 0.085, "right": 0.97, "bottom": 0.5 / height, "top": 1 - 1.0 / height, **adjust})
    figure.text(0.012, 1 - 0.22 / height, a["title"], fontsize=12, fontweight="bold")
    figure.text(0.012, 1 - 0.40 / height, draw.run_text(run), fontsize=7.5, color="#666666")
    return figure, axes


def legend(figure, height, series):
    figure.legend([Line2D([], [], color=s.color, marker=s.mark, linestyle="-") for s in series], [s.label for s in series],
                  loc="center left", bbox_to_anchor=(0.005, 1 - 0.62 / height), ncol=len(series), fontsize=8.5, columnspacing=1.6)


def ordered(a, rows, key):
    return a[f"{key}_order"].split(",") if f"{key}_order" in a else [str(v) for v in rows.distinct(a[key])]


def bars(a, run, rows, series):
    names = ordered(a, rows, "rows")
    height = 1.05 + 0.26 * len(series) * len(names)
    figure, ((axes,),) = canvas(a, run, height, left=0.17, right=0.95, bottom=0.03, top=1 - 0.8 / height)
    legend(figure, height, series)
    found = {(n, s.contender): rows.rate(s.contender, **{a["rows"]: n}) for n in names for s in series}
    most, thick = max(v for v in found.values() if v and v.sure), 0.8 / len(series)
    for k, n in enumerate(names):
        for c, s in enumerate(series):
            v, y = found[n, s.contender], k + (c - (len(series) - 1) / 2) * thick
            if v is None:
                continue
            end = v if v.sure else 0
            axes.barh(y, end, thick * 0.92, color=s.color)
            text = draw.digits(v)
            if c == 0 and len(series) > 1 and v.sure:
                text += f" ({draw.digits(rows.faster(series[1].contender, s.contender, **{a['rows']: n}))} times as fast)"
            axes.text(end + most / 100, y, text, va="center", color=s.color, fontsize=8.5)
    axes.set_yticks(range(len(names)), [draw.name(n) for n in names])
    axes.invert_yaxis()
    axes.set_xlim(0, most * 1.4)
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    return figure


def lines(a, run, rows, series):
    panels = [(draw.name(p), rows.where(f"{a['panel']} == {p!r}")) for p in ordered(a, rows, "panel")]
    columns = min(3, len(panels))
    down = (len(panels) + columns - 1) // columns
    height = 1.15 + 2.15 * down
    figure, axes = canvas(a, run, height, columns, down, hspace=0.36, wspace=0.2)
    legend(figure, height, series)
    xs = ordered(a, rows, "x")
    for panel in axes.flat[len(panels):]:
        panel.remove()
    for k, (title, group) in enumerate(panels):
        panel = axes[k // columns][k % columns]
        for s in series:
            points = [(x, v) for x, v in ((x, group.rate(s.contender, **{a["x"]: n})) for x, n in enumerate(xs)) if v and v.sure]
            if points:
                panel.plot(*zip(*points), s.mark + "-", color=s.color)
        panel.set_title(title, pad=3)
        panel.grid(axis="y", color="#e4e4e4", linewidth=0.6)
        panel.set_axisbelow(True)
        panel.set_yscale("log")
        panel.margins(y=0.08)
        panel.yaxis.set_major_locator(LogLocator(subs=(1, 3)))
        panel.yaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_minor_locator(NullLocator())
        panel.set_xlim(-0.25, len(xs) - 0.75)
        panel.set_xticks(range(len(xs)), xs)
        if k + columns >= len(panels):
            panel.set_xlabel(a.get("x_label", "samples a side"))
    return figure


KINDS = {"bars": bars, "lines": lines}


def svg(name, a, run, rows):
    """A chart's text; fails if something in it is cut off or lies on something else. Figures that have not converged are not drawn;
    bars say so."""
    if not any(draw.alone(line)["sure"] for line in rows):
        raise draw.Problem(f"{name}: no figure has converged")
    figure = KINDS[a["kind"]](a, run, rows, [Series(part) for part in a["series"].split(";")] if "series" in a else [])
    layout.check(name, figure)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    pyplot.close(figure)
    return "".join(line.rstrip() + "\n" for line in text.getvalue().splitlines())
