"""What a remainder is plotted against, by hand on small cases."""

import numpy as np
import pytest

from plants.measured.campaigns.recording import Recording
from plants.measured.residual.series.remainder import direction, remainder_of, variables


def test_direction_and_time_since_it_turned():
    pressure = np.array([100.0, 100.0, 101.0, 103.0, 103.0, 102.0, 100.0, 100.0, 104.0])
    heading, since = direction(np.arange(9.0), pressure)
    assert heading.tolist() == [0, 0, 1, 1, 1, -1, -1, -1, 1]
    # Since the start, then since it last stood: at 1 s, at 4 s, at 7 s.
    assert since.tolist() == [0, 1, 1, 2, 3, 1, 2, 3, 1]


def test_ripple_is_no_turn():
    pressure = 100.0 + np.arange(50.0) + 0.04 * (-1.0) ** np.arange(50)
    assert set(direction(np.arange(50.0), pressure)[0][1:]) == {1.0}
    still = 100.0 + 0.02 * (-1.0) ** np.arange(50)
    assert set(direction(np.arange(50.0), still)[0]) == {0.0}


def recording(**changes):
    n = 30
    fields = {
        "name": "r.csv", "time": 5.0 + np.arange(n) * 0.1, "command": np.linspace(0.0, 4.0, n),
        "angle": np.round(np.linspace(0.0, 3.0, n), 1), "pressure": np.linspace(100.0, 130.0, n),
        "other_pressure": np.full(n, 90.0), "extra": {"load_N": np.arange(n) * 2.0},
    }  # fmt: skip
    return Recording(**(fields | changes))


def test_variables_of_a_recording():
    r = recording()
    pressure = np.append(np.linspace(100.0, 129.0, 29), 120.0)
    found = variables(r, pressure, np.zeros(30))
    assert found["time_s"][0] == 0.0
    assert found["work_kPa"][-1] == pytest.approx(29.0 + 9.0)
    assert found["pressure_rate_kPa_s"][3] == pytest.approx(290.0 / 28.0)
    assert found["load_N"][-1] == 58.0
    assert found["command_V"] is r.command
    assert {"pressure_kPa", "direction", "angle_deg", "since_reversal_s", "other_pressure_kPa"} <= set(found)
    assert all(v.shape == (30,) for v in found.values())


def test_nothing_measured_of_the_simulated_channels_is_among_the_variables():
    # The noise of a measured pressure would correlate with the remainder.
    r = recording()
    simulated = np.full(30, 110.0)
    loud = recording(pressure=r.pressure + 5.0, angle=r.angle - 5.0)
    quiet, noisy = variables(r, simulated, simulated), variables(loud, simulated, simulated)
    assert all(np.array_equal(quiet[n], noisy[n]) for n in quiet)


def test_what_was_not_logged_is_left_out():
    found = variables(recording(other_pressure=None, reference=np.zeros(30)), np.full(30, 100.0), None)
    assert "angle_deg" not in found
    assert "other_pressure_kPa" not in found
    assert "reference_deg" in found


def test_remainder_is_measured_less_simulated_and_knows_the_rounding():
    r = recording()
    left = remainder_of(r, "wrist", np.full(30, 100.0), np.ones(30), 0.1)
    assert left.value == pytest.approx(r.angle - 1.0)
    assert left.resolution == pytest.approx(0.1)
    assert remainder_of(r, "regulator", np.full(30, 100.0), None, 0.1).value[0] == 0.0
    with pytest.raises(ValueError, match="not measured"):
        remainder_of(recording(angle=None), "wrist", np.ones(30), np.ones(30), 0.1)
    with pytest.raises(ValueError, match="not simulated"):
        remainder_of(r, "wrist", np.ones(30), None, 0.1)
