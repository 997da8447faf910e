"""Files of an exported law, from the templates beside: C, its header, README, test program, Makefile."""

from functools import cache
from html import escape
from importlib.metadata import version
from math import isfinite, isnan
from textwrap import fill, wrap
from typing import Any

from design.controllers.measurement.plausible import UNSEEN
from design.export.part import Part, Watched


def render(template: str, part: Part, **values: Any) -> str:
    """A file of a part; values: what its template needs beside.  The same for the same law whenever and
    wherever it is exported."""
    common = {
        "out": part.output.member,
        "a": part.sensors.angle, "p": part.sensors.pressure, "UNSEEN": UNSEEN,
        "real": part.real, "single": part.precision == "single",
    }  # fmt: skip
    return render_named(template, part.name, part=part, **common, **values)


def render_named(template: str, name: str, **values: Any) -> str:
    """A file of what is exported under a name, which begins those in C; values: what its template needs."""
    own = {"n": name, "N": name.upper(), "version": VERSION}
    return str(_environment().get_template(template).render(**own, **values))


VERSION = version("wrist-workbench")


@cache
def _environment() -> Any:
    import jinja2

    made = jinja2.Environment(
        loader=jinja2.PackageLoader("design.export", "templates"),
        autoescape=False,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    made.filters |= {"repr": repr, "number": number, "fill": lambda text: fill(text, 110), "cell": cell}
    made.globals |= {"comment": comment, "believed": believed}
    return made


def cell(text: str) -> str:
    """A text of a rig's file as a table of Markdown takes it, and as what is no markup.

    >>> cell("a|<b>\\nc")
    'a&#124;&lt;b&gt; c'
    """
    return escape(" ".join(text.split())).replace("|", "&#124;")


def believed(watched: Watched, value: str) -> str:
    """The call in C that says whether a sensor's value is believed."""
    c, indent = watched.channel, " " * 18
    limits = ", ".join(repr(x) for x in (c.low, c.high, c.jump, c.rate))
    return f"believed({value}, &state->{watched.last}, &state->{watched.age},\n{indent}{limits})"


def number(value: float) -> str:
    """A number of C, also one that is none.

    >>> number(0.1), number(float("nan"))
    ('0.1', 'NAN')
    """
    return repr(value) if isfinite(value) else "NAN" if isnan(value) else "INFINITY"


def comment(*paragraphs: str) -> str:
    """A block comment, its lines at most 100 characters long."""
    lines = [
        line for p in paragraphs for line in (wrap(p, 96, subsequent_indent="  " * p.startswith(" ")) or [""])
    ]
    text = "\n".join(f"   {line}".rstrip() for line in lines).replace("*/", "* /")
    return "/*" + text[2:] + " */"
