"""Reference profiles: references one after the other, in each lane at times of its own."""

from typing import Any, NamedTuple

import numpy as np

Number = Any


class Asked(NamedTuple):
    """What is asked at a sample: the reference [deg], the one before it [deg], the sample at which it
    began."""

    reference: Number
    before: Number
    begins: Number


class ReferenceProfile(NamedTuple):
    """References [deg], the samples at which those after the first begin, and what was asked before [deg]."""

    references: tuple[Number, ...]
    switches: tuple[Number, ...] = ()
    before: Number = 0.0

    def at(self, sample: Number) -> Asked:
        """What is asked at a sample.

        >>> profile = ReferenceProfile((15.0, 0.0), (2000.0,))
        >>> [float(x) for x in profile.at(2500.0)]
        [0.0, 15.0, 2000.0]
        """
        reference, before, begins = Asked(self.references[0], self.before, 0.0)
        for later, earlier, switch in zip(
            self.references[1:], self.references[:-1], self.switches, strict=True
        ):
            here = sample >= switch
            reference = np.where(here, later, reference)
            before = np.where(here, earlier, before)
            begins = np.where(here, switch, begins)
        return Asked(reference, before, begins)
