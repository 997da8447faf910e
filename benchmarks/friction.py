"""Laws of hysteresis and friction on two rigs without a command: from displacement to force, in a free run.

The stop operator of a displacement x with threshold r is x less its play (Maxwell slip: a spring that slips
at a force), so that the play of `plants.measured.guess` serves for both; weights are found by least squares,
those of stops none negative.  Libraries that users would take instead are compared where they are installed:
they are no dependencies.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.guess import lagged, plays

Array = NDArray[np.float64]
DT = 0.01
"""Sample time [s] of both rigs; what was logged unevenly is interpolated."""

REACHES = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.3)
"""Thresholds of the stops, as shares of the range of the displacement, and of its speed."""

LAGS = (0.0, 0.005, 0.01, 0.02, 0.04, 0.08)
"""Time constants [s] between the law and the force that are tried."""

SMOOTHED = 9
"""Rows over which a displacement is smoothed before it is differentiated."""

PISTON = ("Kidney_2bar", "Kidney_2bar_tweederun")
HALVED = ("KDN_1bar", "O-ring_5bar", "X-ring257_7bar")
"""Runs whose first part is fitted and whose rest is held out."""

FITTED = 0.6


@dataclass(frozen=True)
class ForceRun:
    """Displacement [mm or the log's unit] and force [N] every `DT` s, of shape (n,)."""

    displacement: Array
    force: Array

    @property
    def speed(self) -> Array:
        """Of the smoothed displacement [1/s]."""
        from scipy.signal import savgol_filter

        found: Array = savgol_filter(self.displacement, SMOOTHED, 2, deriv=1, delta=DT)
        return found


@dataclass(frozen=True)
class ForceTask:
    """Runs to fit and runs held out, by the name of the task."""

    name: str
    fit: tuple[ForceRun, ...]
    held_out: tuple[ForceRun, ...]

    @property
    def span(self) -> float:
        """Range of the force that was held out [N]."""
        force = np.concatenate([r.force for r in self.held_out])
        return float(np.ptp(force))


Law = Callable[[ForceTask], list[Array]]


def tasks(data: Path) -> list[ForceTask]:
    """The tasks that a folder of data holds."""
    damper = data / "mr-damper"
    found = [
        ForceTask(
            "mr-damper: series A, its validation held out",
            tuple(_damper(p) for p in sorted(damper.glob("ensaio.A.*.mat"))),
            tuple(_damper(p) for p in sorted(damper.glob("ensaio.vali.A.*.mat"))),
        )
    ]
    piston = data / "piston-friction"
    one, other = (_piston(piston / f"{n}.csv") for n in PISTON)
    found.append(ForceTask("piston seal: Kidney 2 bar, its second run held out", (one,), (other,)))
    for name in HALVED:
        run = _piston(piston / f"{name}.csv")
        at = round(FITTED * len(run.force))
        first, rest = (ForceRun(run.displacement[s], run.force[s]) for s in (slice(at), slice(at, None)))
        found.append(
            ForceTask(f"piston seal: {name.replace('_', ' ')}, last 40 % held out", (first,), (rest,))
        )
    return found


def _damper(path: Path) -> ForceRun:
    from scipy.io import loadmat

    content = loadmat(path)
    return ForceRun(content["dist"].ravel().astype(float), content["forc"].ravel().astype(float))


def _piston(path: Path) -> ForceRun:
    table = np.loadtxt(path, delimiter="\t")
    time, first = 1e-3 * table[:, 0], np.unique(table[:, 0], return_index=True)[1]
    even = np.arange(time[0], time[-1], DT)
    return ForceRun(*(np.interp(even, time[first], table[first, column]) for column in (4, 6)))


def _least_squares(task: ForceTask, columns: Callable[[ForceRun], tuple[Array, Array]]) -> list[Array]:
    """Forces held out, of columns whose weights are free and columns whose weights are not negative, behind
    the lag that does best on the runs fitted."""
    from scipy.optimize import lsq_linear

    best: tuple[float, float, Array] | None = None
    y = np.concatenate([r.force for r in task.fit])
    made = {id(r): columns(r) for r in (*task.fit, *task.held_out)}
    free = made[id(task.fit[0])][0].shape[1]

    def shaped(r: ForceRun, tau: float) -> Array:
        return lagged(np.hstack(made[id(r)]), DT, tau, 0.0)

    for tau in LAGS:
        a = np.vstack([shaped(r, tau) for r in task.fit])
        scale = np.maximum(np.linalg.norm(a, axis=0), 1e-12)
        low = np.where(np.arange(a.shape[1]) < free, -np.inf, 0.0)
        found = lsq_linear(a / scale, y, (low, np.inf))
        if best is None or found.cost < best[0]:
            best = (float(found.cost), tau, found.x / scale)
    assert best is not None
    return [shaped(r, best[1]) @ best[2] for r in task.held_out]


def _plain(r: ForceRun) -> Array:
    return np.column_stack([np.ones(len(r.force)), r.displacement, r.speed])


def linear(task: ForceTask) -> list[Array]:
    """Spring, damper and a constant."""
    return _least_squares(task, lambda r: (_plain(r), np.empty((len(r.force), 0))))


def coulomb(task: ForceTask) -> list[Array]:
    """The same with a friction that has the sign of the speed."""
    return _least_squares(task, lambda r: (_plain(r), np.sign(r.speed)[:, None]))


def stops(x: Array, span: float) -> Array:
    """Stop operators of a series (n,) with thresholds of shares of its range, shape (n, m).

    >>> stops(np.array([0.0, 1.0, 0.0]), 1.0)[:, 0].tolist()
    [0.0, 0.0025, -0.0025]
    """
    return x[:, None] - plays(x, span * np.array(REACHES))


def maxwell_slip(task: ForceTask) -> list[Array]:
    """Spring, damper, constant, and stops of the displacement."""
    span = float(np.ptp(np.concatenate([r.displacement for r in task.fit])))
    return _least_squares(task, lambda r: (_plain(r), stops(r.displacement, span)))


def rate_slip(task: ForceTask) -> list[Array]:
    """The same with friction that saturates with the speed, at several speeds."""
    span = float(np.ptp(np.concatenate([r.displacement for r in task.fit])))
    fast = float(np.ptp(np.concatenate([r.speed for r in task.fit])))

    def columns(r: ForceRun) -> tuple[Array, Array]:
        limits = fast * np.array(REACHES)
        saturated = np.clip(r.speed[:, None], -limits, limits)
        return _plain(r), np.hstack([stops(r.displacement, span), saturated])

    return _least_squares(task, columns)


def linear_dynamics(task: ForceTask, order: int = 3) -> list[Array]:
    """An ARX model of displacement and speed in a free run from the first measured rows."""
    rows, y = [], []
    for r in task.fit:
        u = np.column_stack([r.displacement, r.speed])
        past = [r.force[order - k : len(r.force) - k] for k in range(1, order + 1)]
        given = [u[order - k : len(u) - k] for k in range(order + 1)]
        rows.append(np.column_stack([*past, *given, np.ones(len(r.force) - order)]))
        y.append(r.force[order:])
    weights = np.linalg.lstsq(np.vstack(rows), np.concatenate(y), rcond=None)[0]
    found = []
    for r in task.held_out:
        u, force = np.column_stack([r.displacement, r.speed]), list(r.force[:order])
        for i in range(order, len(r.force)):
            row = [*(force[i - k] for k in range(1, order + 1)), *u[i - order : i + 1][::-1].ravel(), 1.0]
            force.append(float(np.clip(np.dot(row, weights), -1e6, 1e6)))
        found.append(np.array(force))
    return found


def narx(task: ForceTask) -> list[Array]:
    """SysIdentPy: polynomial NARX of degree 2, terms by FROLS, in a free run."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    model = FROLS(
        order_selection=True, n_info_values=20, ylag=2, xlag=[[1, 2], [1, 2]], info_criteria="bic",
        basis_function=Polynomial(degree=2),
    )  # fmt: skip
    centre, size = _scales(task)
    x, y = zip(*((_scaled(r, centre, size)) for r in task.fit), strict=True)
    model.fit(X=np.vstack(x), y=np.concatenate(y)[:, None])
    found = []
    for r in task.held_out:
        given, force = _scaled(r, centre, size)
        free = model.predict(X=given, y=force[: model.max_lag, None])
        found.append(np.asarray(free).ravel() * size[2] + centre[2])
    return found


def sindy(task: ForceTask) -> list[Array]:
    """PySINDy: a discrete model of degree 2 of the force, with the same inputs, in a free run."""
    import pysindy

    centre, size = _scales(task)
    runs = [_scaled(r, centre, size) for r in task.fit]
    model = pysindy.DiscreteSINDy(
        optimizer=pysindy.STLSQ(threshold=1e-3), feature_library=pysindy.PolynomialLibrary(degree=2)
    )
    model.fit([f[:, None] for _, f in runs], t=1, u=[g for g, _ in runs])
    found = []
    for r in task.held_out:
        given, force = _scaled(r, centre, size)
        try:
            free = np.asarray(model.simulate(force[:1], len(force), u=given)).ravel()
        except ValueError:  # it ran away
            free = np.full(len(force), np.inf)
        found.append(free * size[2] + centre[2])
    return found


def _scales(task: ForceTask) -> tuple[Array, Array]:
    parts = [(r.displacement, r.speed, r.force) for r in task.fit]
    whole = [np.concatenate(p) for p in zip(*parts, strict=True)]
    return np.array([p.mean() for p in whole]), np.array([p.std() for p in whole])


def _scaled(r: ForceRun, centre: Array, size: Array) -> tuple[Array, Array]:
    columns = (np.column_stack([r.displacement, r.speed, r.force]) - centre) / size
    return columns[:, :2], columns[:, 2]


LAWS: dict[str, Law] = {
    "spring and damper": linear, "Coulomb friction": coulomb, "Maxwell slip": maxwell_slip,
    "Maxwell slip and saturating friction": rate_slip, "ARX, third order": linear_dynamics,
    "SysIdentPy NARX": narx, "PySINDy": sindy,
}  # fmt: skip


def shares(task: ForceTask, laws: Sequence[str] = tuple(LAWS)) -> dict[str, float | None]:
    """Error of each law on the runs held out as a share of the range of the force; None where a library is
    not installed, infinite for a run that runs away."""
    return {name: _share(task, LAWS[name]) for name in laws}


def _share(task: ForceTask, law: Law) -> float | None:
    try:
        made = law(task)
    except ImportError:
        return None
    left = [f[: len(r.force)] - r.force[: len(f)] for f, r in zip(made, task.held_out, strict=True)]
    with np.errstate(over="ignore", invalid="ignore"):
        rms = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    return rms / task.span if np.isfinite(rms) and rms < 1e3 * task.span else float("inf")


def table(data: Path) -> list[dict[str, Any]]:
    """The errors of all laws on all tasks of a folder, for JSON."""

    def said(share: float | None) -> float | str | None:
        return "ran away" if share == float("inf") else share

    return [
        {
            "task": t.name,
            "range_N": t.span,
            "error_share_of_range": {n: said(s) for n, s in shares(t).items()},
        }
        for t in tasks(data)
    ]
