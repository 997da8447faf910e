"""Two campaigns of one rig: whether it changed between them, and in what.

The traced plant of the old campaign is held against every recording of the new one, as a log is against its
design.  Its structure is then fitted to the new campaign: differences of parameters with intervals that hold
for all of them together, and, where the rig changed, effects that came or went.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from design.robustness.box import Box, box_of
from design.studies.check.residual import (
    MARGIN,
    ChannelResidual,
    channel_residuals,
    drawn,
    free_readings,
)
from plants.measured.campaigns.begin import first_begin
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.free_run import squares
from plants.measured.instrument.remark import Remark
from plants.measured.trace.change.refit import StageRefit, refit, seen_alike
from plants.measured.trace.change.two_steps import white_errors
from plants.measured.trace.result import Named, Trace
from plants.measured.trace.search.candidate import WORTH
from plants.measured.trace.stages.model import Model
from plants.parameters.remainder import CHANNELS, RemainderSize

Array = NDArray[np.float64]
CONFIDENCE = 0.95
"""Probability that all intervals together hold the true differences (Bonferroni)."""


@dataclass(frozen=True)
class ParameterChange:
    """A parameter that both campaigns determine: its values, their difference, and the interval of that, in
    its unit; all intervals of a study hold together.  rise: by how much the chi-square per row of the new
    campaign would rise with the old value, the other parameters fitted."""

    name: str
    unit: str
    stage: str
    old: float
    new: float
    low: float
    high: float
    rise: float

    @property
    def difference(self) -> float:
        """New less old."""
        return self.new - self.old

    @property
    def half_width(self) -> float:
        """Half the width of the interval."""
        return 0.5 * (self.high - self.low)

    @property
    def differs(self) -> bool:
        """Whether the difference is beyond its interval, and seen in what the plant simulates: a smaller one
        is an imperfection of the model's form as often as a change, however certain."""
        return self.certain and self.rise > WORTH

    @property
    def certain(self) -> bool:
        """Whether the interval excludes that there is no difference."""
        return self.low > 0.0 or self.high < 0.0


@dataclass(frozen=True)
class RecordingResidual:
    """What the old plant leaves of a recording of the new campaign."""

    recording: Recording
    channels: tuple[ChannelResidual, ...]


@dataclass(frozen=True)
class CampaignChange:
    """What changed between two campaigns of one rig.

    residuals: of the old plant on the new campaign, which alone decide whether the rig changed.  parameters:
    of the structure that the new campaign has, those that both determine.  undetermined: parameters that one
    of the campaigns, or both, do not determine.
    """

    old: Trace
    campaign: Campaign
    residuals: tuple[RecordingResidual, ...]
    stages: tuple[StageRefit, ...]
    parameters: tuple[ParameterChange, ...]
    undetermined: tuple[str, ...]
    instrument: tuple[Remark, ...]

    @property
    def changed(self) -> bool:
        """Whether the new campaign shows what the old plant does not explain."""
        return any(c.new for r in self.residuals for c in r.channels)

    @property
    def verdict(self) -> str:
        """``changed`` or ``unchanged``."""
        return "changed" if self.changed else "unchanged"

    @property
    def came(self) -> tuple[Named, ...]:
        """Effects that only the new campaign needs."""
        return tuple(e for s in self.stages for e in s.came)

    @property
    def went(self) -> tuple[str, ...]:
        """Effects that the new campaign does not need any more."""
        return tuple(n for s in self.stages for n in s.went)

    @property
    def kept(self) -> tuple[str, ...]:
        """Effects that both campaigns need."""
        return tuple(n for s in self.stages for n in s.old.effects if n in s.new.effects)

    @property
    def unexplained(self) -> tuple[str, ...]:
        """Channels of which more is left than was, with all these changes."""
        return tuple(
            s.new.stage.channel for s in self.stages if s.new.chi2 > MARGIN**2 * max(s.old.chi2, 1.0)
        )


def campaign_change(
    old: Trace, campaign: Campaign, seed: int = 0, progress: Callable[[str, float], None] | None = None
) -> CampaignChange:
    """Hold a campaign against the trace of an earlier one of the same rig.

    Raises InputError for a campaign of another motion or with other channels.
    """
    campaign, instrument = seen_alike(old, campaign)
    residuals = left_of(old, campaign, seed)
    changed = any(c.new for r in residuals for c in r.channels)
    stages = refit(old, campaign, changed, seed, progress)
    found = [_differences(s) for s in stages]
    count = sum(len(f) for f in found)
    parameters = tuple(p for s, f in zip(stages, found, strict=True) for p in _joint(old, s, f, count))
    return CampaignChange(
        old, campaign, residuals, stages, parameters,
        tuple(_undetermined(stages, parameters)), instrument,
    )  # fmt: skip


def left_of(old: Trace, campaign: Campaign, seed: int = 0) -> tuple[RecordingResidual, ...]:
    """What the plant of a trace leaves of each recording of another campaign, and up to what it may."""
    box = box_of(replace(old.revised, remainder=_left_anywhere(old)))
    shares = not_contradicted(box, old, drawn(box, seed))
    return tuple(
        RecordingResidual(r, channel_residuals(Playback(r, old.revised.rig.sample_time), box, shares))
        for r in campaign.recordings
    )


def not_contradicted(box: Box, old: Trace, shares: Array) -> Array:
    """Places in the box of a traced plant, (intervals, lanes), moved towards the plant itself as far as it
    takes until none changes the old recordings by more than the plant leaves of them.

    Errors of parameters that the old recordings tell from each other badly, or not at all, are wide; a plant
    that they contradict would forgive any change of the rig.
    """
    if not box.intervals:
        return shares
    wrist, moved = box.wrist, box.at(shares)
    squares: dict[str, list[Array]] = {channel: [] for channel in CHANNELS}
    for r in (*old.campaign.fit, *old.campaign.validate):
        playback = Playback(r, wrist.rig.sample_time)
        begin = first_begin(r, float(wrist.hysteresis.rest_pressure), wrist.rig)
        runs = (free_readings(playback, w, begin) for w in (moved, wrist))
        for channel, by, own in zip(CHANNELS, *runs, strict=True):
            squares[channel].append((by - own) ** 2)
    kept = np.ones(shares.shape[1])
    for channel, left in old.revised.remainder.items():
        rms = np.sqrt(np.mean(np.concatenate(squares[channel]), axis=0))
        kept = np.minimum(kept, np.hypot(left.rms, left.noise) / np.maximum(rms, 1e-12))
    return 0.5 + kept * (shares - 0.5)


def _left_anywhere(old: Trace) -> dict[str, RemainderSize]:
    """What the old plant leaves of that recording of its own campaign of which it leaves most: how much that
    is depends on what is asked, and the new campaign may ask another part of it."""
    found = {}
    for channel, left in old.revised.remainder.items():
        each = [
            float(np.mean(s)) for role in ("fit", "validate") for s in squares(old.runs, channel, role=role)
        ]
        rms = float(np.sqrt(max(*each, left.noise**2) - left.noise**2))
        found[channel] = replace(left, rms=max(rms, left.rms))
    return found


def _differences(stage: StageRefit) -> dict[str, float]:
    """Standard error of the difference of each parameter that both campaigns determine."""
    found = {}
    for name, before in stage.old_errors.items():
        after = stage.new_errors.get(name)
        if before is not None and after is not None:
            found[name] = float(np.hypot(before, after))
    return found


def _undetermined(stages: Sequence[StageRefit], known: Sequence[ParameterChange]) -> list[str]:
    """Parameters that both campaigns have, but do not both determine."""
    both = [n for s in stages for n in s.new.names if n in s.old.values]
    return [n for n in both if n not in {p.name for p in known}]


def _joint(old: Trace, stage: StageRefit, errors: dict[str, float], count: int) -> list[ParameterChange]:
    """Differences with intervals that hold for `count` parameters together."""
    from scipy.stats import t

    free = min(_free(stage.old), _free(stage.new))
    reach = float(t.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / max(count, 1), max(free, 1)))
    alone = dict(zip(stage.new.names, white_errors(stage.new), strict=True))
    found = []
    for name, error in errors.items():
        before, after = stage.old.values[name], stage.new.values[name]
        half = reach * error
        unit = old.revised.parameters[name].unit
        found.append(
            ParameterChange(
                name,
                unit,
                stage.new.stage.name,
                before,
                after,
                after - before - half,
                after - before + half,
                (after - before) ** 2 / (alone[name] ** 2 * len(stage.new.residual)),
            )
        )
    return found


def _free(model: Model) -> int:
    """Degrees of freedom of standard errors over blocks."""
    return int(model.problem.blocks.max()) + 1 - len(model.names)
