"""The linear MPC as C: observer, condensed QP, first move.

The QP's answer depends on four numbers alone, theta = (static angle h, angle a without the shift,
shift - r, u of the period before), and only its first move is used.  With A = (I, D) the matrix of the
bounds, f = F theta and lambda the multipliers of those that are met,

    u = X theta - H^-1 A' lambda,     X = -H^-1 F,

so that X (N, 4) and the rows of A H^-1 (2N, N), computed here, are all that the target needs: what is
solved there is a least-distance problem in the multipliers (`templates/active_set.c.jinja`).
"""

from typing import Any, NamedTuple

import numpy as np

from design.export.fields import Quantity, described
from design.export.mpc.ladder import Ladder, descend
from design.export.mpc.laws import Array, Number, constants, laws, part, play, within, without_bounds
from design.export.part import Part
from design.mpc import observer
from design.mpc.formulations import linear
from design.mpc.problem import Believed, MPCProblem
from plants.kernel.graphs import baked, c_source, graph


class MPCMemory(NamedTuple):
    """What the C remembers beside its last command: belief, rungs of the ladder, and as far as a plan is
    followed without a new one its static angles from the next period on and its u from the last one on."""

    believed: Believed
    ladder: Ladder
    plan: tuple[Number, ...]
    wish: tuple[Number, ...]


def of_linear_mpc(name: str, title: str, problem: MPCProblem) -> Part:
    """The linear MPC of a problem.  Raises InputError where daqp, which the test vector needs, is missing."""
    controller = linear.linear_mpc(problem)
    planner, ladder = controller.planner, controller.fallback
    belief, kept = observer.begin(0.0, 100.0, problem.wrist), ladder.patience + 1
    nothing = (0.0,) * kept

    def start(at: Any) -> Any:
        believed = observer.begin(at[1], at[0], problem.wrist)
        memory = MPCMemory(believed, Ladder(), nothing, nothing)
        return memory, within(at[0] / problem.wrist.regulator.gain, problem)

    code = c_source(
        f"{name}_law",
        baked(f"{name}_init_law", graph(start, (0.0, 0.0))),
        *laws(name, problem, planner, controller.gains),
        descend(name, ladder, problem.period),
        *([play(name, problem)] if problem.delay else []),
    )
    state = (
        *described(belief),
        *described(Ladder()),
        Quantity("plan", "deg", "static angles from the next period on", kept),
        Quantity("wish", "deg", "static angles that the commands point to, from the last one on", kept),
    )
    X, towards = without_bounds(planner), towards_bounds(planner)
    own = {
        **constants(problem, planner, ladder), "factored": False, "kept": kept,
        "laws": [
            "init", "believe", "target", "ahead", "wanted", "press", "descend",
            *(["play"] if problem.delay else []),
        ],
        "tables": {"UNBOUNDED": X.tolist(), "TOWARDS": towards.tolist()},
    }  # fmt: skip
    return part(
        name, title, controller, state, code, "mpc.c.jinja", own,
        (
            f"The QP (horizon {problem.horizon}, range and rate of the command bounded) is solved by a dual "
            f"active-set method with a bound on its iterations; in double precision its matrices are about "
            f"{8 * (X.size + towards.size) // 1000} kB of constants, and a step takes about "
            f"{8 * ((problem.horizon + 1) ** 2 + 8 * problem.horizon) // 1000 + 2} kB of stack. Where it "
            f"finds no answer the return code is {name.upper()}_FAILED, and the command that of the plan "
            "before, then of a PI, as where a measurement is lost."
        ),
    )  # fmt: skip


def towards_bounds(of: linear.Planner) -> Array:
    """A H^-1 (2N, N); see the module."""
    from scipy.linalg import cho_factor, cho_solve

    A = np.vstack([np.eye(of.problem.horizon), of.problem.differences])
    return np.asarray(cho_solve(cho_factor(of.hessian), A.T).T, float)
