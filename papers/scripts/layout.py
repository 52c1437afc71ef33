# SPDX-License-Identifier: Apache-2.0
"""Where things lie in a picture: axes that follow their data, and the check that nothing is cut off and no
label lies on another. The check measures with matplotlib's own renderer."""

import math

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
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


def _holds(outer, box, room=1):
    return outer.padded(room).containsx(box.x0) and outer.padded(room).containsx(box.x1) and outer.padded(room).containsy(
        box.y0) and outer.padded(room).containsy(box.y1)


def _outside(axes, renderer):
    """Points of lines, markers included, and bars that are not within the axes."""
    frame, title = axes.get_window_extent(renderer), axes.get_title(loc="left")
    for line in axes.lines:
        size = line.get_markersize() * axes.figure.dpi / 144 if line.get_marker() not in ("None", None, "") else 0
        for (x, y), at in zip(axes.transData.transform(line.get_xydata()), line.get_xydata(), strict=True):
            if not _holds(frame, Bbox.from_extents(x - size, y - size, x + size, y + size)):
                yield f"the point ({at[0]:g}, {at[1]:g}) lies outside the axes {title}"
    for patch in axes.patches:
        if not _holds(frame, patch.get_window_extent(renderer)):
            yield f"a bar lies outside the axes {title}"


def faults(figure):
    """One line for each point or label outside its axes or the picture, and for each two labels that overlap."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    found = [fault for axes in figure.axes for fault in _outside(axes, renderer)]
    inside = {text: axes for axes in figure.axes for text in axes.texts}
    boxes, unseen = [], {tick.label1 for axes in figure.axes for axis in (axes.xaxis, axes.yaxis) for tick in axis.get_major_ticks()
                         if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())}
    for text in figure.findobj(lambda artist: isinstance(artist, Text) and artist.get_visible() and artist.get_text().strip()):
        if text in unseen:
            continue
        box, words = text.get_window_extent(renderer).padded(-0.5), " ".join(text.get_text().split())
        if not _holds(figure.bbox, box):
            found.append(f'"{words}" lies outside the picture')
        elif text in inside and not _holds(inside[text].get_window_extent(renderer), box, 2):
            found.append(f'"{words}" lies outside its axes')
        found += [f'"{words}" overlaps "{other}"' for other, taken in boxes if box.overlaps(taken)]
        boxes.append((words, box))
    return found


def check(name, figure):
    found = faults(figure)
    if found:
        raise Problem("\n".join(f"{name}: {fault}" for fault in found))
