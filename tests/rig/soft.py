"""Soft actuators on cheap hardware, as a real logger sees them: rigs that no parameter file describes.

Each is a chain of its own, of nobody's library: a valve whose rate depends on the pressure and on the
direction, transport delay, several plays, a curved and saturating joint, slow creep.  The logger renews the
pressure less often than it writes rows, counts in steps, lets the angle rest at zero, and is offset anew in
each recording.  One, a wrist of muscles, sticks and slips as well.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit

from tests.rig.core import Controller, pi_command
from tests.rig.signals import Signal

TICK = 0.001


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


class Switched(NamedTuple):
    """On/off valves without a regulator: each period [s] the one to a supply is open for as large a share as
    the command is of its range, then the one to the outside.

    most [kPa/s]: what flows in at no pressure; stall [kPa]: where nothing flows in; out [kPa/s]: what flows
    out at `stall`, with the root of the pressure; period 0: no such valves.
    """

    most: float = 0.0
    stall: float = 1.0
    out: float = 0.0
    period: float = 0.0


REGULATED = Switched()
"""A regulator, and no such valves."""


class Relays(NamedTuple):
    """A Preisach operator: pressures [kPa] at which each relay switches on and off, and what the angle [deg]
    rises by when it does, each (n,)."""

    on: Signal
    off: Signal
    rise: Signal


NONE = Relays(np.empty(0), np.empty(0), np.empty(0))


class Loop(NamedTuple):
    """A PI around the chain: controller (gains of its own period), period [ticks], the angle [deg] that
    it counts from, reference [deg] counted likewise at every ms, delay of the command [ticks]."""

    controller: Controller
    period: int
    zero: float
    reference: Signal
    late: int


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
        return _chain(
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


@njit
def through_valves(p, pressure, tick, duty):
    """Pressure [kPa] after a ms, of which the filling valve is open for a part."""
    ticks = round(p.period / 0.001)
    opened = min(max(duty * ticks - tick % ticks, 0.0), 1.0)
    change = opened * p.most * (1.0 - pressure / p.stall)
    change -= (1.0 - opened) * p.out * sqrt(max(pressure, 0.0) / p.stall)
    return max(pressure + 0.001 * change, 0.0)


@njit
def _chain(
    command,
    loop,
    gain,
    bias,
    fill,
    exhaust,
    falls,
    r,
    w,
    origin,
    cubic,
    full,
    first,
    share,
    slow,
    lag,
    late,
    tail,
    breakaway,
    rest,
    relays,
    natural,
    damping,
    valves,
    low,
    high,
):
    """loop: what makes the command up from its first value on, behind a delay; an empty reference where the
    command is given."""
    n = len(command)
    pressure, angle = np.empty(n), np.empty(n)
    P = follows = gain * command[0] + bias
    P = 0.0 if valves.period > 0.0 else P
    moves = True
    plays = np.zeros(len(r))
    y, v, w0 = 0.0, 0.0, 2.0 * np.pi * natural
    c = 0.0
    is_on = relays.on <= P
    switched = np.sum(relays.rise[is_on])
    before = P
    closed, integral, filtered, held = len(loop.reference) > 0, 0.0, 0.0, command[0]
    for j in range(len(r)):
        plays[j] = min(max(0.0, P - origin - r[j]), P - origin + r[j])
    for i in range(n):
        if closed:
            if i % loop.period == 0 and i > 0:
                seen = angle[i - 1] - loop.zero
                held, integral, filtered = pi_command(
                    loop.controller, loop.reference[i], seen, filtered, integral
                )
            if i + loop.late < n:
                command[i + loop.late] = held
        target = gain * command[i] + bias
        follows += 0.001 / tail * (target - follows)
        target += late * (follows - target)
        if valves.period > 0.0:
            P = through_valves(valves, P, i, (command[i] - low) / (high - low))
        else:
            rate = (fill if target > P else exhaust) / (1.0 + falls * max(P, 0.0) / 100.0)
            P += 0.001 * rate * (target - P)
        x = P - origin
        u = 0.0
        for j in range(len(r)):
            plays[j] = min(max(plays[j], x - r[j]), x + r[j])
            u += w[j] * plays[j]
        if len(is_on) > 0:
            for j in range(len(is_on) if before != P else 0):
                if relays.on[j] <= P and not is_on[j]:
                    is_on[j] = True
                    switched += relays.rise[j]
                elif relays.off[j] > P and is_on[j]:
                    is_on[j] = False
                    switched -= relays.rise[j]
            u, before = switched, P
        h = u - cubic * full * (u / full) ** 3
        h = max(h - first, 0.0) if first > 0.0 else h
        if i == 0:
            y, c = h, share * h
        c += 0.001 / slow * (share * h - c)
        if breakaway > 0.0:
            moves = abs(h + c - y) > (rest if moves else breakaway)
        if natural > 0.0:
            v += 0.001 * (w0 * w0 * (h + c - y) - 2.0 * damping * w0 * v)
            y += 0.001 * v
        elif moves:
            y += 0.001 / lag * (h + c - y)
        pressure[i], angle[i] = P, y
    return pressure, angle


def sine(low: float, high: float, frequency: float, seconds: float) -> Signal:
    """Between two commands, from the lower one."""
    t = np.arange(round(seconds / TICK)) * TICK
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos(2.0 * np.pi * frequency * t)


def stairs(levels: Sequence[float], hold: float) -> Signal:
    """Levels held for a time [s]."""
    return np.repeat(np.asarray(levels, float), round(hold / TICK))


def wandering(low: float, high: float, hold: float, seconds: float, seed: int) -> Signal:
    """Random levels, each held from half to one and a half times `hold` [s]."""
    rng, parts, total = np.random.default_rng(seed), [np.full(1000, low)], 1.0
    while total < seconds:
        for_s = rng.uniform(0.5, 1.5) * hold
        parts.append(np.full(round(for_s / TICK), rng.uniform(low, high)))
        total += for_s
    return np.concatenate(parts)[: round(seconds / TICK)]


def arm_a() -> SoftRig:
    """Driven by one slow sine; the pressure channel is renewed every 0.17 s."""
    return SoftRig(
        "arm-a", 0.0, 5.0, 30.0, 4.0, 0.66, 2.4, 1.6, 0.8, (0.0, 3.0, 8.0, 15.0, 25.0),
        (0.08, 0.05, 0.05, 0.04, 0.04), 10.0, 0.12, 30.0, 0.0, (0.08, 12.0), 0.08,
        Logger(0.0102, renewal=0.17, angle_noise=0.015, pressure_noise=0.15),
        {
            "large": lambda: sine(0.5, 4.5, 0.1, 60.0),
            "medium": lambda: sine(0.5, 3.5, 0.1, 60.0),
            "check": lambda: sine(0.5, 4.0, 0.1, 60.0),
        },
    )  # fmt: skip


def arm_b() -> SoftRig:
    """Three runs at 20 Hz, a sensor that rests at zero until the joint moves."""
    return SoftRig(
        "arm-b", 0.0, 10.0, 8.0, 0.0, 0.10, 4.0, 2.5, 0.3, (0.0, 2.0, 6.0, 12.0), (0.10, 0.08, 0.06, 0.05),
        12.0, 0.10, 18.0, 2.0, (0.05, 8.0), 0.15,
        Logger(0.05, angle_step=0.05, pressure_step=0.1, angle_noise=0.0, rests=True),
        {
            "stairs": lambda: stairs([0, 3, 6, 9, 10, 7, 4, 1, 5, 8, 2, 0], 5.0),
            "wave": lambda: sine(0.0, 10.0, 0.05, 80.0),
            "check": lambda: wandering(0.0, 10.0, 3.0, 60.0, 4),
        },
    )  # fmt: skip


def bender() -> SoftRig:
    """A bending actuator on a pump: filling in 2 s, exhausting in 5, commanded in counts of a DAC."""
    return SoftRig(
        "bender", 0.0, 4095.0, 0.02, 3.0, 0.08, 1.1, 0.45, 0.2, (0.0, 1.5, 4.0), (0.45, 0.2, 0.15), 8.0, 0.08,
        55.0, 0.0, (0.04, 6.0), 0.1,
        Logger(0.04, angle_step=0.1, pressure_step=0.05, angle_noise=0.1, pressure_noise=0.1, offset=0.3),
        {
            "stairs": lambda: stairs([0, 1000, 2000, 3000, 4000, 3000, 2000, 1000, 0], 10.0),
            "steps": lambda: wandering(0.0, 4095.0, 6.0, 90.0, 1),
            "wave": lambda: sine(0.0, 4000.0, 0.04, 75.0),
            "check": lambda: wandering(200.0, 3800.0, 5.0, 75.0, 2),
        },
    )  # fmt: skip


def finger() -> SoftRig:
    """A finger on a vacuum pump: on/off valves under pulse-width modulation at 40 Hz, in percent."""
    return SoftRig(
        "finger", 0.0, 100.0, 0.73, 0.0, 0.05, 1.0, 1.0, 0.0, (0.0, 1.0, 3.0, 7.0), (0.5, 0.2, 0.15, 0.1),
        0.0, 0.15, 80.0, 0.0, (0.08, 5.0), 0.1,
        Logger(0.01, angle_step=0.05, pressure_step=0.05, angle_noise=0.08, pressure_noise=0.1),
        {
            "stairs": lambda: stairs([0, 15, 30, 45, 60, 75, 90, 75, 60, 45, 30, 15, 0], 4.0),
            "steps": lambda: wandering(0.0, 95.0, 2.0, 70.0, 5),
            "wave": lambda: sine(0.0, 90.0, 0.15, 60.0),
            "check": lambda: wandering(5.0, 90.0, 1.5, 60.0, 6),
        },
        valves=Switched(150.0, 78.0, 220.0, 0.025),
    )  # fmt: skip


def climber() -> SoftRig:
    """Fitted on small steps and a slow sine, held out on large steps: what the rate far from the commanded
    pressure is, no recording to fit on says.  The pressure is renewed in every fortieth row."""
    return SoftRig(
        "climber", 0.0, 5.0, 40.0, 2.0, 0.05, 6.0, 5.0, 0.5, (0.0, 4.0, 12.0, 30.0), (0.06, 0.05, 0.05, 0.06),
        15.0, 0.10, 36.0, 0.0, (0.06, 5.0), 0.08,
        Logger(0.005, renewal=0.2, angle_noise=0.03, pressure_noise=0.1, pressure_step=0.25),
        {
            "stairs": lambda: stairs([0.2, 1, 1.8, 2.6, 3.4, 4.2, 4.2, 3.4, 2.6, 1.8, 1, 0.2], 5.0),
            "wave": lambda: sine(0.2, 4.0, 0.1, 60.0),
            "check": lambda: wandering(0.2, 4.2, 3.0, 60.0, 7),
        },
    )  # fmt: skip


def muscles() -> SoftRig:
    """A wrist of two pneumatic muscles behind electro-pneumatic regulators, made after figures that were read
    off a public log: pressure late by 53 ms, with 124 ms and a tail up to 0.9 s; a loop a third of the stroke
    wide, 9 / 18 deg at 200 kPa and 34 / 56 at 390 (up / down); the angle holds over 13 kPa, then jumps
    4 deg."""
    return SoftRig(
        "muscles", 0.0, 10.0, 60.0, 0.0, 0.053, 8.0, 8.0, 0.0, (0.0, 20.0, 45.0, 89.0),
        (0.010, 0.016, 0.056, 0.047), 95.0, -0.12, 65.0, 0.0, (0.06, 3.0), 0.06,
        Logger(0.01, angle_noise=0.03, pressure_noise=0.5, angle_step=0.01, pressure_step=0.15),
        {
            "sweep": lambda: np.concatenate([np.linspace(0, 10, 20000), np.linspace(10, 0, 20000)]),
            "stairs": lambda: stairs([0, 2, 4, 6, 8, 10, 7, 5, 3, 1, 6, 2, 0], 4.0),
            "steps": lambda: wandering(0.0, 9.0, 3.0, 60.0, 11),
            "check": lambda: wandering(0.0, 9.5, 2.5, 60.0, 12),
        },
        (0.12, 0.35), (2.5, 0.3),
    )  # fmt: skip


CAMPAIGNS = {
    "arm-a": (arm_a, ("large", "medium"), ("check",)),
    "arm-b": (arm_b, ("stairs", "wave"), ("check",)),
    "bender": (bender, ("stairs", "steps", "wave"), ("check",)),
    "finger": (finger, ("stairs", "steps", "wave"), ("check",)),
}
"""Rig, recordings to fit on and held-out ones, by name."""
