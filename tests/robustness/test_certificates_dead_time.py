"""With dead time, a linear loop is certified up to its delay margin, and not beyond."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.continuous import check, lmi, popov, quadratic
from design.robustness.certificates.continuous.search import confirmed, program, search
from design.robustness.certificates.continuous.signals import LoopSignals
from design.robustness.loop_model import LoopModel
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime

TW = 0.16


def delay_margin(Kp: float, Ki: float, slope: float, rate: float) -> float:
    """By python-control: phase margin over its crossing frequency, the least over all crossings."""
    import control

    p = control.tf("s")
    loop = (Kp + Ki / p) * rate / (p + rate) * slope / (TW * p + 1.0)
    _, pm, _, _, wc, _ = control.stability_margins(loop, returnall=True)
    return float(np.min(np.mod(np.radians(pm), 2.0 * np.pi) / wc))


@pytest.mark.parametrize("rung", [quadratic.RUNG, popov.RUNG])
@pytest.mark.parametrize(
    ("Kp", "Ki", "slope", "rate"), [(3.13, 10.4, 0.36, 9.0), (6.0, 10.0, 0.36, 9.0), (2.0, 6.0, 0.36, 2.0)]
)
def test_a_linear_loop_is_certified_to_its_delay_margin(
    Kp: float, Ki: float, slope: float, rate: float, rung: str
) -> None:
    model = LoopModel(Kp, Ki, {"only": slope}, rate, rate, TW)
    margin = delay_margin(Kp, Ki, slope, rate)
    assert search(model, rung, dead_time=0.99 * margin).form is not None
    assert search(model, rung, dead_time=1.01 * margin).form is None


def test_dead_time_of_the_plant_and_beside_it_add_up() -> None:
    wrist = Wrist.flexion() + DeadTime(0.03)
    late = search(LoopModel.of(wrist, PI(1.2, 2.2)), popov.RUNG, dead_time=0.02).form
    same = search(LoopModel.of(Wrist.flexion(), PI(1.2, 2.2)), popov.RUNG, dead_time=0.05).form
    assert late is not None
    assert same is not None
    assert np.allclose(late.P, same.P)


def test_moments_move_as_the_transport_says() -> None:
    """Z_k of z = exp(p t) in closed form of Legendre's polynomials, by quadrature."""
    model, tau, p = LoopModel(2.0, 3.0, {"only": 0.36}, 2.0, 2.0, TW), 0.2, -1.3
    signals = LoopSignals.of(model, tau, open_law=False, order=4)
    s, w = np.polynomial.legendre.leggauss(40)
    z = np.exp(-p * tau * (s + 1.0) / 2.0)
    Z = np.array([0.5 * np.sum(w * z * np.polynomial.legendre.Legendre.basis(k)(s)) for k in range(4)])
    x0 = 1.0 / model.Ki  # so that z = Ki x0 is 1 now
    vector = np.concatenate([[x0, 0.0, 0.0], Z, [np.exp(-p * tau)]])
    # The derivative of the first four moments of an exponential is p times themselves.
    assert np.allclose((signals.rate(0.36, 2.0) @ vector)[3:], p * Z, atol=1e-12)


@pytest.mark.parametrize("decay", [0.0, 0.7])
def test_what_is_under_way_changes_as_its_integrals_do(decay: float) -> None:
    """S int z^2 + R int (1 - s) z^2 over the dead time, of a polynomial z, of which the moments have all:
    what sets out comes in, what arrives goes out, and the decay adds both integrals at most."""
    model, tau = LoopModel(2.0, 3.0, {"only": 0.36}, 2.0, 2.0, TW), 0.2
    signals = LoopSignals.of(model, tau, open_law=False, order=4)
    s, w = np.polynomial.legendre.leggauss(20)
    for coefficients in np.random.default_rng(2).standard_normal((4, 4)):
        z = np.polynomial.legendre.Legendre(coefficients)
        sent, arrived = float(z(-1.0)), float(z(1.0))  # from the newest to the oldest
        Z = [0.5 * np.sum(w * z(s) * np.polynomial.legendre.Legendre.basis(k)(s)) for k in range(4)]
        vector = np.concatenate([[sent / model.Ki, 0.0, 0.0], Z, [arrived]])
        whole = 0.5 * np.sum(w * z(s) ** 2)
        found = {n: vector @ m @ vector for n, m in quadratic.transport(signals, decay).items()}
        assert found["S"] == pytest.approx((sent**2 - arrived**2) / tau + 2.0 * decay * whole)
        assert found["R"] == pytest.approx((sent**2 - whole) / tau + 2.0 * decay * whole)
        for sign in (-1.0, 1.0):  # each bound is one where what it leaves out has the right sign
            price = quadratic.paid(signals, sign * decay)[0]
            assert price["R"] == pytest.approx(1.0 / tau - sign * 2.0 * decay)
            assert price["S"] == pytest.approx(-sign * 2.0 * decay)


def test_one_moment_is_enough_for_a_short_dead_time() -> None:
    model, tau = LoopModel(2.0, 3.0, {"only": 0.36}, 2.0, 2.0, TW), 0.02
    signals = LoopSignals.of(model, tau, open_law=False, order=1)
    u = program(signals, quadratic.RUNG, 0.0, signals.scale)
    found = confirmed(lambda: lmi.widest(u), signals, quadratic.RUNG, 0.0, tau)
    assert found.form is not None
    assert found.form.order == 1
    assert check.margin(found.form, model, tau) > check.CONFIRMED
    assert check.margin(found.form, model, 0.0) < 0.0
