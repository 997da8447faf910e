"""What users would take instead of a model of the rig, on any rig: inputs to an output, in a free run.

Each is fitted on the same rows, starts from the first measured rows that it needs and sees no measured output
after them.  What it has to choose (orders, degree, threshold) it chooses by its free run on the last fifth of
the rows fitted.  Libraries are no dependencies: where one is not installed, its method raises ImportError.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from plants.measured.guess.rough_models import lagged
from plants.measured.trace.revision.errors import interval

Array = NDArray[np.float64]
TRIED_ON = 0.2
"""Share of the rows fitted, the last ones, on which a method chooses among its settings."""

INPUT_LAGS = 6
"""Delayed values of all inputs together that NARX and SINDy models are offered."""

TERMS = 15
"""Terms of a NARX model, at most."""

KNOTS = 6
"""Knots of the static map of each input of a Hammerstein-Wiener model."""

EVEN = np.linspace(-5.0, 5.0, 2001)
"""Values, in standard deviations, among which its first state is sought."""

DELAYS = (0, 1, 2, 4, 8)
"""Rows by which its inputs may be late."""

RUNAWAY = 1e3
"""Free runs beyond so many standard deviations of the output have run away."""

Setting = TypeVar("Setting")


@dataclass(frozen=True)
class Logged:
    """Inputs (n, m) and output (n,) every `dt` [s]."""

    inputs: Array
    output: Array
    dt: float

    def rows(self, first: int, last: int) -> "Logged":
        """The rows from `first` to before `last`."""
        return Logged(self.inputs[first:last], self.output[first:last], self.dt)


@dataclass(frozen=True)
class Task:
    """Runs to fit and runs held out, of which the rows from `judged_from` on are judged."""

    fit: tuple[Logged, ...]
    held_out: tuple[Logged, ...]
    judged_from: int = 0

    @property
    def span(self) -> float:
        """Range of the output that is judged."""
        return float(np.ptp(np.concatenate([r.output[self.judged_from :] for r in self.held_out])))

    def left(self, made: Sequence[Array]) -> list[Array]:
        """Errors of free runs (n,) of the runs held out, on the rows judged."""
        return [(f - r.output)[self.judged_from :] for f, r in zip(made, self.held_out, strict=True)]


Method = Callable[[Task], list[Array]]
FreeRun = Callable[[Logged], Array]


def error(task: Task, method: Method) -> dict[str, Any]:
    """Error of a method on the rows judged with its interval at 95 %; what came in between, in words."""
    try:
        left = task.left(method(task))
    except ImportError:
        return {"error": None, "why": "not installed"}
    rms = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    if not rms < task.span:
        return {"error": None, "why": "runs away"}
    low, high = interval([e**2 for e in left], [r.dt for r in task.held_out])
    return {"error": rms, "interval_95": (low, high), "share_of_range": rms / task.span}


def arx(task: Task) -> list[Array]:
    """A linear difference equation, of the order of 1 to 4 that does best."""
    return _chosen(task, (1, 2, 3, 4), _arx)


def narx(task: Task) -> list[Array]:
    """SysIdentPy: a polynomial NARX model with terms by FROLS and BIC, of degree 2 and the order of two that
    does best."""
    return _chosen(task, ((1, 2), (2, 2)), _narx)


def sindy(task: Task) -> list[Array]:
    """PySINDy: a discrete model of the output with delayed inputs, of the degree and threshold of four that
    does best."""
    return _chosen(task, ((1, 1e-3), (1, 1e-2), (2, 1e-3), (2, 1e-2)), _sindy)


def hammerstein_wiener(task: Task) -> list[Array]:
    """Static maps of the inputs, two lags behind a delay, a cubic of what comes out; of five delays the one
    that does best.  No library has it: scipy's least squares fits all of it at once, in 30 steps."""
    return _chosen(task, DELAYS, _hammerstein_wiener)


def _chosen(
    task: Task, settings: Sequence[Setting], made: Callable[[Sequence[Logged], Setting], FreeRun]
) -> list[Array]:
    """Free runs of a method with the setting that does best on the last fifth of the rows fitted."""
    n = len(task.fit)
    if n > 1:
        last = max(1, round(TRIED_ON * n))
        first, rest = task.fit[:-last], task.fit[-last:]
    else:
        (run,) = task.fit
        at = round((1.0 - TRIED_ON) * len(run.output))
        first, rest = (run.rows(0, at),), (run.rows(at, len(run.output)),)

    scaled = _Scale.of(first)

    def tried(setting: Setting) -> float:
        free = made([scaled.to(r) for r in first], setting)
        left = [free(s) - s.output for s in (scaled.to(r) for r in rest)]
        rms = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
        return rms if np.isfinite(rms) else np.inf

    best = min(settings, key=tried)
    scale = _Scale.of(task.fit)
    free = made([scale.to(r) for r in task.fit], best)
    return [free(scale.to(r)) * scale.size[-1] + scale.centre[-1] for r in task.held_out]


@dataclass(frozen=True)
class _Scale:
    """Means and standard deviations of inputs and, last, output."""

    centre: Array
    size: Array

    @classmethod
    def of(cls, runs: Sequence[Logged]) -> "_Scale":
        whole = np.vstack([np.column_stack([r.inputs, r.output]) for r in runs])
        return cls(whole.mean(axis=0), np.maximum(whole.std(axis=0), 1e-12))

    def to(self, r: Logged) -> Logged:
        inputs = (r.inputs - self.centre[:-1]) / self.size[:-1]
        return Logged(inputs, (r.output - self.centre[-1]) / self.size[-1], r.dt)


def _delayed(inputs: Array, lags: int) -> Array:
    """Inputs and their values up to so many rows before, of shape (n, m (lags + 1)), first values held."""
    late = [np.vstack([np.repeat(inputs[:1], k, axis=0), inputs])[: len(inputs)] for k in range(lags + 1)]
    return np.hstack(late)


def _arx(runs: Sequence[Logged], order: int) -> FreeRun:
    def past(r: Logged) -> Array:
        return np.column_stack([r.output[order - k : len(r.output) - k] for k in range(1, order + 1)])

    def given(r: Logged) -> Array:
        return np.column_stack([_delayed(r.inputs, order), np.ones(len(r.output))])

    rows = np.vstack([np.hstack([past(r), given(r)[order:]]) for r in runs])
    weights = np.linalg.lstsq(rows, np.concatenate([r.output[order:] for r in runs]), rcond=None)[0]

    def free(r: Logged) -> Array:
        driven, found = (given(r) @ weights[order:]).tolist(), r.output[:order].tolist()
        own = weights[:order].tolist()
        for i in range(order, len(r.output)):
            value = driven[i] + sum(w * found[i - k] for k, w in enumerate(own, start=1))
            found.append(min(max(value, -RUNAWAY), RUNAWAY))
        return np.array(found)

    return free


def _narx(runs: Sequence[Logged], setting: tuple[int, int]) -> FreeRun:
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    own, degree = setting
    m = runs[0].inputs.shape[1]
    lags = list(range(1, INPUT_LAGS // m + 1))
    model = FROLS(
        order_selection=True, n_info_values=TERMS, ylag=own, xlag=[lags] * m if m > 1 else lags,
        info_criteria="bic", basis_function=Polynomial(degree=degree),
    )  # fmt: skip
    model.fit(X=np.vstack([r.inputs for r in runs]), y=np.concatenate([r.output for r in runs])[:, None])

    def free(r: Logged) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):
            found = model.predict(X=r.inputs, y=r.output[: model.max_lag, None])
        return np.asarray(found, float).ravel()

    return free


def _sindy(runs: Sequence[Logged], setting: tuple[int, float]) -> FreeRun:
    import pysindy

    degree, threshold = setting
    lags = INPUT_LAGS // runs[0].inputs.shape[1] - 1
    library = pysindy.PolynomialLibrary(degree=degree)
    model = pysindy.DiscreteSINDy(optimizer=pysindy.STLSQ(threshold=threshold), feature_library=library)
    model.fit([r.output[:, None] for r in runs], t=1, u=[_delayed(r.inputs, lags) for r in runs])
    weights, powers = np.asarray(model.coefficients())[0], np.asarray(library.powers_)

    def free(r: Logged) -> Array:
        given, now, found = _delayed(r.inputs, lags), float(r.output[0]), []
        for row in given:  # the model's own simulation is the same, a hundred times slower
            found.append(now)
            now = float(np.prod(np.append(now, row) ** powers, axis=1) @ weights)
            now = min(max(now, -RUNAWAY), RUNAWAY)
        return np.array(found)

    return free


def _hammerstein_wiener(runs: Sequence[Logged], delay: int) -> FreeRun:
    from scipy.optimize import least_squares

    dt, m = runs[0].dt, runs[0].inputs.shape[1]
    low = np.min([r.inputs.min(axis=0) for r in runs], axis=0)
    high = np.max([r.inputs.max(axis=0) for r in runs], axis=0)

    def static(r: Logged) -> Array:
        at = np.clip((r.inputs - low) / np.maximum(high - low, 1e-12), 0.0, 1.0) * (KNOTS - 1)
        hats = np.maximum(0.0, 1.0 - np.abs(at[:, :, None] - np.arange(KNOTS)))
        return hats.reshape(len(at), m * KNOTS)

    def curved(slow: Array, p: Array) -> Array:
        return slow + p[2] * slow**2 + p[3] * slow**3

    def out(mapped: Array, first: float, p: Array) -> Array:
        """From a first measured value: the slower lag begins where it gives that."""
        fast = lagged(mapped @ p[4:], dt, float(np.exp(p[1])), delay * dt)
        begin = float(EVEN[np.argmin(np.abs(curved(EVEN, p) - first))])
        slow = lagged(np.concatenate([[begin], fast]), dt, float(np.exp(p[0])), 0.0)[1:]
        return curved(slow, p)

    given = [(static(r), float(r.output[0])) for r in runs]
    y = np.concatenate([r.output for r in runs])
    starts = []
    for tau in dt * np.array([0.5, 2.0, 8.0, 32.0]):
        from_zero = [np.vstack([np.zeros((1, m * KNOTS)), g]) for g, _ in given]
        columns = np.vstack([lagged(g, dt, tau, delay * dt)[1:] for g in from_zero])
        fades = np.concatenate([f * np.exp(-dt / tau * np.arange(1, len(g) + 1)) for g, f in given])
        weights = np.linalg.lstsq(columns, y - fades, rcond=1e-6)[0]
        left = float(np.sum((columns @ weights + fades - y) ** 2))
        starts.append((left, np.concatenate([[np.log(tau), np.log(0.5 * dt), 0.0, 0.0], weights])))
    first = min(starts, key=lambda s: s[0])[1]
    bounds = (np.full(len(first), -20.0), np.full(len(first), 20.0))
    bounds[0][:2], bounds[1][:2] = np.log(0.1 * dt), np.log(1e4 * dt)
    bounds[0][2:4], bounds[1][2:4] = -0.5, 0.5

    def residual(p: Array) -> Array:
        return np.concatenate([out(g, f, p) for g, f in given]) - y

    fitted = least_squares(residual, np.clip(first, *bounds), bounds=bounds, max_nfev=30).x
    return lambda r: out(static(r), float(r.output[0]), fitted)


METHODS: dict[str, Method] = {
    "ARX": arx,
    "SysIdentPy NARX": narx,
    "PySINDy": sindy,
    "Hammerstein-Wiener": hammerstein_wiener,
}
