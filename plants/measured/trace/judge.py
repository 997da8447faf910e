"""What a search for effects amounts to: which names could as well be others, what the data cannot
tell, and whether all is explained."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from plants.measured.trace.ranking.screening import Ranked
from plants.measured.trace.search.candidate import Candidate, tied
from plants.measured.trace.search.rounds import EffectSearch
from plants.measured.trace.stages.model import Model

Array = NDArray[np.float64]
NOTHING = 1.1
"""Nothing is made of a chi-square per row below this: an error of 1.05 times the noise."""

REACHED = ((1.5, 0.05), (2.0, 0.005))
"""A stage is explained up to a chi-square per row, an error of 1.22 and 1.41 times the noise, if no more
than a share is left, on rows left out of the fit, of what it had above 1: a cause in a form that is not
quite the rig's leaves a small share of a large effect, a wrong cause a large one."""

CAUSES = 2
"""Effects of each part of the rig in a stage of which forms that are not quite the rig's are excused: with
three and their parameters nearly any loop is followed nearly."""

WANDER, WANDERING = 5.0, 3.0
"""A sensor may wander, which no model foresees: where an effect says so, chi-square may be up to
the second figure if it is explained once a moving mean over the first [s] is taken out."""
CALM = 1.25
"""What chi-square must come down to without the wander."""

MOVES = 5.0
"""A channel that an effect needs moves if it moves by more than this, in its own unit."""

SEEN = 0.02
"""An effect whose response, at any strength tried, adds less than this to the mean square of the
residual in units of the noise is not excited by the data."""


def explained(search: EffectSearch) -> bool:
    """Whether the model that was chosen reaches the noise."""
    model = search.chosen.model
    if model.chi2 <= NOTHING:
        return True
    if not many(model) and any(model.chi2 <= most for most, _ in REACHED):
        left = (search.chosen.held_out - 1.0) / max(search.declared.held_out - 1.0, 1e-9)
        if any(model.chi2 <= most and left <= share for most, share in REACHED):
            return True
    if not any(f.WANDERS for f in model.forms) or model.chi2 > WANDERING:
        return False
    return _without_wander(model) <= CALM


def many(model: Model) -> bool:
    """Whether a stage has so many effects that together they follow nearly anything nearly."""
    return len(model.forms) > CAUSES * model.stage.parts


def _without_wander(model: Model) -> float:
    from scipy.ndimage import uniform_filter1d

    total, stage = 0.0, model.stage
    for playback, a, b in zip(stage.playbacks, stage.edges[:-1], stage.edges[1:], strict=True):
        rows = max(3, round(WANDER / float(np.median(np.diff(playback.recording.time)))))
        r = model.residual[a:b]
        total += float(np.sum((r - uniform_filter1d(r, rows, mode="nearest")) ** 2))
    return total / model.residual.size


def alternatives(search: EffectSearch) -> dict[str, tuple[Candidate, ...]]:
    """For each effect that was chosen, models with another in its place that this data does not tell
    from it: the errors on blocks of time do not differ by more than their scatter, or by little against
    what neither explains."""
    chosen = search.chosen
    found: dict[str, tuple[Candidate, ...]] = {}
    names = set(chosen.model.effects)
    for name in chosen.model.effects:
        beside = []
        for round_ in search.rounds:
            for c in round_.candidates:
                others = set(c.model.effects)
                if len(others) == len(names) and names - others == {name} and tied(chosen.model, c.model):
                    beside.append(c)
        found[name] = tuple(beside)
    return found


def unexcited(model: Model, ranking: Sequence[Ranked]) -> Mapping[str, str]:
    """Effects that the recordings do not excite, with the reason; by name."""
    found = {}
    for name in model.stage.effects:
        lacking = not_logged(model, name)
        if lacking:
            found[name] = f"{' and '.join(lacking)} was not logged, or never moved"
            continue
        if max((r.power for r in ranking if r.name == name), default=0.0) < SEEN:
            found[name] = (
                f"at every strength tried it would change the {_what(model)} by less than "
                f"{SEEN**0.5:.2g} of the noise beyond what other parameters absorb"
            )
    return found


def not_logged(model: Model, name: str) -> list[str]:
    """What an effect needs of a log and this one lacks, or shows at rest; in words."""
    from plants.effects import EFFECTS

    needed = {column: words for form in EFFECTS[name] for column, words in form.LOG.items()}
    runs = [p.recording.channels for p in model.stage.playbacks]
    return [
        words
        for column, words in needed.items()
        if not any(column in run and float(np.ptp(run[column])) > MOVES for run in runs)
    ]


def _what(model: Model) -> str:
    return model.stage.channel.split("_")[0]
