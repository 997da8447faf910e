"""One rung on one loop: a Lyapunov function is searched for by a solver and handed to the check."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.continuous import check, lmi, popov, quadratic
from design.robustness.certificates.continuous.form import Form, FormSearch
from design.robustness.certificates.continuous.signals import LoopSignals, rates, slopes
from design.robustness.certificates.reasons import NoneOfThisKind, NoSolver, NotConfirmed
from design.robustness.loop_model import LoopModel
from design.synthesis import convex

Array = NDArray[np.float64]

RUNGS: Mapping[str, Callable[[LoopSignals, float], list[lmi.Inequality]]] = {
    quadratic.RUNG: quadratic.inequalities,
    popov.RUNG: popov.inequalities,
}
"""The rungs in continuous time, from the one that takes least for granted to the one that proves most."""

HALVINGS = 10
"""Of the interval in which the best decay rate lies: it is found to a thousandth of its bound."""


def search(
    model: LoopModel,
    rung: str,
    decay: float = 0.0,
    dead_time: float = 0.0,
    solvers: tuple[str, ...] = convex.SOLVERS,
) -> FormSearch:
    """A Lyapunov function of a rung that falls by exp(-2 decay t) at least, confirmed, or why not.

    decay [1/s]; dead_time [s]: beside the loop's own.  Raises KeyError for an unknown rung.
    """
    signals = signals_of(model, rung, dead_time)
    u = program(signals, rung, decay, signals.scale)
    return confirmed(lambda: lmi.widest(u, solvers), signals, rung, decay, dead_time)


def fastest(model: LoopModel, rung: str, dead_time: float = 0.0) -> FormSearch:
    """The Lyapunov function of a rung with the largest decay rate, by bisection; every step is checked.

    dead_time [s].
    Where none falls at all, the answer of `search` without decay.
    """
    best = search(model, rung, 0.0, dead_time)
    if best.form is None:
        return best
    # No faster than the slowest pole of any corner; with dead time that bound may be off.
    low, high = 0.0, -max(_abscissa(model, s, k) for s in slopes(model) for k in rates(model))
    high = max(high, 1e-6)
    while (further := search(model, rung, high, dead_time)).form is not None:
        best, low, high = further, high, 2.0 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        found = search(model, rung, middle, dead_time)
        if found.form is None:
            high = middle
        else:
            best, low = found, middle
    return best


def signals_of(model: LoopModel, rung: str, dead_time: float) -> LoopSignals:
    """The signals that a rung speaks of, of a loop with a dead time [s]."""
    return LoopSignals.of(model, dead_time, RUNGS[rung] is popov.inequalities)


def program(signals: LoopSignals, rung: str, decay: float, scale: Array) -> lmi.Unknowns:
    """The inequalities of a rung as a convex program, in a vector of the sizes `scale`."""
    n = signals.states
    bound = {"S": signals.moments[:n, :n]} if signals.order else {}
    return lmi.unknowns(RUNGS[rung](signals, decay), scale, bound, quadratic.paid(signals, decay))


def confirmed(
    solve: Callable[[], lmi.Solution], signals: LoopSignals, rung: str, decay: float, dead_time: float
) -> FormSearch:
    """What a solver finds for a loop with a dead time [s], once the check has looked at it."""
    try:
        solution = solve()
    except convex.Unsolved as said:
        return FormSearch(None, None, "", NoSolver(str(said)))
    open_law = signals.open_law
    # A number that a solver leaves a hair below 0 is 0; the check sees what is then claimed.
    form = Form(
        solution.P, decay, open_law,
        slopes=tuple(sorted(set(slopes(signals.model)))) if open_law else (),
        multipliers=tuple(max(v, 0.0) for v in solution.own),
        **{name: max(v, 0.0) for name, v in solution.shared.items()},
    )  # fmt: skip
    margin = check.margin(form, signals.model, dead_time)
    if margin > check.CONFIRMED:
        return FormSearch(form, margin, solution.solver)
    if solution.margin <= check.CONFIRMED:
        return FormSearch(None, margin, solution.solver, NoneOfThisKind(solution.solver, margin))
    return FormSearch(None, margin, solution.solver, NotConfirmed(solution.solver, margin))


def _abscissa(model: LoopModel, slope: float, rate: float) -> float:
    return float(np.linalg.eigvals(model.matrix(slope, rate)).real.max())
