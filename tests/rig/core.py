"""The integrator of a rig: Heun's method at a quarter of a millisecond, in open or closed loop.

Everything discontinuous (targets, hysteresis, stops) is updated once a substep; the regulator's
and the joint's differential equations are taken with Heun.  Outside quantities come at 1 kHz.
"""

from math import exp
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit

from tests.rig import joint_effects, open_effects, regulator_effects, sensor_effects, wrist_effects
from tests.rig.effects import Hidden
from tests.rig.joint_effects import SPRINGS, bristles, joint_acceleration, lugre, maxwell_slip, stop_push
from tests.rig.open_effects import ripple, run_out
from tests.rig.parameters import Declared
from tests.rig.regulator_effects import accepted_target, leaked, limited_rate, supply_pressure, valve_rate
from tests.rig.sensor_effects import drift, hum
from tests.rig.signals import Signal
from tests.rig.wrist_effects import (
    LONGEST_SPECTRUM,
    PLAYS,
    bent,
    bouc_wen,
    curved_transit,
    lens,
    loaded,
    slope_factor,
    widening,
)

TICK = 0.001  # s, of the controller
SUBSTEPS = 4  # of a tick


def _forget_stale_machine_code() -> None:
    """Numba dates its cache by this file alone and would miss a law that was edited in another."""
    laws = (regulator_effects, wrist_effects, joint_effects, sensor_effects, open_effects)
    newest = max(Path(str(law.__file__)).stat().st_mtime_ns for law in laws)
    for index in (Path(__file__).parent / "__pycache__").glob("core.*.nbi"):
        if index.stat().st_mtime_ns < newest:
            index.unlink(missing_ok=True)


_forget_stale_machine_code()


class Controller(NamedTuple):
    """PI controller: command = (rest_pressure + Kp (b r - y) + Ki integral (r - y))/gain, clipped.

    Kp [kPa/deg], Ki [kPa/(deg s)], gain [kPa/V], rest_pressure [kPa], low and high [V]; b weights the
    reference r, y is the measured angle behind a lag of Tf [s], none where that is 0.  The integrator stands
    still while the command is clipped, unless the error drives it back.  It acts every so many ticks, and
    its command is held in between.
    """

    Kp: float = 0.0
    Ki: float = 0.0
    gain: float = 49.4
    rest_pressure: float = 100.0
    low: float = 0.0
    high: float = 4.0
    b: float = 1.0
    Tf: float = 0.0
    every: int = 1


class Outside(NamedTuple):
    """What comes from outside, at 1 kHz: arrays of one length.

    command [V] (of no account in closed loop), reference [deg], other_pressure [kPa], joint and
    sensor disturbances [deg], noise [deg] of the angle reading.
    """

    command: Signal
    reference: Signal
    other_pressure: Signal
    joint: Signal
    sensor: Signal
    noise: Signal


@njit
def pi_command(
    controller: Controller, reference: float, angle: float, filtered: float, integral: float
) -> tuple[float, float, float]:
    """(command [V], integral and filtered angle after it)."""
    dt = TICK * controller.every
    filtered = angle if controller.Tf == 0.0 else angle + (filtered - angle) * exp(-dt / controller.Tf)
    proportional = controller.Kp * (controller.b * reference - filtered)
    error = reference - filtered
    volts = (controller.rest_pressure + proportional + controller.Ki * integral) / controller.gain
    command = min(max(volts, controller.low), controller.high)
    clipped_further = (command - volts) * error < 0.0
    return command, integral if clipped_further else integral + error * dt, filtered


@njit
def pressure_rate(
    p: Declared, hidden: Hidden, target: float, pressure: float, supply: float, angle: float
) -> float:
    """dP/dt [kPa/s] of regulator, orifice and leak."""
    error = target - pressure
    rate = p.k_slow + (p.k_fast - p.k_slow) * error**2 / (error**2 + p.e0**2)
    rate = valve_rate(hidden.asymmetry, rate * error, pressure)
    rate = limited_rate(hidden.supply, rate, pressure, supply)
    rate -= hidden.open.bending_leak.rate * max(pressure, 0.0) * (angle / 20.0) ** 2
    return rate - leaked(hidden.leak, pressure)


@njit(cache=True)
def integrate(
    p: Declared,
    hidden: Hidden,
    closed: bool,
    noisy: bool,
    controller: Controller,
    outside: Outside,
    substeps: int,
) -> Signal:
    """Columns at every tick, before its command acts: command, pressure, true angle, measured angle."""
    ticks = len(outside.command)
    dt = TICK / substeps
    out = np.empty((ticks, 4))
    strange = hidden.open
    spectrum = hidden.creep
    creeping = np.zeros(LONGEST_SPECTRUM)
    plays, pulls = np.zeros(PLAYS), np.zeros(SPRINGS)
    late = np.full(round(hidden.dead_time.transport_s / dt) + 1, p.rest_pressure)
    at = 0  # where the delay line is written next, and read after that
    tube_decay = exp(-dt / hidden.dead_time.tube_s) if hidden.dead_time.tube_s > 0.0 else 0.0
    recovery = exp(-dt / hidden.supply.recovery_s)
    remembers = exp(-dt / hidden.rate.memory_s)

    pressure = target = sampled = accepted = p.rest_pressure
    next_sample = -strange.sampled_regulator.offset_s
    command = p.rest_pressure / controller.gain
    use, work, largest, remembered_rate = 0.0, 0.0, 0.0, 0.0
    h, virgin = 0.0, True
    other = outside.other_pressure[0] - 100.0
    x = hidden.coupling.pressure * other
    # The other muscle has been at its pressure for long: the joint rests where that holds it.
    u = hidden.coupling.angle * other + hidden.coupling.bend * other**2 / 100.0
    y, speed, stuck, pull, smooth, seen = u, 0.0, True, 0.0, 0.0, u
    integral, filtered = 0.0, 0.0

    for tick in range(ticks):
        start = tick * TICK
        behind = strange.sensor_backlash.half_width
        reading = seen + run_out(strange.eccentric_sensor, seen) + outside.sensor[tick]
        reading += drift(hidden.drift, start)
        if hidden.hum.form > 0:
            reading += hum(hidden.hum, start)
        reading += strange.valve_current.amplitude * ((command / 4.0) ** 2 - 0.25)  # of the command so far
        measured = reading + outside.noise[tick] * (1.0 + strange.speed_noise.per_speed * abs(speed))
        if closed and tick % controller.every == 0:
            seen_angle = measured if noisy else reading
            command, integral, filtered = pi_command(
                controller, outside.reference[tick], seen_angle, filtered, integral
            )
        elif not closed:
            command = outside.command[tick]
        out[tick, 0], out[tick, 1], out[tick, 2], out[tick, 3] = command, pressure, y, measured
        following = min(tick + 1, ticks - 1)
        for substep in range(substeps):
            time = start + (substep + 1) * dt  # of the end of this substep
            share = (substep + 1) / substeps

            # Command to target: gain, sampling, dead band, dead time, tube.
            wanted = command * p.gain
            if strange.gain_drift.loss != 0.0:
                wanted *= 1.0 - strange.gain_drift.loss * (1.0 - exp(-time / strange.gain_drift.warming_s))
            if strange.sampled_regulator.period_s > 0.0:
                if time - dt >= next_sample - 1e-9:
                    sampled = wanted
                    next_sample += strange.sampled_regulator.period_s
                wanted = sampled
            accepted = accepted_target(hidden.deadband, wanted, accepted)
            late[at] = accepted
            at = (at + 1) % len(late)
            target = late[at] + (target - late[at]) * tube_decay

            # Pressure of the chamber.
            supply = supply_pressure(hidden.supply, use)
            reached = min(target, supply) if hidden.supply.form == 2 else target
            first = pressure_rate(p, hidden, reached, pressure, supply, y)
            second = pressure_rate(p, hidden, reached, pressure + dt * first, supply, y)
            before = pressure
            pressure += 0.5 * dt * (first + second)
            if hidden.supply.form == 1:
                pressure = min(pressure, supply)
            use = (use + max(pressure - before, 0.0)) * recovery

            # What works on the muscles, and hysteresis between its two lines.
            other = (
                (1.0 - share) * outside.other_pressure[tick]
                + share * outside.other_pressure[following]
                - 100.0
            )
            x_before, x = x, pressure - p.rest_pressure + hidden.coupling.pressure * other
            rate = abs(pressure - before) / dt
            remembered_rate = rate + (remembered_rate - rate) * remembers
            work += abs(pressure - before)
            largest = max(largest, abs(pressure - p.rest_pressure))
            slope = slope_factor(hidden.softening, work, time, largest)
            wider = widening(hidden.rate, rate, remembered_rate)
            arm, bow = slope * bent(hidden.curvature, x), lens(hidden.curvature, x)
            low = p.a1 * arm - p.w1 - wider - hidden.curvature.bow1 * bow
            high = p.a2 * arm + p.w2 + wider + hidden.curvature.bow2 * bow
            transit = p.s * slope
            if hidden.shape.form == 3 and x > x_before:
                transit = curved_transit(
                    hidden.shape, transit, p.a1 * slope, (high - h) / max(high - low, 1e-9)
                )
            elif hidden.shape.form == 3:
                transit = curved_transit(
                    hidden.shape, transit, p.a2 * slope, (h - low) / max(high - low, 1e-9)
                )
            if not virgin:
                h += transit * (x - x_before)
            if h < low:
                h, virgin = low, False
            if h > high:
                h, virgin = high, False

            # Static angle that the joint is drawn to.
            u_before, u = u, h
            if spectrum.form > 0:
                for i in range(LONGEST_SPECTRUM):
                    creeping[i] += (h - creeping[i]) * (1.0 - exp(-dt / spectrum.times_s[i]))
                    u += spectrum.gains[i] * creeping[i]
            if hidden.shape.form == 1:
                for i in range(PLAYS):
                    half = hidden.shape.widest * (i + 1) / PLAYS
                    plays[i] = min(max(plays[i], x - half), x + half)
                    u += hidden.shape.slope / PLAYS * plays[i]
            elif hidden.shape.form == 2:
                smooth = bouc_wen(hidden.shape, smooth, x - x_before)
                u += hidden.shape.slope * (x - smooth)
            u += ripple(strange.pressure_ripple, x) + outside.joint[tick]
            u += hidden.coupling.angle * other + hidden.coupling.bend * other**2 / 100.0
            u = loaded(hidden.load, u, time)

            # The joint: stuck, a lag, or of second order; then its stops.
            if hidden.stick.form == 1:
                off = abs(u - y)
                stuck = off < (hidden.stick.breakaway if stuck else hidden.stick.residue)
            if hidden.stick.form == 1 and stuck:
                speed = 0.0
            elif hidden.stick.form == 2 and hidden.inertia.form > 0:
                a0 = joint_acceleration(hidden.inertia, u_before - pull, y, speed, x_before)
                r0 = bristles(hidden.stick, speed, pull)
                y1, v1, pull1 = y + dt * speed, speed + dt * a0, pull + dt * r0
                a1 = joint_acceleration(hidden.inertia, u - pull1, y1, v1, x)
                pull += 0.5 * dt * (r0 + bristles(hidden.stick, v1, pull1))
                y, speed = y + 0.5 * dt * (speed + v1), speed + 0.5 * dt * (a0 + a1)
            elif hidden.stick.form == 2:
                v0, r0 = lugre(hidden.stick, p.Tw, u_before, y, pull)
                speed, r1 = lugre(hidden.stick, p.Tw, u, y + dt * v0, pull + dt * r0)
                speed = 0.5 * (v0 + speed)
                y += dt * speed
                pull += 0.5 * dt * (r0 + r1)
            elif hidden.stick.form == 3:
                speed = (u - y - pull) / p.Tw
                y += dt * speed
                pull = maxwell_slip(hidden.stick, pulls, dt * speed)
            elif hidden.inertia.form == 0:
                slow = (u_before - y - stop_push(hidden.stop, y)) / p.Tw
                guess = y + dt * slow
                fast = (u - guess - stop_push(hidden.stop, guess)) / p.Tw
                speed = 0.5 * (slow + fast)
                y += dt * speed
            else:
                a0 = joint_acceleration(
                    hidden.inertia, u_before - stop_push(hidden.stop, y), y, speed, x_before
                )
                y1, v1 = y + dt * speed, speed + dt * a0
                a1 = joint_acceleration(hidden.inertia, u - stop_push(hidden.stop, y1), y1, v1, x)
                y, speed = y + 0.5 * dt * (speed + v1), speed + 0.5 * dt * (a0 + a1)
            if hidden.stop.form == 1 and (y > hidden.stop.high or y < hidden.stop.low):
                y, speed = min(max(y, hidden.stop.low), hidden.stop.high), 0.0
            seen = min(max(seen, y - behind), y + behind)
    return out
