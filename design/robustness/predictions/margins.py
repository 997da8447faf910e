"""Margins of the loop on every branch at the rates that the regulator can have, and how they are judged."""

from collections.abc import Callable
from typing import Any

from design.controllers.pi import PI
from design.margins import by_python_control
from design.requirements import ROUNDING, Limits
from design.robustness.statement import Statement
from plants.wrist import Wrist

STEEPEST = "steepest"
"""The rate of small motions about the error at which k(e) e is steepest."""

Row = dict[str, Any]


def steepest_rate(wrist: Wrist) -> float:
    """Largest slope of k(e) e [1/s]: 9/8 of the way from k_slow to k_fast, at e = sqrt(3) e0.

    With u = (e/e0)^2 the slope is k_slow + (k_fast - k_slow) (3 u + u^2) / (1 + u)^2, whose
    derivative vanishes at u = 3.

    >>> from plants import Wrist
    >>> round(steepest_rate(Wrist.flexion()), 4)
    10.0563
    """
    p = wrist.regulator
    return float(p.k_fast + max(p.k_fast - p.k_slow, 0.0) / 8.0)


def branch_margins(wrist: Wrist, controller: PI, dead_time: float = 0.0) -> list[Row]:
    """Margins on every branch at the slow, the fast and the steepest rate, for one pair of gains.

    Rows as of `design.margins.by_python_control`, with `dead_time` [s] on top of the wrist's own.  The
    fast rate is the largest k(e); the slope of k(e) e, which is what a small motion about a moving
    equilibrium meets, passes it, so that rows of the rate ``steepest`` follow where k_fast > k_slow.
    The wrist cannot stay there: the steepest slope belongs to an error of sqrt(3) e0, which moves the
    pressure.
    """
    rows = by_python_control(wrist, controller, dead_time)
    rate = steepest_rate(wrist)
    if rate > float(wrist.regulator.k_fast):
        steep = by_python_control(wrist.with_values(k_fast=rate), controller, dead_time, ("fast",))
        rows += [{**r, "rate": r["rate"].replace("fast", STEEPEST)} for r in steep]
    return rows


def place(row: Row) -> str:
    """In words, the branch and rate of a row.

    >>> place({"branch": "line1", "rate": "slow"})
    'line1, slow regulator rate'
    """
    return f"{row['branch']}, {row['rate']} regulator rate"


def statements(rows: list[Row], limits: Limits) -> list[Statement]:
    """What the margins predict: stability on every branch, and each margin at its worst.

    Only Ms and the delay margin have limits; the other figures are told without being judged
    (holds is None).  The value is the worst over the rows, `branch` where.
    """
    unstable = [r for r in rows if not r["stable"]]
    found = [
        Statement(
            "prediction", "the linear loop is stable on every branch at every rate", not unstable,
            float(len(unstable)), "unstable branches", place(unstable[0]) if unstable else "every branch",
            "poles, or Nyquist's criterion where a delay leaves none; no switching is considered",
        )
    ]  # fmt: skip
    within = limits.named
    found.append(_worst(rows, "Ms", "1", "Ms", "at most", within.get("Ms"), max))
    found.append(
        _worst(rows, "delay_margin_s", "s", "delay margin", "at least", within.get("delay_margin_s"), min)
    )
    found.append(_worst(rows, "gain_margin", "1", "gain margin", "at least", None, min))
    found.append(_worst(rows, "phase_margin_deg", "deg", "phase margin", "at least", None, min))
    found.append(_worst(rows, "Mt", "1", "Mt", "at most", None, max))
    found.append(_worst(rows, "disk_margin", "1", "disk margin", "at least", None, min))
    return found


def _worst(
    rows: list[Row],
    key: str,
    unit: str,
    words: str,
    sense: str,
    limit: float | None,
    worse: Callable[..., tuple[float, str]],
) -> Statement:
    lost = float("inf") if sense == "at most" else 0.0  # of an unstable loop no margin means anything
    value, branch = worse(
        ((float(r[key]) if r["stable"] else lost, place(r)) for r in rows), key=lambda pair: pair[0]
    )
    because = "worst of the branches and rates"
    if limit is None:
        claim = f"{words} on every branch"
        return Statement("prediction", claim, None, value, unit, branch, because + "; no limit is set")
    shown = f"{1e3 * limit:g} ms" if unit == "s" else f"{limit:g}"
    holds = value <= limit * ROUNDING if sense == "at most" else value >= limit / ROUNDING
    return Statement(
        "prediction", f"{words} {sense} {shown} on every branch", holds, value, unit, branch, because
    )
