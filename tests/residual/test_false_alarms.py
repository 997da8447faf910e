"""Sensor noise is no missing effect: white, coloured, rounded, heavy-tailed, with parameters a little off."""

from dataclasses import replace

import numpy as np
import pytest

from plants.measured.fitting.noise import noise_of
from plants.measured.residual.battery import make_tests
from plants.measured.residual.examine import examine
from plants.measured.residual.series.joined import join
from tests.residual.made import RUNS, VARIABLES, noise, with_structure


@pytest.mark.slow
@pytest.mark.parametrize("memory", [0.0, 0.02, 0.1, 0.5])
@pytest.mark.parametrize("half", [0, 1])
def test_noise_of_any_colour_is_not_structured(memory, half):
    for seed in range(5 * half, 5 * half + 5):
        found = examine(noise(seed, memory))
        assert not found.structured, (seed, found.findings[:3])
        assert found.depends_on == ()


@pytest.mark.parametrize("step", [0.5, 2.0, 5.0])
def test_rounded_noise_is_not_structured(step):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        angles = [np.round((r.angle + rng.standard_normal(len(r.time))) / step) * step for r in RUNS]
        floor = noise_of(angles)
        remainders = [
            replace(n, value=a - r.angle, noise=floor, resolution=step)
            for n, a, r in zip(noise(seed), angles, RUNS, strict=True)
        ]
        found = examine(remainders)
        assert not found.structured, (seed, found.findings[:3])


def test_noise_with_heavy_tails_is_not_structured():
    for seed in range(4):
        heavy = with_structure(noise(seed), lambda r, rng: rng.standard_t(4, len(r.value)) / 2.0**0.5, seed)
        assert not examine(heavy).structured, seed


def test_a_noise_floor_that_is_too_low_raises_no_alarm():
    # The floor of strongly coloured noise may be missed; the bounds come from the remainder's own spectrum.
    for seed in range(5):
        assert not examine([replace(r, noise=0.2) for r in noise(seed, 0.3)]).structured, seed


def test_a_misfit_within_the_errors_of_parameters_is_too_small_to_matter():
    # Thirty parameters, each off by what noise of 28,000 rows leaves of it, carry a thousandth of it.
    def off(r, rng):
        columns = np.stack([np.sin(k * r.variables["pressure_kPa"] / 40.0) for k in range(1, 31)])
        return r.value + rng.standard_normal(30) @ columns * (2.0 / 28_000) ** 0.5

    for seed in range(4):
        assert not examine(with_structure(noise(seed), off, seed)).structured, seed


def test_bounds_hold_at_the_level_they_state():
    """Of tests at 5 and 1 %, about so many fail on noise; the bounds may be wider, not narrower."""
    p = []
    for memory in (0.0, 0.1, 0.5):
        for seed in range(3):
            battery = make_tests(join(noise(100 + seed, memory)), 1.0, seed)
            p += [e.p_value for (kind, _), e in battery.evidence.items() if kind != "whiteness"]
    p = np.array(p)
    assert len(p) > 200
    assert np.mean(p < 0.05) < 0.09
    assert np.mean(p < 0.01) < 0.03
    assert np.min(p) > 1e-5


def test_variables_of_the_draws_are_the_ones_of_a_wrist():
    assert {"pressure_kPa", "direction", "since_reversal_s", "other_pressure_kPa"} <= set(VARIABLES[0])
