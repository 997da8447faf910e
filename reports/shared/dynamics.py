"""Unmodelled dynamics, in words."""

import numpy as np

from plants.parameters.remainder import UncertaintyWeight
from reports.shared.tables import number


def dynamics_words(weight: UncertaintyWeight) -> str:
    """How much of what the plant does its residual repeats, as a sentence.

    >>> dynamics_words(UncertaintyWeight(0.1, 1.5, 2.0, 2.2))[:80]
    'Part of it follows the plant linearly: unmodelled dynamics of at most 10 % at lo'
    """
    high = float(np.abs(weight.response(np.array(2.0 * np.pi * weight.known_Hz))))
    return (
        "Part of it follows the plant linearly: unmodelled dynamics of at most "
        f"{number(100.0 * weight.low, 2)} % at low frequencies and {number(100.0 * high)} % at "
        f"{number(weight.known_Hz, 2)} Hz, the highest frequency that the recordings tell of."
    )
