"""A controller that is not in the repository, registered with one call, is compared and exported."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from design.comparison.compare import controllers, on_tasks
from design.controllers import register
from design.controllers.controller import Measured, remembers
from design.controllers.feedforward import FeedforwardPI
from design.controllers.lqi import LQI
from design.controllers.pi import PI
from design.controllers.registry import REGISTERED
from design.controllers.state_space import linearised
from design.export.catalogue import part
from design.export.vectors import vector
from design.input_loop import POINTS, InputLoop, command_margins
from design.margins import branch_responses
from design.open_loops import by_python_control
from plants import Wrist
from plants.effects import DeadTime
from plants.errors import InputError
from plants.wrist import SAMPLE_TIME

WRIST = Wrist.flexion()


@dataclass(frozen=True)
class Integral:
    """The command creeps towards the reference, and is drawn back by the pressure."""

    Ki: Any
    damping: Any
    gain: Any = 49.4
    low: Any = 0.0
    high: Any = 4.0

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledIntegral":
        return SampledIntegral(self.Ki * dt, self.damping * dt, self.gain, self.low, self.high)

    def holding(self, pressure: Any, seen: Measured | None = None) -> "IntegralState":
        return IntegralState(pressure)

    def command(self, state: "IntegralState") -> Any:
        return state.target / self.gain


@remembers(target=("kPa", "pressure that is commanded"))
class IntegralState(NamedTuple):
    target: Any


class SampledIntegral(NamedTuple):
    Ki_dt: Any
    damping_dt: Any
    gain: Any
    low: Any
    high: Any

    def act(self, state: IntegralState, seen: Measured) -> tuple[IntegralState, Any]:
        wanted = state.target + self.Ki_dt * seen.error - self.damping_dt * (state.target - seen.pressure)
        command = np.minimum(np.maximum(wanted / self.gain, self.low), self.high)
        return IntegralState(command * self.gain), command


@pytest.fixture
def registered():
    """The controller, known while a test runs."""
    register("integral", lambda wrist: Integral(6.0, 0.5, wrist.regulator.gain), "Integral control")
    yield
    del REGISTERED["integral"]


def test_it_is_compared_with_the_margins_of_its_law(registered):
    (own,) = controllers(WRIST, PI(3.1, 10.4))["integral"]
    assert all(np.isfinite(m[0].settling_time_s) for m in on_tasks(WRIST, [own]).values())
    Ms, delay = command_margins(WRIST, own)
    # By hand: target+ = (1 - damping dt) target + Ki dt e + damping dt P.
    z = np.exp(1j * np.geomspace(1e-2, 3000.0, 4000) * SAMPLE_TIME)
    found = []
    for b in ("transit", "line1", "line2"):
        for rate in ("slow", "fast"):
            response = WRIST.linearised(b, rate)(z)
            k = WRIST.regulator.k_slow if rate == "slow" else WRIST.regulator.k_fast
            share = -np.expm1(-k * SAMPLE_TIME)
            pressure = 49.4 * share / (z - 1.0 + share)
            found.append((6.0 * response - 0.5 * pressure) * SAMPLE_TIME / (z - 1.0 + 0.5 * SAMPLE_TIME))
    # The law answers in the sample that it measures in, hence z times what a state would give.
    expected = max(np.abs(1.0 / (1.0 + z * loop / 49.4)).max() for loop in found)
    assert pytest.approx(expected, rel=1e-4) == Ms
    assert 0.0 < delay < np.inf
    late, _ = command_margins(WRIST + DeadTime(0.05), own)
    assert late > Ms


def test_it_is_exported(registered):
    made = part("integral", "flexion", WRIST)
    assert (made.title, [f.member for f in made.inputs]) == (
        "Integral control",
        ["reference_deg", "angle_deg", "pressure_kPa"],
    )
    assert [f.member for f in made.state] == ["target_kPa"]
    assert np.isfinite(vector(made, WRIST, 300).rows[:, 3]).all()
    with pytest.raises(InputError, match=r"one of pi, .*, integral$"):
        part("derivative", "flexion", WRIST)


def test_a_state_without_units_is_refused_by_name(registered):
    class Mute(NamedTuple):
        target: Any

    class Unspoken(Integral):
        def holding(self, pressure: Any, seen: Measured | None = None) -> Any:
            return Mute(pressure)

    register("integral", lambda wrist: Unspoken(6.0, 0.5))
    with pytest.raises(InputError, match=r"Mute\.target: a state without unit or meaning; decorate Mute"):
        part("integral", "flexion", WRIST)


@pytest.mark.parametrize("gains", [(1.2, 2.2), (3.1, 10.4)])
def test_the_law_of_a_PI_has_the_margins_of_python_control(gains):
    branches = branch_responses(WRIST, POINTS)
    rows = by_python_control(WRIST, PI(*gains))
    for controller in (PI(*gains), FeedforwardPI.of(WRIST, Kp=gains[0], Ki=gains[1])):
        found = InputLoop.at_command(controller, branches).margins(branches)
        assert float(found.Ms) == pytest.approx(max(r["Ms"] for r in rows), rel=1e-5)
        assert float(found.delay_margin_s) == pytest.approx(min(r["delay_margin_s"] for r in rows), rel=1e-4)


def test_a_linear_law_is_its_state_space_sample_by_sample():
    controller = LQI(Ke=60.0, Kd=-50.0, Kq=-14.0, jump=3.5, slope=0.2, Tw=0.16, bandwidth=20.0)
    law, c = linearised(controller), controller.sampled()
    state, m = controller.holding(98.8, Measured(0.0, 0.0, 98.8)), np.zeros(len(law.a))
    rng = np.random.default_rng(0)
    for angle, pressure in rng.normal(0.0, 0.1, (50, 2)):
        seen = np.array([angle, pressure])
        state, command = c.act(state, Measured(-angle, angle, 98.8 + pressure))
        assert float(command) == pytest.approx(98.8 / 49.4 + law.c @ m + law.d @ seen, abs=1e-12)
        m = law.a @ m + law.b @ seen
