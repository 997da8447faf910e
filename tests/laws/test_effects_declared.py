"""What effects declare beside their laws: where a log suggests to try them, what keeps a wrist from an angle,
and how long they let a performance bound stand."""

from types import SimpleNamespace

import numpy as np
import pytest

from plants import Wrist
from plants.effects import EFFECTS
from plants.effects.effect import Around
from plants.effects.regulator.supply_droop import CappedPressure
from plants.effects.sensor.periodic import Hum
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.end_stop import CompliantStop, GivingStop, HardStop, PadStop, SpringStop
from plants.effects.wrist.inertia import Inertia
from plants.effects.wrist.learnt_block import LearntBlock
from plants.effects.wrist.load_step import LoadStep
from plants.effects.wrist.loop_shape import OneMorePlay, SeveralPlays, SmoothLoop
from plants.effects.wrist.rate_dependence import Viscous
from plants.effects.wrist.stick_slip import SHARES, FreeSlip
from plants.rig import built_in_rig
from tests.laws.effect_steps import WRIST

MEASURED = np.linspace(-18.0, 26.0, 5001)


def log(channel="angle_deg", values=MEASURED, noise=0.05, steps=(), lines=()):
    """A log by what it tells."""
    return SimpleNamespace(
        channel=channel, rig=built_in_rig(), noise=noise, steps=lambda: list(steps),
        quantiles=lambda *shares: np.quantile(values, shares), spectral_lines=lambda: list(lines),
    )  # fmt: skip


def test_a_load_is_tried_at_the_moments_told_with_three_times_the_noise_either_way():
    tried = LoadStep.trials_on(log(noise=0.2, steps=[(3.0, 1.0), (7.5, -1.0)]))
    assert [(t["moment"], t["shift"]) for t in tried] == [
        (3.0, pytest.approx(0.6)),
        (7.5, pytest.approx(-0.6)),
    ]
    assert LoadStep.trials_on(log()) == []


def test_a_hum_is_tried_at_the_lines_told_with_their_size_in_noise():
    tried = Hum.trials_on(log(noise=0.2, lines=[(2.5, 1.5, -2.0)]))
    assert [(t["frequency"], t["sine"], t["cosine"]) for t in tried] == [
        (2.5, pytest.approx(0.3), pytest.approx(-0.4))
    ]


def test_a_supply_is_tried_as_declared_and_at_shares_of_the_pressure_reached():
    declared = list(CappedPressure.trials(built_in_rig()))
    pressures = np.linspace(0.0, 150.0, 5001)
    tried = list(CappedPressure.trials_on(log("pressure_kPa", pressures)))
    assert tried[: len(declared)] == declared
    more = tried[len(declared) :]
    others = {tuple(v for n, v in sorted(t.items()) if n != "supply") for t in declared}
    assert len(more) == 3 * len(others)
    assert sorted({t["supply"] / np.quantile(pressures, 0.998) for t in more}) == pytest.approx(
        [0.9, 0.97, 1.0]
    )
    assert list(CappedPressure.trials_on(log("angle_deg"))) == declared


def test_a_joint_that_sticks_is_tried_at_shares_of_the_range_reached():
    declared = list(FreeSlip.trials(built_in_rig()))
    tried = list(FreeSlip.trials_on(log()))
    assert tried[: len(declared)] == declared
    width = np.quantile(MEASURED, 0.998) - np.quantile(MEASURED, 0.002)
    assert {round(t["breakaway"] / width, 9) for t in tried[len(declared) :]} == {round(s, 9) for s in SHARES}


@pytest.mark.parametrize("kind", [HardStop, PadStop, SpringStop])
def test_stops_are_tried_on_either_side_and_on_both_at_shares_of_the_angles_reached(kind):
    tried = [(t["low"], t["high"]) for t in kind.trials_on(log())]
    low, high = np.quantile(MEASURED, [0.002, 0.998])
    lows = [-90.0, *(s * low for s in (1.0, 0.9, 0.75, 0.6))]
    highs = [90.0, *(s * high for s in (1.0, 0.9, 0.75, 0.6))]
    expected = {(round(a, 9), round(b, 9)) for a in lows for b in highs} - {(-90.0, 90.0)}
    assert {(round(a, 9), round(b, 9)) for a, b in tried} == expected
    assert len(tried) == len(expected)
    calm = [(t["low"], t["high"]) for t in kind.trials_on(log(values=np.array([-0.1, 0.2])))]
    assert max(a for a, _ in calm) == pytest.approx(-0.6)  # at a degree at least: noise is no stop
    assert min(b for _, b in calm) == pytest.approx(0.6)


def test_a_joint_that_goes_to_one_side_may_rest_against_a_stop_where_it_starts():
    tried = list(HardStop.trials_on(log(values=np.linspace(-0.01, 40.0, 500))))
    assert any(-0.1 < t["low"] <= 0.0 for t in tried)
    turned = list(HardStop.trials_on(log(values=np.linspace(-40.0, 0.01, 500))))
    assert any(0.0 <= t["high"] < 0.1 for t in turned)


def test_what_keeps_a_wrist_from_an_angle_is_said_and_nothing_else():
    stop, supply = HardStop(-12.0, 14.0), CappedPressure(120.0, 0.0, 8.0)
    assert "+14 deg" in stop.obstacle(150.0, 15.0)
    assert "-12 deg" in stop.obstacle(50.0, -12.5)
    assert stop.obstacle(150.0, 14.0) is stop.obstacle(0.0, -12.0) is stop.obstacle(0.0, 0.0) is None
    assert supply.obstacle(120.0, 0.0) is None
    assert "120 kPa, where 121 kPa" in supply.obstacle(121.0, 0.0)


def test_a_joint_that_gives_is_kept_from_no_angle():
    for kind in (SpringStop, GivingStop):
        assert kind(-12.0, 14.0, 0.2).obstacle(150.0, 20.0) is None
        assert "+14 deg" in kind(-12.0, 14.0, 0.0).obstacle(150.0, 20.0)
    assert PadStop(-12.0, 14.0, 1.0).obstacle(150.0, 20.0) is None
    assert "+14 deg" in CompliantStop(-12.0, 14.0, 0.2).obstacle(150.0, 20.0)  # what is seen is the link


def test_what_makes_haste_pay_less_or_undoes_it_has_no_bound():
    assert Viscous(0.0).no_bound(WRIST) is Viscous(0.01).no_bound(WRIST) is None
    assert "narrows" in Viscous(-0.01).no_bound(WRIST)
    assert Creep(0.0, 4.0).no_bound(WRIST) is Creep(0.1, 4.0).no_bound(WRIST) is None
    assert "backwards" in Creep(-0.1, 4.0).no_bound(WRIST)


@pytest.mark.parametrize("inertia", [0.02, 0.05, 0.07, 0.079, 0.081, 0.1, 0.3])
def test_a_joint_that_rings_keeps_the_bound_while_its_impulse_response_is_positive(inertia):
    """Against the impulse response of 1 / (inertia^2 s^2 + Tw s + 1), by its roots."""
    wrist = WRIST + Inertia(inertia)
    roots = np.roots([inertia**2, wrist.Tw, 1.0])
    end = wrist.effects[0].bound_ends(wrist)
    if np.isreal(roots).all():
        assert end is None
        assert sorted(wrist.effects[0].joint_lags(wrist)) == pytest.approx(sorted(inertia**2 * -roots.real))
    else:
        assert end == pytest.approx(np.pi / abs(roots[0].imag))
        assert wrist.effects[0].joint_lags(wrist) == pytest.approx((wrist.Tw / 2.0, wrist.Tw / 2.0))
    assert Inertia(inertia).no_bound(wrist) is None
    assert "stop" in Inertia(inertia).no_bound(wrist + HardStop(-10.0, 10.0))


def test_what_only_watches_the_pressure_leaves_it_and_all_else_that_drives_changes_it():
    """A rest is searched without those that only watch."""
    watching, seen = set(), set()
    for form in (*(f for forms in EFFECTS.values() for f in forms), LearntBlock):
        null, kinds = form().values, form.kinds()
        values = {
            f"{form.NAME}.{n}": (v := null[f"{form.NAME}.{n}"]) + 0.1 * (min(k.high, v + 10.0) - v)
            for n, k in kinds.items()
        }
        plant = Wrist.from_values({**WRIST.values, **values}, (form,), WRIST.rig)
        sampled = plant.sampled()
        for i, effect in sampled.at("drive"):
            state = plant.rest().effects[i]
            _, _, after = effect(state, 100.0, 137.0, Around(other_pressure=20.0))
            left = after == 137.0
            assert left == (not sampled.driving), form
            (watching if left else seen).add(form)
    assert watching >= {LearntBlock, OneMorePlay, SmoothLoop, SeveralPlays}
    assert seen
