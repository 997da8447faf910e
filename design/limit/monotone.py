"""Where the wrist is a monotone cascade, which is what makes full throttle the fastest way.

A map is monotone if a state and an input that are larger in every component give a larger next state
(Angeli & Sontag, Monotone control systems, IEEE TAC 48 (2003) 1684; the comparison lemma is that of
Khalil, Nonlinear Systems, 3rd ed., section 3.4).  Stage by stage, for one sample:

    regulator   P+ = P + f(gain v - P) rises with P and v where 0 <= f' <= 1: looked at on a grid.
    hysteresis  with z = h - s P, z+ = clip(z, line1(P+) - s P+, line2(P+) - s P+): a generalised play,
                which rises with z and P+ where both lines are at least as steep as the transit and
                s >= 0 (Brokate & Sprekels, Hysteresis and Phase Transitions, 1996);
                the lines are looked at on a grid too.
    lag         y+ = keep y + before h + after h+ with positive coefficients.

The virgin curve is not such a stage: a dip below the dead zone leaves a memory that a straight rise
does not.  `design.limit.bound` treats that dip apart.

Each effect declares what the bound makes of it (`plants.effects.effect`): it is kept, being monotone (branch
curvature as far as the grid agrees, cross coupling while the other motion rests, all that sits in the
sensor, which the judge does not look through), or taken away, where the wrist without it goes at least as
far at every time: the bound then holds, and is weaker.  For all others, and for values at which it is not
so, the bound is refused with the effect's own reason.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from plants.actuator.regulator import Regulator
from plants.dynamics import press
from plants.effects import Effect
from plants.effects.effect import Around
from plants.errors import InputError
from plants.hysteresis import FourSegment
from plants.wrist import State, Wrist

POINTS = 201
"""Points of the grids of pressures and of commands."""

ROUNDING = 1e-9
"""By how much a map may fall from one point of a grid to the next [kPa, deg]."""


def without(wrist: Wrist, state: State, left_out: Callable[[Effect], bool]) -> tuple[Wrist, State]:
    """A wrist and its state without some effects."""
    kept = [i for i, e in enumerate(wrist.effects) if not left_out(e)]
    bare = replace(wrist, effects=tuple(wrist.effects[i] for i in kept))
    return bare, state._replace(effects=tuple(state.effects[i] for i in kept))


def prompt(wrist: Wrist, state: State) -> tuple[Wrist, State]:
    """A wrist and its state without what delays and smooths its command."""
    return without(wrist, state, lambda effect: effect.DELAY is not None)


def relaxed(wrist: Wrist, state: State) -> tuple[Wrist, State]:
    """The wrist, and its state, that goes at least as far as this one and is a monotone cascade.

    Raises InputError for one of which that is not known, with the reason.
    """
    if np.ndim(state.pressure) or any(np.ndim(v) for v in wrist.values.values()):
        raise InputError("limit: the wrist has arrays as parameters or state; ask for one lane at a time")
    if not wrist.hysteresis.MONOTONE:
        raise InputError(
            f"limit: no bound is known for the hysteresis law {wrist.hysteresis.NAME!r}: more pressure at "
            "all times is not known to give more angle at all times; leave the bound out"
        )
    for effect in wrist.effects:
        reason = effect.no_bound(wrist)
        if reason:
            raise InputError(
                f"limit: no bound is known for {effect.NAME} ({effect.FORM}): {reason}; leave the effect out"
            )
    bare, left = without(wrist, state, lambda effect: effect.BOUND == "taken away")
    _check_pressure(bare, left)
    _check_lines(bare, left)
    return bare, left


def claimed(wrist: Wrist) -> int | None:
    """For how many samples the envelope is one; None: for ever."""
    ends = [t for e in wrist.effects if (t := e.bound_ends(wrist)) is not None]
    return max(int(min(ends) / wrist.rig.sample_time) - 1, 0) if ends else None


def _pressures(wrist: Wrist, state: State) -> Any:
    """Pressures [kPa] that the wrist may come to, (POINTS,)."""
    ends = [*wrist.reach, float(state.pressure)]
    return np.linspace(min(ends), max(ends), POINTS)


def _check_pressure(wrist: Wrist, state: State) -> None:
    """InputError unless the pressure after a sample rises with the pressure before and the command.

    The tube's delay and lag are monotone by their form, and left out.
    """
    valve, _ = prompt(wrist, state)
    c, grid = valve.sampled(), _pressures(wrist, state)
    start = valve.rest()._replace(pressure=grid[:, None])
    after, _ = press(start, np.linspace(*wrist.rig.command_range, POINTS)[None, :], c)
    if min(np.diff(after, axis=0).min(), np.diff(after, axis=1).min()) < -ROUNDING:
        r: Regulator = wrist.regulator
        raise InputError(
            f"limit: a larger command does not always give a larger pressure (k_fast {r.k_fast:.4g}, k_slow "
            f"{r.k_slow:.4g} 1/s): full throttle is not known to be fastest; check the regulator's rates"
        )


def _check_lines(wrist: Wrist, state: State) -> None:
    """InputError unless both lines, as the effects bend them, are at least as steep as the transit."""
    c, loop, grid, quiet = wrist.sampled(), wrist.hysteresis, _pressures(wrist, state), Around()
    rest = wrist.rest().effects
    acting = driven(wrist, grid)
    low, high = loop.ascending(acting), loop.descending(acting)
    for i, effect in c.at("bend"):
        _, down, up, _ = effect(rest[i], acting, acting, loop, quiet)
        low, high = low + down, high + up
    # A sum of plays whose weights are not negative rises anyhow: only what bends it has to be looked at.
    flattest = loop.flattest if isinstance(loop, FourSegment) else 0.0
    rises = [np.diff(acting).min(), *(np.diff(x - flattest * acting).min() for x in (low, high))]
    if min(rises) < -ROUNDING or loop.flattest < 0.0:
        raise InputError(
            "limit: a line of the loop is flatter somewhere than the transit: a larger pressure does not "
            "always give a larger angle later; check a1, a2 and s, and the curvature"
        )


def driven(wrist: Wrist, pressure: Any) -> Any:
    """The pressure [kPa] that drives the loop, for one that the regulator gives; the other motion rests."""
    rest, acting = wrist.rest().effects, pressure
    for i, effect in wrist.sampled().at("drive"):
        _, _, acting = effect(rest[i], acting, acting, Around())
    return acting
