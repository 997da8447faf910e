"""Standard errors of a stage that is driven by an estimated one: the wrist under the regulator's pressure.

The sandwich of the wrist takes the pressure for known.  What the regulator's parameters are uncertain by goes
through it: a gain that is too high makes slopes too low (Murphy & Topel, Estimation and inference in two-step
econometric models, J. Business & Economic Statistics 3, 1985, doi 10.1080/07350015.1985.10509471).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.effects import in_order
from plants.measured.trace.revision.revised import errors_of
from plants.measured.trace.stages.model import Model

Array = NDArray[np.float64]


def std_errors(model: Model, regulator: Model | None = None) -> dict[str, float | None]:
    """Standard error of each parameter of a model, None for one that is not determined; regulator: what
    drives it."""
    own, white = errors_of(model).std_errors, white_errors(model)
    # What was measured and put back leaves nothing of the regulator's errors.
    through = np.zeros(len(own))
    if regulator is not None and model.stage.free_drives is None:
        through = _through(model, regulator)
    return {
        n: None if e is None else float(np.hypot(max(e, w), t))
        for n, e, w, t in zip(model.names, own, white, through, strict=True)
    }


def white_errors(model: Model) -> Array:
    """Standard error of each parameter (n,) where nothing but white noise of the channel's floor is left: a
    sandwich over few blocks scatters, and should not fall below it."""
    slopes = model.linear[1]
    size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
    inverse = np.linalg.pinv((slopes / size).T @ (slopes / size), hermitian=True)
    found: Array = np.sqrt(np.maximum(np.diag(inverse), 1e-12)) / size
    return found


def sensitivity(model: Model, regulator: Model) -> Array:
    """How each parameter of a driven stage, fitted, moves with each of what drives it, (n, k)."""
    stage = replace(model.stage, name="whole", drives=None, free_drives=None)
    whole = Model(
        stage, model.start, {**model.values, **regulator.found}, in_order((*regulator.forms, *model.forms)),
        (*regulator.fixed, *model.fixed),
    )  # fmt: skip
    slopes = whole.linear[1]
    mine, its = ([whole.names.index(n) for n in m.names] for m in (model, regulator))
    size = np.maximum(np.linalg.norm(slopes[:, mine], axis=0), 1e-12)
    found: Array = np.linalg.lstsq(slopes[:, mine] / size, -slopes[:, its], rcond=1e-9)[0] / size[:, None]
    return found


def _through(model: Model, regulator: Model) -> Array:
    """Standard deviation of each parameter of a driven stage by the uncertainty of what drives it, (n,)."""
    moved, found = sensitivity(model, regulator), errors_of(regulator)
    errors = np.array([e or 0.0 for e in found.std_errors])
    covariance = found.correlation * np.outer(errors, errors)
    variance: Array = np.einsum("ij,jk,ik->i", moved, covariance, moved)
    return np.sqrt(np.maximum(variance, 0.0))
