"""The rungs in continuous time as certificates: the best decay rate, and where it holds."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from design.controllers.pi import PI
from design.robustness.certificates.certificate import (
    Certificate,
    LoopClass,
    Switching,
)
from design.robustness.certificates.continuous import popov, region
from design.robustness.certificates.continuous.search import RUNGS, fastest, search
from design.robustness.certificates.continuous.signals import rates, slopes, total_dead_time
from design.robustness.certificates.continuous.virgin import VirginBounds, time_on_virgin_curve
from design.robustness.certificates.reasons import UnstableBranch
from design.robustness.loop_model import LoopModel
from design.synthesis import convex
from plants.wrist import Wrist

DEAD_TIMES = (0.0, 0.05)
"""Dead times [s] beside the loop's own; rigs of this kind show about 50 ms of tube."""


def certify(
    model: LoopModel,
    wrist: Wrist,
    controller: PI,
    reference: float | None = None,
    dead_times: Sequence[float] = DEAD_TIMES,
) -> list[Certificate]:
    """Every rung at every dead time [s], with the largest step that it covers against `reference` [deg].

    A rung that finds nothing, or whose find the check does not confirm, is in the list with holds False
    and why.  `shape` and `level` are the region's: from every x with x' shape x <= level the command
    stays within its range for references up to `largest_step_deg` either way.  Only without dead
    time: with one, where the loop goes depends on what is on its way too, and the largest step
    alone is told.

    >>> from plants import Wrist
    >>> wrist, timid = Wrist.flexion(), PI(0.5, 0.5)
    >>> [c.holds for c in certify(LoopModel.of(wrist, timid), wrist, timid, dead_times=(0.0,))]
    [True, True]
    """
    reference = wrist.rig.task.step if reference is None else reference
    virgin = time_on_virgin_curve(wrist, controller, reference)
    return [
        _certificate(model, wrist, controller, reference, rung, dead_time, virgin)
        for dead_time in dead_times
        for rung in RUNGS
    ]


def certifies(model: LoopModel, rung: str, dead_time: float = 0.0) -> bool:
    """Whether a rung certifies a loop at all: one search by one solver, checked; for maps of the gain plane.

    dead_time [s].  Some 20 to 40 ms a call.  A solver that fails counts as no, where `certify` would try
    another.

    >>> from plants import Wrist
    >>> loop = LoopModel.of(Wrist.flexion(), PI(1.2, 2.2))
    >>> [certifies(loop, rung) for rung in RUNGS]
    [False, True]
    """
    if model.other_law or hopeless(model, dead_time) is not None:
        return False
    return search(model, rung, 0.0, dead_time, convex.SOLVERS[:1]).form is not None


def hopeless(model: LoopModel, dead_time: float) -> UnstableBranch | None:
    """Why no function can fall along a loop: a linear loop of it does not decay; None where it may.
    dead_time [s]: it moves poles, but not the one at 0 of a loop without integral action."""
    return unstable(model) if total_dead_time(model, dead_time) == 0.0 or model.Ki == 0.0 else None


def unstable(model: LoopModel) -> UnstableBranch | None:
    """The first branch and rate at which the linear loop without dead time does not decay; None where it
    does at every corner."""
    for branch, slope in model.distinct_slopes.items():
        for name, rate in (("slow", model.k_slow), ("fast", model.k_fast)):
            pole = np.linalg.eigvals(model.matrix(slope, rate))
            worst = float(pole.real.max())
            if worst >= 0.0:
                return UnstableBranch(branch, name, worst)
    return None


def class_of(model: LoopModel, rung: str) -> LoopClass:
    """The loops that a rung is about."""
    switching = Switching.FIXED_LAW if rung == popov.RUNG else Switching.ANY_TIME
    return LoopClass(switching, rates(model), slopes(model), popov.monotone(model))


def _certificate(
    model: LoopModel,
    wrist: Wrist,
    controller: PI,
    reference: float,
    rung: str,
    dead_time: float,
    virgin: VirginBounds,
) -> Certificate:
    about, pole = class_of(model, rung), hopeless(model, dead_time)
    evidence: dict[str, Any] = {"virgin_curve": virgin}
    if pole is not None:
        return Certificate(rung, about, dead_time, False, None, None, "", pole, evidence=evidence)
    found = fastest(model, rung, dead_time)
    if found.form is None:
        return Certificate(
            rung, about, dead_time, False, None, None, found.solver, found.reason, evidence=evidence
        )
    covered = region.largest(model, wrist, controller, rung, dead_time)
    evidence["form"] = found.form.record
    evidence["region"] = _of_region(covered, model, wrist, controller, reference, virgin)
    shape, level = None, None
    if covered.form is not None and not covered.form.order:
        shape, level = region.start_matrix(covered.form, model), covered.level
    return Certificate(
        rung, about, dead_time, True, found.form.decay, found.margin, found.solver,
        shape=shape, level=level, evidence=evidence,
    )  # fmt: skip


def _of_region(
    covered: region.InvariantRegion,
    model: LoopModel,
    wrist: Wrist,
    controller: PI,
    reference: float,
    virgin: VirginBounds,
) -> dict[str, Any]:
    """What the region says of the step that is asked for, from a line and from the virgin curve."""
    if covered.form is None:
        curved = {"curved": True} if covered.curved else {}
        return {"largest_step_deg": None, "covers_step": False, **curved}
    return {
        "largest_step_deg": covered.largest_step, "covers_step": abs(reference) <= covered.largest_step,
        "covers_step_from_virgin": region.covers(covered, model, wrist, controller, reference, virgin),
        "margin": covered.margin, "form": covered.form.record,
    }  # fmt: skip
