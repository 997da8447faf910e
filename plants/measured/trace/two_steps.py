"""Standard errors of a stage that is driven by an estimated one: the wrist under the regulator's pressure.

The sandwich of the wrist takes the pressure for known.  What the regulator's parameters are uncertain by goes
through it: a gain that is too high makes slopes too low (Murphy & Topel, Estimation and inference in two-step
econometric models, J. Business & Economic Statistics 3, 1985, doi 10.1080/07350015.1985.10509471).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.trace.stages.model import Model, ordered
from plants.measured.trace.trace import errors_of

Array = NDArray[np.float64]


def std_errors(model: Model, regulator: Model | None = None) -> dict[str, float | None]:
    """Standard error of each parameter of a model, None for one that is not determined; regulator: what
    drives it."""
    own = errors_of(model).std_errors
    through = np.zeros(len(own)) if regulator is None else _through(model, regulator)
    return {
        n: None if e is None else float(np.hypot(e, t))
        for n, e, t in zip(model.names, own, through, strict=True)
    }


def _through(model: Model, regulator: Model) -> Array:
    """Standard deviation of each parameter of a driven stage by the uncertainty of what drives it, (n,)."""
    stage = replace(model.stage, name="whole", drives=None, free_drives=None)
    known = {n: regulator.values[n] for n in regulator.names}
    whole = Model(
        stage, model.start, {**model.values, **known}, ordered((*regulator.forms, *model.forms)),
        (*regulator.fixed, *model.fixed),
    )  # fmt: skip
    slopes = whole.linear[1]
    of = whole.names.index
    mine, its = ([of(n) for n in m.names] for m in (model, regulator))
    moved = np.linalg.lstsq(slopes[:, mine], -slopes[:, its], rcond=1e-9)[0]
    found = errors_of(regulator)
    errors = np.array([e or 0.0 for e in found.std_errors])
    covariance = found.correlation * np.outer(errors, errors)
    variance: Array = np.einsum("ij,jk,ik->i", moved, covariance, moved)
    return np.sqrt(np.maximum(variance, 0.0))
