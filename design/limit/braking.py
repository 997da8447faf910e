"""What the bound of the settling time knows of braking: a wrist that is too fast leaves the band again.

Claim (plus direction; minus is its mirror image).  Let a wrist be settled from sample T on: y_T > r - b,
and y_k < r + b ever after.  The lag is a filter with positive weights, so for any n

    y_(T+n) = keep^n y_T + sum w_i h_i,   sum w_i = 1 - keep^n,   hence at some i in [T, T + n]
    h_i <= H = (r + b - keep^n (r - b)) / (1 - keep^n).

From a static angle h at an earlier sample t and a pressure P, full throttle backwards is, at every later
sample, a lower envelope of pressure and static angle (`design.limit.monotone`).  There the angle is at least
the lower of two: the transit h - s (P - P'), P' being the pressure of the reversed throttle, and line 2
at P'.  The way P - P' that the pressure has fallen by grows with P, which is at most the pressure of
full throttle at t; and P is at least the pressure at which line 2 has the angle h.  So h_i <= H
within theta = T + n - t samples asks that

    h_t <= max(H + s fall_theta(P of full throttle at t), line2(rise_theta(P at which line2 = H))),

where rise undoes the reversed throttle.  With the envelope of `design.limit.bound`, h_t is at most
the lesser of the two, and y_T at most what the lag makes of that.  Where this does not come to r - b for
some n, no wrist is settled from T on.  That line 2 is met only after the transit is not used, and what
h_t may be is only narrowed down over the last `WINDOW` samples before T.
"""

from typing import Any

import numpy as np

from design.limit.replay import Array
from plants.actuator import regulator
from plants.dynamics import SampledWrist
from plants.hysteresis import FourSegment
from plants.wrist import State, Wrist

AFTER = (4, 6, 8, 11, 15, 20, 26, 33, 41, 50, 62)
"""Samples n after T at which the angle is asked to be inside the band still; any will do."""

WINDOW = 100
"""Samples before T over which braking is thought of."""

ROUNDING = 1e-6
"""What the angles [deg] that braking allows are widened by, far more than the rounding they come with."""

LATEST = 60
"""By how many samples the bound is raised at most."""


def knows(wrist: Wrist, state: State, reference: float, sign: float) -> bool:
    """Whether the claim is made for a wrist and its start: four straight segments; no effect but a dead
    time, which only makes braking later; no virgin curve beyond the reference; and lines that do not cross
    within the pressures of the commands, since the loop has no inside beyond that."""
    p, gain = wrist.hysteresis, wrist.regulator.gain
    ends = np.array([float(state.pressure), *(gain * v for v in wrist.rig.command_range)])
    return (
        isinstance(p, FourSegment)
        and all(e.DELAY for e in wrist.effects)
        and not (bool(state.memory.virgin) and sign * reference < 0.0)
        and bool(np.all(p.ascending(ends) <= p.descending(ends)))
    )


def settles_after(
    wrist: Wrist, first: int, start: float, reference: float, band: float, pressure: Array, static: Array
) -> int:
    """The first sample, not before `first`, from which on a wrist may be settled, or one that is not later.

    start, reference, band: angle at the start, reference and half-width of the band [deg]; pressure [kPa]
    and static [deg], (samples,): what no command passes in the direction of the step.
    """
    c, p, sign = wrist.sampled(), wrist.hysteresis, float(np.sign(reference - start))
    assert isinstance(p, FourSegment)
    back = wrist.rig.command_range[0] if sign > 0 else wrist.rig.command_range[1]
    last = first + LATEST
    if last + AFTER[-1] >= len(static):
        return first
    n = np.array(AFTER)
    kept = c.lag.keep**n
    goal = (sign * reference + band - kept * (sign * reference - band)) / (1.0 - kept)  # H, (n,)
    begin = max(first - WINDOW, 0)
    rise = _risen(c, p, sign, back, goal, last + AFTER[-1] - begin)
    fall = _fallen(c, back, pressure[begin : last + 1], last + AFTER[-1] - begin)
    ahead = sign * static
    for sample in range(first, last):
        rows, t = sample - begin + 1, np.arange(begin, sample + 1)
        reached = np.inf
        for i, after in enumerate(AFTER):
            by_transit = goal[i] + p.s * fall[rows - 1 + after, :rows]
            braked = np.maximum(rise[sample + after - t, i], by_transit) + ROUNDING
            most = np.concatenate([ahead[:begin], np.minimum(ahead[begin : sample + 1], braked)])
            reached = min(reached, _lagged(most, c))
        if c.lag.keep**sample * sign * start + reached > sign * reference - band:
            return sample
    return last


def _lagged(static: Array, c: SampledWrist) -> float:
    """What the lag makes of static angles [deg], (samples + 1,), from 0."""
    weights = c.lag.keep ** np.arange(len(static) - 2, -1, -1.0)
    return float(weights @ (c.lag.before * static[:-1] + c.lag.after * static[1:]))


def _fallen(c: SampledWrist, back: float, pressure: Array, samples: int) -> Array:
    """By how much [kPa] throttle backwards since sample t has moved the pressure by sample k: row k,
    column t."""
    moved, out = pressure.copy(), np.zeros((samples + 1, len(pressure)))
    for k in range(samples + 1):
        out[k] = np.abs(pressure - moved)
        moved[: k + 1] = regulator.step(moved[: k + 1], back, c.regulator)
    return out


def _risen(c: SampledWrist, p: FourSegment, sign: float, back: float, goal: Array, samples: int) -> Array:
    """The static angle on the braking line [deg], times `sign`, that is brought to `goal` by so many
    samples of throttle backwards, (samples + 1, goals)."""
    line, inverse = (p.descending, p.descending_pressure) if sign > 0 else (p.ascending, p.ascending_pressure)
    target: Any = inverse(sign * goal)
    out = np.full((samples + 1, len(goal)), np.inf)
    out[0] = goal
    for k in range(1, samples + 1):
        before = target
        for _ in range(4):  # the step is nearly the identity: each round gains two digits
            before = before + target - regulator.step(before, back, c.regulator)
        target = before
        out[k] = sign * line(target)
    return out
