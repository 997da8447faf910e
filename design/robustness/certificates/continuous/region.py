"""Where a certificate holds: the states from which the command is never clipped.

The command is v = (P + q) / gain, and the pressure lies between line 2 and line 1 at the static angle
h = r - x0 + x1.  So the command stays within its range wherever

    rest + (h + w1) / a1 + q <= gain v_high,        rest + (h - w2) / a2 + q >= gain v_low:

two planes in x, at distances that the reference r moves, for outer branches that are straight.  From a
start with V <= c, V only falls while the command is not clipped, and {V <= c} lies in {X' Q X <= c}
(Q = P without dead time); so where that ellipsoid lies between the planes the command is not clipped at
any time.  A dead time tau puts tau Z_0 on the left, for the command is ahead of q by what is on its way.

A step of r from rest on a line starts at x = (r, 0, b Kp r), b the weight of the reference, with a dead time
tau after the step, the command having risen at Ki r all the while.  What holds for steps of r and -r holds
for all between: the planes come no nearer, and the start comes nearer to 0 in proportion.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.robustness.certificates.continuous import lmi
from design.robustness.certificates.continuous.form import Form, FormSearch
from design.robustness.certificates.continuous.search import confirmed, program, signals_of
from design.robustness.certificates.continuous.signals import rates, total_dead_time
from design.robustness.certificates.continuous.virgin import VirginBounds
from design.robustness.loop_model import LoopModel
from plants.wrist import Wrist

Array = NDArray[np.float64]

STEPS = 9
"""Halvings of the interval in which the largest step lies: it is found to a five-hundredth."""


@dataclass(frozen=True)
class InvariantRegion:
    """A form, and the largest step [deg] for which V <= level at the start and the command is not
    clipped where V <= level; margin: of the form's check; tau [s]: dead time; form: None where no
    step was found that surely keeps the command in its range, or where none was looked for, since the
    outer branches are `curved`.

    The form keeps no decay rate of its own: where the command is not clipped the certificate's does.
    """

    form: Form | None
    level: float
    largest_step: float
    margin: float | None
    tau: float
    curved: bool = False


def planes(wrist: Wrist, controller: PI, reference: float, tau: float, order: int) -> tuple[Array, Array]:
    """Rows g and distances b with g X <= b where the command is surely within its range, for one
    reference [deg]: (2, 3 + order), (2,), the upper end of the range first.

    >>> from plants import Wrist
    >>> g, b = planes(Wrist.flexion(), PI(1.2, 2.2), 15.0, 0.0, 0)
    >>> b.round(2).tolist()                                     # 97.6 kPa less 21 deg on line 1, and
    [39.27, 125.0]
    """
    p, gain = wrist.hysteresis, float(wrist.regulator.gain)
    ahead = np.zeros(order)
    ahead[:1] = tau
    outer, other = (float(slope) for slope in p.steepness)
    up = np.array([-1.0 / outer, 1.0 / outer, 1.0, *ahead])
    down = -np.array([-1.0 / other, 1.0 / other, 1.0, *ahead])
    b = np.array([
        gain * controller.high - float(p.ascending_pressure(reference)),
        float(p.descending_pressure(reference)) - gain * controller.low,
    ])  # fmt: skip
    return np.array([up, down]), b


def level(form: Form, g: Array, b: Array) -> float:
    """Largest c with {X' Q X <= c} between the planes g X <= b; 0 where 0 is not between them."""
    if not (b > 0.0).all():
        return 0.0
    return float(np.min(b**2 / np.einsum("ij,ji->i", g, np.linalg.solve(form.below, g.T))))


def at_start(form: Form, model: LoopModel, reference: float, q: float | None = None) -> float:
    """V at most at the start of a step [deg] from rest, of q [kPa], b Kp r where not given.

    int_0^q psi <= kappa q^2 / 2, and z was Ki r for as long as the dead time.
    """
    q = model.weight * model.Kp * reference if q is None else q
    start, weights = _start(model, reference, q, form.order)
    numbers = {"popov": form.popov, "S": form.S, "R": form.R}
    return float(start @ form.P @ start + sum(w * numbers[n] for n, w in weights.items()))


def _start(model: LoopModel, reference: float, q: float, order: int) -> tuple[Array, dict[str, float]]:
    z, (low, high) = model.Ki * reference, rates(model)
    start = np.array([reference, 0.0, q, *([z] + [0.0] * order)[:order]])
    weights = {"popov": (high - low) * q * q}
    return start, weights | ({"S": z * z, "R": 0.5 * z * z} if order else {})


def start_matrix(form: Form, model: LoopModel) -> Array:
    """A matrix M with V <= x' M x, without dead time, (3, 3): from {x' M x <= c} V stays below c."""
    low, high = rates(model)
    return form.P + form.popov * (high - low) * np.diag([0.0, 0.0, 1.0])


def covers(
    region: InvariantRegion,
    model: LoopModel,
    wrist: Wrist,
    controller: PI,
    reference: float,
    virgin: VirginBounds,
) -> bool:
    """Whether a step [deg] from rest on the virgin curve leaves it within the region, unclipped so far.

    It leaves with x = (r, 0, q), z having been Ki r for as long as it was there.
    """
    if region.form is None or not virgin.leaves or virgin.clipped:
        return False
    g, b = planes(wrist, controller, reference, region.tau, region.form.order)
    sign = 1.0 if reference >= 0.0 else -1.0
    ends = [at_start(region.form, model, reference, sign * q) for q in (virgin.q_least, virgin.q_most)]
    return max(ends) <= level(region.form, g, b)  # V at most is convex in q


def largest(
    model: LoopModel, wrist: Wrist, controller: PI, rung: str, dead_time: float = 0.0
) -> InvariantRegion:
    """The form of a rung that covers the largest step from rest on a line, with a dead time [s].

    By bisection over the step; every form is checked, and so is the region, in plain NumPy.
    """
    signals = signals_of(model, rung, dead_time)
    tau = total_dead_time(model, dead_time)
    if not wrist.hysteresis.straight():
        return InvariantRegion(None, 0.0, 0.0, None, tau, curved=True)
    best = InvariantRegion(None, 0.0, 0.0, None, tau)

    def bounds(r: float) -> tuple[Array, Array]:
        pairs = [planes(wrist, controller, sign * r, tau, signals.order) for sign in (1.0, -1.0)]
        return pairs[0][0], np.min([b for _, b in pairs], axis=0)

    def attempt(r: float) -> InvariantRegion | None:
        g, b = bounds(r)
        if not (b > 0.0).all():
            return None
        start, weights = _start(model, r, model.weight * model.Kp * r, signals.order)
        u = program(signals, rung, 0.0, signals.scale * (r / signals.scale[0]))
        # A hair inside, so that what the solver leaves open does not decide.
        found: FormSearch = confirmed(
            lambda: lmi.widest_within(u, start * (1.0 + 1e-6), weights, g / b[:, None]),
            signals, rung, 0.0, dead_time,
        )  # fmt: skip
        if found.form is None:
            return None
        c = level(found.form, g, b)
        return (
            InvariantRegion(found.form, c, r, found.margin, tau)
            if at_start(found.form, model, r) <= c
            else None
        )

    g, b = bounds(0.0)
    # The step at which a plane passes through 0, or a start lies beyond one.
    start = _start(model, 1.0, model.weight * model.Kp, signals.order)[0]
    b1 = bounds(1.0)[1]
    low, high = 0.0, float(np.min(b / np.maximum(b - b1, np.abs(g @ start) + b - b1)))
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        region = attempt(middle)
        if region is None:
            high = middle
        else:
            best, low = region, middle
    return best
