"""Logs of a closed loop are fitted as those of an open loop: the noise that the controller feeds back biases
nothing, since the fit runs freely from the logged command.  What that did between rows is found: set-points
that change between them, a controller that runs once a row, a smooth command in a slow log."""

from dataclasses import replace

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.fit import fit_campaign
from plants.measured.fitting.stage import Stage
from plants.measured.trace.rig_fit import fit_rig
from plants.measured.trace.stages.between_rows import _turned, with_command
from plants.parameters.files import built_in
from plants.wrist import Wrist
from tests.rig.campaign import QUICK, logged_table, make_campaign, make_rig, record_closed, set_points
from tests.trace.traces import trace_folder

BETWEEN, AT_ROWS = 3, 2  # digits of the moments [s] at which set-points change; rows are 0.01 s apart


def recorded(rig, folder, digits):
    return load_campaign(record_closed(rig, folder, digits))


def off(rig, fitted):
    """How far parameters lie from the rig's, in standard errors, and as a share."""
    truth = rig.declared._asdict()
    return {
        n: (abs(p.value - truth[n]) / p.provenance.std_error, abs(p.value / truth[n] - 1.0))
        for n, p in fitted.parameters.items()
        if getattr(p.provenance, "std_error", None) is not None
    }


@pytest.mark.suite
def test_parameters_lie_within_their_errors(tmp_path):
    rig = make_rig("flexion", [], 402)
    fit = fit_campaign(recorded(rig, tmp_path, AT_ROWS), built_in("flexion"), 1)
    assert max(fit.ratios.values()) < 1.05
    assert all(errors < 4.0 or share < 0.005 for errors, share in off(rig, fit.fitted).values())


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "seed"), [("flexion", 403), ("deviation", 404)])
def test_set_points_between_rows_bias_nothing(tmp_path, axis, seed):
    rig = make_rig(axis, [], seed)
    campaign = recorded(rig, tmp_path, BETWEEN)
    at_rows = fit_campaign(campaign, built_in(axis), 1)
    assert off(rig, at_rows.fitted)["k_fast"][1] > 0.03  # jumps of the command held until their rows
    found = fit_rig(campaign, built_in(axis), 1)
    errors, share = off(rig, found.fit.fitted)["k_fast"]
    assert share < 0.005
    assert errors < 3.5  # the standard error knows that the times were estimated too
    assert max(found.fit.ratios.values()) < 1.05
    assert [r.habit for r in found.start.instrument] == ["between"]
    moments, _ = set_points(rig, 11, BETWEEN)
    recording = found.start.campaign.fit[0]
    at = np.flatnonzero(Playback(recording).jumped)
    when = (recording.time - recording.ahead)[at]
    nearest = np.abs(when[:, None] - moments).min(axis=1)
    assert np.median(nearest) < 0.0005
    assert np.quantile(nearest, 0.9) < 0.01  # a few jumps are the command's that comes back from its limit


@pytest.mark.slow
def test_what_times_of_jumps_explain_is_taken_off(tmp_path):
    rig = make_rig("flexion", [], 403)
    model = fit_rig(recorded(rig, tmp_path, BETWEEN), built_in("flexion"), 1).model
    problem, x = model.problem.off_jumps(model.vector), model.vector
    of_each = np.add.reduceat(problem.jumps * problem.residuals(x[None, :])[:, 0], model.stage.jumps)
    assert np.abs(of_each).max() < 1e-6 * np.linalg.norm(problem.jumps)
    # By numpy: least squares with a column for each jump leaves the same.
    at = np.searchsorted(model.stage.jumps, np.arange(len(problem.jumps)), side="right") - 1
    columns = np.zeros((len(problem.jumps), len(model.stage.jumps)))
    columns[np.arange(len(at)), at] = problem.jumps
    explained = columns @ np.linalg.lstsq(columns, model.residual, rcond=None)[0]
    assert problem.residuals(x[None, :])[:, 0] == pytest.approx(model.residual - explained, abs=1e-9)


@pytest.mark.slow
def test_set_points_at_rows_stay_there(tmp_path):
    rig = make_rig("flexion", [], 402)
    found = fit_rig(recorded(rig, tmp_path, AT_ROWS), built_in("flexion"), 1)
    assert not found.start.instrument
    assert all(r.ahead is None for r in (*found.start.campaign.fit, *found.start.campaign.validate))


@pytest.mark.slow
def test_a_missing_effect_does_not_pass_for_set_points_between_rows(tmp_path):
    rig = make_rig("flexion", ["fill-exhaust-asymmetry"], 407)
    assert not fit_rig(recorded(rig, tmp_path, AT_ROWS), built_in("flexion"), 1).start.instrument


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_nor_does_a_regulator_that_became_faster_or_slower(tmp_path, factor):
    rig = make_rig("flexion", [], 402)
    recording = recorded(rig, tmp_path, AT_ROWS).fit[0]
    values = rig.declared._asdict()
    changed = {n: factor * values[n] for n in ("k_fast", "k_slow")}
    plant = built_in("flexion")
    wrist = Wrist.from_values({**plant.values, **values, **changed}, rig=plant.rig)
    assert with_command(recording, wrist) is recording


def test_steps_of_a_command_are_no_ramps_over_a_row():
    """They would only make the steps half a row late, for which a regulator that lacks a dead time asks."""
    time = np.arange(400) / 20
    steps, wave = np.repeat([0.0, 3.0, 1.0, 2.0], 100), 2.0 + np.sin(time)
    played = tuple(Playback(Recording(n, time, u)) for n, u in (("steps", steps), ("wave", wave)))
    stage = Stage("regulator", "pressure_kPa", 1.0, played, (), built_in("flexion").rig)
    turned = [p.recording.commanded for p in _turned(stage).playbacks]
    assert [p.recording.commanded for p in played] == ["held", "held"]
    assert turned == ["held", "straight"]
    assert [p.recording.commanded for p in _turned(_turned(stage)).playbacks] == ["held", "held"]


@pytest.mark.suite
@pytest.mark.parametrize(
    ("axis", "effects", "seed"),
    [
        ("flexion", [], 402),
        ("flexion", ["creep"], 405),
        ("deviation", ["dead-time"], 406),
        ("flexion", ["fill-exhaust-asymmetry"], 407),
        ("deviation", ["rate-dependence"], 408),
        ("flexion", ["inertia"], 409),
    ],
)
def test_as_much_is_named_with_set_points_between_rows(tmp_path, axis, effects, seed):
    recorded(make_rig(axis, effects, seed), tmp_path, BETWEEN)
    trace = trace_folder(tmp_path)
    assert [e.name for e in trace.effects] == effects
    assert trace.verdict == ("explained" if effects else "nothing-missing")


def test_a_jump_ahead_of_its_row_counts_for_the_share_of_its_sample():
    reference = np.array([0.0, 0.0, 15.0, 15.0])
    log = Recording(
        "r", np.arange(4) * 0.01, np.array([1.0, 1.0, 3.0, 3.0]), np.zeros(4), reference=reference
    )
    timed = replace(log, ahead=np.array([0.0, 0.0, 0.0034, 0.0]))
    assert Playback(timed).commands[:16] == pytest.approx(1.0)
    assert Playback(timed).commands[16] == pytest.approx(1.0 + 0.4 * 2.0)
    assert Playback(timed).commands[17:] == pytest.approx(3.0)
    assert Playback(log).commands[:20] == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "seed"), [("flexion", 403), ("deviation", 404)])
def test_a_controller_that_runs_once_a_row_holds_its_command(tmp_path, axis, seed):
    rig = make_rig(axis, [], seed)
    record_closed(rig, tmp_path, BETWEEN, controller=QUICK._replace(every=10))
    campaign = load_campaign(tmp_path)
    assert max(fit_campaign(campaign, built_in(axis), 1).ratios.values()) > 1.03  # of straight commands
    found = fit_rig(campaign, built_in(axis), 1)
    assert [(r.habit, r.channel) for r in found.start.instrument] == [("held", "command_V")]
    assert {r.commanded for r in (*found.start.campaign.fit, *found.start.campaign.validate)} == {"held"}
    assert max(found.fit.ratios.values()) < 1.03
    assert off(rig, found.fit.fitted)["k_slow"][1] < 0.01


def waves(rig, folder, row):
    """A campaign whose command moves smoothly at 1 kHz in open loop, with a row every so many ms."""
    time = np.arange(60_001) * 0.001
    for salt, name in enumerate(("one", "two", "three")):
        slow = np.sin(2.0 * np.pi * (0.15 + 0.02 * salt) * time) * np.cos(0.2 * time)
        run = rig.play(2.02 + 1.4 * slow + 0.3 * np.sin((4.4 + 0.6 * salt) * time), salt)
        logged_table(rig, "sine", run, False).iloc[:: row // 10].to_csv(folder / f"{name}.csv", index=False)
    (folder / "campaign.toml").write_text(
        f'axis = "{rig.axis}"\nsample_time_s = {row / 1000}\nfit = ["one.csv", "two.csv"]\n'
        'validate = ["three.csv"]\n'
    )
    return load_campaign(folder)


@pytest.mark.slow
def test_a_command_in_open_loop_may_move_between_the_rows_of_a_slow_log(tmp_path):
    rig = make_rig("flexion", [], 402)
    campaign = waves(rig, tmp_path, 40)
    assert off(rig, fit_campaign(campaign, built_in("flexion"), 1).fitted)["k_fast"][1] > 0.3  # held
    found = fit_rig(campaign, built_in("flexion"), 1)
    assert [r.habit for r in found.start.instrument] == ["straight"]
    assert off(rig, found.fit.fitted)["k_fast"][1] < 0.02
    assert max(found.fit.ratios.values()) < 1.05
    assert "moves on between the rows, 0.04 s apart" in str(found.start.instrument[0])
    assert trace_folder(tmp_path).verdict == "nothing-missing"


def test_a_command_that_is_held_in_open_loop_stays_held(tmp_path):
    rig = make_campaign(tmp_path, "flexion", seed=402, short=True)
    found = fit_rig(load_campaign(tmp_path), built_in(rig.axis), 1)
    assert not found.start.instrument
    assert all(r.between is None for r in (*found.start.campaign.fit, *found.start.campaign.validate))
