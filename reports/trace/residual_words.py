"""What a residual depends on, and how it behaves, in words."""

from collections.abc import Sequence

from plants.measured.residual.examine import Examination
from plants.measured.trace.search.description import Description
from reports.shared.tables import listed, number

UNITS = {"angle_deg": "deg", "pressure_kPa": "kPa"}
"""Channels of an answer, and their units."""

VARIABLES = {
    "pressure_kPa": "the pressure",
    "pressure_rate_kPa_s": "the pressure rate",
    "direction": "the direction of motion",
    "angle_deg": "the angle",
    "time": "time",
    "time_s": "time",
    "since_reversal_s": "the time since the last reversal",
    "work_kPa": "the path length of the pressure",
    "command_V": "the command",
    "other_pressure_kPa": "the other motion's pressure",
    "reference_deg": "the set-point",
}
"""Variables that a residual may depend on, for people; a channel of the user's own keeps its name."""

BEHAVES = {"events": "jumps at times", "changing size": "changes in size", "offset": "has an offset"}
"""What else a residual may do."""


def channel_name(channel: str) -> str:
    """What a channel measures, by its column."""
    return channel.split("_")[0]


def depends(names: Sequence[str]) -> str:
    """What a residual depends on, and how else it behaves, in words.

    >>> depends(["angle_deg", "time", "events"]), depends([])
    ('the residual depends on the angle and time, and jumps at times', 'it depends on no variable tried')
    """
    does = [BEHAVES.get(n, f"is {n}") for n in names if n in BEHAVES or n.startswith("periodic at")]
    on = [VARIABLES.get(n, n) for n in names if n not in BEHAVES and not n.startswith("periodic at")]
    said = ([f"depends on {listed(on)}"] if on else []) + does
    if not said:
        return "it depends on no variable tried"
    return f"the residual {', and '.join([', '.join(said[:-1]), said[-1]] if len(said) > 1 else said)}"


def describe(after: Examination, channel: str) -> str:
    """The residual of a channel and what it depends on, in one sentence."""
    times = f", {number(after.ratio)} times the noise" if after.noise > 0.0 else ""
    size = f"{number(after.rmse)} {UNITS[channel]} residual of the {channel_name(channel)}{times}"
    return f"{size}; {depends(after.depends_on)}."


def description(learnt: Description, channel: str) -> str:
    """How much of the residual of a channel a description accounts for, in a sentence."""
    curves = "smooth curves of " if len(learnt.variables) > 1 else "a smooth curve of "
    made = curves + listed([VARIABLES.get(v, v) for v in learnt.variables])
    accounts = "account" if len(learnt.variables) > 1 else "accounts"
    return (
        f"A description, not a cause: {made} {accounts} for {100 * learnt.described:.0f} % of the residual "
        f"of the {channel_name(channel)} beyond noise, on held-out blocks of time."
    )
