"""What a model leaves of a channel, and what an engineer would plot it against."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import resolution

Array = NDArray[np.float64]
RemainderStage = Literal["regulator", "wrist"]

TURN = 0.1
"""The direction has turned when the pressure has come back by this much [kPa]."""

SMOOTHED = 11
"""Rows over which the other motion's pressure, the only measured variable here, is smoothed."""


@dataclass(frozen=True)
class Remainder:
    """What a model leaves of one channel in one recording; arrays of shape (n,).

    name: of the recording; stage: ``regulator`` for what is left of the pressure [kPa], ``wrist`` for
    the angle [deg]; time [s]; value: measured minus simulated; noise: floor of the channel (standard
    deviation, from the data), both in the channel's unit; variables: what to plot it against, by
    name with unit; resolution: smallest step of the logged channel, in its unit, 0 where unknown.
    """

    name: str
    stage: RemainderStage
    time: Array
    value: Array
    noise: float
    variables: Mapping[str, Array]
    resolution: float = 0.0


def remainder_of(
    recording: Recording, stage: RemainderStage, pressure: Array, angle: Array | None, noise: float
) -> Remainder:
    """What a simulated pressure [kPa] and angle [deg] (n,) leave of a recording at a stage.

    `noise` is the floor of the stage's channel.  Raises ValueError where that was not logged or simulated.
    """
    measured, simulated = (recording.pressure, pressure) if stage == "regulator" else (recording.angle, angle)
    if measured is None or simulated is None:
        raise ValueError(f"{recording.name}: the {stage} was not measured, or not simulated")
    return Remainder(
        recording.name, stage, recording.time, measured - simulated, noise,
        variables(recording, pressure, angle), resolution(measured),
    )  # fmt: skip


def variables(recording: Recording, pressure: Array, angle: Array | None) -> dict[str, Array]:
    """What an engineer would plot a residual against, by name with unit, shape (n,) each.

    Taken from the simulated pressure [kPa] and angle [deg] (None where only the regulator was
    simulated), not from the measured ones, whose noise is part of the residual and would
    correlate with it.  Channels that were not simulated are as logged.
    """
    from scipy.signal import savgol_filter

    time = recording.time - recording.time[0]
    heading, since = direction(recording.time, pressure)
    found = {
        "pressure_kPa": pressure,
        "pressure_rate_kPa_s": np.gradient(pressure, recording.time),
        "direction": heading,
    }
    if angle is not None:
        found["angle_deg"] = angle
    found |= {
        "time_s": time,
        "since_reversal_s": since,
        "work_kPa": np.append(0.0, np.cumsum(np.abs(np.diff(pressure)))),
        "command_V": recording.command,
    }
    if recording.other_pressure is not None:
        other = recording.other_pressure
        found["other_pressure_kPa"] = savgol_filter(other, SMOOTHED, 2) if len(other) > SMOOTHED else other
    if recording.reference is not None:
        found["reference_deg"] = recording.reference
    return found | dict(recording.extra)


def direction(time: Array, pressure: Array) -> tuple[Array, Array]:
    """Direction of the last movement of the pressure [kPa], (n,), -1, 0 or 1, 0 before the first, and
    the time since it last turned [s].

    A turn counts when the pressure has come back by TURN, and from where it last stood at its extreme.
    """
    heading, since = np.zeros(len(time)), np.empty(len(time))
    now, extreme, turned = 0.0, float(pressure[0]), float(time[0])
    at = turned
    for i, (t, p) in enumerate(zip(time.tolist(), pressure.tolist(), strict=True)):
        if abs(p - extreme) > TURN and (p - extreme) * now <= 0.0:
            now, turned = (1.0 if p > extreme else -1.0), at
            extreme, at = p, t
        elif now != 0.0 and (p - extreme) * now >= 0.0:
            extreme, at = p, t
        elif now == 0.0:
            at = t
        heading[i], since[i] = now, t - turned
    return heading, since
