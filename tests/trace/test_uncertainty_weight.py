"""The weight of unmodelled dynamics is above what is known of made-up residuals, and silent about noise."""

import numpy as np
import pytest
from scipy.signal import lfilter

from plants.measured.trace.revision.uncertainty_weight import bands, uncertainty_weight

DT, NOISE = 0.01, 0.03
OMEGA = 2.0 * np.pi * np.array([0.05, 0.1, 0.3, 1.0, 2.0])


def moved(rng, n=3000):
    """An angle [deg] on random steps of 1.5 s, behind a lag of 0.2 s."""
    command = 10.0 * np.repeat(rng.uniform(-1.0, 1.0, n // 150), 150)
    return lfilter([DT / 0.2], [1.0, DT / 0.2 - 1.0], command)


def pieces(seed, left):
    """Two recordings: what is `left` of an angle, and noise."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(2):
        y = moved(rng)
        found.append((left(y, rng) + NOISE * rng.standard_normal(y.size), y, DT))
    return found


DYNAMICS = {
    "gain": (lambda y, rng: 0.05 * y, lambda s: 0.05 + 0.0 * s),
    "dead time": (lambda y, rng: np.concatenate([np.zeros(5), y[:-5]]) - y, lambda s: np.exp(-0.05 * s) - 1),
    "lag": (lambda y, rng: lfilter([0.1], [1.0, -0.9], y) - y, lambda s: 1.0 / (1.0 + 0.1 * s) - 1.0),
}


@pytest.mark.parametrize("name", DYNAMICS)
def test_the_weight_is_above_dynamics_that_were_left_out_and_not_far(name):
    left, true = DYNAMICS[name]
    for seed in range(6):
        weight = uncertainty_weight(pieces(seed, left), NOISE)
        told = 2.0 * np.pi * weight.known_Hz >= OMEGA
        size, wanted = np.abs(weight.response(OMEGA))[told], np.abs(true(1j * OMEGA))[told]
        assert told.sum() >= 4
        # A band has one gain for frequencies that differ by two, and the weight is of first order.
        assert np.all(size > 0.9 * wanted)
        assert np.all(size < 3.0 * wanted + 0.06)


def coloured(y, rng):
    return lfilter([0.02], [1.0, -0.98], rng.standard_normal(y.size))


@pytest.mark.parametrize("left", [lambda y, rng: 0.0 * y, coloured])
def test_noise_and_a_disturbance_of_its_own_have_no_weight(left):
    found = [uncertainty_weight(pieces(seed, left), NOISE) for seed in range(30)]
    assert sum(w is not None for w in found) <= 2  # one in a hundred by the test's own level


def test_a_recording_of_one_line_tells_nothing_and_none_has_no_weight():
    t = DT * np.arange(3000)
    one = np.sin(2.0 * np.pi * t / 10.0)
    rng = np.random.default_rng(0)
    assert uncertainty_weight([(NOISE * rng.standard_normal(t.size), one, DT)], NOISE) is None
    assert uncertainty_weight([], NOISE) is None


def test_where_the_angle_does_not_stand_above_the_noise_nothing_is_told():
    still = [(0.05 * y, y, DT) for _, y, _ in pieces(1, coloured)]
    loud = float(np.std(still[0][1]))
    assert not any(b.excited for b in bands(still, 100.0 * loud))
    assert uncertainty_weight(still, 100.0 * loud) is None
    assert uncertainty_weight(still, 1e-3).low == pytest.approx(0.05, rel=0.02)


def test_the_gain_and_its_spread_are_those_of_many_draws():
    """White signals: the gain that made them, and the spread of what 200 draws show."""
    rng = np.random.default_rng(3)
    draws = []
    for _ in range(200):
        y, e = rng.standard_normal((2, 2000))
        draws.append(bands([(0.3 * y + 0.4 * e, y, DT)], 0.0)[-2])
    seen = np.array([b.gain for b in draws])
    assert seen.mean() == pytest.approx(0.3, abs=0.01)
    told = np.sqrt(np.mean([b.spread**2 for b in draws]))
    assert told == pytest.approx(seen.std(), rel=0.15)
    # Without a relation the chances are even: as many below a tenth as should be.
    none = [bands([(rng.standard_normal(2000), rng.standard_normal(2000), DT)], 0.0)[-2] for _ in range(400)]
    assert np.mean([b.chance < 0.1 for b in none]) == pytest.approx(0.1, abs=0.045)
