"""A rig fitted from its log, without effects: its start, its hysteresis law, and the fit."""

from collections.abc import Callable
from dataclasses import dataclass

from plants.measured.campaigns.campaign import Campaign
from plants.measured.fitting.fit import Fit, fit_campaign
from plants.measured.trace.declared import stages_of
from plants.measured.trace.law import LawChoice, law_of_rig
from plants.measured.trace.stages.between_rows import with_commands
from plants.measured.trace.stages.model import Model
from plants.measured.trace.start import FROM_GUESS, Start, starting
from plants.parameters.quantities import ParameterSet

STARTS = 6
"""Starting points of each stage of a fit, the first that of the set that was given."""


@dataclass(frozen=True)
class RigFit:
    """A fit of a rig from its log: the start, the fit of the declared law, how the law was chosen (None where
    it was given), and the fit of the law that was chosen."""

    start: Start
    declared: Fit
    law: LawChoice | None
    fit: Fit

    @property
    def model(self) -> Model:
        """The first stage of the fit, as a trace begins with it."""
        stage = stages_of(self.start.campaign, self.fit)[0]
        fixed = tuple(n for n in self.fit.undetermined if n in stage.declared)
        return Model(stage, self.fit.fitted, self.fit.fitted.values, fixed=fixed)


def fit_rig(
    campaign: Campaign,
    given: ParameterSet | None = None,
    starts: int | None = None,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> RigFit:
    """Fit a rig from its log: from the set `given`, the built-in one of a motion of that name, or a guess,
    and then with the hysteresis law that does best on rows left out.  starts: starting points of each stage;
    where not given `STARTS` from a set that somebody made, one from a guess, which is near already.  Where
    the command did something else between rows than is taken for granted it is fitted again with that.

    Raises InputError as `plants.measured.fitting.fit.fit_campaign` does.
    """
    found = _fitted(starting(campaign, given), starts, seed, progress)
    timed = with_commands(found.start, found.model)
    return found if timed is None else _fitted(timed, starts, seed, progress)


def _fitted(
    begun: Start, starts: int | None, seed: int, progress: Callable[[str, float], None] | None
) -> RigFit:
    fit = fit_campaign(
        begun.campaign, begun.parameters, starts or (FROM_GUESS if begun.guessed else STARTS), seed, progress,
        apart=not begun.guessed,
    )  # fmt: skip
    law = law_of_rig(begun, fit, seed)
    if law is None or law.name == fit.fitted.law.NAME:
        return RigFit(begun, fit, law, fit)
    return RigFit(begun, fit, law, fit_campaign(begun.campaign, law.parameters, 1, seed, progress))
