"""Gains of the observers here, which all watch a lag behind something that holds still: both poles alike."""

from typing import Any

Number = Any


def double_pole(keep: Number, pole: Number) -> tuple[Number, Number]:
    """Corrections (of the angle, of what it lags behind) per degree that the angle was mispredicted by, which
    put both poles of the error at `pole`; the lag keeps the share `keep` of its angle in a step.

    >>> double_pole(0.5, 0.5)
    (0.5, 0.5)
    """
    angle = 1.0 - pole * pole / keep
    return angle, (keep * (1.0 - angle) + 1.0 - 2.0 * pole) / (1.0 - keep)
