"""What a tuning under the whole requirement asks of any kind of controller."""

from typing import Any, Protocol

from design.synthesis.judged import Judged
from design.synthesis.requirements import Problem


class TunedController(Protocol):
    """Gains of least cost on a set of cases, of any kind of controller."""

    @property
    def problem(self) -> Problem:
        """The set, its limits and branches."""
        ...

    @property
    def controller(self) -> Any:
        """The controller with the gains."""
        ...

    @property
    def gains(self) -> dict[str, float]:
        """Gains and settings by name."""
        ...

    @property
    def at(self) -> Judged:
        """What they do on the set."""
        ...

    @property
    def feasible(self) -> bool:
        """Whether they meet every limit there."""
        ...
