"""Friction of a rig from its log: what force a displacement meets, by a law whose parts the data choose."""

from plants.measured.friction.choice import Choice, fit_friction
from plants.measured.friction.law import FrictionLaw, Parts
from plants.measured.friction.run import ForceRun

__all__ = ["Choice", "ForceRun", "FrictionLaw", "Parts", "fit_friction"]
