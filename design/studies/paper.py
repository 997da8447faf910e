"""The series behind the paper's figures, computed from the model alone.

Steady states are not read off the law: each level is held for 20 s of
simulation, as a rig would be.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from design.controllers.pi import PI
from design.evaluation.scenarios import STEP
from design.evaluation.steps import run
from design.studies.shown.panels import Array, Panel, Series
from design.synthesis.tuning_rules import paper_range
from plants.actuator.regulator import Regulator
from plants.parameters.quantities import REGULATOR_NAMES
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist

HOLD = 20.0
"""How long a level is held until it counts as steady [s]; the regulator takes about 10 s."""

LAG = 0.111
"""Time constant of the paper's first-order lag regulator [s] (section 3)."""

INITIAL_LEVELS = (0.0, 50.0, 100.0, 150.0, 200.0)
"""Pressures applied from rest [kPa] (section 5.1)."""

STAIRCASE = (100.0, 150.0, 200.0, 150.0, 100.0, 50.0, 0.0, 50.0, 100.0, 150.0, 200.0)
"""Applied pressure [kPa], one level after the other (section 5.2); its order beyond the first
step is assumed: up, all the way down, and up again, so that the loop closes."""

ALIKE = 0.005
"""Regulators that differ by no more than this share of each parameter are drawn as one."""

MOTIONS = {"flexion": "Palmar/dorsal flexion", "deviation": "Radial/ulnar deviation"}
PLUS = {"flexion": "dorsal", "deviation": "ulnar"}
TIME, PRESSURE, ANGLE = "Time [s]", "Pressure [kPa]", "Angle [deg]"


def volts(pressure: float, regulator: Regulator) -> float:
    """The command [V] for a pressure [kPa], within the range of the command."""
    low, high = COMMAND_RANGE
    return float(min(max(pressure / regulator.gain, low), high))


def commands(levels: Sequence[float], regulator: Regulator, hold: float = HOLD) -> Array:
    """Commands [V], one per ms, that hold one pressure [kPa] after the other."""
    return np.repeat([volts(p, regulator) for p in levels], round(hold / SAMPLE_TIME))


def by_regulator(
    flexion: Wrist, deviation: Wrist, names: Sequence[str] = REGULATOR_NAMES
) -> dict[str, Wrist]:
    """The wrists whose regulators differ in the parameters of `names`, by what to call them: one
    where both motions share the regulator, or where fits of it differ by less than can be seen."""
    one, other = flexion.values, deviation.values
    if all(abs(one[n] - other[n]) <= ALIKE * abs(one[n]) for n in names):
        return {"": flexion}
    return {"flexion": flexion, "deviation": deviation}


def _called(name: str, whose: str) -> str:
    return f"{name}, {whose}" if whose else name


def regulator_steady(flexion: Wrist, deviation: Wrist) -> tuple[Panel, ...]:
    """Fig. 5: command voltage to steady-state pressure."""
    levels = np.arange(COMMAND_RANGE[0], COMMAND_RANGE[1] + 0.25, 0.5)
    found = []
    for whose, wrist in by_regulator(flexion, deviation, ("gain",)).items():
        held = round(HOLD / SAMPLE_TIME)
        steady = [float(wrist.simulate(np.full(held, v), every=held).pressure[-1]) for v in levels]
        line = _called(f"P = {wrist.regulator.gain:.3g} kPa/V · v", whose)
        found.append(Series(line, levels, wrist.regulator.gain * levels, "guide"))
        held_for = _called(f"after {HOLD:g} s of simulation", whose)
        found.append(Series(held_for, levels, np.array(steady), "points"))
    return (Panel("Regulator, steady state", "Command [V]", "Steady-state pressure [kPa]", tuple(found)),)


def regulator_step(
    flexion: Wrist, deviation: Wrist, variable: bool, command: float = 3.0
) -> tuple[Panel, ...]:
    """Figs. 6 and 8: 100 kPa, a command [V] for 12 s, 100 kPa again; with the lag regulator, or
    with the variable P one and the lag beside it.  The second panel is a close-up of the first."""
    found: list[Series] = []
    gains = by_regulator(flexion, deviation, ("gain",))
    for whose, wrist in (by_regulator(flexion, deviation) if variable else gains).items():
        rest, gain = wrist.hysteresis.rest_pressure, wrist.regulator.gain
        pressures = (rest, command * gain, rest)
        v = np.concatenate([
            commands([p], wrist.regulator, s) for p, s in zip(pressures, (2.0, 12.0, 12.0), strict=True)
        ])  # fmt: skip
        r, lag = wrist.simulate(v, every=10), wrist.as_lag_regulator(LAG).simulate(v, every=10)
        time = r.time - 2.0
        role, owner = "beside" if variable else "model", whose if len(gains) > 1 else ""
        if len(gains) > 1 or not found:  # else command and lag are there already
            asked = np.concatenate([v[::10], v[-1:]]) * gain
            found.append(Series(_called("command", owner), time, asked, "command"))
            found.append(Series(_called(f"lag of {LAG:g} s", owner), time, lag.pressure, role))
        if variable:
            found.append(Series(_called("variable P model", whose), time, r.pressure))
    whole = Panel(f"A command of {command:g} V and back", TIME, PRESSURE, tuple(found))
    seconds = 12.0 if variable else 1.2
    near = tuple(_between(s, -0.1 * seconds, seconds) for s in found)
    title = "Close-up: the last kilopascals" if variable else "Close-up: the rise"
    return whole, Panel(title, TIME, PRESSURE, near)


def _between(s: Series, low: float, high: float) -> Series:
    part = (s.x >= low) & (s.x <= high)
    return Series(s.name, s.x[part], s.y[part], s.role)


def initial_motion(flexion: Wrist, deviation: Wrist) -> tuple[Panel, ...]:
    """Fig. 10: from rest at 100 kPa to each level: steady-state angle against pressure."""
    panels = []
    for motion, wrist in (("flexion", flexion), ("deviation", deviation)):
        ends = [wrist.simulate(commands([p], wrist.regulator), every=1000) for p in INITIAL_LEVELS]
        reached = np.array([r.pressure[-1] for r in ends]), np.array([r.angle[-1] for r in ends])
        loop = wrist.hysteresis
        p: Array = np.linspace(0.0, wrist.regulator.gain * COMMAND_RANGE[1], 200)
        ends_of_zone = [loop.descending_pressure(0.0), loop.ascending_pressure(0.0)]
        p = np.sort(np.concatenate([p, np.clip(ends_of_zone, p[0], p[-1])]))
        virgin = np.minimum(np.maximum(0.0, loop.ascending(p)), loop.descending(p))
        series = (Series("virgin curve", p, virgin), Series("held for 20 s", *reached, "points"))
        panels.append(Panel(MOTIONS[motion], PRESSURE, f"Steady-state angle, + {PLUS[motion]} [deg]", series))
    return tuple(panels)


def staircase(flexion: Wrist, deviation: Wrist) -> tuple[Panel, ...]:
    """Fig. 11: applied pressure against time, and the pressure that follows."""
    time: Array = np.linspace(0.0, len(STAIRCASE) * HOLD, len(STAIRCASE) + 1)
    found = [Series("applied", time, np.array([*STAIRCASE, STAIRCASE[-1]]), "command")]
    for whose, wrist in by_regulator(flexion, deviation).items():
        r = wrist.simulate(commands(STAIRCASE, wrist.regulator), every=50)
        found.append(Series(_called("modelled pressure", whose), r.time, r.pressure))
    return (Panel("Staircase of applied pressure", TIME, PRESSURE, tuple(found)),)


def loops(flexion: Wrist, deviation: Wrist) -> tuple[Panel, ...]:
    """Fig. 12: steady-state angle against pressure on the staircase, the path between, and the
    two lines that bound it."""
    panels = []
    for motion, wrist in (("flexion", flexion), ("deviation", deviation)):
        r = wrist.simulate(commands(STAIRCASE, wrist.regulator), every=20)
        ends = np.arange(1, len(STAIRCASE) + 1) * round(HOLD / SAMPLE_TIME) // 20
        p: Array = np.linspace(0.0, wrist.regulator.gain * COMMAND_RANGE[1], 50)
        series = (
            Series("line 1", p, wrist.hysteresis.ascending(p), "guide"),
            Series("line 2", p, wrist.hysteresis.descending(p), "guide"),
            Series("path", r.pressure, r.static_angle),
            Series("steady states", r.pressure[ends], r.angle[ends], "points"),
        )
        panels.append(Panel(MOTIONS[motion], PRESSURE, f"Steady-state angle, + {PLUS[motion]} [deg]", series))
    return tuple(panels)


def drive_system(flexion: Wrist, deviation: Wrist) -> tuple[Panel, ...]:
    """Fig. 13: the angle of regulator and wrist in series on the staircase."""
    panels = []
    for motion, wrist in (("flexion", flexion), ("deviation", deviation)):
        r = wrist.simulate(commands(STAIRCASE, wrist.regulator), every=50)
        series = (Series("wrist drive system", r.time, r.angle),)
        panels.append(Panel(MOTIONS[motion], TIME, f"Angle, + {PLUS[motion]} [deg]", series))
    return tuple(panels)


def pi_step(wrist: Wrist, motion: str, every: int = 10) -> tuple[Panel, ...]:
    """Figs. 14 and 15: a step of 15 degrees under the stand-in for the paper's PI; bounds are
    taken over the range of its gains."""
    gains = paper_range()
    pi = PI.of(wrist, np.array([Kp for Kp, _ in gains]), np.array([Ki for _, Ki in gains]))
    _, _, t = run(wrist, pi, STEP, record=True)
    assert t is not None
    time, rows = t.time[::every], slice(None, None, every)

    def bounded(name: str, values: Array) -> Series:
        v = values[rows]
        return Series(name, time, v[:, 0], "model", v.min(axis=1), v.max(axis=1))

    asked = Series("reference", time, np.full(time.size, STEP), "command")
    angle, pressure = (bounded("PI, stand-in gains", x) for x in (t.angle, t.pressure))
    return (
        Panel(MOTIONS[motion], TIME, f"Angle, + {PLUS[motion]} [deg]", (asked, angle)),
        Panel("Pressure", TIME, PRESSURE, (pressure,)),
    )


SERIES: Mapping[int, Callable[[Wrist, Wrist], tuple[Panel, ...]]] = {
    5: regulator_steady,
    6: partial(regulator_step, variable=False),
    8: partial(regulator_step, variable=True),
    10: initial_motion,
    11: staircase,
    12: loops,
    13: drive_system,
    14: lambda flexion, deviation: pi_step(flexion, "flexion"),
    15: lambda flexion, deviation: pi_step(deviation, "deviation"),
}
"""What the figures that the model can redraw show of two wrists, by their numbers in the paper."""


def series(number: int, flexion: Wrist, deviation: Wrist) -> tuple[Panel, ...]:
    """One figure of the paper from two wrists; raises ValueError for a figure that cannot be."""
    if number not in SERIES:
        raise ValueError(f"Fig. {number} cannot be redrawn; one of {', '.join(map(str, SERIES))}")
    return SERIES[number](flexion, deviation)


def redrawn(wrists: Mapping[str, Wrist]) -> dict[int, tuple[Panel, ...]]:
    """All figures of the paper by number, of wrists by motion; none where one of the paper's is
    lacking."""
    if not all(motion in wrists for motion in MOTIONS):
        return {}
    return {number: series(number, *(wrists[m] for m in MOTIONS)) for number in SERIES}
