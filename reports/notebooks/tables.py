"""Tables in a notebook: Markdown that every viewer draws, the same text where none does."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite

from design.synthesis.evaluate import Evaluation
from design.synthesis.requirements import LIMIT_UNITS, Problem
from reports.shared.glossary import BROKEN as MARK
from reports.shared.names import COST_WORDS, limit_name
from reports.shared.tables import Cell, Column, Group, Table, number, row

BROKEN = f"\u00a0{MARK}"
"""What stands behind a value that breaks its limit."""


@dataclass(frozen=True, repr=False)
class Markdown:
    """Text in Markdown, which Jupyter and its viewers draw when a cell ends in it."""

    text: str

    def _repr_markdown_(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return self.text


def shown(table: Table) -> Markdown:
    """A table of a report: what breaks a limit has the mark ▲ behind it, what is assumed is slanted.

    >>> columns = (Column("Limit", number=False), Column("Ms", "1"))
    >>> print(shown(Table(columns, (Group("", (row("a", "2"),)),))))
    | Limit | Ms [1] |
    | :-- | --: |
    | a | 2 |
    """
    heads = [c.heading + (f" [{c.unit}]" if c.unit else "") for c in table.columns]
    lines = [_line(heads), _line(["--:" if c.number else ":--" for c in table.columns])]
    for group in table.groups:
        if group.heading:
            lines.append(_line([f"**{_safe(group.heading)}**"] + [""] * (len(heads) - 1)))
        for i, cells in enumerate(group.rows):
            lines.append(_line([_cell(c, i in group.strong) for c in cells]))
    return Markdown("\n".join(lines))


def rows(records: Iterable[Mapping[str, object]], digits: int = 3) -> Markdown:
    """A table of records that share their keys, which are the headings, numbers rounded to some digits.

    Raises ValueError where there is no record.

    >>> print(rows([{"controller": "PI", "Ms [1]": 1.97421}]))
    | controller | Ms [1] |
    | :-- | --: |
    | PI | 1.97 |
    """
    found = list(records)
    if not found:
        raise ValueError("a table of no rows")
    columns = tuple(Column(heading, number=not isinstance(v, str)) for heading, v in found[0].items())
    cells = tuple(row(*(_text(v, digits) for v in r.values())) for r in found)
    return shown(Table(columns, (Group("", cells),)))


def limits_held(problem: Problem, at: Evaluation, names: Iterable[str]) -> Markdown:
    """What pairs of gains, by name, do on a problem: worst cost, and each limited quantity at its
    worst."""
    limits = problem.limits.named
    return rows(
        {
            "controller": name,
            "Kp": float(at.Kp[i]),
            "Ki": float(at.Ki[i]),
            f"worst {COST_WORDS[problem.cost]}": float(at.cost[i]),
            **{
                f"{limit_name(n)} [{LIMIT_UNITS[n]}]": Cell(
                    number(float(at.values[n][i])), broken=bool(at.excess[n][i] > 0.0)
                )
                for n in limits
            },
        }
        for i, name in enumerate(names)
    )


def _text(value: object, digits: int) -> Cell:
    if isinstance(value, Cell):
        return value
    if isinstance(value, float):
        return Cell(number(value, digits) if isfinite(value) else "∞")
    return Cell(str(value))


def _cell(cell: Cell, strong: bool) -> str:
    text = _safe(cell.text) + (f" ({_safe(cell.under)})" if cell.under else "")
    if cell.broken:
        return f"**{text}{BROKEN}**"
    if cell.marked:
        return f"*{text}*"
    return f"**{text}**" if strong and text else text


def _line(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _safe(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*").replace("\n", " ")
