"""A check as a page for a colleague, and beside it the same as JSON and pictures."""

from pathlib import Path
from typing import TYPE_CHECKING

from design.studies.check.check import LogCheck
from design.studies.check.stairs import BAND
from reports.check import words
from reports.check.record import check_record
from reports.shared.figures.style import BLACK, GREY, ORANGE, new_figure, seen, styled
from reports.shared.html import Made, render
from reports.shared.page import shown, write_page
from reports.shared.residuals import CAPTION, COLUMNS, channel_rows, draw_residuals
from reports.shared.tables import Cell, Column, Group, Table, number, row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WITHIN = {"settling time": f" to ±{100 * BAND:g} %"}
"""What a metric is relative to, where a design has another: a band that noise does not leave again."""

SECTIONS = {"envelope": "The log and the prediction", "residual": "Residual of the plant model"}
"""Titles of the page's sections by their ids."""


def write_check(folder: str | Path, check: LogCheck, made: Made) -> Path:
    """Write check.html, check.json and the figures as PNG into a folder, each complete or not at all.
    Returns the path of the page; raises InputError where it cannot be written."""
    drawn = {"envelope": draw_envelope(check), "residual": draw_residuals(check.log, check.residual.channels)}
    captions = {"envelope": words.envelope_caption(check), "residual": CAPTION}
    page = render(
        "check.html", made=made, title=words.title(check), kind=f"check of {check.plant.axis}",
        sections=SECTIONS, summary=words.summary(check), remarks=words.remarks(check),
        figures=figure_table(check),
        channels=Table(COLUMNS, (Group("", channel_rows(check.residual.channels)),)),
        **shown(drawn, captions),
    )  # fmt: skip
    return write_page(Path(folder), "check", page, check_record(check), drawn)


def draw_envelope(check: LogCheck) -> "Figure":
    """The logged angle within the samples."""
    log, e = check.log, check.envelope
    assert log.reference is not None
    assert log.angle is not None
    with styled():
        figure, (at,) = new_figure()
        few = seen(len(log.time))
        at.fill_between(log.time[few], e.low[few], e.high[few], color=GREY, alpha=0.35, lw=0, label="samples")
        at.plot(log.time[few], log.reference[few], color=BLACK, lw=0.8, ls="--", label="reference")
        at.plot(log.time[few], log.angle[few], color=ORANGE, lw=1.2, label="log")
        at.set(xlabel="Time [s]", ylabel="Angle [deg]", xlim=(log.time[0], log.time[-1]))
        at.legend()
    return figure


def figure_table(check: LogCheck) -> Table:
    """Each stair's figures beside those of the samples."""
    columns = (
        Column("Metric", number=False), Column("Log"), Column("Samples, median"), Column("Least"),
        Column("Largest"), Column("Distance over spread", "1"),
    )  # fmt: skip
    groups = []
    for i, s in enumerate(check.stairs):
        rows = tuple(
            row(
                f"{f.name}{WITHIN.get(f.name, '')} [{f.unit}]", Cell(number(f.value), broken=f.departs),
                number(f.middle), number(f.low), number(f.high), number(f.score, 2),
            )
            for f in check.envelope.figures
            if f.stair == i
        )  # fmt: skip
        groups.append(Group(f"to {words.asked(check, s)} at {number(s.begins)} s", rows))
    return Table(columns, tuple(groups))
