"""Which channel is the command, the pressure, the angle, the reference: by name, by unit, by what leads.

A name or a unit says what a channel may be.  Where several may be the same, the physics decides: a command
moves before the pressure, the pressure before the angle, and what a computer writes has no noise.
"""

import re
from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from plants.errors import InputError
from plants.measured.fitting.noise import noise_floor
from plants.measured.formats.cells import shorten
from plants.measured.formats.channel import Array, LoggedChannel
from plants.measured.formats.columns import ATMOSPHERE
from plants.measured.formats.units import AS_THEY_ARE, KINDS, factor, kept, quantity
from plants.measured.importing.lead import lead
from plants.measured.importing.names import ASKED, HINTS, LENGTHS, is_counted
from plants.measured.importing.orientation import orientations
from plants.measured.importing.pressure_zero import above_vacuum, counts_from_vacuum, deepens, of_air

ROLES = {
    "reference": "reference_deg", "command": "command_V", "pressure": "pressure_kPa", "angle": "angle_deg",
}  # fmt: skip
"""Roles, and the standard columns that they fill."""

NAMED, ALSO_NAMED, OF_UNIT, OF_OTHER, QUIET, LEADS = 3.0, 1.0, 2.0, -4.0, 1.0, 1.5
"""Points: for a name, for one that fits another role before, for a unit and for one of another quantity, for
a command without noise, for each pair in which cause comes before effect."""

OPTIONAL = 2.0
"""Points that a channel needs to be taken for one that a campaign may lack."""

ALIKE = 0.5
"""Likeness from which a channel without name and unit, between the command and the angle, is the pressure."""

CANDIDATES = 5

RADIANS, BARS, PASCALS = 1.2, 16.0, 5000.0
"""An angle that stays below is in rad; a pressure that stays below is in bar, one that exceeds this in Pa."""

VOLTS = 48.0
"""A command without a unit that exceeds this is hardly in V."""

PAIRS = (("command", "pressure"), ("command", "angle"), ("pressure", "angle"), ("reference", "angle"))


COUNTS = "counts"
CONVERTERS = (255, 1023, 4095, 16383, 65535)
"""Largest counts of usual converters."""


class Role(NamedTuple):
    """What fills a role: the channel's name, its unit as taken, factor to the standard unit, and why;
    absolute: whether it is a pressure above vacuum; quaternion: the four channels of an orientation, whose
    first is the channel."""

    channel: str
    unit: str
    factor: float
    why: str
    absolute: bool = False
    quaternion: tuple[str, ...] = ()

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of all its channels."""
        return self.quaternion or (self.channel,)

    def entry(self, columns: Mapping[str, str] | None = None) -> str | dict[str, object]:
        """What ``[columns]`` says of it; columns: those of the file by channel, where they differ.

        >>> Role("p", "hPa", 0.1, "", absolute=True).entry({"p": "p (hPa)"})
        {'name': 'p (hPa)', 'unit': 'hPa', 'absolute': True}
        """
        names = [(columns or {}).get(c, c) for c in self.channels]
        if self.quaternion:
            return {"quaternion": names}
        if self.absolute and self.factor < 0.0:
            return {"name": names[0], "scale": self.factor, "offset": ATMOSPHERE}
        if self.absolute:
            return {"name": names[0], "unit": self.unit, "absolute": True}
        if self.unit in AS_THEY_ARE:
            return {"name": names[0], "unit": self.unit}
        return names[0] if self.factor == 1.0 else {"name": names[0], "scale": self.factor}


def roles(channels: Sequence[LoggedChannel], given: Mapping[str, tuple[str, str]]) -> dict[str, Role]:
    """The channel of each role, by role.

    given: what the user says, role to name and unit ("" for the channel's own).
    Raises InputError for a name that no channel has, and where the command, or what it moves, cannot be told.
    """
    named = {c.name: c for c in channels}
    for role, (name, _) in given.items():
        if name not in named:
            raise InputError(f"--map {role}={name}: no such channel; the log has {shorten(list(named))}")
    turning = orientations(channels)
    parts = {n for _, names in turning.values() for n in names}
    known = {**named, **{name: angle for name, (angle, _) in turning.items()}}
    chosen = {role: (named if unit else known)[name] for role, (name, unit) in given.items()}
    taken_already = {name for name, _ in given.values()}
    free = [
        c
        for n, c in known.items()
        if n not in taken_already and (n in turning or n not in parts) and np.ptp(c.values) > 0.0
    ]
    left = [r for r in ROLES if r not in chosen]
    points = {r: {c.name: _points(r, c) for c in free if r == "angle" or c.name not in turning} for r in left}
    options = {r: _options(points[r], r) for r in left}
    best, most = chosen, -np.inf
    for names in product(*options.values()):
        taken = [n for n in names if n is not None]
        if len(set(taken)) < len(taken):
            continue
        trial = chosen | {r: known[n] for r, n in zip(left, names, strict=True) if n is not None}
        if not _between(trial, points.get("pressure", {})):
            continue
        total = sum(points[r][n] for r, n in zip(left, names, strict=True) if n is not None)
        total += sum(_led(trial[a], trial[b]) for a, b in PAIRS if a in trial and b in trial)
        if "command" in trial and ("angle" in trial or "pressure" in trial) and total > most:
            best, most = trial, total
    if "command" not in best or not {"angle", "pressure"} & set(best):
        raise InputError(
            "the command and the angle, or the pressure, cannot be told among the channels "
            f"{shorten(list(named))}; say --map command=NAME --map angle=NAME"
        )
    found = {r: _role(r, best[r], given.get(r), best) for r in ROLES if r in best}
    if "pressure" in best:
        found["pressure"] = _of_vacuum(found["pressure"], best["command"], best["pressure"])
    for role, of in found.items():
        if of.channel in turning and best[role] is turning[of.channel][0]:
            names = turning[of.channel][1]
            why = of.why.replace("unit deg", f"the angle that the orientation {', '.join(names)} has turned")
            found[role] = of._replace(quaternion=names, why=why)
    return found


def _between(trial: Mapping[str, LoggedChannel], points: Mapping[str, float]) -> bool:
    """Whether a pressure that nothing says to be one moves after the command and before the angle, much as
    they do; true of one that has a name or a unit."""
    if "pressure" not in trial or points.get(trial["pressure"].name, OPTIONAL) >= OPTIONAL:
        return True
    if not {"command", "angle"} <= trial.keys():
        return False
    leads = lead(trial["command"], trial["pressure"]), lead(trial["pressure"], trial["angle"])
    return all(lag > 0.0 and likeness > ALIKE for lag, likeness in leads)


def _options(points: Mapping[str, float], role: str) -> list[str | None]:
    """Channels that may fill a role, the likeliest first, and none."""
    least = {"reference": OPTIONAL, "pressure": -0.5}.get(role, OF_OTHER + OF_UNIT)
    likely = sorted(
        (n for n in points if points[n] > least or points[n] == least == OPTIONAL), key=lambda n: -points[n]
    )
    return [*likely[:CANDIDATES], None]


def _points(role: str, channel: LoggedChannel) -> float:
    """How much name, unit and noise of a channel speak for a role."""
    points = 0.0
    name = channel.name.lower()
    hinted = [r for r, column in ROLES.items() if re.search(HINTS[column], name)]
    if re.search(ASKED, name):  # of the pressure, not of the angle
        hinted = ["command"]
    if role in hinted:
        points += NAMED if hinted[0] == role else ALSO_NAMED
    kind = quantity(channel.unit) if channel.unit else None
    if kind is not None and (role, channel.unit) not in {("angle", unit) for unit in LENGTHS}:
        asked = role == "command" and kind == "pressure" and {"command", "reference"} & set(hinted)
        own = kind == ("angle" if role == "reference" else role)
        points += OF_UNIT if own else 0.0 if asked else OF_OTHER  # a regulator is asked for a pressure
    if role in ("command", "reference") and _is_written(channel.values):
        points += QUIET
    return points


def _is_written(values: Array) -> bool:
    """Whether a series has no noise, as one that a computer made."""
    thin = values[:20_000]
    return len(thin) > 8 and noise_floor(thin) < 1e-3 * float(np.ptp(values))


def _led(cause: LoggedChannel, effect: LoggedChannel) -> float:
    """Points for a pair, in the order of cause and effect."""
    lag, likeness = lead(cause, effect)
    return LEADS * float(np.sign(lag)) if likeness > 0.2 else 0.0


def _role(
    role: str, channel: LoggedChannel, given: tuple[str, str] | None, all_of: Mapping[str, LoggedChannel]
) -> Role:
    """A channel in its role: unit, factor and reasons."""
    unit, why = channel.unit, []
    if given is not None:
        unit = given[1] or unit
        why.append("given by --map")
    else:
        if re.search(HINTS[ROLES[role]], channel.name.lower()):
            why.append("by its name")
        for a, b in PAIRS:
            if role in (a, b) and a in all_of and b in all_of:
                lag, like = lead(all_of[a], all_of[b])
                if like > 0.2 and lag > 0.0:
                    other = b if role == a else a
                    why.append(f"{'leads' if role == a else 'follows'} the {other} by {lag:.2g} s")
                elif like > ALIKE and lag < 0.0 and (role, a, b) == ("command", "command", "pressure"):
                    why.append(f"yet follows the pressure by {-lag:.2g} s: are the two exchanged?")
    wanted = "angle" if role == "reference" else role
    if not unit and wanted == "angle" and is_counted(channel.name):
        unit = COUNTS
    kind = quantity(unit) if unit else None
    as_it_is = kept(unit, role)
    if given is not None and given[1] and kind != wanted and not as_it_is:
        factor(unit, role, f"--map {role}={channel.name}")  # which raises, and says why
    if as_it_is:
        said = f"unit {unit}" if role == "command" else f"no angle but {as_it_is}, in which it stays"
        if wanted == "angle" and as_it_is == COUNTS:
            turn = f'{{name = "{channel.name}", counts = COUNTS_PER_TURN, full = 360.0}}'
            said += f"; {turn} gives it in deg, with the encoder's counts in place of COUNTS_PER_TURN"
        return Role(channel.name, as_it_is, 1.0, ", ".join([*why, said]))
    if kind == wanted:
        why.append(f"unit {unit}")
        to_standard = factor(unit, role, channel.name)
        absolute = role == "pressure" and above_vacuum(channel, to_standard)
        if absolute and not (given and given[1]) and counts_from_vacuum(channel):
            why.append("above vacuum")
            return Role(channel.name, unit, to_standard, ", ".join(why), True)
        if absolute:
            why.append(f'starts near that of the air: add unit = "{unit}", absolute = true if above vacuum')
        return Role(channel.name, unit, to_standard, ", ".join(why))
    guessed, most = _unit_by_range(role, channel.values), float(np.max(np.abs(channel.values)))
    if role != "command":
        why.append(f"its unit {unit or 'is not told'}{' is not known' * bool(unit)}: {guessed} by its range")
    elif unit or most <= VOLTS:
        why.append(f"its unit {unit} is taken for V" if unit else "its unit is not told: taken for V")
    elif full := _full_scale(channel.values):
        guessed = COUNTS
        why.append(
            "its unit is not told: taken for counts of a converter, as they are whole numbers; "
            f'{{name = "{channel.name}", counts = {full}, full = 10.0}} says that {full} are 10 V'
        )
    else:
        why.append(
            f"its unit is not told: taken for V, though {most:.6g} is much: "
            f'--map "command={channel.name} [mV]" gives another'
        )
    return Role(channel.name, guessed, factor(guessed, role, channel.name), ", ".join(why))


def _of_vacuum(role: Role, command: LoggedChannel, pressure: LoggedChannel) -> Role:
    """The role of a pressure, counted below that of the air where it is a vacuum that the command deepens."""
    air = of_air(pressure, role.factor)
    if not deepens(command, pressure, air):
        return role
    why = f"{role.why}, a vacuum that deepens as the command rises: counted below the air's"
    return role._replace(factor=-role.factor, why=why, absolute=bool(air))


def _full_scale(values: Array) -> int | None:
    """The largest count of a converter whose counts a series may be, None for what is no counts."""
    if values.min() < 0.0 or np.any(values != np.round(values)):
        return None
    return next((c for c in CONVERTERS if values.max() <= c), None)


def _unit_by_range(role: str, values: Array) -> str:
    """A unit in which values of this size can be meant."""
    most = float(np.max(np.abs(values)))
    if role in ("angle", "reference"):
        return "rad" if most < RADIANS else "deg"
    if role == "pressure":
        return "bar" if most < BARS else "Pa" if most > PASCALS else "kPa"
    return KINDS[role]
