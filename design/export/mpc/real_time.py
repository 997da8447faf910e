"""The nonlinear MPC by real-time iteration as C: one Gauss-Newton step of the exact problem a period.

The law is `design.mpc.formulations.real_time.RealTimeMPC` with nothing prepared, in Python as on the target:
what is linearised about is always the state that is believed now.  (Python's own loop linearises about the
state that it predicts, after the command is out, so that less is left to do when the next measurement
comes.)

In C it solves for the step d = u - v from the plan v; without bounds,

    H = J'QJ + M,    H d = -(J'Q e + M v - m),    e the errors and J the slopes of the angles at v,

which is the same QP, but keeps the digits of a single-precision number for what changes.  The slopes are
the forward sensitivities of one substep, as a graph, chained over the horizon.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from design.export.fields import Quantity, described
from design.export.mpc.ladder import Ladder, descend
from design.export.mpc.laws import Number, constants, laws, part, play, within, without_bounds
from design.export.part import Part
from design.mpc import observer
from design.mpc.formulations import linear
from design.mpc.formulations.real_time import JUMP, STUCK, real_time_mpc
from design.mpc.prediction import Carried, carried
from design.mpc.problem import Believed, MPCProblem
from plants.kernel import pytrees as tree
from plants.kernel.graphs import baked, c_source, graph


class RealTimeMemory(NamedTuple):
    """What the C remembers beside its last command: belief, rungs of the ladder, and the commands [V] of the
    plan from the next period on."""

    believed: Believed
    ladder: Ladder
    plan: tuple[Number, ...]


def of_real_time_mpc(name: str, title: str, problem: MPCProblem) -> Part:
    """The nonlinear MPC of a problem.

    Raises InputError where daqp, which the test vector needs, is missing."""
    N, wrist = problem.horizon, problem.wrist
    controller = real_time_mpc(problem)
    planner, ladder, belief = controller.first.planner, controller.fallback, observer.begin(0.0, 100.0, wrist)

    def start(at: Any) -> Any:
        command = within(at[0] / wrist.regulator.gain, problem)
        return RealTimeMemory(observer.begin(at[1], at[0], wrist), Ladder(), (command,) * N), command

    along = Carried.of(wrist)
    c, slopes = wrist.sampled(), (0.0,) * len(along.entries)
    code = c_source(
        f"{name}_law",
        baked(f"{name}_init_law", graph(start, (0.0, 0.0))),
        *laws(name, problem, planner, controller.gains),
        descend(name, ladder, problem.period),
        play(name, problem),
        baked(f"{name}_slope_law", graph(partial(carried, along=along), belief.plant, slopes, (0.0,), c), c),
    )
    state = (
        *described(belief),
        *described(Ladder()),
        Quantity("plan", "V", "commands from the next period on", N),
    )
    own = {
        **constants(problem, planner, ladder), **chained(along), "factored": True, "laws": [
            "init", "believe", "target", "ahead", "wanted", "press", "descend", "play", "slope",
        ],
        "tables": {"UNBOUNDED": without_bounds(planner).tolist(), "FACTOR": [factor(planner)]},
        "weights": problem.weights, "jump": JUMP, "stuck": STUCK, "shift": tree.names(belief).index("shift"),
        "virgin": tree.names(belief.plant).index("memory.virgin") if problem.loop.DEAD_ZONE else None,
    }  # fmt: skip
    stack = 8 * (2 * N * (N + 1) + (N + 1) ** 2 + 16 * N) // 1000
    return part(
        name, title, controller, state, code, "real_time.c.jinja", own,
        (
            f"In each period the wrist is linearised about the plan of the period before and one QP "
            f"(horizon {N}, range and rate of the command bounded) is solved by a dual active-set method "
            f"with a bound on its iterations. Where there is no plan, where the reference changed by "
            f"{JUMP:g} deg or more, and where the plan stays in the dead zone, the linear MPC's plan is "
            f"taken if it costs less. A step takes about {stack} kB of stack in double precision. Where the "
            f"QP has no answer the return code is {name.upper()}_FAILED, and the command that of the plan "
            "before, then of a PI, as where a measurement is lost."
        ),
    )  # fmt: skip


def chained(along: Carried) -> dict[str, Any]:
    """How the slopes of a period are chained: of each row of the state, which entry times which row; the
    entry by the command; what the entries are at the start of a period."""
    n, place = len(along.rows), {entry: k for k, entry in enumerate(along.entries)}
    return {
        "products": [[(place[i, k], k) for k in range(n) if (i, k) in place] for i in range(n)],
        "by_command": [place.get((i, n)) for i in range(n)],
        "seeds": [float(i == j) for i, j in along.entries],
    }


def factor(of: linear.Planner) -> list[float]:
    """Cholesky factor of the linear plan's Hessian, row by row, of its diagonal the inverse."""
    L = np.linalg.cholesky(of.hessian)
    np.fill_diagonal(L, 1.0 / np.diag(L))
    return [float(x) for x in L.ravel()]
