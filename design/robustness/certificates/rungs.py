"""Every rung for the loop of one controller; all open where its law is none that the rungs are about."""

from collections.abc import Callable, Sequence

from design.controllers.pi import PI
from design.robustness.box import Box
from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.continuous import ladder, popov, quadratic
from design.robustness.certificates.continuous.signals import rates, slopes
from design.robustness.certificates.memory.ladder import IN_BOX, ONE_LINE, certify_memory
from design.robustness.certificates.reasons import OtherLaw
from design.robustness.certificates.sampled import sampled_loop
from design.robustness.certificates.sampled.words import Word
from design.robustness.loop_model import LoopModel
from plants.wrist import Wrist

FIRST: dict[Switching, str] = {
    Switching.MEMORY: ONE_LINE, Switching.MEMORY_IN_BOX: IN_BOX, Switching.SLOPE_EVERY_SAMPLE: popov.RUNG,
    Switching.FIXED_LAW: popov.RUNG, Switching.ANY_TIME: quadratic.RUNG,
    Switching.EVERY_SAMPLE: quadratic.RUNG,
}  # fmt: skip
"""The first rung that would be tried about each class of loops."""


def certify_everything(
    wrist: Wrist,
    controller: PI,
    dead_times: Sequence[float],
    box: Box | None = None,
    stable: bool = True,
    tell: Callable[[float], None] = lambda share: None,
) -> tuple[list[Certificate], Word | None]:
    """Rungs in continuous time and sampled at every dead time [s], and an order of switching that speaks
    against some, looked for where each branch is `stable`; box: for the rung about its plants; tell: of the
    share that is done.

    A weight of the reference changes no loop, and where a step of it starts is known (`LoopModel.weight`).
    """
    model, times = LoopModel.of(wrist, controller), tuple(dead_times)
    if model.other_law:
        return [_open(model, s, t) for t in times for s in Switching], None
    rungs = ladder.certify(model, wrist, controller, wrist.rig.task.step, times)
    tell(0.4)
    word = sampled_loop.word_of(model) if stable else None
    tell(0.5)
    rungs += sampled_loop.certify_sampled(model, times, word)
    tell(0.7)
    return [*rungs, *certify_memory(model, wrist, controller, times, box)], word


def _open(model: LoopModel, switching: Switching, dead_time: float) -> Certificate:
    about = LoopClass(switching, rates(model), slopes(model))
    why = OtherLaw(model.other_law)
    return Certificate(FIRST[switching], about, dead_time, False, None, None, "", why)
