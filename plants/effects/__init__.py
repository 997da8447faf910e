"""Effects that a rig may have and the declared wrist lacks: one phenomenon a file.

``wrist + Creep(gain=0.1)`` is a wrist.  Each effect acts at a port of the wrist
(`plants.effects.effect` lists them), has its own parameters and state, and
vanishes at its null.  Where rigs differ, one name has two or three functional
forms; a new effect is a new file, a line here and a test.
"""

from plants.effects.branch_curvature import Bow, Curve, Polynomial, Saturation
from plants.effects.creep import Creep, LogCreep, TwoTimeCreep
from plants.effects.cross_coupling import Coupling, PressureCoupling, QuadraticCoupling
from plants.effects.dead_time import DeadTime, TubeDeadTime
from plants.effects.effect import Around, Effect
from plants.effects.end_stop import CompliantStop, GivingStop, HardStop, PadStop, SpringStop
from plants.effects.fill_exhaust import OrificeExhaust, PressureDependentRates, TwoRates
from plants.effects.gyro_drift import Drift, WarmingDrift
from plants.effects.inertia import DraggedInertia, Inertia, StiffeningInertia
from plants.effects.load_step import GradualLoad, LoadStep
from plants.effects.periodic import HarmonicHum, Hum
from plants.effects.rate_dependence import PowerWidening, RememberedRate, SaturatingWidening, Viscous
from plants.effects.regulator_deadband import Latch, Play, ValveOverlap
from plants.effects.softening import Mullins, SofteningByWork, Warming
from plants.effects.supply_droop import CappedPressure, CappedTarget, LimitedFlow, SaturatingSag

EFFECTS: dict[str, tuple[type[Effect], ...]] = {
    "dead-time": (DeadTime, TubeDeadTime),
    "regulator-deadband": (Latch, Play, ValveOverlap),
    "fill-exhaust-asymmetry": (TwoRates, PressureDependentRates, OrificeExhaust),
    "supply-droop": (CappedPressure, CappedTarget, SaturatingSag, LimitedFlow),
    "branch-curvature": (Polynomial, Saturation, Bow, Curve),
    "cross-coupling": (Coupling, QuadraticCoupling, PressureCoupling),
    "rate-dependence": (Viscous, PowerWidening, SaturatingWidening, RememberedRate),
    "softening": (SofteningByWork, Warming, Mullins),
    "load-step": (LoadStep, GradualLoad),
    "creep": (Creep, TwoTimeCreep, LogCreep),
    "inertia": (Inertia, DraggedInertia, StiffeningInertia),
    "end-stop": (HardStop, GivingStop, SpringStop, PadStop, CompliantStop),
    "gyro-drift": (Drift, WarmingDrift),
    "periodic-disturbance": (Hum, HarmonicHum),
}
"""The forms of each effect, by name, in the order in which effects of a wrist act."""

__all__ = ["EFFECTS", "Around", "Effect", "form_of"]


def form_of(name: str, form: str) -> type[Effect]:
    """The form of an effect by its name and the form's.

    Raises KeyError for a name, or a form of it, that there is not.
    """
    for effect in EFFECTS[name]:
        if form == effect.FORM:
            return effect
    raise KeyError(f"{name} has no form {form!r}; one of {', '.join(e.FORM for e in EFFECTS[name])}")
