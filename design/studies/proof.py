"""What is proved of exactly the recommended gains: the certificates that there are, told as they are."""

from typing import Any

from design.controllers.pi import PI
from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.continuous import ladder
from design.robustness.certificates.sampled import sampled_loop
from design.robustness.loop_model import LoopModel
from design.status import Status
from plants.errors import InputError
from plants.wrist import Wrist


def proof(wrist: Wrist, Kp: float, Ki: float, dead_time: float) -> dict[str, Any]:
    """Whether the sampled loop behind a dead time [s] is proved to decay under gains, at which rate, and
    whether the proof covers the task; beside it every rung.

    A reference weight changes no loop, so that what is proved of the gains holds whatever it is.  A proof for
    the loop in continuous time, or without the dead time, is in the list and does not count.
    """
    controller = PI.of(wrist, Kp, Ki)
    model = LoopModel.of(wrist, controller)
    times = tuple(dict.fromkeys((0.0, dead_time)))
    try:
        rungs = ladder.certify(model, wrist, controller, wrist.rig.task.step, times)
        sampled = sampled_loop.certify_sampled(model, times, sampled_loop.word_of(model))
    except (InputError, ArithmeticError, ValueError) as error:  # a loop that no certificate knows
        return _record(None, (), (), model, dead_time, str(error))
    good = [c for c in sampled if c.holds and c.dead_time == dead_time]
    best = max(good, key=lambda c: c.decay or 0.0, default=None)
    return _record(best, rungs, sampled, model, dead_time, "")


def _record(
    best: Certificate | None,
    rungs: Any,
    sampled: Any,
    model: LoopModel,
    dead_time: float,
    why: str,
) -> dict[str, Any]:
    proved = best is not None and not model.left_out
    covers = bool(best is not None and best.evidence.get("region", {}).get("covers_task", False))
    told = [
        {
            "rung": c.rung, "sampled": c in sampled, "status": c.status.value, "dead_time_s": c.dead_time,
            "rate_1_s": c.decay if c.holds else None,
        }
        for c in (*rungs, *sampled)
    ]  # fmt: skip
    return {
        "status": (Status.PROVED if proved else Status.OPEN).value,
        "rate_1_s": None if best is None else best.decay,
        "dead_time_s": dead_time,
        "covers_task": proved and covers,
        "left_out": list(model.left_out),
        "why": why,
        "rungs": told,
    }
