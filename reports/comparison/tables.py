"""The tables of a comparison page."""

from math import isnan

from design.comparison.compare import PAPER, TUNED, Comparison, Row, Standing
from design.synthesis.judged import ACTIVE
from design.synthesis.requirements import LIMIT_UNITS, Limits
from design.synthesis.tuning import Tuning
from reports.shared.names import LIMITS, WINDOW, limit_name, name_of, title_of
from reports.shared.tables import Cell, Column, Group, Table, fixed, number, row, spaced

BEYOND = f"> {WINDOW:g}"
"""How a time beyond the end of a task is shown."""

DECIMALS = {
    "rise_time_s": 2, "settling_time_s": 2, "overshoot_percent": 1, "steady_state_error_deg": 3,
    "iae_deg_s": 2, "ise_deg2_s": 1, "itae_deg_s2": 2, "total_variation_V": 2,
}  # fmt: skip


def limits_table(limits: Limits) -> Table:
    """The limits in force."""
    rows = []
    for name, value in limits.named.items():
        words, side, meaning = LIMITS.get(name, (name, "", ""))
        unit = LIMIT_UNITS.get(name, "").replace("1", "")
        rows.append(row(words, f"{side} {number(value)} {unit}".strip(), meaning))
    columns = (Column("Limit", number=False), Column("Bound", number=False), Column("Meaning", number=False))
    return Table(columns, (Group("", tuple(rows)),))


def tuning_table(tuning: Tuning) -> Table:
    """Each limit at the tuned gains: bound, worst value, where it is taken, and what is active."""
    problem, at, rows = tuning.problem, tuning.at, []
    strong = []
    for i, (name, bound) in enumerate(problem.limits.named.items()):
        value, unit = float(at.values[name][0]), LIMIT_UNITS.get(name, "").replace("1", "")
        words, side, _ = LIMITS.get(name, (name, "", ""))
        broken = float(at.excess[name][0]) > 0.0
        near = float(at.excess[name][0]) > -ACTIVE
        note = "broken" if broken else "active" if near else "met"
        strong += [i] if note != "met" else []
        rows.append(row(
            words, f"{side} {number(bound)} {unit}".strip(),
            Cell(f"{number(value)} {unit}".strip(), "", broken), note,
            spaced(problem.place(name, int(at.values_at[name][0]))),
        ))  # fmt: skip
    columns = (
        Column("Limit", number=False), Column("Bound"), Column("Worst value"),
        Column("State", number=False), Column("Where", number=False),
    )  # fmt: skip
    return Table(columns, (Group("", tuple(rows), tuple(strong)),))


def standings_table(comparison: Comparison) -> Table:
    """One row a motion and controller: gains, worst values, margins, limits broken."""
    groups = []
    for motion in {s.motion: None for s in comparison.standings}:
        of = [s for s in comparison.standings if s.motion == motion]
        rows = []
        for s in of:
            tasks = [r for r in comparison.rows if (r.motion, r.controller) == (motion, s.controller)]
            rows.append(row(
                name_of(s.controller), *(number(k) for k in (s.Kp, s.Ki)),
                _worst(tasks, "settling_time_s", "settling_time_s" in s.breaks),
                _worst(tasks, "overshoot_percent", "overshoot_percent" in s.breaks),
                _worst(tasks, "iae_deg_s", False),
                _ratio(s.worst_settling_ratio), _ratio(s.worst_iae_ratio),
                Cell(_known(s.Ms, 2), "", "Ms" in s.breaks),
                _delay(s),
                Cell(", ".join(limit_name(b) for b in s.breaks) or "none", "", bool(s.breaks)),
            ))  # fmt: skip
        groups.append(
            Group(title_of(motion), tuple(rows), tuple(i for i, s in enumerate(of) if s.controller == TUNED))
        )
    columns = (
        Column("Controller", number=False), Column("Kp", "kPa/deg"), Column("Ki", "kPa/(deg s)"),
        Column("Worst settling", "s"), Column("Worst overshoot", "%"), Column("Worst IAE", "deg s"),
        Column("Settling / bound", "1"), Column("IAE / bound", "1"), Column("Ms", "1"),
        Column("Delay margin", "ms"), Column("Limits broken", number=False),
    )  # fmt: skip
    return Table(columns, tuple(groups))


def _delay(s: Standing) -> Cell:
    """The delay margin; beneath, of an MPC, what a simulation tolerates."""
    broken = "delay_margin_s" in s.breaks
    if s.tolerated_delay_s is None:
        return Cell(_known(1000.0 * s.delay_margin_s, 0), "", broken)
    simulated = f"simulated: {fixed(1000.0 * s.tolerated_delay_s, 0)}"
    return Cell(_known(1000.0 * s.delay_margin_s, 0), simulated, broken)


def _known(value: float, decimals: int) -> str:
    """A number, or that there is none, such as a margin of a controller without a linear loop."""
    return "–" if isnan(value) else fixed(value, decimals)


def _ratio(value: float | None) -> str:
    """A ratio to a lower bound, where there is one."""
    return "–" if value is None else fixed(value, 2 if value < 10.0 else 1)


def _worst(tasks: list[Row], metric: str, broken: bool) -> Cell:
    low, value, high = (max(getattr(t, k)[metric] for t in tasks) for k in ("low", "metrics", "high"))
    return _ranged(metric, low, value, high, broken)


def _ranged(metric: str, low: float, value: float, high: float, broken: bool = False) -> Cell:
    beyond = BEYOND if metric in ("rise_time_s", "settling_time_s") else "∞"
    texts = [fixed(v, DECIMALS[metric], beyond) for v in (low, value, high)]
    return Cell(texts[1], f"{texts[0]} to {texts[2]}" if high > low else "", broken)


def paper_note() -> str:
    """What the second lines in the tables are."""
    return f"Small print, {name_of(PAPER)}: range over its assumed gains."
