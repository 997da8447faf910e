"""Hybrid MPC: branches and pieces of the regulator's law as binaries, an MILP for HiGHS, (c).

The problem of `design.mpc.problem` on the model of `formulations.hybrid_model`, with a cost that is
linear in pieces: `norm="one"` sums weights times sizes of errors, swings and moves; `norm="square"` sums
their squares from below, by their tangents, so that the bound that HiGHS proves is one
on the cost of the other MPCs, on this model.  A plan that is proved to be the best of its model is what
no local method gives: it says whether these sit in a poor minimum.  It is an offline reference, for
short horizons or coarse grids: 20 periods mostly take 6 to 20 s to a gap of 0.5 %, and may take far longer
where the reference is hardly reached within them (deviation, -15 deg: gaps of 6 to 16 % after 25 s).

The bound is one for plans of the model, not of the wrist: `formulations.hybrid_model` says what differs.

Per period: the segment of the regulator's law (disaggregated, one binary a segment), the branch (three
binaries), and virgin or not (one).  With `inside` the angle on the transit, h and the branches obey

    line1 <= h <= line2,   h >= inside unless on line 2,   h <= inside unless on line 1,
    h <= line1 if on line 1,   h >= line2 if on line 2,   one branch,

which is h = min(max(inside, line1), line2).  HiGHS: Huangfu & Hall, Mathematical Programming
Computation 10 (2018) 119, doi 10.1007/s12532-017-0130-5, as `scipy.optimize.milp` has it.
"""

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.mpc.formulations.hybrid_model import Piecewise, piecewise, play, sampled_lag
from design.mpc.problem import Believed, MPCProblem
from plants.errors import InputError
from plants.hysteresis import FourSegment

Array = NDArray[np.float64]
Norm = Literal["one", "square"]

FINEST, COARSEST, RATIO = 0.1, 40.0, 1.25
"""Tangents of the square touch it at 0 and from the finest to the coarsest [deg or V], each so many times
the one before: between them they are below it by ((RATIO - 1) / (RATIO + 1))^2, 1.2 %, at most, or by
FINEST^2 / 4 next to 0."""


class HybridPlan(NamedTuple):
    """commands [V] and angles [deg] by the hybrid model, both (N,); their cost in the norm asked for, as the
    model has it, and the least that any plan of the model can cost, as far as it was proved; the law."""

    commands: Array
    angles: Array
    cost: float
    bound: float
    law: Piecewise

    @property
    def gap(self) -> float:
        """What is not proved, as a share of the cost."""
        return (self.cost - self.bound) / self.cost if self.cost else 0.0


@dataclass(frozen=True)
class Effort:
    """pieces: of the regulator's law, on either side of 0; seconds: time limit; gap: of the MILP, relative,
    at which it is done."""

    pieces: int = 4
    seconds: float = 60.0
    gap: float = 5e-3


def cost(
    problem: MPCProblem, angles: Any, commands: Any, before: float, reference: float, norm: Norm
) -> float:
    """The cost of a plan of commands [V] in a norm; "square" is `problem.cost`."""
    if norm == "square":
        return problem.cost(angles, commands, before, reference)
    errors = np.abs(np.asarray(angles, float) - reference)
    moves = np.abs(np.diff(np.asarray(commands, float), prepend=before))
    swings = np.abs(np.diff(np.asarray(angles, float)))
    by = problem.weights
    return float(problem.stage_weights @ errors + by.swing * np.sum(swings) + by.move * np.sum(moves))


def solve(
    problem: MPCProblem,
    believed: Believed,
    before: float,
    reference: float,
    norm: Norm = "one",
    effort: Effort | None = None,
) -> HybridPlan:
    """The best plan of the hybrid model, `before` [V] being the command of the period before.

    Raises InputError for another hysteresis law than four segments, where the loop's lines do not leave the
    transit (a slope of the transit that is not below theirs), and where HiGHS finds no plan, within the time
    limit or at all.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_matrix

    effort, p, P0 = effort or Effort(), problem.wrist, float(believed.plant.pressure)
    if not isinstance(problem.loop, FourSegment):
        raise InputError(
            f"hybrid MPC: its branches are four straight segments, not {problem.loop.NAME!r}: "
            "give a plant with those"
        )
    if not problem.loop.s < min(problem.loop.a1, problem.loop.a2):
        raise InputError("hybrid MPC: the transit is not flatter than the lines: give a smaller slope s")
    pressures = [P0, *(p.regulator.gain * v + believed.lack for v in (problem.low, problem.high))]
    law = piecewise(problem, max(pressures) - min(pressures), effort.pieces)
    made = _Milp(problem, problem.loop, believed, law, norm)
    made.build(before, reference)
    rows = np.array(made.rows)
    result = milp(
        made.price,
        integrality=made.integral,
        bounds=Bounds(made.low, made.high),
        constraints=LinearConstraint(csr_matrix(rows[:, :-1]), made.least - rows[:, -1], -rows[:, -1]),
        options={"time_limit": effort.seconds, "mip_rel_gap": effort.gap},
    )
    if result.x is None:
        raise InputError(
            f"hybrid MPC: HiGHS found no plan ({result.message}): give it more than {effort.seconds:g} s, "
            "a shorter horizon, or wider bounds"
        )
    commands = np.clip(result.x[made.commands], problem.low, problem.high)
    angles = play(problem, law, believed.plant, commands, believed.lack) + believed.shift
    own = cost(problem, angles, commands, before, reference, norm)
    return HybridPlan(commands, angles, own, float(result.mip_dual_bound), law)


class _Milp:
    """Columns and rows of the MILP.  An expression is a row of one coefficient for each column and a
    constant; rows are <= 0, and = 0 where `least` is 0."""

    def __init__(
        self, problem: MPCProblem, loop: FourSegment, believed: Believed, law: Piecewise, norm: Norm
    ) -> None:
        self.loop, self.problem, self.believed, self.law, self.norm = loop, problem, believed, law, norm
        self.segments, self.once = law.segments, float(believed.plant.memory.virgin) > 0.5
        self.width = 7 + 4 + 2 * len(self.segments)
        n = problem.horizon * self.width
        self.one, self.columns = np.eye(n + 1)[n], np.eye(n + 1)[:n]
        self.rows: list[Array] = []
        self.kinds: list[bool] = []
        self.low, self.high = np.full(n, -np.inf), np.full(n, np.inf)
        self.integral, self.price = np.zeros(n), np.zeros(n)
        self.commands = np.arange(problem.horizon) * self.width

    @property
    def least(self) -> Array:
        """Lower bounds of the rows."""
        return np.where(self.kinds, 0.0, -np.inf)

    def below(self, row: Array, other: Array | float = 0.0) -> None:
        """row <= other."""
        self.rows.append(row - other * self.one if isinstance(other, float) else row - other)
        self.kinds.append(False)

    def equal(self, row: Array, other: Array) -> None:
        """row = other."""
        self.rows.append(row - other)
        self.kinds.append(True)

    def build(self, before: float, reference: float) -> None:
        """All periods."""
        b, one = self.believed, self.one
        P, h, y, v = b.plant.pressure * one, b.plant.memory.h * one, b.plant.angle * one, before * one
        virgin = one if self.once else 0.0 * one
        c = sampled_lag(self.problem, float(self.law.knots[-1]))
        for k, weight in enumerate(self.problem.stage_weights):
            first = k * self.width
            x = self.columns[first : first + self.width]
            v1, P1, h1, y1, size, effort, swing, on1, along, on2, virgin1 = x[:11]
            self.low[first], self.high[first] = self.problem.low, self.problem.high
            self.integral[first + 7 : first + 11] = 1.0
            self.low[first + 7 : first + 11], self.high[first + 7 : first + 11] = 0.0, 1.0
            up, down = self.regulator(first, v1, P, P1)
            self.branches(P, P1, h, h1, virgin, virgin1, on1, along, on2)
            self.below(on1 + down, 1.0)  # a line is only met on the way to it
            self.below(on2 + up, 1.0)
            self.equal(y1, c.keep * y + c.before * h + c.after * h1)
            self.below(v1 - v, self.problem.rate)
            self.below(v - v1, self.problem.rate)
            self.sized(size, y1 + (b.shift - reference) * one)
            self.sized(effort, v1 - v)
            by = self.problem.weights
            if k > 0 and by.swing > 0.0:
                self.sized(swing, y1 - y)
                self.price[first + 6] = by.swing
            else:
                self.low[first + 6] = self.high[first + 6] = 0.0
            self.price[first + 4], self.price[first + 5] = weight, by.move
            P, h, y, v, virgin = P1, h1, y1, v1, virgin1

    def regulator(self, first: int, v: Array, P: Array, after: Array) -> tuple[Array, Array]:
        """P after a period, by segments; whether the segment is one of a rise, of a fall."""
        m, gain = len(self.segments), self.problem.wrist.regulator.gain
        parts, chosen = self.columns[first + 11 : first + 11 + m], self.columns[first + 11 + m :][:m]
        places = slice(first + 11 + m, first + 11 + 2 * m)
        self.integral[places], self.low[places], self.high[places] = 1.0, 0.0, 1.0
        self.equal(parts.sum(axis=0), gain * v + self.believed.lack * self.one - P)
        self.equal(chosen.sum(axis=0), self.one)
        gain_of = np.zeros_like(P)
        for (a, b, slope, intercept), part, z in zip(self.segments, parts, chosen, strict=True):
            self.below(a * z - part)
            self.below(part - b * z)
            gain_of = gain_of + slope * part + intercept * z
        self.equal(after, P + gain_of)
        middle = m // 2
        return chosen[middle + 1 :].sum(axis=0), chosen[:middle].sum(axis=0)

    def branches(
        self, P: Array, P1: Array, h: Array, h1: Array, virgin: Array, virgin1: Array,
        on1: Array, along: Array, on2: Array,
    ) -> None:  # fmt: skip
        """h after a period, and whether the wrist is on the virgin curve still."""
        p, one = self.loop, self.one
        line1 = p.a1 * P1 - (p.a1 * p.rest_pressure + p.w1) * one
        line2 = p.a2 * P1 - (p.a2 * p.rest_pressure - p.w2) * one
        at = np.array([self.problem.low, self.problem.high]) * self.problem.wrist.regulator.gain
        ends = np.append(at + self.believed.lack, self.believed.plant.pressure)
        wide = float(np.max((p.a2 - p.a1) * (ends - p.rest_pressure) + p.w1 + p.w2))
        most = float(self.law.values[-1])  # that the pressure moves by in a period
        slope = 0.0 if self.once else p.s
        beyond1, beyond2 = (p.a1 - slope) * most, (p.a2 - slope) * most
        self.equal(on1 + along + on2, one)
        self.below(line1 - h1)
        self.below(h1 - line2)
        self.below(h1 - line1 - wide * (one - on1))
        self.below(line2 - h1 - wide * (one - on2))
        inside = h + p.s * (P1 - P)
        still = p.s * most * virgin  # on the virgin curve the angle stays, whatever the pressure
        self.below(inside - h1 - beyond2 * on2 - still)
        self.below(h1 - inside - beyond1 * on1 - still)
        if self.once:
            off = one - virgin
            reach = wide + most * max(p.a1, p.a2)
            self.below(h - h1 - beyond2 * on2 - reach * off)
            self.below(h1 - h - beyond1 * on1 - reach * off)
            self.below(virgin1 - virgin)
            self.below(virgin1 - along)
            self.below(virgin + along - one - virgin1)
        else:
            self.equal(virgin1, 0.0 * one)

    def sized(self, size: Array, of: Array) -> None:
        """size >= |of|, or its square from below."""
        if self.norm == "one":
            self.below(of - size)
            self.below(-of - size)
            return
        self.below(-size)
        for at in np.geomspace(FINEST, COARSEST, round(np.log(COARSEST / FINEST) / np.log(RATIO)) + 1):
            for sign in (1.0, -1.0):
                self.below(2.0 * sign * at * of - at * at * self.one - size)
