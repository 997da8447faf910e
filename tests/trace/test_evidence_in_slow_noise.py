"""Slow noise is not a missing effect, and an effect that passes for slow noise is found all the same."""

import numpy as np
import pytest
from scipy.linalg import solve_toeplitz, toeplitz

from benchmarks.false_discoveries import null_campaign
from plants.measured.residual.series.joined import Joined, join
from plants.measured.residual.series.remainder import Remainder
from plants.measured.trace.result import StageTrace, Trace
from plants.measured.trace.search.likelihood import demanded, expected, likelihood_of
from tests.rig.campaign import make_campaign
from tests.rig.rig import Noise
from tests.trace.traces import trace_folder

DT, ROWS, MEMORY = 0.01, 4400, 0.2


def covariance(rows: int) -> np.ndarray:
    """Of first-order noise of variance 1 and a memory of 0.2 s, at lags 0, 1, ..."""
    return np.exp(-np.arange(rows) * DT / MEMORY)


def slow_noise(seed: int, rows: int = ROWS) -> np.ndarray:
    """Such noise: each row what is left of the one before, and something new."""
    keep = np.exp(-DT / MEMORY)
    new = np.random.default_rng(seed).standard_normal(rows)
    value = np.empty(rows)
    value[0] = new[0]
    for i in range(1, rows):
        value[i] = keep * value[i - 1] + np.sqrt(1.0 - keep**2) * new[i]
    return value


def joined(value: np.ndarray) -> Joined:
    return join([Remainder("r", "wrist", DT * np.arange(len(value)), value, 1.0, {})])


def unlikely(value: np.ndarray) -> float:
    """Minus the exact log-likelihood of a series as such noise, but for its constant, by scipy."""
    c = covariance(len(value))
    return 0.5 * float(value @ solve_toeplitz(c, value)) + 0.5 * np.linalg.slogdet(toeplitz(c))[1]


def wrist(trace: Trace) -> StageTrace:
    return next(s for s in trace.stages if s.name == "wrist")


def test_the_likelihood_of_a_spectrum_is_that_of_its_covariance():
    value = slow_noise(1, 600)
    circle = 20_000
    lags = np.minimum(np.arange(circle), circle - np.arange(circle))
    spectrum = np.fft.rfft(np.exp(-lags * DT / MEMORY)).real
    found = expected(spectrum, circle, 150)
    assert found.unlikely(value) == pytest.approx(unlikely(value), rel=1e-6)
    assert found.unlikely(value[:90]) == pytest.approx(unlikely(value[:90]), rel=1e-6)


@pytest.mark.parametrize("size", [0.8, 4.0])
def test_a_ramp_gains_what_the_exact_likelihood_says(size):
    ramp = size * np.linspace(-1.0, 1.0, ROWS)
    exact, found = [], []
    for seed in range(6):
        noise = slow_noise(seed)
        solved = solve_toeplitz(covariance(ROWS), np.column_stack([noise, noise + ramp]))
        exact.append(0.5 * float((noise + ramp) @ solved[:, 1] - noise @ solved[:, 0]))
        found.append(likelihood_of(joined(noise)) - likelihood_of(joined(noise + ramp)))
    # The spectrum is found in 44 s of the noise: slow waves are known to a third.
    assert sum(found) == pytest.approx(sum(exact), rel=0.35)


def test_a_wave_followed_in_noise_alone_gains_less_than_is_demanded():
    time = DT * np.arange(ROWS)
    gains = []
    for seed in range(40):
        noise = slow_noise(seed)
        best = []
        for frequency in np.arange(0.05, 1.0, 0.1):
            waves = np.column_stack(
                [np.sin(2 * np.pi * frequency * time), np.cos(2 * np.pi * frequency * time)]
            )
            best.append(noise - waves @ np.linalg.lstsq(waves, noise, rcond=None)[0])
        least = min(best, key=lambda left: float(left @ left))
        gains.append(likelihood_of(joined(least)) - likelihood_of(joined(noise)))
    assert max(gains) < demanded(3, DT * ROWS)
    assert max(gains) > 1.0


@pytest.mark.slow
def test_slow_noise_of_the_pressure_does_not_drive_the_wrist(tmp_path):
    noise = Noise(0.05, 0.4, 0.2)
    make_campaign(tmp_path / "c", "flexion", [], seed=61, noise=noise, short=True)
    trace = trace_folder(tmp_path / "c")
    assert (trace.verdict, trace.effects) == ("nothing-missing", ())
    left = wrist(trace).model.residual * wrist(trace).stage.noise
    assert np.std(left) == pytest.approx(noise.angle_deg, rel=0.15)


@pytest.mark.slow
def test_an_effect_too_short_for_structure_is_found(tmp_path):
    make_campaign(tmp_path / "c", "deviation", ["branch-curvature"], seed=405, short=True)
    trace = trace_folder(tmp_path / "c")
    assert not wrist(trace).before.structured
    assert (trace.verdict, [e.name for e in trace.effects]) == ("explained", ["branch-curvature"])


@pytest.mark.suite
def test_an_effect_is_told_from_the_slow_noise_around_it(tmp_path):
    make_campaign(tmp_path / "c", "flexion", ["gyro-drift"], seed=412, short=True, correlation_s=0.2)
    trace = trace_folder(tmp_path / "c")
    assert not wrist(trace).before.structured
    assert (trace.verdict, [e.name for e in trace.effects]) == ("explained", ["gyro-drift"])


@pytest.mark.suite
@pytest.mark.parametrize("seed", [1192, 1197])
def test_a_fit_to_the_wrong_minimum_is_no_missing_effect(tmp_path, seed):
    trace = trace_folder(null_campaign(tmp_path, seed))
    assert (trace.verdict, trace.effects) == ("nothing-missing", ())
    stage = wrist(trace)
    assert trace.fit.fit_rmse["angle_deg"] == pytest.approx(
        np.std(stage.model.residual) * stage.stage.noise, rel=0.05
    )
