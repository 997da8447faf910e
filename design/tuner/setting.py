"""What the sliders say, and the wrist that it makes of the user's own."""

from dataclasses import dataclass, fields
from typing import NamedTuple

from design.synthesis.answer import UNITS
from design.synthesis.tuning import Region
from design.synthesis.tuning_rules import PAPER_GAINS
from plants.effects.regulator.dead_time import DeadTime
from plants.hysteresis import Role
from plants.rig import Rig
from plants.wrist import Wrist

REGION = Region(Kp=(0.5, 20.0), Ki=(0.5, 100.0))
"""Gains that the sliders of the built-in rig reach where none are given: what holds 15 degrees in either
motion, and around."""

DELAY = f"{DeadTime.NAME}.{DeadTime.DELAY}"


@dataclass(frozen=True)
class Setting:
    """Positions of the sliders.

    Kp [kPa/deg], Ki [kPa/(deg s)], in the units of the rig; factors of the wrist's own parameters: width of
    both offsets w1 and w2, lines of the slopes a1 and a2, transit of the slope s; dead_time [s], the whole
    of it.
    """

    Kp: float = PAPER_GAINS[0]
    Ki: float = PAPER_GAINS[1]
    width: float = 1.0
    lines: float = 1.0
    transit: float = 1.0
    dead_time: float = 0.0

    @property
    def of_plant(self) -> tuple[float, ...]:
        """What makes the plant, without the gains."""
        return self.width, self.lines, self.transit, self.dead_time

    def moved(self, other: "Setting") -> list[str]:
        """Names of the sliders that stand elsewhere in another setting."""
        return [f.name for f in fields(self) if getattr(self, f.name) != getattr(other, f.name)]


class Slider(NamedTuple):
    """A slider: name in a `Setting`, label, unit and factor to it for people, range, whether its scale is
    logarithmic, and what it changes."""

    name: str
    label: str
    unit: str
    per_unit: float
    low: float
    high: float
    logarithmic: bool
    meaning: str


def region_of(rig: Rig) -> Region:
    """Gains that the sliders of a rig reach where none are given: as much of its pressure for as much of its
    step as `REGION` has.

    >>> from dataclasses import replace
    >>> from plants.rig import Units, built_in_rig
    >>> region_of(replace(built_in_rig(), units=Units("V", "bar", "deg"), pressure_range=(0.0, 2.0))).Kp
    (0.005, 0.2)
    """
    Kp, Ki = (
        tuple(round(rig.scaled(v, unit), 9) for v in getattr(REGION, name)) for name, unit in UNITS.items()
    )
    return Region(Kp=(Kp[0], Kp[1]), Ki=(Ki[0], Ki[1]))


def sliders(region: Region, rig: Rig, own_dead_time: float = 0.0) -> tuple[Slider, ...]:
    """The sliders; that of the dead time reaches 0.2 s, and twice that of the wrist [s], and what the rig may
    have, where this is more.

    >>> from plants.rig import built_in_rig
    >>> [s.name for s in sliders(REGION, built_in_rig())]
    ['Kp', 'Ki', 'width', 'lines', 'transit', 'dead_time']
    """
    longest = DeadTime.kinds()["delay"].high
    late = min(max(0.2, 2.0 * own_dead_time, 2.0 * rig.uncertainty.dead_time[1]), longest)
    pressure, angle = rig.units.pressure, rig.units.angle
    return (
        Slider("Kp", "Kp", f"{pressure}/{angle}", 1.0, *region.Kp, True, "proportional gain"),
        Slider("Ki", "Ki", f"{pressure}/({angle} s)", 1.0, *region.Ki, True, "integral gain"),
        Slider("width", "Loop width", "×", 1.0, 0.3, 2.0, False, "factor of the offsets w1 and w2"),
        Slider("lines", "Line slopes", "×", 1.0, 0.5, 1.5, False, "factor of the slopes a1 and a2"),
        Slider("transit", "Transit slope", "×", 1.0, 0.0, 3.0, False, "factor of the slope s"),
        Slider("dead_time", "Dead time", "ms", 1000.0, 0.0, late, False, "of the tube, the whole of it"),
    )


def initial(wrist: Wrist) -> Setting:
    """The setting at which the wrist is the user's own, with the paper's gains, scaled to the rig.

    >>> initial(Wrist.flexion() + DeadTime(0.05)).dead_time
    0.05
    """
    Kp, Ki = (wrist.rig.scaled(v, unit) for v, unit in zip(PAPER_GAINS, UNITS.values(), strict=True))
    return Setting(Kp, Ki, dead_time=float(wrist.values.get(DELAY, 0.0)))


def plant(wrist: Wrist, setting: Setting) -> Wrist:
    """The wrist of a setting, made of the user's own; it has a dead time as an effect even where that is
    zero, so that moving the slider never makes another kind of plant, which would be compiled anew.

    >>> moved = plant(Wrist.flexion(), Setting(width=0.5, dead_time=0.02))
    >>> moved.hysteresis.w1, moved.values["dead-time.delay"]
    (3.0, 0.02)
    """
    v, roles = wrist.values, wrist.hysteresis.roles(wrist.hysteresis.values)
    factors: dict[Role, float] = {"width": setting.width, "outer": setting.lines, "inner": setting.transit}
    loop = {n: v[n] * factor for role, factor in factors.items() for n in roles[role]}
    late = wrist if DELAY in wrist.values else wrist + DeadTime()
    return late.with_values(**loop, **{DELAY: setting.dead_time})


def trouble(wrist: Wrist) -> str | None:
    """Why the parameters of a wrist make no loop within the range of the command, in one line, or None.

    >>> trouble(plant(Wrist.flexion(), Setting(lines=0.5, transit=3.0)))
    'transit slope s = 0.2409 is not below a1 = 0.18, so the loop runs backwards'
    """
    return wrist.hysteresis.problem(*wrist.reach)
