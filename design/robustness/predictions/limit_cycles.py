"""Limit cycles that harmonic balance predicts, and what the simulator says to each.

A cycle that attracts is confirmed where the loop, started on it, ends on a cycle of that size and
frequency; one that repels, where starts below it die down and starts above it grow, and what is between
them has its size and frequency.  That there is none is tried with large swings.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.robustness.predictions.describing_function import (
    centre_of,
    hysteresis_function,
    regulator_rate,
    swept,
)
from design.robustness.predictions.harmonic_balance import balances, parts, regulator_response
from design.robustness.predictions.orbits import (
    PER_PERIOD,
    STILL,
    SUSTAINED,
    Rollout,
    Swings,
    on_orbit,
    rollout,
)
from design.robustness.statement import Claim, Reason, Statement
from design.status import Status
from plants.wrist import Wrist

Array = NDArray[np.float64]
AMPLITUDE_AGREES, FREQUENCY_AGREES = 0.3, 0.15
"""Shares by which a cycle that is seen may differ from the predicted one and still confirm it: the
describing function leaves out all harmonics but the first."""

PERIODS = 60
"""Length of a simulation that confirms or refutes a cycle."""

SCALES = (0.1, 3.0)
"""Starts about a cycle that repels, as shares of its amplitude."""

ROUNDS = 12
"""Times that the gap between starts below and above it is narrowed down, at the most."""

STEADY = 0.002
"""Share by which lanes on a cycle that repels may differ in amplitude, and it from one period to the next."""


@dataclass(frozen=True)
class LimitCycle:
    """An oscillation that harmonic balance predicts, and what was seen of it.

    amplitude_deg of the angle, amplitude_kPa of the pressure, frequency_rad_s; centre_kPa: pressure about
    which it swings; stable: whether it attracts; clipped: whether it asks for commands beyond the range,
    of which the prediction knows nothing; confirmed: whether the simulator has it; seen_*: what it has
    there, None where it has no cycle.
    """

    amplitude_deg: float
    amplitude_kPa: float
    frequency_rad_s: float
    centre_kPa: float
    stable: bool
    clipped: bool
    confirmed: bool = False
    seen_amplitude_deg: float | None = None
    seen_amplitude_kPa: float | None = None
    seen_frequency_rad_s: float | None = None


def limit_cycles(wrist: Wrist, controller: PI, reference: float = 0.0) -> list[LimitCycle]:
    """Limit cycles about a reference [deg] for one pair of gains, by amplitude, each simulated.

    >>> from plants import Wrist
    >>> limit_cycles(Wrist.flexion(), PI(1.2, 2.2))
    []
    >>> [(c.stable, c.confirmed) for c in limit_cycles(Wrist.flexion(), PI(1.0, 40.0))]
    [(False, True), (True, True)]
    """
    return [simulated(wrist, controller, c, reference) for c in predicted(wrist, controller, reference)]


def predicted(wrist: Wrist, controller: PI, reference: float = 0.0) -> list[LimitCycle]:
    """The limit cycles of the harmonic balance about a reference [deg], not yet simulated.

    Those that would swing past the crossing of lines that are not parallel are left out: the loop has
    no law there.
    """
    found = []
    gain, loop = wrist.regulator.gain, wrist.hysteresis
    for A, w, stable in balances(wrist, controller, reference):
        centre = float(centre_of(loop, A, reference)[0])
        ends = np.array([centre - A, centre + A])
        if np.any(loop.ascending(ends) > loop.descending(ends)):
            continue
        N, _ = hysteresis_function(loop, A, centre)
        known = parts(wrist, controller, w)
        air = regulator_response(regulator_rate(wrist.regulator, A * w), known.z, wrist.rig.sample_time)
        asked = float(A / abs(air))
        clipped = centre - asked < controller.low * gain or centre + asked > controller.high * gain
        found.append(LimitCycle(float(abs(N[0] * known.joint) * A), A, w, centre, stable, bool(clipped)))
    return found


def simulated(wrist: Wrist, controller: PI, cycle: LimitCycle, reference: float = 0.0) -> LimitCycle:
    """A predicted cycle with what the sampled loop does when it is started on it, below and above it."""
    seen = (_attractor if cycle.stable else _watershed)(wrist, controller, cycle, reference)
    if seen is None:
        return cycle
    kPa, deg, frequency = seen
    agrees = (
        abs(kPa / cycle.amplitude_kPa - 1.0) <= AMPLITUDE_AGREES
        and abs(frequency / cycle.frequency_rad_s - 1.0) <= FREQUENCY_AGREES
    )
    return replace(
        cycle, confirmed=agrees, seen_amplitude_deg=deg, seen_amplitude_kPa=kPa,
        seen_frequency_rad_s=frequency,
    )  # fmt: skip


def _attractor(
    wrist: Wrist, controller: PI, cycle: LimitCycle, reference: float
) -> tuple[float, float, float] | None:
    """Amplitudes [kPa], [deg] and frequency [rad/s] that a loop started on the cycle ends with; None
    where it comes to rest."""
    period = 2.0 * np.pi / cycle.frequency_rad_s
    went = _from_scales(wrist, controller, cycle, np.array([1.0]), reference)
    before = went.swing((PERIODS - 16) * period, (PERIODS - 8) * period)
    last = went.swing((PERIODS - 8) * period, PERIODS * period)
    if last.kPa[0] < max(STILL, SUSTAINED * before.kPa[0]) or not np.isfinite(last.frequency[0]):
        return None
    return float(last.kPa[0]), float(last.deg[0]), float(last.frequency[0])


def _watershed(
    wrist: Wrist, controller: PI, cycle: LimitCycle, reference: float
) -> tuple[float, float, float] | None:
    """Amplitudes [kPa], [deg] and frequency [rad/s] of the swing between starts that end below the cycle
    and starts that end above it; None where all starts do the same, or no swing between them is steady."""
    period, (low, high) = 2.0 * np.pi / cycle.frequency_rad_s, SCALES
    for _ in range(ROUNDS):
        scales = np.geomspace(low, high, 16)
        went = _from_scales(wrist, controller, cycle, scales, reference)
        above = went.swing((PERIODS - 4) * period, PERIODS * period).kPa > cycle.amplitude_kPa
        turns = np.flatnonzero(~above[:-1] & above[1:])
        if not len(turns):
            return None
        i = int(turns[0])
        low, high = float(scales[i]), float(scales[i + 1])
        found = _plateau(went, i, period)
        if found is not None:
            return found
    return None


def _plateau(went: Rollout, i: int, period: float) -> tuple[float, float, float] | None:
    """The swing that lane i and the next share before they part, where it stands still for longest;
    None where it never does."""
    shared, steady = [], []
    for k in range(2, 2 * PERIODS - 4):
        s = went.swing(0.5 * k * period, (0.5 * k + 2.0) * period)
        if abs(s.kPa[i] / s.kPa[i + 1] - 1.0) > STEADY or not np.isfinite(s.frequency[i]):
            break
        a, b, c = (float(0.5 * (v[i] + v[i + 1])) for v in (s.kPa, s.deg, s.frequency))
        shared.append((a, b, c))
        if k >= 4:  # two half periods before
            steady.append(abs(a / shared[-3][0] - 1.0))
    if not steady or min(steady) > STEADY:
        return None
    return shared[int(np.argmin(steady)) + 2]


def _from_scales(wrist: Wrist, controller: PI, cycle: LimitCycle, scales: Array, reference: float) -> Rollout:
    """The loop started on orbits that are the cycle's with its amplitude scaled, one a lane."""
    A, w = scales * cycle.amplitude_kPa, cycle.frequency_rad_s
    known = parts(wrist, controller, w)
    N, mean = hysteresis_function(wrist.hysteresis, A, cycle.centre_kPa)
    _, static = swept(wrist.hysteresis, A, cycle.centre_kPa)
    swing = N * known.joint * A  # of the angle, to a pressure that rises through its centre
    state, held = on_orbit(
        wrist, controller, cycle.centre_kPa, static[0], np.asarray(mean), np.asarray(swing), known.z
    )
    period = 2.0 * np.pi / w
    every = max(1, round(period / PER_PERIOD / wrist.rig.sample_time))
    return rollout(wrist, controller, reference, state, held, PERIODS * period, every)


@dataclass(frozen=True)
class NoOscillation(Claim):
    """No lasting oscillation about the reference."""


@dataclass(frozen=True)
class HasCycle(Claim):
    """The loop has a limit cycle of harmonic balance."""

    cycle: LimitCycle


@dataclass(frozen=True)
class Balanced(Reason):
    """Harmonic balance predicts so many cycles that attract and that repel; what large swings do."""

    attract: int
    repel: int
    swings: Swings


@dataclass(frozen=True)
class Simulated(Reason):
    """What the simulator says to a cycle."""

    cycle: LimitCycle


def statements(cycles: list[LimitCycle], swings: Swings) -> list[Statement]:
    """That the loop has no lasting oscillation, and each predicted cycle with its verdict.

    The first is false where the simulated loop goes on swinging; None (not known) where it comes to
    rest from everywhere that was tried though a cycle that attracts is predicted, or the reverse.
    Values are amplitudes of the angle [deg].
    """
    attract = [c for c in cycles if c.stable]
    seen = [c.seen_amplitude_deg or 0.0 for c in attract] + [swings.amplitude_deg]
    swinging = swings.persisting > 0 or any(c.seen_amplitude_kPa is not None for c in attract)
    holds = False if swinging else None if attract else True
    reason = Balanced(len(attract), len(cycles) - len(attract), swings)
    found = [
        Statement(
            Status.PREDICTED, NoOscillation(), holds, max(seen), reason, "deg",
            evidence={"frequency_rad_s": swings.frequency_rad_s},
        )
    ]  # fmt: skip
    for c in cycles:
        evidence = {k: v for k, v in vars(c).items() if k != "amplitude_deg"}
        found.append(
            Statement(
                Status.PREDICTED, HasCycle(c), c.confirmed, c.amplitude_deg, Simulated(c), "deg",
                evidence=evidence,
            )
        )  # fmt: skip
    return found
