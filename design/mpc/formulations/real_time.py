"""Nonlinear MPC on the exact sampled step by real-time iteration, (b).

Every period one Gauss-Newton step of the nonlinear problem is taken, about the plan of the period
before, shifted: Diehl, Bock & Schloder, SIAM J. Control Optim. 43 (2005) 1714, doi
10.1137/S0363012902400713; Gros, Zanon, Quirynen, Bemporad & Diehl, Int. J. Control 93 (2020) 62, doi
10.1080/00207179.2016.1222553.  In the preparation, after the command is out, the exact step is
linearised and condensed about the state that is predicted; in the feedback, the measured state enters
the linear term and one dense QP is solved.

The memory of the hysteresis is a state like the others, and the plan bends at its lines.  Where no
command of the plan moves the angle (the virgin curve) the gradient is zero and no step can be
taken: there, at the start, and when the reference jumps, the plan is that of the linear MPC (a) if that
costs less, its commands played through the exact step.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.mpc import observer, qp
from design.mpc.fallback import Attempt, Fallback, Info, MPCState, begin, step
from design.mpc.formulations import linear
from design.mpc.prediction import Linearised, differentiated, linearise, roll, start_of
from design.mpc.problem import Believed, MPCProblem
from plants.kernel import pytrees as tree

Array = NDArray[np.float64]

JUMP = 0.1
"""Change of the reference [deg] in a period that has the plan compared with that of (a)."""

STUCK = 0.02
"""Error [deg] at the end of a plan that stays on the virgin curve, above which the same is done."""

FAR_ANGLE, FAR = 0.1, 0.5
"""How far angle and static angle [deg], and the rest of a state [kPa; virgin], may be from that which was
prepared for before it is prepared for again: a line that lies in between would not be seen."""


@dataclass(frozen=True)
class RealTimeMPC:
    """The controller (b): pure `init` and `step`.

    >>> from plants import Wrist
    >>> controller = real_time_mpc(MPCProblem(Wrist.flexion()))
    >>> state = controller.init(Measured(0.0, 0.0, 100.0))
    >>> state, command, info = controller.step(state, Measured(15.0, 0.0, 100.0))
    >>> round(command, 3), info.rung
    (4.0, 'solved')
    """

    first: linear.LinearMPC
    weights: Array
    outputs: Array
    moves: Array
    solve: qp.Solve
    differentiated: list[int]
    far: Array

    @property
    def problem(self) -> MPCProblem:
        """What is solved."""
        return self.first.problem

    @property
    def coefficients(self) -> Array:
        """Of the model, flat."""
        return self.first.coefficients

    @property
    def gains(self) -> observer.Gains:
        """Gains of the observer."""
        return self.first.gains

    @property
    def fallback(self) -> Fallback:
        """Settings of the ladder."""
        return self.first.fallback

    def on(self, problem: MPCProblem) -> "RealTimeMPC":
        """The same controller of another problem."""
        return real_time_mpc(problem, self.fallback)

    def init(self, seen: Measured) -> MPCState:
        """The state in which it holds a wrist that is seen to rest."""
        return begin(self, seen)

    def step(self, state: MPCState, seen: Measured) -> tuple[MPCState, float, Info]:
        """State after, command [V] of, and record of, one period."""
        return step(self, state, seen)

    def attempt(self, state: MPCState, believed: Believed, reference: float) -> Attempt:
        """The feedback: one QP about the prepared plan, prepared again where that does not fit."""
        N, start = self.problem.horizon, start_of(believed)
        about: Linearised | None = state.prepared
        active = state.active
        if state.plan is None or not abs(reference - state.reference) < JUMP:
            about = None
        elif about is None or (np.abs(start - about.start) > self.far).any():
            about = self._linearised(believed, state.plan)
        if about is None or self._stuck(about, believed, reference):
            about = self._linearised(believed, self.start_plan(state, believed, reference))
            active = active * 0
        commands = about.commands
        off = start - about.start
        missing = (
            about.angles + about.by_start[:, :-1] @ off[self.differentiated] - about.by_command @ commands
        )
        missing += believed.shift - reference
        missing += about.by_start[:, -1] * ((believed.lack - about.lack) / self.problem.wrist.regulator.gain)
        f = (self.outputs @ missing) @ about.by_command
        f[0] -= self.problem.weights.move * state.command
        low, high = self.problem.bounds(state.command)
        clock = self.fallback.clock
        started = clock()
        found = self.solve(about.hessian, f, low, high, active)
        took = clock() - started
        ahead = np.concatenate([found.x[1:], found.x[-1:]])
        return Attempt(
            float(found.x[0]), ahead, qp.shifted(found.active, N), found.found, found.reason,
            found.iterations, took,
        )  # fmt: skip

    def start_plan(self, state: MPCState, believed: Believed, reference: float) -> Array:
        """Commands [V], shape (N,), to linearise about afresh: the shifted plan, the linear MPC's, or the
        command held, whichever costs least through the exact step."""
        N, of = self.problem.horizon, self.first.planner
        idle = np.zeros(2 * N, dtype=np.int32)
        angles, found = linear.plan(of, believed, state.command, reference, idle)
        plans = [np.full(N, state.command)] if state.plan is None else [state.plan]
        if found.found:
            plans.append(linear.follow(of, believed, state.command, angles))
        return min(plans, key=lambda v: self.cost(believed, v, state.command, reference))

    def cost(self, believed: Believed, commands: Array, before: float, reference: float) -> float:
        """What a plan [V] costs through the exact step, `before` [V] being the command before it."""
        states = roll(self.problem, self.coefficients, start_of(believed), believed.lack, commands)
        return self.problem.cost(states[:, -1] + believed.shift, commands, before, reference)

    def resume(self, plan: Array, believed: Believed, command: float) -> tuple[float, Array]:
        """The first command [V] of a plan, and the rest of it."""
        return float(plan[0]), np.concatenate([plan[1:], plan[-1:]])

    def prepare(self, state: MPCState) -> Linearised | None:
        """Linearise and condense about the shifted plan, from the state that is predicted."""
        if state.plan is None:
            return None
        held, believed = np.array([state.command]), state.believed
        ahead = roll(self.problem, self.coefficients, start_of(believed), believed.lack, held)[0]
        return linearise(
            self.problem, self.coefficients, self.weights, self.moves, ahead, believed.lack, state.plan
        )

    def _linearised(self, believed: Believed, plan: Array) -> Linearised:
        return linearise(
            self.problem, self.coefficients, self.weights, self.moves, start_of(believed), believed.lack, plan
        )

    def _stuck(self, about: Linearised, believed: Believed, reference: float) -> bool:
        """Whether a plan stays on the virgin curve away from the reference."""
        if not self.problem.loop.DEAD_ZONE:
            return False
        last = tree.like(believed.plant, about.states[-1])
        return bool(last.memory.virgin > 0.5 and abs(last.angle + believed.shift - reference) > STUCK)


def real_time_mpc(problem: MPCProblem, fallback: Fallback | None = None) -> RealTimeMPC:
    """The nonlinear MPC of a problem; raises InputError where daqp is not installed."""
    first = linear.linear_mpc(problem, fallback)
    return RealTimeMPC(
        first,
        problem.stage_weights,
        problem.angle_hessian,
        problem.move_hessian,
        qp.solver(problem.differences),
        differentiated(problem.shape),
        np.array(
            [FAR_ANGLE if n in ("memory.h", "angle") else FAR for n in tree.names(problem.wrist.rest())]
        ),
    )
