"""Oscillations as the simulator has them: what confirms or refutes a predicted limit cycle.

Lanes start on a predicted cycle and on cycles smaller and larger than it.  One that attracts is seen at
the end of the run; one that repels is closed in between the largest start that dies down and the
smallest that grows.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.evaluation.runner import play, step_from
from design.evaluation.steps import holding
from plants.equilibrium import at_pressure
from plants.kernel import pytrees as tree
from plants.wrist import State, Wrist

Array = NDArray[np.float64]
PER_PERIOD = 200
"""Samples recorded in a period: a peak between two is missed by 0.02 % at the most."""

STILL = 1e-3
"""Amplitude of pressure [kPa] below which a swing counts as gone."""

SUSTAINED = 0.9
"""Share of its amplitude that a swing keeps from one fifth of a run to the next if it persists."""


@dataclass(frozen=True)
class Swing:
    """Oscillations of lanes within a window: amplitude (half of peak to peak) of the pressure [kPa] and
    of the angle [deg], frequency [rad/s], NaN where the pressure does not come round twice; (lanes,)."""

    kPa: Array
    deg: Array
    frequency: Array


@dataclass(frozen=True)
class Swings:
    """What became of large swings within the command range: how many lanes, for how long [s], how many
    still swing at the end, and the largest of these; 0 where there is none."""

    lanes: int
    duration: float
    persisting: int
    amplitude_kPa: float
    amplitude_deg: float
    frequency_rad_s: float


@dataclass(frozen=True)
class Rollout:
    """Time [s] (rows,), pressure [kPa] and angle [deg], each (rows, lanes)."""

    time: Array
    pressure: Array
    angle: Array

    def swing(self, begin: float, end: float) -> Swing:
        """The oscillations between two times [s]."""
        rows = (self.time >= begin) & (self.time <= end)
        P, y = self.pressure[rows], self.angle[rows]
        return Swing(
            0.5 * np.ptp(P, axis=0), 0.5 * np.ptp(y, axis=0),
            np.array([_frequency(self.time[rows], lane) for lane in P.T], float),
        )  # fmt: skip


def _frequency(time: Array, signal: Array) -> float:
    """Frequency [rad/s] from the upward crossings of the middle; NaN for fewer than two."""
    s = signal - 0.5 * (signal.max() + signal.min())
    up = np.flatnonzero((s[:-1] < 0.0) & (s[1:] >= 0.0))
    if len(up) < 2:
        return float("nan")
    at = time[up] + (time[up + 1] - time[up]) * s[up] / (s[up] - s[up + 1])
    return float(2.0 * np.pi * (len(at) - 1) / (at[-1] - at[0]))


def rollout(
    wrist: Wrist, controller: PI, reference: float, state: State, held: Any, duration: float, every: int
) -> Rollout:
    """The loop of `design.evaluation.steps` from given states, for a duration [s].

    Every `every`-th sample is recorded.
    """
    lanes = step_from(wrist, state, reference, duration)
    rows = play(lanes, controller, held, False, ("plant.pressure", "plant.angle"), every, jobs=1).rows
    time = np.asarray(np.arange(rows.shape[1]) * (every * wrist.rig.sample_time), float)
    return Rollout(time, rows[0], rows[1])


def on_orbit(
    wrist: Wrist,
    controller: PI,
    centre: float,
    static: Array,
    mean: Array,
    swing: NDArray[np.complex128],
    z: Any,
) -> tuple[State, Any]:
    """States of lanes, of plant and controller, as the pressure of an oscillation rises through its centre
    [kPa].

    static: angle of the loop; mean of the angle [deg] and its swing about it, whose imaginary part it is and
    which one sample multiplies by z, each (lanes,).  Effects are at rest there: what is under way in a tube
    is not known.
    """
    hold = holding(wrist, controller, wrist.rest()._replace(pressure=centre, angle=np.asarray(mean)))
    angle = np.asarray(mean + swing.imag, float)
    lanes = [
        tree.leaves(
            State(
                centre, wrist.rest().memory._replace(h=h, virgin=0.0), y,
                tuple(e.rest(wrist, centre, h) for e in wrist.effects),
            )
        )
        for h, y in zip(static, angle, strict=True)
    ]  # fmt: skip
    state = tree.like(wrist.rest(), list(np.array(lanes, float).T))
    return state, controller.swinging(hold, swing, z, wrist.rig.sample_time)


def large_swings(wrist: Wrist, controller: PI, reference: float = 0.0, duration: float = 120.0) -> Swings:
    """What is left after a duration [s] of swings from far off: pressures over nine tenths of the range, on
    both lines, with the integrator holding them and with it far on the other side."""
    low, high = wrist.reach
    starts: list[Any] = []
    held: list[Any] = []
    for share in (0.05, 0.25, 0.75, 0.95):
        for line in ("line1", "line2"):
            state = at_pressure(wrist, line, float(low + share * (high - low)))
            here = holding(wrist, controller, state)
            starts += [tree.leaves(state)] * 2
            held += [tree.leaves(h) for h in (here, here._replace(integral=-here.integral))]
    state = tree.like(wrist.rest(), list(np.array(starts, float).T))
    begin = tree.like(here, list(np.array(held, float).T))
    went = rollout(wrist, controller, reference, state, begin, duration, every=5)
    before, last = went.swing(0.6 * duration, 0.8 * duration), went.swing(0.8 * duration, duration)
    lasts = (last.kPa > STILL) & (last.kPa > SUSTAINED * before.kPa) & np.isfinite(last.frequency)
    if not lasts.any():
        return Swings(len(held), duration, 0, 0.0, 0.0, 0.0)
    top = int(np.argmax(np.where(lasts, last.kPa, 0.0)))
    return Swings(
        len(held), duration, int(lasts.sum()), float(last.kPa[top]), float(last.deg[top]),
        float(last.frequency[top]),
    )  # fmt: skip
