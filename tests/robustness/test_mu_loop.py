"""The wrist's loop with constant parameters: bounds of mu about its exact radius, form M-Delta, bad input."""

from dataclasses import replace
from itertools import product

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.box import box_of
from design.robustness.certificates.constant import mu_sweep
from design.robustness.certificates.constant import robust_stability as whole
from design.robustness.certificates.constant.robust_stability import (
    Refuted,
    robust_stability,
    robust_stability_everywhere,
    statements,
)
from design.robustness.certificates.constant.uncertain_loop import (
    NAMES,
    ORDER,
    REACH,
    UncertainLoop,
    pade_error,
    pade_response,
    systems,
)
from design.robustness.certificates.constant.uncertain_search import slack
from design.robustness.loop_model import LoopModel
from design.status import Status
from plants.effects import DeadTime
from plants.errors import InputError
from plants.linearisation import RATES, branch_slopes
from plants.parameters.files import built_in
from plants.wrist import Wrist
from reports.robustness.claims import claim_words
from reports.robustness.reasons import because

BRANCHES = tuple(branch_slopes(Wrist.flexion()))

FLEXION = built_in("flexion")
NARROW = box_of(FLEXION)
WIDE = box_of(
    FLEXION, given={"Tw": (0.08, 0.4), "gain": (44.0, 55.0), "k_slow": (0.3, 0.8), "k_fast": (5, 13)}
)
GAINS = [(1.2, 2.2), (3.13, 10.4), (9.0, 27.0), (20.0, 40.0), (1.0, 12.0)]


def excess(loop, p):
    """Positive where s^3 + (k + l) s^2 + k l (1 + a g Kp) s + a g k l Ki is stable, parameters positive."""
    a, k, lag, g = p
    return (k + lag) * (1.0 + a * g * loop.Kp) - a * g * loop.Ki


def exact_growth(loop):
    """Affine in each parameter, so that its least over a box is at a corner; halved on the growth."""
    c, r = np.array(loop.centre), np.array(loop.radius)
    zero = np.min(c[r > 0.0] / r[r > 0.0])
    corners = np.array(list(product((-1.0, 1.0), repeat=4)))

    def stable(size):
        return min(excess(loop, c + size * r * corner) for corner in corners) > 0.0

    low, high = 0.0, zero
    if stable(zero * (1.0 - 1e-12)):
        return zero
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return high


@pytest.mark.slow
@pytest.mark.parametrize("gains", GAINS)
@pytest.mark.parametrize("box", [NARROW, WIDE], ids=["narrow", "wide"])
def test_the_bounds_hold_the_exact_radius_between_them(box, gains):
    rows = robust_stability_everywhere(box, PI(*gains))
    assert [(r.branch, r.rate) for r in rows] == list(product(BRANCHES, RATES))
    for r in rows:
        exact = 1.0 / exact_growth(r.loop)
        assert r.certified, r.reason
        assert r.lower <= exact <= r.upper
        assert r.lower == pytest.approx(exact, rel=2e-4)
        assert r.upper <= 1.03 * exact
        assert r.intervals > 1
        assert r.margin > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("gains", GAINS)
def test_the_loop_is_stable_in_all_corners_of_the_bounds_that_are_told(gains):
    for r in robust_stability_everywhere(WIDE, PI(*gains)):
        names = [n for n, radius in zip(NAMES, r.loop.radius, strict=True) if radius > 0.0]
        assert list(r.bounds) == names
        low, high = np.array([r.bounds.get(n, (c, c)) for n, c in zip(NAMES, r.loop.centre, strict=True)]).T
        np.testing.assert_allclose(0.5 * (low + high), r.loop.centre)
        np.testing.assert_allclose(0.5 * (high - low), r.growth * np.array(r.loop.radius), atol=1e-12)
        assert min(excess(r.loop, np.array(p)) for p in product(*zip(low, high, strict=True))) > 0.0


@pytest.mark.slow
def test_the_destabilising_parameters_are_unstable_and_within_the_grown_box():
    for gains in GAINS:
        r = robust_stability(WIDE, PI(*gains), "line1", "slow")
        p = np.array(list(r.destabilising.parameters.values()))
        a, k, lag, g = p
        roots = np.roots([1.0, k + lag, k * lag * (1.0 + a * g * gains[0]), a * g * k * lag * gains[1]])
        assert roots.real.max() > 0.0
        assert np.min(np.abs(roots - r.destabilising.root)) < 1e-6 * np.abs(roots).max()
        grown = np.array(r.loop.radius) * r.destabilising.growth
        assert np.all(np.abs(p - r.loop.centre) <= grown * (1.0 + 1e-12))


@pytest.mark.parametrize(("branch", "rate"), list(product(BRANCHES, RATES)))
def test_closed_with_delta_the_form_is_the_loop_model(branch, rate):
    rng = np.random.default_rng(3)
    loop = UncertainLoop.of(WIDE, PI(3.0, 7.0), branch, rate)
    (system,) = systems(loop)
    for _ in range(5):
        delta = rng.uniform(-1.0, 1.0, 4)
        slope, k, lag, g = loop.at(delta)
        D = np.diag(delta)
        closed = system.A + system.B @ D @ np.linalg.solve(np.eye(4) - system.E @ D, system.C)
        model = LoopModel(3.0 * g, 7.0 * g, {branch: slope}, k, k, 1.0 / lag)
        expected = np.linalg.eigvals(model.matrix(slope, k))
        np.testing.assert_allclose(
            np.sort_complex(np.linalg.eigvals(closed)), np.sort_complex(expected), rtol=1e-9
        )
        np.testing.assert_allclose(loop.matrix(loop.at(delta)), model.matrix(slope, k), rtol=1e-12)


@pytest.mark.parametrize("part", [0, 1])
def test_with_a_dead_time_the_form_is_singular_where_the_loop_has_a_root(part):
    # det(I - M Delta) times what the centre has of it is the loop's own 1 + L, up to a factor.
    rng = np.random.default_rng(4)
    loop = UncertainLoop.of(WIDE, PI(3.0, 7.0), "line1", "fast", 0.05)
    system = systems(loop)[part]
    omega = {0: 40.0, 1: 400.0}[part]
    s, late = 1j * omega, np.exp(-0.05j * omega)
    approximant = pade_response(0.05, np.array(omega))
    last = (late / approximant - 1.0) / pade_error(REACH) if part == 0 else late
    assert abs(last) <= 1.0 + 1e-12

    def characteristic(p, delay):
        a, k, lag, g = p
        return s * (s + k) * (s + lag) + a * g * k * lag * (loop.Kp * s + loop.Ki) * delay

    M = system.response(omega)
    for _ in range(5):
        delta = rng.uniform(-1.0, 1.0, 4)
        found = np.linalg.det(np.eye(5) - M * np.append(delta, last))
        centre = characteristic(loop.centre, approximant if part == 0 else 0.0)
        assert found == pytest.approx(characteristic(loop.at(delta), late) / centre, rel=1e-8)


def test_the_approximant_of_a_dead_time_is_within_its_bound():
    x = np.linspace(0.0, REACH, 4001)
    error = np.abs(pade_response(0.05, x / 0.05) - np.exp(-1j * x))
    assert error.max() <= pade_error(REACH) < 2e-4
    assert error.max() > 0.02 * pade_error(REACH)  # no bound of another order of magnitude
    small = x[1:4001:40]
    for order in (2, 4):
        error = np.abs(pade_response(1.0, small, order) - np.exp(-1j * small))
        assert np.all(error <= [pade_error(v, order) for v in small])
    num, den = control.pade(0.05, ORDER)
    s = 1j * np.array([1.0, 30.0, 90.0])
    np.testing.assert_allclose(
        pade_response(0.05, s.imag), np.polyval(num, s) / np.polyval(den, s), rtol=1e-7
    )


def delay_margin(loop, p):
    """By python-control: phase margin over the crossing; infinite where the loop is small throughout."""
    a, k, lag, g = p
    c = a * k * lag * g
    L = control.tf([c * loop.Kp, c * loop.Ki], np.polymul([1.0, k, 0.0], [1.0, lag]))
    _, phase, _, at = control.margin(L)
    return np.deg2rad(phase) / at


@pytest.mark.parametrize("gains", [(1.2, 2.2), (9.0, 27.0), (12.0, 25.0)])
def test_with_a_dead_time_the_bounds_agree_with_delay_margins_of_python_control(gains):
    rng = np.random.default_rng(5)
    for branch in ("transit", "line1"):
        r = robust_stability(NARROW, PI(*gains), branch, "fast", 0.05)
        assert r.certified
        assert r.dead_time == 0.05
        assert r.lower <= r.upper <= 1.03 * r.lower
        for _ in range(30):
            p = r.loop.at(np.sign(rng.uniform(-1.0, 1.0, 4)) * rng.uniform(0.9, 1.0, 4) / r.upper)
            assert delay_margin(r.loop, p) > 0.05
        p = np.array(list(r.destabilising.parameters.values()))
        assert delay_margin(r.loop, p) < 0.05
        assert r.destabilising.root.real > 0.0
        assert r.destabilising.root.imag == pytest.approx(r.worst, rel=0.1)


def test_slack_has_the_sign_of_eigenvalues_and_of_delay_margins():
    rng = np.random.default_rng(6)
    loop = UncertainLoop(2.0, 14.0, (1.0,) * 4, (0.0,) * 4)
    p = np.exp(rng.normal(size=(500, 4)))
    stable = np.linalg.eigvals(loop.matrix(p)).real.max(axis=-1) < 0.0
    assert 50 < stable.sum() < 450
    np.testing.assert_array_equal(slack(loop, p) > 0.0, stable)
    late = UncertainLoop(2.0, 14.0, (1.0,) * 4, (0.0,) * 4, 0.02)
    few = p[stable][:40]
    expected = [delay_margin(loop, q) > 0.02 for q in few]
    assert 0 < sum(expected) < 40
    np.testing.assert_array_equal(slack(late, few) > 0.0, expected)


def test_statements_say_what_is_proved_refuted_and_only_predicted(monkeypatch):
    proved = statements([robust_stability(NARROW, PI(9.0, 27.0), "line1", "fast", 0.05)])[0]
    assert (proved.status, proved.holds, proved.branch) == (
        Status.PROVED, True, "line1, fast regulator rate"
    )  # fmt: skip
    assert claim_words(proved.claim).endswith("with up to 50 ms of dead time")
    assert proved.value == pytest.approx(1.0 / proved.evidence["mu_upper"])
    box = box_of(FLEXION, given={"k_fast": (4.0, 40.0), "Tw": (0.05, 0.3)})
    refuted = statements([robust_stability(box, PI(9.0, 27.0), "line1", "fast", 0.05)])[0]
    assert (refuted.status, refuted.holds) == (Status.DISPROVED, False)
    assert refuted.value < 1.0
    monkeypatch.setattr(whole, "MOST_LMIS", 3)
    predicted = statements([robust_stability(NARROW, PI(9.0, 27.0), "line1", "fast", 0.05)])[0]
    assert predicted.status is Status.PREDICTED
    assert predicted.evidence["certified"] is False
    assert "left a gap" in because(predicted)


@pytest.mark.parametrize(
    ("lower", "upper", "holds"),
    [(0.8, 0.9, True), (0.9, 1.0, True), (0.9, 1.1, None), (1.0, 1.1, False), (1.1, 1.2, False)],
)
def test_a_box_that_need_not_grow_to_hold_an_unstable_loop_fails(lower, upper, holds):
    r = robust_stability(NARROW, PI(9.0, 27.0), "line1", "fast")
    found = replace(r, lower=lower, upper=upper)
    assert found.holds is holds
    assert found.growth == 1.0 / upper


def test_a_certificate_that_the_check_refutes_is_none(monkeypatch):
    # Intervals without ends: the inequality is not what it should be at the frequencies looked at again.
    monkeypatch.setattr(mu_sweep, "crossings", lambda *args: np.array([]))
    r = robust_stability(NARROW, PI(9.0, 27.0), "line1", "slow")
    assert not r.certified
    assert statements([r])[0].status is Status.PREDICTED


def test_members_of_a_certified_set_are_looked_at_by_eigenvalues_and_by_slack_each_by_itself(monkeypatch):
    loop = UncertainLoop.of(WIDE, PI(1.0, 12.0), "line1", "slow")
    exact = exact_growth(loop)
    assert whole._refuted(loop, 1.0 / (0.98 * exact)) is None
    assert whole._refuted(loop, 1.0 / (1.02 * exact)) is Refuted.UNSTABLE_MEMBER
    with monkeypatch.context() as m:  # where slack says nothing, the eigenvalues do
        m.setattr(whole, "slack", lambda loop, p: np.ones(np.shape(p)[:-1]))
        assert whole._refuted(loop, 1.0 / (0.98 * exact)) is None
        assert whole._refuted(loop, 1.0 / (1.02 * exact)) is Refuted.UNSTABLE_MEMBER
    late = UncertainLoop.of(NARROW, PI(1.2, 2.2), "line1", "fast", 0.05)
    assert whole._refuted(late, 1.0) is None
    monkeypatch.setattr(whole, "pade_error", lambda x: 1e-9)
    assert whole._refuted(late, 1.0) is Refuted.POOR_APPROXIMANT


def test_a_loop_that_only_extra_dead_time_destabilises_is_a_finding():
    r = robust_stability(NARROW, PI(20.0, 40.0), "line1", "fast", 0.05)
    assert (r.growth, r.holds) == (0.0, False)
    s = statements([r])[0]
    assert (s.status, s.holds, s.value, s.evidence["mu_upper"]) == (Status.DISPROVED, False, 0.0, None)


def test_the_plants_own_dead_time_counts_at_its_largest():
    plant = FLEXION.revised([DeadTime], {"dead-time.delay": 0.03}, {}, "a step")
    box = box_of(plant, given={"dead-time.delay": (0.02, 0.05)})
    own = robust_stability(box, PI(9.0, 27.0), "line1", "fast")
    extra = robust_stability(NARROW, PI(9.0, 27.0), "line1", "fast", 0.05)
    assert own.dead_time == 0.05
    assert own.upper == pytest.approx(extra.upper, rel=1e-6)


@pytest.mark.parametrize(
    ("gains", "words"),
    [
        ((0.1, 120.0), "transit, slow regulator rate"),
        ((2.0, 0.0), "unstable at the centre"),
        ((0.0, 0.0), "Kp = 0"),
    ],
)
def test_unstable_gains_are_refused_in_one_line_that_names_the_branch(gains, words):
    with pytest.raises(InputError, match=words) as error:
        robust_stability_everywhere(NARROW, PI(*gains))
    assert "\n" not in str(error.value)


def test_unknown_branches_and_negative_dead_times_are_refused():
    for arguments in [("virgin", "slow"), ("line1", "medium"), ("line1", "slow", -0.1)]:
        with pytest.raises(InputError, match="robustness: "):
            robust_stability(NARROW, PI(1.2, 2.2), *arguments)
