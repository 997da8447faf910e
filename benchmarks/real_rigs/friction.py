"""Friction of rigs without a command: from displacement (and load) to force, in a free run.

Ours is the law of `plants.measured.friction`, whose parts are chosen on blocks of the rows fitted.  Beside
it stand what the field takes (Coulomb friction, Bouc-Wen) and what libraries offer
(`benchmarks.real_rigs.black_box`), on the same rows with the same inputs.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.real_rigs.black_box import METHODS, Logged, Method, Task, error
from plants.measured.friction import ForceRun, FrictionChoice, fit_friction
from plants.measured.friction.choice import LAGS
from plants.measured.guess.rough_models import lagged

Array = NDArray[np.float64]
DT = 0.01
"""Sample time [s]; what was logged unevenly is interpolated."""

FITTED = 0.6
"""Share of a single run that is fitted; the rest is judged."""

THIRD = 3
"""Every so many runs of a series one is held out."""

AGAIN = "_tweederun"
"""How the second run of a seal is called."""

STEP = 0.2
"""Largest step of the Bouc-Wen equation, in displacements to slip."""

FAR = (-7.0, 2.0)
"""Logarithms between which displacement to slip, as a share of the range, and sharpness are searched."""

EVALUATIONS = 120
"""Of the search for the three parameters in which Bouc-Wen is not linear."""


@dataclass(frozen=True)
class ForceTask:
    """Runs to fit and runs held out, of which the rows from `judged_from` on are judged: those before only
    say how the rig got there."""

    name: str
    fit: tuple[ForceRun, ...]
    held_out: tuple[ForceRun, ...]
    judged_from: int = 0

    @property
    def plain(self) -> Task:
        """The same as inputs (displacement, speed, load where logged) and output."""
        return Task(*(tuple(map(_logged, runs)) for runs in (self.fit, self.held_out)), self.judged_from)


def _logged(r: ForceRun) -> Logged:
    load = () if r.load is None else (r.load,)
    return Logged(np.column_stack([r.displacement, r.speed, *load]), r.force, r.dt)


def tasks(data: Path) -> Iterator[ForceTask]:
    """The tasks that a folder of data holds, whatever runs are in it."""
    damper = data / "mr-damper"
    for series in sorted({p.name.split(".")[1] for p in damper.glob("ensaio.?.*.mat")}):
        runs = tuple(_damper(p) for p in sorted(damper.glob(f"ensaio.{series}.*.mat")))
        other = tuple(_damper(p) for p in sorted(damper.glob(f"ensaio.vali.{series}.*.mat")))
        held = runs[THIRD - 1 :: THIRD]
        rest = tuple(r for i, r in enumerate(runs) if i % THIRD != THIRD - 1)
        yield ForceTask(f"damper, series {series}, every third run", rest, held)
        if other:
            yield ForceTask(f"damper, series {series}, its validation", runs, other)
    piston = data / "piston-friction"
    for path in sorted(piston.glob("*.csv")):
        name, run = re.sub(r"_", " ", path.stem), _piston(path)
        first = piston / f"{path.stem.removesuffix(AGAIN)}.csv"
        if path.stem.endswith(AGAIN) and first.is_file():
            yield ForceTask(f"seal {first.stem.replace('_', ' ')}, second run", (_piston(first),), (run,))
        else:
            yield _halved(f"seal {name}", run)
    loop = data / "pam-joint-force" / "data.mat"
    if loop.is_file():
        yield _halved("muscle joint, force loop", _loop(loop))


def _halved(name: str, run: ForceRun) -> ForceTask:
    at = round(FITTED * len(run.force))
    return ForceTask(name, (run.rows(0, at),), (run,), at)


def _damper(path: Path) -> ForceRun:
    from scipy.io import loadmat

    content = loadmat(path)
    return ForceRun(content["dist"].ravel().astype(float), content["forc"].ravel().astype(float), None, DT)


def _piston(path: Path) -> ForceRun:
    table = np.loadtxt(path, delimiter="\t")
    time, first = 1e-3 * table[:, 0], np.unique(table[:, 0], return_index=True)[1]
    even = np.arange(time[0], time[-1], DT)
    x, force, pressure = (np.interp(even, time[first], table[first, c]) for c in (4, 6, 5))
    return ForceRun(x, force, pressure, DT)


def _loop(path: Path) -> ForceRun:
    """At 100 Hz, means of ten rows; the displacement in mm."""
    from scipy.io import loadmat

    content = loadmat(path)
    x, force = (content[n].ravel()[: len(content[n]) // 10 * 10].reshape(-1, 10).mean(axis=1) for n in "xF")
    return ForceRun(1e3 * x, force, None, DT)


def _base(r: ForceRun) -> Array:
    """Area times load (or a constant), stiffness, viscosity."""
    return np.column_stack([np.ones(len(r.force)) if r.load is None else r.load, r.displacement, r.speed])


def _least_squares(
    task: ForceTask, columns: Callable[[ForceRun], Array]
) -> tuple[float, Callable[[ForceRun], Array]]:
    """What columns leave of the forces fitted, as a sum of squares, behind the lag that leaves least; and the
    force of a run."""
    y = np.concatenate([r.force for r in task.fit])
    made = [(r, columns(r)) for r in task.fit]
    found = []
    for tau in LAGS:
        a = np.vstack([lagged(c, r.dt, tau, 0.0) for r, c in made])
        weights = np.linalg.lstsq(a, y, rcond=None)[0]
        found.append((float(np.sum((a @ weights - y) ** 2)), tau, weights))
    cost, tau, weights = min(found, key=lambda f: f[0])
    return cost, lambda r: lagged(columns(r), r.dt, tau, 0.0) @ weights


def coulomb(task: ForceTask) -> list[Array]:
    """Spring, damper, load times area, and a friction that has the sign of the speed."""
    _, force = _least_squares(task, lambda r: np.column_stack([_base(r), np.sign(r.speed)]))
    return [force(r) for r in task.held_out]


def bouc_wen(task: ForceTask) -> list[Array]:
    """The same with the friction of Bouc and Wen (J. Eng. Mech. Div. 102, 1976), which slips gradually."""
    from scipy.optimize import minimize

    span = float(np.ptp(np.concatenate([r.displacement for r in task.fit])))

    def columns(p: Array) -> Callable[[ForceRun], Array]:
        slip, sharp = (float(np.exp(np.clip(v, *FAR))) for v in (p[0], p[2]))
        slip, share = span * slip, float(np.clip(p[1], 0.0, 1.0))
        return lambda r: np.column_stack([_base(r), slipping(r.displacement, slip, share, sharp)])

    found = minimize(
        lambda p: _least_squares(task, columns(p))[0],
        np.array([np.log(0.03), 0.5, 0.0]),
        method="Nelder-Mead",
        options={"maxfev": EVALUATIONS},
    )
    _, force = _least_squares(task, columns(found.x))
    return [force(r) for r in task.held_out]


@njit(cache=False)
def slipping(x, slip, share, sharp):  # type: ignore[no-untyped-def]
    """The state of Bouc and Wen, within 1, under a displacement (n,), from zero: dz = dx (1 - |z|^sharp
    (share sign(z dx) + 1 - share)) / slip."""
    found, z = np.zeros(len(x)), 0.0
    for i in range(1, len(x)):
        way = (x[i] - x[i - 1]) / slip
        steps = int(abs(way) / STEP) + 1
        for _ in range(steps):
            against = 1.0 - share + (share if z * way > 0.0 else -share)
            z = min(max(z + way / steps * (1.0 - abs(z) ** sharp * against), -1.0), 1.0)
        found[i] = z
    return found


def record(task: ForceTask, methods: Sequence[str] = tuple(METHODS)) -> dict[str, Any]:
    """Errors of all laws and methods on a task, for JSON."""
    plain = task.plain
    choices: list[FrictionChoice] = []

    def ours(_: Task) -> list[Array]:
        choices.append(fit_friction(task.fit))
        return [choices[0].law.force(r) for r in task.held_out]

    laws: dict[str, Method] = {
        "ours": ours,
        "Coulomb": lambda _: coulomb(task),
        "Bouc-Wen": lambda _: bouc_wen(task),
    }
    errors = {n: error(plain, m) for n, m in (laws | {n: METHODS[n] for n in methods}).items()}
    parts = choices[0].law.parts
    return {
        "task": task.name,
        "rows": {
            "fit": sum(len(r.force) for r in task.fit),
            "held_out": sum(len(r.force) - task.judged_from for r in task.held_out),
        },
        "range": plain.span,
        "unit": "N",
        "parts": [
            *(["presliding and rate"] if parts.presliding else []),
            *([f"curves of {parts.knots} knots"] if parts.knots else []),
            *(["running in"] if parts.running_in else []),
        ],
        "errors": errors,
    }
