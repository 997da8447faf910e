"""Effects that a rig may have and the declared wrist lacks: one phenomenon a file.

``wrist + Creep(gain=0.1)`` is a wrist.  Each effect acts at a port of the wrist
(`plants.effects.effect` lists them), has its own parameters and state, and
vanishes at its null.  Where rigs differ, one name has two or three functional
forms; a new effect is a new file, a line here and a test.  What only one of your
rigs has need not stand here: `register` makes it known for as long as Python runs.
"""

from collections.abc import Iterable
from inspect import isabstract
from typing import TypeVar

from plants.effects.effect import Around, Effect
from plants.effects.regulator.dead_time import DeadTime, SecondOrderDeadTime, TubeDeadTime
from plants.effects.regulator.fill_exhaust import (
    CommandedOpenings,
    FlowLimits,
    OrificeExhaust,
    PressureDependentRates,
    TwoRates,
)
from plants.effects.regulator.leak import LaminarLeak, PowerLeak, SealedLeak
from plants.effects.regulator.regulator_curvature import Hyperbola
from plants.effects.regulator.regulator_deadband import Latch, LeastPressure, PlayDeadBand, ValveOverlap
from plants.effects.regulator.supply_droop import CappedPressure, CappedTarget, LimitedFlow, SaturatingSag
from plants.effects.sensor.gyro_drift import Drift, WarmingDrift
from plants.effects.sensor.periodic import HarmonicHum, Hum
from plants.effects.wrist.branch_curvature import Bow, Polynomial, Saturation, SmoothCurve
from plants.effects.wrist.creep import Creep, LogCreep, TwoTimeCreep
from plants.effects.wrist.cross_coupling import Coupling, PressureCoupling, QuadraticCoupling
from plants.effects.wrist.end_stop import CompliantStop, GivingStop, HardStop, PadStop, SpringStop
from plants.effects.wrist.inertia import DraggedInertia, Inertia, StiffeningInertia
from plants.effects.wrist.learnt_block import LearntBlock
from plants.effects.wrist.load_step import GradualLoad, LoadStep
from plants.effects.wrist.loop_shape import CurvedTransit, OneMorePlay, SeveralPlays, SmoothLoop
from plants.effects.wrist.rate_dependence import PowerWidening, RememberedRate, SaturatingWidening, Viscous
from plants.effects.wrist.softening import Mullins, SofteningByWork, Warming
from plants.effects.wrist.stick_slip import BristleFriction, FreeSlip, MaxwellSlip, RubbingSlip
from plants.errors import InputError

EFFECTS: dict[str, tuple[type[Effect], ...]] = {
    forms[0].NAME: forms
    for forms in (
        (DeadTime, TubeDeadTime, SecondOrderDeadTime),
        (Latch, PlayDeadBand, ValveOverlap, LeastPressure),
        (TwoRates, PressureDependentRates, OrificeExhaust, FlowLimits, CommandedOpenings),
        (CappedPressure, CappedTarget, SaturatingSag, LimitedFlow),
        (LaminarLeak, PowerLeak, SealedLeak),
        (Hyperbola,),
        (Polynomial, Saturation, Bow, SmoothCurve),
        (Coupling, QuadraticCoupling, PressureCoupling),
        (Viscous, PowerWidening, SaturatingWidening, RememberedRate),
        (SofteningByWork, Warming, Mullins),
        (LoadStep, GradualLoad),
        (Creep, TwoTimeCreep, LogCreep),
        (OneMorePlay, SmoothLoop, SeveralPlays, CurvedTransit),
        (Inertia, DraggedInertia, StiffeningInertia),
        (FreeSlip, RubbingSlip, BristleFriction, MaxwellSlip),
        (HardStop, GivingStop, SpringStop, PadStop, CompliantStop),
        (Drift, WarmingDrift),
        (Hum, HarmonicHum),
    )
}
"""The forms of each effect, by name, in the order in which effects of a wrist act."""

Some = TypeVar("Some", Effect, type[Effect])

__all__ = ["EFFECTS", "Around", "Effect", "form_of", "in_order", "known_effects", "register"]


def known_effects() -> dict[str, tuple[type[Effect], ...]]:
    """The forms of all that a plant may have beside the declared wrist, by name, in the order in which they
    act: the effects, and last what was learnt, which has no cause and which no search tries unasked.

    >>> set(known_effects()) - set(EFFECTS)
    {'learnt'}
    """
    return {**EFFECTS, LearntBlock.NAME: (LearntBlock,)}


def in_order(effects: Iterable[Some]) -> tuple[Some, ...]:
    """Effects, or forms of them, in the order in which they act; one that is not registered acts last.

    >>> [e.NAME for e in in_order([Creep(), LeastPressure(), DeadTime()])]
    ['regulator-deadband', 'dead-time', 'creep']
    """
    place = {name: i for i, name in enumerate(known_effects())}
    return tuple(sorted(effects, key=lambda e: (not e.FIRST, place.get(e.NAME, len(place)))))


def form_of(name: str, form: str) -> type[Effect]:
    """The form of an effect by its name and the form's.

    Raises KeyError for a name, or a form of it, that there is not.
    """
    for effect in EFFECTS[name]:
        if form == effect.FORM:
            return effect
    raise KeyError(f"{name} has no form {form!r}; one of {', '.join(e.FORM for e in EFFECTS[name])}")


def register(form: type[Effect], after: str | None = None) -> type[Effect]:
    """Make a form of an effect known to parameter files, traces and wrists, and return it.

    after: name of the effect behind which it acts where they share a port; behind all others where not
    given.  A further form of an effect that is known has that one's place.  Registering a form again puts
    the new class in the old one's stead, as when a cell of a notebook is run twice.

    Raises InputError for a class that lacks what an effect has to say, and for an `after` that is not known
    or that the effect, being known, does not act behind.
    """
    lacking = [n for n in ("NAME", "FORM", "STAGE", "HAPPENS") if not hasattr(form, n)]
    if lacking or isabstract(form):
        what = ", ".join(lacking) or ", ".join(sorted(form.__abstractmethods__))
        raise InputError(f"effect {form.__name__}: lacks {what}; see plants.effects.effect")
    if after is not None and after not in EFFECTS:
        raise InputError(f"effect {form.NAME}: no effect {after!r} to act after; one of {', '.join(EFFECTS)}")
    names = list(EFFECTS)
    behind = names[names.index(after) + 1 :] if after is not None else []
    if form.NAME in EFFECTS:
        if after is not None and form.NAME not in behind:
            raise InputError(f"effect {form.NAME}: acts before {after} already; leave `after` out")
        EFFECTS[form.NAME] = (*(f for f in EFFECTS[form.NAME] if f.FORM != form.FORM), form)
        return form
    EFFECTS[form.NAME] = (form,)
    for name in behind:  # a dictionary keeps the order in which it was filled
        EFFECTS[name] = EFFECTS.pop(name)
    return form
