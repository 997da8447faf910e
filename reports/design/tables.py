"""Tables of a design: the recommended gains, limits by what they hold under, and the price list."""

from design.studies.design_study import DesignStudy, MotionDesign
from design.studies.limits_matrix import CONDITIONS
from design.synthesis.requirements import LIMIT_UNITS
from reports.design.words import controller_words, value_words
from reports.shared.tables import Cell, Column, Group, Table, number, row

LIMIT_NAMES = {
    "overshoot_percent": "overshoot", "Ms": "Ms", "Mt": "Mt", "delay_margin_s": "delay margin",
    "total_variation_V": "total variation", "steady_error_percent": "steady error",
    "settling_time_s": "settled after",
}  # fmt: skip


def gains_table(study: DesignStudy) -> Table:
    """The decision card: a row a motion."""
    columns = (
        Column("motion", number=False), Column("controller", number=False), Column("Kp", "kPa/deg"),
        Column("Ki", "kPa/(deg s)"), Column("b", "1"), Column("Tf", "ms"), Column("why", number=False),
    )  # fmt: skip
    rows = tuple(
        row(
            m.motion, m.recommended, number(m.gains["Kp"]), number(m.gains["Ki"]), number(m.gains["b"]),
            number(1000 * m.gains["Tf"]), controller_words(m),
        )
        for m in study.motions
    )  # fmt: skip
    return Table(columns, (Group("", rows),))


def matrix_table(study: DesignStudy) -> Table:
    """Limits by what they hold under."""
    columns = (
        Column("limit", number=False), Column("at most"), *(Column(c) for c in CONDITIONS),
        Column("proved", number=False),
    )  # fmt: skip
    return Table(columns, tuple(Group(m.motion, _matrix(m)) for m in study.motions))


def _matrix(m: MotionDesign) -> tuple[tuple[Cell, ...], ...]:
    rows = []
    for r in m.matrix:
        unit = LIMIT_UNITS[r["limit"]]
        name = LIMIT_NAMES[r["limit"]] + ("" if unit == "1" else f" [{unit}]")
        bound = number(r["bound"]) + (" or more" if r["limit"] == "delay_margin_s" else "")
        cells = [Cell(value_words(r["values"][c]), broken=r["held"][c] is False) for c in CONDITIONS]
        rows.append(row(name, bound, *cells, "–"))
    proved = m.evidence["proved"]
    rate = "" if proved["rate_1_s"] is None else f", {number(proved['rate_1_s'])} 1/s"
    blank = ["–"] * len(CONDITIONS)
    rows.append(row("stability", "", *blank, proved["status"] + rate))
    return tuple(rows)


def price_table(study: DesignStudy) -> Table:
    """What each guarantee costs."""
    columns = (
        Column("guarantee", number=False), Column("controller", number=False), Column("Kp", "kPa/deg"),
        Column("Ki", "kPa/(deg s)"), Column("b", "1"), Column("worst IAE", "deg s"),
        Column("worst settling", "s"), Column("worst overshoot", "%"), Column("IAE over its bound", "1"),
    )  # fmt: skip
    groups = []
    for m in study.motions:
        rows = []
        for r in m.prices:
            gains = r["gains"] or dict.fromkeys(("Kp", "Ki", "b"))
            limit = study.requirements[m.motion]["limits"].get("overshoot_percent", float("inf"))
            over = r["worst_overshoot_percent"]
            held = "" if not r["gains"] or r["feasible"] else ", not held"
            rows.append(
                row(
                    r["guarantee"] + held, r["controller"],
                    *(number(gains.get(n)) for n in ("Kp", "Ki", "b")),
                    number(r["worst_iae_deg_s"]), number(r["worst_settling_s"]),
                    Cell(number(over), broken=over is not None and over > limit),
                    number(r["ratio_to_bound"]) if r["gains"] else "open",
                )
            )  # fmt: skip
        groups.append(Group(m.motion, tuple(rows)))
    return Table(columns, tuple(groups))
