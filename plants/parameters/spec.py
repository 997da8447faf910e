"""What every parameter of a name has in common."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """What every parameter of a name has in common: unit, meaning, bounds that make sense."""

    unit: str
    meaning: str
    low: float
    high: float
