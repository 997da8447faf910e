"""The rungs of the sampled loop with one law of the regulator: the best decay, and the tasks that come to it.

Without memory the slope may change at every sample, as in `certificates.continuous.popov`.  With memory it
changes as the loop has it, while one line at most is met: what is left of every motion in the end.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from design.controllers.pi import PI
from design.evaluation.tasks import comparison_tasks
from design.robustness.box import Box
from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.continuous import popov
from design.robustness.certificates.memory import programme
from design.robustness.certificates.memory.form import LineForm, MemorySearch
from design.robustness.certificates.memory.loop import FixedLawLoop, Plants
from design.robustness.certificates.memory.region import Arrivals, arrivals, visited
from design.robustness.certificates.memory.runs import Runs, run
from design.robustness.certificates.reasons import NoCertificate, NotOnePlay, UnstableMode
from design.robustness.certificates.sampled.sampled_loop import delay_samples, delayed
from design.robustness.certificates.sampled.switched import discrete
from design.robustness.loop_model import LoopModel
from plants.hysteresis.law import HysteresisLaw, Side
from plants.linearisation import branch_slopes
from plants.wrist import Wrist

DEAD_TIMES = (0.0, 0.05)
"""Dead times [s] beside the loop's own."""

ONE_LINE, IN_BOX = "memory of one line", "memory of one line, in the box"
TRIED = (0.5, 0.2, 0.05, 1e-3)
"""Decays that are asked for at first, as shares of that of the slowest pole, until one is found."""

HALVINGS, IN_BOX_HALVINGS = 5, 3
"""Of the interval in which the best decay lies, of one plant and in a box."""

BACK = (1.0, 0.9, 0.5)
"""Shares of what a solver claims beyond the first decay found, tried until the check confirms one."""

SHARE = 0.5
"""Of the decay of the slowest pole, which the tasks are to come to; less where no function has so much."""

LOOKED = 2.0
"""Time [s] after a step at which the states are that a function for the tasks is to be small at."""


def certify_memory(
    model: LoopModel,
    wrist: Wrist,
    controller: PI,
    dead_times: Sequence[float] = DEAD_TIMES,
    box: Box | None = None,
) -> list[Certificate]:
    """Both rungs at every dead time [s], rounded up to whole samples together with the plant's own; where
    a box is given the one with memory for all plants in it too, whose slopes and lag may drift.

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
        found.append(_free(loop, dead_time, slowest))
        found.append(_remembered(loop, wrist, controller, dead_time, slowest))
        if box is not None:
            # The branches of another law need not have the same names everywhere in the box.
            known = lines_of(loop.plants, wrist.hysteresis)
            wide = FixedLawLoop.of(model, samples, plants_of(box, controller)) if known else loop
            found.append(_in_box(wide, wrist.hysteresis, dead_time, slowest))
    return found


def plants_of(box: Box, controller: PI) -> Plants:
    """The plants of a box, as a controller meets them.

    >>> from design.robustness.box import box_of
    >>> from plants.parameters.files import built_in
    >>> plants = plants_of(box_of(built_in("flexion")), PI(1.2, 2.2))
    >>> [round(x, 3) for x in (*plants.slopes["line1"], *plants.slow, *plants.lag, *plants.gain)]
    [0.324, 0.396, 0.44, 0.66, 0.128, 0.192, 1.0, 1.0]
    """
    gain = float(box.wrist.regulator.gain)
    low, high = box.bounds("gain")
    branches = branch_slopes(box.wrist, box.wrist.reach)
    return Plants(
        {branch: box.slopes(branch) for branch in branches}, box.bounds("k_slow"), box.bounds("k_fast"),
        box.bounds("Tw"), (low / gain, high / gain),
    )  # fmt: skip


def lines_of(plants: Plants, law: HysteresisLaw) -> dict[Side, tuple[float, ...]]:
    """Ends of the slopes [deg/kPa] of the two lines of a loop that is one play between straight lines; empty
    for others.

    >>> from plants import Wrist
    >>> wrist = Wrist.flexion()
    >>> lines_of(Plants.of(LoopModel.of(wrist, PI.of(wrist, 1.0, 1.0))), wrist.hysteresis)
    {'ascending': (0.36,), 'descending': (0.36,)}
    """
    sides = {branch: law.sides(branch) for branch in plants.slopes}
    if not law.straight() or sorted(sides.values()) != [("ascending",), ("descending",), ("inner",)]:
        return {}
    ends = {of[0]: tuple(sorted(set(plants.slopes[branch]))) for branch, of in sides.items()}
    return {side: of for side, of in ends.items() if side != "inner"}


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
    found = _with_memory(ONE_LINE, loop, wrist.hysteresis, dead_time, slowest)
    if found.decay is None:
        return found
    runs = run(wrist, controller, comparison_tasks(wrist.rig), loop.samples, loop.model.dt)
    wanted = min(SHARE * slowest, found.decay)
    forms = for_tasks(loop, wrist.hysteresis, lines_of(loop.plants, wrist.hysteresis), runs, wanted)
    tasks = _tasks(arrivals(forms, loop, wrist.hysteresis, runs), wanted, forms)
    return replace(found, evidence={**found.evidence, "tasks": tasks})


def _in_box(loop: FixedLawLoop, law: HysteresisLaw, dead_time: float, slowest: float) -> Certificate:
    return _with_memory(IN_BOX, loop, law, dead_time, slowest)


def _with_memory(
    name: str, loop: FixedLawLoop, law: HysteresisLaw, dead_time: float, slowest: float
) -> Certificate:
    """The rung with memory; slowest [1/s]: decay of the slowest pole of the model's plant."""
    switching = Switching.MEMORY_IN_BOX if name == IN_BOX else Switching.MEMORY
    about, lines = _about(loop, switching), lines_of(loop.plants, law)
    evidence: dict[str, Any] = {"samples": loop.samples, "slowest_pole_1_s": slowest}

    def none(reason: NoCertificate | None, solver: str = "") -> Certificate:
        return Certificate(name, about, dead_time, False, None, None, solver, reason, evidence=evidence)

    if not lines:
        return none(NotOnePlay())
    if slowest <= 0.0:
        return none(UnstableMode())
    found = {ends: _of_line(loop, ends, slowest) for ends in sorted(set(lines.values()))}
    worst = min(found.values(), key=lambda f: f.form.decay if f.form is not None else -1.0)
    if worst.form is None:
        return none(worst.reason, worst.solver)
    evidence["forms"] = [
        {"line_deg_per_kPa": ends, **f.form.record} for ends, f in found.items() if f.form is not None
    ]
    margin = min(f.margin for f in found.values() if f.margin is not None)
    return Certificate(
        name, about, dead_time, True, worst.form.decay, margin, worst.solver, evidence=evidence
    )


def for_tasks(
    loop: FixedLawLoop, law: HysteresisLaw, lines: Mapping[Side, tuple[float, ...]], runs: Runs, decay: float
) -> dict[Side, LineForm]:
    """For each line the function of a decay [1/s] that is least where the runs are soon after a step."""
    found: dict[Side, LineForm] = {}
    for side, ends in lines.items():
        seen = visited(side, loop, law, runs, LOOKED, decay)
        form = programme.line(loop, ends, decay, seen).form
        if form is not None:
            found[side] = form
    return found


def _of_line(loop: FixedLawLoop, ends: tuple[float, ...], slowest: float) -> MemorySearch:
    halvings = HALVINGS if loop.plants == Plants.of(loop.model) else IN_BOX_HALVINGS
    return fastest(lambda decay, sure: programme.line(loop, ends, decay, sure=sure), slowest, halvings)


def fastest(
    search: Callable[[float, bool], MemorySearch], slowest: float, halvings: int = HALVINGS
) -> MemorySearch:
    """What a search finds with the largest decay [1/s], by bisection up to that of the slowest pole,
    confirmed.

    search: of a decay, and whether to be sure of what is found.  What is found of a decay holds of slower
    ones, but with hardly any decay the inequalities hold by hardly any margin: `TRIED` begins in the middle.
    """
    high, best = slowest, search(TRIED[0] * slowest, True)
    for share in TRIED[1:]:
        if best.form is not None:
            break
        best = search(share * slowest, True)
    if best.form is None:
        return best
    first = low = best.form.decay
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if search(middle, False).form is not None else (low, middle)
    for back in BACK if low > first else ():
        found = search(first + back * (low - first), True)
        if found.form is not None:
            return found
    return best


def _about(loop: FixedLawLoop, switching: Switching) -> LoopClass:
    p = loop.plants
    rates = min(p.slow + p.fast), max(p.slow + p.fast)
    lag = p.lag if p.lag[0] < p.lag[1] else None
    slopes = p.extremes[0], p.extremes[-1]
    return LoopClass(switching, rates, slopes, loop.law.grows, loop.samples, lag)


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
