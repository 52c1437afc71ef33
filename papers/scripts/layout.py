# SPDX-License-Identifier: Apache-2.0
"""The check that nothing in a picture is cut off and no label lies on another, measured with matplotlib's own renderer."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from draw import Problem


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
