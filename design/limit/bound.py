"""The lower bound: no command in the range settles sooner, or leaves a smaller IAE, than full throttle.

Claim.  Let y_k be the angle of a wrist under any commands v_k in the range, from a given state, and
Y_k the angle under full throttle in the direction of the step.  For a step in the plus direction
y_k <= Y_k at every sample k; in the minus direction y_k >= Y_k.

Proof (plus; minus is its mirror image).  The commands of full throttle are the largest at every sample,
and the states are equal at the start.  Where every stage is monotone (`design.limit.monotone`), the
order of commands carries over to pressures by induction on k, from there to z = h - s P and so to
h = z + s P, and from there to y.  Nothing is asked of the start: it may be at rest on either
line or between them, or moving.

The virgin curve is the exception.  Let commands v take the wrist off it.
(a) By line 1: at that sample P has passed the end of the dead zone; the pressure of full throttle is
    not below it, has passed it too, rises, and is on line 1, so that both the pressure and z
    of full throttle are the larger; from there on both are monotone.  Before, h = 0 <= H.
(b) By line 2, after a dip: not before the sample m at which full throttle *backwards* leaves the
    virgin curve (comparison of pressures, the other way).  At sample m - 1 that wrist has a
    pressure not below the one where line 2 is met, and an angle that is that of every virgin wrist.
    A wrist that starts there at m - 1, its virgin memory gone, with the z that line 2 has where it is met
    (or a little more) and full throttle that acts without delay, has from then on at every sample
    a pressure, z and angle not below those of any wrist that dipped.
So Y is the larger of two envelopes, straight and after a dip.  On the declared plants the second hardly
matters; where the dead zone is wide, the transit steep and the regulator quick, a dip is the faster way.

A settled wrist is inside the band, so it does not settle before the first sample at which Y is (settling
time: as `design.evaluation.metrics`, the first sample from which on the angle stays inside).  Its IAE is at
least the sum of max(0, reference - Y_k) dt.  That a wrist which is too fast leaves the band again raises the
bound of the settling time by a few samples where the step is steep (`design.limit.braking`); that of
the IAE knows nothing of it.
Quantisation, delay, noise and a controller's own sampling restrict the commands and keep the bound.
"""

from dataclasses import dataclass

import numpy as np

from design.limit.braking import knows, settles_after
from design.limit.monotone import claimed, driven, prompt, relaxed
from design.limit.replay import DURATION, Array
from plants.errors import InputError
from plants.kernel import pytrees as tree
from plants.kernel.batches import run_lanes
from plants.simulation.open_loop import OpenLoop, SampledOpenLoop, law, surroundings
from plants.wrist import State, Wrist


@dataclass(frozen=True)
class Bound:
    """What no command in the range can beat: settling_s [s] (infinite where the band is not reached at
    all), iae [deg s], and the envelope [deg] (samples,) that the angle cannot pass; from the first sample
    at which it is not claimed, if any, it is infinite."""

    settling_s: float
    iae: float
    envelope: Array


def bound(wrist: Wrist, reference: float, state: State | None = None, begin: float = 0.0) -> Bound:
    """Lower bound of settling time and IAE of a step to a reference [deg] from a state (rest where not
    given), which may be moving, at a time [s].

    Raises InputError for a step of no size, and for a wrist that is not known to be monotone.

    >>> from plants import Wrist
    >>> found = bound(Wrist.flexion(), 15.0)
    >>> found.settling_s, round(found.iae, 3)
    (0.256, 2.309)
    """
    state = wrist.rest() if state is None else state
    size = float(reference - state.angle)
    if size == 0.0 or not np.isfinite(size):
        raise InputError(f"limit: a step from {state.angle:g} to {reference:g} deg has no size; give another")
    sign, samples = float(np.sign(size)), round(DURATION / wrist.rig.sample_time)
    fastest = _envelope(wrist, state, sign, samples, begin)
    left = sign * (reference - fastest.angle)
    band = wrist.rig.task.band * abs(size)
    near = np.flatnonzero(left < band)
    entry = int(near[0]) if len(near) else None
    if entry is not None and knows(wrist, state, reference, sign):
        pressure, static = fastest.pressure, fastest.memory.h
        entry = settles_after(wrist, entry, float(state.angle), reference, band, pressure, static)
    return Bound(
        float("inf") if entry is None else entry * wrist.rig.sample_time,
        float(np.maximum(left, 0.0).sum()) * wrist.rig.sample_time,
        np.asarray(fastest.angle, float),
    )


def _envelope(wrist: Wrist, state: State, sign: float, samples: int, begin: float) -> State:
    """Pressure, static angle and angle that no command passes in the direction of `sign`, (samples,)."""
    monotone, start = relaxed(wrist, state)
    ahead, back = wrist.rig.command_range[::-1] if sign > 0 else wrist.rig.command_range
    straight, _ = _throttle(monotone, start, ahead, samples, begin)
    static, angle = sign * straight.memory.h, sign * straight.angle
    if monotone.hysteresis.DEAD_ZONE and start.memory.virgin:
        dip, _ = _throttle(monotone, start, back, samples, begin)
        left = np.flatnonzero(dip.memory.virgin < 0.5)
        if len(left):
            m = int(left[0])
            _, ready = _throttle(monotone, start, back, m - 1, begin)
            # Its z is that of line 2 at the pressure of sample m, which is past the one where that is met.
            raised = monotone.hysteresis.flattest * (
                driven(monotone, ready.pressure) - driven(monotone, dip.pressure[m])
            )
            ready_to_go, ready = prompt(monotone, ready)
            left_it = monotone.hysteresis.doubted(ready.memory, True)
            ready = ready._replace(memory=left_it._replace(h=float(raised)))
            later = begin + (m - 1) * wrist.rig.sample_time
            dipped, _ = _throttle(ready_to_go, ready, ahead, samples - m + 1, later)
            static[m - 1 :] = np.maximum(static[m - 1 :], sign * dipped.memory.h)
            angle[m - 1 :] = np.maximum(angle[m - 1 :], sign * dipped.angle)
    until = claimed(wrist)
    if until is not None:
        angle[until:] = np.inf
    return State(straight.pressure, straight.memory._replace(h=sign * static), sign * angle)


def _throttle(wrist: Wrist, state: State, command: float, samples: int, begin: float) -> tuple[State, State]:
    """The wrist before each of some samples of one command [V], as a state of arrays (samples,), of which
    pressure, loop and angle are filled; and after the last."""
    given = {"command": np.full(samples, command), **surroundings(wrist, samples, begin)}
    last, rows = run_lanes(
        law(tuple(given)), OpenLoop(state), SampledOpenLoop(wrist.sampled(), wrist.rig.sample_time), samples,
        given, inputs=tuple(given), every=1,
        record=tuple(f"plant.{n}" for n in tree.names(state) if not n.startswith("effects")), jobs=1,
    )  # fmt: skip
    bare = state._replace(effects=())
    ends = tree.like(last.plant, [float(x[0]) for x in tree.leaves(last.plant)])
    return tree.like(bare, list(rows[:, :-1, 0])), ends
