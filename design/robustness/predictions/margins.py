"""Margins of the loop on every branch at the rates that the regulator can have, and how they are judged."""

from dataclasses import dataclass
from typing import Any

from design.controllers.pi import PI
from design.open_loops import by_python_control
from design.robustness.statement import EVERY_BRANCH, Claim, Reason, Statement
from design.status import Status
from design.synthesis.requirements import ROUNDING, Limits
from plants.parameters.remainder import UncertaintyWeight
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


def branch_margins(
    wrist: Wrist, controller: PI, dead_time: float = 0.0, weight: UncertaintyWeight | None = None
) -> list[Row]:
    """Margins on every branch at the slow, the fast and the steepest rate, for one pair of gains.

    Rows as of `design.open_loops.by_python_control`, with `dead_time` [s] on top of the wrist's own and
    unmodelled dynamics of a weight.  The
    fast rate is the largest k(e); the slope of k(e) e, which is what a small motion about a moving
    equilibrium meets, passes it, so that rows of the rate ``steepest`` follow where k_fast > k_slow.
    The wrist cannot stay there: the steepest slope belongs to an error of sqrt(3) e0, which moves the
    pressure.
    """
    rows = by_python_control(wrist, controller, dead_time, weight=weight)
    rate = steepest_rate(wrist)
    if rate > float(wrist.regulator.k_fast):
        steep = by_python_control(wrist.with_values(k_fast=rate), controller, dead_time, ("fast",), weight)
        rows += [{**r, "rate": r["rate"].replace("fast", STEEPEST)} for r in steep]
    return rows


def place(row: Row) -> str:
    """In words, the branch and rate of a row.

    >>> place({"branch": "line1", "rate": "slow"})
    'line1, slow regulator rate'
    """
    return f"{row['branch']}, {row['rate']} regulator rate"


@dataclass(frozen=True)
class StableEverywhere(Claim):
    """The linear loop is stable on every branch at every rate; by poles, or by Nyquist's criterion."""


@dataclass(frozen=True)
class MarginHeld(Claim):
    """A margin, by its key in rows, is at most or at least its limit on every branch; limit: None where none
    is set, so that the margin is told without being judged."""

    key: str
    at_most: bool
    limit: float | None


@dataclass(frozen=True)
class OfRows(Reason):
    """The statement's value is the worst of the branches and rates."""


def statements(rows: list[Row], limits: Limits) -> list[Statement]:
    """What the margins predict: stability on every branch, and each margin at its worst.

    Only Ms and the delay margin have limits; the other figures are told without being judged
    (holds is None).  The value is the worst over the rows, `branch` where.
    """
    unstable = [r for r in rows if not r["stable"]]
    stable = Statement(
        Status.PREDICTED, StableEverywhere(), not unstable, float(len(unstable)), OfRows(),
        "unstable branches", place(unstable[0]) if unstable else EVERY_BRANCH,
    )  # fmt: skip
    within = limits.named
    return [
        stable,
        _worst(rows, MarginHeld("Ms", True, within.get("Ms")), "1"),
        _worst(rows, MarginHeld("delay_margin_s", False, within.get("delay_margin_s")), "s"),
        _worst(rows, MarginHeld("gain_margin", False, None), "1"),
        _worst(rows, MarginHeld("phase_margin_deg", False, None), "deg"),
        _worst(rows, MarginHeld("Mt", True, within.get("Mt")), "1"),
        _worst(rows, MarginHeld("disk_margin", False, None), "1"),
        *([_worst(rows, MarginHeld("WT", True, within.get("WT")), "1")] if "WT" in rows[0] else []),
    ]


def _worst(rows: list[Row], claim: MarginHeld, unit: str) -> Statement:
    lost = float("inf") if claim.at_most else 0.0  # of an unstable loop no margin means anything
    worse = max if claim.at_most else min
    value, branch = worse(
        ((float(r[claim.key]) if r["stable"] else lost, place(r)) for r in rows), key=lambda pair: pair[0]
    )
    holds = None
    if claim.limit is not None:
        holds = value <= claim.limit * ROUNDING if claim.at_most else value >= claim.limit / ROUNDING
    return Statement(Status.PREDICTED, claim, holds, value, OfRows(), unit, branch)
