"""Soft actuators on cheap hardware, as a real logger sees them: rigs that no parameter file describes.

Each is a chain of its own, of nobody's library: a valve whose rate depends on the pressure and on the
direction, transport delay, several plays, a curved and saturating joint, slow creep.  The logger renews the
pressure less often than it writes rows, counts in steps, lets the angle rest at zero, and is offset anew in
each recording.  One, a wrist of muscles, sticks and slips as well; a finger has no regulator.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from tests.rig.core import Controller
from tests.rig.signals import Signal
from tests.rig.soft.chain import NONE, REGULATED, TICK, Loop, Relays, Switched, run_chain


@dataclass(frozen=True)
class Logger:
    """What is written: row time [s] and its jitter [s], renewal of the pressure [s] (0: every row), steps of
    angle [deg] and pressure [kPa], noise of both, largest offset of the angle in a recording [deg], whether
    the angle cannot go below zero, delay of the angle channel [s], how many rows are written twice, and as
    many in the wrong order."""

    row: float
    jitter: float = 0.0
    renewal: float = 0.0
    angle_step: float = 0.01
    pressure_step: float = 0.01
    angle_noise: float = 0.02
    pressure_noise: float = 0.1
    offset: float = 0.0
    rests: bool = False
    angle_delay: float = 0.0
    slips: int = 0


@dataclass(frozen=True)
class SoftRig:
    """A chain from command (own unit) to angle [deg].

    low, high: command range; gain, bias [kPa]; delay [s]; fill, exhaust [1/s] at 0 kPa and how they fall
    with the pressure (per 100 kPa); thresholds [kPa] and weights [deg/kPa] of the plays; cubic: share by
    which the joint stiffens at `full` deg; first: angle below which it does not move [deg]; creep: share and
    time constant [s]; lag [s]; tail: share of the pressure that follows late and its time constant [s];
    stick: distance [deg] from its equilibrium at which the joint breaks away, and at which it rests again;
    relays: in place of the plays, where there are any; swing: natural frequency [Hz] and damping ratio of the
    joint, in place of the lag where the former is not 0; valves: in place of the regulator,
    gain then that of a line along what they make of the command.
    """

    name: str
    low: float
    high: float
    gain: float
    bias: float
    delay: float
    fill: float
    exhaust: float
    falls: float
    thresholds: tuple[float, ...]
    weights: tuple[float, ...]
    origin: float
    cubic: float
    full: float
    first: float
    creep: tuple[float, float]
    lag: float
    logger: Logger
    commands: dict[str, Callable[[], Signal]] = field(default_factory=dict)
    tail: tuple[float, float] = (0.0, 1.0)
    stick: tuple[float, float] = (0.0, 0.0)
    relays: Relays = NONE
    swing: tuple[float, float] = (0.0, 0.0)
    valves: Switched = REGULATED

    def play(self, command: Signal) -> tuple[Signal, Signal]:
        """Pressure [kPa] and angle [deg] at every ms of a command at 1 kHz."""
        late = round(self.delay / TICK)
        delayed = np.concatenate([np.full(late, command[0]), command])[: len(command)]
        return self._run(delayed, Loop(Controller(), 1, 0.0, np.empty(0), 0))

    def follow(
        self, reference: Signal, controller: Controller, period: float, zero: float, late: float = 0.0
    ) -> Signal:
        """Angle [deg] at every ms under a PI that acts once a period [s]; reference and angle count from
        a zero [deg] of the sensor; late: dead time [s] beside the rig's own."""
        ticks = round(period / TICK)
        own = controller._replace(Ki=controller.Ki * ticks, Tf=controller.Tf / ticks)
        command = np.full(len(reference), self.low)
        delay = round((self.delay + late) / TICK)
        return self._run(command, Loop(own, ticks, zero, reference, delay))[1] - zero

    def _run(self, command: Signal, loop: Loop) -> tuple[Signal, Signal]:
        return run_chain(
            command, loop, self.gain, self.bias, self.fill, self.exhaust, self.falls,
            np.array(self.thresholds), np.array(self.weights), self.origin, self.cubic, self.full, self.first,
            *self.creep, self.lag, *self.tail, *self.stick, self.relays, *self.swing,
            self.valves, self.low, self.high,
        )  # fmt: skip

    def log(self, command: Signal, seed: int) -> pd.DataFrame:
        """The rows of a recording."""
        rng, kept = np.random.default_rng(seed), self.logger
        pressure, angle = self.play(command)
        every = kept.row / TICK
        at = np.arange(0.0, len(command) - 1, every)
        at = at + np.concatenate([[0.0], rng.uniform(-0.5, 0.5, len(at) - 1) * kept.jitter / TICK])
        rows = np.clip(np.rint(at).astype(int), 0, len(command) - 1)
        seen = np.maximum(rows - round(kept.angle_delay / TICK), 0)
        measured = (
            angle[seen] + rng.normal(0.0, kept.angle_noise, len(rows)) + rng.uniform(-1, 1) * kept.offset
        )
        if kept.rests:
            measured = np.maximum(measured, 0.0)
        fresh = pressure + rng.normal(0.0, kept.pressure_noise, len(pressure))
        if kept.renewal > 0.0:
            period = round(kept.renewal / TICK)
            fresh = fresh[(np.arange(len(fresh)) // period) * period]
        order = np.arange(len(rows))
        at = 10 * np.arange(1, kept.slips + 1)
        order[at], order[at + 1] = order[at + 1], order[at]
        order = np.insert(order, at + 5, order[at + 5])
        return pd.DataFrame(
            {
                "time_s": np.round(rows * TICK, 4),
                "command_V": np.round(command[rows], 4),
                "pressure_kPa": np.round(np.round(fresh[rows] / kept.pressure_step) * kept.pressure_step, 5),
                "angle_deg": np.round(np.round(measured / kept.angle_step) * kept.angle_step, 5),
            }
        ).iloc[order]

    def write(self, folder: Path, fit: Sequence[str], validate: Sequence[str]) -> None:
        """A campaign of the recordings named."""
        folder.mkdir(parents=True, exist_ok=True)
        for i, name in enumerate((*fit, *validate)):
            table = self.log(self.commands[name](), 100 + i)
            table.to_csv(folder / f"{name}.csv", index=False, lineterminator="\n")
        lists = [", ".join(f'"{n}.csv"' for n in names) for names in (fit, validate)]
        (folder / "campaign.toml").write_text(
            f'axis = "{self.name}"\nstart = "unknown"\nsample_time_s = {self.logger.row:.5g}\n'
            f"fit = [{lists[0]}]\nvalidate = [{lists[1]}]\n"
        )
