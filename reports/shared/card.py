"""The decision card, the first screen of a page: gains, limits by what they hold under, and the step.

Whoever has a recommended controller per motion hands over `CardRow`s; the card does not ask what study they
are from.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from design.status import Status
from design.studies.shown.limits_matrix import CONDITIONS
from design.synthesis.requirements import LIMIT_UNITS
from reports.shared.glossary import NOT_JUDGED
from reports.shared.html import Shown
from reports.shared.tables import Cell, Column, Group, Table, listed, measured, number, row

LIMIT_NAMES = {
    "overshoot_percent": "Overshoot", "Ms": "Ms", "Mt": "Mt", "delay_margin_s": "Delay margin",
    "total_variation_V": "Variation of u", "steady_error_percent": "Steady error",
    "settling_time_s": "Settling time", "WT": "|W T|",
}  # fmt: skip
LATE = "longest dead time"
HEADS = dict(
    zip(
        CONDITIONS,
        ("nominal", "every branch and start", LATE, "perturbed plants", "worst case found"),
        strict=True,
    )
)
"""What the card calls each condition; the dead time by its size, where the card knows it."""


@dataclass(frozen=True)
class CardRow:
    """What the card shows of a motion: its controller by name, gains (Kp, Ki, b, Tf), rows of the matrix as
    `design.studies.shown.limits_matrix.matrix` makes them, the proof, the band of steps, a short reason."""

    motion: str
    controller: str
    gains: Mapping[str, float]
    matrix: Sequence[Mapping[str, Any]]
    proved: Mapping[str, Any]
    band: Mapping[str, Any]
    why: str = ""

    @property
    def overshoot(self) -> float | None:
        """The limit on overshoot [%], where there is one."""
        return next((r["bound"] for r in self.matrix if r["limit"] == "overshoot_percent"), None)


@dataclass(frozen=True)
class Card:
    """The first screen: gains, limits by conditions in a table a motion, the step with its band."""

    gains: Table
    matrices: Sequence[Table]
    step: Shown


def card(rows: Sequence[CardRow], step: Shown) -> Card:
    """The card of some motions, with the figure that shows their step."""
    return Card(gains_table(rows), [matrix_table([r]) for r in rows], step)


def gains_table(rows: Sequence[CardRow]) -> Table:
    """Controllers, a row a motion, and whether stability is proved."""
    more = [c for c in ("b", "Tf") if any(r.gains.get(c, 0.0) != (1.0 if c == "b" else 0.0) for r in rows)]
    columns = (
        Column("Motion", number=False), Column("Controller", number=False), Column("Kp", "kPa/deg"),
        Column("Ki", "kPa/(deg s)"),
        *(Column("Weight b", "1") if c == "b" else Column("Tf", "ms") for c in more),
        Column("Stability", number=False),
        *((Column("Evidence", number=False),) if any(r.why for r in rows) else ()),
    )  # fmt: skip
    found = []
    for r in rows:
        extra = [number(r.gains[c] * (1.0 if c == "b" else 1000.0)) for c in more]
        words = [r.why] if any(x.why for x in rows) else []
        gains = (number(r.gains["Kp"]), number(r.gains["Ki"]))
        found.append(row(r.motion, r.controller, *gains, *extra, _stability(r), *words))
    return Table(columns, (Group("", tuple(found), tuple(range(len(found)))),))


def _stability(of: CardRow) -> Cell:
    return Cell(proof_words(of), met=of.proved["status"] == "proved")


def proof_words(of: CardRow) -> str:
    """The status of the proof for the task, and the rate; where it is open, that of smaller motions, or the
    effects that no certificate includes."""
    rate, status = of.proved["rate_1_s"], str(of.proved["status"])
    if beyond := of.proved.get("left_out"):
        return f"{status}: certificates do not include {listed(list(beyond))}"
    if rate is None:
        return status
    return f"{status}, {number(rate, 2)} 1/s" + ("" if status == "proved" else " for smaller motions")


def matrix_table(rows: Sequence[CardRow]) -> Table:
    """Limits by what they are judged under; in the last column, that none of them is proved."""
    known = [
        c for c in CONDITIONS if any(r["values"][c] is not None for of in rows for r in of.matrix)
    ]  # what nothing was judged under has no column
    columns = (
        Column("Limit", number=False), Column("Bound"), *(Column(_head(c, rows)) for c in known),
        Column(Status.PROVED.value),
    )  # fmt: skip
    return Table(columns, tuple(Group(r.motion, _matrix(r, known)) for r in rows))


def _head(condition: str, rows: Sequence[CardRow]) -> str:
    """What the card calls a condition: the longest dead time by its size, where it is that of all rows."""
    found = {r.band.get("dead_time_s") for r in rows}
    late = found.pop() if len(found) == 1 else None
    return f"{1000 * late:.3g} ms dead time" if late and HEADS[condition] == LATE else HEADS[condition]


def _matrix(of: CardRow, known: Sequence[str]) -> tuple[tuple[Cell, ...], ...]:
    rows = []
    for r in of.matrix:
        unit = LIMIT_UNITS[r["limit"]]
        name = LIMIT_NAMES[r["limit"]] + ("" if unit == "1" else f" [{unit}]")
        bound = ("≥ " if r["limit"] == "delay_margin_s" else "≤ ") + number(r["bound"])
        cells = [
            Cell(
                _value(r["limit"], r["values"][c], r["held"][c], r["bound"]),
                broken=r["held"][c] is False, met=r["held"][c] is True,
            )
            for c in known
        ]  # fmt: skip
        rows.append(row(name, bound, *cells, Status.OPEN.value))  # no certificate is of a limit
    return tuple(rows)


def _value(limit: str, value: float | None, held: bool | None, bound: float) -> str:
    """A value in the matrix; a file has null for one that is infinite, and was judged all the same.  One that
    breaks its limit by less than it is rounded by has more digits.

    >>> _value("Ms", 1.5, True, 2.0), _value("Ms", None, None, 2.0), _value("Ms", 2.0029, False, 2.0)
    ('1.50', '–', '2.0029')
    >>> _value("settling_time_s", None, False, 10.0)
    'never'
    """
    if held is None:
        return NOT_JUDGED
    if value is None or not isfinite(value):
        return "never" if limit == "settling_time_s" else "∞"
    told = measured(float(value))
    close = held is False and told == measured(float(bound))
    return measured(float(value), 6, 6).rstrip("0").rstrip(".") if close and value != bound else told


def broken_words(broken: int, total: int) -> str:
    """In how many samples and runs of a search a controller breaks a limit."""
    return f"{broken} of {total} runs break a limit"


def gains_words(gains: Mapping[str, float]) -> str:
    """Gains in a line.

    >>> gains_words({"Kp": 2.89, "Ki": 7.39, "b": 1.0, "Tf": 0.0})
    'Kp = 2.89 kPa/deg, Ki = 7.39 kPa/(deg s)'
    """
    words = f"Kp = {number(gains['Kp'])} kPa/deg, Ki = {number(gains['Ki'])} kPa/(deg s)"
    words += f", b = {number(gains['b'])}" if gains["b"] != 1.0 else ""
    return words + (f", Tf = {number(1000 * gains['Tf'])} ms" if gains["Tf"] else "")


def step_caption(rows: Sequence[CardRow], which: str = "recommended") -> str:
    """Beneath the steps; which: gains these are, recommended or nearest."""
    b = rows[0].band
    return (
        f"Step of {number(b['step'])} deg from rest under the {which} gains, drawn upwards. Band: "
        f"smallest and largest angle of {b['cases']} fresh cases of the requirement."
    )
