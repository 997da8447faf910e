"""The sensor of the angle, noisy and in whole quanta, and what a controller is shown.

A reading is rounded to the nearest quantum, halves upwards, as a converter does whose thresholds lie
half-way between its codes.  (Rounding halves to even, as ``np.round``, would be no other reading, but has no
operation in the compiled loop.)
"""

from typing import Any, NamedTuple

import numpy as np

Number = Any
HOLD = 10
"""Samples of 1 ms that a value of the noise is held: the sensor delivers at 100 Hz."""


class Measured(NamedTuple):
    """What a controller sees in one sample: error of the angle that the sensor shows and that angle
    [deg], and the pressure [kPa]."""

    error: Number
    angle: Number
    pressure: Number

    @property
    def reference(self) -> Number:
        """The angle [deg] that is asked for."""
        return self.error + self.angle


class Noise(NamedTuple):
    """Coefficient of white noise: its standard deviation [deg]."""

    deviation: Number


class Quantum(NamedTuple):
    """Coefficients of a quantum [deg]: its size, 1 / size."""

    size: Number
    per_degree: Number


class Sensor(NamedTuple):
    """A sensor, perfect but for the parts that it has: a `Noise`, a `Quantum`."""

    noise: Any = ()
    quantum: Any = ()

    def shows(self, angle: Number, noise: Number = 0.0) -> Number:
        """The reading [deg] of an angle [deg], `noise` being of standard deviation 1.

        >>> float(sensor(0.0, 0.05).shows(0.126))
        0.15000000000000002
        """
        seen = angle + self.noise.deviation * noise if self.noise else angle
        if not self.quantum:
            return seen
        return self.quantum.size * np.floor(seen * self.quantum.per_degree + 0.5)


PERFECT = Sensor()
"""A sensor that shows the angle itself."""


def sensor(noise: float = 0.0, quantum: float = 0.0) -> Sensor:
    """A sensor with noise of a standard deviation [deg] and a quantum [deg]; without those that are 0."""
    return Sensor(
        Noise(noise) if noise > 0.0 else (), Quantum(quantum, 1.0 / quantum) if quantum > 0.0 else ()
    )
