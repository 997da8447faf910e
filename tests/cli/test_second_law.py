"""A plant file with another hysteresis law passes through the commands as the paper's does."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plants import Wrist
from plants.parameters.files import dump, load
from plants.rig import Zero
from tests.laws.second_law import LOOP, counted_from, second_law_file, second_law_set
from tests.rig import signals

NOISE_DEG, NOISE_KPA = 0.05, 0.1


@pytest.fixture
def plays(tmp_path: Path) -> Path:
    """The plant's file."""
    return second_law_file(tmp_path)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of that plant: short recordings, noise on both channels."""
    folder = tmp_path_factory.mktemp("plays")
    wrist, rng = Wrist.of(second_law_set()), np.random.default_rng(3)
    for name in ("staircase", "steps", "sine"):
        volts = signals.command_of(signals.OPEN_LOOP[name](rng, True))
        went, n = wrist.simulate(np.repeat(volts, 10), every=10), len(volts)
        columns = (
            np.arange(n) * 0.01, volts, went.pressure[:n] + rng.normal(0.0, NOISE_KPA, n),
            went.angle[:n] + rng.normal(0.0, NOISE_DEG, n),
        )  # fmt: skip
        np.savetxt(
            folder / f"{name}.csv", np.column_stack(columns), "%.4f", ",",
            header="time_s,command_V,pressure_kPa,angle_deg", comments="",
        )  # fmt: skip
    (folder / "campaign.toml").write_text(
        'axis = "flexion"\nsample_time_s = 0.01\n'
        'fit = ["staircase.csv", "steps.csv"]\nvalidate = ["sine.csv"]\n'
    )
    return folder


def test_show_gives_the_parameters_of_its_law(wrist, plays):
    shown = wrist("show", "--plant", plays, "--json", "-").json
    assert {n: shown[n]["value"] for n in LOOP.values} == pytest.approx(LOOP.values)
    assert "a1" not in shown
    assert "weight of play 2 of 3" in wrist("show", "--plant", plays).out


def test_simulate_plays_the_loop_open_and_closed(wrist, plays):
    opened = wrist("simulate", "--plant", plays, "--volts", "3", "--json", "-").json
    assert opened["angle_deg"][-1] == pytest.approx(Wrist.of(load(plays)).simulate([3.0] * 10_000).angle[-1])
    closed = wrist("simulate", "--plant", plays, "--gains", "2,6", "--json", "-").json
    assert closed["angle_deg"][-1] == pytest.approx(15.0, abs=0.3)


def test_fit_finds_its_parameters_and_writes_a_plant_of_the_same_law(wrist, campaign, tmp_path):
    start, fitted = tmp_path / "start.toml", tmp_path / "fitted.toml"
    off = replace(LOOP, v0=0.1, v=(0.1, 0.1, 0.1), reach=28.0, c1=1.05, c2=1.0, b1=0.95, b2=0.9)
    dump(second_law_set(off), start)
    outcome = wrist("fit", campaign, "--plant", start, "--starts", "1", "--save", fitted, "--json", "-")
    assert outcome.code == 0, outcome.err
    assert outcome.json["validate_rmse"]["angle_deg"] < 1.5 * NOISE_DEG
    assert load(fitted).law is type(LOOP)


@pytest.mark.slow
def test_trace_finds_nothing_missing_in_its_own_recordings(wrist, campaign, plays):
    outcome = wrist("trace", campaign, "--plant", plays)
    assert outcome.code == 0, outcome.err
    assert "Nothing is missing" in outcome.out


@pytest.mark.slow
def test_tune_answers_with_gains_that_hold_every_limit(wrist, plays):
    outcome = wrist("tune", "--plain", "--plant", plays, "--points", "8", "--starts", "1", "--json", "-")
    assert outcome.code == 0, outcome.err
    assert outcome.json["worst_case"]["each_metric_over_all_scenarios"]["overshoot_percent"] <= 5.0
    assert outcome.json["Ki"] > 1.0


@pytest.mark.slow
def test_robust_states_what_holds_and_what_it_cannot_say(wrist, plays):
    outcome = wrist(
        "robust", "--plant", plays, "--gains", "2,6", "--samples", "20", "--budget", "200", "--json", "-"
    )
    assert outcome.code in (0, 1), outcome.err
    assert "outer branch, steepest" in str(outcome.json)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("controller", "gains", "told"),
    [
        ("pi", "2,6", 0), ("lqi", "600,-640,-70,8,45", 0), ("feedforward", "25", 3),
        ("feedforward-pi", "1.2,2.2,0", 6),  # of its model, and as observed
        ("observer", "15", 3),
    ],
)  # fmt: skip
def test_export_writes_a_controller_that_knows_it(wrist, plays, tmp_path, controller, gains, told):
    out = tmp_path / controller
    outcome = wrist("export", controller, "--plant", plays, "--gains", gains, "--out", out, "--json", "-")
    assert outcome.code == 0, outcome.err
    assert (out / "Makefile").exists()
    plays_told = [m["name"] for m in outcome.json["state"] if "plays" in m["name"]]
    assert len(plays_told) == told


def test_the_tuner_moves_its_loop():
    from design.tuner.case import case
    from design.tuner.setting import Setting, plant

    wrist = Wrist.of(second_law_set())
    moved = plant(wrist, Setting(width=1.1, lines=1.2, transit=0.9)).hysteresis
    assert (moved.reach, moved.v0) == pytest.approx((1.1 * LOOP.reach, 0.9 * LOOP.v0))
    assert moved.v == pytest.approx([1.2 * v for v in LOOP.v])
    made = case(wrist, Setting(width=1.1))
    assert (made.trouble, len(made.problem.scenarios)) == (None, 10)


def test_a_recording_is_played_from_where_a_rig_rests_that_is_counted_from_elsewhere(
    wrist, campaign, tmp_path
):
    """Played from the pressure at which the angle is counted 0, the first seconds would be off by degrees."""
    moved = second_law_set(counted_from(LOOP, 5.0))
    rig = replace(moved.rig, zero=Zero(angle=5.0, rest=-5.0))
    dump(replace(moved, rig=rig), tmp_path / "moved.toml")
    outcome = wrist(
        "simulate", "--recording", campaign / "steps.csv", "--plant", tmp_path / "moved.toml", "--json", "-"
    )
    off = np.subtract(outcome.json["angle_deg"], outcome.json["measured_angle_deg"])
    assert np.sqrt(np.mean(off**2)) < 1.2 * NOISE_DEG
    assert "played from its first rows" in outcome.err
