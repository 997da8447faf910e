"""A remark on the instrument: something that the log does, and not the rig, in words and as numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from plants.rig import Zero

Habit = Literal[
    "held", "counted from", "far", "reversed", "offset", "resting", "saturated", "clipped", "late",
    "repeated", "swapped", "empty", "gaps", "clock", "spikes", "between", "straight",
    "decimated",
]  # fmt: skip


UNDER_SINES = " The recordings to fit on are single sines, under which {}: record steps to tell."


@dataclass(frozen=True)
class Remark:
    """Something that the log does.

    habit: ``held`` (renewed every `value` s; of a command, that of a closed loop is held from row to row),
    ``counted from`` (`value` is logged where the rig's plant is at zero), ``far`` (likewise, of an angle
    far from zero), ``reversed`` (counted with the opposite sign), ``offset`` (off by up to `value`, anew in
    each recording), ``resting`` (exactly zero for `value` s), ``saturated`` (likewise, and never beyond),
    ``clipped`` (its sensor shows nothing beyond `value`), ``late`` (logged `value` s late), ``repeated`` and
    ``swapped`` (so many rows), ``empty`` (so many cells), ``gaps`` (so many), ``clock`` (counts from `value`
    s), ``decimated`` (one row every `value` s is used), ``spikes`` (so many rows), ``between`` (so many jumps
    of a command between rows), ``straight`` (a command that moves straight between rows `value` s apart; of
    commands see `plants.measured.trace.stages.between_rows`).
    recordings: in which, by name; stated: whether campaign.toml says so; doubtful: whether the recordings
    cannot tell it from what a rig does.
    """

    habit: Habit
    channel: str
    value: float
    unit: str
    recordings: tuple[str, ...]
    stated: bool = False
    doubtful: bool = False

    def __str__(self) -> str:
        name, many = self.channel.split("_")[0], len(self.recordings) > 1
        where = f"{len(self.recordings)} recordings" if many else self.recordings[0]
        match self.habit:
            case "held" if name == "command":
                return (
                    f"The command is held between the rows, {self.value:.3g} s apart, as by a controller "
                    f"that runs once a row ({where})."
                )
            case "held":
                return (
                    f"The {name} channel is renewed every {self.value:.3g} s and held in between ({where}); "
                    "only renewed values count, with straight lines between them."
                )
            case "counted from":
                if name == "angle":
                    return (
                        f"The angle goes to one side; it is counted from {self.value:.4g} {self.unit}, in "
                        "the middle of its range, so that steps go either way. The revised plant keeps this."
                    )
                said = (
                    f"Under a command of zero the pressure is {self.value:.4g} kPa, by a fit of the "
                    "regulator; it is counted from there. The revised plant keeps this."
                )
                return (
                    f"{said}{UNDER_SINES.format('unequal rates move the mean too')}"
                    if self.doubtful
                    else said
                )
            case "far":
                return (
                    f"The {name} lies far from zero for its range; it is counted from {self.value:.4g} "
                    f"{self.unit}. The revised plant keeps this."
                )
            case "reversed":
                return (
                    f"The {name} falls as the pressure rises; it is counted with the opposite sign. The "
                    "revised plant keeps this."
                )
            case "offset":
                return (
                    f"The {name} sensor is offset by up to {self.value:.3g} {self.unit}, anew in each "
                    f"recording ({where}); the offsets are taken off."
                )
            case "saturated":
                return (
                    f"The {name} reads exactly zero for up to {self.value:.3g} s and never beyond ({where}): "
                    "the sensor saturates, there is a stop, or the joint rests there. Simulations are "
                    "compared as a sensor that saturates reads them, so rows at zero tell only that the true "
                    "value is not on the other side."
                )
            case "clipped":
                seen = "reaches" if self.stated else "stays at exactly"
                return (
                    f"The {name} {seen} {self.value:.4g} {self.unit} ({where}), an end of its sensor's "
                    "range. Simulations are compared as such a sensor reads them, so rows there tell only "
                    "that the true value is not within."
                )
            case "late":
                said = (
                    f"The {name} channel is logged {self.value:.3g} s later than the others ({where}); it is "
                    "put back to when it was measured."
                )
                if self.doubtful:
                    said += UNDER_SINES.format("a lag shifts the phase too")
                if self.stated or self.channel != "angle_deg":
                    return said
                return (
                    f"{said} A controller may read it as late, so that a design counts this as dead time; if "
                    "the logger alone is late, state angle_delay_s in [logger]."
                )
            case "repeated":
                return f"{self.value:.0f} rows were written twice ({where}); the copies are left out."
            case "swapped":
                return f"{self.value:.0f} rows stood in the wrong order ({where}); they are put in order."
            case "empty":
                return f"{self.value:.0f} cells are empty ({where}); only the others count."
            case "gaps":
                return f"The time has {self.value:.0f} short gaps ({where}); the command is held over them."
            case "clock":
                return f"The clock starts at {self.value:.10g} s ({where}); time counts from the first row."
            case "decimated":
                return (
                    f"Rows are closer than the regulator's time constant needs: one every {self.value:.3g} s "
                    f"is used, and the mean of the command in between ({where})."
                )
            case "spikes":
                return (
                    f"The {name} channel has {self.value:.0f} rows of spikes ({where}); they are left out, "
                    "with straight lines over them."
                )
            case "straight":
                return (
                    f"The command moves on between the rows, {self.value:.3g} s apart ({where}); it is taken "
                    "to be straight there."
                )
            case "between":
                return (
                    f"The set-point changes between rows ({where}); the times of {self.value:.0f} jumps of "
                    "the command are estimated from what followed them."
                )
            case _:
                return f"The {name} sensor rests at exactly zero for up to {self.value:.3g} s ({where})."


def zero_of(remarks: Sequence[Remark]) -> Zero:
    """What a log is counted from after all that was said of it.

    >>> zero_of([Remark("counted from", "angle_deg", 26.0, "deg", ("steps.csv",))])
    Zero(pressure=0.0, angle=26.0, reversed=False, rest=0.0)
    """
    found = {r.channel: r.value for r in remarks if r.habit in ("counted from", "far")}
    turned = any(r.habit == "reversed" for r in remarks)
    return Zero(found.get("pressure_kPa", 0.0), found.get("angle_deg", 0.0), turned)


def angle_delay_of(remarks: Sequence[Remark]) -> float | None:
    """The delay [s] of the angle that a controller meets as well: what was found in a log, 0 where it is
    stated to be the logger's, None where nothing was found.

    >>> angle_delay_of([Remark("late", "angle_deg", 0.08, "s", ("steps.csv",))])
    0.08
    """
    late = (r for r in remarks if r.habit == "late" and r.channel == "angle_deg")
    return next((0.0 if r.stated else r.value for r in late), None)


def habits(remarks: Sequence[Remark]) -> list[dict[str, object]]:
    """The remarks as dictionaries, for JSON."""
    return [dict(vars(r)) | {"recordings": list(r.recordings), "text": str(r)} for r in remarks]
