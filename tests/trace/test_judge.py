"""Which effects pass for another: by chance, or by little against what neither of them explains."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plants.measured.trace.judge import alternatives
from plants.measured.trace.traced_stage import helps

ROWS, BLOCKS = 4000, 20


def candidate(effects: tuple[str, ...], chi2: float, seed: int = 1) -> Any:
    """A model of a stage that leaves white noise of a chi-square; of one seed, the same noise scaled."""
    residual = np.random.default_rng(seed).standard_normal(ROWS)
    residual *= np.sqrt(chi2 / np.mean(residual**2))
    stage = SimpleNamespace(left_out_blocks=np.arange(ROWS) * BLOCKS // ROWS)
    return SimpleNamespace(model=SimpleNamespace(effects=effects, stage=stage, residual=residual, chi2=chi2))


def found(chosen: Any, *others: Any) -> dict[str, list[tuple[str, ...]]]:
    search: Any = SimpleNamespace(chosen=chosen, rounds=[SimpleNamespace(candidates=others)])
    return {name: [c.model.effects for c in beside] for name, beside in alternatives(search).items()}


@pytest.mark.parametrize(("rise", "tied"), [(0.02, True), (0.03, True), (0.06, False)])
def test_what_neither_explains_is_no_evidence_for_one_of_them(rise, tied):
    of_both = found(
        candidate(("dead-time", "gyro-drift"), 1.4), candidate(("dead-time", "creep"), 1.4 + rise)
    )
    assert of_both == {"dead-time": [], "gyro-drift": [("dead-time", "creep")] if tied else []}


def test_at_the_noise_the_scatter_decides():
    assert found(candidate(("creep",), 1.0), candidate(("drift",), 1.01)) == {"creep": []}
    assert found(candidate(("creep",), 1.0), candidate(("drift",), 1.01, seed=2)) == {"creep": [("drift",)]}


def test_one_that_leaves_much_more_is_none_however_the_errors_scatter():
    other = candidate(("drift",), 1.3)
    other.model.residual[:200] *= 3.0  # in one block only, so that the scatter is large
    assert found(candidate(("creep",), 1.2), other) == {"creep": []}


def test_another_number_of_effects_is_no_alternative():
    assert found(candidate(("creep",), 1.0), candidate(("drift", "leak"), 1.0)) == {"creep": []}


@pytest.mark.parametrize(("left", "kept"), [(5.4, True), (5.6, False)])
def test_effects_that_leave_half_of_a_stage_are_kept_and_others_are_not(left, kept):
    """Each has shown on rows left out that it serves; of a declared 10 nine are above the noise."""
    search: Any = SimpleNamespace(
        chosen=SimpleNamespace(model=SimpleNamespace(chi2=left)),
        declared=SimpleNamespace(
            model=SimpleNamespace(chi2=10.0, stage=SimpleNamespace(channel="angle_deg", noise=0.1))
        ),
    )
    fit: Any = SimpleNamespace(fit_rmse={"angle_deg": 0.3})
    assert helps(search, fit) == kept
    under_the_law: Any = SimpleNamespace(fit_rmse={"angle_deg": 0.4})  # 16 under the law that was declared
    assert helps(search, under_the_law)
