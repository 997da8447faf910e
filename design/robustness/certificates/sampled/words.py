"""Words: orders of switching that make a switched system grow, so that nothing can prove it stable.

A word is a sequence of modes, each held for its dwell time and then begun again.  A spectral radius
of its product above 1 means that who repeats the word makes the state grow without bound; that of any
word, per step, bounds the joint spectral radius from below (Daubechies & Lagarias 1992; Jungers 2009,
The Joint Spectral Radius).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.sampled.switched import Switched

Array = NDArray[np.float64]

GRIDS = {1: 1, 2: 24, 3: 10, 4: 6}
"""Dwell times tried a letter, by the number of letters of a word, before the best are refined."""

WORTH = 0.02
"""By what share of its growth a word has to be beaten by a longer one."""

REFINED = 2
"""Words of each number of letters that the optimiser refines."""


@dataclass(frozen=True)
class Word:
    """A periodic order of switching.

    letters: modes in the order in which they act; dwells: how long each is held, in the system's unit
    of time (steps of a discrete one); radius: spectral radius of one pass; names: of the letters.
    """

    letters: tuple[int, ...]
    dwells: tuple[float, ...]
    radius: float
    names: tuple[str, ...] = ()

    @property
    def growth(self) -> float:
        """Rate [1 / unit of time] at which the state grows under the word; negative where it decays."""
        return float(np.log(max(self.radius, 1e-300)) / sum(self.dwells))

    @property
    def radius_per_time(self) -> float:
        """Spectral radius per unit of time."""
        return float(np.exp(self.growth))

    @property
    def grows(self) -> bool:
        """Whether the word makes the state grow, by more than rounding could pretend."""
        return self.radius > 1.0 + 1e-9

    def __str__(self) -> str:
        names = self.names or tuple(f"mode {k}" for k in self.letters)
        held = ", then ".join(f"{d:.3g} s of {n}" for d, n in zip(self.dwells, names, strict=True))
        cycle = f"the state is multiplied by {self.radius:.3g} per cycle ({self.growth:+.3g} 1/s)"
        return f"{held}, repeated: {cycle}"


def necklaces(letters: int, length: int) -> Iterator[tuple[int, ...]]:
    """Words of a length, one of each class of rotations: its first in the order of the dictionary.

    >>> list(necklaces(2, 3))
    [(0, 0, 0), (0, 0, 1), (0, 1, 1), (1, 1, 1)]
    """
    # The algorithm of Fredricksen, Kessler & Maiorana, in the form of Ruskey, Combinatorial
    # Generation: a prenecklace is extended by its own period or by a larger letter.
    word = [0] * (length + 1)

    def extend(t: int, period: int) -> Iterator[tuple[int, ...]]:
        if t > length:
            if length % period == 0:
                yield tuple(word[1:])
            return
        word[t] = word[t - period]
        yield from extend(t + 1, period)
        for letter in range(word[t - period] + 1, letters):
            word[t] = letter
            yield from extend(t + 1, t)

    yield from extend(1, 1)


def radii(matrices: Array) -> Array:
    """Spectral radii of matrices of shape (..., n, n), shape (...)."""
    return np.asarray(np.max(np.abs(np.linalg.eigvals(matrices)), axis=-1))


def discrete_word(matrices: list[Array], length: int = 8, most: int = 50_000) -> Word:
    """The word of up to `length` letters with the largest spectral radius a step, of x+ = A_i x.

    Every necklace is tried, powers of letters among them; lengths of which there are more than `most`
    words are left out.  Raises ValueError where there are no matrices.

    >>> word = discrete_word([np.array([[1.0, 1], [0, 1]]), np.array([[1.0, 0], [1, 1]])], 4)
    >>> word.letters, round(word.radius_per_time, 6)
    ((0, 1), 1.618034)
    """
    every = np.array(matrices, float)
    found: Word | None = None
    for n in range(1, length + 1):
        if len(every) ** n > n * most:
            break
        words = np.array(list(necklaces(len(every), n)))
        total = every[words[:, 0]]
        for k in range(1, n):
            total = every[words[:, k]] @ total
        values = radii(total)
        k = int(np.argmax(values))
        word = Word(tuple(map(int, words[k])), (1.0,) * n, float(values[k]))
        # A longer word has to be better by more than rounding: the square of a word is none.
        if found is None or word.growth > found.growth + 1e-12:
            found = word
    if found is None:
        raise ValueError("discrete_word: no matrices")
    return found


def search_word(
    system: Switched, shortest: float, longest: float, letters: int = 4, seed: int = 1, shrink: int = 1
) -> Word:
    """The word of up to `letters` letters that makes the state grow fastest, with its dwell times.

    Words in which no letter follows itself are tried on a grid of dwell times between `shortest` and
    `longest`; the best are refined by differential evolution in the dwell times' logarithms (Storn &
    Price 1997), which are whole numbers of steps in a sampled system.  shrink: divides the grids and
    the populations, for large systems.  The best word is returned whether it grows or decays; a search
    that finds none that grows proves nothing.
    """
    modes = len(system.generators)
    hold = _holder(system, longest)
    shortest = max(shortest, system.dt)
    found = [_measured(system, (i,), (shortest,)) for i in range(modes)]
    for n in range(2, letters + 1):
        words = [w for w in necklaces(modes, n) if all(a != b for a, b in pairwise((*w, w[0])))]
        if not words:
            continue
        grid = np.geomspace(shortest, longest, max(GRIDS.get(n, 5) // shrink, 4))
        held = [hold(i, grid) for i in range(modes)]
        tried = [_best_on_grid(system, w, grid, held) for w in words]
        tried.sort(key=lambda w: -w.growth)
        found += [_refined(system, w, shortest, longest, hold, seed, shrink) for w in tried[:REFINED]]
    # A longer word has to be worth it: not the same one with a letter held for a few samples more.
    best = found[0]
    for word in found[1:]:
        worth = WORTH * abs(best.growth) if len(word.letters) > len(best.letters) else 0.0
        best = word if word.growth > best.growth + worth else best
    return best


Holder = Callable[[int, Array], Array]
"""Matrices of mode i held for times of shape (m,), shape (m, n, n)."""


def _holder(system: Switched, longest: float) -> Holder:
    if system.dt == 0.0:
        from scipy.linalg import expm

        return lambda i, times: np.asarray(expm(times[:, None, None] * system.generators[i]))
    # Powers by squaring, the bits of the exponents looked up in a table: exact in the exponent.
    n = len(system.generators[0])
    bits = int(np.ceil(np.log2(longest / system.dt + 2.0))) + 1
    table = []
    for m in system.generators:
        squares = [np.eye(n) + system.dt * m]
        for _ in range(bits - 1):
            squares.append(squares[-1] @ squares[-1])
        table.append(squares)

    def hold(i: int, times: Array) -> Array:
        steps = np.maximum(np.rint(times / system.dt), 1.0).astype(np.int64)
        total = np.broadcast_to(np.eye(n), (len(times), n, n)).copy()
        for k, square in enumerate(table[i]):
            chosen = (steps >> k) & 1 == 1
            total[chosen] = square @ total[chosen]
        return total

    return hold


def _times(system: Switched, times: Array) -> Array:
    """Dwell times as they can be: whole numbers of steps in a sampled system."""
    return times if system.dt == 0.0 else np.maximum(np.rint(times / system.dt), 1.0) * system.dt


def _best_on_grid(system: Switched, word: tuple[int, ...], grid: Array, held: list[Array]) -> Word:
    total, times = held[word[0]], _times(system, grid)
    duration = times
    for letter in word[1:]:
        total = np.einsum("gij,...jk->...gik", held[letter], total)
        duration = duration[..., None] + times
    growth = np.log(np.maximum(radii(total), 1e-300)) / duration
    place = np.unravel_index(int(np.argmax(growth)), growth.shape)
    return _measured(system, word, tuple(float(grid[k]) for k in place))


def _refined(
    system: Switched, word: Word, shortest: float, longest: float, hold: Holder, seed: int, shrink: int
) -> Word:
    from scipy.optimize import differential_evolution

    def decay(logs: Array) -> Array:
        times = np.exp(logs.reshape(len(word.letters), -1))
        total = hold(word.letters[0], times[0])
        for letter, dwell in zip(word.letters[1:], times[1:], strict=True):
            total = hold(letter, dwell) @ total
        growth = np.log(np.maximum(radii(total), 1e-300)) / np.sum(_times(system, times), axis=0)
        return np.asarray(-growth)

    start = np.log(np.clip(word.dwells, shortest, longest))
    result = differential_evolution(
        decay, [(np.log(shortest), np.log(longest))] * len(word.letters), x0=start,
        maxiter=60 // shrink, popsize=max(12 // shrink, 6), rng=seed, polish=False, vectorized=True,
        updating="deferred",
    )  # fmt: skip
    refined = _measured(system, word.letters, tuple(float(t) for t in np.exp(result.x)))
    return max(word, refined, key=lambda w: w.growth)


def _measured(system: Switched, letters: tuple[int, ...], dwells: tuple[float, ...]) -> Word:
    """The word with its spectral radius, from powers or exponentials of their own."""
    from scipy.linalg import expm

    times = tuple(float(t) for t in _times(system, np.array(dwells)))
    total = np.eye(len(system.generators[0]))
    for letter, time in zip(letters, times, strict=True):
        m = system.generators[letter]
        if system.dt == 0.0:
            total = expm(time * m) @ total
        else:
            total = np.linalg.matrix_power(np.eye(len(m)) + system.dt * m, round(time / system.dt)) @ total
    return Word(letters, times, float(radii(total)))


def named(word: Word, names: list[str]) -> Word:
    """The word with the names of its letters, one name a mode."""
    return replace(word, names=tuple(names[k] for k in word.letters))
