"""Drift and hum are added to what is measured, and to nothing else."""

import numpy as np
import pytest
from scipy.integrate import quad

from plants.effects import EFFECTS, Drift, HarmonicHum, Hum, WarmingDrift
from tests.laws.effect_steps import DT, WRIST, played

VOLTS = np.repeat([3.0, 2.0], 300)
TIME = np.arange(601) * DT


@pytest.mark.parametrize(
    ("effect", "added"),
    [
        (Drift(0.5), 0.5 * TIME),
        (Hum(7.0, 0.2, -0.1), 0.2 * np.sin(14 * np.pi * TIME) - 0.1 * np.cos(14 * np.pi * TIME)),
        (
            HarmonicHum(3.0, 0.2, 0.1, -0.3, 0.4),
            0.2 * np.sin(6 * np.pi * TIME) + 0.1 * np.cos(6 * np.pi * TIME)
            - 0.3 * np.sin(12 * np.pi * TIME) + 0.4 * np.cos(12 * np.pi * TIME),
        ),
    ],
    ids=lambda v: v.FORM if hasattr(v, "FORM") else "",
)  # fmt: skip
def test_the_reading_is_off_by_the_formula_and_the_joint_is_not(effect, added):
    pressure, angle, seen = played(WRIST + effect, VOLTS)
    plain = played(WRIST, VOLTS)
    np.testing.assert_array_equal([pressure, angle], plain[:2])
    np.testing.assert_allclose(seen - angle, added, atol=1e-12)


def test_a_drift_while_warming_up_is_the_integral_of_its_rate():
    effect = WarmingDrift(0.02, 0.5, 0.2)
    _, angle, seen = played(WRIST + effect, VOLTS)
    for k in (0, 100, 600):
        total, _ = quad(lambda t: 0.02 + 0.5 * np.exp(-t / 0.2), 0.0, k * DT)
        assert seen[k] - angle[k] == pytest.approx(total, abs=1e-10)


def test_the_compiled_wrist_shows_the_same():
    wrist = WRIST + Drift(0.5) + Hum(7.0, 0.2, -0.1)
    _, _, seen = played(wrist, VOLTS)
    np.testing.assert_allclose(wrist.simulate(VOLTS).angle, seen, atol=1e-12)


def test_a_sensor_that_drifts_wanders_and_no_other_effect_does():
    """The trace forgives a residual that wanders, but not of a rig without such a sensor."""
    wandering = {form for forms in EFFECTS.values() for form in forms if form.WANDERS}
    assert wandering == {Drift, WarmingDrift}
