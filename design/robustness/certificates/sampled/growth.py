"""How a loop's state grows under a word of branches and rates, and decays under each letter alone."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.sampled.sampled_loop import vertices
from design.robustness.certificates.sampled.words import Word
from design.robustness.loop_model import LoopModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Growth:
    """Size of the state as a ratio to the first pass, each (rows,), at times [s]: under the word, again and
    again, and under each of its letters alone, by name; ends [s]: of the passes, but for the last."""

    time: Array
    word: Array
    alone: Mapping[str, Array]
    ends: Array


def growth_of(model: LoopModel, word: Word, passes: int = 8) -> Growth:
    """Growth of the state under a switching sequence (a word), from the direction that grows most."""
    loops = vertices(model)
    letters = [(loops[n], round(d / model.dt)) for n, d in zip(word.names, word.dwells, strict=True)]
    samples = sum(count for _, count in letters)
    once = played(np.eye(len(letters[0][0])), letters)[-1]
    values, vectors = np.linalg.eig(once)
    start = np.real(vectors[:, int(np.argmax(np.abs(values)))])
    under = played(start, letters * passes)
    unit = np.abs(under[: samples + 1]).max(axis=0)  # of each state, the most of the first pass
    alone = {n: played(start, [(loops[n], samples * passes)]) for n in dict.fromkeys(word.names)}
    return Growth(
        np.asarray(model.dt * np.arange(len(under)), float),
        np.abs(under / unit).max(axis=1),
        {n: np.abs(states / unit).max(axis=1) for n, states in alone.items()},
        np.asarray(np.arange(1, passes) * samples * model.dt, float),
    )


def played(start: Array, letters: list[tuple[Array, int]]) -> Array:
    """States (samples + 1, ...) from a state (n,), or the columns of (n, m), under matrices (n, n),
    each for so many samples."""
    states = [np.asarray(start, float)]
    for matrix, count in letters:
        for _ in range(count):
            states.append(matrix @ states[-1])
    return np.array(states)
