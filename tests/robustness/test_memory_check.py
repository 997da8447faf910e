"""The check of functions with memory decides in fractions, and refuses what was tampered with."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.memory import programme
from design.robustness.certificates.memory.check import confirm_common, confirm_line
from design.robustness.certificates.memory.loop import FixedLawLoop, growth_of
from design.robustness.certificates.reasons import NoneOfThisKind, NotConfirmed
from design.robustness.loop_model import LoopModel
from plants import Wrist

LOOP = LoopModel.of(Wrist.flexion(), PI(2.0, 4.0))
SLOPE = (0.36,)


def flipped(matrix: Any) -> Any:
    found = matrix.copy()
    found[0, 2] = found[2, 0] = -found[0, 2]
    return found


@pytest.mark.parametrize("samples", [0, 50])
def test_a_function_with_memory_that_was_tampered_with_is_refused(samples: int) -> None:
    loop = FixedLawLoop.of(LOOP, samples)
    form = programme.line(loop, SLOPE, 0.15).form
    assert form is not None
    assert confirm_line(form, loop).holds
    line, transit = form.line, form.transit
    broken = [
        replace(form, line=replace(line, P=flipped(line.P))),
        replace(form, line=replace(line, P=line.P * np.nan)),
        replace(form, line=replace(line, popov=-line.popov)),
        replace(form, line=replace(line, popov=100.0 * line.popov)),
        replace(form, transit=replace(transit, P=-transit.P)),
        replace(form, transit=replace(transit, P=2.0 * line.P)),  # not below the other
        replace(form, transit=replace(transit, popov=2.0 * line.popov + 1.0)),
        replace(form, cross=-form.cross),
        replace(form, cross=form.cross[:-1]),
        replace(form, cross=form.cross * np.nan),
        replace(form, gap=-form.gap),
        replace(form, multipliers=(0.0, 0.0, 0.0)),
        replace(form, multipliers=(-1.0, *form.multipliers[1:])),
        replace(form, decay=0.5),
        replace(form, decay=float("nan")),
        replace(form, inner=(0.2,)),
        replace(form, outer=(0.5,)),
    ]
    if samples:
        broken += [
            replace(form, line=replace(line, S=0.0)),
            replace(form, line=replace(line, R=-line.R)),
            replace(form, transit=replace(transit, S=2.0 * line.S + 1.0)),
        ]
    for other in broken:
        assert not confirm_line(other, loop).holds
    assert not confirm_line(form, FixedLawLoop.of(LOOP, 50 - samples)).holds  # another number of moments


@pytest.mark.parametrize("samples", [0, 50])
def test_a_common_function_that_was_tampered_with_is_refused(samples: int) -> None:
    loop = FixedLawLoop.of(LOOP, samples)
    form = programme.common(loop, 0.05).form
    assert form is not None
    assert confirm_common(form, loop).holds
    broken = [
        replace(form, form=replace(form.form, P=flipped(form.form.P))),
        replace(form, form=replace(form.form, popov=-1.0)),
        replace(form, multipliers=form.multipliers[:1]),
        replace(form, multipliers=()),
        replace(form, slopes=(0.1, 0.36)),
        replace(form, decay=0.3),
    ]
    for other in broken:
        assert not confirm_common(other, loop).holds


def test_the_check_sees_a_loop_that_the_function_was_not_made_for() -> None:
    form = programme.line(FixedLawLoop.of(LOOP, 50), SLOPE, 0.15).form
    assert form is not None
    for other in (
        replace(LOOP, Ki=50.0),
        replace(LOOP, k_fast=90.0),
        replace(LOOP, Tw=1.0),
        replace(LOOP, dt=0.01),
    ):
        assert not confirm_line(form, FixedLawLoop.of(other, 50)).holds
    assert not confirm_line(form, FixedLawLoop.of(LOOP, 80)).holds


def test_a_solver_that_lies_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    def lies(self: Any) -> Any:
        return np.random.default_rng(3).normal(size=self.unknowns.count), 1.0, "LIAR"

    monkeypatch.setattr(programme.Program, "solve", lies)
    loop = FixedLawLoop.of(LOOP, 50)
    for found in (programme.line(loop, SLOPE, 0.1), programme.common(loop, 0.01)):
        assert found.form is None
        assert isinstance(found.reason, NotConfirmed)


def test_slopes_at_will_have_no_function_where_memory_has_one() -> None:
    """At (3.13, 10.4) Popov's kind ends; the memory is what rules the bad orders of switching out."""
    loop = FixedLawLoop.of(LoopModel.of(Wrist.flexion(), PI(3.13, 10.4)), 50)
    assert isinstance(programme.common(loop, 1e-3).reason, NoneOfThisKind)
    assert programme.line(loop, SLOPE, 0.2).form is not None


def test_the_growth_of_a_sample_is_at_least_that_of_the_rate() -> None:
    for decay in (0.0, 0.1, 0.3, 7.0):
        assert float(growth_of(decay, 0.001)) >= np.exp(decay * 0.001)
        assert float(growth_of(decay, 0.001)) <= np.exp(decay * 0.001) + 1e-12
