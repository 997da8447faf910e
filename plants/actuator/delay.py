"""Transport delay as a port primitive: the runner keeps the line, the law only reads and feeds it.

A delay of hundreds of samples is no state that a law could pass along one by
one.  The law puts in `newest` and reads two neighbouring samples of the past,
which the runner (`plants.kernel`) lays there before every step.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants.meanings import remembers

Number = Any
Array = NDArray[np.float64]
LONGEST = 511
"""Samples that a line holds."""


@remembers(
    near=("deg", "angle of the model so many whole samples ago"),
    far=("deg", "angle of the model one sample before that"),
    newest=("deg", "angle of the model put into the delay last"),
)
class DelayLine(NamedTuple):
    """What a law sees of a line: the samples put in `samples` steps ago (near) and one step before
    that (far), and the one put in last (newest).  A line starts filled with its `newest`."""

    near: Number
    far: Number
    newest: Number


class SampledDelay(NamedTuple):
    """A delay of `samples` whole samples and a `share` of one more."""

    samples: Number
    share: Number


def at_rest(value: Number) -> DelayLine:
    """A line that has held one value for long."""
    return DelayLine(value, value, value)


def sampled(delay: Number, dt: float) -> SampledDelay:
    """A delay [s] in samples of `dt` [s]; at most `LONGEST` of them."""
    samples = np.clip(np.asarray(delay, float) / dt, 0.0, LONGEST - 1.0)
    whole = np.floor(samples + 1e-9)
    return SampledDelay(whole, np.maximum(samples - whole, 0.0))


def step(line: DelayLine, value: Number, c: SampledDelay) -> tuple[DelayLine, Number]:
    """The line with one more value put in, and what comes out; linear between samples.

    >>> from plants.actuator.delay import *
    >>> _, out = step(at_rest(3.0), 7.0, sampled(0.0, 0.001))   # no delay: what goes in comes out
    >>> float(out)
    7.0
    """
    near = np.where(c.samples < 0.5, value, line.near)
    return line._replace(newest=value), near + c.share * (line.far - near)


def arriving(commands: Array, before: Array, late: Array, index: Array) -> Array:
    """Commands [V], (samples, lanes), as they arrive at the samples of an index, `late` samples after they
    were given, linear between two of them as a line has it; `before` [V] was held until the start; (lanes,).

    For a loop that is cut into calls, which no line outlasts.

    >>> given = np.array([[1.0], [2.0], [3.0]])
    >>> arriving(given, np.array([0.0]), np.array([1.5]), np.arange(3.0)).ravel().tolist()
    [0.0, 0.5, 1.5]
    """
    whole = np.floor(late + 1e-9).astype(int)
    share, lanes = np.maximum(late - whole, 0.0), np.arange(late.size)

    def given(at_: NDArray[np.intp]) -> Array:
        return np.where(at_ >= 0, commands[np.maximum(at_, 0), lanes], before)

    near = index.astype(int)[:, None] - whole
    found: Array = (1.0 - share) * given(near) + share * given(near - 1)
    return found
