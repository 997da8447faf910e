"""Tables of a design: what its card shows, and the price list."""

from design.studies.design_study import DesignStudy
from reports.design.words import controller_words
from reports.shared.card import CardRow
from reports.shared.tables import Cell, Column, Group, Table, measured, number, row

GUARANTEES = {"memory and corners": "every start and corner"}
"""What pages call a guarantee, where not by its name."""


def card_rows(study: DesignStudy) -> list[CardRow]:
    """What the decision card shows, a row a motion."""
    return [
        CardRow(m.motion, m.recommended, m.gains, m.matrix, m.evidence["proved"], m.band, controller_words(m))
        for m in study.motions
    ]


def price_table(study: DesignStudy) -> Table:
    """What each guarantee costs."""
    columns = (
        Column("Guarantee", number=False), Column("Controller", number=False),
        Column("Measures", number=False), Column("Kp", "kPa/deg"),
        Column("Ki", "kPa/(deg s)"), Column("b", "1"), Column("Worst IAE", "deg s"),
        Column("Worst settling", "s"), Column("Worst overshoot", "%"), Column("IAE / bound", "1"),
    )  # fmt: skip
    groups = []
    for m in study.motions:
        rows = []
        for r in m.prices:
            gains = r["gains"] or dict.fromkeys(("Kp", "Ki", "b"))
            limit = study.requirements[m.motion]["limits"].get("overshoot_percent", float("inf"))
            over = r["worst_overshoot_percent"]
            held = "" if not r["gains"] or r["feasible"] else ", limit broken"
            rows.append(
                row(
                    GUARANTEES.get(r["guarantee"], r["guarantee"]) + held, r["controller"],
                    " and ".join(r["sensors"]), *(number(gains.get(n)) for n in ("Kp", "Ki", "b")),
                    _of_run(r["worst_iae_deg_s"]), _of_run(r["worst_settling_s"]),
                    Cell(_of_run(over), broken=over is not None and over > limit),
                    _of_run(r["ratio_to_bound"]) if r["gains"] else "open",
                )
            )  # fmt: skip
        groups.append(Group(m.motion, tuple(rows)))
    return Table(columns, tuple(groups))


def _of_run(value: float | None) -> str:
    """A result, or a dash where there is none."""
    return number(None) if value is None else measured(value)
