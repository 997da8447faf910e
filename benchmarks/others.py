"""The same closed loop in python-control and do-mpc, one rollout at a time, as both are made for.

Neither judges the response; ours does while it simulates.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.rollouts import DURATION, SAMPLES, TOLERANCE, Case, Disagreement, case
from benchmarks.timing import duel
from design.controllers import pi
from design.controllers.pi import PIState
from design.evaluation.steps import run
from plants import dynamics as plant
from plants.kernel import pytrees as tree
from plants.simulation.closed_loop import ClosedLoop, SampledClosedLoop
from plants.wrist import SAMPLE_TIME, State

Array = NDArray[np.float64]
LANES = 1024
"""Rollouts of our batch, two threads; the others do one lane of it."""

LANE = 0
DO_MPC_SAMPLES = 1000
"""Samples that do-mpc runs; its time is scaled to the whole rollout."""


def plain_update(c: SampledClosedLoop) -> Callable[..., list[float]]:
    """Closed loop in plain Python floats: (pressure, h, virgin, angle, integral), one sample later.

    Our own laws would do, but NumPy's ufuncs on single numbers are several times slower.
    """
    r, p, k = c.plant.regulator, c.plant, c.controller

    def update(t: float, x: Array, u: Array, params: dict[str, Any]) -> list[float]:
        pressure, h, virgin, angle, integral = x.tolist()
        error = float(u[0]) - angle
        wanted = (k.rest_pressure + k.Kp * error + integral) * k.volts_per_kPa
        command = min(max(wanted, k.low), k.high)
        if (wanted - command) * error <= 0.0:
            integral += k.Ki_dt * error

        e = r.gain * command - pressure
        w = e * e / (e * e + r.e0_squared)
        rate = r.alpha_slow + w * (r.alpha_rise - (1.0 - w) * r.z_rise * (r.z_centre + w * r.z_rise))
        after = pressure + rate * e
        inside = h + p.s * (1.0 - virgin) * (after - pressure)
        line1, line2 = p.a1 * (after - p.rest_pressure) - p.w1, p.a2 * (after - p.rest_pressure) + p.w2
        moved = min(max(inside, line1), line2)
        angle = p.lag.keep * angle + p.lag.before * h + p.lag.after * moved
        return [after, moved, virgin if moved == inside else 0.0, angle, integral]

    return update


def by_python_control(c: SampledClosedLoop, start: list[float]) -> Callable[[], Array]:
    """A rollout by ``control.input_output_response``; returns the angle at every sample."""
    import control

    system = control.nlsys(plain_update(c), None, inputs=1, states=5, outputs=5, dt=SAMPLE_TIME)
    time = np.arange(SAMPLES) * SAMPLE_TIME
    reference = np.full(SAMPLES, c.reference.references[0])

    def work() -> Array:
        return np.asarray(control.input_output_response(system, time, reference, start).states[3])

    return work


def by_do_mpc(c: SampledClosedLoop, s: ClosedLoop) -> Callable[[], Array]:
    """A shorter rollout by do-mpc's simulator, PI and plant one discrete model; returns the angles."""
    import casadi

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # do-mpc tells which of its optional parts are missing
        import do_mpc

    casadi.GlobalOptions.setNumpyMode(1)  # our laws on symbols, as in plants.kernel.graphs
    like: tuple[State, PIState] = (s.plant, s.controller)
    model = do_mpc.model.Model("discrete", "SX")
    names = [n.replace(".", "_") for n in ("pressure", "h", "virgin", "angle", "integral")]
    symbols = tree.like(like, [model.set_variable("_x", n) for n in names])
    error = model.set_variable("_u", "reference") - symbols[0].angle
    controller, command = pi.step(symbols[1], error, c.controller)
    after = tree.leaves((plant.step(symbols[0], command, c.plant), controller))
    for name, value in zip(names, after, strict=True):
        model.set_rhs(name, casadi.vertcat(value))  # out of NumPy mode
    model.setup()
    simulator = do_mpc.simulator.Simulator(model)
    simulator.set_param(t_step=SAMPLE_TIME)
    simulator.setup()
    reference = np.array([[c.reference.references[0]]])

    def work() -> Array:
        simulator.reset_history()
        simulator.x0 = np.array(tree.leaves(like), float)
        return np.array([simulator.make_step(reference)[3, 0] for _ in range(DO_MPC_SAMPLES)])

    return work


def single(batch: Case) -> tuple[SampledClosedLoop, ClosedLoop, Array]:
    """Coefficients, first state and, by us, the angle before every sample: all of one lane."""
    c, s = (
        tree.like(t, [float(np.broadcast_to(x, LANES)[LANE]) for x in tree.leaves(t)]) for t in batch.trees()
    )
    lane = {n: float(np.broadcast_to(v, LANES)[LANE]) for n, v in batch.wrist.values.items()}
    gains = pi.PI(float(batch.controller.Kp[LANE]), float(batch.controller.Ki[LANE]))
    wrist = plant.Wrist.from_values(lane)
    _, _, signals = run(wrist, gains, c.reference.references[0], duration=DURATION, record=True)
    assert signals is not None
    return c, s, signals.angle[:, 0]


def require_same(who: str, angle: Array, ours: Array) -> None:
    """Raises Disagreement where two angles [deg] differ by more than `TOLERANCE`."""
    difference = float(np.max(np.abs(angle - ours)))
    if not difference <= TOLERANCE:
        raise Disagreement(f"{who} and ours do not compute the same: angles differ by {difference:.3g} deg")


def measure(rounds: int) -> dict[str, float | None]:
    """Figures of python-control and of do-mpc (None where that is not installed)."""
    batch = case(LANES)
    c, s, angle = single(batch)
    figures: dict[str, float | None] = {}

    by_control = by_python_control(c, tree.leaves((s.plant, s.controller)))
    require_same("python-control", by_control(), angle[:SAMPLES])
    result = duel(by_control, lambda: batch.ours(jobs=2), rounds)
    figures["rollouts.python_control_ms"] = result.first * 1e3
    figures["rollouts.vs_python_control"] = result.ratio * LANES

    try:
        short = by_do_mpc(c, s)
    except ModuleNotFoundError:
        return {**figures, "rollouts.do_mpc_ms": None, "rollouts.vs_do_mpc": None}
    require_same("do-mpc", short(), angle[1 : DO_MPC_SAMPLES + 1])
    result = duel(short, lambda: batch.ours(jobs=2), rounds)
    scale = SAMPLES / DO_MPC_SAMPLES
    figures["rollouts.do_mpc_ms"] = result.first * scale * 1e3
    figures["rollouts.vs_do_mpc"] = result.ratio * scale * LANES
    return figures
