"""The chain from command to angle, tick after tick: valves, plays or relays, joint, and a PI around it."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from tests.rig.core import Controller, pi_command
from tests.rig.signals import Signal

TICK = 0.001


class Switched(NamedTuple):
    """On/off valves without a regulator: each period [s] the one to a supply is open for as large a share as
    the command is of its range, then the one to the outside.

    most [kPa/s]: what flows in at no pressure; stall [kPa]: where nothing flows in; out [kPa/s]: what flows
    out at `stall`, with the root of the pressure; period 0: no such valves.
    """

    most: float = 0.0
    stall: float = 1.0
    out: float = 0.0
    period: float = 0.0


REGULATED = Switched()
"""A regulator, and no such valves."""


class Relays(NamedTuple):
    """A Preisach operator: pressures [kPa] at which each relay switches on and off, and what the angle [deg]
    rises by when it does, each (n,)."""

    on: Signal
    off: Signal
    rise: Signal


NONE = Relays(np.empty(0), np.empty(0), np.empty(0))


class Loop(NamedTuple):
    """A PI around the chain: controller (gains of its own period), period [ticks], the angle [deg] that
    it counts from, reference [deg] counted likewise at every ms, delay of the command [ticks]."""

    controller: Controller
    period: int
    zero: float
    reference: Signal
    late: int


@njit
def through_valves(p, pressure, tick, duty):
    """Pressure [kPa] after a ms, of which the filling valve is open for a part."""
    ticks = round(p.period / 0.001)
    opened = min(max(duty * ticks - tick % ticks, 0.0), 1.0)
    change = opened * p.most * (1.0 - pressure / p.stall)
    change -= (1.0 - opened) * p.out * sqrt(max(pressure, 0.0) / p.stall)
    return max(pressure + 0.001 * change, 0.0)


@njit
def run_chain(
    command,
    loop,
    gain,
    bias,
    fill,
    exhaust,
    falls,
    r,
    w,
    origin,
    cubic,
    full,
    first,
    share,
    slow,
    lag,
    late,
    tail,
    breakaway,
    rest,
    relays,
    natural,
    damping,
    valves,
    low,
    high,
):
    """loop: what makes the command up from its first value on, behind a delay; an empty reference where the
    command is given."""
    n = len(command)
    pressure, angle = np.empty(n), np.empty(n)
    P = follows = gain * command[0] + bias
    P = 0.0 if valves.period > 0.0 else P
    moves = True
    plays = np.zeros(len(r))
    y, v, w0 = 0.0, 0.0, 2.0 * np.pi * natural
    c = 0.0
    is_on = relays.on <= P
    switched = np.sum(relays.rise[is_on])
    before = P
    closed, integral, filtered, held = len(loop.reference) > 0, 0.0, 0.0, command[0]
    for j in range(len(r)):
        plays[j] = min(max(0.0, P - origin - r[j]), P - origin + r[j])
    for i in range(n):
        if closed:
            if i % loop.period == 0 and i > 0:
                seen = angle[i - 1] - loop.zero
                held, integral, filtered = pi_command(
                    loop.controller, loop.reference[i], seen, filtered, integral
                )
            if i + loop.late < n:
                command[i + loop.late] = held
        target = gain * command[i] + bias
        follows += 0.001 / tail * (target - follows)
        target += late * (follows - target)
        if valves.period > 0.0:
            P = through_valves(valves, P, i, (command[i] - low) / (high - low))
        else:
            rate = (fill if target > P else exhaust) / (1.0 + falls * max(P, 0.0) / 100.0)
            P += 0.001 * rate * (target - P)
        x = P - origin
        u = 0.0
        for j in range(len(r)):
            plays[j] = min(max(plays[j], x - r[j]), x + r[j])
            u += w[j] * plays[j]
        if len(is_on) > 0:
            for j in range(len(is_on) if before != P else 0):
                if relays.on[j] <= P and not is_on[j]:
                    is_on[j] = True
                    switched += relays.rise[j]
                elif relays.off[j] > P and is_on[j]:
                    is_on[j] = False
                    switched -= relays.rise[j]
            u, before = switched, P
        h = u - cubic * full * (u / full) ** 3
        h = max(h - first, 0.0) if first > 0.0 else h
        if i == 0:
            y, c = h, share * h
        c += 0.001 / slow * (share * h - c)
        if breakaway > 0.0:
            moves = abs(h + c - y) > (rest if moves else breakaway)
        if natural > 0.0:
            v += 0.001 * (w0 * w0 * (h + c - y) - 2.0 * damping * w0 * v)
            y += 0.001 * v
        elif moves:
            y += 0.001 / lag * (h + c - y)
        pressure[i], angle[i] = P, y
    return pressure, angle
