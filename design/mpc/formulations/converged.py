"""Nonlinear MPC, every period solved to convergence and from many starts, (d): what the others give away.

Same problem, observer and ladder of fallbacks as the real-time iteration (b), which takes one step where
this takes as many as it needs.  In each period:

1. starts: the plan before, shifted; (a)'s plan through the exact step; the command held; and, of plans
   that throttle fully to and fro and then hold the reference on either line, those that cost least;
2. from each, Gauss-Newton steps with a line search on the exact cost, until none lowers it;
3. from the best, IPOPT with exact second derivatives (`design.mpc.nlp`).

The best by the exact cost is taken, so that a step that leads nowhere, at one of the problem's corners, is
never worse than its start.  A minimum that is found is a local one; that there are several (the
wrist overshoots on one line or comes back on the other) is why there are many starts.  It takes some
0.1 to 1 s a period: a reference, not for use.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.mpc import fallback, nlp, observer
from design.mpc.fallback import Attempt, Fallback, Info, MPCState
from design.mpc.formulations.linear import follow
from design.mpc.formulations.linear import plan as linear_plan
from design.mpc.formulations.real_time import RealTimeMPC, real_time_mpc
from design.mpc.prediction import linearise, start_of
from design.mpc.problem import Believed, MPCProblem

Array = NDArray[np.float64]

FORTH, BACK = 20, 8
"""Periods of full throttle to and fro, at most, in the plans that are tried."""

DESCENTS = 6
"""Of these, how many are descended from: the best of each time of throttling back and each line, and of
those the best."""

SMALLEST = 1e-12
"""Relative gain of a step below which a descent ends."""

STEPS = 100
"""Of a descent, at most."""

NEGLIGIBLE = 1e-4
"""Cost of a plan [deg^2] below which no better one is looked for: it could not save more than that, and a
step of 15 deg costs some thousand."""


class Plan(NamedTuple):
    """Commands [V], shape (N,), and their cost through the exact step."""

    commands: Array
    cost: float


@dataclass(frozen=True)
class ConvergedMPC:
    """The controller (d): pure `init` and `step`.

    >>> from plants import Wrist
    >>> controller = converged_mpc(MPCProblem(Wrist.flexion(), horizon=10))
    >>> state = controller.init(Measured(0.0, 0.0, 116.0))
    >>> state, command, info = controller.step(state, Measured(3.0, 0.0, 100.0))
    >>> 0.0 <= command <= 4.0, info.rung
    (True, 'solved')
    """

    inner: RealTimeMPC
    converge: nlp.Converge

    @property
    def problem(self) -> MPCProblem:
        """What is solved."""
        return self.inner.problem

    @property
    def coefficients(self) -> Array:
        """Of the model, flat."""
        return self.inner.coefficients

    @property
    def gains(self) -> observer.Gains:
        """Gains of the observer."""
        return self.inner.gains

    @property
    def fallback(self) -> Fallback:
        """Settings of the ladder."""
        return self.inner.fallback

    def init(self, seen: Measured) -> MPCState:
        """The state in which it holds a wrist that is seen to rest."""
        return fallback.begin(self, seen)

    def step(self, state: MPCState, seen: Measured) -> tuple[MPCState, float, Info]:
        """State after, command [V] of, and record of, one period."""
        return fallback.step(self, state, seen)

    def attempt(self, state: MPCState, believed: Believed, reference: float) -> Attempt:
        """Solve; iterations are IPOPT's."""
        clock = self.fallback.clock
        started = clock()
        shifted = [] if state.plan is None else [state.plan]
        best, iterations = self.solve(believed, state.command, reference, shifted)
        ahead = np.concatenate([best.commands[1:], best.commands[-1:]])
        took = clock() - started
        return Attempt(
            float(best.commands[0]), ahead, state.active, bool(np.isfinite(best.cost)), "", iterations, took
        )

    def resume(self, plan: Array, believed: Believed, command: float) -> tuple[float, Array]:
        """The first command [V] of a plan, and the rest of it."""
        return self.inner.resume(plan, believed, command)

    def prepare(self, state: MPCState) -> None:
        """Nothing: it is never in time."""

    def solve(
        self, believed: Believed, before: float, reference: float, more: list[Array]
    ) -> tuple[Plan, int]:
        """The best plan found, and IPOPT's iterations; `before` [V]: the command of the period before;
        `more`: plans [V] to start from beside those of this controller."""
        descended = [self.descend(believed, v, before, reference) for v in more]
        best = min(descended, key=lambda plan: plan.cost, default=None)
        if best is not None and best.cost < NEGLIGIBLE:
            return best, 0
        for v in self.starts(believed, before, reference):
            descended.append(self.descend(believed, v, before, reference))
        best = min(descended, key=lambda plan: plan.cost)
        answer = self.converge(believed, best.commands, before, reference)
        polished = self._judged(believed, answer.commands, before, reference)
        return min(polished, best, key=lambda plan: plan.cost), answer.iterations

    def starts(self, believed: Believed, before: float, reference: float) -> list[Array]:
        """Plans [V], within range and rate, that lead to different minima."""
        N, of = self.problem.horizon, self.inner.first.planner
        angles, found = linear_plan(of, believed, before, reference, np.zeros(2 * N, dtype=np.int32))
        first = [np.full(N, before)] + ([follow(of, believed, before, angles)] if found.found else [])
        best = [
            min((self._judged(believed, v, before, reference) for v in family), key=lambda plan: plan.cost)
            for family in self._throttled(believed, before, reference)
        ]
        return first + [p.commands for p in sorted(best, key=lambda plan: plan.cost)[:DESCENTS]]

    def _throttled(self, believed: Believed, before: float, reference: float) -> list[Array]:
        """Full throttle towards the reference for some periods, back for some, then a line's pressure:
        plans [V] of (forth, N), for each time of throttling back and each line."""
        N, p, loop = self.problem.horizon, self.problem, self.problem.loop
        aim = reference - believed.shift
        to, back = (p.high, p.low) if aim > believed.plant.memory.h else (p.low, p.high)
        pressures = (loop.ascending_pressure(aim), loop.descending_pressure(aim))
        families = []
        for k in range(min(N, BACK) + 1):
            for pressure in pressures:
                level = (pressure - believed.lack) / p.wrist.regulator.gain
                forth = range(min(N - k, FORTH) + 1)
                plans = [np.repeat([to, back, level], [j, k, N - j - k]) for j in forth]
                families.append(nlp.within(p, np.array(plans, float), before))
        return families

    def descend(self, believed: Believed, plan: Array, before: float, reference: float) -> Plan:
        """Gauss-Newton steps from a plan [V], each as long as lowers the exact cost."""
        best, problem = self._judged(believed, plan, before, reference), self.problem
        low, high = problem.bounds(before)
        start, idle = start_of(believed), np.zeros(2 * problem.horizon, dtype=np.int32)
        weights, moves = self.inner.weights, self.inner.moves
        for _ in range(STEPS):
            v = best.commands
            about = linearise(problem, self.coefficients, weights, moves, start, believed.lack, v)
            missing = about.angles - about.by_command @ v + believed.shift - reference
            f = (weights * missing) @ about.by_command
            f[0] -= problem.weights.move * before
            found = self.inner.solve(about.hessian, f, low, high, idle)
            if not found.found:
                break
            better = self._along(believed, best, found.x - v, before, reference)
            if not better.cost < best.cost * (1.0 - SMALLEST):
                break
            best = better
        return best

    def _along(self, believed: Believed, at: Plan, way: Array, before: float, reference: float) -> Plan:
        """The first plan that costs less, the step halved until there is one; else the plan itself."""
        length = 1.0
        while length > 1e-5:
            tried = self._judged(believed, at.commands + length * way, before, reference)
            if tried.cost < at.cost:
                return tried
            length *= 0.5
        return at

    def _judged(self, believed: Believed, commands: Array, before: float, reference: float) -> Plan:
        return Plan(commands, self.inner.cost(believed, commands, before, reference))


def converged_mpc(problem: MPCProblem, fallback: Fallback | None = None) -> ConvergedMPC:
    """The converged MPC of a problem; raises InputError where daqp is not installed."""
    return ConvergedMPC(real_time_mpc(problem, fallback), nlp.converger(problem))
