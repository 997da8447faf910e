"""A rig: declared parameters, hidden effects and noise, and what it does in open or closed loop."""

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from tests.rig.core import SUBSTEPS, TICK, Controller, Outside, integrate
from tests.rig.effects import Hidden
from tests.rig.parameters import Declared
from tests.rig.signals import Signal, bursts, noise, other_pressure, slips


@dataclass(frozen=True)
class Noise:
    """Spread of the sensors' noise [deg, kPa] and its correlation time [s], 0 where it is white."""

    angle_deg: float
    pressure_kPa: float
    correlation_s: float = 0.0


def draw_noise(rng: np.random.Generator, correlation_s: float = 0.0) -> Noise:
    """Noise as loud as the practice data's."""
    return Noise(float(rng.uniform(0.04, 0.09)), float(rng.uniform(0.19, 0.34)), correlation_s)


class Run(NamedTuple):
    """Signals at 1 kHz; each value is of before the command of its tick acts.

    time [s], command [V], reference [deg], pressure and other_pressure [kPa] without noise, angle [deg]
    of the joint, measured [deg] by the sensor: with drift, hum, noise.
    """

    time: Signal
    command: Signal
    reference: Signal
    pressure: Signal
    other_pressure: Signal
    angle: Signal
    measured: Signal


class LoopResult(NamedTuple):
    """A closed-loop step, judged on the true angle.

    iae [deg s], overshoot and settling relative to the reference; settling [s] into 5 % for the rest of
    the run (inf if never, or if it oscillates); oscillates: three swings of 5 % or more in the second half
    of the run.
    """

    run: Run
    iae: float
    overshoot: float
    settling: float
    oscillates: bool


@dataclass(frozen=True)
class Bench(ABC):
    """What all rigs have: the motion, names of what they hide, noise, and the seed of all that is random."""

    axis: str
    effects: tuple[str, ...]
    noise: Noise
    seed: int

    def play(self, command: Signal, salt: int, substeps: int = SUBSTEPS) -> Run:
        """Answer to commands [V] at 1 kHz in open loop; salt tells the recordings' random streams apart."""
        return self._run(command, np.zeros(len(command)), None, True, salt, substeps)

    def follow(self, reference: Signal, controller: Controller, salt: int, noisy: bool = True) -> Run:
        """Closed loop with a PI controller along a reference [deg] at 1 kHz.

        The controller sees what the sensor shows, without its noise unless `noisy`.
        """
        return self._run(np.zeros(len(reference)), reference, controller, noisy, salt, SUBSTEPS)

    def _run(
        self,
        command: Signal,
        reference: Signal,
        controller: Controller | None,
        noisy: bool,
        salt: int,
        substeps: int,
    ) -> Run:
        count = len(command)
        time = np.arange(count) * TICK
        streams = [np.random.default_rng([self.seed, salt, i]) for i in range(5)]
        other = other_pressure(time, streams[0])
        joint, sensor, loudness = self._disturbances(count, streams)
        angle_noise = noise(self.noise.angle_deg, count, self.noise.correlation_s, TICK, streams[3])
        outside = Outside(command, reference, other, joint, sensor, angle_noise * loudness)
        columns = self._columns(controller is not None, noisy, controller or Controller(), outside, substeps)
        return Run(time, columns[:, 0], reference, columns[:, 1], other, columns[:, 2], columns[:, 3])

    def closed_loop(
        self,
        Kp: float,
        Ki: float,
        reference: float = 15.0,
        duration: float = 10.0,
        gain: float = 49.4,
        rest_pressure: float = 100.0,
        low: float = 0.0,
        high: float = 4.0,
        salt: int = 99,
    ) -> LoopResult:
        """A step of the reference [deg] at time zero under PI control at 1 kHz, on this very rig."""
        controller = Controller(Kp, Ki, gain, rest_pressure, low, high)
        run = self.follow(np.full(round(duration / TICK), reference), controller, salt)
        return judged(run, reference)

    def _disturbances(self, count: int, streams: list[np.random.Generator]) -> tuple[Signal, Signal, Signal]:
        """At the joint and at the sensor [deg], and what the noise is multiplied with; at 1 kHz."""
        return np.zeros(count), np.zeros(count), np.ones(count)

    @abstractmethod
    def _columns(
        self, closed: bool, noisy: bool, controller: Controller, outside: Outside, substeps: int
    ) -> Signal:
        """Command, pressure, true angle, measured angle at every tick."""

    @property
    def common(self) -> dict[str, Any]:
        """What is told of every rig, as plain values."""
        return {
            "axis": self.axis,
            "seed": self.seed,
            "effects": list(self.effects),
            "noise": asdict(self.noise),
        }


@dataclass(frozen=True)
class Rig(Bench):
    """A rig with the declared physics and the parameters of its hidden effects."""

    declared: Declared
    hidden: Hidden

    def _disturbances(self, count: int, streams: list[np.random.Generator]) -> tuple[Signal, Signal, Signal]:
        strange = self.hidden.open
        wander = np.cumsum(streams[2].normal(0.0, strange.wander.per_root_s * TICK**0.5, count))
        return (
            slips(*strange.slips, count, streams[1]),
            wander,
            bursts(*strange.burst_noise, count, streams[4]),
        )

    def _columns(
        self, closed: bool, noisy: bool, controller: Controller, outside: Outside, substeps: int
    ) -> Signal:
        columns: Signal = integrate(self.declared, self.hidden, closed, noisy, controller, outside, substeps)
        return columns

    @property
    def truth(self) -> dict[str, Any]:
        """What the rig hides, as plain numbers: only effects that are there."""
        present = {
            name: parameters._asdict()
            for name, parameters in [*self.hidden._asdict().items(), *self.hidden.open._asdict().items()]
            if name != "open" and parameters != type(parameters)()
        }
        return self.common | {"declared": self.declared._asdict(), "hidden": present}


def judged(run: Run, reference: float) -> LoopResult:
    """Metrics of a step from rest to a constant reference [deg]."""
    error = reference - run.angle
    outside = np.flatnonzero(np.abs(error) > 0.05 * abs(reference))
    settled = int(outside[-1]) + 1 if len(outside) > 0 else 0
    oscillates = swings(run.angle[len(error) // 2 :], 0.05 * abs(reference)) >= 3
    return LoopResult(
        run,
        iae=float(np.abs(error).sum() * TICK),
        overshoot=max(0.0, float((-error * np.sign(reference)).max()) / abs(reference)),
        settling=float("inf") if oscillates or settled == len(error) else float(run.time[settled]),
        oscillates=oscillates,
    )


def swings(angle: Signal, least: float) -> int:
    """How often the angle turns round after moving by at least `least` [deg] the other way."""
    count, extreme, direction = 0, float(angle[0]), 0.0
    low = high = extreme
    for value in angle[::10]:
        if direction == 0.0:
            low, high = min(low, value), max(high, value)
            if high - low >= least:
                direction = 1.0 if value == high else -1.0
                extreme = value
        elif (value - extreme) * direction >= 0.0:
            extreme = value
        elif (extreme - value) * direction >= least:
            count, extreme, direction = count + 1, value, -direction
    return count
