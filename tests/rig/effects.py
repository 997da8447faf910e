"""All hidden effects of a rig, and how one is drawn by name.

The names of the vocabulary are those of the measured-data format; a variant is the number of
a functional form, counted from 1.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from tests.rig import joint_effects as joint
from tests.rig import open_effects
from tests.rig import regulator_effects as regulator
from tests.rig import sensor_effects as sensor
from tests.rig import wrist_effects as wrist
from tests.rig.open_effects import OpenEffects
from tests.rig.parameters import Declared


class Hidden(NamedTuple):
    """Everything that the declared model does not know; nothing by default."""

    dead_time: regulator.DeadTime = regulator.DeadTime()
    asymmetry: regulator.Asymmetry = regulator.Asymmetry()
    deadband: regulator.Deadband = regulator.Deadband()
    supply: regulator.Supply = regulator.Supply()
    leak: regulator.Leak = regulator.Leak()
    creep: wrist.Creep = wrist.Creep()
    curvature: wrist.Curvature = wrist.Curvature()
    rate: wrist.RateDependence = wrist.RateDependence()
    load: wrist.LoadStep = wrist.LoadStep()
    softening: wrist.Softening = wrist.Softening()
    coupling: wrist.Coupling = wrist.Coupling()
    inertia: joint.Inertia = joint.Inertia()
    stop: joint.EndStop = joint.EndStop()
    shape: wrist.LoopShape = wrist.LoopShape()
    stick: joint.StickSlip = joint.StickSlip()
    drift: sensor.GyroDrift = sensor.GyroDrift()
    hum: sensor.Hum = sensor.Hum()
    open: OpenEffects = OpenEffects()


class Entry(NamedTuple):
    """Of one name: the field of Hidden that it fills, the number of its forms that suites draw from, its
    draw, and how many more there are, which come by their number only, so that no suite's rigs change."""

    field: str
    forms: int
    draw: Callable[..., Any]
    more: int = 0

    @property
    def last(self) -> int:
        """Number of the last form."""
        return self.forms + self.more


CATALOGUE = {
    "dead-time": Entry("dead_time", 2, regulator.draw_dead_time),
    "fill-exhaust-asymmetry": Entry("asymmetry", 3, regulator.draw_asymmetry, more=1),
    "regulator-deadband": Entry("deadband", 2, regulator.draw_deadband),
    "supply-droop": Entry("supply", 3, regulator.draw_supply),
    "leak": Entry("leak", 2, regulator.draw_leak),
    "creep": Entry("creep", 3, wrist.draw_creep),
    "branch-curvature": Entry("curvature", 3, wrist.draw_curvature),
    "rate-dependence": Entry("rate", 4, wrist.draw_rate_dependence),
    "load-step": Entry("load", 3, wrist.draw_load_step),
    "softening": Entry("softening", 3, wrist.draw_softening),
    "cross-coupling": Entry("coupling", 3, wrist.draw_coupling),
    "inertia": Entry("inertia", 3, joint.draw_inertia),
    "end-stop": Entry("stop", 3, joint.draw_end_stop),
    "loop-shape": Entry("shape", 3, wrist.draw_loop_shape),
    "stick-slip": Entry("stick", 3, joint.draw_stick_slip),
    "gyro-drift": Entry("drift", 2, sensor.draw_drift),
    "periodic-disturbance": Entry("hum", 2, sensor.draw_hum),
}
VOCABULARY = tuple(CATALOGUE)
OPEN = tuple(open_effects.DRAWS)
NEEDS_THE_RIG = ("branch-curvature", "end-stop")  # their strength is relative to the rig's own range


def draw_effect(
    name: str, variant: int | None, rng: np.random.Generator, rig: Declared, scale: float = 1.0
) -> tuple[str, Any]:
    """(field, parameters) of one effect; a variant of None is drawn too.  Raises KeyError or ValueError."""
    if name in open_effects.DRAWS:
        return name.replace("-", "_"), open_effects.DRAWS[name](scale, rng)
    entry = CATALOGUE[name]
    drawn = int(rng.integers(1, entry.forms + 1))
    form = drawn if variant is None else variant
    if not 1 <= form <= entry.last:
        raise ValueError(f"{name} has the variants 1 to {entry.last}")
    more = (rig,) if name in NEEDS_THE_RIG else ()
    return entry.field, entry.draw(form, scale, rng, *more)


def draw_hidden(
    names: list[str], variants: dict[str, int], rng: np.random.Generator, rig: Declared, scale: float = 1.0
) -> Hidden:
    """All effects of a rig, drawn in the order given."""
    hidden = Hidden()
    for name in names:
        field, parameters = draw_effect(name, variants.get(name), rng, rig, scale)
        parameters = plain(parameters)
        if name in open_effects.DRAWS:
            hidden = hidden._replace(open=hidden.open._replace(**{field: parameters}))
        else:
            hidden = hidden._replace(**{field: parameters})
    return hidden


def plain(value: Any) -> Any:
    """The same NamedTuple with Python's own numbers, so that one compiled integrator serves all rigs."""
    return type(value)(*(tuple(map(float, v)) if isinstance(v, tuple) else _number(v) for v in value))


def _number(value: Any) -> int | float:
    return int(value) if isinstance(value, int | np.integer) else float(value)
