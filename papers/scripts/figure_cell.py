# SPDX-License-Identifier: Apache-2.0
"""The figure of papers/numerics.md: a ray over one cell, from above and from the side, with the names used there."""

from matplotlib import pyplot

RAY, SURFACE, HIT, GREY = "#1f6fb4", "#8c5a2b", "#b5443c", "#666666"
ORG, DIR = (-0.55, 0.10), (1.0, 0.38)  # from above, in cells from (i, j)
CROSSINGS = {"t(i)": -ORG[0] / DIR[0], "diagonal": (ORG[0] - ORG[1]) / (DIR[1] - DIR[0]), "t(i + 1)": (1 - ORG[0]) / DIR[0]}


def at(t):
    return ORG[0] + t * DIR[0], ORG[1] + t * DIR[1]


def from_above(axes):
    axes.set_title("from above", loc="left")
    axes.plot([0, 1, 1, 0, 0, 1], [0, 0, 1, 1, 0, 1], color=SURFACE)
    for x, y, name in ((0, 0, "h00"), (1, 0, "h10"), (0, 1, "h01"), (1, 1, "h11")):
        axes.plot(x, y, "o", color=SURFACE)
        axes.text(x + (0.04 if x else -0.04), y + (0.07 if y else -0.07), f"{name} at {'(i + 1' if x else '(i'}, "
                  f"{'j + 1)' if y else 'j)'}", ha="left" if x else "right", va="center", color=SURFACE, fontsize=8)
    axes.text(0.70, 0.16, "triangle A\nx − i ≥ y − j", ha="center", va="center", color=GREY, fontsize=8)
    axes.text(0.30, 0.82, "triangle B\nx − i < y − j", ha="center", va="center", color=GREY, fontsize=8)
    axes.annotate("", at(1.98), ORG, arrowprops={"arrowstyle": "->", "color": RAY, "linewidth": 1.6})
    axes.plot(*ORG, "o", color=RAY)
    axes.text(ORG[0] + 0.08, ORG[1] + 0.07, "org = (ox, oy, oz)", color=RAY, ha="right", va="bottom", fontsize=8)
    axes.text(*at(2.03), "dir =\n(dx, dy, dz)", color=RAY, ha="left", va="center", fontsize=8)
    labels = {"t(i)": ("enters at t(i)", (-6, 9), "right"), "diagonal": ("diagonal\nat td", (-9, 3), "right"),
              "t(i + 1)": ("leaves at t(i + 1)", (7, -12), "left")}
    for name, (text, shift, ha) in labels.items():
        axes.plot(*at(CROSSINGS[name]), "o", color=RAY)
        axes.annotate(text, at(CROSSINGS[name]), shift, textcoords="offset points", color=RAY, fontsize=8, ha=ha)
    axes.set_xlim(-1.16, 1.98)
    axes.set_ylim(-0.35, 1.42)
    axes.set_aspect("equal")
    axes.axis("off")


def from_the_side(axes):
    axes.set_title("along the ray", loc="left")
    t, surface = list(CROSSINGS.values()), (0.30, 0.42, 0.80)
    ray = [1.0 - 0.62 * (when - t[0]) for when in t]
    ends = [t[0] - 0.25, t[2] + 0.3]
    axes.plot(ends, [1.0 - 0.62 * (when - t[0]) for when in ends], color=RAY)
    axes.plot(t, surface, "o-", color=SURFACE)
    axes.text(ends[0] + 0.06, 1.16, "ray: oz + t dz", color=RAY, fontsize=8)
    axes.text(t[0] + 0.08, 0.26, "surface", color=SURFACE, fontsize=8)
    for name, when, above, below in zip(("d(t(i)) > 0", "d(td) > 0", "d(t(i + 1)) < 0"), t, ray, surface):
        axes.annotate("", (when, above), (when, below),
                      arrowprops={"arrowstyle": "<->", "color": GREY, "shrinkA": 3, "shrinkB": 1})
        axes.plot([when, when], [0.02, min(above, below)], ":", color="#bbbbbb", linewidth=0.9)
        right = when == t[2]
        axes.text(when + (0.03 if right else -0.03), (above + below) / 2, name, color=GREY, fontsize=8, va="center",
                  ha="left" if right else "right")
    share = (ray[1] - surface[1]) / ((ray[1] - surface[1]) - (ray[2] - surface[2]))
    hit = t[1] + (t[2] - t[1]) * share, surface[1] + (surface[2] - surface[1]) * share
    axes.plot(*hit, "o", color=HIT, markersize=6)
    axes.annotate("hit: the root of d between\nta = td and tb = t(i + 1)", hit, (t[1] + 0.26, 1.08), color=HIT, fontsize=8,
                  ha="left", arrowprops={"arrowstyle": "-", "color": HIT, "linewidth": 0.7})
    for name, when in zip(("t(i)", "td", "t(i + 1)"), t):
        axes.text(when, -0.02, name, color=RAY, ha="center", va="top", fontsize=8)
    axes.annotate("", (ends[1] + 0.1, 0.02), (ends[0], 0.02), arrowprops={"arrowstyle": "->", "color": GREY})
    axes.text(ends[1] + 0.12, 0.02, "t", va="center", color=GREY)
    axes.set_xlim(ends[0] - 0.22, ends[1] + 0.3)
    axes.set_ylim(-0.14, 1.28)
    axes.axis("off")


def draw():
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8.4, 3.1), gridspec_kw={"width_ratios": (1.25, 1)})
    figure.subplots_adjust(left=0.012, right=0.985, bottom=0.01, top=0.92, wspace=0.02)
    from_above(left)
    from_the_side(right)
    return figure
