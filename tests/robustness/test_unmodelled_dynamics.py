"""A residual that is unmodelled dynamics: in margins, in mu, in the requirement, in the plant's file."""

from dataclasses import replace
from itertools import product

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.margins import branch_responses, margins, with_dynamics
from design.open_loops import by_python_control, loop_tf
from design.robustness.box import Box, box_of
from design.robustness.certificates.constant.robust_stability import Centre, robust_stability, statements
from design.robustness.certificates.constant.uncertain_loop import UncertainLoop
from design.robustness.requirement import POINTS, requirement
from design.synthesis.evaluate import evaluate
from plants.effects.wrist.remainder import ColouredRemainder
from plants.errors import InputError
from plants.parameters.files import built_in, dump, load
from plants.parameters.remainder import BANDS, RemainderSize, UncertaintyWeight
from plants.simulation.disturbance import burdened
from plants.wrist import Wrist
from reports.robustness.claims import claim_words
from reports.robustness.reasons import because

WEIGHT = UncertaintyWeight(0.1, 1.5, 2.0, 3.0)
WRIST = Wrist.flexion()


def plant(weight):
    left = RemainderSize(0.3, 2.0, 0.8, 6.0, 0.07, 0.01, dict.fromkeys(BANDS, 0.25), weight)
    return replace(built_in("flexion"), remainder={"angle_deg": left})


def box(weight):
    of = plant(weight)
    return box_of(of).leaving(ColouredRemainder.of(of.remainder["angle_deg"]))


def system(weight):
    """The weight as python-control has it."""
    w = 2.0 * np.pi * weight.corner_Hz
    return control.tf([weight.high / w, weight.low], [1.0 / w, 1.0])


def test_the_weight_is_its_transfer_function():
    omega = np.geomspace(1e-2, 1e3, 50)
    np.testing.assert_allclose(WEIGHT.response(omega), system(WEIGHT)(1j * omega))


@pytest.mark.parametrize("gains", [(1.2, 2.2), (3.13, 10.4), (20.0, 40.0), (1.0, 120.0)])
def test_the_peak_is_that_of_python_control(gains):
    pi = PI(*gains)
    found = margins(with_dynamics(branch_responses(WRIST), WEIGHT), pi)
    rows = by_python_control(WRIST, pi, weight=WEIGHT)
    wanted = []
    for row in rows:
        loop = loop_tf(WRIST, pi, row["branch"], row["rate"])
        closed = control.feedback(loop, 1)
        omega = np.geomspace(1e-2, 0.99 * np.pi / loop.dt, 4000)
        stable = np.all(np.abs(closed.poles()) < 1.0)
        peak = np.max(np.abs(closed(np.exp(1j * omega * loop.dt)) * WEIGHT.response(omega)))
        wanted.append(max(peak, WEIGHT.low) if stable else np.inf)  # T is 1 at zero frequency
        assert row["WT"] == pytest.approx(wanted[-1], rel=1e-3)
    assert float(found.WT) == pytest.approx(max(wanted), rel=1e-3)
    assert wanted[int(found.WT_at)] == pytest.approx(max(wanted), rel=1e-3)
    assert found.values["WT"] is found.WT
    assert "WT" not in margins(branch_responses(WRIST), pi).values
    assert "WT" not in by_python_control(WRIST, pi)[0]


def needed(loop, parameters):
    """Least gain of dynamics that destabilise a stable loop, on a fine grid, by python-control."""
    slope, rate, lag, gain = parameters
    s = control.tf("s")
    forward = slope * rate * lag * gain * (loop.Kp * s + loop.Ki) / (s * (s + rate) * (s + lag))
    omega = np.geomspace(1e-2, 1e3, 3000)
    late = np.exp(-1j * omega * loop.dead_time)
    L = forward(1j * omega) * late
    return np.min(np.abs(1.0 + L) / np.abs(system(loop.weight)(1j * omega) * L))


@pytest.mark.parametrize("dead_time", [0.0, 0.05])
def test_mu_with_the_block_is_where_some_member_first_needs_no_more_than_the_weight(dead_time):
    """Inside the certified box every corner and every draw stands dynamics of the weight; in one a hundredth
    larger the destabilising parameters do not."""
    found = robust_stability(box(WEIGHT), PI(3.13, 10.4), "line1", "slow", dead_time)
    bare = robust_stability(box_of(built_in("flexion")), PI(3.13, 10.4), "line1", "slow", dead_time)
    assert found.certified
    assert bare.upper < found.lower <= found.upper < 1.02 * found.lower
    loop, rng = found.loop, np.random.default_rng(0)
    corners = [*product((-1.0, 1.0), repeat=4), *rng.uniform(-1.0, 1.0, (40, 4))]
    assert min(needed(loop, loop.at(0.999 * found.growth * np.array(c))) for c in corners) > 1.0
    beyond = [found.destabilising.parameters[n] for n in ("slope", "rate", "lag", "gain")]
    assert needed(loop, beyond) < 1.001
    (said,) = statements([found])
    assert claim_words(said.claim).endswith("and the residual as unmodelled dynamics")
    assert "with unmodelled dynamics at" in because(said)
    assert said.evidence["weight"]["high"] == 1.5


def test_a_weight_that_the_centre_does_not_stand_is_a_finding():
    found = robust_stability(box(UncertaintyWeight(0.3, 3.0, 1.0, 2.0)), PI(3.13, 10.4), "line1", "slow")
    assert (found.holds, found.growth, found.reason) == (False, 0.0, Centre.DYNAMICS)
    assert needed(found.loop, found.loop.centre) < 1.0


def test_without_uncertain_parameters_the_block_alone_is_proved_or_not():
    certain = Box(plant(WEIGHT), ()).leaving(ColouredRemainder(0.3, 5.0))
    found = robust_stability(certain, PI(3.13, 10.4), "line1", "slow")
    assert found.certified
    assert found.holds
    assert needed(found.loop, found.loop.centre) > 1.0


def test_the_block_takes_the_place_of_the_change_of_slopes():
    """A residual without a weight widens the slopes, one with a weight does not."""
    widened, weighed = (UncertainLoop.of(box(w), PI(1.2, 2.2), "line1", "slow") for w in (None, WEIGHT))
    plain = UncertainLoop.of(box_of(built_in("flexion")), PI(1.2, 2.2), "line1", "slow")
    assert weighed.radius == plain.radius
    assert widened.radius[0] > plain.radius[0]
    assert (widened.weight, weighed.weight) == (None, WEIGHT)


def test_the_requirement_asks_for_robust_stability_and_tuning_obeys():
    wide = UncertaintyWeight(0.2, 4.0, 1.0, 2.0)
    asked, bare = requirement(plant(wide)), requirement(plant(None))
    assert (asked.limits.WT, bare.limits.WT) == (1.0, None)
    gains = PI.of(asked.wrist, 3.0, 8.0)
    beyond = asked.linear_excess(gains)
    assert beyond["WT"] > 0.0
    assert "WT" not in bare.linear_excess(gains)
    assert {n: v for n, v in beyond.items() if n != "WT"} == bare.linear_excess(gains)
    # The nominal plant leaves the residual, without and with the longest dead time; corners have none of it.
    late = burdened(asked.wrist, asked.space.dead_time, None)
    responses = [b.response for w in (asked.wrist, late) for b in branch_responses(w, POINTS)]
    for b in asked.branches:
        assert (b.weight is not None) is any(np.allclose(b.response, r, 1e-9) for r in responses)
    assert 4 <= sum(b.weight is not None for b in asked.branches) < len(asked.branches) // 4
    # Without the residual nothing is left of it, whatever else is changed.
    assert replace(asked, box=asked.box.leaving(None)).limits.WT is None
    assert replace(asked, box=Box(asked.box.plant, ()).leaving(asked.box.remainder)).limits.WT == 1.0
    # A problem that screens does not simulate such gains.
    at = evaluate(asked.problem(), 3.0, 8.0)
    assert at.excess["WT"][0] == pytest.approx(beyond["WT"], rel=1e-6)
    assert np.isinf(at.cost[0])


def test_the_weight_is_written_and_read(tmp_path):
    dump(plant(WEIGHT), tmp_path / "plant.toml")
    assert load(tmp_path / "plant.toml").remainder["angle_deg"].weight == WEIGHT
    text = (tmp_path / "plant.toml").read_text(encoding="utf-8")
    for old, new, said in (
        ("corner_Hz = 2.0", "corner_Hz = 0.0", "remainder.angle_deg.weight: corner_Hz = 0; give"),
        ("low = 0.1", "low = -0.1", "remainder.angle_deg.weight: low = -0.1 is not a finite number"),
        ("high = 1.5", "hihg = 1.5", "hihg"),
    ):
        assert old in text
        (tmp_path / "bad.toml").write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(InputError, match=said):
            load(tmp_path / "bad.toml")
