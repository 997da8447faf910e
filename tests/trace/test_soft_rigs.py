"""Rigs that no parameter file describes are traced from the log alone: what is left is small, what is named
is true, nothing is borrowed from the command.

The rigs are those of `tests.rig.soft.named`, which share no code with the library and have other forms of the
effects.
"""

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.search.worth import SHARE
from plants.measured.trace.trace import trace_campaign
from plants.wrist import Wrist
from reports.trace.captions import after_words
from reports.trace.words import log_words
from tests.rig.campaign import drop
from tests.rig.soft.drawn import preisach_actuator, recordings, soft_actuator
from tests.rig.soft.named import CAMPAIGNS, muscles

pytestmark = pytest.mark.suite
TRUE = {
    "arm-a": {
        "dead-time",
        "fill-exhaust-asymmetry",
        "branch-curvature",
        "creep",
        "end-stop",
        "loop-shape",
    },
    "arm-b": {"dead-time", "fill-exhaust-asymmetry", "branch-curvature", "creep", "end-stop"},
    "bender": {"dead-time", "fill-exhaust-asymmetry", "branch-curvature", "creep", "end-stop"},
    "finger": {"dead-time", "fill-exhaust-asymmetry", "branch-curvature", "creep", "end-stop"},
}
"""Effects that a rig has.  A joint that does not move below an angle has a stop there; one that stiffens with
the cube of its angle may be described as curved or as meeting a soft stop.  Arm A has five plays with
thresholds at uneven distances, the law four at even ones."""


@pytest.fixture(scope="module", params=CAMPAIGNS)
def traced(request, tmp_path_factory):
    make, fit, validate = CAMPAIGNS[request.param]
    folder = tmp_path_factory.mktemp("soft") / request.param
    make().write(folder, fit, validate)
    return request.param, trace_campaign(load_campaign(folder))


def test_the_error_is_at_most_half_of_the_declared_models_and_two_hundredths_of_the_range(traced):
    _, trace = traced
    assert trace.after["angle_deg"] <= 0.5 * trace.before["angle_deg"]
    assert trace.remainder["angle_deg"].share_of_range <= 0.02
    assert trace.explained_share["angle_deg"] >= 0.75
    assert not trace.worse


def test_only_what_the_rig_has_is_named(traced):
    name, trace = traced
    named = {e.name for e in trace.effects}
    assert named <= TRUE[name]
    assert {"dead-time", "fill-exhaust-asymmetry"} <= named


def test_the_curved_loop_is_better_described_by_another_law(traced):
    """Before effects are looked for; with the effects that each needs either may be the better one, and the
    other is taken where it takes away as much as an effect must, a quarter of the sum of squares."""
    _, trace = traced
    assert trace.law.held_out["prandtl-ishlinskii"] < trace.law.held_out["four-segment"]
    if trace.law.with_effects:
        errors = trace.law.with_effects
        assert (1.0 - SHARE) * errors[trace.law.name] ** 2 <= 1.1 * min(errors.values()) ** 2


def test_what_the_law_alone_leaves_is_told_apart_from_its_effects(traced):
    _, trace = traced
    if trace.other_law is None:  # with effects four segments may be the better law
        assert not trace.law_alone
        return
    alone = trace.law_alone["angle_deg"]
    assert trace.after["angle_deg"] < alone
    assert f"With {trace.other_law} and no effect" in " ".join(log_words(trace))
    assert f"the hysteresis law {trace.other_law}" in after_words(trace)


def test_a_wrist_of_muscles_that_sticks_is_told_from_one_that_does_not(tmp_path):
    """It breaks away at 2.5 deg and rests again at 0.3, which no form of the library does quite so; it creeps
    by 6 %."""
    muscles().write(tmp_path, ("sweep", "stairs", "steps"), ("check",))
    trace = trace_campaign(load_campaign(tmp_path))
    found = {e.name: e for e in trace.effects}
    # Whether the creep is named hangs on the rounding of the processor.
    assert {"dead-time", "stick-slip"} <= set(found) <= {"dead-time", "creep", "stick-slip"}
    assert all(0.03 < e.parameters["gain"][0] < 0.09 for n, e in found.items() if n == "creep")
    # No form of the library does what it does: what fits best breaks away at 1.8 to 2.5 deg.
    assert found["stick-slip"].parameters["breakaway"][0] == pytest.approx(2.5, rel=0.35)
    # Some of it may be given to a lag behind it, which delays by as much where nothing is quick.
    wrist = Wrist.of(trace.revised)
    late = next(e for e in wrist.effects if e.NAME == "dead-time")
    assert late.delay + sum(late.lags(wrist)) == pytest.approx(0.053, abs=0.015)
    assert trace.after["angle_deg"] < (0.7 if "creep" in found else 0.75) * trace.before["angle_deg"]
    assert trace.after["pressure_kPa"] < 0.3 * trace.before["pressure_kPa"]
    assert trace.remainder["angle_deg"].share_of_range < 0.02


def test_sensors_zeroed_anew_hide_no_effect(tmp_path):
    """Recordings that are offset by 0.6 deg of 41 to each other were explained by softening and drift."""
    soft_actuator(211).write(tmp_path / "soft", recordings(211), ("check",))
    trace = trace_campaign(load_campaign(tmp_path / "soft"))
    assert any("anew in each recording" in str(r) for r in trace.instrument)
    named = {e.name for e in trace.effects}
    assert {"dead-time", "creep"} <= named <= TRUE["bender"]
    assert trace.after["angle_deg"] < 2.0 * trace.noise["angle_deg"]


def test_a_sensor_that_saturates_hides_no_effect(tmp_path):
    """All recordings begin with a sensor that shows nothing below zero, which hides their offsets; a stop and
    another shape of the loop stood for both."""
    soft_actuator(302).write(tmp_path / "soft", recordings(302), ("check",))
    trace = trace_campaign(load_campaign(tmp_path / "soft"))
    assert {"saturated", "offset"} <= {r.habit for r in trace.instrument}
    assert {e.name for e in trace.effects} == {"dead-time", "fill-exhaust-asymmetry", "creep"}
    assert trace.after["angle_deg"] < 0.1 * trace.before["angle_deg"]


def test_a_law_that_fits_each_recording_for_itself_does_not_replace_another(tmp_path):
    """Four segments with a softening, a load step and creep have the smaller error on held-out blocks, and
    twice the error on recordings left out whole: held-out data were simulated with three times the error."""
    soft_actuator(530).write(tmp_path / "soft", recordings(530), ("check",))
    trace = trace_campaign(load_campaign(tmp_path / "soft"))
    assert (
        {"dead-time", "fill-exhaust-asymmetry", "creep"} <= {e.name for e in trace.effects} <= TRUE["arm-b"]
    )
    assert trace.after["angle_deg"] < 0.2 * trace.before["angle_deg"]


def test_what_the_form_of_a_law_leaves_is_given_no_name(tmp_path):
    """Under the law that was chosen 0.19 % of the range is left, which several effects follow by half; the
    joint creeps by 1.7 %, which may be named."""
    soft_actuator(203).write(tmp_path / "soft", recordings(203), ("check",))
    trace = trace_campaign(load_campaign(tmp_path / "soft"))
    named = {e.name for e in trace.effects}
    assert (
        {"dead-time", "fill-exhaust-asymmetry"} <= named <= {"dead-time", "fill-exhaust-asymmetry", "creep"}
    )
    assert trace.after["angle_deg"] < 0.2 * trace.before["angle_deg"]


def test_an_effect_that_serves_single_recordings_is_not_named(tmp_path):
    """A softening takes half of chi-square, and each recording is left twice the error by a fit to the other;
    on some processors the search does not get there.  The joint creeps by 6 %, which may be named."""
    soft_actuator(502).write(tmp_path / "soft", recordings(502), ("check",))
    trace = trace_campaign(load_campaign(tmp_path / "soft"))
    named = {e.name for e in trace.effects}
    assert (
        {"dead-time", "fill-exhaust-asymmetry"} <= named <= {"dead-time", "fill-exhaust-asymmetry", "creep"}
    )
    assert trace.after["angle_deg"] < 0.3 * trace.before["angle_deg"]


@pytest.mark.parametrize("either_way", [False, True])
def test_a_joint_that_does_not_move_at_first_needs_no_effect_for_its_curve(tmp_path, either_way):
    """Where the angle counts from the middle of its range, the rest at the end of it is on no virgin curve of
    four segments; believed to be for plays too, recordings were left with five times the error."""
    soft_actuator(529).write(tmp_path / "soft", recordings(529), ("check",))
    trace = trace_campaign(load_campaign(tmp_path / "soft"), either_way=either_way)
    assert trace.law.name == "prandtl-ishlinskii"
    named = {e.name for e in trace.effects}
    assert {"dead-time", "fill-exhaust-asymmetry"} <= named
    assert named <= {"dead-time", "fill-exhaust-asymmetry", "creep"}
    assert trace.after["angle_deg"] < 0.2 * trace.before["angle_deg"]


@pytest.mark.parametrize(
    ("seed", "most", "found", "beside"), [(401, 0.75, {"creep"}, {"softening"}), (707, 0.2, set(), {"creep"})]
)
def test_without_a_pressure_what_the_valve_does_is_named(tmp_path, seed, most, found, beside):
    """One effect at a time, a softening was named for it, and three quarters of the error of the declared
    model were left, or nothing was named, and three fifths.  Both joints creep; whether that is named (of
    707), and whether 401 is given a softening beside it, hangs on the rounding of the processor."""
    soft_actuator(seed).write(tmp_path, recordings(seed), ("check",))
    drop(tmp_path, ["pressure_kPa"])
    trace = trace_campaign(load_campaign(tmp_path))
    named = {e.name for e in trace.effects}
    found = {"fill-exhaust-asymmetry", *found}
    assert found <= named <= {"dead-time", *found, *beside}
    assert trace.after["angle_deg"] < most * trace.before["angle_deg"]
    assert any("No pressure was logged" in r and all(n in r for n in found) for r in trace.remarks)
    assert any("on an assumed scale, 100 kPa over the range of the command" in r for r in trace.remarks)


def test_a_creep_is_not_taken_for_a_drift_of_the_sensor(tmp_path):
    """A drift that changes while warming up follows more of the recordings that it is fitted on, and less of
    one that is left out whole; a design knows of no drift, and its gains did not hold on the rig."""
    preisach_actuator(966).write(tmp_path, recordings(966), ("check",))
    trace = trace_campaign(load_campaign(tmp_path), either_way=True)
    assert {e.name for e in trace.effects} == {"dead-time", "fill-exhaust-asymmetry", "inertia", "creep"}
    wrist = Wrist.of(trace.revised)
    creep = next(e for e in wrist.effects if e.NAME == "creep").sampled(wrist, 20.0)  # whatever its form
    gain, slow = preisach_actuator(966).creep
    assert np.dot(creep.gains, creep.shares) == pytest.approx(gain * -np.expm1(-20.0 / slow), rel=0.15)
    assert trace.after["angle_deg"] < 0.1 * trace.before["angle_deg"]


def test_a_creep_as_quick_as_the_lag_leaves_the_weights_of_the_plays_determined(tmp_path):
    """With both free each weight was known to 95 %, and a design for such plants found no gains."""
    preisach_actuator(961, copies=2).write(tmp_path, recordings(961), ("check",))
    trace = trace_campaign(load_campaign(tmp_path), either_way=True)
    p = trace.revised.parameters
    for weight in ("v0", "v1"):
        assert p[weight].provenance.std_error < 0.3 * p[weight].value
    assert trace.after["angle_deg"] < 0.3 * trace.before["angle_deg"]


def test_for_a_design_the_names_and_the_error_are_the_same(tmp_path):
    """Counted from mid-range the law fitted worse by six times, since it began between its branches: another
    law was taken, and stick-slip, curvature and creep were named for the difference."""
    soft_actuator(901).write(tmp_path / "soft", recordings(901), ("check",))
    campaign = load_campaign(tmp_path / "soft")
    plain, amid = (trace_campaign(campaign, either_way=way) for way in (False, True))
    assert amid.revised.rig.zero.rest == -16.0
    assert {e.name for e in plain.effects} == {"dead-time", "fill-exhaust-asymmetry"}
    assert [e.name for e in amid.effects] == [e.name for e in plain.effects]
    assert amid.after["angle_deg"] == pytest.approx(plain.after["angle_deg"], rel=0.1)


def test_an_effect_that_serves_its_recordings_only_in_one_form_is_kept_in_another(tmp_path):
    """Rates that depend on the pressure, and two time constants of a creep, fit its two recordings best and
    miss one by a fit to the other; a ratio of rates and a single time constant do not."""
    rig = soft_actuator(100)
    rig.write(tmp_path, recordings(100), ("check",))
    trace = trace_campaign(load_campaign(tmp_path))
    found = {e.name: e for e in trace.effects}
    assert set(found) == {"dead-time", "fill-exhaust-asymmetry", "creep"}
    assert found["fill-exhaust-asymmetry"].parameters["ratio"][0] == pytest.approx(
        rig.exhaust / rig.fill, rel=0.1
    )
    assert trace.after["angle_deg"] < 0.2 * trace.before["angle_deg"]
    assert trace.after["pressure_kPa"] < 0.15 * trace.before["pressure_kPa"]
