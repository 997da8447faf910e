"""What every model predictive controller here minimises, and under which bounds: one definition for all.

At the start of each period of `period` [s] the command v is chosen and then held.  With e_k = y_k - r the
error [deg] at the end of period k and v_0 the command of the period before, minimise

    sum_{k=1}^{N} q_k e_k^2 + swing sum_{k=2}^{N} (e_k - e_{k-1})^2 + move sum_{k=1}^{N} (v_k - v_{k-1})^2

with q_k = angle, q_N = terminal, subject to

    low <= v_k <= high and |v_k - v_{k-1}| <= rate,

the model being the exact sampled wrist
(`plants.dynamics.step`, 20 substeps of 1 ms in a period of 20 ms) with two constant disturbances that an
observer estimates: `lack` [kPa], added to the commanded pressure, and `shift` [deg], added to the
static angle.  Rawlings, Mayne & Diehl, Model Predictive Control (2017), chapter 1.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import remembers
from design.controllers.measurement.plausible import SensorLimits
from plants.errors import InputError
from plants.hysteresis import HysteresisLaw
from plants.kernel import pytrees
from plants.wrist import COMMAND_RANGE, State, Wrist

Array = NDArray[np.float64]

LONGEST_HORIZON = 200
"""Periods; a dense problem of more than that is a mistake rather than a wish."""


@dataclass(frozen=True)
class MPCWeights:
    """Weights of the cost: angle [1/deg^2], move [1/V^2] (of the change of the command from one period to
    the next), terminal [1/deg^2] (in place of `angle` at the last stage), swing [1/deg^2] (of the change
    of the angle from one period to the next: squared errors alone would have the angle shoot past
    the reference, out of the settling band, for the sake of some ms of rise).  Raises InputError for a
    weight that is negative or not finite, and for a move weight of 0, which leaves the problem without
    a unique answer where the angle does not move (the virgin curve)."""

    angle: float = 1.0
    move: float = 0.05
    terminal: float = 10.0
    swing: float = 3.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(
                    f"weight {name} of the MPC is {value}: give a finite number that is not negative"
                )
        if self.move <= 0.0:
            raise InputError("weight move of the MPC is 0: give a positive number, such as 0.05 per V^2")
        if self.angle + self.terminal <= 0.0:
            raise InputError("weights angle and terminal of the MPC are both 0: nothing is asked for")


@dataclass(frozen=True)
class Observer:
    """Speeds of the observer, as in `design.mpc.observer`: bandwidth [rad/s] of the shift's estimate,
    and share of what the pressure misses that goes into `lack` in one period (0 to 1).  Raises InputError
    for others."""

    bandwidth: float = 20.0
    lack: float = 0.2

    def __post_init__(self) -> None:
        if not (np.isfinite(self.bandwidth) and self.bandwidth > 0.0):
            raise InputError(
                f"observer bandwidth of the MPC is {self.bandwidth} rad/s: give a positive number"
            )
        if not 0.0 <= self.lack <= 1.0:
            raise InputError(f"observer share for the lack of pressure is {self.lack}: give one from 0 to 1")


@dataclass(frozen=True)
class MPCProblem:
    """Model, horizon, weights and bounds; see the module.

    wrist: the declared wrist that is believed in, without effects; period [s], a multiple of the
    sample time; horizon in periods; low, high [V]; rate [V per period]; observer: how fast the
    disturbances are believed; sensors: what they can show, those of the wrist's rig where not given; delay:
    periods by which the model takes commands to arrive late.
    Raises InputError with one line for what makes no sense.

    >>> problem = MPCProblem(Wrist.flexion())
    >>> problem.substeps, problem.horizon
    (20, 30)
    >>> MPCProblem(Wrist.flexion(), period=0.0205)
    Traceback (most recent call last):
    plants.errors.InputError: MPC period of 0.0205 s: give a multiple of the sample time, 0.001 s
    """

    wrist: Wrist
    period: float = 0.02
    horizon: int = 30
    weights: MPCWeights = field(default_factory=MPCWeights)
    observer: Observer = field(default_factory=Observer)
    low: float = COMMAND_RANGE[0]
    high: float = COMMAND_RANGE[1]
    rate: float = 2.0
    sensors: SensorLimits | None = None
    delay: int = 0

    def __post_init__(self) -> None:
        dt = self.wrist.rig.sample_time
        steps = self.period / dt
        if not (np.isfinite(steps) and steps >= 1.0 - 1e-9 and abs(steps - round(steps)) < 1e-6):
            raise InputError(f"MPC period of {self.period:g} s: give a multiple of the sample time, {dt:g} s")
        if isinstance(self.horizon, bool) or int(self.horizon) != self.horizon:
            raise InputError(f"MPC horizon of {self.horizon}: give a whole number of periods")
        if not 2 <= self.horizon <= LONGEST_HORIZON:
            raise InputError(f"MPC horizon of {self.horizon} periods: give one from 2 to {LONGEST_HORIZON}")
        if isinstance(self.delay, bool) or int(self.delay) != self.delay or self.delay < 0:
            raise InputError(f"MPC delay of {self.delay}: give a whole number of periods, 0 or more")
        if not self.rate > 0.0:
            raise InputError(f"rate limit of {self.rate:g} V per period: give a positive number")
        if not self.low < self.high:
            raise InputError(f"command range from {self.low:g} to {self.high:g} V: give low below high")
        if self.wrist.effects:
            names = ", ".join(e.NAME for e in self.wrist.effects)
            raise InputError(f"the MPC's model is the declared wrist: leave out its effects ({names})")
        if any(np.ndim(v) for v in self.wrist.values.values()):
            raise InputError("the MPC plans for one wrist at a time: give parameters that are numbers")

    @property
    def loop(self) -> HysteresisLaw:
        """The hysteresis that is believed in."""
        return self.wrist.hysteresis

    @cached_property
    def plausible(self) -> SensorLimits:
        """What the sensors can show; what is beyond takes no part."""
        return SensorLimits.of(self.wrist) if self.sensors is None else self.sensors

    @cached_property
    def shape(self) -> HysteresisLaw:
        """The same law with parameters of no meaning: plants whose law has this shape share their kernels."""
        return pytrees.like(self.loop, [1.0] * len(pytrees.leaves(self.loop)))  # type: ignore[no-any-return]

    @property
    def substeps(self) -> int:
        """Samples in a period."""
        return round(self.period / self.wrist.rig.sample_time)

    @property
    def stage_weights(self) -> Array:
        """Weight of the squared error of each stage [1/deg^2], shape (horizon,)."""
        q = np.full(self.horizon, float(self.weights.angle))
        q[-1] = self.weights.terminal
        return q

    @property
    def angle_hessian(self) -> Array:
        """Half the second derivative of the cost by the angles [1/deg^2], (horizon, horizon)."""
        D = np.diff(np.eye(self.horizon), axis=0)
        return np.asarray(np.diag(self.stage_weights) + self.weights.swing * (D.T @ D), float)

    @property
    def move_hessian(self) -> Array:
        """Half the second derivative of the move suppression by the commands [1/V^2], (horizon, horizon)."""
        D = np.eye(self.horizon) - np.eye(self.horizon, k=-1)
        return np.asarray(self.weights.move * (D.T @ D), float)

    def cost(self, angles: Any, commands: Any, before: float, reference: float) -> float:
        """The cost of a plan: angles [deg] at the ends of the periods and commands [V], both (horizon,)."""
        errors = np.asarray(angles, float) - reference
        moves = np.diff(np.asarray(commands, float), prepend=before)
        swings = self.weights.swing * np.sum(np.diff(errors) ** 2)
        return float(self.stage_weights @ errors**2 + swings + self.weights.move * np.sum(moves**2))

    def bounds(self, before: float) -> tuple[Array, Array]:
        """Lower and upper bounds [V] of (commands, their changes), shape (2 horizon,), for a command
        before; of the first change, the bound holds the first command itself."""
        low = np.concatenate([np.full(self.horizon, self.low), np.full(self.horizon, -self.rate)])
        high = np.concatenate([np.full(self.horizon, self.high), np.full(self.horizon, self.rate)])
        low[self.horizon] += before
        high[self.horizon] += before
        return low, high

    @property
    def differences(self) -> Array:
        """The matrix whose product with the commands is bounded beside them: the changes, the first
        being the first command itself; (horizon, horizon)."""
        return np.eye(self.horizon) - np.eye(self.horizon, k=-1)


@remembers(
    lack=("kPa", "what the regulator lacks of the pressure that is commanded"),
    shift=("deg", "shift of the angle, such as by a load"),
)
class Believed(NamedTuple):
    """What a plan starts from: the wrist's state, the angle being that without the shift, and the
    disturbances lack [kPa] and shift [deg]."""

    plant: State
    lack: float
    shift: float


PERIOD = 0.02
"""Period of an MPC [s], or the nearest multiple of the rig's sample time."""

RATE = 0.5
"""Largest change of the command in a period, as a share of its range."""


def _for_rig(wrist: Wrist, **settings: Any) -> MPCProblem:
    """A problem with the range and the sample time of the wrist's rig."""
    (low, high), dt = wrist.rig.command_range, wrist.rig.sample_time
    period = max(1, round(PERIOD / dt)) * dt
    of_rig = {"period": period, "low": low, "high": high, "rate": RATE * (high - low)}
    return MPCProblem(wrist, **{**of_rig, **settings})


def nominal(wrist: Wrist, **changes: Any) -> MPCProblem:
    """The fast setting, for a plant without model error."""
    return replace(_for_rig(wrist), **changes)


def robust(wrist: Wrist, **changes: Any) -> MPCProblem:
    """The setting that stays stable with 60 ms of dead time that the model lacks.

    Moves and swings keep the dead time: with these weights the limits of the whole requirement hold on the
    example campaigns (`design.robustness.tuning.robust_mpc` searches that of the swing; 30 overshoots by
    26 % there, 300 can stand still on a branch).  The observer is slow enough for the noise of the sensor,
    of which a bandwidth of 60 rad/s makes 18 V of total variation.  The slower `lack` is what the dead time
    would disturb.
    """
    slow = _for_rig(
        wrist,
        weights=MPCWeights(move=100.0, terminal=1.0, swing=100.0),
        observer=Observer(bandwidth=20.0, lack=0.1),
    )
    return replace(slow, **changes)


def weighted(problem: MPCProblem, swing: float, move: float, delay: float = 0.0) -> MPCProblem:
    """A problem with other weights of changes of the angle [1/deg^2] and of the command [1/V^2], and a dead
    time of so many periods in its model: what `design.robustness.tuning.robust_mpc` tunes.

    >>> weighted(robust(Wrist.flexion()), 25.0, 50.0, 2.0).delay
    2

    Raises InputError as `MPCProblem`.
    """
    weights = replace(problem.weights, swing=swing, move=move)
    late: Any = int(delay) if float(delay).is_integer() else delay  # which the problem refuses
    return replace(problem, weights=weights, delay=late)
