# SPDX-License-Identifier: Apache-2.0
"""Where things lie in a picture: axes that follow their data, and the check that nothing is cut off and no
label lies on another. The check measures with matplotlib's own renderer."""

import math

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator
from matplotlib.transforms import Bbox

from draw import Problem

def log_limits(values, share=0.08):
    """Limits of a logarithmic axis: those of the values, and a share of their range more on each side."""
    low, high = min(values), max(values)
    room = share * (math.log(high / low) if high > low else 1)
    return low * math.exp(-room), high * math.exp(room)


def log_axis(axis, limits, steps=(1, 3), text="{:g}".format):
    """Logarithmic, with ticks at these steps of each decade."""
    low, high = limits
    axis.axes.set(**{f"{axis.axis_name}scale": "log", f"{axis.axis_name}lim": limits})
    ticks = [step * 10.0 ** decade for decade in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
             for step in steps if low <= step * 10.0 ** decade <= high]
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_ticklabels([text(tick) for tick in ticks])
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


# ---- boxes ----

def _renderer(figure):
    canvas = figure.canvas if isinstance(figure.canvas, FigureCanvasAgg) else FigureCanvasAgg(figure)
    canvas.draw()
    return canvas.get_renderer()


def _box(text, renderer):
    """The letters alone; an annotation's arrow may point anywhere."""
    if isinstance(text, Annotation):
        text.update_positions(renderer)
    return Text.get_window_extent(text, renderer).padded(-0.5)


def _points(axes):
    """Pixels of the points of all lines in data coordinates, and half the size of each marker."""
    for line in axes.lines:
        if line.get_visible() and line.get_transform() == axes.transData:
            size = line.get_markersize() * axes.figure.dpi / 144 if line.get_marker() not in ("None", None, "") else 0
            for point in axes.transData.transform(line.get_xydata()):
                yield point, size


def _holds(outer, box, room=1):
    return (box.x0 >= outer.x0 - room and box.y0 >= outer.y0 - room and box.x1 <= outer.x1 + room and
            box.y1 <= outer.y1 + room)


def _meet(a, b):
    return min(a.x1, b.x1) > max(a.x0, b.x0) and min(a.y1, b.y1) > max(a.y0, b.y0)


def _texts(figure):
    """(text, its axes or None, whether it is a label inside them) of all that is written."""
    for text in [*figure.texts, *(t for legend in figure.legends for t in legend.get_texts())]:
        yield text, None, False
    for axes in figure.axes:
        if not axes.get_visible():
            continue
        for text in axes.texts:
            yield text, axes, True
        others = [axes.title, axes._left_title, axes._right_title]
        if axes.axison:
            for axis in (axes.xaxis, axes.yaxis):
                if axis.get_visible():
                    low, high = sorted(axis.get_view_interval())
                    others += [axis.label, *(tick.label1 for tick in axis.get_major_ticks()
                                             if low <= tick.get_loc() <= high)]
        legend = axes.get_legend()
        for text in [*others, *(legend.get_texts() if legend else [])]:
            yield text, axes, False


def faults(figure):
    """One line for each point or label outside its axes or the picture, and for each two labels that overlap."""
    renderer, found, boxes = _renderer(figure), [], []
    for axes in figure.axes:
        if not axes.get_visible():
            continue
        frame = axes.get_window_extent(renderer)
        for (x, y), size in _points(axes):
            if not _holds(frame, Bbox.from_extents(x - size, y - size, x + size, y + size)):
                where = axes.transData.inverted().transform((x, y))
                found.append(f"the point ({where[0]:g}, {where[1]:g}) lies outside the axes {axes.get_title(loc='left')}")
        for patch in axes.patches:
            if patch.get_visible() and not _holds(frame, patch.get_window_extent(renderer)):
                found.append(f"a bar lies outside the axes {axes.get_title(loc='left')}")
    for text, axes, inside in _texts(figure):
        if not text.get_visible() or not text.get_text().strip():
            continue
        box, words = _box(text, renderer), " ".join(text.get_text().split())
        if not _holds(figure.bbox, box):
            found.append(f'"{words}" lies outside the picture')
        elif inside and not _holds(axes.get_window_extent(renderer), box, 2):
            found.append(f'"{words}" lies outside its axes')
        found += [f'"{words}" overlaps "{other}"' for other, taken in boxes if _meet(box, taken)]
        boxes.append((words, box))
    return found


def check(name, figure):
    found = faults(figure)
    if found:
        raise Problem("\n".join(f"{name}: {fault}" for fault in found))

