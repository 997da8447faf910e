"""A model that was fitted, and what it leaves of rows that did not fit it: blocks, and whole recordings."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.measured.fitting.blocks import lower
from plants.measured.residual.examine import Examination, examine
from plants.measured.trace.search.likelihood import log_likelihood
from plants.measured.trace.stages.model import Model
from plants.measured.trace.stages.remainders import remainders

Array = NDArray[np.float64]
WORTH = 0.05
"""Least fall of chi-square per row that an effect must bring.  With tens of thousands of rows far
smaller ones are beyond doubt, but they are imperfections of a form as often as effects."""

FOLDS = 4
"""Parts that the blocks are dealt to in turn, each left out of one fit: with two, a fit to the other half
need not have met the ranges that it is judged on."""

PARTIAL_FIT = (8, 1e-4)
"""Evaluations and tolerance of fits to parts of the rows: they begin at the fit to all of them."""

BEYOND = 0.1
"""Share of the range of the others that a recording may reach beyond them and still be simulated by a fit to
them: further out it would be extrapolated, where a model has been told nothing."""

ALIKE = 0.1
"""Share of what the chosen model leaves above the noise by which another may leave more and still be the
cause: neither explains that, so that it is no evidence for the one that happens to follow it a little."""

CARRIES = 0.9
"""Share of the error on recordings left out whole that another model may have to be clearly better there."""


@dataclass(frozen=True)
class LeftOut:
    """Residuals (rows,) over the noise, each of a fit to the other parts of the data: under the pressure that
    drives the stage, and in a free run from the command."""

    driven: Array
    free: Array


@dataclass(frozen=True)
class Candidate:
    """A model that was fitted."""

    model: Model

    @cached_property
    def left_out(self) -> LeftOut:
        """What it leaves of rows that did not fit it."""
        return left_out(self.model)

    @property
    def held_out(self) -> float:
        """Its chi-square per row on blocks that did not fit it."""
        return float(np.mean(self.left_out.driven**2))

    @cached_property
    def over_recordings(self) -> float | None:
        """Its error over the noise in a free run, of each recording by a fit to the others; see
        `over_recordings`."""
        return over_recordings(self.model)

    @cached_property
    def examined(self) -> Examination:
        """What its residual shows."""
        return examine(remainders(self.model))

    @cached_property
    def log_likelihood(self) -> float:
        """Of what it leaves, as noise of a colour of its own."""
        return log_likelihood(self.model)

    @property
    def lacks_something(self) -> bool:
        """Whether its residual is large enough to look further: beyond the noise, and beyond what the form of
        a law may leave that was chosen from the log."""
        stage = self.model.stage
        return self.model.chi2 > 1.0 + max(WORTH, (stage.form / stage.noise) ** 2)


def left_out(model: Model) -> LeftOut:
    """Residuals on the blocks of the stage, each of a fit to the rows of the other folds."""
    fold = model.stage.left_out_blocks % FOLDS
    driven, free = np.empty(fold.size), np.empty(fold.size)
    for k in range(FOLDS):
        apart = fold == k
        fitted = model.fitted(*PARTIAL_FIT, ~apart)
        driven[apart] = fitted.residual[apart]
        free[apart] = fitted.freely.residual[apart]
    return LeftOut(driven, free)


def over_recordings(model: Model) -> float | None:
    """Root mean square over the noise of a free run from the command, of each recording by a fit to the
    others to the end, where it stays in their range; None where none does, as where there is one only.

    Blocks are left out of recordings whose other blocks fit the model, so that what belongs to a recording
    alone, such as a load at some moment of it, is taken for a cause.
    """
    edges, found = model.stage.edges, []
    for first, last in pairwise(edges):
        others = np.ones(edges[-1], bool)
        others[first:last] = False
        if others.any() and _within(model.stage.target[first:last], model.stage.target[others]):
            found.append(float(np.mean(model.fitted(rows=others).freely.residual[first:last] ** 2)))
    return float(np.sqrt(np.mean(found))) if found else None


def _within(own: Array, others: Array) -> bool:
    """Whether a channel of a recording stays within the range of the others, or `BEYOND` beyond it."""
    low, high = float(others.min()), float(others.max())
    reach = BEYOND * (high - low)
    return bool(own.min() > low - reach and own.max() < high + reach)


def carries_over(before: Candidate, after: Candidate) -> bool:
    """Whether recordings that did not fit it are simulated clearly better by a model than by another; False
    where none can be simulated by a fit to the others."""
    now, then = after.over_recordings, before.over_recordings
    return now is not None and then is not None and now < CARRIES * then


def tied(best: Model, other: Model) -> bool:
    """Whether two models differ by no more than two standard errors over blocks, nor by much; or by no more
    than `ALIKE` of what the better one leaves."""
    rise = other.chi2 - best.chi2
    blocks = best.stage.left_out_blocks
    difference = np.bincount(blocks, other.residual**2 - best.residual**2)
    scatter = float(np.std(difference, ddof=1)) * np.sqrt(len(difference))
    by_chance = float(difference.sum()) < 2.0 * scatter and rise < 0.1
    return by_chance or rise < ALIKE * (best.chi2 - 1.0)


def falls(before: Candidate, after: Candidate) -> bool:
    """Whether the error of a free run from the command falls on rows left out, for certain (`lower`)."""
    return lower(before.left_out.free, after.left_out.free, before.model.stage.left_out_blocks)
