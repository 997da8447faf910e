"""Figures that only the notebooks draw."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.sampled.sampled_loop import vertices
from design.robustness.certificates.sampled.words import Word
from design.robustness.loop_model import LoopModel
from plants.wrist import SAMPLE_TIME
from reports.shared.style import GREY, LINES, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


def word_growth(model: LoopModel, word: Word, passes: int = 8) -> "Figure":
    """The state of a loop under a word of branches and rates, again and again, and under each of its
    letters alone, from the direction that grows most under the word; lines where a pass ends."""
    loops = vertices(model)
    letters = [(loops[n], round(d / SAMPLE_TIME)) for n, d in zip(word.names, word.dwells, strict=True)]
    samples = sum(count for _, count in letters)
    once = played(np.eye(len(letters[0][0])), letters)[-1]
    values, vectors = np.linalg.eig(once)
    start = np.real(vectors[:, int(np.argmax(np.abs(values)))])
    under = played(start, letters * passes)
    unit = np.abs(under[: samples + 1]).max(axis=0)  # of each state, the most of the first pass
    time = SAMPLE_TIME * np.arange(len(under))
    with styled():
        figure, (axes,) = new_figure(height=3.4)
        for look, name in zip(LINES[1:], dict.fromkeys(word.names), strict=False):
            alone = played(start, [(loops[name], samples * passes)])
            axes.semilogy(time, np.abs(alone / unit).max(axis=1), label=f"only {name}", **look)
        axes.semilogy(
            time,
            np.abs(under / unit).max(axis=1),
            label="the word",
            zorder=5,
            **{**LINES[0], "linewidth": 2.2},
        )
        for end in np.arange(1, passes) * samples * SAMPLE_TIME:
            axes.axvline(end, color=GREY, linewidth=0.6, zorder=0)
        axes.set(
            xlabel="Time [s]", ylabel="Size of the state,\nratio to the first pass [1]",
            xlim=(0.0, time[-1]), ylim=(1e-3, None),
        )  # fmt: skip
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def played(start: Array, letters: list[tuple[Array, int]]) -> Array:
    """States (samples + 1, ...) from a state (n,), or the columns of (n, m), under matrices (n, n),
    each for so many samples."""
    states = [np.asarray(start, float)]
    for matrix, count in letters:
        for _ in range(count):
            states.append(matrix @ states[-1])
    return np.array(states)
