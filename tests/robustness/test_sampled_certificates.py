"""Certificates of the sampled loop hold for it, reach as far as linear theory says, and end at words."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.reasons import UnstableMode
from design.robustness.certificates.sampled.lifted import Delayed, window_quadratic
from design.robustness.certificates.sampled.lifted import gram_polynomials as gram
from design.robustness.certificates.sampled.quadratic import best, common_quadratic
from design.robustness.certificates.sampled.sampled_loop import certify_sampled, delayed, vertices, word_of
from design.robustness.certificates.sampled.switched import discrete, scaled
from design.robustness.certificates.statements import of_ladder
from design.robustness.loop_model import LoopModel
from design.status import Status
from plants import Wrist
from plants.errors import InputError
from reports.robustness.reasons import because

DT = 1e-3


def model(Kp: float, Ki: float) -> LoopModel:
    return LoopModel.of(Wrist.flexion(), PI(Kp, Ki))


def one(loop: Delayed, mode: int) -> Delayed:
    """The loop that stays in one mode."""
    return Delayed((loop.loops[mode],), loop.entry, (loop.reads[mode],), loop.dt, loop.samples)


def radius(matrix: np.ndarray) -> float:
    return float(np.max(np.abs(np.linalg.eigvals(matrix))))


def test_matrices_between_slopes_and_shares_are_in_the_polytope() -> None:
    m = model(1.2, 2.2)
    low, high = m.sampled_shares()
    corners = {
        (s, g): a
        for (s, g), a in zip(
            [(s, g) for s in m.distinct_slopes.values() for g in (low, high)],
            vertices(m).values(),
            strict=True,
        )
    }
    (s0, s1), rng = sorted(m.distinct_slopes.values()), np.random.default_rng(0)
    for u, v in rng.uniform(size=(20, 2)):
        share = low + v * (high - low)
        direct = m.sampled_matrix(s0 + u * (s1 - s0), -np.log1p(-share) / DT)
        mixed = sum(
            wu * wv * corners[s, g] for s, wu in ((s0, 1 - u), (s1, u)) for g, wv in ((low, 1 - v), (high, v))
        )
        np.testing.assert_allclose(direct, mixed, atol=1e-13)


@pytest.mark.slow
def test_timid_gains_are_certified_and_the_common_function_decreases_in_simulation() -> None:
    m = model(0.5, 0.5)
    found = {c.rung: c for c in certify_sampled(m, (0.0,))}
    assert all(c.holds for c in found.values())
    quadratic = found["discrete-time common quadratic"]
    assert quadratic.shape is not None
    assert quadratic.decay is not None
    # A forms' rung proves at least what the quadratic one does, and no rate beats any single mode.
    slowest = min(-np.log(radius(a)) / DT for a in vertices(m).values())
    rates = [c.decay for c in found.values() if c.decay is not None]
    assert 0.0 < rates[0] <= min(rates[1:])
    assert max(rates) <= slowest
    # The worst switching that a greedy opponent finds loses at least the certified decay.
    x = np.random.default_rng(1).normal(size=3)
    before = x @ quadratic.shape @ x
    for _ in range(3000):
        x = max((a @ x for a in vertices(m).values()), key=lambda z: z @ quadratic.shape @ z)
    assert x @ quadratic.shape @ x <= before * np.exp(-2.0 * quadratic.decay * 3.0)


@pytest.mark.slow
def test_tuned_gains_have_a_word_and_no_certificate() -> None:
    """Kp 3.13, Ki 10.4: a destabilising word; its product is multiplied out anew from the loop model."""
    m = model(3.13, 10.4)
    word = word_of(m)
    assert word is not None
    assert word.growth > 0.22
    names = list(vertices(m))
    total = np.eye(3)
    for name, dwell in zip(word.names, word.dwells, strict=True):
        a = list(vertices(m).values())[names.index(name)]
        for _ in range(round(dwell / DT)):
            total = a @ total
    assert radius(total) == pytest.approx(word.radius, rel=1e-9)
    assert radius(total) > 1.2
    found = certify_sampled(m, word=word)
    assert not any(c.holds for c in found)
    for c in found:
        assert c.status is (Status.DISPROVED if c.dead_time == 0.0 else Status.OPEN)
        (said,) = of_ladder([c])
        assert said.holds is (False if c.dead_time == 0.0 else None)
        assert ("none exists: " in because(said)) == (c.dead_time == 0.0)


def test_continuous_loop_grows_by_the_two_letter_word_of_the_trial() -> None:
    """Slow rate on transit for 1.64 s, fast rate on a line for 0.17 s: about +0.22 1/s, by scipy."""
    from scipy.linalg import expm

    m = model(3.13, 10.4)
    first = expm(1.64 * m.matrix(m.slopes["transit"], m.k_slow))
    second = expm(0.17 * m.matrix(m.slopes["line1"], m.k_fast))
    growth = np.log(radius(second @ first)) / 1.81
    assert growth == pytest.approx(0.22, abs=0.01)
    word = word_of(m)
    assert word is not None
    assert word.growth >= growth - 0.01


@pytest.mark.slow
def test_gains_beyond_quadratic_functions_are_certified_by_forms() -> None:
    m = model(1.2, 2.2)
    assert word_of(m) is None
    holds = {c.rung: c.holds for c in certify_sampled(m, (0.0,))}
    assert holds == {
        "discrete-time common quadratic": False,
        "discrete-time poly-quadratic": False,
        "discrete-time forms of degree 4": True,
        "discrete-time forms of degree 6": True,
    }


@pytest.mark.slow
@pytest.mark.parametrize("mode", [pytest.param(2, marks=pytest.mark.suite), 3])
def test_one_mode_is_certified_up_to_its_exact_delay_margin(mode: int) -> None:
    """The margin by the eigenvalues of the matrix with all N samples under way."""
    m = model(3.13, 10.4)
    low, high = 1, 600
    while high - low > 1:
        middle = (low + high) // 2
        stable = radius(one(delayed(m, middle), mode).full[0]) < 1.0
        low, high = (middle, high) if stable else (low, middle)
    assert window_quadratic(one(delayed(m, round(0.98 * low)), mode))(0.0).holds
    assert not window_quadratic(one(delayed(m, high), mode))(0.0).holds
    # And its decay at 50 ms is the exact one.
    loop = one(delayed(m, 50), mode)
    most = float(np.min(discrete(loop.full, DT).fates))
    exact = -np.log(radius(loop.full[0])) / DT
    found = best(window_quadratic(loop), 0.1 * most, most, 7)
    assert 0.97 * exact < found.rate <= exact


@pytest.mark.parametrize("samples", [1, 2, 5, 50])
def test_full_matrix_is_the_loop_with_a_line_of_past_changes(samples: int) -> None:
    m = model(1.2, 2.2)
    loop = delayed(m, samples)
    whole, matrix = loop.full[1], list(vertices(m).values())[1]
    x, line = np.array([1.0, -0.5, 3.0]), [0.0] * samples
    state = np.concatenate([x, line])
    for _ in range(3 * samples):
        moved = matrix @ x
        z = m.Kp * (moved[0] - x[0]) + m.Ki * DT * x[0]
        line.append(z)
        moved[2] += line.pop(0) - z
        x, state = moved, whole @ state
        np.testing.assert_allclose(state[:3], x, atol=1e-12)


@pytest.mark.parametrize("follows", [False, True])
def test_function_of_the_window_decreases_as_a_form_of_all_that_is_under_way(follows: bool) -> None:
    """The certificate unfolded to 3 + N states, against the full matrices at vertices and between."""
    m, samples, loss = model(0.3, 0.3), 50, 1e-4
    loop = delayed(m, samples)
    found = window_quadratic(loop, follows)(loss)
    assert found.holds
    undelayed = [a + np.outer(loop.entry, DT * c) for a, c in zip(loop.loops, loop.reads, strict=True)]
    back = scaled(discrete(undelayed, DT))[1]
    unit = max(float(np.linalg.norm(c @ back)) for c in loop.reads)
    # Moments by numpy's Legendre series, made orthonormal on the window (signs as the module's).
    count = len(found.shapes[0]) - 3
    x = (2.0 * np.arange(1, samples + 1) - samples - 1) / samples
    q, _ = np.linalg.qr(np.polynomial.legendre.legvander(x, count - 1))
    q *= np.sign(q[0] * gram(samples, count)[0])
    to_w = np.zeros((3 + count, 3 + samples))
    to_w[:3, :3] = np.linalg.inv(back)
    to_w[3:, 3:] = q.T * np.sqrt(samples) / samples / (DT * unit)
    s, r = found.weights
    line = s + r * DT * (samples + 1 - np.arange(1, samples + 1))
    squares = np.diag(np.concatenate([np.zeros(3), DT * line / (DT * unit) ** 2]))
    shapes = list(found.shapes) * (1 if follows else len(loop.loops))
    # In the states times exp(rate t), as the rate was taken out of the loop.
    grown = np.diag(np.exp(found.rate * DT * np.concatenate([np.zeros(3), np.arange(1, samples + 1)])))
    forms = np.array([grown @ (to_w.T @ p @ to_w + squares) @ grown for p in shapes])
    full, ends = np.array(loop.full), np.eye(len(shapes))
    inside = np.random.default_rng(2).dirichlet(np.ones(len(shapes)), (10, 2))
    for now, then in [(v, w) for v in ends for w in ends] + list(inside):
        a, v, after = (np.tensordot(w, of, 1) for w, of in ((now, full), (now, forms), (then, forms)))
        root = np.linalg.inv(np.linalg.cholesky(v))
        left = root @ (v * np.exp(-2.0 * found.rate * DT) - a.T @ after @ a) @ root.T
        assert np.linalg.eigvalsh((left + left.T) / 2.0)[0] > -1e-12


@pytest.mark.slow
def test_dead_time_takes_from_the_decay_of_timid_gains() -> None:
    decays = []
    for samples in (0, 50, 300):
        loop = delayed(model(0.3, 0.3), samples)
        if samples == 0:
            system = scaled(discrete(loop.full, DT))[0]
            found = best(common_quadratic(system), 1e-4, float(np.min(system.fates)), 9)
        else:
            found = best(window_quadratic(loop), 1e-4, float(np.min(discrete(loop.full, DT).fates)), 7)
        assert found.holds
        decays.append(found.rate)
    assert decays[0] > decays[1] > decays[2] > 0.0


def test_unstable_gains_and_negative_dead_time_are_told() -> None:
    found = certify_sampled(model(1.0, 400.0), (0.0, 0.05))
    assert not any(c.holds for c in found)
    assert all(c.reason == UnstableMode() and c.status is Status.DISPROVED for c in found)
    with pytest.raises(InputError, match="dead time"):
        certify_sampled(model(1.0, 1.0), (-0.01,))
