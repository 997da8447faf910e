"""With effects the bound is weaker or the same, is claimed where its proof holds, and refused elsewhere."""

import numpy as np
import pytest

from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.limit import bound, limit
from plants import Wrist
from plants import dynamics as plant
from plants.effects.effect import Around
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.regulator.fill_exhaust import TwoRates
from plants.effects.regulator.regulator_deadband import Latch, ValveOverlap
from plants.effects.regulator.supply_droop import CappedPressure
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.end_stop import HardStop
from plants.effects.wrist.inertia import Inertia
from plants.effects.wrist.rate_dependence import Viscous
from plants.effects.wrist.softening import SofteningByWork
from plants.errors import InputError


def _random_angles(wrist, start, rng, samples=350, lanes=60):
    """Angles (samples + 1, lanes) of the wrist's own law, called with arrays, under random commands."""
    c = wrist.sampled()
    state = wrist.rest(start)
    state = plant.State(
        np.full(lanes, state.pressure),
        type(state.memory)(np.full(lanes, state.memory.h), np.full(lanes, state.memory.virgin)),
        np.full(lanes, state.angle), state.effects,
    )  # fmt: skip
    out, v = [state.angle], np.full(lanes, 4.0)
    for k in range(samples):
        changes = rng.random(lanes) < 0.02
        v = np.where(changes, rng.choice([0.0, 4.0, 4.0, 2.7], lanes), v)
        state = plant.step(state, v, c, Around(k * 0.001))
        out.append(state.angle)
    return np.array(out)


@pytest.mark.parametrize(
    "effects",
    [
        (ValveOverlap(3.0), CappedPressure(190.0, 0.2, 3.0), Viscous(0.01)),
        (Latch(5.0),),
        (TwoRates(1.4), Creep(0.1, 0.5), Inertia(0.12)),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_random_commands_stay_below_the_envelope(effects, sign):
    wrist = Wrist.flexion()
    for effect in effects:
        wrist = wrist + effect
    rng = np.random.default_rng(7)
    for start in ("virgin", "line1", "inside"):
        envelope = bound(wrist, sign * 15.0, wrist.rest(start)).envelope[:351]
        assert (sign * _random_angles(wrist, start, rng) <= sign * envelope[:, None] + 1e-9).all()


def test_a_dead_time_adds_itself():
    plain, late = Wrist.deviation(), Wrist.deviation() + DeadTime(0.05)
    for reference in (15.0, -15.0):
        one, other = bound(plain, reference), bound(late, reference)
        assert other.settling_s == pytest.approx(one.settling_s + 0.05, abs=1e-9)
        assert other.iae == pytest.approx(one.iae + 0.05 * 15.0, abs=2e-3)


def test_a_stop_before_the_band_is_never_passed():
    found = bound(Wrist.flexion() + HardStop(-11.0, 11.0), 15.0)
    assert np.isinf(found.settling_s)
    assert found.iae > 4.0 * 9.0


@pytest.mark.parametrize(
    ("wrist", "words"),
    [
        (Wrist.flexion() + SofteningByWork(depth=0.1), "softening"),
        (Wrist.flexion() + Creep(gain=-0.1), "creeps backwards"),
        (Wrist.flexion() + Inertia(0.1) + HardStop(-20.0, 20.0), "stop"),
        (Wrist.flexion().with_values(s=0.4), "flatter"),
        (Wrist.flexion().with_values(k_fast=1.0, k_slow=20.0, e0=5.0), "larger command"),
        (Wrist.flexion().with_values(Tw=np.array([0.1, 0.2])), "one lane"),
    ],
)
def test_refusals_name_the_reason(wrist, words):
    with pytest.raises(InputError, match=words) as told:
        bound(wrist, 15.0)
    assert "\n" not in str(told.value)


def test_refusals_of_trajectories_and_steps():
    with pytest.raises(InputError, match="no size"):
        bound(Wrist.flexion(), 0.0)
    with pytest.raises(InputError, match="out of reach"):
        limit(Case(Task("virgin", 0.0, (60.0,)), Wrist.flexion()), trajectory=True)
    with pytest.raises(InputError, match="no trajectory for a wrist with creep"):
        limit(Case(Task("virgin", 0.0, (15.0,)), Wrist.flexion() + Creep(0.1)), trajectory=True)
