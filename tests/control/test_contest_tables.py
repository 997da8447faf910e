"""Every controller of a contest meets the same plants, and what is reported is what was played."""

import json
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest

from design.contest import Contest, contest, contest_record, scores
from design.contest.plants import FORMS, RIGS, day_to_day, first, nominal, perturbed, rig, within_reach
from design.contest.play import METRICS, by_plant, play
from design.contest.scores import BESIDE, BOTH, Score
from design.contest.statistics import FEWEST, ConfidenceInterval
from design.controllers.pi import PI
from design.evaluation.tasks import FAMILIES, side_by_side
from design.mpc.formulations.linear import linear_mpc
from design.mpc.problem import MPCProblem
from design.robustness.box import box_of
from design.robustness.samples.conditions import Conditions
from plants import InputError, Wrist, built_in
from plants.effects.effect import Effect
from plants.files import json_text
from plants.rig import built_in_rig
from reports.comparison.contest.words import against, rig_sentences, sentences

SETS = {m: built_in(m) for m in ("flexion", "deviation")}
PIS = {"tuned": PI(3.1, 10.4), "again": PI(3.1, 10.4), "timid": PI(1.2, 2.2)}


@cache
def small() -> Contest:
    return contest(SETS, {m: PIS for m in SETS}, count=12, jobs=1)


def test_every_motion_field_and_family_has_every_controller_once():
    found = small()
    expected = {(m, f, t) for m in SETS for f in ("nominal plant", "perturbed plants") for t in FAMILIES}
    expected |= {(m, r, "steps") for m in SETS for r in RIGS} | {(BOTH, "coupled, 0.02 deg/kPa", "steps")}
    assert set(found.tables) == expected
    assert all([s.controller for s in found.of(*table)] == list(PIS) for table in expected)


def test_the_declared_plant_is_played_without_a_load_or_dead_time():
    plain, uncertainty = nominal(Wrist.flexion()), built_in_rig().uncertainty
    noisy = Conditions(0.0, 0.0, uncertainty.noise, uncertainty.resolution)
    assert small().conditions == noisy  # what is told of it
    asked = side_by_side(built_in_rig())
    for family in FAMILIES:
        here = [i for i, t in enumerate(asked) if t.family == family]
        played = play(plain, PIS, asked, noisy, seed=0)
        for s in small().of("flexion", "nominal plant", family):
            values = by_plant(played[s.controller], here)
            assert s.mean == {m: pytest.approx(float(values[m].mean()), rel=1e-12) for m in METRICS}


def test_the_coupled_plants_are_those_with_other_effects():
    """Every fifth of those drawn, the first among them."""
    coupled = small().of(*next(k for k in small().tables if k[0] == BOTH))
    others = [s for k in small().tables if k[1] in RIGS for s in small().of(*k)]
    assert {s.plants for s in (*coupled, *others)} == {3}


def test_steps_of_both_motions_at_once_count_every_pair_of_signs_once(monkeypatch):
    """Of each plant, the later settling and the errors of both added up."""
    asked = []

    def noted(field, plants, tasks, *others):
        assert {t.start for t in tasks} == {"virgin"}
        asked.append([(plant, t.references[0]) for plant, t in zip(plants, tasks, strict=True)])

    monkeypatch.setattr(scores, "lanes_for", noted)
    lane = np.arange(12.0)
    monkeypatch.setattr(scores, "both_motions", lambda *given: (lane**2, 100.0 - lane))
    monkeypatch.setattr(scores, "told", lambda value: dict.fromkeys(METRICS, value))
    fields = {m: perturbed(SETS[m], 12) for m in SETS}
    (found,) = scores.coupled_scores(fields, {m: {"x": PIS["tuned"]} for m in SETS}, None, "x", 0, 1)
    step = built_in_rig().task.step
    each = [(plant, a, b) for (plant, a), (same, b) in zip(*asked, strict=True) if plant == same]
    assert sorted(each) == sorted(product(range(3), (-step, step), (-step, step)))
    assert found.mean["iae_deg_s"] == pytest.approx(np.mean(lane**2 + 100.0 - lane))
    latest = np.maximum(lane**2, 100.0 - lane).reshape(3, 4).max(axis=1)
    assert found.mean["settling_time_s"] == pytest.approx(latest.mean())


def test_the_same_gains_under_two_names_differ_nowhere_and_share_their_ranks():
    for table in small().tables:
        tuned, again, timid = small().of(*table)
        assert again.mean == tuned.mean
        assert again.ranks == tuned.ranks
        assert {(i.low, i.high) for i in again.against.values()} <= {(0.0, 0.0), (-np.inf, np.inf)}
        assert timid.mean["iae_deg_s"] > tuned.mean["iae_deg_s"]


def test_timid_gains_are_behind_on_the_perturbed_plants_beyond_doubt():
    for motion in SETS:
        scores = small().of(motion, "perturbed plants", "steps")
        assert [s.ranks["iae_deg_s"] for s in scores] == [(1, 2), (1, 2), (3, 3)]
        assert scores[2].against["iae_deg_s"].low > 0.0
        said = against(scores, "tuned")
        assert said.index("no significant difference: again") < said.index("more IAE: timid (")


def test_a_single_plant_ranks_nobody():
    for s in small().of("flexion", "nominal plant", "steps"):
        assert s.ranks == {"iae_deg_s": (1, 3), "settling_time_s": (1, 3)}


def test_a_score_is_the_mean_over_plants_of_means_and_worst_values_over_tasks():
    drawn, asked = (
        perturbed(SETS["flexion"], 12),
        [t for t in side_by_side(built_in_rig()) if t.family == "steps"],
    )
    played = play(drawn, {"x": PIS["timid"]}, asked, Conditions(0.0, 0.0, 0.07, 0.01), seed=1)["x"]
    assert played["iae_deg_s"].shape == (drawn.count, 8)
    values = by_plant(played, [0, 3])
    assert values["iae_deg_s"] == pytest.approx(played["iae_deg_s"][:, [0, 3]].mean(axis=1))
    assert values["settling_time_s"] == pytest.approx(played["settling_time_s"][:, [0, 3]].max(axis=1))


def test_a_plant_is_the_same_however_many_are_drawn_and_lies_in_its_box():
    few, many = (perturbed(SETS["flexion"], n, seed=4).wrist for n in (10, 25))
    box = box_of(SETS["flexion"])
    for name in SETS["flexion"].values:
        values = np.broadcast_to(many.values[name], (25,))
        np.testing.assert_array_equal(values[:10], np.broadcast_to(few.values[name], (10,)))
        low, high = box.bounds(name)
        assert np.all((values >= low * (1 - 1e-12)) & (values <= high * (1 + 1e-12)))
    assert np.ptp(many.values["Tw"]) > 0.0


def test_a_fit_that_is_sure_of_one_day_is_not_taken_to_be_sure_of_another():
    plain = SETS["flexion"]
    values = {n: plain.values[n] for n in ("Tw", "w1", "a1")}
    fitted = plain.fitted(values, {"Tw": 1e-5, "w1": 1.0, "a1": 1e-5}, "rig")
    drawn = perturbed(fitted, 200).wrist.values
    for name, half in (("Tw", 0.2), ("a1", 0.1)):
        share = np.abs(drawn[name] / plain.values[name] - 1.0).max()
        assert 0.8 * half < share <= half * (1 + 1e-12)
    assert np.abs(drawn["w1"] / plain.values["w1"] - 1.0).max() > 0.25  # two standard errors are wider


def test_of_a_loop_whose_lines_would_cross_less_of_the_spread_is_drawn():
    plain = SETS["deviation"]
    narrow = {"a1": 0.26, "a2": 0.21, "w1": 3.1, "w2": 3.7}
    fitted = plain.fitted(narrow, dict.fromkeys(narrow, 1e-4), "rig")
    assert day_to_day(plain)[1] == 1.0
    box, share = day_to_day(fitted)
    assert 0.0 < share < 1.0
    drawn = perturbed(fitted, 100).wrist.hysteresis
    gap = (drawn.a2 - drawn.a1) * 97.6 + drawn.w1 + drawn.w2
    assert np.all(gap > 0.0)
    assert box.bounds("Tw")[1] / plain.values["Tw"] == pytest.approx(1.0 + 0.2 * share)


def test_a_rig_has_its_effect_at_a_trial_value_and_all_others_at_their_nulls():
    plain = nominal(Wrist.flexion())
    trials = {f"{e.NAME}.{n}": v for e in forms() for t in e.trials() for n, v in t.items()}
    for name, effect in RIGS.items():
        changed = rig(name, plain, 1).wrist.values
        for parameter, value in plain.wrist.values.items():
            expected = effect.get(parameter, value)
            assert float(np.ravel(changed[parameter])[0]) == float(np.ravel(expected)[0])
        assert set(effect) <= set(trials)


def forms() -> tuple[type[Effect], ...]:
    return FORMS


def test_plants_that_no_command_can_hold_are_set_aside_and_counted():
    drawn = perturbed(SETS["flexion"], 12)
    slopes = {n: drawn.wrist.values[n] * np.where(np.arange(12) < 5, 0.6, 1.0) for n in ("a1", "a2", "s")}
    kept = within_reach(drawn.__class__("weak", drawn.wrist.with_values(**slopes), 12))
    assert (kept.count, kept.set_aside) == (7, 5)
    assert first(kept, 3, "some").count == 3


@pytest.mark.slow
def test_an_MPC_meets_plants_beside_all_others():
    mpc = linear_mpc(MPCProblem(Wrist.flexion()))
    one = {"flexion": SETS["flexion"]}
    found = contest(one, {"flexion": PIS}, count=10, periodic={"flexion": {"MPC": mpc}}, periodic_count=2)
    names = {k: [s.controller for s in found.of(*k)] for k in found.tables}
    beside = {k for k, n in names.items() if n == [*PIS, "MPC"]}
    assert all(k in beside for k in names if k[1] == "nominal plant")
    assert {k[1] for k in beside} == {"nominal plant"} | {f"{n}{BESIDE}" for n in ("perturbed plants", *RIGS)}
    tuned, _, _, ours = found.of("flexion", f"perturbed plants{BESIDE}", "steps")
    assert (ours.plants, tuned.plants) == (2, 2)
    assert ours.mean["iae_deg_s"] < tuned.mean["iae_deg_s"]


def test_the_record_is_plain_json_with_a_row_for_every_score():
    record = json.loads(json_text(contest_record(small())))
    assert len(record["scores"]) == len(small().scores)
    one = next(s for s in record["scores"] if s["controller"] == "timid" and s["field"] == "perturbed plants")
    assert one["iae_deg_s_difference_low"] < one["iae_deg_s_difference"] < one["iae_deg_s_difference_high"]
    assert set(METRICS) <= set(one)
    nobody = next(s for s in record["scores"] if s["field"] == "nominal plant" and s["controller"] == "timid")
    assert nobody["iae_deg_s_difference_low"] is None


def test_the_sentences_name_each_motion_that_enough_plants_tell_of():
    of_steps = [s.split(",")[0] for s in sentences(small()) if ", steps: " in s]
    assert of_steps == ["flexion", "deviation"]
    assert small().of(*next(k for k in small().tables if k[0] == BOTH))[0].plants < FEWEST


def test_a_rig_takes_a_lead_away_only_where_enough_plants_say_so():
    def score(field, plants, low, high):
        against = {
            m: ConfidenceInterval(0.5 * (low + high), low, high) for m in ("iae_deg_s", "settling_time_s")
        }
        return Score("flexion", field, "steps", "quick", plants, {}, 1.0, against, {})

    def said(plants, low, high):
        rigs = [score(name, plants, low, high) for name in RIGS]
        return rig_sentences(replace(small(), scores=(score("perturbed plants", 50, -2.0, -1.0), *rigs)))

    assert said(10, -2.0, -1.0) == []
    assert said(9, -np.inf, np.inf) == []
    (one,) = said(10, -1.0, 0.1)
    assert one == f"flexion, {' and '.join(RIGS)}: no longer less IAE than the recommended PI: quick."


def test_too_few_plants_are_refused():
    with pytest.raises(InputError, match="9 plants are too few"):
        perturbed(SETS["flexion"], 9)
