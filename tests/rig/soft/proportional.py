"""A proportional regulator of second order, which gives nothing below a least command.

The pressure is that of `scipy.signal`: a second-order system, the command held over each sample;
the library has no part in it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import cont2discrete, lfilter

from tests.rig.signals import Signal
from tests.rig.soft.pressures import ROW, write_pressures

RANGE = 10.0
"""Largest command [V]."""


@dataclass(frozen=True)
class Proportional:
    """Pressure = gain (command - dead) above a dead command [V], and none below; natural frequency [rad/s],
    damping ratio, delay [s] and noise [kPa]."""

    gain: float = 20.0
    dead: float = 0.0
    natural: float = 22.0
    damping: float = 0.8
    delay: float = 0.03
    noise: float = 0.25

    def pressure(self, command: Signal) -> Signal:
        """Pressure [kPa] at each row of a command [V] that was held at its first value for long."""
        late = round(self.delay / ROW)
        asked = np.concatenate([np.full(late, command[0]), command])[: len(command)]
        target = self.gain * np.maximum(asked - self.dead, 0.0)
        continuous = ([self.natural**2], [1.0, 2.0 * self.damping * self.natural, self.natural**2])
        numerator, denominator, _ = cont2discrete(continuous, ROW, "zoh")
        return np.asarray(target[0] + lfilter(numerator.ravel(), denominator, target - target[0]))

    def write(self, folder: Path) -> None:
        """A campaign of its pressures."""
        write_pressures(folder, self.pressure, RANGE, self.noise)
