"""What is proved of exactly the recommended gains: the certificates that there are, told as they are."""

from collections.abc import Sequence
from typing import Any

from design.controllers.pi import PI
from design.robustness.box import Box
from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.rungs import certify_everything
from design.robustness.loop_model import LoopModel
from design.robustness.requirement import Requirement, requirement_record
from design.status import Status
from design.studies.stages import Stages
from plants.errors import InputError
from plants.wrist import Wrist


def kept_proof(
    stages: Stages, motion: str, required: Requirement, controller: PI, dead_time: float
) -> dict[str, Any]:
    """`proof` of a motion's gains on the plant of a requirement, behind a dead time [s] and on the box of
    parameters; taken from the stages of a design where these have it of the same gains and plant."""
    wrist = required.wrist
    asked = {
        "law": type(wrist.hysteresis).__name__, "plant": {n: float(v) for n, v in wrist.values.items()},
        "requirement": requirement_record(required), "dead_time_s": dead_time,
        "controller": {n: float(v) for n, v in vars(controller).items()},
    }  # fmt: skip
    return stages.done(f"proof-{motion}", asked, lambda: proof(wrist, controller, dead_time, required.box))


def proof(wrist: Wrist, controller: PI, dead_time: float, box: Box | None = None) -> dict[str, Any]:
    """Whether the sampled loop behind a dead time [s] is proved to decay under a controller, at which rate,
    and whether the proof covers the tasks; beside it every rung, also that for all plants in a box.

    A reference weight changes no loop, and a run from a task its own way; with a filter of the angle all
    rungs are open.  A proof for the loop in continuous time, or without the dead time, is in the list and
    does not count.
    """
    model = LoopModel.of(wrist, controller)
    times = tuple(dict.fromkeys((0.0, dead_time)))
    try:
        rungs, _ = certify_everything(wrist, controller, times, box)
    except (InputError, ArithmeticError, ValueError) as error:  # a loop that no certificate knows
        return _record((), model, dead_time, str(error))
    why = f"the controller has {model.other_law}, which no certificate knows" if model.other_law else ""
    return _record(rungs, model, dead_time, why)


def _record(rungs: Sequence[Certificate], model: LoopModel, dead_time: float, why: str) -> dict[str, Any]:
    """The best rung of the sampled loop with its dead time: one that covers the tasks before one that does
    not, then the faster.  Where a plant has effects that no certificate includes, the rungs are about the
    wrist without them, and no rate is told of the plant."""
    good = [c for c in rungs if _sampled(c) and c.holds and c.dead_time == dead_time]
    best = max(good, key=lambda c: (_covers(c), _rate(c)), default=None)
    proved = best is not None and not model.left_out
    told = [
        {
            "rung": c.rung, "sampled": _sampled(c), "status": c.status.value, "dead_time_s": c.dead_time,
            "rate_1_s": c.decay if c.holds else None, "covers_task": _covers(c),
        }
        for c in rungs
    ]  # fmt: skip
    return {
        "status": (Status.PROVED if proved else Status.OPEN).value,
        "rate_1_s": None if best is None or model.left_out else _rate(best),
        "rung": None if best is None else best.rung,
        "dead_time_s": dead_time,
        "covers_task": proved and best is not None and _covers(best),
        "left_out": list(model.left_out),
        "why": why,
        "rungs": told,
    }


def _sampled(c: Certificate) -> bool:
    return c.about is not None and c.about.switching.sampled


def not_asked(dead_time: float) -> dict[str, Any]:
    """The same where no proof was asked for, behind a dead time [s]: all is open."""
    return {
        "status": Status.OPEN.value, "rate_1_s": None, "rung": None, "dead_time_s": dead_time,
        "covers_task": False, "left_out": [], "why": "no proof was asked for", "rungs": [],
    }  # fmt: skip


def _covers(c: Certificate) -> bool:
    """Whether the tasks come to what a certificate is about."""
    tasks, region = c.evidence.get("tasks", {}), c.evidence.get("region", {})
    return bool(tasks.get("covered", False) or region.get("covers_task", False))


def _rate(c: Certificate) -> float:
    """The decay [1/s]: the one to which the tasks come, where they do."""
    tasks = c.evidence.get("tasks", {})
    return float(tasks["decay"] if tasks.get("covered", False) else c.decay or 0.0)
