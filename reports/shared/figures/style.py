"""How every figure looks: one style, readable in colour, in grey, on a phone and on paper.

Colours are those of Okabe and Ito, which the colour-blind tell apart; since
print may be grey, what differs in colour also differs in line style or carries
its label.  Text stays text, which can be searched and selected; Verdana, of the same widths, stands in where
DejaVu Sans is not installed.
"""

import io
import re
from collections.abc import Mapping
from contextlib import AbstractContextManager
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.shared.figures.curves import attributes, panels, with_attributes
from reports.shared.units import relabel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY, PALE = "#6b6b6b", "#d9d9d9"
FAINT = "#a3a3a3"
"""Colour of the curves that stand behind."""

DASHED, DOTTED, DASH_DOT, LONG = (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 2, 1.2, 2)), (0, (9, 3))
LINES: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linestyle": "-"},
    {"color": VERMILLION, "linestyle": DASHED},
    {"color": GREEN, "linestyle": DASH_DOT},
    {"color": PURPLE, "linestyle": LONG},
    {"color": ORANGE, "linestyle": DOTTED},
    {"color": SKY, "linestyle": (0, (3, 1, 1, 1, 1, 1))},
)
"""Colour and line style of the first, second, ... series of a figure."""

CONTROLLER_LINES: Mapping[str, dict[str, Any]] = {
    "tuned": {"color": BLUE, "linestyle": "-", "linewidth": 2.2},
    "paper": {"color": BLACK, "linestyle": DASHED},
    "SIMC": {"color": ORANGE, "linestyle": DASH_DOT},
    "AMIGO": {"color": GREEN, "linestyle": LONG},
    "Ziegler-Nichols": {"color": PURPLE, "linestyle": DOTTED, "linewidth": 1.9},
    "convex-concave PI": {"color": VERMILLION, "linestyle": (0, (3, 1, 1, 1, 1, 1))},
    "robust LQI": {"color": SKY, "linestyle": (0, (2.4, 0.9)), "linewidth": 2.0},
    "PI + feedforward": {"color": "#882255", "linestyle": (0, (12, 1.0)), "linewidth": 2.2},
    "cascade PI": {"color": "#44AA99", "linestyle": (0, (5, 1.2))},
    "feedforward": {"color": GREY, "linestyle": (0, (4, 1.2)), "linewidth": 1.8},
    "robust PI": {"color": "#1B5E20", "linestyle": (0, (5, 1, 1, 1))},
    "linear MPC": {"color": "#332288", "linestyle": (0, (1, 0.7)), "linewidth": 2.0},
    "real-time MPC": {"color": "#999933", "linestyle": (0, (10, 1.5, 1, 1.5)), "linewidth": 2.0},
    "PI tuned without dead time": {"color": "#EE6677", "linestyle": (0, (7, 1.5))},
    "robust MPC": {"color": "#7B4A12", "linestyle": (0, (2, 1.4)), "linewidth": 2.0},
}
"""One colour a controller in all outputs: those of Okabe and Ito, then darker ones after Tol."""

WIDTH = 5.8
"""Width of a figure [inch]: between a phone and paper, so that its letters are read on both."""

POINTS = 1500
"""A curve is thinned to about this many points: more cannot be seen, and a page must stay light."""

STYLE: Mapping[Any, Any] = {
    "font.family": "DejaVu Sans",  # ships with matplotlib
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#444444",
    "axes.grid": True,
    "axes.formatter.useoffset": False,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.7,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 9,
    "legend.handlelength": 3.0,
    "hatch.linewidth": 0.6,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "mathtext.default": "regular",
}


def styled() -> AbstractContextManager[None]:
    """The context in which figures are drawn; it leaves no trace in matplotlib's settings."""
    import matplotlib

    return matplotlib.rc_context(dict(STYLE))


def new_figure(
    rows: int = 1, columns: int = 1, height: float = 3.2, width: float = WIDTH, **grid: Any
) -> "tuple[Figure, list[Axes]]":
    """An empty figure of `width` x `height` [inch] and its axes, row by row.

    `grid` goes to ``Figure.subplots``.  Call it, and draw, within `styled`.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **grid)
    return figure, list(axes.ravel())


def seen(count: int, points: int = POINTS) -> slice:
    """Which of `count` points of a curve to draw.

    >>> seen(10_000), seen(700)
    (slice(None, None, 6), slice(None, None, 1))
    """
    return slice(None, None, max(1, count // points))


def controller_line(name: str, position: int = 0) -> dict[str, Any]:
    """Colour and line style of a controller; of an unknown one, by its position among them."""
    return dict(CONTROLLER_LINES.get(name, LINES[position % len(LINES)]))


def svg(figure: "Figure", name: str, description: str = "") -> str:
    """The figure as an SVG element to be put into a page, scaling with the page's width.

    name: unique within the page; it goes before every id, since several figures
    share a page's ids.  description: what those hear who cannot see the figure.
    The same figure gives the same text: no dates, ids hashed from the name.  Coordinates are rounded
    to a hundredth of a point, which no screen and no printer shows.
    """
    import matplotlib

    if not re.fullmatch(r"[A-Za-z][\w-]*", name):
        raise ValueError(f"{name!r} cannot go before an id; letters, digits, - and _ only")
    buffer = io.StringIO()
    relabel(figure)
    _no_formulas(figure)
    of = attributes(figure)
    own = {artist: artist.get_gid() for artist in of}
    marks = {f"curve-{place}": said for place, said in enumerate(of.values())}
    for artist, mark in zip(of, marks, strict=True):
        artist.set_gid(mark)
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    for artist, gid in own.items():
        artist.set_gid(gid)
    text = with_attributes(buffer.getvalue(), marks)
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = _light(text)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'((?:xlink:)?href="#|url\(#)', rf"\g<1>{name}-", text)
    width = figure.get_size_inches()[0]
    head = (
        f'<svg class="figure" role="img" aria-label="{escape(description or name, quote=True)}" '
        f'style="--wide:{width:g}in" data-panels="{escape(panels(figure))}" '
    )
    opening = re.sub(r'\s(?:width|height)="[^"]*"', "", text[: text.index(">") + 1], count=2)
    return head + opening.removeprefix("<svg").lstrip() + text[text.index(">") + 1 :].strip()


def _no_formulas(figure: "Figure") -> None:
    """Draw dollar signs in titles and names as they are; axes put some around their powers."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        if "$" in text.get_text() and r"\mathdefault" not in text.get_text():
            text.set_parse_math(False)


def _light(text: str) -> str:
    """An SVG with coordinates rounded, without the ids that nothing refers to and without blanks at the
    ends of its lines; ids that are left are numbered: they are hashes of coordinates before rounding, which
    differ in the last digit from run to run."""
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    ids = [name for name in re.findall(r' id="([^"]*)"', text) if name in used]
    names = {n: f"i{place}" for place, n in enumerate(ids)}
    text = re.sub(
        r' id="([^"]*)"', lambda m: f' id="{names[m.group(1)]}"' if m.group(1) in names else "", text
    )
    text = re.sub(
        r'((?:href="#|url\(#))([^")]+)', lambda m: m.group(1) + names.get(m.group(2), m.group(2)), text
    )
    text = text.replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")
    for where in (r'(?<=\sd=")[^"]+', r'(?<=\s[xy]=")[^"]+', r"(?:translate|rotate)\([^)]+"):
        text = re.sub(where, lambda m: _LONG.sub(_rounded, m.group(0)), text)
    return re.sub(r"\s*\n\s*", "\n", text)


_LONG = re.compile(r"-?\d+\.\d{3,}")


def _rounded(number: re.Match[str]) -> str:
    return f"{float(number.group(0)):.2f}".rstrip("0").rstrip(".")


def save(figure: "Figure", path: str | Path, dpi: int = 200) -> Path:
    """Write the figure as .png or .svg, by the ending of `path`, complete or not at all.

    Raises InputError where the place cannot be written to, ValueError for another ending.
    """
    import matplotlib

    from plants.files import write_atomically

    path = Path(path)
    ending = path.suffix.lower().removeprefix(".")
    if ending not in ("png", "svg"):
        raise ValueError(f"{path}: figures are written as .png or .svg")
    buffer = io.BytesIO()
    relabel(figure)
    _no_formulas(figure)
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": path.stem}):
        metadata = {"Software": None} if ending == "png" else {"Date": None}
        figure.savefig(buffer, format=ending, dpi=dpi, metadata=metadata)
    write_atomically(path, buffer.getvalue())
    return path
