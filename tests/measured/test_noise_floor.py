"""The noise floor: white noise as ever, noise with a memory where the command was still for long."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import norm, truncnorm

import plants.measured
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import _without_hum, is_coloured, noise_of
from plants.measured.residual.stillness import bent, noise_of_campaign, still_rows

EXAMPLES = Path(plants.measured.__file__).parent / "examples"
DT = 0.01
LEVELS = [100.0, 150.0, 197.0, 150.0, 100.0, 50.0, 0.0, 50.0] * 2 + [100.0]


def coloured(rows: int, memory: float, rng: np.random.Generator) -> np.ndarray:
    if memory == 0.0:
        return rng.standard_normal(rows)
    keep = np.exp(-DT / memory)
    start = [keep * rng.standard_normal()]
    return lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(rows), zi=start)[0]


def staircase(seed: int, memory: float, hold: float = 8.0) -> list[Recording]:
    """A staircase whose angle settles slowly, with noise of 0.06 deg of a correlation time [s]."""
    rng = np.random.default_rng([seed, round(memory * 1000)])
    command = np.repeat(LEVELS, round(hold / DT)) / 49.4
    keep = np.exp(-DT / 0.6)
    angle = 0.25 * lfilter([1.0 - keep], [1.0, -keep], 49.4 * command - 100.0)
    noise = 0.06 * coloured(len(command), memory, rng)
    return [Recording("r", np.arange(len(command)) * DT, command, angle + noise)]


def spoiled(recordings: list[Recording], added) -> list[Recording]:
    return [replace(r, angle=r.angle + added(r.time)) for r in recordings]


def test_white_noise_keeps_the_floor_that_it_had():
    for axis in ("flexion", "deviation"):
        campaign = load_campaign(EXAMPLES / axis)
        for channel, of in (("angle_deg", lambda r: r.angle), ("pressure_kPa", lambda r: r.pressure)):
            recordings = (*campaign.fit, *campaign.validate)
            assert noise_of_campaign(recordings, channel) == noise_of([of(r) for r in recordings])
    made = staircase(1, 0.0)
    assert noise_of_campaign(made, "angle_deg") == noise_of([made[0].angle])


@pytest.mark.parametrize(
    ("memory", "tolerance"), [(0.02, 0.10), (0.05, 0.10), (0.1, 0.10), (0.2, 0.15), (0.5, 0.22)]
)
def test_noise_with_a_memory_is_found_whole(memory, tolerance):
    ratios = [noise_of_campaign(staircase(seed, memory), "angle_deg") / 0.06 for seed in range(8)]
    assert max(abs(r - 1.0) for r in ratios) < tolerance
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.06)
    assert noise_of([staircase(0, memory)[0].angle]) < 0.85 * 0.06  # what differences see of it


@pytest.mark.parametrize("memory", [0.0, 0.1])
@pytest.mark.parametrize(
    "added",
    [
        lambda t: 0.05 * t,
        lambda t: 0.5 * np.sin(2.0 * np.pi * 0.8 * t),
        lambda t: 0.5 * np.sin(2.0 * np.pi * 3.0 * t) + 0.1 * np.sin(2.0 * np.pi * 6.0 * t),
        lambda t: 1.5 * np.log1p(np.mod(t, 8.0) / 0.5),
        lambda t: np.where(t > 69.0, 2.0, 0.0),
    ],
    ids=["drift", "slow hum", "hum with a harmonic", "creep", "load step"],
)
def test_effects_do_not_pass_for_noise(added, memory):
    ratios = [noise_of_campaign(spoiled(staircase(s, memory), added), "angle_deg") / 0.06 for s in range(4)]
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1 if memory else 0.03)


def test_without_long_holds_the_white_floor_is_kept():
    made = staircase(1, 0.1, hold=2.0)
    assert noise_of_campaign(made, "angle_deg") == noise_of([made[0].angle])


def test_a_channel_that_was_not_logged_has_no_floor():
    assert noise_of_campaign(staircase(1, 0.0), "pressure_kPa") is None
    extra = [replace(r, extra={"load_N": r.angle}) for r in staircase(1, 0.0)]
    assert noise_of_campaign(extra, "load_N") == noise_of([extra[0].angle])


def test_still_rows_begin_three_seconds_after_the_command_moved():
    time = np.arange(1000) * DT
    command = np.where(time < 5.0, 2.0, 3.0) + 0.0005 * (-1.0) ** np.arange(1000)
    assert still_rows(Recording("r", time, command)) == [slice(300, 500), slice(800, 1000)]
    assert still_rows(Recording("r", time, 2.0 + 0.1 * time)) == []


def test_colour_is_told_with_certainty_only():
    rng = np.random.default_rng(2)
    for _ in range(50):
        assert not is_coloured([rng.standard_normal(500)])
    assert is_coloured([coloured(500, 0.1, rng)])
    assert not is_coloured([np.zeros(10)])


def test_a_slow_trend_is_taken_off():
    x = np.linspace(0.0, 1.0, 50)
    assert bent(3.0 - x + 2.0 * x**2) == pytest.approx(np.zeros(50), abs=1e-12)


def test_a_channel_that_stands_still_has_no_coloured_noise():
    """Its differences are 0, as are those of a noise that is smaller than the quantum."""
    assert not is_coloured([np.ones(500), np.zeros(300)])
    assert noise_of([np.ones(500)]) == 0.0


@pytest.mark.parametrize("scale", [2.0**-12, 2.0**12])
def test_a_channel_in_another_unit_has_the_same_floor_in_that_unit(scale):
    """To the bit, for powers of 2: of white noise on jumps and a hum, and of noise with a memory."""
    rng, time = np.random.default_rng(5), np.arange(4000) * DT
    hum = 0.3 * np.sin(2.0 * np.pi * 7.0 * time) + 0.06 * rng.standard_normal(4000)
    jumps = hum + 5.0 * np.sign(np.sin(2.0 * np.pi * 1.3 * time))
    assert noise_of([scale * jumps]) == scale * noise_of([jumps])
    (made,) = staircase(3, 0.1)
    whole = noise_of_campaign([made], "angle_deg")
    assert noise_of_campaign([replace(made, angle=scale * made.angle)], "angle_deg") == scale * whole
    assert is_coloured([scale * coloured(500, 0.1, np.random.default_rng(2))])


def test_of_few_differences_the_four_smaller_count():
    """Of eight values there are five third differences; the largest, of a jump, is left out."""
    third = np.array([1.0, -2.0, 3.0, -4.0, 100.0])
    values = np.concatenate([np.zeros(3), third])
    for _ in range(3):
        values = np.cumsum(values)
    np.testing.assert_allclose(np.diff(values, 3), third)
    cut = norm.ppf(0.95)
    expected = np.sqrt(np.mean(third[:4] ** 2) / truncnorm(-cut, cut).var() / 20.0)
    assert noise_of([values]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("times", "taken"), [(25.0, False), (60.0, True)])
def test_a_hum_is_taken_out_of_differences_from_forty_times_the_power_around_it(times, taken):
    """A wave of amplitude A stands A^2 n / 4 above white noise of 1 in n values."""
    rows, phase = 4000, 2.0 * np.pi * 0.137 * np.arange(4000)
    left = []
    for seed in range(5):
        wave = np.sqrt(4.0 * times / rows) * np.sin(phase)
        found = _without_hum(np.random.default_rng(seed).standard_normal(rows) + wave)
        left.append(abs(np.exp(1j * phase) @ found) ** 2 / rows)
    assert (np.median(left) < 5.0) == taken


@pytest.mark.parametrize("louder", ["slower", "faster"])
@pytest.mark.parametrize(("times", "taken"), [(25.0, False), (60.0, True)])
def test_the_power_around_a_hum_is_that_on_both_sides(louder, times, taken):
    """Of noise of power 19 on one side and 1 on the other, which is 10 around it."""
    rows, phase, left = 4000, 2.0 * np.pi * 0.137 * np.arange(4000), []
    beyond = np.fft.rfftfreq(rows) > 0.137
    power = np.where(beyond == (louder == "faster"), 19.0, 1.0)
    for seed in range(5):
        white = np.random.default_rng(seed).standard_normal(rows)
        noise = np.fft.irfft(np.sqrt(power) * np.fft.rfft(white), rows)
        wave = np.sqrt(10.0 * 4.0 * times / rows) * np.sin(phase)
        found = _without_hum(noise + wave)
        left.append(abs(np.exp(1j * phase) @ found) ** 2 / rows)
    assert (np.median(left) < 50.0) == taken


def test_of_differences_below_four_deviations_a_hum_is_taken_out_by_least_squares():
    rows, cycles = 4000, 548
    phase = 2.0 * np.pi * cycles / rows * np.arange(rows)
    x = np.clip(np.random.default_rng(1).standard_normal(rows), -3.0, 3.0) + 0.6 * np.sin(phase + 0.3)
    waves = np.column_stack([np.sin(phase), np.cos(phase)])
    expected = x - waves @ np.linalg.lstsq(waves, x, rcond=None)[0]
    np.testing.assert_allclose(_without_hum(x), expected, atol=1e-9)


def test_jumps_in_step_are_cut_at_four_deviations_and_are_no_hum():
    """Of 30 deviations, one in 50 rows: cut, they stand 26 times above the noise, at eight deviations 102."""
    x = np.random.default_rng(3).standard_normal(4000)
    x[::50] += 30.0
    np.testing.assert_array_equal(_without_hum(x), x)
