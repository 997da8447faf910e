"""A certificate: a claim about a class of loops, and the check that confirmed it outside the solver."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True)
class Certificate:
    """What one rung of the ladder found.

    rung: its name; claim: what it proves, in words; dead_time [s]: that the loop has beside its own;
    holds: whether the check outside the solver confirmed it; decay [1/s]: largest rate at which every
    trajectory of the class was shown to die away, None where none was; margin: of that check, without
    unit, positive where it is passed: by how much the worst inequality holds, as a share of its own
    size; solver: that found it; why: where it does not hold, what each solver or the check said;
    shape: P, (n, n), where states with x' P x <= level keep the command within its range, else None;
    evidence: further figures, for JSON.
    """

    rung: str
    claim: str
    dead_time: float
    holds: bool
    decay: float | None
    margin: float | None
    solver: str
    why: str = ""
    shape: NDArray[Any] | None = None
    level: float | None = None
    evidence: Mapping[str, Any] = field(default_factory=dict)
