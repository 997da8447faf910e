"""What a trace finds."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from plants.effects.wrist.learnt_block import LearntBlock
from plants.measured.campaigns.campaign import Campaign
from plants.measured.fitting.fit import Fit
from plants.measured.fitting.free_run import FreeRun
from plants.measured.fitting.stage import Stage
from plants.measured.instrument.remark import Remark
from plants.measured.residual.examine import Examination
from plants.measured.trace.law import LawChoice
from plants.measured.trace.revision.size import explained_share
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.search.description import Description
from plants.measured.trace.search.rounds import EffectSearch
from plants.measured.trace.stages.model import Model
from plants.parameters.correlation import ParameterCorrelation
from plants.parameters.quantities import ParameterSet
from plants.parameters.remainder import RemainderSize
from plants.wrist import Wrist


@dataclass(frozen=True)
class Named:
    """An effect that was found.

    name, form, stage: which; parameters: value, unit and standard error by name;
    alternatives: other effects that this data cannot tell from it; separations:
    which recording would, in words.
    """

    name: str
    form: str
    stage: str
    parameters: Mapping[str, tuple[float, str, float | None]]
    alternatives: tuple[str, ...]
    separations: tuple[str, ...]


@dataclass(frozen=True)
class StageTrace:
    """One stage: the search for effects, the residual before and after it, and what to make of it.

    explained: whether the residual reaches the noise, or is too small to matter.  cannot_judge: effects
    that the data never excites, with the reason.  description: of what
    is left, where no effect explains it.  block: the chosen model with a learnt block, where that was asked
    for and adopted.
    """

    stage: Stage
    search: EffectSearch
    before: Examination
    after: Examination
    explained: bool
    cannot_judge: Mapping[str, str]
    description: Description | None
    block: Candidate | None = None

    @property
    def without_effects(self) -> "StageTrace":
        """The same stage without the effects that were found."""
        declared = self.search.declared
        return replace(self, search=replace(self.search, chosen=declared), after=self.before)

    @property
    def model(self) -> Model:
        """The model that was chosen, with the learnt block where there is one."""
        return (self.block or self.search.chosen).model

    @property
    def name(self) -> str:
        """``regulator``, ``wrist`` or ``whole``."""
        return self.stage.name


@dataclass(frozen=True)
class Trace:
    """The trace of a campaign.

    verdict: ``nothing-missing``, ``explained`` or ``unexplained``; before, after:
    errors by channel on the held-out recordings, with intervals at 95 %
    by bootstrap over blocks; revised: the declared parameters refitted, and effects.  law: how the hysteresis
    law was chosen, None where it was given; instrument: what the logger does.  correlations: of the errors of
    parameters that were estimated together.  named_only: errors as `after`, of the plant without the learnt
    block, where one was adopted; learning: whether one was asked for.  law_alone: errors as `after`, of
    another hysteresis law than the declared one, without effects; empty where the law stayed or nothing was
    added.
    """

    campaign: Campaign
    fit: Fit
    verdict: str
    stages: tuple[StageTrace, ...]
    effects: tuple[Named, ...]
    revised: ParameterSet
    runs: tuple[FreeRun, ...]
    before: Mapping[str, float | None]
    after: Mapping[str, float | None]
    before_interval: Mapping[str, tuple[float, float] | None]
    after_interval: Mapping[str, tuple[float, float] | None]
    remarks: tuple[str, ...] = ()
    law: LawChoice | None = None
    instrument: tuple[Remark, ...] = ()
    correlations: tuple[ParameterCorrelation, ...] = ()
    named_only: Mapping[str, float | None] | None = None
    learning: bool = False
    law_alone: Mapping[str, float | None] = field(default_factory=dict)

    @property
    def other_law(self) -> str | None:
        """Name of the hysteresis law of the revised plant where the declared one has another."""
        name = self.revised.law.NAME
        return None if name == self.fit.fitted.law.NAME else name

    @property
    def differs(self) -> bool:
        """Whether the revised plant has effects, or another hysteresis law, than the declared one."""
        return bool(self.effects or self.other_law)

    @property
    def explained_share(self) -> dict[str, float | None]:
        """Share of the variance above the noise that the declared model leaves and its causes take away, by
        channel."""
        return {c: explained_share(self.before[c], self.by_causes[c], self.noise[c]) for c in self.before}

    @property
    def by_causes(self) -> Mapping[str, float | None]:
        """Errors with all causes that were found, without a learnt block."""
        return self.after if self.named_only is None else self.named_only

    @property
    def block(self) -> LearntBlock | None:
        """The learnt block of the revised plant."""
        found = [e for e in Wrist.of(self.revised).effects if isinstance(e, LearntBlock)]
        return found[0] if found else None

    @property
    def remainder(self) -> dict[str, RemainderSize | None]:
        """What is left of each channel without the noise."""
        return {c: self.revised.remainder.get(c) for c in self.before}

    @property
    def worse(self) -> bool:
        """Whether the revised plant is further off the angle, or the pressure where no angle was logged, than
        the declared one on recordings that chose nothing."""
        channel = "angle_deg" if self.before.get("angle_deg") is not None else "pressure_kPa"
        before, after = self.before[channel], self.after[channel]
        return before is not None and after is not None and after > 1.0001 * before

    @property
    def noise(self) -> Mapping[str, float | None]:
        """Noise floor of each channel, from the data alone."""
        return self.fit.noise

    @property
    def cannot_judge(self) -> dict[str, str]:
        """Effects that the data never excites, with the reason."""
        return {n: why for s in self.stages for n, why in s.cannot_judge.items()}

    @property
    def unexplained(self) -> list[StageTrace]:
        """Stages in which a structured residual is left."""
        return [s for s in self.stages if not s.explained]
