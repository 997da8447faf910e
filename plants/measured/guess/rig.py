"""A first guess of a rig from its log alone: where a fit starts when no parameter set is given.

The values are those of the rough models of `plants.measured.guess.rough_models`, the bounds lie around them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis import LAWS, HysteresisLaw, RoughLoop
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import noise_floor, resolution
from plants.measured.guess.rough_models import (
    REACHES,
    Lagged,
    LoopGuess,
    extent,
    first_order,
    lagged,
    largest_error,
    loop_guess,
    median_step,
    recorded,
)
from plants.parameters.quantities import Guessed, Parameter, ParameterSet, declared_kinds, in_units
from plants.rig import Rig, built_in_rig

Array = NDArray[np.float64]
UNSEEN = 100.0
"""Range of the pressure [kPa] where none was logged, so that its unit is nobody's."""

LOOP_TIMES = (0.002, 0.02)
"""Sample times of the model [s]: a share of the regulator's time constant within these, never above the
log's."""

OF_LAG = 1.0 / 30.0
"""That share."""

OF_TASK = 12.0
"""Time constants of the regulator that a run of the task lasts at least: what a loop needs to settle where it
exhausts at less than half the rate at which it fills."""

OF_HOLD = 20.0
"""Dead times for which the first angle of a return is held at least: a loop whose dead time is longer than
its lags settles in about a dozen."""

SEEN = 0.5
"""Largest error at which the rate may be half-way, as a share of the largest error in the log: the rate far
from the commanded pressure is then mostly one that the log shows, and not one that it is extrapolated to."""


def guessed_rig(campaign: Campaign) -> Rig:
    """The rig that a log shows: its motion, its ranges, its sample times; a step of a third of its range.

    Limits and shares of uncertainty are those of the built-in rig; the total variation goes with the range,
    the duration of the task and the limit of settling with the regulator where that is slower, the time for
    which an angle is held with the dead time too, the load with the step.  Noise and resolution of the sensor
    are those of the log.
    """
    base, recordings = built_in_rig(), campaign.recordings
    low, high = extent([r.command for r in recordings])
    pressures = [r.pressure for r in recordings if r.pressure is not None]
    least, most = extent(pressures) if pressures else (0.0, UNSEEN)
    angles = [r.angle for r in recordings if r.angle is not None]
    fresh = [r.angle[r.fresh("angle_deg")] for r in recordings if r.angle is not None]
    step = _rounded(np.ptp(extent(angles)) / 3.0) if angles else base.task.step
    middle = 0.5 * (least + most)
    seen = followed(campaign.fit)
    lasts = max(base.task.duration, _rounded(OF_TASK * seen.tau))
    slower = lasts / base.task.duration
    task = replace(
        base.task, reaction=(middle, middle + 0.25 * (most - least)), duration=lasts,
        hold=max(slower * base.task.hold, _rounded(OF_HOLD * seen.delay)),
    )  # fmt: skip
    per_volt = (high - low) / (base.command_range[1] - base.command_range[0])
    factors = {"total_variation_V": per_volt, "settling_time_s": slower}
    limits = {n: v * factors.get(n, 1.0) for n, v in base.limits.items()}
    uncertainty = replace(
        base.uncertainty,
        noise=float(np.median([noise_floor(a) for a in fresh])) if angles else base.uncertainty.noise,
        resolution=min(map(resolution, fresh), default=base.uncertainty.resolution),
    )  # fmt: skip
    rig = replace(
        base, name=campaign.axis, title=f"Rig of {campaign.name}", motions=(campaign.axis,),
        units=campaign.units, command_range=(low, high), pressure_range=(least, most), task=task,
        limits=limits, sample_time=_loop_time(campaign.sample_time, seen.tau),
        log_time=campaign.sample_time, uncertainty=uncertainty,
    )  # fmt: skip
    return with_step(rig, step)


def with_step(rig: Rig, step: float) -> Rig:
    """The rig with another step of its task [deg], and a load in proportion to it."""
    load = rig.uncertainty.load * step / rig.task.step
    return replace(rig, task=replace(rig.task, step=step), uncertainty=replace(rig.uncertainty, load=load))


def guessed_set(
    campaign: Campaign, law: str = "four-segment", rig: Rig | None = None, wide: float = 8.0
) -> ParameterSet:
    """Starting values and bounds of the declared parameters, from the recordings to fit on.

    law: name of the hysteresis law; rig: whose motion it is, `guessed_rig` where not given; wide: factor by
    which bounds lie around a guess.  All provenance is `Guessed`.  Raises KeyError for an unknown law.
    """
    rig = guessed_rig(campaign) if rig is None else rig
    kind, logged = LAWS[law], [r for r in campaign.fit if r.pressure is not None]
    low, high = rig.pressure_range
    seen = followed(campaign.fit)
    if logged:
        gain = seen.gain
        drives = [r.pressure for r in campaign.fit if r.pressure is not None]
    else:
        gain = (high - low) / (rig.command_range[1] - rig.command_range[0])
        drives = [lagged(gain * r.command, median_step(r), seen.tau, seen.delay) for r in campaign.fit]
    rate = 1.0 / max(seen.tau, 1e-3)
    span = high - low
    error = largest_error(recorded(campaign.fit, _followed_channel(campaign.fit)), replace(seen, gain=gain))
    half_way = max(SEEN * error, 0.02 * span)
    values = {"gain": gain, "k_fast": rate, "k_slow": rate, "e0": min(0.2 * span, 0.5 * half_way)}
    # Where the pressure ends below what is commanded, the declared regulator is best with a smaller gain.
    share = (
        (high - low) / (abs(gain) * (rig.command_range[1] - rig.command_range[0]))
        if np.isfinite(seen.most)
        else 1.0
    )
    ends = (0.5 * min(share, 1.0) * gain, 2.0 * gain)
    # Of an angle the lag is that of the joint and of what creeps too: the regulator alone may be far faster.
    most = rate * (wide if logged else wide**2)
    bounds = {
        "gain": (min(ends), max(ends)),
        "k_fast": (rate / wide, most), "k_slow": (rate / wide**2, most),
        "e0": (1e-3 * span, half_way),
    }  # fmt: skip
    if campaign.stage == "wrist":
        runs = [r for r in campaign.fit if r.pressure is not None] if logged else list(campaign.fit)
        guess = loop_guess(runs, drives)
        if campaign.start == "rest":
            rest = float(np.median([np.median(d[:3]) for d in drives]))
            guess = replace(guess, loop=guess.loop.at_rest(rest))
        own, around = _of_law(kind, guess, rig, runs)
        values |= own
        bounds |= around
    else:
        own = kind.guess(RoughLoop.of_equal_plays(0.1, 0.02, 0.05 * span, low, low, high))
        values |= own | {"Tw": 0.1}
        bounds |= {n: (min(0.0, v), max(2.0 * v, 1.0)) for n, v in own.items()} | {"Tw": (0.005, 5.0)}
    why = Guessed(f"{campaign.name} (sha256 {campaign.checksum[:12]})")
    kinds = {n: in_units(k, rig) for n, k in declared_kinds(kind, values).items()}
    parameters = {}
    for name, known in kinds.items():
        value, (least, most) = float(values[name]), bounds[name]
        parameters[name] = Parameter(value, known.unit, min(least, value), max(most, value), why)
    return ParameterSet(campaign.axis, f"{campaign.axis}, guessed from its log", parameters, (), rig)


def followed(recordings: Sequence[Recording]) -> Lagged:
    """How the pressure follows the command, or the angle where no pressure was logged."""
    return first_order(recorded(recordings, _followed_channel(recordings)))


def _followed_channel(recordings: Sequence[Recording]) -> str:
    return "pressure" if any(r.pressure is not None for r in recordings) else "angle"


def _of_law(
    law: type[HysteresisLaw], guess: LoopGuess, rig: Rig, runs: Sequence[Recording]
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Values and bounds of the parameters of a law and of the joint."""
    span = rig.pressure_range[1] - rig.pressure_range[0]
    stroke = float(np.ptp(extent([r.angle for r in runs if r.angle is not None])))
    slope = stroke / span
    values = law.guess(guess.loop) | {"Tw": max(guess.lag, 0.02)}
    bounds = {}
    for name, kind in declared_kinds(law, values).items():
        if name not in values:
            continue
        match kind.unit:
            case "deg/kPa":
                bounds[name] = (0.0 if kind.low == 0.0 else 0.02 * slope, 8.0 * slope)
            case "deg":
                bounds[name] = (0.02 * stroke if kind.low > 0.0 else -stroke, 2.0 * stroke)
            case "kPa" if name == "rest_pressure":
                bounds[name] = (guess.loop.rest - span, guess.loop.rest + span)
            case "kPa":
                bounds[name] = (1e-3 * span, REACHES[-1] * span)
            case _:
                bounds[name] = (kind.low, kind.high)
    return values, bounds


def _rounded(value: float) -> float:
    """To two digits."""
    return float(f"{value:.2g}")


def _loop_time(log: float, tau: float) -> float:
    """A whole part of the log's sample time [s], short against the regulator's time constant [s]."""
    least, most = LOOP_TIMES
    target = min(max(tau * OF_LAG, least), most, log)
    return log / max(1, round(log / target))
