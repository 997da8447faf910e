"""The rungs of the sampled loop with one law of the regulator: the best decay, and the tasks that come to it.

Without memory the slope may change at every sample, as in `certificates.continuous.popov`.  With memory it
changes as the loop has it, while one line at most is met: what is left of every motion in the end.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from design.controllers.pi import PI
from design.evaluation.tasks import comparison_tasks
from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.continuous import popov
from design.robustness.certificates.continuous.signals import rates, slopes
from design.robustness.certificates.memory import programme
from design.robustness.certificates.memory.form import LineForm, MemorySearch
from design.robustness.certificates.memory.loop import FixedLawLoop
from design.robustness.certificates.memory.region import Arrivals, arrivals, visited
from design.robustness.certificates.memory.runs import Runs, run
from design.robustness.certificates.reasons import NotOnePlay, UnstableMode
from design.robustness.certificates.sampled.sampled_loop import delay_samples, delayed
from design.robustness.certificates.sampled.switched import discrete
from design.robustness.loop_model import LoopModel
from plants.hysteresis.law import HysteresisLaw, Side
from plants.wrist import Wrist

DEAD_TIMES = (0.0, 0.05)
"""Dead times [s] beside the loop's own."""

ONE_LINE = "memory of one line"
LEAST = 1e-3
"""Least decay that is asked for, as a share of that of the slowest pole."""

HALVINGS = 6
"""Of the interval in which the best decay lies: it is found to a sixty-fourth of that of the slowest pole."""

BACK = (1.0, 0.97, 0.9)
"""Shares of the best decay that a solver claims, tried until the check confirms one."""

SHARE = 0.5
"""Of the decay of the slowest pole, which the tasks are to come to; less where no function has so much."""

LOOKED = 2.0
"""Time [s] after a step at which the states are that a function for the tasks is to be small at."""


def certify_memory(
    model: LoopModel, wrist: Wrist, controller: PI, dead_times: Sequence[float] = DEAD_TIMES
) -> list[Certificate]:
    """Both rungs at every dead time [s], rounded up to whole samples together with the plant's own.

    The evidence of the rung with memory tells of the rig's tasks, ``tasks``: from when on each run of them is
    one of the loops that the rung is about, which decays at ``decay``; see `memory.runs`, `memory.region`.

    >>> from plants import Wrist
    >>> wrist = Wrist.flexion()
    >>> pi = PI.of(wrist, 2.0, 6.0)
    >>> free, remembered = certify_memory(LoopModel.of(wrist, pi), wrist, pi, (0.05,))
    >>> free.holds, remembered.holds, free.decay < 0.05 < 0.2 < remembered.decay
    (True, True, True)
    >>> remembered.evidence["tasks"]["covered"]
    True
    """
    found = []
    for dead_time in dead_times:
        samples = delay_samples(model, dead_time)
        loop = FixedLawLoop.of(model, samples)
        system = discrete(delayed(model, samples).full, model.dt)
        slowest = system.rate(float(np.min(system.fates)))
        found += [
            _free(loop, dead_time, slowest),
            _remembered(loop, wrist, controller, dead_time, slowest),
        ]
    return found


def lines_of(model: LoopModel, law: HysteresisLaw) -> dict[Side, float]:
    """Slopes [deg/kPa] of the two lines of a loop that is one play between straight lines; empty for others.

    >>> from plants import Wrist
    >>> wrist = Wrist.flexion()
    >>> lines_of(LoopModel.of(wrist, PI.of(wrist, 1.0, 1.0)), wrist.hysteresis)
    {'ascending': 0.36, 'descending': 0.36}
    """
    sides = {branch: law.sides(branch) for branch in model.slopes}
    if not law.straight() or sorted(sides.values()) != [("ascending",), ("descending",), ("inner",)]:
        return {}
    return {of[0]: model.slopes[branch] for branch, of in sides.items() if of[0] != "inner"}


def _free(loop: FixedLawLoop, dead_time: float, slowest: float) -> Certificate:
    about = _about(loop, Switching.SLOPE_EVERY_SAMPLE)
    if slowest <= 0.0:
        return Certificate(popov.RUNG, about, dead_time, False, None, None, "", UnstableMode())
    found = fastest(lambda decay, sure: programme.common(loop, decay, sure), slowest)
    evidence = {"samples": loop.samples}
    if found.form is None:
        return Certificate(
            popov.RUNG, about, dead_time, False, None, None, found.solver, found.reason, evidence=evidence
        )
    return Certificate(
        popov.RUNG, about, dead_time, True, found.form.decay, found.margin, found.solver,
        evidence={**evidence, "form": found.form.record},
    )  # fmt: skip


def _remembered(
    loop: FixedLawLoop, wrist: Wrist, controller: PI, dead_time: float, slowest: float
) -> Certificate:
    about, lines = _about(loop, Switching.MEMORY), lines_of(loop.model, wrist.hysteresis)
    evidence: dict[str, Any] = {"samples": loop.samples, "slowest_pole_1_s": slowest}

    def none(reason: Any, solver: str = "") -> Certificate:
        return Certificate(ONE_LINE, about, dead_time, False, None, None, solver, reason, evidence=evidence)

    if not lines:
        return none(NotOnePlay())
    if slowest <= 0.0:
        return none(UnstableMode())
    by_slope = {slope: _of_line(loop, slope, slowest) for slope in sorted(set(lines.values()))}
    worst = min(by_slope.values(), key=lambda f: f.form.decay if f.form is not None else -1.0)
    if worst.form is None:
        return none(worst.reason, worst.solver)
    decay = worst.form.decay
    runs = run(wrist, controller, comparison_tasks(wrist.rig), loop.samples, loop.model.dt)
    wanted = min(SHARE * slowest, decay)
    forms = for_tasks(loop, wrist.hysteresis, lines, runs, wanted)
    evidence["forms"] = {str(s): f.form.record for s, f in by_slope.items()}
    evidence["tasks"] = _tasks(arrivals(forms, loop, wrist.hysteresis, runs), wanted, forms)
    margins = [f.margin for f in by_slope.values() if f.margin is not None]
    return Certificate(ONE_LINE, about, dead_time, True, decay, min(margins), worst.solver, evidence=evidence)


def for_tasks(
    loop: FixedLawLoop, law: HysteresisLaw, lines: Mapping[Side, float], runs: Runs, decay: float
) -> dict[Side, LineForm]:
    """For each line the function of a decay [1/s] that is least where the runs are soon after a step."""
    found: dict[Side, LineForm] = {}
    for side, slope in lines.items():
        seen = visited(side, loop, law, runs, LOOKED, decay)
        form = programme.line(loop, slope, decay, seen).form
        if form is not None:
            found[side] = form
    return found


def _of_line(loop: FixedLawLoop, slope: float, slowest: float) -> MemorySearch:
    return fastest(lambda decay, sure: programme.line(loop, slope, decay, sure=sure), slowest)


def fastest(search: Callable[[float, bool], MemorySearch], slowest: float) -> MemorySearch:
    """What a search finds with the largest decay [1/s], by bisection up to that of the slowest pole,
    confirmed; the answer at hardly any decay where it finds nothing.

    search: of a decay, and whether to be sure of what is found.
    """
    low, high = LEAST * slowest, slowest
    best = search(low, True)
    if best.form is None:
        return best
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if search(middle, False).form is not None else (low, middle)
    for back in BACK:
        found = search(back * low, True)
        if found.form is not None:
            return found
    return best


def _about(loop: FixedLawLoop, switching: Switching) -> LoopClass:
    model = loop.model
    return LoopClass(switching, rates(model), slopes(model), loop.law.grows, loop.samples)


def _tasks(found: Arrivals, decay: float, forms: Mapping[Side, LineForm]) -> dict[str, Any]:
    """What came of the tasks, for JSON."""
    there = found.time[np.isfinite(found.time)]
    return {
        "covered": found.all, "decay": decay, "runs": len(found.names), "arrive": len(there),
        "latest_s": float(there.max()) if there.size else None,
        "off_deg": found.error if there.size else None, "clipped": found.clipped,
        "never": [n for n, t in zip(found.names, found.time, strict=True) if not np.isfinite(t)],
        "forms": {side: form.record for side, form in forms.items()},
    }  # fmt: skip
