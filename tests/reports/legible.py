"""What is wrong with the text of a figure: it leaves the canvas, overlaps another, or a line crosses it."""

from itertools import combinations
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

SLACK = 1.5
"""Points by which boxes may touch: they are drawn around the tallest letters of a font."""


def faults(figure: Any) -> list[str]:
    """Each fault in words; empty where all text of a figure can be read."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    slack = SLACK * figure.dpi / 72.0
    # Of an annotation the text alone, not the line that joins it to its point.
    boxes = [(t.get_text(), Text.get_window_extent(t, renderer)) for t in _drawn(figure)]
    canvas_box = figure.bbox
    found = [
        f"{text!r} leaves the canvas"
        for text, b in boxes
        if b.x0 < canvas_box.x0 - slack
        or b.y0 < canvas_box.y0 - slack
        or b.x1 > canvas_box.x1 + slack
        or b.y1 > canvas_box.y1 + slack
    ]
    for (one, a), (other, b) in combinations(boxes, 2):
        wide = min(a.x1, b.x1) - max(a.x0, b.x0)
        high = min(a.y1, b.y1) - max(a.y0, b.y0)
        if wide > slack and high > slack:
            found.append(f"{one!r} overlaps {other!r}")
    return found + [f"a line runs through {text!r}" for text in _struck(figure, renderer)]


def _struck(figure: Any, renderer: Any) -> list[str]:
    """Texts of a panel through whose letters one of its lines runs, or the leader of another; an opaque patch
    hides the line."""
    found = []
    leaders = [
        (t, t.arrow_patch.get_transform().transform_path(t.arrow_patch.get_path()))
        for t in figure.findobj(Annotation)
        if t.get_visible() and t.arrow_patch is not None
    ]
    for axes in figure.axes:
        lines = [
            line
            for line in axes.lines
            if line.get_visible() and line.get_linestyle() not in ("None", "none", " ", "")
        ]
        for text in axes.texts:
            if not text.get_visible() or not text.get_text().strip() or text.get_bbox_patch() is not None:
                continue
            box = Text.get_window_extent(text, renderer)
            # Of the box of the tallest letters, the middle: where the small ones are.
            letters = Bbox.from_extents(box.x0, box.y0 + 0.3 * box.height, box.x1, box.y1 - 0.3 * box.height)
            near = [_path(line) for line in lines] + [path for of, path in leaders if of is not text]
            if any(path.intersects_bbox(letters, filled=False) for path in near):
                found.append(text.get_text())
    return found


def _path(line: Any) -> Any:
    """A line as it is on the screen."""
    return line.get_transform().transform_path(line.get_path())


def _drawn(figure: Any) -> list[Text]:
    """The texts that are drawn: tick labels within the view, and all others that are visible."""
    ticks: set[int] = set()
    seen: list[Text] = []
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                for label in (tick.label1, tick.label2):
                    ticks.add(id(label))
                    if axes.get_visible() and label.get_visible() and low <= tick.get_loc() <= high:
                        seen.append(label)
    hidden = {id(t) for a in figure.axes if not a.get_visible() for t in a.findobj(Text)}
    seen += [t for t in figure.findobj(Text) if id(t) not in ticks | hidden]
    return [t for t in seen if t.get_visible() and t.get_text().strip()]
