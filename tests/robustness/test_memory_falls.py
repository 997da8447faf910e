"""Along a loop that meets one line, and behind dead time, the function falls in every sample at its rate.

The loop is stepped here in plain Python, with laws of the regulator that the function was not made for, and
the function evaluated from what is under way itself.
"""

from math import exp, log
from typing import Any, NamedTuple

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.box import box_of
from design.robustness.certificates.memory.form import LineForm, WindowForm
from design.robustness.certificates.memory.ladder import plants_of
from design.robustness.certificates.memory.loop import FixedLawLoop, growth_of
from design.robustness.certificates.memory.programme import common, line
from design.robustness.loop_model import LoopModel
from plants import Wrist
from plants.parameters.files import built_in

FLEXION = Wrist.flexion()
GAUSS = np.polynomial.legendre.leggauss(60)


class Law(NamedTuple):
    """Of the regulator."""

    e0: float
    slow: float = 0.55
    fast: float = 9.0


def share(q: Any, law: Law, dt: float) -> Any:
    """The declared law, written apart."""
    w = q * q / (q * q + law.e0 * law.e0)
    slow, fast = law.slow * dt, law.fast * dt
    found = (1 - w) * (1 - exp(-slow)) + w * (1 - exp(-fast))
    return found - w * (1 - w) * (fast - slow) * ((1 - w) * slow + w * fast - (fast - slow) / 2)


def integral(q: float, law: Law, low: float, dt: float) -> float:
    """int_0^q psi by Gauss's rule."""
    at, weights = 0.5 * q * (GAUSS[0] + 1.0), GAUSS[1]
    return float(0.5 * q * np.dot(weights, (share(at, law, dt) - low) * at / dt))


def value(
    form: WindowForm, loop: FixedLawLoop, x: list[float], late: list[float], g: float, law: Law
) -> float:
    """V of a state and of what is under way [kPa/s], last sent first."""
    N, dt = loop.samples, loop.model.dt
    u = [z * g**-i for i, z in enumerate(late, start=1)]
    table = np.asarray(loop.window.table, float)
    w = np.array([*x, *(float(np.dot(row[:N], u)) / N for row in table)])
    window = dt * sum((form.S + form.R * (N + 1 - i) * dt) * z * z for i, z in enumerate(u, start=1))
    popov = 2.0 * form.popov * integral(x[2], law, float(loop.law.low), dt)
    return float(w @ form.P @ w) + window + popov


class OneLine:
    """Error, static angle ahead, pressure error; distance F to the line; changes of command under way."""

    def __init__(self, loop: FixedLawLoop, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.loop, self.law = loop, Law(float(10.0 ** random.uniform(-1.0, 2.0)))
        self.x = [float(v) for v in random.normal(size=3) * [3.0, 3.0, 10.0]]
        self.F = float(random.choice([0.0, 0.02, 0.5]))
        self.late = [float(v) for v in random.normal(size=loop.samples) * 20.0]

    def step(self, slopes: tuple[float, float], Tw: float | None = None) -> None:
        inner, outer = slopes
        m, (e, d, q) = self.loop.model, self.x
        dt, ratio = m.dt, m.dt / (Tw or m.Tw)
        phi = share(q, self.law, dt) * q
        alone = min(phi, self.F)  # on the transit, until the line is met
        h = inner * alone + outer * (phi - alone)
        keep, mean = exp(-ratio), (1.0 - exp(-ratio)) / ratio
        dy = (1.0 - keep) * d + (1.0 - mean) * h
        sent = (m.Kp * -dy + m.Ki * dt * e) / dt
        arrives = self.late.pop() if self.late else sent
        if self.loop.samples:
            self.late.insert(0, sent)
        self.x = [e - dy, d + h - dy, q - phi + dt * arrives]
        self.F -= alone


def level(form: LineForm, run: OneLine, g: float) -> float:
    near = value(form.line, run.loop, run.x, run.late, g, run.law)
    n = run.loop.states
    u = [z * g**-i for i, z in enumerate(run.late, start=1)]
    table = np.asarray(run.loop.window.table, float)
    w = np.array([*run.x, *(float(np.dot(row[: len(u)], u)) / max(len(u), 1) for row in table)])
    assert len(w) == n
    near += 2.0 * run.F * float(form.cross @ w) - form.gap * run.F**2
    return max(near, value(form.transit, run.loop, run.x, run.late, g, run.law))


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0, 5, 50])
@pytest.mark.parametrize("gains", [(2.0, 6.0), (3.13, 10.4)])
def test_a_function_with_memory_falls_on_the_line_off_it_and_in_between(
    gains: tuple[float, float], samples: int
) -> None:
    loop = FixedLawLoop.of(LoopModel.of(FLEXION, PI(*gains)), samples)
    form = line(loop, (0.36,), 0.1).form
    assert form is not None
    g = float(growth_of(0.1, loop.model.dt))
    met = left = 0
    for seed in range(6):
        run = OneLine(loop, seed)
        before = level(form, run, g)
        for _ in range(600):
            away = run.F
            run.step((form.inner[0], form.outer[0]))
            met, left = met + (away > 0.0 == run.F), left + (away == 0.0 < run.F)
            after = level(form, run, g)
            assert after <= before / g**2 * (1.0 + 1e-9)
            before = after
    assert met
    assert left


@pytest.mark.parametrize("samples", [0, 50])
def test_one_function_falls_whatever_the_slope_does_at_every_sample(samples: int) -> None:
    loop = FixedLawLoop.of(LoopModel.of(FLEXION, PI(2.0, 4.0)), samples)
    form = common(loop, 0.05).form
    assert form is not None
    g, random = float(growth_of(0.05, loop.model.dt)), np.random.default_rng(7)
    for seed in range(6):
        run = OneLine(loop, seed)
        before = value(form.form, loop, run.x, run.late, g, run.law)
        for _ in range(300):
            slope = float(random.choice([0.0803, 0.36, random.uniform(0.0803, 0.36)]))
            run.step((slope, slope))
            after = value(form.form, loop, run.x, run.late, g, run.law)
            assert after <= before / g**2 * (1.0 + 1e-9)
            before = after


def test_a_linear_loop_is_certified_to_the_rate_of_its_slowest_pole_and_no_further() -> None:
    model = LoopModel(2.0, 6.0, {"only": 0.36}, 2.0, 2.0, 0.16)
    pole = max(abs(np.linalg.eigvals(model.sampled_matrix(0.36, 2.0))))
    rate = -log(pole) / model.dt
    loop = FixedLawLoop.of(model, 0)
    assert common(loop, 0.99 * rate).form is not None
    assert common(loop, 1.01 * rate).form is None


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0, 50])
def test_a_function_for_a_box_falls_whichever_plant_of_it_it_is_and_while_slopes_and_lag_drift(
    samples: int,
) -> None:
    pi = PI.of(FLEXION, 2.0, 6.0)
    plants = plants_of(box_of(built_in("flexion")), pi)
    loop = FixedLawLoop.of(LoopModel.of(FLEXION, pi), samples, plants)
    outer, inner, lag = plants.slopes["line1"], plants.slopes["transit"], plants.lag
    form = line(loop, outer, 0.1).form
    assert form is not None
    g, random = float(growth_of(0.1, loop.model.dt)), np.random.default_rng(11)
    for seed in range(6):
        run = OneLine(loop, seed)
        law = (random.choice(plants.slow), random.choice(plants.fast))
        run.law = Law(run.law.e0, *(float(k) for k in law))
        before = level(form, run, g)
        for _ in range(300):
            s, a, T = (float(random.choice([*of, random.uniform(*of)])) for of in (inner, outer, lag))
            run.step((s, a), T)
            after = level(form, run, g)
            assert after <= before / g**2 * (1.0 + 1e-9)
            before = after
