"""One claim about a loop, labelled as what it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["certificate", "prediction", "sample"]

EVERY_BRANCH = "every branch"
"""The branch of a statement that is about all of them, in any order."""


@dataclass(frozen=True)
class Statement:
    """A claim in words, and what became of it.

    holds: None where it is not known, which for a certificate means that none was found; it does not
    mean that the claim is false.  value [unit]: the figure that it rests on, None where there is none;
    branch: of the hysteresis, such as ``line1, slow regulator rate``; because: why it holds or does
    not, or how the figure was checked; evidence: further figures, for JSON.
    """

    kind: Kind
    statement: str
    holds: bool | None
    value: float | None
    unit: str = ""
    branch: str = EVERY_BRANCH
    because: str = ""
    evidence: Mapping[str, Any] = field(default_factory=dict)

    @property
    def record(self) -> dict[str, Any]:
        """The statement for JSON."""
        return {
            "statement": self.statement,
            "holds": self.holds,
            "value": self.value,
            "unit": self.unit,
            "branch": self.branch,
            "because": self.because,
            **self.evidence,
        }
