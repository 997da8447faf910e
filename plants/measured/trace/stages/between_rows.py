"""What the command did between the rows of a log.

A controller, or whatever else gives commands, that runs once a row holds its command until the next: the log
shows all of it.  One that runs faster moves it between rows, which are samples of a straight line but where a
set-point changed: a controller acts on that at once, and the log shows its command from the next row on.
Held until that row, the command comes up to a row late, and a fit makes the regulator too fast to make up for
it.  What the pressure did after each jump says when it was: one number for each jump, estimated in turn with
the parameters (separable least squares).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import first_begin
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.blocks import lower
from plants.measured.fitting.stage import Stage
from plants.measured.instrument.remark import Remark
from plants.measured.residual.stillness import noise_of_campaign
from plants.measured.trace.stages.model import Model
from plants.measured.trace.start import Start
from plants.wrist import Wrist

Array = NDArray[np.float64]
ROUNDS = 12
"""Turns of parameters and times: what a turn leaves of an error of the rate is about a half."""

STEPS = 3
"""Gauss-Newton steps of the times in a turn."""

SETTLED = 2e-5
"""Rms change of the times [s] below which they are left as they are."""

WORTH = 6.0
"""Sum of squares over the noise that goes with each jump if the jumps were between rows: a time that is
fitted to noise takes away one."""

TURNED = 30.0
"""Sum of squares over the noise that has to go for a command to be held, or straight, against what is taken
for granted: where it hardly moves but by jumps both are alike."""

RESTS = 0.5
"""Share of its rows in which a command of steps does not change."""

REMAINS = 0.25
"""Share of what chi-square has above 1 that may remain: what a model lacks goes in part with times too."""


def with_commands(begun: Start, model: Model) -> Start | None:
    """The start of a campaign with what its commands did between rows, and remarks of it; None where that is
    what was taken for it: held in open loop, straight lines with jumps at rows in a closed one.

    model: of the first stage, whose recordings are those of the campaign that may be fitted on.
    """
    campaign, stage = begun.campaign, model.stage
    found = _fitted(model)
    of = {p.recording.name: p.recording for p in found.stage.playbacks}
    fit = tuple(of.get(r.name, r) for r in campaign.fit)
    validate = tuple(with_command(r, found.wrist) for r in campaign.validate)
    if all(a is b for a, b in zip((*fit, *validate), campaign.recordings, strict=True)):
        return None
    remarks = _remarks([Playback(r, stage.rig.sample_time) for r in (*fit, *validate)])
    instrument = (*(r for r in begun.instrument if r.channel != "command_V"), *remarks)
    return replace(begun, campaign=replace(campaign, fit=fit, validate=validate), instrument=instrument)


def with_command(recording: Recording, wrist: Wrist) -> Recording:
    """A recording with what its command did between rows by the pressure of a wrist, by the angle where no
    pressure was logged; as it is where that tells nothing else."""
    playback = Playback(recording, wrist.rig.sample_time)
    channel = "angle_deg" if recording.pressure is None else "pressure_kPa"
    begin = first_begin(recording, float(wrist.hysteresis.rest_pressure), wrist.rig)
    begins = None if begin.at_zero else (begin,)
    noise = noise_of_campaign([recording], channel) or 1.0
    stage = Stage("whole", channel, noise, (playback,), (), wrist.rig, begins=begins)

    def left(stage: Stage) -> Array:
        return (stage.play(0, wrist) - stage.target) / noise

    before, timed = left(stage), _placed(stage, wrist)
    if not _worth(before, left(timed), stage):
        timed = stage
    other = _turned(stage)
    return (other if _better(left(timed), left(other), stage) else timed).playbacks[0].recording


def _fitted(model: Model) -> Model:
    """The model, fitted, under what the commands of its recordings did between rows."""
    timed = _in_turn(model)
    if not _worth(model.residual, timed.residual, model.stage):
        timed = model
    other = replace(model, stage=_turned(model.stage)).fitted()
    return other if _better(timed.residual, other.residual, model.stage) else timed


def _turned(stage: Stage) -> Stage:
    """The stage with commands held between rows that were straight, and straight where they were held; steps
    are steps, since a ramp over a row in their place only makes them half a row late."""

    def turned(r: Recording) -> Recording:
        if r.between == "held":  # as the mean of closer rows is
            return r
        if r.commanded == "held" and np.mean(np.diff(r.command) == 0.0) > RESTS:
            return r
        return replace(r, between="straight" if r.commanded == "held" else "held", ahead=None)

    return replace(stage, playbacks=tuple(replace(p, recording=turned(p.recording)) for p in stage.playbacks))


def _better(before: Array, after: Array, stage: Stage) -> bool:
    """Whether a residual under commands that were turned is smaller, by more than noise and for certain."""
    gone = float(np.sum(before**2) - np.sum(after**2))
    return gone > TURNED and lower(before, after, stage.left_out_blocks)


def _remarks(playbacks: Sequence[Playback]) -> list[Remark]:
    """What is said of commands that did between rows what is not taken for granted."""
    found = []
    for way in ("held", "straight"):
        turned = [p.recording for p in playbacks if p.recording.between == way]
        if turned:
            row = float(np.median(np.diff(turned[0].time)))
            found.append(Remark(way, "command_V", row, "s", tuple(dict.fromkeys(r.name for r in turned))))
    timed = [p for p in playbacks if p.recording.ahead is not None]
    if timed:
        names = tuple(dict.fromkeys(p.recording.name for p in timed))
        found.append(Remark("between", "command_V", sum(int(p.jumped.sum()) for p in timed), "jumps", names))
    return found


def _worth(before: Array, after: Array, stage: Stage) -> bool:
    """Whether enough of a residual goes with the times of the jumps of a stage."""
    count = sum(int(p.jumped.sum()) for p in stage.playbacks)
    gone = float(np.sum(before**2) - np.sum(after**2))
    excess = float(np.sum(before**2)) - len(before)
    return count > 0 and gone >= max(WORTH * count, (1.0 - REMAINS) * excess)


def _in_turn(model: Model) -> Model:
    """The model and the times of the jumps, each fitted under the other until the times stay; the parameters
    to what no time explains, so that a turn or two will do (variable projection)."""
    if not any(p.jumped.any() for p in model.stage.playbacks):
        return model
    for _ in range(ROUNDS):
        stage = _placed(model.stage, model.wrist)
        moved = _ahead(stage) - _ahead(model.stage)
        if np.sqrt(np.mean(moved**2)) < SETTLED:
            break
        model = replace(model, stage=stage).fitted_off_jumps()
    return model


def _ahead(stage: Stage) -> Array:
    """Times [s] of all jumps of a stage's recordings ahead of their rows."""
    return np.concatenate([p.ahead[p.jumped] for p in stage.playbacks])


def _placed(stage: Stage, wrist: Wrist) -> Stage:
    """The stage with the times of its jumps at which a wrist leaves least, each by the rows to the next."""
    for _ in range(STEPS):
        moved = tuple(_step(stage, i, wrist) for i in range(len(stage.playbacks)))
        stage = replace(stage, playbacks=moved)
    return stage


def _step(stage: Stage, i: int, wrist: Wrist) -> Playback:
    """The i-th recording with its jumps moved by a Gauss-Newton step each, within the row before theirs."""
    playback = stage.playbacks[i]
    at = np.flatnonzero(playback.jumped)
    if not len(at):
        return playback
    simulated, slopes = stage.moved_by_jumps_of(i, wrist)
    left = simulated - stage.target[slice(*stage.edges[i : i + 2])]
    curvature = np.add.reduceat(slopes**2, at)
    down = np.add.reduceat(slopes * left, at)
    step = np.divide(down, curvature, out=np.zeros(len(at)), where=curvature > 0.0)
    rows = np.diff(playback.recording.time, prepend=np.nan)[at]
    return playback.jumping(np.clip(playback.ahead[at] - step, 0.0, rows))
