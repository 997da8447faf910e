"""How wrong the model of a feedforward may be before it does worse than a plain PI: the break-even map.

One thing at a time is wrong, by an error on a grid, of the wrist against what the controllers believe:

    loop width        w1 and w2 of the wrist, as shares of those believed
    slope             a1, a2 and s, likewise
    starting memory   the static angle believed at the start, at the true pressure: a share of the loop's
                      height there, from where it is towards the line that is farther (to line 2 in between)
    dead time         of the wrist, none being believed [s]

and every controller does the 15 degree steps, both signs from every starting memory.  The settling time of
the worst of them, and the mean IAE, stand as ratios to the plain PI's on the same wrist: above 1 the
feedforward does worse.  Steps that no command can hold are left out, of both.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller, Measured
from design.evaluation.cases import Case, stack, unreachable
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play
from design.evaluation.scenarios import HEADROOM, corner
from design.evaluation.tasks import Task
from plants.errors import InputError
from plants.wrist import STARTS, Wrist

Array = NDArray[np.float64]


def _finer_at_zero(low: float, high: float, step: float, near: float = 0.1, fine: float = 0.005) -> Array:
    """Errors `step` apart from `low` to `high`, but `fine` apart up to `near` on either side of 0."""
    coarse = step * np.arange(round(low / step), round(high / step) + 1)
    close = fine * np.arange(-round(near / fine), round(near / fine) + 1)
    found: Array = np.concatenate([coarse[coarse < -near - 1e-9], close, coarse[coarse > near + 1e-9]])
    return found


GRIDS: Mapping[str, Array] = {
    "loop width": _finer_at_zero(-0.8, 1.0, 0.05),
    "slope": _finer_at_zero(-0.3, 0.6, 0.025),
    "starting memory": np.linspace(0.0, 1.0, 41),
    "dead time": np.linspace(0.0, 0.2, 41),
}
"""Errors that are tried of each kind; finer near 0, where a feedforward alone breaks even."""

KIND_UNITS = {"loop width": "1", "slope": "1", "starting memory": "1", "dead time": "s"}
"""Unit of each kind of error; 1 is a share of what is believed, of the memory one of the loop's height."""

METRICS = ("settling", "IAE")


@dataclass(frozen=True)
class BreakEvenCase:
    """One step of 15 degrees with one thing wrong: the case on the true wrist, and by what share of the
    loop's height the angle believed at the start is off."""

    kind: str
    error: float
    case: Case
    belief: float = 0.0


@dataclass(frozen=True)
class BreakEvenCurve:
    """A controller over the errors of one kind, (n,): settling time [s] of the worst step and mean IAE
    [deg s], its own and the plain PI's; nan where no step can be done, infinite where one does not settle."""

    kind: str
    controller: str
    errors: Array
    settling: Array
    plain_settling: Array
    iae: Array
    plain_iae: Array

    def ratio(self, metric: str) -> Array:
        """``settling`` or ``IAE`` as a ratio to the plain PI's, (n,); nan where neither settles."""
        own, plain = {"settling": (self.settling, self.plain_settling), "IAE": (self.iae, self.plain_iae)}[
            metric
        ]
        with np.errstate(invalid="ignore"):
            found: Array = own / plain
        return found

    def break_even(self, metric: str) -> tuple[float | None, float | None]:
        """The negative and the positive error up to which the controller does no worse than the plain PI.

        Linear between the errors of the grid, the last one that is no worse where the next does not settle;
        None where the controller is no worse to the end of the grid (or of what can be compared), or the
        grid has no such error; 0 where it is worse even without an error.
        """
        ratio, zero = self.ratio(metric), int(np.abs(self.errors).argmin())
        down = crossing(self.errors[zero::-1], ratio[zero::-1]) if zero > 0 else None
        up = crossing(self.errors[zero:], ratio[zero:]) if zero + 1 < self.errors.size else None
        return down, up


@dataclass(frozen=True)
class BreakEven:
    """The map: curves of every controller over every kind of error."""

    curves: tuple[BreakEvenCurve, ...]

    def of(self, kind: str, controller: str) -> BreakEvenCurve:
        """The curve of a controller over a kind of error; raises KeyError where there is none."""
        for c in self.curves:
            if (c.kind, c.controller) == (kind, controller):
                return c
        raise KeyError(f"no curve of {controller} over {kind}")

    def rows(self) -> list[dict[str, Any]]:
        """The numbers, one record for each kind of error, controller and metric, for tables and JSON:
        ratio without error, break-even errors, and the ends of the grid."""
        found = []
        for c in self.curves:
            for metric in METRICS:
                low, high = c.break_even(metric)
                at_zero = float(c.ratio(metric)[np.abs(c.errors).argmin()])
                found.append(
                    {
                        "kind": c.kind, "unit": KIND_UNITS[c.kind], "controller": c.controller,
                        "metric": metric,
                        "ratio_without_error": at_zero, "break_even_low": low, "break_even_high": high,
                        "tried_low": float(c.errors[0]), "tried_high": float(c.errors[-1]),
                    }
                )  # fmt: skip
        return found


def crossing(errors: Array, ratio: Array) -> float | None:
    """Where a ratio first comes above 1, going outwards from the first error; see `Curve.break_even`.

    >>> crossing(np.array([0.0, 0.1, 0.2]), np.array([0.5, 0.75, 1.25]))
    0.15
    """
    worse = np.flatnonzero(ratio > 1.0)
    known = np.flatnonzero(np.isnan(ratio))
    if not worse.size or (known.size and known[0] < worse[0]):
        return None
    n = int(worse[0])
    if n == 0:
        return 0.0
    share = (1.0 - ratio[n - 1]) / (ratio[n] - ratio[n - 1])
    return round(float(errors[n - 1] + share * (errors[n] - errors[n - 1])), 12)


def break_even(
    wrist: Wrist,
    plain: Controller,
    others: Mapping[str, Controller],
    grids: Mapping[str, Array] | None = None,
    step: float | None = None,
    duration: float = 10.0,
    jobs: int | None = None,
) -> BreakEven:
    """The map of controllers, by name, designed for `wrist`, against a plain PI.

    `grids` holds the errors of each kind that is wanted, ascending and with 0 among them; `GRIDS` where not
    given.  All cases of one controller run as lanes of one batch, those with a dead time of another.
    Raises InputError for a wrist with effects, an unknown kind of error, and a grid without 0.

    >>> from design.controllers.feedforward import Feedforward
    >>> from design.controllers.pi import PI
    >>> wrist = Wrist.flexion()
    >>> tried = {"loop width": np.array([0.0, 0.1])}
    >>> found = break_even(wrist, PI(3.13, 10.4), {"feedforward": Feedforward.of(wrist)}, tried, duration=4.0)
    >>> [round(float(x), 2) for x in found.of("loop width", "feedforward").ratio("IAE")]
    [0.39, 0.73]
    """
    tried = GRIDS if grids is None else grids
    step = wrist.rig.task.step if step is None else step
    _check(wrist, tried)
    cases = [
        c
        for kind, errors in tried.items()
        for e in errors
        for c in _cases(wrist, kind, float(e), step, duration)
    ]
    judged = {name: _judge(cases, c, jobs) for name, c in {"": plain, **others}.items()}
    curves = []
    for kind, errors in tried.items():
        of_plain = [_summary(cases, judged[""], kind, float(e)) for e in errors]
        for name in others:
            own = [_summary(cases, judged[name], kind, float(e)) for e in errors]
            (settling, iae), (plain_settling, plain_iae) = np.transpose(own), np.transpose(of_plain)
            curves.append(
                BreakEvenCurve(
                    kind, name, np.asarray(errors, float), settling, plain_settling, iae, plain_iae
                )
            )
    return BreakEven(tuple(curves))


def _check(wrist: Wrist, grids: Mapping[str, Array]) -> None:
    if wrist.effects:
        names = ", ".join(e.NAME for e in wrist.effects)
        raise InputError(f"break-even: the wrist has effects ({names}); map the wrist without them")
    for kind, errors in grids.items():
        if kind not in GRIDS:
            raise InputError(f"break-even: no kind of error {kind!r}; one of {', '.join(GRIDS)}")
        if not np.any(np.abs(errors) < 1e-9) or np.any(np.diff(errors) <= 0.0):
            raise InputError(f"break-even: the errors of the {kind} must ascend and have 0 among them")


def _cases(wrist: Wrist, kind: str, error: float, step: float, duration: float) -> list[BreakEvenCase]:
    """The steps on the wrist with one error that a command can hold."""
    width = error if kind == "loop width" else 0.0
    slope = error if kind == "slope" else 0.0
    true = corner(wrist, 1.0 + width, 1.0 + slope, 1.0)
    least, most = wrist.rig.command_range
    low, high = least + HEADROOM, most - HEADROOM
    found = []
    for sign in (1.0, -1.0):
        for start in STARTS:
            asked = Task(start, 0.0, (sign * step,), (duration,))
            case = Case(asked, true, kind, error if kind == "dead time" else 0.0)
            if unreachable(case, low, high) == 0.0:
                found.append(BreakEvenCase(kind, error, case, error if kind == "starting memory" else 0.0))
    return found


def _judge(cases: Sequence[BreakEvenCase], controller: Controller, jobs: int | None) -> Metrics:
    """Metrics of every case, leaves of shape (cases,)."""
    late = np.array([c.kind == "dead time" for c in cases])
    parts: dict[bool, Metrics] = {}
    for dead in (False, True):
        here = [c for c, is_late in zip(cases, late, strict=True) if is_late == dead]
        if here:
            parts[dead] = _run(here, controller, jobs)
    found = next(iter(parts.values()))
    if len(parts) == 1:
        return found
    order = np.argsort(np.concatenate([np.flatnonzero(~late), np.flatnonzero(late)]))
    both = (np.concatenate([getattr(parts[d], n) for d in (False, True)])[order] for n in vars(found))
    return Metrics(*both)


def _run(cases: Sequence[BreakEvenCase], controller: Controller, jobs: int | None) -> Metrics:
    lanes = stack(c.case for c in cases)
    pressure = lanes.state.pressure
    believed = np.array([_believed(c) for c in cases])
    # A controller that is told a wrong angle at rest begins with a wrong memory.
    held = controller.holding(pressure, Measured(0.0, believed, pressure))
    return play(lanes, controller, held, jobs=jobs).metrics


def _believed(case: BreakEvenCase) -> float:
    """The static angle [deg] that is believed at the start of a case."""
    p, rest = case.case.wrist.hysteresis, case.case.wrist.rest(case.case.task.start)
    low = float(p.ascending(rest.pressure)) - rest.memory.h
    high = float(p.descending(rest.pressure)) - rest.memory.h
    farther = high if high >= -low * (1.0 - 1e-9) else low
    return float(rest.memory.h + case.belief * farther)


def _summary(cases: Sequence[BreakEvenCase], judged: Metrics, kind: str, error: float) -> tuple[float, float]:
    """Worst settling time [s] and mean IAE [deg s] of the cases with one error."""
    here = [i for i, c in enumerate(cases) if (c.kind, c.error) == (kind, error)]
    if not here:
        return float("nan"), float("nan")
    return float(judged.settling_time_s[here].max()), float(judged.iae_deg_s[here].mean())
