"""What a dead time has under way: its moments, and what a certificate pays for it."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import quad

from design.robustness.certificates.continuous import check
from design.robustness.certificates.continuous.quadratic import common_quadratic, paid, transport
from design.robustness.certificates.continuous.signals import LoopSignals
from design.robustness.loop_model import LoopModel

TAU = 0.15


def moments(z, t, order):
    """Of the signal over the dead time before t: int_0^1 P_k(2 s - 1) z(t - s tau) ds."""
    weighed = [
        lambda s, row=row: legendre.legval(2.0 * s - 1.0, row) * z(t - s * TAU) for row in np.eye(order)
    ]
    return np.array([quad(of, 0.0, 1.0, epsabs=1e-12)[0] for of in weighed])


@pytest.mark.parametrize("order", [1, 2, 3, 5])
@pytest.mark.parametrize("z", [np.cos, lambda t: 1.0 + 0.3 * t - t**3], ids=["cosine", "cubic"])
def test_moments_move_as_their_differences_say(z, order):
    """For any number of them: the derivative by central differences."""
    t, step = 0.7, 1e-4
    slope = (moments(z, t + step, order) - moments(z, t - step, order)) / (2.0 * step)
    forward = moments(z, t, order)
    signs = (-1.0) ** np.arange(order)
    for sign in (1.0, signs):  # the newest first, or the oldest first
        Z = sign * forward
        sent, arriving = z(np.array(t)), z(np.array(t - TAU))
        found = np.array(check._moved(Z, sent, arriving, TAU))
        if np.allclose(found, sign * slope, atol=1e-6):
            return
    raise AssertionError("no order of the signal in time fits")


def test_what_has_no_function_claims_neither_rate_nor_dead_time():
    apart = [np.array([[-1.0, 10.0], [0.0, -1.0]]), np.array([[-1.0, 0.0], [10.0, -1.0]])]
    none, some = common_quadratic(apart), common_quadratic([np.diag([-1.0, -2.0])], decay=0.5)
    assert (none.holds, none.decay, none.margin, none.shape, none.dead_time) == (False, None, None, None, 0.0)
    assert (some.holds, some.decay, some.dead_time) == (True, 0.5, 0.0)
    assert (np.linalg.eigvalsh(some.shape) > 0.0).all()
    assert 0.0 < some.margin <= check.positive(some.shape)


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("decay", [0.0, 0.4])
def test_what_is_under_way_costs_at_most_what_its_integral_does(order, decay):
    """S and R weigh int (S + (1 - s) R) z^2 over the dead time; its derivative and its decay, by quadrature
    of a random wave, stay below the bound of the moments."""
    model = LoopModel(2.0, 3.0, {"only": 0.36}, 2.0, 2.0, 0.16)
    signals = LoopSignals.of(model, TAU, open_law=False, order=order)
    given = transport(signals, decay)
    draw = np.random.default_rng(order)
    for S, R in ((1.0, 0.0), (0.0, 1.0), (0.7, 2.0)):
        if any(sum(row[n] * v for n, v in (("S", S), ("R", R))) < 0.0 for row in paid(signals, decay)):
            continue
        a, b, w = draw.normal(size=3)
        z = lambda t, a=a, b=b, w=w: a + b * np.sin(3.0 * w * t)  # noqa: E731
        weighed = lambda t, z=z, S=S, R=R: quad(  # noqa: E731
            lambda s: (S + (1.0 - s) * R) * z(t - s * TAU) ** 2, 0.0, 1.0
        )[0]
        step = 1e-4
        exact = (weighed(1.0 + step) - weighed(1.0 - step)) / (2.0 * step) + 2.0 * decay * weighed(1.0)
        Z = moments(z, 1.0, order)
        x0 = z(1.0) / model.Ki
        for sign in (np.ones(order), (-1.0) ** np.arange(order)):
            v = np.concatenate([[x0, 0.0, 0.0], sign * Z, [z(1.0 - TAU)]])
            bound = v @ (S * given["S"] + R * given["R"]) @ v
            assert bound >= exact - 1e-6
