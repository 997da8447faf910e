"""Trajectories that come close to the bound, by optimal control: direct multiple shooting in CasADi.

The step in the plus direction (the minus direction is its mirror image) has a known order of branches:
the pressure rises, the angle on the transit (or the virgin curve) and then on line 1; at one node the
pressure turns round, and then falls or holds, the angle on the transit and then on line 2.
With the node of the turn given, the hysteresis memory has no state of its own: the static angle is

    h = max(h0 + s (P - P0), line1(P))      before the turn (s = 0 on the virgin curve),
    h = min(hp + s (P - Pp), line2(P))      after it, hp and Pp being those of the turn,

two corners that are rounded by `CORNER`.  What is left are pressure and angle under the exact laws of
regulator and lag at 1 ms, commands held for `HOLD` samples, nodes at the ends of the holds (Bock & Plitt,
A multiple shooting algorithm, IFAC World Congress 1984), and a smooth problem for IPOPT (Wachter &
Biegler, Mathematical Programming 106 (2006) 25).  The turn is found by search from outside, every
candidate being judged by `design.limit.replay`, which knows nothing of branches and rounded corners;
what the optimiser predicts is never reported.  A local optimum is all that is found: the bound
says how far it can be from the best.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np

from design.limit.bound import Bound
from design.limit.monotone import prompt
from design.limit.replay import CommandReplay, replay
from plants import lag
from plants.actuator import regulator
from plants.dynamics import SampledWrist
from plants.effects.effect import dead_time_of
from plants.errors import InputError
from plants.hysteresis import FourSegment
from plants.kernel.graphs import graph
from plants.wrist import State, Wrist

Goal = Literal["settling", "iae"]

HOLD = 4
"""Samples of 1 ms that a command is held."""

TAIL = 0.16
"""Time [s] beyond the bound within which the wrist must have come to hold."""

CORNER = 1e-3
"""By how much the corners of the loop are rounded [deg]."""

MARGIN = 0.005
"""What the optimiser keeps of the settling band for itself, as a share of the band: the replay differs
from the prediction by the rounding of the corners."""

WEIGHT = 20.0
"""Price [deg s per deg and sample] of being outside the band after the bound, where the goal is to settle."""

_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 150, "tol": 1e-7, "mu_strategy": "adaptive"},
}


class Node(NamedTuple):
    """State of a shot at a node: pressure [kPa], angle [deg]."""

    pressure: Any
    angle: Any


class Shot(NamedTuple):
    """A node and the angles [deg] after each of the samples that led to it."""

    node: Node
    angles: tuple[Any, ...]


@dataclass(frozen=True)
class TimeOptimalProblem:
    """A step of a wrist without effects, in the direction `sign`, from a state to a reference [deg];
    bound: in samples."""

    wrist: Wrist
    state: State
    reference: float
    sign: float
    bound: int

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest command [V]."""
        return self.wrist.rig.command_range

    @property
    def loop(self) -> FourSegment:
        """The hysteresis, whose order of branches is known."""
        assert isinstance(self.wrist.hysteresis, FourSegment)
        return self.wrist.hysteresis

    @property
    def nodes(self) -> int:
        """Nodes of the horizon."""
        return -(-(self.bound + round(TAIL / self.wrist.rig.sample_time)) // HOLD)

    @property
    def band(self) -> float:
        """Half-width of the settling band [deg]."""
        return float(self.wrist.rig.task.band * abs(self.reference - self.state.angle))

    def ahead(self, pressure: Any) -> Any:
        """Static angle [deg] before the turn."""
        p, m = self.loop, self.state.memory
        line = (p.ascending if self.sign > 0 else p.descending)(pressure)
        transit = m.h + p.s * (1.0 - m.virgin) * (pressure - self.state.pressure)
        return self.sign * _larger(self.sign * transit, self.sign * line)

    def braking(self, pressure: Any, turn: Any) -> Any:
        """Static angle [deg] after the turn at a pressure `turn` [kPa]."""
        p = self.loop
        line = (p.descending if self.sign > 0 else p.ascending)(pressure)
        transit = self.ahead(turn) + p.s * (pressure - turn)
        return -self.sign * _larger(-self.sign * transit, -self.sign * line)


def _larger(a: Any, b: Any) -> Any:
    """The larger of two angles [deg], the corner rounded."""
    return 0.5 * (a + b + np.sqrt((a - b) ** 2 + CORNER**2))


def optimal(
    wrist: Wrist, reference: float, state: State, found: Bound, goal: Goal, begin: float
) -> CommandReplay:
    """The best replay found of a step to a reference [deg], for a wrist whose only effect may be a dead
    time, which shifts the response and asks for the same commands.

    `found`: its bound.  Raises InputError for a wrist with other effects, and for a step that the
    bound says, or the range of the commands, that it cannot be held.
    """
    if not isinstance(wrist.hysteresis, FourSegment):
        raise InputError(
            f"limit: no trajectory for the hysteresis law {wrist.hysteresis.NAME!r}, only for "
            f"{FourSegment.NAME!r}; ask for the bound alone"
        )
    if not all(e.only_delays for e in wrist.effects):
        names = ", ".join(f"{e.NAME} ({e.FORM})" for e in wrist.effects)
        raise InputError(f"limit: no trajectory for a wrist with {names}; ask for the bound alone")
    if not np.isfinite(found.settling_s):
        raise InputError(f"limit: {reference:g} deg is out of reach, no trajectory settles; ask for less")
    delay = int(float(dead_time_of(wrist.effects)) / wrist.rig.sample_time + 1e-9)
    bare, start = prompt(wrist, state)
    reached = max(round(found.settling_s / wrist.rig.sample_time) - delay, 1)
    problem = TimeOptimalProblem(bare, start, reference, float(np.sign(reference - state.angle)), reached)
    _check_hold(problem)

    @cache
    def tried(turn: int) -> tuple[tuple[float, float], CommandReplay]:
        judged = replay(wrist, _commands(problem, turn, goal), reference, state, begin)
        m = judged.metrics
        settling, iae = float(m.settling_time_s), float(m.iae_deg_s)
        return ((settling, iae) if goal == "settling" else (iae, settling)), judged

    return _best(lambda turn: tried(turn)[0], problem, lambda turn: tried(turn)[1])


def _best(
    score: Callable[[int], Any], problem: TimeOptimalProblem, of: Callable[[int], CommandReplay]
) -> CommandReplay:
    """The replay with the least score over turns: a coarse search, then the neighbours of the best."""
    last = problem.nodes - 2
    at = {min(max(round(share * problem.bound / HOLD), 1), last) for share in (0.84, 0.88, 0.92, 0.96, 1.0)}
    best = min(at, key=score)
    while True:
        near = [j for j in (best - 1, best + 1) if 1 <= j <= last]
        better = min(near, key=score)
        if score(better) >= score(best):
            return of(best)
        best = better


def _check_hold(problem: TimeOptimalProblem) -> None:
    """InputError where no command in the range holds the reference after a turn."""
    p, gain = problem.wrist.hysteresis, problem.wrist.regulator.gain
    pressures = (p.descending_pressure, p.ascending_pressure)
    volts = [pressure(problem.reference) / gain for pressure in pressures]
    if max(volts) < problem.range[0] or min(volts) > problem.range[1]:
        raise InputError(
            f"limit: holding {problem.reference:g} deg needs {min(volts):.3g} to {max(volts):.3g} V, outside "
            f"the range of {problem.range[0]:g} to {problem.range[1]:g} V; ask for less"
        )


def _commands(problem: TimeOptimalProblem, turn: int, goal: Goal) -> Any:
    """Commands [V], one per sample, the last of which holds the pressure that was come to."""
    levels, _, _ = _solve(problem, turn, goal)
    c = problem.wrist.sampled()
    v = np.repeat(np.clip(levels, *problem.range), HOLD)
    pressure = float(problem.state.pressure)
    for command in v:
        pressure = float(regulator.step(pressure, command, c.regulator))
    return np.append(v, np.clip(pressure / c.regulator.gain, *problem.range))


def _laws(problem: TimeOptimalProblem) -> tuple[Any, Any]:
    """CasADi functions of one hold: before the turn (node, command), and after it (node, command, turn)."""
    c: SampledWrist = problem.wrist.sampled()

    def moved(node: Node, command: Any, static: Callable[[Any], Any]) -> Shot:
        angles = []
        for _ in range(HOLD):
            pressure = regulator.step(node.pressure, command, c.regulator)
            angle = lag.step(node.angle, static(node.pressure), static(pressure), c.lag)
            node = Node(pressure, angle)
            angles.append(angle)
        return Shot(node, tuple(angles))

    def ahead(node: Node, command: Any) -> Shot:
        return moved(node, command, problem.ahead)

    def braking(node: Node, command: Any, turn: Any) -> Shot:
        return moved(node, command, lambda pressure: problem.braking(pressure, turn))

    node = Node("pressure", "angle")
    return graph(ahead, node, "command"), graph(braking, node, "command", "turn")


def _solve(problem: TimeOptimalProblem, turn: int, goal: Goal) -> tuple[Any, Any, Any]:
    """Commands [V] of the holds, and pressures and angles at their ends, as the optimiser sees them."""
    import casadi as ca

    n, sign, r, band = problem.nodes, problem.sign, problem.reference, problem.band
    first = ca.DM([problem.state.pressure, problem.state.angle])
    ahead, braking = _laws(problem)
    u, x = ca.MX.sym("u", 1, n), ca.MX.sym("x", 2, n)
    before = ca.horzcat(first, x[:, :-1])
    top = x[0, turn - 1]
    shots = ca.horzcat(
        ahead.map(turn)(before[:, :turn], u[:turn]),
        braking.map(n - turn)(before[:, turn:], u[turn:], ca.repmat(top, 1, n - turn)),
    )
    angles = ca.vec(shots[2:, :])
    left = sign * (r - angles)  # deg, positive before the reference
    last = x[:, n - 1]
    size = ca.sqrt(left**2 + 1e-4)
    dt = problem.wrist.rig.sample_time
    cost = dt * ca.sum1(size) + problem.wrist.Tw * ca.sqrt((last[1] - r) ** 2 + 1e-4)

    moves = sign * (x[0, :] - before[0, :])
    constraints = [
        (ca.vec(shots[:2, :] - x), 0.0, 0.0),
        (ca.vec(moves[:turn]), 0.0, np.inf),
        (ca.vec(moves[turn:]), -np.inf, 0.0),
        (graph(problem.braking, "pressure", "turn")(last[0], top) - r, 0.0, 0.0),
    ]
    late = ca.MX.sym("late", max(n * HOLD - problem.bound + 1, 0) if goal == "settling" else 0)
    if goal == "settling":
        inside = band * (1.0 - MARGIN)
        cost = cost + WEIGHT * ca.sum1(late)
        constraints += [(left, -inside, np.inf), (left[problem.bound - 1 :] - late, -np.inf, inside)]

    w = ca.vertcat(ca.vec(u), ca.vec(x), late)
    nlp = {"x": w, "f": cost, "g": ca.vertcat(*(g for g, _, _ in constraints))}
    limits = [np.concatenate([np.full(g.numel(), c[i]) for g, *c in constraints]) for i in (0, 1)]
    solver = ca.nlpsol("limit", "ipopt", nlp, _OPTIONS)
    low = np.concatenate([np.full(n, problem.range[0]), np.full(2 * n, -np.inf), np.zeros(late.numel())])
    high = np.concatenate([np.full(n, problem.range[1]), np.full(2 * n + late.numel(), np.inf)])
    guess = np.concatenate([_guess(problem, turn), np.zeros(late.numel())])
    solution = solver(x0=guess, lbx=low, ubx=high, lbg=limits[0], ubg=limits[1])
    found = np.array(solution["x"]).ravel()
    nodes = found[n : 3 * n].reshape(n, 2)
    return found[:n], nodes[:, 0], nodes[:, 1]


def _guess(problem: TimeOptimalProblem, turn: int) -> Any:
    """Full throttle until the turn, full throttle back until the loop is at the reference, then hold."""
    c, sign = problem.wrist.sampled(), problem.sign
    low, high = problem.range if sign > 0 else problem.range[::-1]
    node, top, levels, nodes = Node(problem.state.pressure, problem.state.angle), 0.0, [], []
    for k in range(problem.nodes):
        top = node.pressure if k == turn else top
        there = k > turn and sign * (problem.braking(node.pressure, top) - problem.reference) <= 0.0
        command = high if k < turn else node.pressure / c.regulator.gain if there else low
        for _ in range(HOLD):
            after = regulator.step(node.pressure, command, c.regulator)
            static = [
                problem.ahead(p) if k < turn else problem.braking(p, top) for p in (node.pressure, after)
            ]
            node = Node(after, lag.step(node.angle, static[0], static[1], c.lag))
        levels.append(command)
        nodes += [node.pressure, node.angle]
    return np.array([*levels, *nodes], float)
