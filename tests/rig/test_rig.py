"""The measured rig is what it claims: independent, true to the declared physics, and every effect is felt.

Only this file may look at the project's own model, and only at its page for reading.
"""

import ast
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

from plants.one_page import wrist
from tests.rig.campaign import TASK_CONTROLLER, make_campaign, make_rig, run_of
from tests.rig.core import TICK, Controller
from tests.rig.effects import CATALOGUE, OPEN, VOCABULARY, Hidden
from tests.rig.joint_effects import Inertia
from tests.rig.parameters import NOMINAL
from tests.rig.physics import make_physics_rig
from tests.rig.regulator_effects import DeadTime
from tests.rig.rig import Noise, Rig, swings
from tests.rig.signals import noise, task_reference
from tests.rig.suite import LOUD_ONLY, cases

AXES = ("flexion", "deviation")
SILENT = Noise(0.0, 0.0)
NOTHING = Hidden()
EVERY_FORM = [(name, form) for name in VOCABULARY for form in range(1, CATALOGUE[name].last + 1)]


def bare(hidden: Hidden = NOTHING, **changes: float) -> Rig:
    """A silent rig of nominal flexion, with some parameters changed."""
    return Rig("flexion", (), SILENT, 0, NOMINAL["flexion"]._replace(**changes), hidden)


def test_shares_no_code_with_the_project() -> None:
    for file in Path(__file__).parent.glob("*.py"):
        if file.name == Path(__file__).name:
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or "."] if isinstance(node, ast.ImportFrom) else []
            assert {name.split(".")[0] for name in names} <= {
                "abc", "argparse", "collections", "dataclasses", "json", "math", "pathlib", "typing", "zlib",
                "numba", "numpy", "pandas", "scipy", "tests",
            }  # fmt: skip


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("recording", ["steps", "sine", "task"])
def test_with_nothing_hidden_it_is_the_declared_wrist(axis: str, recording: str) -> None:
    rig = make_rig(axis, (), seed=5)
    run = run_of(rig, recording)
    page = np.array(wrist(rig.declared._asdict(), list(run.command)))[:-1]
    np.testing.assert_allclose(run.pressure, page[:, 0], atol=2e-3)
    np.testing.assert_allclose(run.angle, page[:, 2], atol=2e-3)


def test_series_of_lags_has_its_closed_form() -> None:
    fast, slow, rise = 0.02, 0.16, 50.0
    rig = bare(k_fast=1 / fast, k_slow=1 / fast, w1=0.0, Tw=slow)
    run = rig.play(np.full(2000, (100.0 + rise) / 49.4), salt=0)
    t = run.time
    share = 1 - (slow * np.exp(-t / slow) - fast * np.exp(-t / fast)) / (slow - fast)
    np.testing.assert_allclose(run.pressure, 100 + rise * (1 - np.exp(-t / fast)), atol=1e-3)
    np.testing.assert_allclose(run.angle, 0.36 * rise * share, atol=1e-3)


def test_inertia_has_its_closed_form() -> None:
    wn, zeta, rise = 10.0, 0.3, 50.0
    rig = bare(Hidden(inertia=Inertia(1, wn, zeta)), k_fast=400.0, k_slow=400.0, w1=0.0)
    run = rig.play(np.full(3000, (100.0 + rise) / 49.4), salt=0)
    t, damped = run.time - 1 / 400.0, wn * (1 - zeta**2) ** 0.5  # the regulator delays by its time constant
    swing = np.exp(-zeta * wn * t) * (np.cos(damped * t) + zeta * wn / damped * np.sin(damped * t))
    np.testing.assert_allclose(run.angle[50:], (0.36 * rise * (1 - swing))[50:], atol=0.01)


def test_hysteresis_does_not_know_how_long_it_took() -> None:
    pressures = np.array([150.0, 60.0, 120.0, 20.0, 180.0, 100.0]) / 49.4
    slow, slower = (bare().play(np.repeat(pressures, n), 0).angle[n - 1 :: n] for n in (20_000, 30_000))
    np.testing.assert_allclose(slow, slower, atol=1e-3)
    assert abs(slow[-1]) > 3.0  # back at rest pressure, but not at rest


def test_dead_time_delays_the_pressure_by_itself() -> None:
    command = np.repeat([2.5, 1.0, 3.5], 1500)
    late = bare(Hidden(dead_time=DeadTime(1, 0.037))).play(command, 0).pressure
    np.testing.assert_allclose(late[37:], bare().play(command, 0).pressure[:-37], atol=1e-9)


def felt(name: str, variants: dict[str, int]) -> float:
    """Largest deviation [spreads of the noise] from the same rig without the effect, in any recording."""
    rig, plain = (make_rig("flexion", names, 11, variants) for names in ([name], []))
    most = 0.0
    for recording in ("staircase", "steps", "small"):
        with_it, without = run_of(rig, recording), run_of(plain, recording)
        assert np.isfinite(with_it.measured).all()
        assert np.abs(with_it.angle).max() < 60.0
        assert -0.1 < with_it.pressure.min() <= with_it.pressure.max() < 206.0
        angle = np.abs(with_it.measured - without.measured).max() / rig.noise.angle_deg
        most = max(most, angle, np.abs(with_it.pressure - without.pressure).max() / rig.noise.pressure_kPa)
    return float(most)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "form"), EVERY_FORM)
def test_every_form_is_felt(name: str, form: int) -> None:
    assert felt(name, {name: form}) > (1.0 if name == "periodic-disturbance" else 5.0)


@pytest.mark.parametrize("name", OPEN)
def test_every_effect_outside_the_vocabulary_is_felt(name: str) -> None:
    assert felt(name, {}) > 5.0


def test_scale_zero_takes_an_effect_away() -> None:
    command = np.repeat([3.0, 1.0, 2.0], 1000)
    plain = make_rig("deviation", [], 3, noise=SILENT).play(command, 0)
    for name in ("creep", "load-step", "gyro-drift", "cross-coupling", "dead-time", "fill-exhaust-asymmetry"):
        gone = make_rig("deviation", [name], 3, {name: 1}, SILENT, scale=0.0).play(command, 0)
        np.testing.assert_allclose(gone.measured, plain.measured, atol=1e-9)


@pytest.mark.parametrize("axis", AXES)
def test_wrist_from_first_principles_makes_a_loop(axis: str) -> None:
    rig = make_physics_rig(axis, 2, SILENT)
    time = np.arange(80_000) * TICK
    run = rig.play((100.0 + 80.0 * np.sin(2 * np.pi * time / 40.0)) / 49.4, 0)
    pressure, angle = run.pressure[40_000:], run.angle[40_000:]  # the second time round
    area = np.sum(angle[1:] * np.diff(pressure))
    assert -5000.0 < area < -100.0  # deg kPa: the angle trails the pressure
    assert 10.0 < angle.max() < 40.0
    assert -40.0 < angle.min() < -8.0
    finer = rig.play(run.command[:20_000], 0, substeps=16)
    np.testing.assert_allclose(run.angle[:20_000], finer.angle, atol=0.01)


def test_coloured_noise_has_its_spread_and_memory() -> None:
    shake = noise(0.3, 200_000, 0.05, 0.01, np.random.default_rng(0))
    assert shake.std() == pytest.approx(0.3, rel=0.02)
    assert np.corrcoef(shake[5:], shake[:-5])[0, 1] == pytest.approx(np.exp(-1.0), abs=0.02)


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    for folder, seed in (("a", 7), ("b", 7), ("c", 8)):
        make_campaign(tmp_path / folder, "flexion", ["creep", "wander"], seed, short=True)
    a, b, c = ((tmp_path / folder / "steps.csv").read_bytes() for folder in "abc")
    assert a == b != c


def test_recordings_are_in_the_measured_format(tmp_path: Path) -> None:
    rig = make_campaign(tmp_path, "deviation", ["cross-coupling"], 4, short=True)
    described = tomllib.loads((tmp_path / "campaign.toml").read_text())
    assert described["axis"] == "deviation"
    assert described["validate"] == ["sine.csv", "task.csv"]
    table = pd.read_csv(tmp_path / "staircase.csv")
    assert list(table) == ["time_s", "command_V", "pressure_kPa", "angle_deg", "other_pressure_kPa"]
    assert "reference_deg" in pd.read_csv(tmp_path / "task.csv")
    first = int(np.flatnonzero(np.diff(table["command_V"]))[0]) + 1
    before = run_of(rig, "staircase", short=True).pressure[first * 10]
    assert before < 101.0  # the row of the step shows the sensors before it acts
    assert table["pressure_kPa"][first + 100] > 140.0


def test_task_is_the_loop_that_it_says() -> None:
    rig = make_rig("flexion", [], 9, noise=SILENT)
    run = rig.follow(task_reference(), TASK_CONTROLLER, 1)
    error = run.reference - run.measured
    integral = np.concatenate([[0.0], np.cumsum(error)[:-1]]) * TICK
    expected = (100.0 + TASK_CONTROLLER.Kp * error + TASK_CONTROLLER.Ki * integral) / 49.4
    np.testing.assert_allclose(run.command, expected, atol=1e-9)  # never clipped here


def test_the_second_degree_of_freedom_is_the_law_that_it_says() -> None:
    rig = make_rig("flexion", [], 9, noise=SILENT)
    c = Controller(Kp=1.2, Ki=2.2, b=0.6, Tf=0.03)
    run = rig.follow(task_reference(), c, 1)
    keep = np.exp(-TICK / c.Tf)
    filtered = lfilter([1.0 - keep], [1.0, -keep], run.measured)
    integral = np.concatenate([[0.0], np.cumsum(run.reference - filtered)[:-1]]) * TICK
    expected = (100.0 + c.Kp * (c.b * run.reference - filtered) + c.Ki * integral) / 49.4
    np.testing.assert_allclose(run.command, expected, atol=1e-9)  # never clipped here


def test_closed_loop_is_judged_on_the_true_angle() -> None:
    rig = make_rig("flexion", ["gyro-drift"], 9, {"gyro-drift": 1})
    calm, wild = rig.closed_loop(1.2, 2.2), rig.closed_loop(60.0, 400.0)
    assert not calm.oscillates
    assert calm.overshoot < 0.1
    assert 1.0 < calm.settling < 10.0
    assert wild.oscillates
    assert wild.settling == float("inf")
    assert abs(calm.run.angle - calm.run.measured)[-1000:].mean() > 0.05  # the drift is not seen by the judge
    time = np.arange(5000) * TICK
    assert swings(np.sin(2 * np.pi * time), 1.5) == 8  # of ten, neither the first nor the last


def test_suite_holds_every_effect_on_both_motions() -> None:
    suite = list(cases(seed=3))
    for name in VOCABULARY:
        alone = [case for case in suite if case.effects == (name,)]
        assert {case.axis for case in alone} == set(AXES)
        assert len({case.variants[name] for case in alone}) == 2
    strange = [case.effects for case in suite if set(case.effects) & set(OPEN)]
    assert len(strange) == 5
    assert not {name for names in strange for name in names} & set(LOUD_ONLY)
    assert sum(not case.effects for case in suite) == 6
    assert sum(len(case.effects) == 2 for case in suite) == 6
