"""Test vectors: what an exported law is given in 10,000 samples, and what it answered in Python.

The signals come from a loop that is closed around the wrist, with noise and quantisation, so that they are
what the target will see: references of every kind, some out of reach, and measurements that are lost.
"""

from collections.abc import Iterator
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.measurement.plausible import LastBelieved, believed
from design.export.part import SEEN_BY_HAND, Part, Seen, SeenByHand
from design.mpc.observer import begin
from design.mpc.prediction import coefficients, roll, start_of
from design.mpc.problem import MPCProblem
from plants.errors import InputError
from plants.kernel import pytrees as tree
from plants.wrist import SAMPLE_TIME, Wrist

Array = NDArray[np.float64]

STEPS = 10_000
NOISE_DEG, QUANTUM_DEG, NOISE_KPA = 0.07, 0.01, 0.2
OUT_OF_REACH = 0.9
"""Share of the widest reference that is believed: drives any law to both ends of its range."""

LOST = 12
"""Samples in which one of the inputs is lost."""

NUDGE = 1e-9
"""Change of a reading that a law is to forget."""

SPIKES = (1e9, -1e9, 1e300, -1.7e308, 1e4, -1e3)
"""Readings that no plant can have made; as many samples again hold one that jumped within the range."""


class Vector(NamedTuple):
    """Pressure [kPa] and angle [deg] of the start; rows of what is seen, reference, angle, pressure, and
    expected output, shape (steps, 4), or (steps, 6) where it may be commanded by hand."""

    pressure: float
    angle: float
    rows: Array


def references(steps: int, period: float, far: tuple[float, float], draw: np.random.Generator) -> Array:
    """A reference [deg] for each step: jumps, also out of reach (far, upwards and downwards), a chirp, ramps,
    rest."""
    t = np.arange(steps) * SAMPLE_TIME  # a slow law gets as many samples of each kind
    hold = max(60, round(0.4 / period))
    levels = draw.uniform(-25.0, 25.0, steps // hold + 4)
    levels[2:4] = far
    jumps = np.repeat(levels, hold)[:steps]
    chirp = 12.0 * np.sin(2.0 * np.pi * (0.2 + 0.15 * t) * t)
    ramps = 20.0 * np.abs((t / 2.0) % 2.0 - 1.0) - 10.0
    part = np.minimum(np.arange(steps) * 4 // steps, 3)
    return np.where(part == 0, jumps, np.where(part == 1, chirp, np.where(part == 2, ramps, jumps)))


class TargetReplay:
    """The law in Python as a target runs it: its state, its delay lines, and its output held where a
    measurement is lost.  One state at a time, as on the target."""

    def __init__(self, part: Part) -> None:
        self.part, self.state, self.output = part, None, 0.0
        self.lines: list[list[float]] = []
        self.last: list[LastBelieved] = []
        self.watched = part.watched

    def begin(self, pressure: float, angle: float) -> float:
        """Start from rest at a pressure [kPa] and an angle [deg]; the output that holds it.  Where they
        cannot be, the plant is taken to rest as it is built."""
        pressure, angle, _ = self.part.sensors.start(pressure, angle)
        self.state, output = self.part.begin(pressure, angle)
        self.output = self.part.within(output)
        self.last = [LastBelieved((0.0, angle, pressure)[w.place]) for w in self.watched]
        leaves = tree.leaves(self.state)
        self.lines = [[leaves[row + 2]] * (samples + 1) for row, samples in self.part.delays]
        return self.output

    def step(self, seen: Seen | SeenByHand) -> float:
        """The output of one sample."""
        # What the law does not read may be lost, and is nothing to it.
        fields = zip(SEEN_BY_HAND, seen, strict=False)
        seen = self.part.seen(*(x if f in self.part.inputs else 0.0 for f, x in fields))
        seen = self.believed(seen)
        if isinstance(seen, SeenByHand):
            seen = self.by_hand(seen)
        if not self.part.takes_lost and not all(isfinite(x) for x in seen):
            return self.output
        if not self.part.delays:
            self.state, output = self.part.step(self.state, seen)
            self.output = self.part.within(output)
            return self.output
        leaves = tree.leaves(self.state)
        for (row, samples), line in zip(self.part.delays, self.lines, strict=True):
            # The line's end is the newest: `samples` steps ago, and one before that.
            leaves[row], leaves[row + 1] = line[-samples] if samples else line[-1], line[-samples - 1]
        self.state, output = self.part.step(tree.like(self.state, leaves), seen)
        self.output = self.part.within(output)
        after = tree.leaves(self.state)
        for (row, samples), line in zip(self.part.delays, self.lines, strict=True):
            line.append(float(after[row + 2]))
            del line[: -(samples + 1)]
        return self.output

    def by_hand(self, seen: SeenByHand) -> SeenByHand:
        """What is seen, with values that do nothing where none is needed: by hand the command goes through,
        whatever the sensors show."""
        told = seen.manual_command if isfinite(seen.manual_command) else self.output
        if not (isfinite(seen.manual) and seen.manual > 0.5):
            return seen._replace(manual_command=told)
        angle = next(last.value for w, last in zip(self.watched, self.last, strict=True) if w.place == 1)
        reference = seen.reference if isfinite(seen.reference) else angle
        return seen._replace(reference=reference, angle=angle, manual_command=told)

    def believed(self, seen: Any) -> Any:
        """What is seen, a value that cannot be believed being no number."""
        values = list(seen)
        for i, w in enumerate(self.watched):
            self.last[i], good = believed(self.last[i], values[w.place], w.channel)
            values[w.place] = values[w.place] if good else nan
        if not self.part.sensors.angle.holds(seen.reference):
            values[0] = nan
        return self.part.seen(*values)


def vector(part: Part, wrist: Wrist, steps: int = STEPS, seed: int = 0) -> Vector:
    """A test vector of a law, in a loop around a wrist, behind the dead time that a law has in its model.

    Raises InputError for a law whose dead time makes it unstable by itself.

    An observer, which commands nothing, watches the wrist follow the reference under the command that
    would hold it in the end.
    """
    draw = np.random.default_rng(seed)
    widest = part.sensors.angle
    asked = references(steps, part.period, (OUT_OF_REACH * widest.high, OUT_OF_REACH * widest.low), draw)
    lost = draw.choice(steps, LOST, replace=False)
    which = dict(zip(lost.tolist(), draw.integers(0, 3, LOST).tolist(), strict=True))
    spikes = spoiled(part, steps, np.random.default_rng((seed, 1)))
    at = float(wrist.hysteresis.rest_pressure), 0.0
    held, c = MPCProblem(wrist, period=part.period), coefficients(wrist)
    state = start_of(begin(at[1], at[0], wrist))
    law = TargetReplay(part)
    under_way = [law.begin(*at)] * part.under_way
    rows = np.empty((steps, 1 + len(part.seen._fields)))
    hands = by_hand(part, steps, np.random.default_rng((seed, 2)))
    for k, (noise, hiss) in enumerate(draw.standard_normal((steps, 2))):
        angle = np.round((float(state[-1]) + NOISE_DEG * noise) / QUANTUM_DEG) * QUANTUM_DEG
        seen = [float(asked[k]), float(angle), float(state[0]) + NOISE_KPA * hiss]
        if k in which:
            seen[which[k]] = np.nan
        if k in spikes:
            place, value, added = spikes[k]
            seen[place] = value + added * seen[place]
        seen += hands[k]
        output = law.step(part.seen(*seen))
        rows[k] = *seen, output
        under_way.append(output if part.output.unit == "V" else _open_loop(wrist, float(asked[k])))
        state = roll(held, c, state, 0.0, np.array([under_way.pop(0)]))[0]
    found = Vector(*at, rows)
    if part.under_way and (off := apart(part, found)) > part.tolerance:
        raise InputError(
            f"{part.title}: unstable by itself behind the dead time of its model: a reading {NUDGE:g} "
            f"{part.inputs[1].unit} beside changes later commands by up to {off:.1g} {part.output.unit}, so "
            "that no target could be compared with Python; give a larger weight of moves"
        )
    return found


def apart(part: Part, found: Vector) -> float:
    """How far an output comes to be off, in a replay of a test vector whose first angle is nudged.

    A predictor feeds the commands that it gave back to itself, and may be unstable in a loop that is stable:
    of samples that are given, rounding grows to anything.
    """
    law, worst = TargetReplay(part), 0.0
    law.begin(found.pressure, found.angle)
    for k, (*seen, output) in enumerate(found.rows.tolist()):
        seen[1] += NUDGE if k == 0 else 0.0
        worst = max(worst, abs(law.step(part.seen(*seen)) - output))
    return worst


def by_hand(part: Part, steps: int, draw: np.random.Generator) -> list[list[float]]:
    """For each step whether the command is by hand, and which one [V], beyond the range too and now and then
    no number; nothing for a part that cannot be commanded by hand."""
    if not part.by_hand or part.low is None or part.high is None:
        return [[]] * steps
    turns = np.repeat(draw.integers(0, 2, steps // 60 + 1), 60)[:steps].astype(float)
    width = part.high - part.low
    jumps = np.repeat(draw.uniform(part.low - 0.2 * width, part.high + 0.2 * width, steps // 40 + 1), 40)
    turns[draw.choice(steps, steps // 400, replace=False)] = np.nan
    told = jumps[:steps]
    told[draw.choice(steps, steps // 100, replace=False)] = np.nan
    return np.column_stack([turns, told]).tolist()  # type: ignore[no-any-return]


def spoiled(part: Part, steps: int, draw: np.random.Generator) -> dict[int, tuple[int, float, float]]:
    """Samples with a reading that cannot be: which input, and value + share of the true one in its place."""
    far = {1: part.sensors.angle, 2: part.sensors.pressure}
    when = draw.choice(np.arange(1, steps), 2 * len(SPIKES), replace=False).tolist()
    found = {k: (int(draw.integers(0, 3)), value, 0.0) for k, value in zip(when, SPIKES, strict=False)}
    for k in when[len(SPIKES) :]:
        place = int(draw.integers(1, 3))
        found[k] = (place, 0.6 * (far[place].high - far[place].low) / 2.0, 1.0)
    return found


def _open_loop(wrist: Wrist, reference: float) -> float:
    """The command [V] at which the middle of the loop stands at the reference, within the range."""
    p = wrist.hysteresis
    pressure = p.rest_pressure + reference / (0.5 * sum(p.steepness))
    return float(np.clip(pressure / wrist.regulator.gain, *wrist.rig.command_range))


def csv(part: Part, found: Vector) -> str:
    """The vector as a table, numbers as exact as they are; of the inputs only those that the law reads."""
    columns = [SEEN_BY_HAND.index(f) for f in part.inputs]
    head = ",".join([f.member for f in part.inputs] + [f"expected_{part.output.member}"])

    def lines() -> Iterator[str]:
        for row in found.rows:
            yield ",".join(repr(float(x)) for x in (*row[columns], row[-1]))

    return head + "\n" + "\n".join(lines()) + "\n"
