"""A page as one file: templates rendered with everything inside, and what made the page."""

import os
import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from plants.parameters.quantities import Fitted, ParameterSet
from reports.shared.glossary import with_tooltips
from reports.shared.units import page_in_units

DISTRIBUTION = "wrist-workbench"
SYNTHETIC = "The example campaigns are synthetic: they come from a simulator, not from a rig."


@dataclass(frozen=True)
class Made:
    """What made a page: version of the workbench and its commit, the command line, the seed, the
    titles of the parameter sets by motion, SHA-256 of the data by name, and a remark that a reader
    has to know, such as that the recordings are synthetic."""

    version: str
    commit: str
    command: str
    seed: int | None
    sets: Mapping[str, str] = field(default_factory=dict)
    data: Mapping[str, str] = field(default_factory=dict)
    remark: str = ""

    @classmethod
    def now(
        cls,
        command: str,
        seed: int | None = None,
        sets: Mapping[str, ParameterSet] | None = None,
        data: Mapping[str, str] | None = None,
        remark: str = "",
    ) -> "Made":
        """The provenance of a page that this installation is about to make; data and remark, where none is
        given, are those of the fits that the sets come from."""
        titles = {motion: s.title for motion, s in (sets or {}).items()}
        known = dict(data or data_of(sets or {}))
        return cls(version(), commit(), command, seed, titles, known, remark or remark_on(known))


@dataclass(frozen=True)
class Shown:
    """A figure in a page: SVG ready to be put in, the words beneath, and data for the page's script."""

    svg: Any
    caption: str
    data: Any = ""


def data_of(sets: Mapping[str, ParameterSet]) -> dict[str, str]:
    """SHA-256, as far as it is noted, of the campaigns that parameters were fitted to, by name.

    >>> from plants.parameters.files import built_in
    >>> plant = built_in("flexion")
    >>> data_of({"flexion": plant.fitted({"a1": 0.36}, {"a1": 0.001}, "bench (sha256 0123456789ab)")})
    {'bench': '0123456789ab'}
    """
    fits = [p.provenance for s in sets.values() for p in s.parameters.values()]
    noted = (re.fullmatch(r"(.+) \(sha256 (\w+)\)", f.data) for f in fits if isinstance(f, Fitted))
    return {m[1]: m[2] for m in noted if m}


def remark_on(data: Mapping[str, str]) -> str:
    """That data is synthetic, where campaigns that ship with the project are among it; else nothing.

    >>> remark_on({"flexion": "0123456789ab"})
    ''
    """
    from plants.measured.campaigns.campaign import load_campaign, shipped

    for folder in shipped():
        noted = data.get(folder.name)
        if noted and load_campaign(folder).checksum.startswith(noted):
            return SYNTHETIC
    return ""


def version() -> str:
    """Version of the installed workbench, ``unknown`` where it is not installed."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed(DISTRIBUTION)
    except PackageNotFoundError:
        return "unknown"


def commit(root: Path | None = None) -> str:
    """Commit of the checkout that this file belongs to, with ``-dirty`` where files differ from it;
    ``not in a checkout`` for an installed package."""
    root = root or Path(__file__).resolve().parents[2]
    top = _git(root, "rev-parse", "--show-toplevel")
    # An installed package may lie inside a checkout of something else.
    if top is None or Path(top).resolve() != root:
        return "not in a checkout"
    return _git(root, "describe", "--always", "--abbrev=12", "--dirty", "--exclude=*") or "no commit yet"


def _git(root: Path, *words: str) -> str | None:
    environment = {**os.environ, "GIT_OPTIONAL_LOCKS": "0"}  # looking must not write
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *words], capture_output=True, text=True, timeout=10, env=environment
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def render(template: str, **content: Any) -> str:
    """A template of ``reports/templates`` with its content, as one HTML text.

    Strings are escaped; SVG goes in as ``markup(svg)``.  Figures and tables are numbered in the order in
    which they stand.  Every template needs what ``base.html`` shows: title, kind (what kind of report of
    what), summary (three sentences), remarks, sections (titles by id, in their order) and made.  Raises
    ``jinja2.UndefinedError`` for content that the template needs and did not get.
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"figure_number": count(1).__next__, "table_number": count(1).__next__}
    page = environment.get_template(template).render(**content)
    return page_in_units(with_tooltips(page))


def markup(text: str) -> Any:
    """Text that is HTML already and is to be put into a page as it is."""
    from markupsafe import Markup

    return Markup(text)
