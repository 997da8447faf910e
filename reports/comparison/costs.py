"""Costs of other controllers, on a comparison page: the model error that a feedforward tolerates, and the
execution time of each controller."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from design.comparison.break_even import KIND_UNITS, METRICS, BreakEven, BreakEvenCurve
from design.mpc.fallback import SOLVED
from design.mpc.timing import Ledger, Times
from reports.shared.names import name_of, title_of
from reports.shared.tables import Cell, Column, Group, Table, fixed, listed, number, row

METRIC_WORDS = {"settling": "worst settling time", "IAE": "mean IAE"}
KIND_WORDS = {
    "loop width": "loop wider or narrower than modelled",
    "slope": "slopes steeper or flatter than modelled",
    "starting memory": "error of the initial angle, as a share of the loop's height",
    "dead time": "dead time that the model lacks",
}

TIMES = (
    "Wall time in Python on the machine that made this page: a comparison of costs, no guarantee of a "
    "deadline on another machine."
)
"""What the deadline ledger is, and what it is not."""

LEDGER = (
    "Time of a step: median, 99 % of all steps, and the longest; the parts of an MPC as medians, 99 % "
    "beneath. Missed: steps that took longer than the period. Fallback: steps in which the solver of "
    "an MPC gave no new solution. One plain PI stands for all."
)


def break_even_caption(motion: str, found: BreakEven) -> str:
    """Where controllers break even with the recommended PI, and what the map of a motion shows."""
    return (
        f"{break_even_words(motion, found)} Ratios to the recommended PI, one property at a time differing "
        "from the model. Shaded: worse; circles: break-even; arrows: beyond the axis, or not settled."
    )


def break_even_words(motion: str, found: BreakEven) -> str:
    """In a sentence, how wrong each controller's model may be before its IAE is more than the
    recommended PI's."""
    parts = []
    for name in dict.fromkeys(c.controller for c in found.curves):
        of = [c for c in found.curves if c.controller == name]
        reached = [said for c in of if (said := _reach(c))]
        any_ = [_SHORT.get(c.kind, c.kind) for c in of if not _reach(c)]
        reached += [f"any error of the {listed(any_)} that was tried"] if any_ else []
        parts.append(f"{name_of(name)} with {listed(reached)}")
    return (
        f"{title_of(motion)}: the mean IAE stays below that of the recommended PI for {'; for '.join(parts)}."
    )


_SHORT = {"starting memory": "initial angle"}


def _reach(c: BreakEvenCurve) -> str:
    """Between which errors of a kind the IAE is no worse; empty where it is at no error that was tried."""
    low, high = c.break_even("IAE")
    kind = _SHORT.get(c.kind, c.kind)
    if 0.0 in (low, high):
        return f"no error of the {kind}: it is worse even without one"
    ends = [_scaled(c.kind, e) for e in (low, high) if e is not None]
    if len(ends) == 2:
        return f"a {kind} off by {ends[0]} to {ends[1]}"
    return f"a {kind} off by less than {ends[0]}" if ends else ""


def break_even_table(found: BreakEven) -> Table:
    """The numbers of a map: ratio without error, and the errors at which the recommended PI does as well."""
    groups = []
    for kind in dict.fromkeys(c.kind for c in found.curves):
        rows = []
        for c in (c for c in found.curves if c.kind == kind):
            for metric in METRICS:
                low, high = c.break_even(metric)
                ratio = float(c.ratio(metric)[np.abs(c.errors).argmin()])
                below = _error(c, low, c.errors[0]) if (c.errors < 0.0).any() else "–"
                rows.append(
                    row(
                        name_of(c.controller), METRIC_WORDS[metric], fixed(ratio, 2, "–"), below,
                        _error(c, high, c.errors[-1]),
                    )
                )  # fmt: skip
        tried = found.of(kind, next(c.controller for c in found.curves if c.kind == kind)).errors
        reach = f"{_scaled(kind, tried[0])} to {_scaled(kind, tried[-1])}"
        groups.append(Group(f"{KIND_WORDS[kind]} (tried: {reach})", tuple(rows)))
    columns = (
        Column("Controller", number=False), Column("Measure", number=False),
        Column("Ratio to the recommended PI, no error", "1"), Column("Break-even, negative error"),
        Column("Break-even, positive error"),
    )  # fmt: skip
    return Table(columns, tuple(groups))


def _error(c: BreakEvenCurve, at: float | None, end: float) -> str:
    """Where a controller breaks even, or that it does not within what was tried."""
    return f"beyond {_scaled(c.kind, end)}" if at is None else _scaled(c.kind, at)


def _scaled(kind: str, error: float) -> str:
    """An error with its unit, ms or %."""
    if KIND_UNITS[kind] == "s":
        return f"{number(1000.0 * error, 2)} ms"
    return f"{'+' if error > 0.0 and kind != 'starting memory' else ''}{number(100.0 * error, 2)} %"


def ledger_table(ledgers: Mapping[str, Mapping[str, Ledger]], aside: Sequence[str] = ()) -> Table:
    """Times of the steps of every controller, by motion, but of those that are named."""
    groups = [
        Group(title_of(motion), tuple(_ledger(n, found) for n, found in of.items() if n not in aside))
        for motion, of in ledgers.items()
    ]
    columns = (
        Column("Controller", number=False), Column("Period", "ms"), Column("Median", "ms"),
        Column("99 %", "ms"), Column("Longest", "ms"), Column("99 % of the period", "%"),
        Column("Missed", "of steps"), Column("Preparation", "ms"), Column("Solve", "ms"),
        Column("Wrapper", "ms"), Column("Fallback", "steps"),
    )  # fmt: skip
    return Table(columns, tuple(groups))


def _ledger(name: str, found: Ledger) -> tuple[Cell, ...]:
    whole = found.total
    solver = found.preparation.most > 0.0 or found.solve.most > 0.0
    parts = [
        Cell(_ms(t.median), _ms(t.p99)) if solver else Cell("–")
        for t in (found.preparation, found.solve, found.wrapper)
    ]
    fallback = str(found.steps - found.rungs.get(SOLVED, 0)) if solver else "–"
    return row(
        name_of(name), number(1000.0 * found.period), _ms(whole.median), _ms(whole.p99), _ms(whole.most),
        number(100.0 * found.p99_share, 2), Cell(f"{found.misses} of {found.steps}", "", found.misses > 0),
        *parts, fallback,
    )  # fmt: skip


def _ms(seconds: float) -> str:
    return number(1000.0 * seconds, 2)


def ledger_words(ledgers: Mapping[str, Mapping[str, Ledger]]) -> str:
    """In a sentence, who comes nearest to its period, and whether any missed it."""
    all_ = [(n, found) for of in ledgers.values() for n, found in of.items()]
    name, most = max(all_, key=lambda one: one[1].p99_share)
    steps, missed = (sum(getattr(f, n) for _, f in all_) for n in ("steps", "misses"))
    tail = "; no step missed its period"
    if missed:
        who, worst = max(all_, key=lambda one: one[1].misses)
        tail = (
            f"; {missed} of all {steps} steps took longer than their period, most of them the "
            f"{name_of(who)}'s ({worst.misses} of {worst.steps})"
        )
    return (
        f"The nearest to its period comes the {name_of(name)}, of which 99 % of the steps are done within "
        f"{number(100.0 * most.p99_share, 2)} % of the period{tail}."
    )


def break_even_record(found: Mapping[str, BreakEven] | None) -> dict[str, Any] | None:
    """The maps for JSON: rows by motion, None where there is none."""
    return None if found is None else {motion: b.rows() for motion, b in found.items()}


def ledger_record(found: Mapping[str, Mapping[str, Ledger]] | None) -> dict[str, Any] | None:
    """The ledgers for JSON, times in seconds, by motion and controller, None where there is none."""
    if found is None:
        return None
    return {m: {name: _times_of(one) for name, one in of.items()} for m, of in found.items()}


def _times_of(found: Ledger) -> dict[str, Any]:
    parts: dict[str, Times] = {n: getattr(found, n) for n in ("total", "preparation", "solve", "wrapper")}
    return {
        "period_s": found.period, "steps": found.steps, "misses": found.misses, "rungs": found.rungs,
        **{f"{n}_s": {"median": t.median, "p99": t.p99, "most": t.most} for n, t in parts.items()},
    }  # fmt: skip
