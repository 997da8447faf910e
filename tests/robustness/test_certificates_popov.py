"""Popov's rung agrees with his criterion in the frequency domain, and its V falls along trajectories."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

from design.controllers.pi import PI
from design.robustness.certificates.continuous import popov
from design.robustness.certificates.continuous.form import Form
from design.robustness.certificates.continuous.search import fastest, search
from design.robustness.loop_model import LoopModel
from plants import Wrist

OMEGA = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 4001)])


def criterion(Kp: float, Ki: float, slope: float, k_slow: float, k_fast: float, Tw: float) -> float:
    """Largest m with 1/kappa + Re (1 + j omega eta) G(j omega) >= m for an eta >= 0, where q = -G psi,
    from transfer functions alone; positive where Popov's criterion is met."""
    p = 1j * OMEGA[1:]
    plant = (Kp + Ki / p) * slope / (Tw * p + 1.0) / p  # psi to the command's pressure, and back
    G = (1.0 / p + plant) / (1.0 + k_slow * (1.0 / p + plant))
    G = np.concatenate([[1.0 / k_slow], G])
    # max m subject to m - eta Re(j omega G) <= 1/kappa + Re G
    turned = (1j * OMEGA * G).real
    weight = 1.0 + OMEGA  # high frequencies on the scale of eta
    found = linprog(
        [-1.0, 0.0],
        A_ub=np.column_stack([np.ones_like(OMEGA), -turned / weight]),
        b_ub=(1.0 / (k_fast - k_slow) + G.real) / weight,
        bounds=[(None, 1.0), (0.0, None)],
    )
    return float(-found.fun)


@pytest.mark.parametrize("slope", [0.0803, 0.36])
@pytest.mark.parametrize("Kp", [0.6, 2.3, 9.0])
def test_one_slope_is_certified_where_the_criterion_is_met(Kp: float, slope: float) -> None:
    outcomes = set()
    for Ki in Kp * np.geomspace(0.3, 40.0, 8):
        met = criterion(Kp, float(Ki), slope, 0.55, 9.0, 0.16)
        model = LoopModel(Kp, float(Ki), {"only": slope}, 0.55, 9.0, 0.16)
        if abs(met) > 1e-4:  # at the border the two may differ by rounding
            assert (search(model, popov.RUNG).form is not None) == (met > 0.0), (Kp, Ki, met)
            outcomes.add(met > 0.0)
    assert True in outcomes


@pytest.mark.parametrize("gains", [(1.2, 2.2), (6.0, 10.0)])
def test_V_falls_at_the_rate_claimed_whatever_the_slope_does(gains: tuple[float, float]) -> None:
    model = LoopModel.of(Wrist.flexion(), PI(*gains))
    form = fastest(model, popov.RUNG).form
    assert form is not None
    assert form.decay > 0.0
    random = np.random.default_rng(7)
    e0 = 5.0
    for _ in range(5):
        switches = np.cumsum(random.exponential(0.1, 40))
        slopes = random.choice(list(model.slopes.values()), 41)
        x, t, before = random.normal(size=3) * [5.0, 5.0, 20.0], 0.0, np.inf
        for end, slope in zip(switches, slopes, strict=False):
            x = solve_ivp(_field, (t, end), x, args=(model, slope, e0), rtol=1e-9, atol=1e-12).y[:, -1]
            after = _value(form, model, x, e0) * np.exp(2.0 * form.decay * end)
            assert after <= before * (1.0 + 1e-7)
            before, t = after, end


def _field(_t: float, x: np.ndarray, model: LoopModel, slope: float, e0: float) -> list[float]:
    e, ahead, q = x
    flow = (model.k_slow + (model.k_fast - model.k_slow) * q * q / (q * q + e0 * e0)) * q
    angle = ahead / model.Tw
    return [-angle, slope * flow - angle, model.Ki * e - model.Kp * angle - flow]


def _value(form: Form, model: LoopModel, x: np.ndarray, e0: float) -> float:
    """x' P x + 2 lambda int psi, the integral in closed form."""
    q2 = x[2] ** 2
    integral = (model.k_fast - model.k_slow) * 0.5 * (q2 - e0**2 * np.log1p(q2 / e0**2))
    return float(x @ form.P @ x + 2.0 * form.popov * integral)
