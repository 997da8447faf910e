"""A certificate: a claim about a class of loops, and the check that confirmed it outside the solver."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from numpy.typing import NDArray

from design.robustness.certificates.reasons import NoCertificate, UnstableBranch, UnstableMode
from design.robustness.certificates.sampled.words import Word
from design.status import Status


class Switching(Enum):
    """What may change at will along a loop of a class, the narrowest class first."""

    MEMORY = "nothing: the slope is as the memory that meets one line at most"
    MEMORY_IN_BOX = "slope and lag, which drift within a box; else as the memory that meets one line at most"
    SLOPE_EVERY_SAMPLE = "slope, at every sample"
    FIXED_LAW = "slope, at any time"
    ANY_TIME = "slope and regulator rate, at any time"
    EVERY_SAMPLE = "slope and regulator rate, at every sample"

    @property
    def sampled(self) -> bool:
        """Whether loops of the class move from sample to sample."""
        return self not in (Switching.FIXED_LAW, Switching.ANY_TIME)


@dataclass(frozen=True)
class LoopClass:
    """A class of loops: what may change; rates [1/s] and slopes [deg/kPa] between which it may; monotone: the
    regulator's law grows with its error, where it is fixed; samples: of dead time, of a sampled loop; lag
    [s]: between which Tw may lie, where it is not the plant's."""

    switching: Switching
    rates: tuple[float, float]
    slopes: tuple[float, float]
    monotone: bool = False
    samples: int = 0
    lag: tuple[float, float] | None = None


@dataclass(frozen=True)
class Certificate:
    """What one rung of the ladder found.

    name: of the rung; about: the class of loops of which it proves that they decay, None of plain
    matrices; dead_time [s]: that the loop has beside its own; holds: whether the check outside the
    solver confirmed it; decay [1/s]: largest rate at which every trajectory of the class was shown to die
    away, None where none was; margin: of that check, without unit, positive where it is passed: by how
    much the worst inequality holds, as a share of its own size; solver: that found it; reason: why it does
    not hold; word: an order of switching that makes a loop of the class grow, so that no function can
    prove what the rung claims; shape: P, (n, n), where states with x' P x <= level keep the command within
    its range, else None; evidence: further figures, for JSON.
    """

    name: str
    about: LoopClass | None
    dead_time: float
    holds: bool
    decay: float | None
    margin: float | None
    solver: str
    reason: NoCertificate | None = None
    word: Word | None = None
    shape: NDArray[Any] | None = None
    level: float | None = None
    evidence: Mapping[str, Any] = field(default_factory=dict)

    @property
    def rung(self) -> str:
        """Name of the rung among those of loops in continuous time and sampled ones."""
        sampled = self.about is not None and self.about.switching.sampled
        return f"discrete-time {self.name}" if sampled else self.name

    @property
    def remembers(self) -> bool:
        """Whether it is about loops whose slope nobody switches: their memory chooses it."""
        return self.about is not None and self.about.switching in (Switching.MEMORY, Switching.MEMORY_IN_BOX)

    @property
    def status(self) -> Status:
        """Proved; disproved, by a loop of the class that does not decay; or open: that no function was
        found does not make the claim false."""
        if self.holds:
            return Status.PROVED
        grows = self.word is not None or isinstance(self.reason, UnstableBranch | UnstableMode)
        return Status.DISPROVED if grows else Status.OPEN
