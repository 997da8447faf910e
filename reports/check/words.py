"""What a check says in sentences."""

from design.studies.check.check import LogCheck
from design.studies.check.envelope import FigureCheck
from design.studies.check.residual import RigChange
from design.studies.check.stairs import Stair
from plants.effects.wrist.remainder import ColouredRemainder
from reports.shared.tables import listed, number

LITTLE = 0.25
"""Share of a step of the task that a residual may hide and still tell whether the plant has changed."""


def title(check: LogCheck) -> str:
    """The answer in a line: the heading, and what the command says last."""
    return f"{promise(check)}; {plant(check)}"


def promise(check: LogCheck) -> str:
    """Whether the log is within what the design predicted, and what departs first."""
    e = check.envelope
    if e.first is None:
        return f"{check.log.name} is inside the envelope of {e.samples} samples"
    f = e.first
    return (
        f"{check.log.name} is outside the envelope of {e.samples} samples: {departure(f)}, at the step to "
        f"{asked(check, check.stairs[f.stair])}, {number(check.stairs[f.stair].begins)} s"
    )


def asked(check: LogCheck, stair: Stair) -> str:
    """The reference of a stair, as the log has it."""
    rig = check.plant.rig
    return f"{number(rig.zero.logged(stair.reference))} {rig.units.angle}"


def departure(f: FigureCheck) -> str:
    """A figure beside what the samples have of it."""
    unit = "" if f.unit == "1" else f" {f.unit}"
    return f"{f.name} {number(f.value)}{unit} (samples {number(f.low)} to {number(f.high)}{unit})"


def plant(check: LogCheck) -> str:
    """Whether the residual is that of the trace."""
    r = check.residual
    below = hidden(check)
    if not r.new and tells_little(check):
        return f"whether the plant has changed by less than {below} cannot be told"
    if not r.new:
        return f"the plant is unchanged since the trace{f', to within {below}' if below else ''}"
    sizes = [
        f"{number(c.rms)} {c.channel.split('_')[1]} in the {c.channel.split('_')[0]} (expected: at most "
        f"{number(c.allowed)})"
        for c in r.channels
        if c.new
    ]
    cause = "no single change explains it" if r.change is None else change(r.change)
    return f"the plant has changed, its residual is {listed(sizes)}: {cause}"


def hidden(check: LogCheck) -> str:
    """Up to which error of the angle the residual of the trace hides a change; empty for a plant that leaves
    nothing."""
    kept = check.plant.remainder.get("angle_deg")
    found = [c.allowed for c in check.residual.channels if c.channel == "angle_deg"]
    return f"{number(found[0])} deg" if found and ColouredRemainder.of(kept) is not None else ""


def tells_little(check: LogCheck) -> bool:
    """Whether the trace left so much of the angle that a change of the plant hides in it."""
    allowed = [c.allowed for c in check.residual.channels if c.channel == "angle_deg"]
    return bool(hidden(check)) and allowed[0] > LITTLE * check.plant.rig.task.step


def change(c: RigChange) -> str:
    """The change that explains a new residual."""
    unit = "" if c.unit == "1" else f" {c.unit}"
    return f"{c.name} {number(c.size)}{unit} explains {number(100 * c.takes, 2)} % of it"


def summary(check: LogCheck) -> list[str]:
    """Three sentences: the promise, the plant, what to do."""
    advice = {
        "as promised": "No action is needed.",
        "changed": "The prediction holds; record and trace a new campaign before you rely further on the "
        "plant model.",
        "broken": "Record a campaign, trace it, and design again before you trust this controller.",
    }[check.verdict]
    return [f"{promise(check)}.", f"{plant(check)[0].upper()}{plant(check)[1:]}.", advice]


def remarks(check: LogCheck) -> list[str]:
    """What a reader has to know besides the summary."""
    found = [
        "Samples: plants of the design's box with its dead times and loads, simulated with the logged "
        f"reference. False alarms: one in {check.envelope.samples + 1} for rigs of this kind."
    ]
    if hidden(check):
        left = check.residual.known("angle_deg")
        found.append(
            f"The plant is known to leave {number(left)} deg of this angle. A figure departs where it is "
            "worse than in every sample, and than that can make it."
        )
    if not check.own_controller:
        found.append(
            "The logged command differs from the command of these gains for the logged angle (by "
            f"{number(100 * check.command_off, 2)} % of the range): the log is of another controller or "
            "sample time; the envelope is that of the designed controller."
        )
    if counted := check.plant.rig.zero.words(check.plant.rig.units):
        found.append(f"The figures of this page count {counted}, as the plant's file does.")
    if check.plant.remainder.get("angle_deg") is None:
        found.append(
            "The plant's file states no residual; only sensor noise was assumed. `wrist trace "
            "--save` writes one that does."
        )
    return found


def envelope_caption(check: LogCheck) -> str:
    """Beneath the envelope."""
    return (
        f"The logged angle beside {check.envelope.samples} samples, from the lowest to the highest reading "
        "at each time; dashed: the reference."
    )
