"""The pneumatic wrist, and what measurements say about it.

>>> from plants import Wrist
>>> Wrist.flexion().simulate([3.0] * 5000).angle[-1].round(2)
np.float64(11.28)
"""

from plants.actuator.regulator import Regulator
from plants.errors import InputError, InputWarning
from plants.hysteresis import FourSegment, HysteresisLaw, PrandtlIshlinskii
from plants.parameters.quantities import ParameterSet, built_in, load
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, State, Wrist

__all__ = [
    "COMMAND_RANGE",
    "SAMPLE_TIME",
    "FourSegment",
    "HysteresisLaw",
    "InputError",
    "InputWarning",
    "ParameterSet",
    "PrandtlIshlinskii",
    "Regulator",
    "State",
    "Wrist",
    "built_in",
    "load",
]
