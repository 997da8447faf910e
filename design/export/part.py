"""What is exported: a law with its start and its state, as C shows it to who calls it.

The coefficients are baked into the code as constants.  A struct of them would let a target change the gains,
and thereby run something that no test vector, no certificate and no tuning has seen; other gains
are another export.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from design.controllers.measurement.plausible import Channel, SensorLimits
from design.export.fields import ANGLE, BY_HAND, PRESSURE, REFERENCE, Quantity
from design.export.precision import TOLERANCE, Precision
from design.export.rings import DelayRing, kept, rings
from plants.rig import Zero

Number = Any


class Seen(NamedTuple):
    """What a law is given in one sample, and what of it the plant's sensors show: reference [deg], angle
    [deg], pressure [kPa]."""

    reference: Number
    angle: Number
    pressure: Number


class SeenByHand(NamedTuple):
    """As `Seen`, and whether the command is given by hand (1) or not (0), and which one [V]."""

    reference: Number
    angle: Number
    pressure: Number
    manual: Number
    manual_command: Number


SEEN = (REFERENCE, ANGLE, PRESSURE)
SEEN_BY_HAND = (*SEEN, *BY_HAND)


class Watched(NamedTuple):
    """A sensor on the target: its place in `SEEN`, what it shows, and what of that is believed."""

    place: int
    shows: Quantity
    channel: Channel

    @property
    def fields(self) -> tuple[Quantity, Quantity]:
        """Members that keep the last reading that was believed, and how long ago that was."""
        return (
            Quantity(f"{self.shows.name}_believed", self.shows.unit, "last reading that was believed"),
            Quantity(f"{self.shows.name}_age", "", "samples since then"),
        )

    @property
    def last(self) -> str:
        """The member of the reading."""
        return self.fields[0].member

    @property
    def age(self) -> str:
        """The member that counts."""
        return self.fields[1].member


@dataclass(frozen=True)
class Part:
    """A law as C shows it.

    name: begins every name in C; title: what it is, in a line; period [s]; inputs: which of `SEEN` it
    reads; state: members of the struct, the last output included; output; low, high: what the output is
    clipped to, None where it is not; settings by name; code: C that CasADi made, with the functions
    NAME_init_law and NAME_step_law; begin and step: the law in Python, ``begin(pressure, angle) -> (state,
    output)`` and ``step(state, seen) -> (state, output)``, a state whose delay lines the caller fills;
    sensors: what the sensors can show; a sample beyond it is not believed;
    delays: where in the state's leaves each delay line begins, and of how many whole samples it is; notes
    for people; tolerance: how far C may be from Python, in the unit of the output; template: of NAME.c, and
    constants: what it needs; lost: what happens where a measurement is not believed, in words; takes_lost:
    whether `step` is given such a measurement, as no number, rather than held; precision: of the C; by_hand:
    whether it may be commanded by hand, so that it reads `SEEN_BY_HAND`; under_way: how many of its last
    outputs it keeps, those that a dead time in its model holds back; zero: what the rig logs where pressure
    and angle of the law are 0.
    """

    name: str
    title: str
    period: float
    inputs: tuple[Quantity, ...]
    state: tuple[Quantity, ...]
    output: Quantity
    low: float | None
    high: float | None
    settings: Mapping[str, float]
    code: str
    begin: Callable[[float, float], tuple[Any, float]]
    step: Callable[[Any, Any], tuple[Any, float]]
    sensors: SensorLimits
    delays: tuple[tuple[int, int], ...] = ()
    notes: tuple[str, ...] = ()
    tolerance: float = 1e-9
    template: str = "law.c.jinja"
    constants: Mapping[str, Any] = field(default_factory=dict)
    lost: str = "the state is left as it was and the output is that of the last good sample"
    takes_lost: bool = False
    precision: Precision = "double"
    by_hand: bool = False
    under_way: int = 0
    zero: Zero = field(default_factory=Zero)

    def at(self, precision: Precision) -> "Part":
        """The same part in a precision, held to what that can do."""
        tolerance = TOLERANCE[self.template] if precision == "single" else self.tolerance
        return replace(self, precision=precision, tolerance=tolerance)

    @property
    def real(self) -> str:
        """The type of its numbers in C."""
        return "float" if self.precision == "single" else "double"

    @property
    def kept(self) -> list[tuple[int, Quantity]]:
        """Leaves of the state that the struct keeps, with their places: of a delay line not what is read
        from it anew in every sample."""
        return kept(self.state, self.delays)

    @property
    def read(self) -> list[tuple[int, Quantity]]:
        """The inputs, with their places in `SEEN`."""
        return [(SEEN_BY_HAND.index(f), f) for f in self.inputs]

    @property
    def seen(self) -> type[Seen] | type[SeenByHand]:
        """What it is given in one sample."""
        return SeenByHand if self.by_hand else Seen

    @property
    def counted(self) -> dict[str, str]:
        """In C, what the law counts of what the rig logs, ``logged``, by the quantity, where they differ."""
        zero, found = self.zero, {}
        if zero.pressure:
            found["pressure"] = f"logged - ({zero.pressure!r})"
        if zero.reversed:
            found["angle"] = f"{zero.angle!r} - logged"
        elif zero.angle:
            found["angle"] = f"logged - ({zero.angle!r})"
        return found

    def of_log(self, quantity: str, value: str) -> str:
        """In C, what the law counts of a value that the rig logs; the reference is counted as the angle."""
        what = "angle" if quantity == "reference" else quantity
        return f"{self.name}_{what}_of_log({value})" if what in self.counted else value

    @property
    def watched(self) -> list["Watched"]:
        """The sensors among the inputs, whose readings are believed or not."""
        own = {ANGLE: self.sensors.angle, PRESSURE: self.sensors.pressure}
        return [Watched(i, f, own[f].sampled(self.period)) for i, f in self.read if f in own]

    def within(self, output: float) -> float:
        """An output clipped to its range; what is no number becomes its lower end."""
        if self.low is None or self.high is None:
            return output
        return self.high if output > self.high else output if output >= self.low else self.low

    @property
    def lines(self) -> list["DelayRing"]:
        """The delay lines; that of its own outputs is filled with the first, which comes after the state."""
        first = sum(f.size for f in self.state)
        own = [DelayRing(first - 2, self.under_way, self.output)] if self.under_way else []
        return [*rings(self.state, self.delays), *own]

    @property
    def members(self) -> list[Quantity]:
        """Members of the struct of the state: what is kept, the rings of the delay lines, the last output."""
        last = self.output._replace(name=f"last_{self.output.name}", meaning="output of the last good sample")
        rings = (f for line in self.lines for f in line.fields)
        return [*(f for _, f in self.kept), *rings, *(f for w in self.watched for f in w.fields), last]

    @property
    def watched_for(self) -> list[str]:
        """What is believed of each sensor, a line each; of the reference the range of the angle."""
        return [f"  {name} = {value!r}" for name, value in self.sensors.settings.items()]

    @property
    def set_to(self) -> list[str]:
        """The settings, a line each."""
        return [f"  {name} = {value!r}" for name, value in self.settings.items()]
