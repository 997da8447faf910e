"""What is tied to a variable, to time, periodic, in events, or of changing size is found, and named."""

import numpy as np
import pytest

from plants.measured.residual.examine import examine
from tests.residual.made import noise, with_structure


def drift(r, rng):
    return r.value + 1.5 * r.time / 136.0


def sinusoid(frequency):
    return lambda r, rng: r.value + 0.5 * np.sin(2.0 * np.pi * frequency * r.time + rng.uniform(0.0, 6.0))


def events(r, rng):
    value = r.value.copy()
    for at in rng.integers(100, len(value) - 100, 2):
        value[at : at + 50] += 3.0 * rng.choice([-1.0, 1.0])
    return value


def wander(r, rng):
    return r.value + 0.03 * np.cumsum(rng.standard_normal(len(r.value)))


def louder_with_speed(r, rng):
    return r.value * (1.0 + np.minimum(np.abs(r.variables["pressure_rate_kPa_s"]) / 50.0, 2.0))


def louder_with_time(r, rng):
    return r.value * (1.0 + 0.5 * r.time / 136.0)


def bursts(r, rng):
    value = r.value.copy()
    for at in rng.integers(0, len(value) - 60, len(value) // 800):
        value[at : at + 50] *= 3.0
    return value


def on(variable, low, high):
    def change(r, rng):
        x = np.clip((r.variables[variable] - low) / (high - low), 0.0, 1.0)
        return r.value + 0.4 * np.cos(np.pi * x)

    return change


def on_an_extra_channel(r, rng):
    # Logged temperature that warms up and cools down, in no relation to what the wrist does.
    value = 20.0 + 5.0 * np.sin(r.time / 3.7 + len(r.time))
    r.variables["temperature_C"] = value
    return r.value + 0.4 * np.tanh(value - 20.0)


# Where noise is coloured, two variables that run together may change places.
TOGETHER = {"pressure_kPa": {"pressure_kPa", "angle_deg"}, "angle_deg": {"pressure_kPa", "angle_deg"}}


@pytest.mark.slow
@pytest.mark.parametrize("memory", [0.0, 0.05])
@pytest.mark.parametrize(
    ("change", "name"),
    [
        (drift, "time"),
        (sinusoid(0.4), "periodic at 0.4 Hz"),
        (sinusoid(2.31), "periodic at 2.31 Hz"),
        (sinusoid(17.0), "periodic at 17 Hz"),
        (events, "events"),
        (wander, "time"),
        (louder_with_speed, "changing size"),
        (louder_with_time, "changing size"),
        (bursts, "changing size"),
        (on("pressure_kPa", 0.0, 200.0), "pressure_kPa"),
        (on("direction", -1.0, 1.0), "direction"),
        (on("angle_deg", -20.0, 20.0), "angle_deg"),
        (on("other_pressure_kPa", 40.0, 170.0), "other_pressure_kPa"),
        (on("since_reversal_s", 0.0, 4.0), "since_reversal_s"),
    ],
)
def test_structure_is_found_and_named_first(change, name, memory):
    for seed in range(2):
        found = examine(with_structure(noise(seed, memory), change, seed))
        assert found.structured, seed
        allowed = TOGETHER.get(name, {name}) if memory else {name}
        assert found.depends_on[0] in allowed, (seed, found.depends_on)


def test_a_channel_that_only_the_rig_knows_is_named():
    remainders = noise(5)
    remainders = [type(r)(**{**vars(r), "variables": dict(r.variables)}) for r in remainders]
    found = examine(with_structure(remainders, on_an_extra_channel))
    assert found.depends_on[0] == "temperature_C"
    assert "temperature_C" in found.curves


def test_an_offset_is_named_where_there_is_nothing_else():
    assert examine(with_structure(noise(1), lambda r, rng: r.value + 0.3)).depends_on == ("offset",)


def test_a_late_answer_to_the_command_is_tied_to_it():
    """Dead time leaves a pulse after every jump of the command, as large as the jump."""

    def late(r, rng):
        jumps = np.diff(r.variables["command_V"], prepend=r.variables["command_V"][0])
        return r.value - 4.0 * np.convolve(jumps, np.exp(-np.arange(60) / 15.0))[: len(jumps)]

    found = examine(with_structure(noise(2), late))
    assert {"command_V", "pressure_rate_kPa_s"} & set(found.depends_on[:2])
    crossed = next(f for f in found.findings if f.test == "cross-correlation" and f.variable == "command_V")
    assert crossed.statistic > crossed.bound
    curve = found.curves["correlation with command_V"]
    assert 0.0 <= curve.centre[np.argmax(np.abs(curve.mean))] < 0.1
    assert np.mean(np.abs(curve.mean) > curve.high) > 0.05


def test_two_structures_are_both_named():
    change = on("pressure_kPa", 0.0, 200.0)
    both = with_structure(with_structure(noise(3), change), sinusoid(2.31))
    assert set(examine(both).depends_on) == {"pressure_kPa", "periodic at 2.31 Hz"}


def test_the_share_is_the_part_of_the_variance():
    found = examine(with_structure(noise(4), sinusoid(2.31)))
    line = next(f for f in found.findings if f.test == "periodic")
    assert line.share == pytest.approx(0.125 / 1.125, rel=0.1)
    assert found.ratio == pytest.approx(1.125**0.5, rel=0.01)
    assert found.rmse == pytest.approx(found.ratio * found.noise)
    assert line.p_value < 1e-10 < 1.0 < line.statistic / line.bound


@pytest.mark.parametrize(("size", "first"), [(0.25, "pressure_kPa"), (0.7, "periodic at 2.31 Hz")])
def test_what_accounts_for_more_is_named_first(size, first):
    def wave(r, rng):
        return r.value + size * np.sin(2.0 * np.pi * 2.31 * r.time)

    both = with_structure(with_structure(noise(6), on("pressure_kPa", 0.0, 200.0)), wave)
    found = examine(both).depends_on
    assert len(found) == 2
    assert found[0] == first


def test_the_spectrum_is_a_density_that_sums_to_the_variance():
    remainders = with_structure(noise(4), sinusoid(2.31))
    curve = examine(remainders).curves["spectrum"]
    value = np.concatenate([r.value for r in remainders])
    total = float(np.sum(curve.mean) * (curve.centre[1] - curve.centre[0]))
    assert total == pytest.approx(np.var(value), rel=0.02)
    assert not curve.low.any()  # of a power there is no low bound but 0
    assert curve.centre[np.argmax(curve.mean - curve.high)] == pytest.approx(2.31, abs=0.01)
