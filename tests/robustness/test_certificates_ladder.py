"""Each rung certifies the gains that it should, and no unstable ones."""

import json

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.certificate import Switching
from design.robustness.certificates.continuous import popov, quadratic
from design.robustness.certificates.continuous.ladder import certifies, certify, class_of
from design.robustness.certificates.statements import of_ladder
from design.robustness.loop_model import LoopModel
from plants import Wrist
from reports.robustness.statements import statement_record

FLEXION = Wrist.flexion()


def loop(Kp: float, Ki: float, wrist: Wrist = FLEXION) -> LoopModel:
    return LoopModel.of(wrist, PI(Kp, Ki))


def test_a_common_quadratic_form_exists_for_timid_gains_only() -> None:
    assert certifies(loop(0.5, 0.5), quadratic.RUNG)
    assert certifies(loop(1.0, 1.0), quadratic.RUNG)
    for gains in [(1.2, 2.2), (2.32, 6.38), (3.13, 5.2), (6.0, 10.0)]:
        assert not certifies(loop(*gains), quadratic.RUNG)


def test_a_common_form_lets_the_rate_change_at_will_and_popov_has_the_law() -> None:
    """One form for all corners does not know what a corner hangs on; Popov's integral is of one law."""
    model = loop(1.2, 2.2)
    free, law = (class_of(model, rung) for rung in (quadratic.RUNG, popov.RUNG))
    assert (free.switching, law.switching) == (Switching.ANY_TIME, Switching.FIXED_LAW)
    for about in (free, law):
        assert about.rates == (FLEXION.regulator.k_slow, FLEXION.regulator.k_fast)
        assert about.slopes == (FLEXION.hysteresis.s, max(FLEXION.hysteresis.a1, FLEXION.hysteresis.a2))


@pytest.mark.parametrize("gains", [(1.2, 2.2), (2.32, 6.38), (3.13, 5.2), (6.0, 10.0), (30.0, 35.0)])
def test_popov_reaches_further(gains: tuple[float, float]) -> None:
    assert certifies(loop(*gains), popov.RUNG)


def test_popov_does_not_reach_the_tuned_gains() -> None:
    assert not certifies(loop(3.13, 10.4), popov.RUNG)


@pytest.mark.parametrize("dead_time", [0.0, 0.05])
@pytest.mark.parametrize("wrist", [FLEXION, Wrist.deviation()])
@pytest.mark.parametrize("gains", [(20.0, 200.0), (5.0, 100.0)])
def test_unstable_gains_get_none(gains: tuple[float, float], wrist: Wrist, dead_time: float) -> None:
    import control

    p = control.tf("s")
    h = wrist.hysteresis
    corners = [(s, k) for s in (h.s, h.a1, h.a2) for k in (wrist.regulator.k_slow, wrist.regulator.k_fast)]
    loops = [(gains[0] + gains[1] / p) * s * k / ((p + k) * (wrist.Tw * p + 1.0)) for s, k in corners]
    poles = [control.feedback(control.ss(x), 1).poles().real.max() for x in loops]
    assert max(poles) > 0.0  # so says python-control
    refused(gains, wrist, dead_time)


@pytest.mark.parametrize("dead_time", [0.0, 0.05])
@pytest.mark.parametrize("gains", [(1.0, 0.0), (0.0, 0.0)])
def test_without_integral_action_the_error_stays_and_none_is_claimed(
    gains: tuple[float, float], dead_time: float
) -> None:
    refused(gains, FLEXION, dead_time)


def refused(gains: tuple[float, float], wrist: Wrist, dead_time: float) -> None:
    for c in certify(loop(*gains, wrist), wrist, PI(*gains), dead_times=(dead_time,)):
        assert not c.holds
        assert c.decay is c.margin is c.shape is None
        assert c.reason is not None
        assert not certifies(loop(*gains, wrist), c.rung, dead_time)


@pytest.mark.slow
def test_the_ladder_tells_decay_margin_and_region_and_goes_into_json() -> None:
    ladder = certify(loop(1.2, 2.2), FLEXION, PI(1.2, 2.2))
    assert [(c.rung, c.dead_time, c.holds) for c in ladder] == [
        (quadratic.RUNG, 0.0, False),
        (popov.RUNG, 0.0, True),
        (quadratic.RUNG, 0.05, False),
        (popov.RUNG, 0.05, True),
    ]
    for c in ladder:
        json.dumps(statement_record(of_ladder([c])[0]))
        if c.holds:
            slowest = max(np.linalg.eigvals(loop(1.2, 2.2).matrix(s, k)).real.max()
                          for s in (0.0803, 0.36) for k in (0.55, 9.0))  # fmt: skip
            assert c.margin > 0.0
            assert 0.0 < c.decay <= -slowest
            assert c.evidence["region"]["largest_step_deg"] > 5.0
            assert (c.shape is None) == (c.dead_time > 0.0)


def test_a_regulator_of_one_rate_needs_no_popov() -> None:
    wrist = FLEXION.as_lag_regulator()
    assert certifies(loop(1.2, 2.2, wrist), quadratic.RUNG)
    assert certifies(loop(1.2, 2.2, wrist), popov.RUNG)
