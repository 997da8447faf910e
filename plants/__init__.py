"""Model of a pneumatic wrist with hysteresis, and its identification from measurements.

>>> from plants import Wrist
>>> Wrist.flexion().simulate([3.0] * 5000).angle[-1].round(2)
np.float64(11.28)
"""

from typing import Any

from plants.actuator.regulator import Regulator
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.wrist.creep import Creep
from plants.errors import InputError, InputWarning
from plants.facade import named
from plants.hysteresis import FourSegment, HysteresisLaw, Memory, PrandtlIshlinskii
from plants.parameters.files import built_in, load
from plants.parameters.quantities import ParameterSet
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, STARTS, State, Wrist

_HOMES = {
    "RATES": "plants.linearisation",
    "branch_slopes": "plants.linearisation",
    "wrist_x0": "plants.linearisation",
    "load_campaign": "plants.measured.campaigns.campaign",
    "load_recording": "plants.measured.campaigns.campaign",
    "fit_campaign": "plants.measured.fitting.fit",
    "trace_campaign": "plants.measured.trace.trace",
}
"""What needs more than NumPy, imported when it is first used, so that the command starts fast."""

__all__ = [
    "COMMAND_RANGE",
    "RATES",
    "SAMPLE_TIME",
    "STARTS",
    "Creep",
    "DeadTime",
    "FourSegment",
    "HysteresisLaw",
    "InputError",
    "InputWarning",
    "Memory",
    "ParameterSet",
    "PrandtlIshlinskii",
    "Regulator",
    "State",
    "Wrist",
    "branch_slopes",
    "built_in",
    "fit_campaign",
    "load",
    "load_campaign",
    "load_recording",
    "trace_campaign",
    "wrist_x0",
]


def __getattr__(name: str) -> Any:
    return named("plants", _HOMES, name)
