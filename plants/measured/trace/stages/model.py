"""A wrist with effects, fitted to one stage: what a trace compares."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plants.effects import in_order
from plants.measured.fitting.estimate import jacobian, minimise
from plants.measured.fitting.problem import FitProblem
from plants.measured.fitting.stage import Form, Stage
from plants.parameters.quantities import ParameterSet
from plants.wrist import Wrist

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """A declared wrist and effects of some forms, with values for all parameters of both.

    start: bounds and starting values of the declared parameters.  fixed:
    parameters that the recordings do not determine, kept.
    """

    stage: Stage
    start: ParameterSet
    values: Mapping[str, float]
    forms: tuple[Form, ...] = ()
    fixed: tuple[str, ...] = ()

    @property
    def wrist(self) -> Wrist:
        """The wrist that it is a model of."""
        return Wrist.from_values(self.values, self.forms, self.stage.rig)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(f.NAME for f in self.forms)

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters that are fitted: the stage's declared ones, then those of the effects."""
        return tuple(n for n in (*self.stage.declared, *self.of_effects) if n not in self.fixed)

    @property
    def of_effects(self) -> tuple[str, ...]:
        """Parameters of the effects, ``effect.parameter``."""
        return tuple(f"{f.NAME}.{n}" for f in self.forms for n in f.kinds())

    @property
    def found(self) -> dict[str, float]:
        """Values of what was fitted, and of all parameters of the effects."""
        return {n: self.values[n] for n in dict.fromkeys((*self.names, *self.of_effects))}

    @property
    def problem(self) -> FitProblem:
        """The residuals of the model, as a function of its parameters."""
        return FitProblem(self.stage, self.forms, self.names, self.values)

    @property
    def vector(self) -> Array:
        """The parameters that are fitted, (n,)."""
        return np.array([self.values[n] for n in self.names], float)

    @property
    def bounds(self) -> Array:
        """Start, lower and upper bound of each of them, (3, n)."""
        return self.problem.bounds(self.start)

    @cached_property
    def linear(self) -> tuple[Array, Array]:
        """Residuals (rows,), simulated minus measured over noise, and their derivatives (rows, n)."""
        return jacobian(self.problem, self.vector, self.bounds)

    @cached_property
    def residual(self) -> Array:
        """Simulated minus measured over the noise, (rows,)."""
        found: Array = self.problem.residuals(self.vector[None, :])[:, 0]
        return found

    @cached_property
    def chi2(self) -> float:
        """Mean square of the residual in units of the noise: 1 where all is explained."""
        return float(np.mean(self.residual**2))

    @property
    def freely(self) -> "Model":
        """The same model in a free run from the command."""
        stage = self.stage.freely
        return self if stage is self.stage else replace(self, stage=stage)

    def at(self, vector: Array) -> "Model":
        """The same model with other values of its parameters."""
        return self.with_values(dict(zip(self.names, map(float, vector), strict=True)))

    def with_values(self, values: Mapping[str, float]) -> "Model":
        """The same model with other values of some parameters."""
        return Model(self.stage, self.start, {**self.values, **values}, self.forms, self.fixed)

    def plus(self, form: Form, values: Mapping[str, float]) -> "Model":
        """The model with one more effect at some values, given by the names of the form's parameters."""
        more = {f"{form.NAME}.{n}": float(v) for n, v in values.items()}
        return Model(
            self.stage, self.start, {**self.values, **more}, in_order((*self.forms, form)), self.fixed
        )

    def without(self, name: str) -> "Model":
        """The model without the effect of a name."""
        own = f"{name}."
        values = {n: v for n, v in self.values.items() if not n.startswith(own)}
        forms = tuple(f for f in self.forms if name != f.NAME)
        fixed = tuple(n for n in self.fixed if not n.startswith(own))
        return Model(self.stage, self.start, values, forms, fixed)

    def fitted(
        self, evaluations: int = 40, tol: float = 1e-6, rows: NDArray[np.bool_] | None = None
    ) -> "Model":
        """The model at the least squares that lie nearest, on some of the rows."""
        x, _ = minimise(self.problem.on(rows), self.bounds[0], self.bounds, evaluations=evaluations, tol=tol)
        return self.at(x)

    def fitted_off_jumps(self) -> "Model":
        """The model at the least squares of what times of jumps do not explain, that lie nearest."""
        problem = self.problem.off_jumps(self.vector)
        return self.at(minimise(problem, self.bounds[0], self.bounds, tol=1e-6)[0])
