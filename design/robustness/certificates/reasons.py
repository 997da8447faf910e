"""Why a rung certifies nothing, as values."""

from dataclasses import dataclass


@dataclass(frozen=True)
class UnstableBranch:
    """The linear loop on a branch at an end of the regulator's rate has a pole [1/s] not below 0."""

    branch: str
    rate: str
    pole: float


@dataclass(frozen=True)
class UnstableMode:
    """One of the modes does not decay on its own."""


@dataclass(frozen=True)
class NotOnePlay:
    """The hysteresis is not one play between two straight lines."""


@dataclass(frozen=True)
class OtherLaw:
    """The controller has something, in words, that the loops of the rung do not have."""

    has: str


@dataclass(frozen=True)
class NoSolver:
    """No solver came to an end; what each said."""

    said: str


@dataclass(frozen=True)
class NoneOfThisKind:
    """There is no function of this kind: at the best that a solver finds the worst inequality is missed, by
    a margin below 0; what: the unknown, where the rung has a name for it."""

    solver: str
    margin: float
    what: str = ""


@dataclass(frozen=True)
class NotConfirmed:
    """A solver claims one, and the check outside it finds this margin."""

    solver: str
    margin: float


NoCertificate = (
    UnstableBranch | UnstableMode | NotOnePlay | OtherLaw | NoSolver | NoneOfThisKind | NotConfirmed
)
"""Why a rung certifies nothing."""
