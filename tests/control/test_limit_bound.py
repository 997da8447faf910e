"""No commands beat the lower bound, random ones or the best of all switching times, from any start."""

import numpy as np
import pytest
from scipy.optimize import brentq

from design.limit import bound
from design.limit.bound import _envelope
from design.limit.braking import AFTER, LATEST, settles_after
from plants import Wrist
from plants.wrist import STARTS
from tests.control.limit_plant import iae, lanes, of_state, random_switching, settled_at

TASKS = [(start, 0.0, r) for start in STARTS for r in (15.0, -15.0)]
TASKS += [("line1", 15.0, 0.0), ("line2", -15.0, 0.0)]
WRISTS = {"flexion": Wrist.flexion(), "deviation": Wrist.deviation()}


@pytest.mark.parametrize("motion", WRISTS)
@pytest.mark.parametrize(("start", "angle", "reference"), TASKS)
def test_random_commands_never_beat_it(motion, start, angle, reference):
    wrist = WRISTS[motion]
    state = wrist.rest(start, angle)
    found = bound(wrist, reference, state)
    rng = np.random.default_rng([len(motion), len(start), round(100 + angle), round(100 + reference)])
    angles, last = lanes(wrist.values, of_state(state), random_switching(rng, 500, 150))
    sign = np.sign(reference - angle)
    assert (sign * angles <= sign * found.envelope[:501, None] + 1e-9).all()
    assert (settled_at(angles, reference, angle, last) >= found.settling_s - 1e-9).all()
    assert (
        iae(angles, reference) > np.maximum(sign * (reference - found.envelope[:501]), 0).sum() * 0.001
    ).all()


def _switched(reference, angle, turns, ends, samples):
    """Full throttle to each turn, full throttle back to each end, then the pressure held."""
    t1, t2 = (g.ravel() for g in np.meshgrid(turns, ends))
    k = np.arange(samples)[:, None]
    ahead, back = (4.0, 0.0) if reference > angle else (0.0, 4.0)
    return np.where(k < t1, ahead, np.where(k < t1 + t2, back, np.nan))


@pytest.mark.parametrize("motion", WRISTS)
@pytest.mark.parametrize(("start", "angle", "reference"), [TASKS[0], TASKS[5], *TASKS[-2:]])
def test_the_best_of_all_switching_times_lies_just_above_it(motion, start, angle, reference):
    """A turn and an end at every second sample: the best settles within 8 % of the bound, from above."""
    wrist = WRISTS[motion]
    state = wrist.rest(start, angle)
    found = bound(wrist, reference, state)
    near = round(found.settling_s * 1000)
    turns, ends = np.arange(round(0.75 * near), near + 2, 2), np.arange(20, 90, 2)
    commands = _switched(reference, angle, turns, ends, near + 120)
    angles, last = lanes(wrist.values, of_state(state), commands)
    best = settled_at(angles, reference, angle, last).min()
    assert found.settling_s - 1e-9 <= best <= 1.08 * found.settling_s


@pytest.mark.parametrize("seed", range(10))
def test_nor_do_switching_times_on_other_plants(seed):
    """Plants drawn far from the declared ones: narrow or no loop, flat or steep transit, one rate or two,
    and lines that may cross."""
    rng = np.random.default_rng(seed)
    v = Wrist.flexion().values
    drawn = {n: v[n] * np.exp(rng.uniform(-0.5, 0.5)) for n in ("k_fast", "e0", "a1", "a2", "Tw")}
    drawn |= {n: v[n] * rng.choice([0.0, 0.3, 1.0, 1.5]) for n in ("w1", "w2")}
    drawn["k_slow"] = rng.choice([0.55, 3.0, drawn["k_fast"]])
    drawn["s"] = rng.choice([0.0, 0.5, 1.0]) * min(drawn["a1"], drawn["a2"])
    wrist = Wrist.flexion().with_values(**{n: float(x) for n, x in drawn.items()})
    start, angle, reference = [("line1", 12.0, 0.0), ("line2", -12.0, 4.0), ("line1", 8.0, -8.0)][seed % 3]
    state = wrist.rest(start, angle)
    found = bound(wrist, reference, state)
    near = round(found.settling_s * 1000)
    turns, ends = np.arange(near // 2, near + 4, 2), np.arange(2, 110, 2)
    commands = _switched(reference, angle, turns, ends, near + 130)
    angles, last = lanes(wrist.values, of_state(state), commands)
    assert (settled_at(angles, reference, angle, last) >= found.settling_s - 1e-9).all()


def test_lines_that_cross_get_the_plain_bound():
    """Beyond the crossing the joint goes back along the line that it came by, which brakes it sooner
    than any inside of a loop would: a plant found by search on which braking was once overrated."""
    wrist = Wrist.flexion().with_values(
        k_fast=5.673, k_slow=3.0, e0=5.983, a1=0.26937, a2=0.58863, Tw=0.20066, w1=1.8, w2=9.0, s=0.0
    )
    state = wrist.rest("line1", 12.0)
    found = bound(wrist, -12.0, state)
    commands = _switched(-12.0, 12.0, np.arange(290, 312), np.arange(30, 56), 500)
    angles, last = lanes(wrist.values, of_state(state), commands)
    best = settled_at(angles, -12.0, 12.0, last).min()
    assert found.settling_s - 1e-9 <= best <= 1.02 * found.settling_s


def test_of_a_moving_wrist():
    """The start may be any state: one that is half-way through another step, or on its way back."""
    wrist = WRISTS["flexion"]
    rng = np.random.default_rng(5)
    for before in ([4.0] * 90, [4.0] * 200 + [0.0] * 60, [0.0] * 150):
        state = wrist.simulate(before, wrist.rest("inside")).state
        for reference in (state.angle + 12.0, state.angle - 12.0):
            found = bound(wrist, reference, state)
            angles, last = lanes(wrist.values, of_state(state), random_switching(rng, 400, 150))
            sign = np.sign(reference - state.angle)
            assert (sign * angles <= sign * found.envelope[:401, None] + 1e-9).all()
            assert (settled_at(angles, reference, state.angle, last) >= found.settling_s - 1e-9).all()


def test_a_dip_off_the_virgin_curve_is_thought_of():
    """Where the dead zone is wide and the transit steep, a dip first is faster than a straight rise, so
    that full throttle alone would be no bound."""
    wrist = Wrist.flexion().with_values(k_fast=50.0, k_slow=20.0, s=0.3, w1=20.0, w2=20.0)
    found, state = bound(wrist, 12.0), of_state(wrist.rest())
    dips = np.arange(60)
    commands = np.where(np.arange(400)[:, None] < dips, 0.0, 4.0)
    angles, _ = lanes(wrist.values, state, commands)
    entered = np.argmax(12.0 - angles < 0.24, axis=0)
    assert entered[1:].min() < 0.5 * entered[0]
    assert found.settling_s * 1000 <= entered.min()
    assert (angles <= found.envelope[:401, None] + 1e-9).all()


def test_the_linear_cascade_in_closed_form():
    """One rate, no loop: two first-order lags in series, whose step response is in every textbook."""
    wrist = Wrist.flexion().with_values(k_slow=9.0, s=0.36, w1=0.0, w2=0.0)
    slow, fast, final = wrist.Tw, 1.0 / 9.0, 0.36 * (4.0 * 49.4 - 100.0)

    def left(t):
        return 15.0 - final * (1.0 - (slow * np.exp(-t / slow) - fast * np.exp(-t / fast)) / (slow - fast))

    found = bound(wrist, 15.0, wrist.rest("line1"))
    entry = brentq(lambda t: left(t) - 0.3, 0.01, 1.0)
    # The bound knows of braking too, so that it may be later, by less than the two switches would take.
    assert entry <= found.settling_s <= 1.1 * entry
    until = brentq(left, 0.01, 1.0)
    t = np.linspace(0.0, until, 20001)
    area = np.sum(0.5 * (left(t[1:]) + left(t[:-1])) * np.diff(t))
    # The judge's sum counts each sample from its beginning: half a sample of 15 deg more than the area.
    assert found.iae == pytest.approx(area + 0.5 * 0.001 * 15.0, rel=1e-4)


@pytest.mark.parametrize("motion", WRISTS)
@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_from_the_virgin_curve_the_best_of_all_dips_reaches_its_envelope(motion, reference):
    """Back for any time, a sample of anything between, then ahead: never beyond, and within 0.0125 deg."""
    wrist, sign = WRISTS[motion], np.sign(reference)
    state, ahead, back = wrist.rest(), 2.0 + 2.0 * sign, 2.0 - 2.0 * sign
    turns, between = (g.ravel() for g in np.meshgrid(np.arange(120), np.linspace(0.0, 4.0, 21)))
    k = np.arange(400)[:, None]
    commands = np.where(k < turns, back, np.where(k == turns, between, ahead))
    angles, _ = lanes(wrist.values, of_state(state), commands)
    left = sign * bound(wrist, reference, state).envelope[:400] - (sign * angles).max(axis=1)[:400]
    assert left.min() >= -1e-9
    assert left.max() < 0.0125


def test_the_bound_is_raised_by_so_many_samples_at_most_and_only_where_all_of_them_are_known():
    """A slow wrist comes back into a narrow band later than is looked ahead."""
    wrist, band = WRISTS["flexion"].with_values(Tw=0.5, k_fast=3.0, k_slow=3.0), 1e-3
    fastest = _envelope(wrist, wrist.rest("line2", -12.0), 1.0, 4000, 0.0)
    first = int(np.flatnonzero(4.0 - fastest.angle < band)[0])
    whole = first + LATEST + AFTER[-1]

    def raised(samples):
        static = fastest.memory.h[:samples]
        return settles_after(wrist, first, -12.0, 4.0, band, fastest.pressure, static) - first

    assert raised(4000) == raised(whole + 1) == LATEST
    assert raised(whole) == 0
