"""Delay lines on a target: rings, of which the struct keeps what a law does not read anew in every sample."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from design.export.fields import Quantity
from plants.actuator.delay import SampledDelay
from plants.kernel import pytrees

Delays = Sequence[tuple[int, int]]
"""Of each delay line of a state, the number of its first leaf and of its whole samples."""


class DelayRing(NamedTuple):
    """A delay line on the target: a ring.  Place of its first leaf in the state, numbers that it holds, and
    what it holds."""

    near: int
    size: int
    holds: Quantity

    @property
    def far(self) -> int:
        """Place of what was put in one sample before `near`."""
        return self.near + 1

    @property
    def newest(self) -> int:
        """Place of what is put in."""
        return self.near + 2

    @property
    def fields(self) -> tuple[Quantity, Quantity]:
        """Members that keep it: the ring, and the place of the oldest in it."""
        name = self.holds.name.removesuffix("_near")
        return (
            Quantity(f"{name}_line", self.holds.unit, "what the delay holds, a ring", self.size),
            Quantity(f"{name}_oldest", "", "place of the oldest in the ring", counts=True),
        )

    @property
    def ring(self) -> str:
        """The ring's member; one of a single number is declared without brackets."""
        return self.fields[0].member

    @property
    def oldest(self) -> str:
        """The member that counts."""
        return self.fields[1].member


def kept(state: Sequence[Quantity], delays: Delays) -> list[tuple[int, Quantity]]:
    """Leaves of a state that its struct keeps, with their places: of a delay line not what is read from it
    anew in every sample."""
    read = {row + i for row, _ in delays for i in (0, 1)}
    return [(i, f) for i, f in enumerate(state) if i not in read]


def rings(state: Sequence[Quantity], delays: Delays) -> list[DelayRing]:
    """The delay lines of a state."""
    return [DelayRing(row, samples + 1, state[row]) for row, samples in delays]


def samples_of(coefficients: Any) -> list[int]:
    """Whole samples of each delay among coefficients."""
    flat = pytrees.leaves(coefficients)
    return [int(np.rint(flat[i])) for i in pytrees.places(coefficients, SampledDelay)]
