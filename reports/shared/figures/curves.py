"""What the script of a page (`templates/curves.js`) needs to know of a figure.

Which of its groups are curves, which are their labels, and how the coordinates of its panels read in data.
"""

import json
import re
from collections.abc import Iterator, Mapping
from html import escape
from itertools import chain
from typing import TYPE_CHECKING, Any

from reports.shared.units import in_units

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS_PER_INCH = 72.0


def attributes(figure: "Figure") -> dict["Artist", str]:
    """Attributes of the SVG group of every named curve and of every label that names one.

    A curve's name is its group id (``gid=`` where it is drawn), else its label in legends; a text that reads
    as a name, in a legend or beside a curve, is its label.
    """
    found: dict[Artist, str] = {}
    names: set[str] = set()
    for place, axes in enumerate(figure.axes):
        for artist in chain(axes.lines, axes.collections, axes.patches):
            if name := _name(artist):
                names.add(name)
                panel = f' data-panel="{place}"' if artist in axes.lines and _scales(axes) else ""
                found[artist] = f'data-curve="{escape(name)}"{panel}'
    return found | {label: f'data-of="{escape(n)}"' for label, n in _labels(figure) if n in names}


def _name(artist: "Artist") -> str:
    label = artist.get_gid() or str(artist.get_label())
    return "" if label.startswith("_") else in_units(label)


def _labels(figure: "Figure") -> "Iterator[tuple[Artist, str]]":
    """Texts beside curves, and those of legends with the samples of lines before them, with what they say."""
    for axes in figure.axes:
        yield from ((text, text.get_text()) for text in axes.texts)
    for legend in chain(figure.legends, (axes.get_legend() for axes in figure.axes)):
        if legend is not None:
            for sample, text in zip(legend.legend_handles, legend.texts, strict=True):
                yield text, text.get_text()
                if sample is not None:
                    yield sample, text.get_text()


def panels(figure: "Figure") -> str:
    """How the coordinates of each panel of a drawn figure read in data, as JSON: of x and of y, between which
    coordinates the panel lies, its limits there, whether its scale is logarithmic, and its label."""
    wide, high = (POINTS_PER_INCH * size for size in figure.get_size_inches())
    found = []
    for axes in figure.axes:
        box = axes.get_position()
        x = _side(axes, "x", wide * box.x0, wide * box.x1)
        found.append([x, _side(axes, "y", high * (1.0 - box.y0), high * (1.0 - box.y1))])
    return json.dumps(found, separators=(",", ":"))


def _side(axes: "Axes", which: str, start: float, end: float) -> Mapping[str, Any]:
    limits, scale = getattr(axes, f"get_{which}lim")(), getattr(axes, f"get_{which}scale")()
    together = getattr(axes, f"get_shared_{which}_axes")().get_siblings(axes)
    said = [getattr(a, f"get_{which}label")() for a in (axes, *together)]
    return {
        "from": round(start, 1), "to": round(end, 1), "low": float(limits[0]), "high": float(limits[1]),
        "log": scale == "log", "label": next((s for s in said if s), which),
    }  # fmt: skip


def _scales(axes: "Axes") -> bool:
    """Whether a panel's coordinates can be read."""
    return {axes.get_xscale(), axes.get_yscale()} <= {"linear", "log"}


def with_attributes(text: str, marks: Mapping[str, str]) -> str:
    """An SVG in which groups carry attributes instead of the ids that stand for them.

    >>> with_attributes('<g id="curve-0">', {"curve-0": 'data-curve="recommended PI"'})
    '<g data-curve="recommended PI">'
    """
    return re.sub(r'id="([^"]+)"', lambda m: marks.get(m[1], m[0]), text)
