"""The whole plant as C shows it: regulator, hysteresis, lag, and every effect that its parameter set has.

It is the law that is simulated (`plants.dynamics.step`), its coefficients baked in, with the time that passes
in its state, so that a load that comes and a sensor that drifts do so on the target too.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from design.export.fields import Quantity, described, lines_of
from design.export.rings import DelayRing, kept, rings, samples_of
from plants.dynamics import State, read, settled, step
from plants.effects.effect import Around
from plants.equilibrium import holding_command
from plants.errors import InputError
from plants.kernel import pytrees
from plants.kernel.graphs import NO_GRAPH, baked, c_source, graph, used
from plants.meanings import remembers
from plants.wrist import Wrist

Number = Any

TOLERANCE = 1e-9
"""How far C may be from Python, as a share of the range of the pressure, and of the angles that it gives."""


class PlantInput(NamedTuple):
    """What the plant is given in one sample: command [V], pressure of the other motion [kPa]."""

    command: Number
    other_pressure: Number


class PlantOutput(NamedTuple):
    """What its sensors show after the sample: angle [deg], pressure [kPa]."""

    angle: Number
    pressure: Number


@remembers(sample=("", "samples since the start"), begin=("s", "time of the start"))
class PlantMemory(NamedTuple):
    """The plant, samples since the start, and the time of the start [s]."""

    plant: State
    sample: Number
    begin: Number


@dataclass(frozen=True)
class PlantPart:
    """A plant as C shows it.

    name: begins every name in C; title: what it is, in a line; period [s], of a sample; inputs: which of
    `PlantInput` it depends on, and columns: their places in it; at_rest: what they are while it rests;
    outputs: angle and pressure as its sensors show them; state: leaves of the state; delays: where among
    them each delay line begins, and of how many whole samples it is; settings: parameters by name; code: C
    that CasADi made, with the functions NAME_init_law and NAME_step_law; tolerance: how far C may be from
    Python, of each output in its unit.
    """

    name: str
    title: str
    period: float
    inputs: tuple[Quantity, ...]
    columns: tuple[int, ...]
    at_rest: tuple[float, ...]
    outputs: tuple[Quantity, Quantity]
    state: tuple[Quantity, ...]
    delays: tuple[tuple[int, int], ...]
    settings: Mapping[str, float]
    code: str
    tolerance: tuple[float, float]

    @property
    def kept(self) -> list[tuple[int, Quantity]]:
        """Leaves of the state that the struct keeps, with their places."""
        return kept(self.state, self.delays)

    @property
    def lines(self) -> list[DelayRing]:
        """The delay lines."""
        return rings(self.state, self.delays)

    @property
    def members(self) -> list[Quantity]:
        """Members of the struct of the state: what is kept, the rings of the delay lines."""
        return [*(f for _, f in self.kept), *(f for line in self.lines for f in line.fields)]

    @property
    def set_to(self) -> list[str]:
        """The settings, a line each."""
        return [f"  {name} = {value!r}" for name, value in self.settings.items()]


def of_plant(name: str, title: str, wrist: Wrist) -> PlantPart:
    """The part of a plant with all its effects, at the sample time of its rig.

    Raises InputError for an effect whose state nobody described, or that has no C.
    """
    c, dt, rest = _floats(wrist.sampled()), wrist.rig.sample_time, float(wrist.rig.rest_pressure)
    start = _floats(wrist.rest())

    def around(begin: Number, sample: Number, given: PlantInput) -> Around:
        return Around(begin + sample * dt, given.other_pressure - rest)

    def begun(begin: tuple[Number], given: PlantInput) -> tuple[PlantMemory, PlantOutput]:
        first = around(begin[0], 0.0, given)
        plant = settled(start, c, first)
        return PlantMemory(plant, 0.0, begin[0]), PlantOutput(read(plant, c, first), plant.pressure)

    def moved(m: PlantMemory, given: PlantInput) -> tuple[PlantMemory, PlantOutput]:
        now = around(m.begin, m.sample, given)
        plant = step(m.plant, given.command, c, now)
        seen = read(plant, c, now._replace(time=now.time + dt))
        return PlantMemory(plant, m.sample + 1.0, m.begin), PlantOutput(seen, plant.pressure)

    example, nothing = PlantMemory(start, 0.0, 0.0), PlantInput(0.0, 0.0)
    try:
        init_law = baked(f"{name}_init_law", graph(begun, (0.0,), nothing))
        step_law = baked(f"{name}_step_law", graph(moved, example, nothing))
    except NO_GRAPH:
        raise InputError(
            f"plant: {_without_c(wrist)}: its law has no C; write it with NumPy ufuncs"
        ) from None
    needed = [True, used(step_law, 1)[1] or used(init_law, 1)[1]]
    columns = tuple(i for i, wanted in enumerate(needed) if wanted)
    inputs, outputs = _signals(wrist)
    held = float(holding_command(wrist, start.pressure)), rest
    low, high = wrist.rig.pressure_range
    least, most = (float(x) for x in wrist.hysteresis.reachable(low, high))
    return PlantPart(
        name, title, dt, tuple(inputs[i] for i in columns), columns, tuple(held[i] for i in columns), outputs,
        _members(example, wrist), tuple(zip(lines_of(example), samples_of(c), strict=True)),
        {n: float(v) for n, v in wrist.values.items()}, c_source(f"{name}_law", init_law, step_law),
        (TOLERANCE * (most - least), TOLERANCE * (high - low)),
    )  # fmt: skip


def _without_c(wrist: Wrist) -> str:
    """What of a plant whose law is no graph makes it none: one of its effects, or its hysteresis."""
    for effect in wrist.effects:
        alone = replace(wrist, effects=(effect,))
        c = _floats(alone.sampled())
        try:
            graph(lambda s, u, c=c: step(s, u[0], c), _floats(alone.rest()), (0.0,))
        except NO_GRAPH:
            return f"{effect.NAME} ({effect.FORM})"
    return f"{wrist.hysteresis.NAME} hysteresis"


def _floats(tree: Any) -> Any:
    return pytrees.like(tree, [float(x) for x in pytrees.leaves(tree)])


def _signals(wrist: Wrist) -> tuple[tuple[Quantity, Quantity], tuple[Quantity, Quantity]]:
    u = wrist.rig.units
    return (
        Quantity("command", u.command, "command to the regulator, held for a sample"),
        Quantity("other_pressure", u.pressure, "pressure of the other motion"),
    ), (
        Quantity("angle", u.angle, "angle that the sensor shows"),
        Quantity("pressure", u.pressure, "pressure"),
    )


def _members(example: PlantMemory, wrist: Wrist) -> tuple[Quantity, ...]:
    """The leaves of the state, named by effect rather than by its number, in the units of the rig."""
    to = wrist.rig.unit

    def named(field: Quantity) -> Quantity:
        name = field.name.removeprefix("plant_")
        found = re.match(r"effects_(\d+)_", name)
        if found:
            name = f"{wrist.effects[int(found[1])].NAME}_{name[found.end() :]}"
        return field._replace(name=re.sub(r"\W+", "_", name, flags=re.ASCII), unit=to(field.unit))

    return tuple(map(named, described(example)))
