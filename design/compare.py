"""Controllers x tasks -> one table: the tuned PI beside the paper's and the textbook rules.

Everything is simulated under the same command range and sampling, from the
same states.  The paper's gains are a stand-in, so its rows carry the range that
the metrics take over the range of those gains, and no verdict is given that
would change within it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from design.loop import Trajectory, run
from design.margins import by_python_control
from design.metrics import Metrics
from design.pi import PI
from design.requirements import Limits
from design.rules import baselines, paper_range
from design.tasks import STEP, Scenario
from plants import tree
from plants.wrist import STARTS, Wrist

HOLD = 5.0
"""How long the first angle of a return step is held [s]."""

TUNED = "tuned"
PAPER = "paper"
METRICS = tuple(f.name for f in fields(Metrics))


@dataclass(frozen=True)
class Row:
    """One controller on one task.  `low` and `high` bound each metric over the range of the
    paper's gains; they equal `metrics` for every other controller."""

    motion: str
    task: str
    controller: str
    metrics: Mapping[str, float]
    low: Mapping[str, float]
    high: Mapping[str, float]


@dataclass(frozen=True)
class Standing:
    """A controller's margins on one motion: gains, the worst over branches and rates by
    python-control, and which of the limits it breaks (margins, and overshoot on the tasks)."""

    motion: str
    controller: str
    Kp: float
    Ki: float
    Ms: float
    delay_margin_s: float
    worst_overshoot_percent: float
    worst_settling_s: float
    worst_iae_deg_s: float
    breaks: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """Rows of the table, standings, and the step of each motion and controller for drawing."""

    rows: tuple[Row, ...]
    standings: tuple[Standing, ...]
    steps: Mapping[tuple[str, str], Trajectory]
    limits: Limits
    verdicts: tuple[str, ...]


def task_scenarios(wrist: Wrist) -> list[Scenario]:
    """The 15 degree steps of one motion: both signs, from every starting memory."""
    return [Scenario(start, 0.0, sign * STEP, wrist) for sign in (1, -1) for start in STARTS]


def controllers(wrist: Wrist, tuned: PI) -> dict[str, list[PI]]:
    """Controllers by name, each a list: one PI, or the range of the paper's, the stand-in first."""
    named = {TUNED: [tuned], **{name: [pi] for name, pi in baselines(wrist).items()}}
    named[PAPER] = [
        PI(Kp, Ki, wrist.regulator.gain, wrist.hysteresis.rest_pressure) for Kp, Ki in paper_range()
    ]
    return named


def on_tasks(wrist: Wrist, pis: list[PI]) -> dict[str, list[Metrics]]:
    """Metrics by task, one for each PI."""
    gains = PI(
        np.array([c.Kp for c in pis]), np.array([c.Ki for c in pis]), pis[0].gain, pis[0].rest_pressure
    )
    found: dict[str, list[Metrics]] = {}
    for s in task_scenarios(wrist):
        state = tree.like(
            wrist.rest(), [np.full(len(pis), x) for x in tree.leaves(wrist.rest(s.start, s.angle))]
        )
        judged, _, _ = run(wrist, gains, np.full(len(pis), s.reference), state)
        found[f"0 to {s.reference:+g} deg, {s.start}"] = [judged[i] for i in range(len(pis))]
    for sign in (1, -1):
        there = np.full(len(pis), sign * STEP)
        _, held, _ = run(wrist, gains, there, duration=HOLD)
        judged, _, _ = run(wrist, gains, np.zeros(len(pis)), held.plant, held.controller, begin=HOLD)
        found[f"return from {sign * STEP:+g} to 0 deg"] = [judged[i] for i in range(len(pis))]
    return found


def together(one: Metrics, other: Metrics) -> Metrics:
    """Metrics of both motions at once: the later time, the larger overshoot and error, and the
    integrals and the travel of both added up.  The declared wrist couples the motions nowhere."""
    largest = ("rise_time_s", "settling_time_s", "overshoot_percent", "steady_state_error_deg")
    pairs = ((n, getattr(one, n), getattr(other, n)) for n in METRICS)
    return Metrics(*(max(a, b) if n in largest else a + b for n, a, b in pairs))


def _row(motion: str, task: str, name: str, judged: list[Metrics]) -> Row:
    table = {n: [float(getattr(m, n)) for m in judged] for n in METRICS}
    return Row(
        motion, task, name,
        {n: v[0] for n, v in table.items()},
        {n: min(v) for n, v in table.items()},
        {n: max(v) for n, v in table.items()},
    )  # fmt: skip


def compare(
    wrists: Mapping[str, Wrist],
    tuned: Mapping[str, PI],
    limits: Limits | None = None,
    refusals: Mapping[str, str] | None = None,
) -> Comparison:
    """Run every controller on every task of each motion, and of two motions at once.

    `wrists` and `tuned` map a motion's name to its wrist and its tuned PI; `refusals`
    gives the reason for a motion that could not be tuned within the limits, whose
    PI is then only the nearest there is.
    """
    limits = limits or Limits()
    rows: list[Row] = []
    standings: list[Standing] = []
    steps: dict[tuple[str, str], Trajectory] = {}
    judged: dict[tuple[str, str], dict[str, list[Metrics]]] = {}
    for motion, wrist in wrists.items():
        for name, pis in controllers(wrist, tuned[motion]).items():
            tasks = judged[motion, name] = on_tasks(wrist, pis)
            rows += [_row(motion, task, name, m) for task, m in tasks.items()]
            standings.append(_standing(motion, name, wrist, pis[0], tasks, limits))
            _, _, trajectory = run(wrist, pis[0], STEP, record=True)
            assert trajectory is not None
            steps[motion, name] = trajectory
    if len(wrists) == 2:
        one, other = wrists
        for name in {n: None for _, n in judged}:
            for sign in (1, -1):
                task = f"0 to {sign * STEP:+g} deg, virgin"
                both = [
                    together(a, b)
                    for a, b in zip(judged[one, name][task], judged[other, name][task], strict=True)
                ]
                rows.append(_row("both at once", task, name, both))
    return Comparison(
        tuple(rows), tuple(standings), steps, limits, tuple(verdicts(rows, standings, refusals))
    )


def _standing(
    motion: str, name: str, wrist: Wrist, pi: PI, tasks: dict[str, list[Metrics]], limits: Limits
) -> Standing:
    margins = by_python_control(wrist, pi)
    worst = {n: max(float(getattr(m[0], n)) for m in tasks.values()) for n in METRICS}
    Ms = max(m["Ms"] for m in margins)
    delay = min(m["delay_margin_s"] for m in margins)
    held = {
        "overshoot_percent": worst["overshoot_percent"],
        "Ms": Ms,
        "total_variation_V": worst["total_variation_V"],
        "steady_error_percent": 100.0 * worst["steady_state_error_deg"] / STEP,
    }
    # A tuned optimum lies on its limit: half a per mille keeps rounding from breaking it.
    breaks = [n for n, v in held.items() if n in limits.named and v > limits.named[n] * 1.0005]
    if "delay_margin_s" in limits.named and delay < limits.named["delay_margin_s"] / 1.0005:
        breaks.append("delay_margin_s")
    return Standing(
        motion, name, float(pi.Kp), float(pi.Ki), Ms, delay, worst["overshoot_percent"],
        worst["settling_time_s"], worst["iae_deg_s"], tuple(breaks),
    )  # fmt: skip


def verdicts(
    rows: list[Row], standings: list[Standing], refusals: Mapping[str, str] | None = None
) -> list[str]:
    """What the table says, one sentence a motion; a comparison with the paper's PI only where the
    whole range of its gains agrees."""
    said = []
    for motion in {s.motion: None for s in standings}:
        if refusals and motion in refusals:
            said.append(f"{motion}: {refusals[motion]}; what stands as tuned is only the nearest there is.")
            continue
        of = {s.controller: s for s in standings if s.motion == motion}
        ours = max(r.high["settling_time_s"] for r in rows if (r.motion, r.controller) == (motion, TUNED))
        theirs = [r for r in rows if (r.motion, r.controller) == (motion, PAPER)]
        low = max(r.low["settling_time_s"] for r in theirs)
        high = max(r.high["settling_time_s"] for r in theirs)
        if ours < low:
            against = "ahead of the paper's PI over the whole range of its gains"
        elif ours > high:
            against = "behind the paper's PI over the whole range of its gains"
        else:
            against = "not to be ranked against the paper's PI, whose gains are not known well enough"
        rules = [s for n, s in of.items() if n not in (TUNED, PAPER)]
        broken = [s.controller for s in rules if s.breaks]
        tail = f"; {', '.join(broken)} break the limits" if broken else ""
        said.append(
            f"{motion}: the tuned PI settles the worst 15 degree task in {_seconds(ours)} "
            f"(paper's stand-in {_seconds(low)} to {_seconds(high)}), {against}{tail}."
        )
    return said


def _seconds(value: float) -> str:
    return f"{value:.2f} s" if np.isfinite(value) else "more than 10 s"


def row_record(row: Row) -> dict[str, Any]:
    """A row as a flat record for CSV and JSON; what is infinite becomes None."""

    def finite(v: float) -> float | None:
        return v if np.isfinite(v) else None

    record: dict[str, Any] = {"motion": row.motion, "task": row.task, "controller": row.controller}
    for n in METRICS:
        record[n] = finite(row.metrics[n])
    for n in METRICS:
        record[f"{n}_low"], record[f"{n}_high"] = finite(row.low[n]), finite(row.high[n])
    return record
