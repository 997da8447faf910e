"""Gains for a list of systems of python-control hold their limits by python-control's own margins."""

import control
import numpy as np
import pytest

from design.synthesis.tune_pi import MarginLimits, margins_of, tune_pi
from plants.errors import InputError

s = control.tf("s")
PLANTS = [1.0 / (s + 1) ** 3, 1.5 / ((s + 1) * (0.3 * s + 1) ** 2), 0.7 / ((2 * s + 1) * (0.2 * s + 1) ** 3)]
SAMPLED = [control.sample_system(control.ss(p), 0.05, "zoh") for p in PLANTS]


def loop(plant, Kp, Ki):
    if plant.isdtime(strict=True):
        return plant * control.tf([Kp, Ki * plant.dt - Kp], [1.0, -1.0], plant.dt)
    return plant * control.tf([Kp, Ki], [1.0, 0.0])


@pytest.mark.slow
@pytest.mark.parametrize("plants", [PLANTS, SAMPLED, PLANTS[:1]], ids=["continuous", "discrete", "one"])
@pytest.mark.filterwarnings("ignore")  # of python-control's conversions
def test_margins_are_those_of_python_control_and_within_the_limits(plants):
    limits = MarginLimits(Ms=1.6, gain_margin=2.5, phase_margin_deg=45.0)
    found = tune_pi(plants, limits)
    for plant, held in zip(plants, found.margins, strict=True):
        open_loop = loop(plant, found.Kp, found.Ki)
        gain, phase, distance, _, crossing, _ = control.stability_margins(open_loop)
        assert held.gain_margin == pytest.approx(gain, rel=2e-3)
        assert held.phase_margin_deg == pytest.approx(phase, rel=2e-3)
        assert held.Ms == pytest.approx(1.0 / distance, rel=2e-3)
        assert held.delay_margin_s == pytest.approx(np.radians(phase) / crossing, rel=2e-3)
        poles = control.feedback(open_loop, 1).poles()
        assert np.all(np.abs(poles) < 1.0 if plant.isdtime(strict=True) else poles.real < 0.0)
        assert 1.0 / distance <= 1.6 * 1.002
        assert gain >= 2.5 * 0.998
        assert phase >= 45.0 * 0.998


@pytest.mark.slow
def test_the_integral_gain_is_the_largest_under_a_bound_on_the_sensitivity():
    """Against the plain search of the definition: the first Ki, at each Kp, at which Ms is at its limit."""
    plant, omega = PLANTS[0], np.geomspace(1e-3, 1e2, 4000)
    response = plant(1j * omega)

    def first(Kp):
        Ki = np.linspace(0.01, 1.5, 600)
        peaks = np.max(1.0 / np.abs(1.0 + (Kp + Ki[:, None] / (1j * omega)) * response), axis=1)
        return Ki[int(np.argmax(peaks > 1.6))] if peaks[0] <= 1.6 else 0.0

    most = max(first(Kp) for Kp in np.linspace(0.3, 1.2, 61))
    assert tune_pi([plant], MarginLimits(Ms=1.6)).Ki == pytest.approx(most, rel=1e-2)


@pytest.mark.slow
def test_dead_time_counts_as_its_long_pade_form_does():
    late = 0.4
    found = tune_pi([PLANTS[1]], MarginLimits(Ms=1.5), dead_times=late)
    pade = control.tf(*control.pade(late, 8))
    gain, phase, distance, *_ = control.stability_margins(loop(PLANTS[1] * pade, found.Kp, found.Ki))
    (held,) = found.margins
    assert (held.gain_margin, held.phase_margin_deg) == pytest.approx((gain, phase), rel=5e-3)
    assert held.Ms == pytest.approx(1.0 / distance, rel=5e-3)


def test_a_plant_of_negative_gain_gets_negative_gains():
    found = tune_pi([-PLANTS[0]])
    assert found.Kp < 0.0
    assert found.Ki < 0.0
    assert found.margins[0].stable


def test_an_unstable_loop_is_called_so():
    assert not margins_of(PLANTS[0], 10.0, 5.0).stable


@pytest.mark.parametrize(
    ("systems", "limits", "said"),
    [
        ([], None, "none given"),
        ([3.0], None, "no transfer function"),
        ([control.ss(np.eye(2), np.eye(2), np.eye(2), 0)], None, "several inputs"),
        ([PLANTS[0], -PLANTS[1]], None, "differ in sign"),
        ([PLANTS[0], 1e6 * PLANTS[0]], MarginLimits(phase_margin_deg=170.0), "no gains hold them"),
    ],
)
def test_what_cannot_be_tuned_is_refused(systems, limits, said):
    with pytest.raises(InputError, match=said):
        tune_pi(systems, limits)
