"""A syringe that a motor drives: it compresses a closed volume of air, some of which is lost.

The pressure is that of an ideal gas at constant temperature, the loss a laminar flow; the library has no part
in it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import njit

from tests.rig.signals import Signal
from tests.rig.soft.pressures import ROW, write_pressures

STROKE = 10.0
"""Largest command [V], for the whole stroke."""

OUTSIDE = 101.3
"""Pressure outside [kPa]."""


@njit
def compressed(command: Signal, swept: float, lag: float, loss: float) -> Signal:
    """Gauge pressure [kPa] at each row of strokes that are asked for, [V]."""
    substeps = 20
    h = ROW / substeps
    air, stroke, out = 1.0, command[0], np.empty(len(command))
    for i in range(len(command)):
        pressure = OUTSIDE * (air / (1.0 - swept * stroke / STROKE) - 1.0)
        out[i] = pressure
        for _ in range(substeps):
            stroke += h / lag * (command[i] - stroke)
            air -= h * loss * pressure / OUTSIDE
            pressure = OUTSIDE * (air / (1.0 - swept * stroke / STROKE) - 1.0)
    return out


@dataclass(frozen=True)
class Syringe:
    """The whole stroke sweeps a share `swept` of the closed volume; time constant of the motor [s]; loss of
    air [1/s of the gauge pressure]; noise of the sensor [kPa]."""

    swept: float = 0.3
    lag: float = 0.08
    loss: float = 0.0
    noise: float = 0.1

    @property
    def gain(self) -> float:
        """Slope of the pressure over the command at zero [kPa/V]."""
        return OUTSIDE * self.swept / STROKE

    def pressure(self, command: Signal) -> Signal:
        """Gauge pressure [kPa] at each row of a command [V]."""
        return np.asarray(compressed(command, self.swept, self.lag, self.loss))

    def write(self, folder: Path) -> None:
        """A campaign of its pressures."""
        write_pressures(folder, self.pressure, STROKE, self.noise)
