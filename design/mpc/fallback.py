"""One period of an MPC, whatever it solves, and what it does when that fails: a ladder of fallbacks.

1. The QP's answer, if it was found in time and the sensors' values are finite.
2. The plan of the period before, shifted, for as many periods in a row as `patience` says.
3. A PI on the measured angle, its integrator set so that the command does not jump (bumpless transfer:
   Astrom & Hagglund, Advanced PID Control (2006)); without a measurement of the angle
   the command is held.

The first period that solves again takes over.  State in, state out; the clock is the only thing that is
looked at from outside.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from design.controllers import pi
from design.controllers.controller import Measured
from design.controllers.measurement.plausible import LastBelieved, believed
from design.controllers.pi import PI, PIState
from design.mpc import observer, qp
from design.mpc.prediction import roll, start_of
from design.mpc.problem import Believed, MPCProblem
from plants.errors import InputError
from plants.kernel import pytrees as tree
from plants.wrist import Wrist

Array = NDArray[np.float64]

SOLVED, SHIFTED, BY_PI, HELD = "solved", "shifted plan", "PI", "held"
"""Rungs of the ladder, from the top."""


def slow_pi(wrist: Wrist | None = None) -> PI:
    """The PI below the plans, of a wrist, the built-in one where not given.

    >>> slow_pi(Wrist.flexion()) == slow_pi()
    True
    """
    if wrist is None:
        return PI(1.2, 2.2)
    rig = wrist.rig
    Kp, Ki = rig.scaled(1.2, "kPa/deg"), rig.scaled(2.2, "kPa/(deg s)")
    return PI.of(wrist, Kp, Ki)


@dataclass(frozen=True)
class Fallback:
    """patience: periods that a shifted plan may go on for; pi: the controller below it (`slow_pi`);
    budget [s]: time from the measurement to the command after which an answer is late (None: never);
    clock: of ns.
    Raises InputError for a patience that is negative or a budget that is not positive."""

    patience: int = 5
    pi: PI = field(default_factory=slow_pi)
    budget: float | None = None
    clock: Callable[[], int] = time.perf_counter_ns

    def __post_init__(self) -> None:
        if self.patience < 0:
            raise InputError(f"patience of the MPC's fallback is {self.patience}: give 0 or more periods")
        if self.budget is not None and not self.budget > 0.0:
            raise InputError(f"time budget of the MPC is {self.budget} s: give a positive time, or none")


class Info(NamedTuple):
    """How a period went: the rung of the ladder, why it is not the first, iterations of the solver, and
    times [ns] of the preparation of the next period, of the solver, and of all the rest."""

    rung: str
    reason: str
    iterations: int
    preparation_ns: int
    solve_ns: int
    wrapper_ns: int

    @property
    def total_ns(self) -> int:
        """The whole step [ns]."""
        return self.preparation_ns + self.solve_ns + self.wrapper_ns


class MPCState(NamedTuple):
    """What an MPC remembers: what it believes of the wrist; the command [V] and reference [deg] of the
    period before; the plan from now on, in the controller's own terms; the guess of the active set; what
    was prepared; failures in a row; state of the PI where that is in charge, else None; the last readings
    of angle and pressure that could be believed; commands [V] before it that a known dead time still held
    back when the last period began, the oldest first."""

    believed: Believed
    command: float
    reference: float
    plan: Array | None
    active: qp.Active
    prepared: Any
    failures: int
    pi: PIState | None
    seen_angle: LastBelieved = LastBelieved(0.0)
    seen_pressure: LastBelieved = LastBelieved(0.0)
    under_way: tuple[float, ...] = ()


class Attempt(NamedTuple):
    """Command [V] and plan from the period after on, the guess of the active set for that, whether they
    were found and if not why, iterations, and time [ns] in the solver."""

    command: float
    plan: Array | None
    active: qp.Active
    found: bool
    reason: str
    iterations: int
    solve_ns: int


class Planning(Protocol):
    """What differs from one MPC to the other."""

    @property
    def problem(self) -> MPCProblem:
        """What is solved."""
        ...

    @property
    def coefficients(self) -> Array:
        """Of the model, flat."""
        ...

    @property
    def fallback(self) -> Fallback:
        """Settings of the ladder."""
        ...

    @property
    def gains(self) -> observer.Gains:
        """Gains of the observer."""
        ...

    def attempt(self, state: MPCState, believed: Believed, reference: float) -> Attempt:
        """Solve."""
        ...

    def resume(self, plan: Array, believed: Believed, command: float) -> tuple[float, Array]:
        """Command [V] of a plan for the period that begins, and the plan from the next one on."""
        ...

    def prepare(self, state: MPCState) -> Any:
        """Whatever can be done before the next measurement."""
        ...


def begin(of: Planning, seen: Measured) -> MPCState:
    """The state in which an MPC holds a wrist that is seen to rest, as far as the range of its command
    allows; where what is seen cannot be (`design.controllers.measurement.plausible`), the wrist as it
    is built."""
    pressure, angle, _ = of.problem.plausible.start(float(seen.pressure), float(seen.angle))
    found, N = observer.begin(angle, pressure, of.problem.wrist), of.problem.horizon
    belief = tree.like(found, [float(x) for x in tree.leaves(found)])
    command = min(max(pressure / of.problem.wrist.regulator.gain, of.problem.low), of.problem.high)
    idle, last = np.zeros(2 * N, dtype=np.int32), (LastBelieved(angle), LastBelieved(pressure))
    under_way = (command,) * of.problem.delay
    return MPCState(belief, command, float("nan"), None, idle, None, 0, None, *last, under_way=under_way)


def _screened(of: Planning, state: MPCState, seen: Measured) -> tuple[Measured, LastBelieved, LastBelieved]:
    """What is seen, a reading that cannot be believed being no number, and what is remembered of it."""
    limits, period = of.problem.plausible, of.problem.period
    angle, a = believed(state.seen_angle, float(seen.angle), limits.angle.sampled(period))
    pressure, p = believed(state.seen_pressure, float(seen.pressure), limits.pressure.sampled(period))
    shown = Measured(
        float(seen.error) if a else float("nan"),
        float(seen.angle) if a else float("nan"),
        float(seen.pressure) if p else float("nan"),
    )
    last = [LastBelieved(float(x.value), float(x.age)) for x in (angle, pressure)]
    return shown, last[0], last[1]


def step(of: Planning, state: MPCState, seen: Measured) -> tuple[MPCState, float, Info]:
    """One period: state after, command [V] to be held, and how it went."""
    ladder, clock = of.fallback, of.fallback.clock
    started = clock()
    seen, *last = _screened(of, state, seen)
    acted, *pending = (*state.under_way, state.command)
    belief = observer.update(state.believed, acted, seen, of.gains, of.coefficients)
    ahead = _ahead(of, belief, pending)
    asked = float(seen.error) + float(seen.angle)
    reference = asked if isfinite(asked) else state.reference
    tried = _attempt(of, state, ahead, reference, seen)
    late = ladder.budget is not None and clock() - started > ladder.budget * 1e9
    if tried.found and not late:
        command, after = tried.command, (tried.plan, tried.active, 0, None)
        rung, reason = SOLVED, ""
    else:
        reason = tried.reason or "late"
        command, rung, after = _descend(of, state, ahead, seen)
    command = bounded(of.problem, command, state.command)
    plan, active, failures, integral = after
    new = MPCState(belief, command, reference, plan, active, None, failures, integral, *last)
    new = new._replace(under_way=tuple(pending))
    given = clock()
    new = new._replace(prepared=of.prepare(new._replace(believed=ahead))) if rung == SOLVED else new
    ended = clock()
    times = ended - given, tried.solve_ns, given - started - tried.solve_ns
    return new, command, Info(rung, reason, tried.iterations, *times)


def _ahead(of: Planning, belief: Believed, pending: list[float]) -> Believed:
    """What is believed of the wrist when the command of now begins to act: the model's run under commands [V]
    that a known dead time holds back (a predictor of Smith's kind, of the model with its hysteresis)."""
    if not pending:
        return belief
    states = roll(of.problem, of.coefficients, start_of(belief), belief.lack, np.array(pending))
    return belief._replace(plant=tree.like(belief.plant, states[-1].tolist()))


def _attempt(of: Planning, state: MPCState, believed: Believed, reference: float, seen: Measured) -> Attempt:
    failed = Attempt(state.command, None, state.active, False, "", 0, 0)
    if not (isfinite(float(seen.angle)) and isfinite(float(seen.pressure))):
        return failed._replace(reason="a sensor's value is no number, or none that a plant can show")
    if not isfinite(reference):
        return failed._replace(reason="no reference")
    try:
        found = of.attempt(state, believed, reference)
    except (ArithmeticError, RuntimeError, ValueError) as error:
        return failed._replace(reason=f"solver failed: {error}")
    if found.found and not isfinite(found.command):
        return found._replace(found=False, reason="the command is not finite")
    return found


def _descend(of: Planning, state: MPCState, believed: Believed, seen: Measured) -> tuple[float, str, Any]:
    """Command [V], rung, and (plan, active, failures, PI's state) below the first rung."""
    ladder, failures = of.fallback, state.failures + 1
    idle = state.active * 0
    if state.plan is not None and failures <= ladder.patience:
        command, plan = of.resume(state.plan, believed, state.command)
        if isfinite(command):
            return command, SHIFTED, (plan, idle, failures, None)
    error, c = float(seen.error), ladder.pi.sampled(of.problem.period)
    if not isfinite(error):
        return state.command, HELD, (None, idle, failures, state.pi)
    integral = state.pi or c.following(PIState(0.0), seen, state.command)
    after, command = pi.step(integral, error, c)
    return float(command), BY_PI, (None, idle, failures, PIState(float(after.integral)))


def bounded(problem: MPCProblem, command: float, before: float) -> float:
    """A command [V] within range and rate of that before [V]."""
    moved = min(max(command, before - problem.rate), before + problem.rate)
    return min(max(moved, problem.low), problem.high)
