"""A log of the closed loop held against its design, as one value: inside the envelope or not, which figure
departs first, and whether the plant is still the one that was traced."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from design.robustness.requirement import Requirement, requirement
from design.studies.check.envelope import SampledEnvelope, envelope
from design.studies.check.residual import ResidualCheck, residual
from design.studies.check.stairs import Stair, stairs_of
from design.synthesis.designed_plant import events, without
from plants.errors import InputError
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.formats.cells import shorten
from plants.measured.trace.stages.between_rows import with_command
from plants.parameters.quantities import ParameterSet

OTHER_GAINS = 0.02
"""Rms, as a share of the command's range, by which a logged command may differ from what the gains give for
the logged angle; more is another controller's."""


@dataclass(frozen=True)
class LogCheck:
    """A log, the stairs of it that were judged, the envelope and the residual.

    command_off: rms [share of the range] of the logged command beside what the controller gives for the
    logged angle.
    """

    log: Recording
    plant: ParameterSet
    stairs: tuple[Stair, ...]
    envelope: SampledEnvelope
    residual: ResidualCheck
    command_off: float

    @property
    def kept(self) -> bool:
        """Whether the log is within what the design predicted."""
        return self.envelope.inside

    @property
    def verdict(self) -> str:
        """``as promised``, ``changed`` where the promise is kept but the plant is another, or ``broken``."""
        if not self.kept:
            return "broken"
        return "changed" if self.residual.new else "as promised"

    @property
    def own_controller(self) -> bool:
        """Whether the log's command is that of the design's controller."""
        return self.command_off <= OTHER_GAINS


def check_log(
    log: Recording, plant: ParameterSet, controller: Any, samples: int = 200, seed: int = 0,
    jobs: int | None = None,
) -> LogCheck:  # fmt: skip
    """Hold a log of a closed loop against samples of its design and against the traced plant.

    Where set-points changed between rows, when they did is estimated first.
    Raises InputError for a log without reference or angle, or whose reference never steps.
    """
    if log.reference is None or log.angle is None:
        lacks = "reference_deg" if log.reference is None else "angle_deg"
        raise InputError(
            f"{log.name}: has no {lacks}; its columns are {shorten(list(log.channels))}: name the one under "
            "[columns] of campaign.toml beside it, or log the closed loop with its reference and its angle"
        )
    required: Requirement = requirement(without(plant, events(plant)))
    playback = Playback(with_command(log, required.wrist), plant.rig.sample_time)
    stairs = _stairs(log)
    kept = plant.remainder.get("angle_deg")
    noise = required.conditions.noise if kept is None else kept.noise
    left = residual(playback, required.box, seed)
    error = 0.0 if required.box.remainder is None else left.known("angle_deg")
    found = envelope(playback, stairs, required, controller, samples, seed, noise, error, jobs)
    return LogCheck(log, plant, stairs, found, left, _command_off(log, controller))


def _stairs(log: Recording) -> tuple[Stair, ...]:
    assert log.reference is not None
    try:
        return stairs_of(log.time, log.reference)
    except InputError as error:
        raise InputError(f"{log.name}: {error}") from None


def _command_off(log: Recording, controller: Any) -> float:
    """Rms of the logged command beside what a controller gives at the log's rows, as a share of its range;
    its integral part begins where the first command is the logged one."""
    from plants.simulation.sensor import Measured

    assert log.reference is not None
    assert log.angle is not None
    law = controller.sampled(float(np.median(np.diff(log.time))))
    first = Measured(0.0, float(log.angle[0]), controller.gain * float(log.command[0]))
    held = controller.rest_pressure
    at_first = first._replace(error=float(log.reference[0] - log.angle[0]))
    _, begun = law.act(controller.holding(held, first), at_first)
    held += controller.gain * float(log.command[0] - begun)
    state, given = controller.holding(held, first), np.empty(len(log.time))
    for k, (asked, angle) in enumerate(zip(log.reference, log.angle, strict=True)):
        state, given[k] = law.act(state, Measured(asked - angle, angle, first.pressure))
    return float(np.sqrt(np.mean((given - log.command) ** 2)) / (controller.high - controller.low))
