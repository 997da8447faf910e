"""The page of a design says its answer in three sentences of at most twenty words, whatever the answer."""

import itertools
from dataclasses import replace

import pytest

from design.alternatives.designs import LQI_NAME, ROBUST_MPC
from design.robustness.certificates.memory.ladder import IN_BOX
from design.studies.design_study import DesignStudy, MotionDesign
from design.studies.designs import CASCADE, FORWARD, DesignEffort
from plants.effects.wrist.cross_coupling import Coupling
from plants.effects.wrist.remainder import STEEPNESS
from plants.effects.wrist.stick_slip import FreeSlip
from plants.parameters.files import built_in, dump, load
from plants.rig import Zero
from reports.design import tables
from reports.design.alternative_words import cascade_words, feedforward_words, lqi_words, mpc_words
from reports.design.words import (
    controller_words,
    controllers,
    last_line,
    motion_lines,
    price_caption,
    remarks,
    summary,
    title,
    worse_words,
)

GAINS = {"Kp": 2.89, "Ki": 7.39, "b": 1.0, "Tf": 0.0}


def motion(name, broken, proved):
    guard = {"overshoot_percent": 0.1}
    design = {"gains": GAINS, "holds": not broken, "cost": 10.0, "guard": guard}
    row = {
        "guarantee": "proved", "controller": "PI", "sensors": ["angle"], "gains": None,
        "worst_iae_deg_s": None,
        "worst_settling_s": None, "worst_overshoot_percent": None, "ratio_to_bound": None,
    }  # fmt: skip
    evidence = {
        "samples": {"broken": broken, "total": 20_000}, "worst_case": {"broken": broken, "runs": 50_688},
        "proved": {"status": proved, "rate_1_s": None},
    }  # fmt: skip
    return MotionDesign(
        name, built_in(name), (), {}, {"PI": design, "2-DOF PI": design}, "PI", evidence, (row,), (), {},
        "the dead time" if broken else None,
    )  # fmt: skip


CASES = list(itertools.product((0, 7), ("open", "proved"), (1, 2)))


def study(broken, proved, count):
    names = ("flexion", "deviation")[:count]
    limits = {"overshoot_percent": 5.0}
    about = {n: {"longest_dead_time_s": 0.05, "limits": limits, "remainder": None} for n in names}
    return DesignStudy(
        tuple(motion(n, broken, proved) for n in names), about, {"overshoot_percent": 0.1}, DesignEffort()
    )


@pytest.mark.parametrize(("broken", "proved", "count"), CASES)
def test_three_sentences_of_at_most_twenty_words(broken, proved, count):
    said = summary(study(broken, proved, count))
    assert len(said) == 3
    for sentence in said:
        assert len(sentence.split()) <= 20, sentence
        assert sentence.endswith(".")


def test_what_does_not_hold_is_said_first_and_which_guarantee_would_have_to_go():
    bad = study(7, "open", 2)
    assert title(bad).startswith("No gains meet every limit")
    assert controllers(bad).startswith("Nearest")
    assert controllers(study(0, "open", 2)).startswith("Recommended")
    assert "without the dead time" in last_line(bad)
    good = study(0, "open", 2)
    assert "meet every limit with up to 50 ms" in last_line(good)
    assert "a proof of stability is open for flexion and deviation" in last_line(good)
    assert "proved on the plant as fitted" in last_line(study(0, "proved", 1))


def test_the_limits_that_gains_break_are_those_of_any_condition_and_of_the_search():
    held = [("Ms", {"nominal": True, "longest dead time": None}), ("Mt", {"nominal": True, "late": False})]
    matrix = tuple({"limit": n, "bound": 1.0, "values": {}, "held": of} for n, of in held)
    (bad,) = study(7, "open", 1).motions
    worst = {**bad.evidence["worst_case"], "excess_of": "settling_time_s"}
    bad = replace(bad, matrix=matrix, evidence={**bad.evidence, "worst_case": worst})
    assert bad.limits_broken == ("Mt", "settling_time_s")
    (good,) = study(0, "open", 1).motions
    assert replace(good, matrix=matrix).limits_broken == ()


def test_a_guessed_rig_is_told_where_its_task_and_its_limits_are_set(tmp_path):
    (m,) = study(0, "open", 1).motions
    samples = {**m.evidence["samples"], "upper_bound": 1e-4, "worst_iae_deg_s": 8.0, "worst_settling_s": 1.0}
    worst = {**m.evidence["worst_case"], "excess": -0.1, "excess_of": "Ms", "scenario": "0, +15 deg"}
    evidence = {**m.evidence, "samples": samples, "worst_case": {**worst, "worst_iae_deg_s": 8.0}}
    trace = {"after": {"angle_deg": 0.1}, "effects": [], "verdict": "nothing-missing"}
    rig = replace(m.plant.rig, name="finger", motions=("finger",))
    plant = replace(m.plant, axis="finger", rig=rig)
    m = replace(m, motion="finger", plant=plant, trace=trace, evidence=evidence)
    assert not [line for line in motion_lines(m) if "guessed" in line]
    (told,) = (line for line in motion_lines(replace(m, guessed=True)) if "guessed" in line)
    assert "(steps of 15 deg, settling within 10 s)" in told
    assert "[rig.task] and [rig.limits] of a copy of plant-finger.toml, and give that with --plant" in told
    # What it says to do is read as it is meant.
    path = tmp_path / "plant-finger.toml"
    dump(plant, path)
    text = path.read_text().replace("step = 15.0", "step = 8.0")
    path.write_text(text.replace("settling_time_s = 10.0", "settling_time_s = 3.0"))
    read = load(path).rig
    assert (read.task.step, read.limits["settling_time_s"]) == (8.0, 3.0)


def test_a_row_without_gains_is_open():
    (group,) = tables.price_table(study(0, "open", 1)).groups
    assert [c.text for c in group.rows[0]][-1] == "open"


@pytest.mark.parametrize(("broken", "gains"), [(0, "recommended"), (3, "nearest")])
def test_the_price_of_the_whole_requirement_is_told_in_per_cent(broken, gains):
    plain = study(broken, "open", 1)
    (m,) = plain.motions

    def priced(worst, feasible=True):
        row = {**m.prices[0], "controller": "PI", "feasible": True}
        rows = [{**row, "guarantee": "memory and corners", "worst_iae_deg_s": 8.0}]
        last = {"guarantee": "worst case found", "worst_iae_deg_s": worst, "feasible": feasible}
        rows.append({**row, **last})
        return price_caption(replace(plain, motions=(replace(m, prices=tuple(rows)),)))

    assert priced(10.0).startswith(f"The {gains} gains err 25 % more on flexion than gains tuned for")
    assert "err 50 % less on flexion" in priced(4.0)
    assert priced(None).startswith("Worst IAE over the same steps")
    assert "Blue: tuned for the whole requirement" in priced(10.0)
    assert "Blue" not in priced(10.0, feasible=False)


def test_a_residual_is_told_with_what_is_proved_of_the_slopes_that_it_changes():
    plain = study(0, "proved", 1)
    (m,) = plain.motions
    left = {**plain.requirements["flexion"], "remainder": {"peak": 0.6, "length": 5.0}}

    def told(rate):
        rung = {"rung": f"discrete-time {IN_BOX}", "dead_time_s": 0.05, "rate_1_s": rate}
        proved = {**m.evidence["proved"], "dead_time_s": 0.05, "rungs": [{**rung, "dead_time_s": 0.0}, rung]}
        one = replace(m, evidence={**m.evidence, "proved": proved})
        return remarks(replace(plain, motions=(one,), requirements={"flexion": left}))

    (said,) = (w for w in told(0.123) if "residual" in w)
    assert "up to 0.6 deg along 5 deg" in said
    assert f"up to {100 * STEEPNESS * 0.6 / 5.0:.0f} %" in said
    assert "rate at least 0.12 1/s" in said
    assert any("a proof of stability is open" in w for w in told(None))
    assert "unmodelled dynamics" not in said
    weight = {"low": 0.1, "high": 0.9, "corner_Hz": 1.0, "known_Hz": 1.0}
    left["remainder"] = {**left["remainder"], "weight": weight}
    (said,) = (w for w in told(0.123) if "residual" in w)
    # (0.1^2 + 0.9^2) / 2 is the square of the gain at the corner.
    assert "unmodelled dynamics of at most 10 % at low frequencies and 64 % at 1 Hz" in said


def test_an_mpc_is_told_with_what_was_searched():
    (m,) = study(0, "open", 1).motions
    of = {"gains": {"swing": 80.0, "move": 500.0, "delay": 2.0}, "cost": 5.0, "holds": True, "samples": 256}
    of["search_runs"] = 2000
    of["margins"] = {"Ms": 1.9, "Mt": 1.3, "delay_margin_s": 0.08}
    said = mpc_words(replace(m, designs={**m.designs, ROBUST_MPC: of}))
    assert "Ms = 1.9 at most" in said
    assert "at least 80 ms" in said
    assert "worst IAE of its tuning is 50 % lower" in said
    assert said.endswith("found in about 2000 runs of a search and in 256 fresh samples.")


def test_a_feedforward_that_holds_is_told_with_what_it_would_save():
    with_one = motion("flexion", 0, "proved")
    gains = {"Kp": 2.88, "Ki": 7.39, "speed": 3.0, "dead_time": 0.025}
    held = {**with_one.designs, FORWARD: {"gains": gains, "holds": True, "cost": 7.5}}
    words = feedforward_words(replace(with_one, designs=held))
    assert "filter 3 1/s" in words
    assert "25 ms" in words
    assert "by 25 %" in words
    assert "not recommended" not in words
    assert feedforward_words(with_one) == ""


def test_a_feedforward_whose_worst_case_breaks_a_limit_is_told_with_the_case():
    with_one = motion("flexion", 0, "proved")
    gains = {"Kp": 2.88, "Ki": 7.39, "speed": 3.0, "dead_time": 0.025}
    worst = {"worst_excess": 6.7, "worst_excess_of": "overshoot_percent", "worst_case": "0, +15, +10, +5 deg"}
    broken = {"gains": gains, "holds": False, "cost": 7.5, **worst}
    words = feedforward_words(replace(with_one, designs={**with_one.designs, FORWARD: broken}))
    assert "not recommended" in words
    assert "670 %" in words
    assert "0, +15, +10, +5 deg" in words
    untold = {n: v for n, v in broken.items() if not n.startswith("worst")}  # broke a case of its tuning
    assert feedforward_words(replace(with_one, designs={**with_one.designs, FORWARD: untold})) == ""


def test_a_cascade_is_told_with_what_it_measures_and_gains():
    with_one = motion("flexion", 0, "proved")
    gains = {"Kp": 2.61, "Ki": 8.83, "b": 0.8, "Kc": 1.0}
    one = {"gains": gains, "holds": True, "cost": 9.0}
    words = cascade_words(replace(with_one, designs={**with_one.designs, CASCADE: one}))
    for told in ("Kc = 1", "measured pressure", "10 % lower", "no broken limit was found"):
        assert told in words
    assert cascade_words(with_one) == ""


def test_an_lqi_is_told_with_the_limit_that_it_breaks_or_that_none_was_found():
    with_one = motion("flexion", 0, "proved")
    gains = {"Ke": 600.0, "Kd": -640.0, "Kq": -70.0, "jump": 8.0, "bandwidth": 45.0}
    broken = {"worst_excess": 0.14, "worst_excess_of": "overshoot_percent"}
    one = {"gains": gains, "holds": False, "cost": 9.0, **broken}
    words = lqi_words(replace(with_one, designs={**with_one.designs, LQI_NAME: one}))
    assert "breaks the limit on overshoot by 14 %" in words
    assert "10 % lower" in words
    # A stage that was read from its file has null for an Ms without bound.
    unstable = {**one, "worst_excess": None, "worst_excess_of": "Ms"}
    words = lqi_words(replace(with_one, designs={**with_one.designs, LQI_NAME: unstable}))
    assert "breaks the limit on Ms by ∞ %" in words
    near = {**one, "worst_excess": -0.02}
    words = lqi_words(replace(with_one, designs={**with_one.designs, LQI_NAME: near}))
    assert "breaks" not in words
    held = {**one, "holds": True, "cost": 12.0}
    words = lqi_words(replace(with_one, designs={**with_one.designs, LQI_NAME: held}))
    assert "no broken limit was found" in words
    assert "20 % higher" in words
    assert lqi_words(with_one) == ""


def test_gains_with_a_thin_reserve_are_told_and_so_is_an_other_motion_that_moves_the_angle():
    usual = study(0, "proved", 2)
    assert len(remarks(usual)) == 1
    first, second = usual.motions
    thin = {**first.designs["PI"], "guard": {"overshoot_percent": 0.025}}
    changed = (
        replace(first, designs={**first.designs, "PI": thin}),
        replace(second, plant=replace(second.plant, effects=(Coupling,))),
    )
    _, reserve, other = remarks(replace(usual, motions=changed))
    assert reserve.startswith("flexion: no gains meet the limits with that reserve; these keep 2.5 %")
    assert other.startswith("deviation: the other motion moves this angle")


def test_evidence_counts_runs_and_what_a_reference_weight_gains_is_a_remark():
    usual = study(0, "proved", 1)
    (only,) = usual.motions
    assert controller_words(only) == "0 of 70688 runs break a limit"
    two = replace(only, recommended="2-DOF PI", designs={**only.designs, "2-DOF PI": better(only, 8.7)})
    said = " ".join(remarks(replace(usual, motions=(two,))))
    assert "flexion: the reference weight lowers the worst IAE by 13 %." in said
    fails = {**two.designs, "PI": {**two.designs["PI"], "holds": False}}
    assert "reference weight" not in " ".join(remarks(replace(usual, motions=(replace(two, designs=fails),))))


def better(of, cost):
    return {**of.designs["PI"], "cost": cost}


@pytest.mark.parametrize("cost", [None, float("inf")])
def test_gains_that_break_a_limit_of_the_linear_loop_have_no_error_to_compare(cost):
    """They are not simulated."""
    (m,) = study(7, "open", 1).motions
    margins = {"Ms": 1.9, "Mt": 1.3, "delay_margin_s": 0.08}
    gains = dict.fromkeys(("Kp", "Ki", "speed", "dead_time", "swing", "move", "delay"), 1.0)
    of = {
        "gains": gains,
        "cost": cost, "holds": False, "worst_excess": 0.2, "worst_excess_of": "Ms", "worst_case": "a step",
        "margins": margins,
    }  # fmt: skip
    told = {LQI_NAME: lqi_words, CASCADE: cascade_words, FORWARD: feedforward_words, ROBUST_MPC: mpc_words}
    for name, words in told.items():
        said = words(replace(m, designs={**m.designs, name: of}))
        assert "IAE" not in said or "not known" in said
        assert "Ms" in said
        recommended = replace(
            m, designs={**m.designs, "PI": {**m.designs["PI"], "cost": cost}, name: {**of, "cost": 9.0}}
        )
        assert "nan" not in words(recommended)


def test_steps_out_of_reach_are_told_as_what_fails():
    bad = study(7, "open", 1)
    (m,) = bad.motions
    nearest = {"limit": None, "words": "OutOfReach"}
    beyond = replace(m, designs={**m.designs, "PI": {**m.designs["PI"], "nearest": nearest}})
    said = last_line(replace(bad, motions=(beyond,)))
    assert said.startswith("no gains meet every limit: no command in its range holds the steps of flexion")
    assert "[rig.task]" in said


def test_friction_that_keeps_a_joint_out_of_the_band_is_told():
    """A joint that breaks away 2.4 deg from its equilibrium is not held within 0.3 deg by any integrator; one
    that does so at 0.2 deg is."""
    (m,) = study(7, "open", 1).motions

    def sticking(breakaway):
        values = m.plant.values | {"stick-slip.breakaway": breakaway, "stick-slip.residue": 0.2}
        return replace(m, plant=m.plant.revised((FreeSlip,), values, {}, "a log"))

    bad = replace(study(7, "open", 1), motions=(sticking(2.4),))
    said = "flexion: the joint breaks away 2.4 deg from its equilibrium, beyond the band of 0.3 deg"
    assert said in last_line(bad)
    assert any(r.startswith(said) and "[rig.task]" in r for r in remarks(bad))
    for fine in (replace(bad, motions=(sticking(0.2),)), replace(study(0, "open", 1), motions=(m,))):
        assert "breaks away" not in last_line(fine) + " ".join(remarks(fine))


def test_what_the_page_counts_from_is_told():
    good = study(0, "open", 1)
    (m,) = good.motions
    rig = replace(m.plant.rig, zero=Zero(3.0, 26.0))
    counted = replace(m, plant=replace(m.plant, rig=rig))
    (said,) = (w for w in remarks(replace(good, motions=(counted,))) if "of the log" in w)
    assert "the pressure from 3 kPa, the angle from 26 deg" in said
    assert not [w for w in remarks(good) if "of the log" in w]


@pytest.mark.parametrize(
    ("before", "after", "said"), [(2.5, 10.3, True), (2.5, 1.1, False), (None, None, False)]
)
def test_a_revised_plant_that_is_worse_than_the_declared_one_is_told(before, after, said):
    told = worse_words({"before": {"angle_deg": before}, "after": {"angle_deg": after}})
    assert told == (
        ", above 2.5 deg of the declared plant: tune that one (`wrist fit`, `wrist tune`)" if said else ""
    )
