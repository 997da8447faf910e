"""Friction of a rig from its log: what force a displacement meets, by a law whose parts the data choose."""

from plants.measured.friction.choice import FrictionChoice, fit_friction
from plants.measured.friction.law import FrictionLaw, FrictionParts
from plants.measured.friction.run import ForceRun

__all__ = ["ForceRun", "FrictionChoice", "FrictionLaw", "FrictionParts", "fit_friction"]
