"""The closed loop: plant, controller, sensor, reference profile, disturbance and judge, sampled together.

One law for every loop that is simulated.  Its parts are NamedTuples in the trees of state and coefficients;
a part that is absent, ``()``, is gone when the law is traced, and costs nothing in the compiled code.  What
comes from outside are signals by name (`OutsideSignals`), of which a run has those that it needs: the
time for a plant with effects, the pressure of the other motion, noise; or commands, in place of a
controller, where they are known before (a replay) or decided once a period
(`plants.simulation.periodic`).  Constant loads and dead times are effects of the plant
(`plants.simulation.disturbance`).

The controller sees what the sensor shows; the judge sees the joint.  The two differ where the sensor is not
perfect or the plant has effects that sit in it, such as a drift.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants import dynamics as plant
from plants.dynamics import QUIET, SampledWrist, State
from plants.effects.effect import Around
from plants.equilibrium import holding_command
from plants.kernel import pytrees
from plants.kernel.batches import run_lanes
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import PERFECT, Measured, Sensor

if TYPE_CHECKING:
    from plants.wrist import Wrist

Number = Any
Array = NDArray[np.float64]


class ClosedLoop(NamedTuple):
    """State of plant, controller and judge."""

    plant: State
    controller: Any = ()
    judge: Any = ()


class SampledClosedLoop(NamedTuple):
    """Coefficients of plant and controller, the reference profile, the judge, the sensor."""

    plant: SampledWrist
    controller: Any
    reference: ReferenceProfile
    judge: Any = ()
    sensor: Sensor = PERFECT


class OutsideSignals(NamedTuple):
    """What comes from outside in a sample: its index, its time [s], how far the pressure of the other motion
    is from rest [kPa], noise of standard deviation 1, the command [V] that is given where there is no
    controller, the one that reaches the valve where transport is kept outside the plant, and the reference
    [deg] where it was logged in place of a profile."""

    sample: Number
    time: Number = QUIET.time
    other_pressure: Number = QUIET.other_pressure
    noise: Number = 0.0
    command: Number | None = None
    arriving: Number | None = None
    reference: Number | None = None


def step(s: ClosedLoop, signals: OutsideSignals, c: SampledClosedLoop) -> ClosedLoop:
    """One sample: measure, control, move, judge by the true angle."""
    around = Around(signals.time, signals.other_pressure)
    asked = c.reference.at(signals.sample)
    if signals.reference is not None:
        asked = asked._replace(reference=signals.reference)
    controller, command = s.controller, signals.command
    if command is None:
        seen = c.sensor.shows(plant.read(s.plant, c.plant, around), signals.noise)
        measured = Measured(asked.reference - seen, seen, s.plant.pressure)
        controller, command = c.controller.act(s.controller, measured)
    arriving = command if signals.arriving is None else signals.arriving
    after = plant.step(s.plant, arriving, c.plant, around)
    judge = c.judge.update(s.judge, signals.sample, asked, s.plant, after, command) if c.judge else ()
    return ClosedLoop(after, controller, judge)


@cache
def law(names: tuple[str, ...]) -> Callable[[ClosedLoop, tuple[Number, ...], SampledClosedLoop], ClosedLoop]:
    """The law with its signals in the order of some names of `OutsideSignals`; ``index`` is that of the
    sample in a run that goes on where another ended, for ``sample`` is counted from 0 in every run."""
    fields = ["sample" if n == "index" else n for n in names]

    def closed_loop(s: ClosedLoop, inputs: tuple[Number, ...], c: SampledClosedLoop) -> ClosedLoop:
        return step(s, OutsideSignals(**dict(zip(fields, inputs, strict=True))), c)

    return closed_loop


def advance(
    first: ClosedLoop,
    c: SampledClosedLoop,
    samples: int | NDArray[np.intp],
    shared: dict[str, Array] | None = None,
    own: dict[str, Array] | None = None,
    hold: int = 1,
    every: int = 0,
    record: tuple[str, ...] = (),
    jobs: int | None = None,
) -> tuple[ClosedLoop, Array]:
    """The loop after so many samples, of all lanes or of each, and what was recorded on the way, as
    `plants.kernel.batches.run_lanes`.

    shared, own: signals by their names (`OutsideSignals`), (samples,) of all lanes, and (rows, lanes) of each
    lane's own, a row for every `hold` samples.
    """
    shared, own = shared or {}, own or {}
    names = (*(() if "index" in shared else ("sample",)), *shared, *own)
    found: tuple[ClosedLoop, Array] = run_lanes(
        law(names), first, c, samples, shared, names, every, record, jobs, own, hold
    )
    return found


def clock(wrist: "Wrist", samples: int, begin: float = 0.0) -> dict[str, Array]:
    """The time [s] of each sample as a signal, for a plant with effects; others need none."""
    if not wrist.effects:
        return {}
    return {"time": np.asarray(begin + np.arange(samples) * wrist.rig.sample_time, float)}


def holding(wrist: "Wrist", controller: Any, state: State, begin: float = 0.0) -> Any:
    """The state of a controller that holds the wrist still at the pressure of `state`, at a time [s]."""
    seen = plant.read(state, wrist.sampled(), Around(begin))
    measured = Measured(0.0, seen, state.pressure)
    return controller.holding(holding_command(wrist, state.pressure) * controller.gain, measured)


@dataclass(frozen=True)
class Trajectory:
    """Signals of closed loops, shape (samples, lanes): time [s] (samples,), angle of the joint
    and static angle [deg], pressure [kPa], command [V], and what the sensor shows [deg] but for its noise
    and its quantum."""

    time: Array
    angle: Array
    static_angle: Array
    pressure: Array
    command: Array
    measured: Array


def recorded(of: ClosedLoop) -> tuple[str, ...]:
    """Names of what is recorded in every sample for a trajectory, of a loop with a judge."""
    names = pytrees.names(of)
    return (*(n for n in names if n.startswith("plant.")), "judge.command")


def trajectory(rows: Array, like: State, c: SampledWrist, dt: float, begin: float = 0.0) -> Trajectory:
    """The trajectory of which `recorded` signals are the rows, (signals, samples, lanes), `dt` [s]
    apart, from a time [s]."""
    # The command of a row is given after its measurement: it stands in the row after.
    given = np.concatenate([rows[-1, 1:], rows[-1, -1:]])
    time = np.asarray(np.arange(rows.shape[1]) * dt, float)
    went = pytrees.like(like, rows[:-1])
    seen = plant.read(went, c, Around(begin + time[:, None]))
    return Trajectory(time, went.angle, went.memory.h, went.pressure, given, seen)
