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

Effects are of four kinds:

- kept, being monotone: dead time, fill/exhaust asymmetry, branch curvature (as far as the grid agrees),
  cross coupling (the other motion rests), load step, creep that goes on in the same direction, end
  stops, and all that sits in the sensor, which the judge does not look through;
- taken away, where the wrist without it goes at least as far at every time: a dead band of the
  regulator, supply droop, and a loop that widens with the rate.  The bound then holds, and is weaker;
- inertia with linear damping: its impulse response is positive for ever where its poles are real, and
  for the first half period where it rings, so that the envelope is claimed that long;
- refused: softening, creep backwards, a loop that narrows with the rate, inertia with drag or
  stiffening or against a stop, and a commanded pressure capped by a supply that may sag below zero.
"""

from typing import Any

import numpy as np

from plants.effects import Effect
from plants.effects.dead_time import DeadTime, TubeDeadTime
from plants.effects.effect import Around
from plants.effects.inertia import NULL, Inertia
from plants.errors import InputError
from plants.hysteresis import FourSegment
from plants.regulator import Regulator
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, State, Wrist, press

KEPT = (
    "dead-time", "fill-exhaust-asymmetry", "branch-curvature", "cross-coupling", "load-step", "creep",
    "end-stop", "gyro-drift", "periodic-disturbance", "inertia",
)  # fmt: skip
"""Effects whose wrist is simulated as it is."""

TAKEN_AWAY = ("regulator-deadband", "supply-droop", "rate-dependence")
"""Effects without which the wrist goes at least as far."""

POINTS = 201
"""Points of the grids of pressures and of commands."""

ROUNDING = 1e-9
"""By how much a map may fall from one point of a grid to the next [kPa, deg]."""


def without(wrist: Wrist, state: State, names: tuple[str, ...]) -> tuple[Wrist, State]:
    """A wrist and its state without some effects."""
    kept = [i for i, e in enumerate(wrist.effects) if e.NAME not in names]
    bare = Wrist(wrist.regulator, wrist.hysteresis, wrist.Tw, tuple(wrist.effects[i] for i in kept))
    return bare, state._replace(effects=tuple(state.effects[i] for i in kept))


def relaxed(wrist: Wrist, state: State) -> tuple[Wrist, State]:
    """The wrist, and its state, that goes at least as far as this one and is a monotone cascade.

    Raises InputError for one of which that is not known, with the reason.
    """
    if np.ndim(state.pressure) or any(np.ndim(v) for v in wrist.values.values()):
        raise InputError("limit: the wrist has arrays as parameters or state; ask for one lane at a time")
    for effect in wrist.effects:
        reason = _refusal(effect, wrist)
        if reason:
            raise InputError(
                f"limit: no bound is known for {effect.NAME} ({effect.FORM}): {reason}; leave the effect out"
            )
    bare, left = without(wrist, state, TAKEN_AWAY)
    _check_pressure(bare, left)
    _check_lines(bare, left)
    return bare, left


def claimed(wrist: Wrist) -> int | None:
    """For how many samples the envelope is one; None: for ever."""
    for effect in wrist.effects:
        if isinstance(effect, Inertia) and effect.inertia > NULL and wrist.Tw < 2.0 * effect.inertia:
            m = effect.inertia**2
            ringing = np.sqrt(4.0 * m - wrist.Tw**2) / (2.0 * m)  # rad/s
            return max(int(np.pi / ringing / SAMPLE_TIME) - 1, 0)
    return None


def _refusal(effect: Effect, wrist: Wrist) -> str | None:
    v = {n.split(".")[1]: x for n, x in effect.values.items()}
    if effect.NAME == "creep" and min(v["gain"], v.get("gain_late", 0.0)) < 0.0:
        return "what creeps backwards undoes a fast move"
    if effect.NAME == "rate-dependence" and v["widening"] < 0.0:
        return "a loop that narrows with the rate rewards haste and slowness alike"
    if effect.NAME == "supply-droop" and "capped" in effect.FORM and v.get("deepest", 0.0) > v["supply"]:
        return "the supply may sag below zero and pull the commanded pressure with it"
    if effect.NAME == "inertia":
        if not isinstance(effect, Inertia):
            return "only linear damping has an impulse response"
        if any(e.NAME == "end-stop" for e in wrist.effects):
            return "a stop within a second-order transient is no monotone map"
    if effect.NAME not in KEPT + TAKEN_AWAY:
        return "its wrist is not a monotone cascade"
    return None


def _pressures(wrist: Wrist, state: State) -> Any:
    """Pressures [kPa] that the wrist may come to, (POINTS,)."""
    ends = [wrist.regulator.gain * v for v in COMMAND_RANGE] + [float(state.pressure)]
    return np.linspace(min(ends), max(ends), POINTS)


def _check_pressure(wrist: Wrist, state: State) -> None:
    """InputError unless the pressure after a sample rises with the pressure before and the command.

    The tube's delay and lag are monotone by their form, and left out.
    """
    valve, _ = without(wrist, state, ("dead-time",))
    c, grid = valve.sampled(), _pressures(wrist, state)
    start = valve.rest()._replace(pressure=grid[:, None])
    after, _ = press(start, np.linspace(*COMMAND_RANGE, POINTS)[None, :], c)
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


def delay_of(wrist: Wrist) -> float:
    """Transport delay of the wrist [s], the lag of its tube left out."""
    found = [e.delay for e in wrist.effects if isinstance(e, DeadTime | TubeDeadTime)]
    return float(found[0]) if found else 0.0
