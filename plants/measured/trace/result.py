"""What a trace finds."""

from collections.abc import Mapping
from dataclasses import dataclass

from plants.measured.campaign import Campaign
from plants.measured.fit import Fit
from plants.measured.free_run import FreeRun
from plants.measured.residual.examine import Examination
from plants.measured.trace.search.choose import EffectSearch
from plants.measured.trace.search.learnt import Learnt
from plants.measured.trace.stages.model import Model
from plants.measured.trace.stages.stage import Stage
from plants.parameters.quantities import ParameterSet


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
    """One stage: the search for effects, the remainder before and after it, and what to make of it.

    explained: whether the remainder reaches the noise.  cannot_judge: effects
    that the data never excites, with the reason.  learnt: a description of what
    is left, where no effect explains it.
    """

    stage: Stage
    search: EffectSearch
    before: Examination
    after: Examination
    explained: bool
    cannot_judge: Mapping[str, str]
    learnt: Learnt | None

    @property
    def model(self) -> Model:
        """The model that was chosen."""
        return self.search.chosen.model

    @property
    def name(self) -> str:
        """``regulator``, ``wrist`` or ``whole``."""
        return self.stage.name


@dataclass(frozen=True)
class Trace:
    """The trace of a campaign.

    verdict: ``nothing-missing``, ``explained`` or ``unexplained``; before, after:
    errors by channel on the held-out recordings, with intervals at 95 %
    by bootstrap over blocks; revised: the declared parameters refitted, and effects.
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
        """Stages in which a structured remainder is left."""
        return [s for s in self.stages if not s.explained]
