"""A study says of each motion what was asked, why no gains hold every limit, and what could not be drawn."""

from dataclasses import replace

import pytest

from design import Question, Study
from design.studies import study as module
from design.studies.paper import SERIES, redrawn
from design.synthesis.answer import LimitBroken, answer, refusal
from plants import InputError, Wrist, built_in
from plants.effects import DeadTime
from tests.reports.report_samples import small_study

FLEXION = built_in("flexion")
LATE = FLEXION.revised([DeadTime], {"dead-time.delay": 0.05}, {}, "a step")


@pytest.mark.slow
def test_it_has_the_motions_that_were_asked_for_in_their_order():
    study = small_study()
    assert study.motions == list(study.plants) == ["flexion", "deviation"]
    assert Question({"left": FLEXION}).wrists == {"left": Wrist.of(FLEXION)}


@pytest.mark.slow
def test_refusals_are_those_of_the_answers():
    study = small_study()
    no = LimitBroken((0.1, 20.0), (0.1, 50.0), 1.0, 2.0, "Ms", 3.0, 2.0, "line1, fast rate")
    refused = replace(study, answers={"flexion": replace(study.answers["flexion"], refusal=no)})
    assert refused.refusals == {"flexion": no}
    assert refused.verdicts["flexion"] is no
    assert refused.verdicts["deviation"] == study.verdicts["deviation"]


@pytest.mark.slow
def test_an_answer_is_of_the_gains_and_of_the_nominal_step():
    tuning = small_study().tunings["flexion"]
    found = answer(tuning)
    assert found.tuning is tuning
    assert found.refusal == refusal(tuning)
    assert all(found.nominal[n] <= found.everywhere[n] for n in found.nominal)
    assert found.everywhere["iae_deg_s"] == pytest.approx(float(tuning.at.cost[0]))


@pytest.mark.slow
@pytest.mark.parametrize(("samples", "said"), [(10, ["flexion"]), (0, [])])
def test_motions_whose_plants_cannot_be_perturbed_are_named_where_that_was_asked_for(samples, said):
    study = small_study()
    asked = Question({"flexion": LATE, "deviation": built_in("deviation")}, samples=samples)
    assert replace(study, question=asked).unperturbed == said


def test_without_the_solver_of_the_MPCs_they_are_left_out_and_the_reason_is_kept(monkeypatch):
    def lacking(wrist: Wrist) -> dict[str, object]:
        raise InputError("daqp is not installed")

    monkeypatch.setattr(module, "design_mpcs", lacking)
    assert module._mpcs({"flexion": Wrist.flexion()}) == ({}, "daqp is not installed")


@pytest.mark.slow
def test_the_papers_figures_are_redrawn_of_its_two_motions_and_of_nothing_less():
    assert redrawn({"flexion": Wrist.flexion()}) == {}
    assert redrawn({"bending": Wrist.flexion(), "deviation": Wrist.deviation()}) == {}
    assert list(small_study().redrawn) == list(SERIES)


@pytest.mark.slow
def test_a_study_is_a_value():
    study = small_study()
    assert isinstance(study, Study)
    with pytest.raises(AttributeError):
        study.contest = None
