"""Certificates for the sampled loop: slope and regulator rate may change at will at every sample.

The class is larger than the real loop, whose slope follows its pressure and whose rate follows q.  What
is proved of it holds for the real loop while the command is not clipped; what is not, as where a word
(`word_of`) makes the class grow, says nothing against the real loop.
"""

from collections.abc import Iterator
from math import ceil

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.continuous.signals import rates, slopes
from design.robustness.certificates.reasons import UnstableMode
from design.robustness.certificates.sampled.lifted import Delayed, lifted, window_quadratic
from design.robustness.certificates.sampled.quadratic import (
    Search,
    best,
    common_quadratic,
    poly_quadratic,
    rounded,
)
from design.robustness.certificates.sampled.switched import discrete
from design.robustness.certificates.sampled.words import Word, named, search_word
from design.robustness.loop_model import LoopModel
from plants.errors import InputError
from plants.linearisation import RATES

Array = NDArray[np.float64]

DEGREES = (4, 6)
"""Degrees of the forms that are tried where there is no dead time."""

LEAST = 1e-4
"""Least decay that is asked for, as a share of that of the slowest vertex."""


STEPS = (11, 8)
"""Bisections of the decay, without and with dead time: to about 1 % and 4 % of itself."""


def vertices(model: LoopModel) -> dict[str, Array]:
    """The sampled loop at each slope and each end of the regulator's share, by name, each (3, 3);
    at the model's sample time.

    The matrix is affine in the slope and in the share, so that all between are in the convex hull.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> list(vertices(LoopModel.of(Wrist.flexion(), PI(1.2, 2.2))))[:2]
    ['transit at the slow rate', 'transit at the fast rate']
    """
    return {
        f"{branch} at the {rate} rate": model.sampled_matrix(slope, -np.log1p(-share) / model.dt)
        for branch, slope in model.distinct_slopes.items()
        for rate, share in zip(RATES, model.sampled_shares(), strict=True)
    }


def delay_samples(model: LoopModel, dead_time: float) -> int:
    """Whole samples of a dead time [s] and the plant's own, rounded up.

    Raises InputError for one that is negative or not finite.
    """
    if not (np.isfinite(dead_time) and dead_time >= 0.0):
        raise InputError(f"dead time {dead_time:g} s: give a finite one that is not negative")
    return ceil((dead_time + model.dead_time) / model.dt - 1e-9)


def certify_sampled(
    model: LoopModel, dead_times: tuple[float, ...] = (0.0, 0.05), word: Word | None = None
) -> list[Certificate]:
    """The rungs of the sampled loop, each with the best decay that bisection found.

    Without dead time: a common quadratic function, a poly-quadratic one and forms of the `DEGREES`.
    With dead times [s], rounded up to whole samples together with the plant's own: quadratic functions
    of the states, of the moments of the commands under way and of their squares (`window_quadratic`).
    word: one that `word_of` found, which is then given as the reason where nothing is certified; it
    proves that no such certificate exists, not that the real loop is unstable.
    Each is checked outside the solver; none that the check does not confirm is given.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> [c.holds for c in certify_sampled(LoopModel.of(Wrist.flexion(), PI(1.2, 2.2)), (0.0,))]
    [False, False, True, True]
    """
    found = []
    for dead_time in dead_times:
        samples = delay_samples(model, dead_time)
        rungs = _rungs(model) if samples == 0 else _delayed_rungs(model, samples)
        for name, search, high, back in rungs:
            found.append(_certificate(model, name, search, high, back, dead_time, samples, word))
    return found


def word_of(model: LoopModel, seed: int = 1) -> Word | None:
    """A word of slopes and rates that makes the sampled loop grow, None where the search finds none.

    Such a word shows that no certificate for arbitrary switching of slopes and rates exists for these
    gains.  It does not show that the real loop is unstable: there the rate is a function of q, and the
    slope follows the pressure.  That none is found proves nothing.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> word_of(LoopModel.of(Wrist.flexion(), PI(1.2, 2.2))) is None
    True
    """
    loops = vertices(model)
    system = discrete(list(loops.values()), model.dt)
    word = search_word(system, 2.0 * model.dt, 4.0 / model.k_slow, seed=seed)
    return named(word, list(loops)) if word.grows else None


Rung = tuple[str, Search, float, Array | None]
"""Name, search, loss that cannot be exceeded, and T of the states in which P is found, if P is of x."""


def _rungs(model: LoopModel) -> Iterator[Rung]:
    system = discrete(list(vertices(model).values()), model.dt)
    even, back = rounded(system)
    high = float(np.min(even.fates))
    yield "common quadratic", common_quadratic(even), high, back
    yield "poly-quadratic", poly_quadratic(even), high, None
    for degree in DEGREES:
        forms = lifted(even, degree // 2)
        name = f"forms of degree {degree}"
        yield name, common_quadratic(forms), float(np.min(forms.fates)), None


def delayed(model: LoopModel, samples: int) -> Delayed:
    """The vertices of the loop whose changes of command z = Kp (x0+ - x0) + Ki dt x0 enter q after so
    many samples; the other states move as they do without dead time.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> model = LoopModel.of(Wrist.flexion(), PI(1.2, 2.2))
    >>> np.allclose(delayed(model, 0).full[0], vertices(model)["transit at the slow rate"])
    True
    """
    entry, loops, reads = np.array([0.0, 0.0, 1.0]), [], []
    for matrix in vertices(model).values():
        z = model.Kp * (matrix[0] - np.array([1.0, 0.0, 0.0])) + np.array([model.Ki * model.dt, 0.0, 0.0])
        loops.append(matrix - np.outer(entry, z))
        reads.append(z / model.dt)
    return Delayed(tuple(loops), entry, tuple(reads), model.dt, samples)


def _delayed_rungs(model: LoopModel, samples: int) -> Iterator[Rung]:
    loop = delayed(model, samples)
    high = float(np.min(discrete(loop.full, loop.dt).fates))
    yield "common quadratic", window_quadratic(loop), high, None
    yield "poly-quadratic", window_quadratic(loop, follows=True), high, None


def _certificate(
    model: LoopModel, name: str, search: Search, high: float, back: Array | None, dead_time: float,
    samples: int, word: Word | None,
) -> Certificate:  # fmt: skip
    about = LoopClass(Switching.EVERY_SAMPLE, rates(model), slopes(model), samples=samples)
    if high <= 0.0:
        return Certificate(name, about, dead_time, False, None, None, "", UnstableMode())
    calm = search(LEAST * high)
    if not calm.holds:
        against = word if word is not None and word.grows and samples == 0 else None
        return Certificate(
            name, about, dead_time, False, None, calm.margin, calm.solver, calm.reason, against
        )
    found = best(search, LEAST * high, high, STEPS[samples > 0])
    shape = None
    if back is not None:
        inverse = np.linalg.inv(back)
        shape = inverse.T @ found.shapes[0] @ inverse
    evidence = {"margin_at_least_decay": calm.margin, "least_decay": calm.rate, "samples": samples}
    return Certificate(
        name, about, dead_time, True, found.rate, found.margin, found.solver, shape=shape, evidence=evidence
    )
