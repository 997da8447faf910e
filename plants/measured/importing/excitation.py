"""Which runs are fitted on and which are held out: not one excitation twice."""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plants.measured.formats.channel import Array

ALIKE = 0.6
"""Distance of two excitations below which they are one and the same."""

VALIDATE = 0.34
"""Share of the logs that is kept for reporting the error."""

PER_PERIOD, CORNERS = 24, 0.85
"""Points per period at which the bends of a command are looked at, and share of all bending that the sharpest
quarter of them holds where it moves in ramps: of a sine that is 0.38."""

TURNS = 0.4
"""Share of its steps at which a command turns, from which on they are random: about half-way between those of
a staircase that goes up and down a few times and of levels drawn at random."""

HELD_OUT = frozenset(
    ("val", "valid", "validate", "validation", "holdout", "heldout", "check", "unseen", "pruefung", "prüfung")
)
TRAIN = frozenset(("train", "training"))
"""Words in the name of a run that say what it is for."""


class Excited(NamedTuple):
    """How a run's command moves: low and high [V], typical frequency [Hz], share of rows in which it changes,
    and the largest part of its changes that one row holds; what it looks like, in a word."""

    low: float
    high: float
    frequency: float
    moving: float
    jump: float
    word: str


class Chosen(NamedTuple):
    """Places of the runs to fit on and of those to hold out, and why."""

    fit: tuple[int, ...]
    validate: tuple[int, ...]
    why: str


def excited(time: Array, command: Array) -> Excited:
    """How a command (n,) moves over time [s] (n,).

    >>> t = np.arange(3000) / 100
    >>> excited(t, 2.0 + np.sin(t)).word, excited(t, 1.0 + np.floor(t / 5.0) % 2).word
    ('sine', 'steps')
    >>> excited(t, np.exp(-t / 20) * np.arcsin(np.sin(t))).word
    'ramps'
    """
    low, high = float(command.min()), float(command.max())
    moved = np.diff(command)
    total = float(np.abs(moved).sum()) or 1.0
    power = np.abs(np.fft.rfft((command - command.mean()) * np.hanning(len(command)))) ** 2
    frequencies = np.fft.rfftfreq(len(command), float(np.median(np.diff(time))))
    centre = float((power * frequencies).sum() / max(power.sum(), 1e-300))
    share, jump = float(np.mean(moved != 0.0)), float(np.abs(moved).max()) / total
    line = int(np.argmax(power))
    concentrated = power[max(0, line - 2) : line + 3].sum() / max(power.sum(), 1e-300)
    levels = len(np.unique(np.round(command, 6)))
    if share < 0.1:
        word = "steps" if levels <= 8 else "random steps" if _turns_often(command) else "staircase"
    elif line > 1 and _bends_at_corners(time, command, float(frequencies[line])):
        word = "ramps"
    elif concentrated > 0.9 and line > 1:
        word = "sine"
    else:
        word = "sweep or noise"
    return Excited(low, high, centre, share, jump, word)


def _turns_often(command: Array) -> bool:
    """Whether a command that moves in steps turns back after a good part of them: of a staircase few do, of
    levels drawn at random two thirds (Bienaymé 1874, turning points)."""
    held = command[:-1][np.diff(command) == 0.0]
    ways = np.sign(np.diff(held))
    ways = ways[ways != 0.0]
    return len(ways) > 1 and bool(np.mean(ways[1:] != ways[:-1]) > TURNS)


def _bends_at_corners(time: Array, command: Array, frequency: float) -> bool:
    """Whether a command of a frequency [Hz] bends nearly at corners alone, as a triangle or a trapezoid."""
    even = np.arange(time[0], time[-1], 1.0 / (PER_PERIOD * frequency))
    bends = np.sort(np.abs(np.diff(np.interp(even, time, command), 2)))[::-1]
    return bool(bends[: len(bends) // 4].sum() > CORNERS * bends.sum())


def choose(asked: Sequence[Excited], names: Sequence[str] = ()) -> Chosen:
    """Hold out what the names of the runs say is held out; where none does, fit on the widest excitation, and
    hold out what differs most from it within its range, about a third.

    >>> staircase = Excited(0.0, 4.0, 0.02, 0.01, 0.05, "staircase")
    >>> sine = Excited(0.5, 3.5, 0.1, 1.0, 0.001, "sine")
    >>> choose([sine, sine, staircase])[:2]
    ((2,), (0, 1))
    >>> choose([sine, sine, staircase], ["sine", "sineVal2", "staircase"])[:2]
    ((0, 2), (1,))
    """
    named = _named_held_out(names)
    if named:
        fit = tuple(i for i in range(len(asked)) if i not in named)
        return Chosen(fit, named, "those are held out whose names say so")
    if len(asked) == 1:
        return Chosen((0,), (), "one run: its first part is fitted on and the rest is held out")
    groups = _groups(asked)
    if len(groups) == 1:
        held = max(1, round(VALIDATE * len(asked)))
        fit, last = tuple(range(len(asked) - held)), tuple(range(len(asked) - held, len(asked)))
        why = "all runs ask the same of the rig: the last are held out, and say little of other motion"
        return Chosen(fit, last, why)
    span = (
        np.array([min(asked[i].low for i in g) for g in groups]),
        np.array([max(asked[i].high for i in g) for g in groups]),
    )
    widths = span[1] - span[0]
    held_out: list[list[int]] = []
    left = sorted(groups, key=lambda g: (widths[groups.index(g)], -len(g)))
    # From the narrowest on, so that what is held out lies within what was fitted on.
    while len(left) > 1 and sum(map(len, held_out)) + len(left[0]) <= max(1, round(0.5 * len(asked))):
        if held_out and sum(map(len, held_out)) >= VALIDATE * len(asked):
            break
        held_out.append(left.pop(0))
    if not held_out:
        held_out.append(left.pop(0))
    validate = tuple(sorted(i for g in held_out for i in g))
    fit = tuple(i for i in range(len(asked)) if i not in validate)
    words = [" and ".join(sorted({asked[i].word for i in part})) for part in (fit, validate)]
    return Chosen(
        fit, validate, f"fitted on {words[0]}, held out {words[1]}: another excitation, in a narrower range"
    )


def _named_held_out(names: Sequence[str]) -> tuple[int, ...]:
    """Places of the names that say of a run that it is to validate a model; none where all do or none does.
    A test is one beside runs to train on: alone the word says nothing."""
    words = [{w.lower() for w in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", n)} for n in names]
    said = HELD_OUT | ({"test"} if any(own & TRAIN for own in words) else set())
    found = tuple(i for i, own in enumerate(words) if own & said)
    return found if len(found) < len(names) else ()


def _groups(asked: Sequence[Excited]) -> list[list[int]]:
    """Runs whose commands are alike, together."""
    from scipy.cluster.hierarchy import fcluster, linkage

    full = max(a.high for a in asked) - min(a.low for a in asked) or 1.0
    features = np.array(
        [
            (a.low / full, a.high / full, np.log(max(a.frequency, 1e-4)), 2.0 * a.moving, 2.0 * a.jump)
            for a in asked
        ]
    )
    labels = fcluster(linkage(features, "complete"), ALIKE, "distance")
    return [[i for i in range(len(asked)) if labels[i] == k] for k in dict.fromkeys(labels.tolist())]
