"""Step times of the MPCs as shares of their period, and do-mpc on the same problem in the same run.

A step is timed from the measurement to the end of the preparation of the next one, by the wall's
clock.  On a machine that others use, the 99 % quantile of that is theirs: so beside it there is the same
with every step repeated, which a pure step allows, and the least of its times kept.  What is left
varies with the step alone, such as with the iterations of its QP.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.rollouts import Disagreement
from benchmarks.timing import duel
from design.controllers.controller import Measured
from design.mpc import observer
from design.mpc.fallback import Info
from design.mpc.formulations import hybrid, linear, real_time
from design.mpc.formulations.converged import converged_mpc
from design.mpc.formulations.real_time import RealTimeMPC
from design.mpc.loop import run
from design.mpc.prediction import roll, start_of
from design.mpc.problem import MPCProblem, MPCWeights
from design.mpc.timing import Ledger, ledger
from plants import dynamics as plant
from plants.hysteresis import Memory
from plants.simulation.sensor import HOLD, sensor
from plants.wrist import SAMPLE_TIME, STARTS, State, Wrist

Array = NDArray[np.float64]

MEANING = {
    "mpc.linear_p99_share_of_period": "99 % quantile of a linear MPC's step / its period, 20 ms, wall clock",
    "mpc.rti_p99_share_of_period": "the same of the real-time iteration; horizon 30",
    "mpc.linear_p99_share_of_period_quiet": "the same of the linear MPC, each step the least of 5 repeats",
    "mpc.rti_p99_share_of_period_quiet": "the same of the real-time iteration, each step the least of 5",
    "mpc.linear_median_share_of_period": "median of a linear MPC's step / its period, wall clock",
    "mpc.rti_median_share_of_period": "the same of the real-time iteration",
    "mpc.rti_vs_do_mpc": "do-mpc's time for one step of the same problem / the real-time iteration's",
    "mpc.do_mpc_ms": "ms per step of do-mpc, begun at its last answer",
    "mpc.rti_cost_vs_converged": "closed-loop cost of the real-time iteration / of the NLP, converged; mean",
    "mpc.rti_cost_vs_converged_worst": "the same, the largest of 16 tasks of 15 deg",
    "mpc.linear_cost_vs_converged": "the same of the linear MPC, mean",
    "mpc.converged_plan_vs_from_hybrid": "cost of the NLP's first plan / where the MILP's leads; 2 tasks",
    "mpc.converged_plan_vs_hybrid_bound": "the same / what HiGHS proves for the hybrid model, same cost",
    "mpc.hybrid_law_error_kpa_per_s": "kPa/s, most that k(e) e, piecewise affine, is off, over a period",
}
"""What each figure says."""

LEAVE_OUT = 20
"""First steps of a run that are not counted: code and caches are loaded there."""

REPEATS = 5
"""Of each step, in the quiet figures."""

TOLERANCE = 1e-3
"""Largest relative difference of do-mpc's cost of its plan and ours of the same plan."""

HYBRID_HORIZON = 20
"""Periods of the MILP's problem, which takes some 10 to 20 s."""

SENSOR = sensor(0.02, 0.01)
NOISE = np.random.default_rng(0).standard_normal((round(4.0 / SAMPLE_TIME) // HOLD, 1))
"""The sensor of the timed runs, and its noise."""

Make = Callable[[MPCProblem], Any]


class Repeated:
    """A controller whose steps are repeated, the record of the shortest being kept."""

    def __init__(self, controller: Any, times: int) -> None:
        self.problem, self.init = controller.problem, controller.init
        self.controller, self.times = controller, times

    def step(self, state: Any, seen: Measured) -> tuple[Any, float, Info]:
        """The step, which is the same however often it is made."""
        made = [self.controller.step(fresh(state), seen) for _ in range(self.times)]
        return min(made, key=lambda m: m[2].total_ns)


def fresh(state: Any) -> Any:
    """The state with its Hessian another array: the solver would know one that it has factorised."""
    if state.prepared is None:
        return state
    return state._replace(prepared=state.prepared._replace(hessian=state.prepared.hessian.copy()))


def steps(make: Make, wrist: Wrist, times: int) -> list[Info]:
    """Records of the steps of the 15 degree tasks, both signs from every starting memory, with noise."""
    controller = Repeated(make(MPCProblem(wrist)), times)
    found: list[Info] = []
    for start in STARTS:
        for reference in (15.0, -15.0):
            done = run(wrist, controller, reference, wrist.rest(start), 4.0, False, SENSOR, NOISE)
            found += done.periods[LEAVE_OUT if not found else 0 :]
    return found


def step_times(make: Make, times: int = 1) -> Ledger:
    """The deadline ledger of a kind of MPC over both motions, each step the least of so many repeats."""
    infos = steps(make, Wrist.flexion(), times) + steps(make, Wrist.deviation(), times)
    return ledger(infos, MPCProblem(Wrist.flexion()).period)


def midway(problem: MPCProblem, periods: int = 6) -> tuple[RealTimeMPC, Any, Measured, State]:
    """A real-time iteration under way to 15 deg from line 1: controller, its state, what it sees next and
    the wrist's state then."""
    wrist = problem.wrist
    controller, state = real_time.real_time_mpc(problem), wrist.rest("line1")
    c, memory = wrist.sampled(), controller.init(_seen(state))
    for _ in range(periods):
        memory, command, _ = controller.step(memory, _seen(state))
        for _ in range(problem.substeps):
            state = plant.step(state, command, c)
    return controller, memory, _seen(state), state


def _seen(state: State) -> Measured:
    return Measured(15.0 - float(state.angle), float(state.angle), float(state.pressure))


def by_do_mpc(
    problem: MPCProblem, state: State, before: float, plan: Array
) -> tuple[Any, Callable[[], Array]]:
    """do-mpc's controller of the same problem, and one step of it from a state, `before` [V] having been
    the command; it begins at a plan [V] first and then at its own last answer."""
    import casadi

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it tells which of its optional parts are missing
        import do_mpc

    casadi.GlobalOptions.setNumpyMode(1)  # our laws on symbols, as in plants.kernel.graphs
    wrist = problem.wrist
    c, model = wrist.sampled(), do_mpc.model.Model("discrete", "SX")
    names = ("pressure", "h", "virgin", "angle")
    x = [model.set_variable("_x", n) for n in names]
    v = model.set_variable("_u", "command")
    after = State(x[0], Memory(x[1], x[2]), x[3])
    for _ in range(problem.substeps):
        after = plant.step(after, v, c)
    for name, value in zip(names, (after.pressure, *after.memory, after.angle), strict=True):
        model.set_rhs(name, casadi.vertcat(value))
    casadi.GlobalOptions.setNumpyMode(-1)  # do-mpc is not made for that
    model.setup()
    mpc = do_mpc.controller.MPC(model)
    mpc.settings.n_horizon, mpc.settings.t_step = problem.horizon, problem.period
    mpc.settings.state_discretization, mpc.settings.store_full_solution = "discrete", True
    mpc.settings.supress_ipopt_output()
    error = (model.x["angle"] - 15.0) ** 2
    mpc.set_objective(lterm=problem.weights.angle * error, mterm=problem.weights.terminal * error)
    mpc.set_rterm(command=problem.weights.move)
    mpc.bounds["lower", "_u", "command"] = problem.low
    mpc.bounds["upper", "_u", "command"] = problem.high
    mpc.setup()
    x0 = np.array([state.pressure, state.memory.h, state.memory.virgin, state.angle], float).reshape(-1, 1)
    mpc.x0, mpc.u0 = x0, np.array([[before]])
    mpc.set_initial_guess()
    for k, command in enumerate(plan):
        mpc.opt_x_num["_u", k, 0] = command

    def work() -> Array:
        mpc.u0 = np.array([[before]])
        mpc.make_step(x0)
        return np.array([float(mpc.opt_x_num["_u", k, 0]) for k in range(problem.horizon)])

    return mpc, work


def do_mpc_figures(rounds: int) -> dict[str, float | None]:
    """Ratio and time of do-mpc (None where it is not installed); raises Disagreement if what it minimises
    is not what we do.  The rate is not bounded and the swing not weighted here: do-mpc
    has no such terms by itself."""
    problem = MPCProblem(Wrist.flexion(), rate=100.0, weights=MPCWeights(swing=0.0))
    controller, memory, seen, state = midway(problem)
    start = start_of(memory.believed._replace(plant=state))
    try:
        mpc, work = by_do_mpc(problem, state, memory.command, memory.plan)
    except ModuleNotFoundError:
        return {"mpc.rti_vs_do_mpc": None, "mpc.do_mpc_ms": None}
    plan = work()
    if not mpc.solver_stats["success"]:
        raise Disagreement(f"do-mpc did not solve: {mpc.solver_stats['return_status']}")
    angles = roll(problem, controller.coefficients, start, 0.0, plan)[:, 3]
    # Its first stage cost is that of the state it starts from, which no command changes.
    theirs = float(mpc.S.get_function("nlp_f")(mpc.opt_x_num, mpc.opt_p_num))
    theirs -= problem.weights.angle * float(seen.error) ** 2
    ours = problem.cost(angles, plan, memory.command, 15.0)
    if not abs(theirs - ours) <= TOLERANCE * ours:
        raise Disagreement(f"do-mpc's cost of its plan is {theirs:.6g}, ours of the same plan {ours:.6g}")
    result = duel(work, lambda: controller.step(fresh(memory), seen), rounds)
    return {"mpc.rti_vs_do_mpc": result.ratio, "mpc.do_mpc_ms": result.first * 1e3}


def closed_loop_cost(problem: MPCProblem, play: Any, reference: float) -> float:
    """Cost of a run as the problem counts it, its terminal weight left out: `play` is what
    `design.mpc.loop.run` returned with its signals."""
    n = problem.substeps
    angles, commands = play.trajectory.angle[n::n, 0], play.trajectory.command[:-1:n, 0]
    before = play.trajectory.pressure[0, 0] / problem.wrist.regulator.gain
    moves = np.diff(commands, prepend=before)
    errors = angles - reference
    swings, by = np.diff(errors), problem.weights
    return float(by.angle * errors @ errors + by.swing * swings @ swings + by.move * moves @ moves)


def cost_vs_converged(converged: Make = converged_mpc) -> dict[str, float | None]:
    """Closed-loop costs of the real-time iteration and of the linear MPC over that of a controller that
    solves to convergence, `converged(problem)`, over the 15 degree tasks of both motions from every
    starting memory."""
    ratios = []
    for wrist in (Wrist.flexion(), Wrist.deviation()):
        problem = MPCProblem(wrist)
        makes = (linear.linear_mpc, real_time.real_time_mpc, converged)
        controllers = [make(problem) for make in makes]
        for start in STARTS:
            for reference in (15.0, -15.0):
                plays = [run(wrist, c, reference, wrist.rest(start), 2.0, True) for c in controllers]
                costs = [closed_loop_cost(problem, play, reference) for play in plays]
                ratios.append([costs[0] / costs[2], costs[1] / costs[2]])
    of_linear, of_rti = np.array(ratios).T
    return {
        "mpc.rti_cost_vs_converged": float(of_rti.mean()),
        "mpc.rti_cost_vs_converged_worst": float(of_rti.max()),
        "mpc.linear_cost_vs_converged": float(of_linear.mean()),
    }


def hybrid_figures() -> dict[str, float | None]:
    """How the converged NLP's first plans stand to those of the hybrid MPC, proved to be near the best of
    its model: from line 1 to 15 deg in both motions, `HYBRID_HORIZON` periods, same cost."""
    led, bound, missed = [], [], []
    for wrist in (Wrist.flexion(), Wrist.deviation()):
        problem, reference = MPCProblem(wrist, horizon=HYBRID_HORIZON), 15.0
        controller, believed = (
            converged_mpc(problem),
            observer.begin(0.0, float(wrist.rest("line1").pressure), wrist),
        )
        before = float(believed.plant.pressure / wrist.regulator.gain)
        best, _ = controller.solve(believed, before, reference, [])
        plan = hybrid.solve(problem, believed, before, reference, "square")
        led.append(best.cost / controller.descend(believed, plan.commands, before, reference).cost)
        bound.append(best.cost / plan.bound)
        missed.append(plan.law.rate_error)
    return {
        "mpc.converged_plan_vs_from_hybrid": max(led),
        "mpc.converged_plan_vs_hybrid_bound": max(bound),
        "mpc.hybrid_law_error_kpa_per_s": max(missed),
    }


def measure(rounds: int, converged: Make = converged_mpc) -> dict[str, float | None]:
    """All figures of `MEANING`."""
    figures: dict[str, float | None] = {}
    for name, make in (("linear", linear.linear_mpc), ("rti", real_time.real_time_mpc)):
        wall = step_times(make)
        figures[f"mpc.{name}_p99_share_of_period"] = wall.p99_share
        figures[f"mpc.{name}_median_share_of_period"] = wall.total.median / wall.period
        figures[f"mpc.{name}_p99_share_of_period_quiet"] = step_times(make, REPEATS).p99_share
    figures |= do_mpc_figures(rounds) | cost_vs_converged(converged) | hybrid_figures()
    return {key: figures[key] for key in MEANING}
