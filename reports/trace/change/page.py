"""Two campaigns of one rig as a page for a colleague, and beside it the same as JSON and pictures."""

from pathlib import Path
from typing import TYPE_CHECKING

from design.studies.check.campaigns import CampaignChange
from reports.shared.figures.style import BLACK, GREY, ORANGE, new_figure, styled
from reports.shared.html import Made, render
from reports.shared.page import shown, write_page
from reports.shared.residuals import CAPTION, COLUMNS, channel_rows, draw_residuals
from reports.shared.tables import Column, Group, Table, number, row, with_error
from reports.trace.change import words
from reports.trace.change.record import change_record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SECTIONS = {
    "parameters": "Parameters before and after", "effects": "Effects",
    "residual": "Residual of the old plant",
}  # fmt: skip
"""Titles of the page's sections by their ids."""


def write_change(folder: str | Path, change: CampaignChange, made: Made) -> Path:
    """Write change.html, change.json and the figures as PNG into a folder, each complete or not at all.
    Returns the path of the page; raises InputError where it cannot be written."""
    worst = words.most_off(change)
    drawn = {
        "differences": draw_differences(change),
        "residual": draw_residuals(worst.recording, worst.channels),
    }
    captions = {
        "differences": words.parameter_caption(),
        "residual": f"{worst.recording.name}, with the largest residual of the old plant. {CAPTION}",
    }
    page = render(
        "change.html", made=made, title=words.title(change),
        kind=f"two campaigns of {change.campaign.axis}", sections=SECTIONS, summary=words.summary(change),
        remarks=words.remarks(change), intervals=words.interval_words(change.parameters),
        parameters=parameter_table(change), effects=effect_table(change), channels=channel_table(change),
        **shown(drawn, captions),
    )  # fmt: skip
    return write_page(Path(folder), "change", page, change_record(change), drawn)


def draw_differences(change: CampaignChange) -> "Figure":
    """A row a parameter: its difference in per cent of the old value, with its interval."""
    determined = [p for p in change.parameters if p.old != 0.0]
    with styled():
        figure, (at,) = new_figure(1, 1, 0.8 + 0.26 * len(determined))
        for place, p in enumerate(determined):
            low, middle, high = sorted(100.0 * v / p.old for v in (p.low, p.difference, p.high))
            color = ORANGE if p.differs else BLACK
            at.plot((low, high), (place, place), color=color, lw=1.6, solid_capstyle="butt")
            at.plot(middle, place, "o", color=color, ms=4)
        at.axvline(0.0, color=GREY, lw=0.8)
        at.set_yticks(range(len(determined)), [p.name for p in determined])
        at.set(xlabel="Difference [% of the old value]", ylim=(len(determined) - 0.5, -0.5))
        at.grid(axis="y", visible=False)
    return figure


def parameter_table(change: CampaignChange) -> Table:
    """Each parameter in both campaigns, and the interval of the difference."""
    columns = (
        Column("Parameter", number=False), Column("Unit", number=False), Column("Old"), Column("New"),
        Column("Difference, joint interval"),
    )  # fmt: skip
    groups = []
    for stage in dict.fromkeys(p.stage for p in change.parameters):
        of = [p for p in change.parameters if p.stage == stage]
        rows = tuple(row(p.name, p.unit, number(p.old, 4), number(p.new, 4), words.difference(p)) for p in of)
        groups.append(Group(stage, rows, tuple(i for i, p in enumerate(of) if p.differs)))
    return Table(columns, tuple(groups))


def effect_table(change: CampaignChange) -> Table:
    """Effects of either campaign, and of those that came their parameters."""
    rows = [row(n, "in both", "–") for n in change.kept] + [row(n, "disappeared", "–") for n in change.went]
    for e in change.came:
        values = ", ".join(f"{n} {with_error(v, s)} {unit}" for n, (v, unit, s) in e.parameters.items())
        rows.append(row(e.name, "appeared", values))
    columns = tuple(Column(h, number=False) for h in ("Effect", "Campaigns", "Parameters where it appeared"))
    return Table(columns, (Group("", tuple(rows) or (row("none", "–", "–"),)),))


def channel_table(change: CampaignChange) -> Table:
    """The residual of the old plant in each recording."""
    groups = tuple(Group(r.recording.name, channel_rows(r.channels)) for r in change.residuals)
    return Table(COLUMNS, groups)
