"""Options that the commands share, and what they mean.  Nothing heavy is imported before it is used."""

import math
import shlex
import sys
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.completion import files
from design.cli.strict import LARGEST, given
from design.cli.terminal.screen import is_stdout

if TYPE_CHECKING:
    from plants.parameters.quantities import ParameterSet
    from plants.rig import Rig


class Axis(StrEnum):
    """Motions of the paper's wrist."""

    flexion = "flexion"
    deviation = "deviation"


AxisOption = Annotated[Axis, typer.Option(help="Motion of the wrist, with its built-in parameters.")]
PlantOption = Annotated[
    Path | None,
    typer.Option(
        help="Parameter set (TOML) in place of the built-in one, for example from `wrist fit --save`.",
        autocompletion=files,
    ),
]
CampaignArgument = Annotated[
    Path, typer.Argument(help="Folder with campaign.toml and the recordings.", autocompletion=files)
]
StartOption = Annotated[
    Path | None,
    typer.Option(
        "--plant",
        help="Parameter set to start from; by default the built-in one of the axis.",
        autocompletion=files,
    ),
]
JsonOption = Annotated[
    Path | None,
    typer.Option("--json", help="Write the result as JSON to this file; - for stdout.", autocompletion=files),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(help="Address of a Dask scheduler, such as tcp://host:8786, to run on its workers."),
]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Folder for pictures and reports.", autocompletion=files)
]
SeedOption = Annotated[int, typer.Option(help="Seed of all random numbers.", min=0, max=2**32)]
JobsOption = Annotated[int | None, typer.Option(help="Threads; all processors by default.", min=1)]


def parameter_set(axis: Axis, plant: Path | None) -> "ParameterSet":
    """The set of a file, or the built-in one of an axis; InputError where both are given and differ."""
    from plants.errors import InputError
    from plants.parameters.files import built_in, load

    if plant is None:
        return shown(built_in(axis.value))
    found = load(plant)
    if found.axis != axis.value and given("--axis"):
        raise InputError(f"--axis: {plant} is of {found.axis!r}, not of {axis.value!r}; leave --axis out")
    return shown(found)


def shown(found: "ParameterSet") -> "ParameterSet":
    """The same set, in whose rig's units everything is shown from now on."""
    from reports.shared.units import show

    show(found.rig)
    return found


def rig_of(plant: Path | None) -> "Rig | None":
    """The rig of a parameter set that was given; None for the built-in one."""
    from plants.parameters.files import load

    return None if plant is None else load(plant).rig


def given_set(plant: Path | None) -> "ParameterSet | None":
    """The set that a fit starts from, if the user gave one."""
    from plants.parameters.files import load

    return None if plant is None else shown(load(plant))


def write_json(path: Path | None, content: Mapping[str, Any]) -> None:
    """Write JSON to a file, complete or not at all, or to stdout; nothing where no path is given."""
    if path is None:
        return
    from plants.files import json_text, write_atomically

    if is_stdout(path):
        sys.stdout.write(json_text(content))
    else:
        write_atomically(path, json_text(content))


def command_line() -> str:
    """The line that this process was started with, as a shell takes it: for the foot of a page."""
    return shlex.join(["wrist", *sys.argv[1:]])


def following(said: Any, *words: object) -> None:
    """Say which command comes next, as a shell takes it."""
    said.print(f"next: {shlex.join(str(w) for w in words)}", soft_wrap=True)


def say_left_out(said: Any, plant: "ParameterSet") -> None:
    """Say, in a line each, which effects of a plant a design leaves out, and which delay it adds."""
    from design.synthesis.designed_plant import left_out

    gone = left_out(plant)
    if gone:
        said.print(f"left out, in the sensor or an event of the recordings: {', '.join(gone)}")
    if late := plant.rig.angle_delay:
        said.print(f"the angle is read {late:.3g} s late: in the loop that is dead time, and counted as such")


def numbers(text: str, option: str, example: str) -> tuple[float, ...]:
    """The numbers of an option such as ``--gains 1.2,2.2``: as many as in the example, none negative."""
    from plants.errors import InputError

    count = example.count(",") + 1
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count or not all(math.isfinite(v) and v >= 0.0 for v in found):
        raise InputError(
            f"{option}: {text!r} is not {count} numbers with commas between, none negative, like {example}"
        )
    if max(found) > LARGEST:
        raise InputError(f"{option}: {max(found):g} is beyond {LARGEST:g}; give numbers that can be meant")
    return found


def check_dead_time(plant: "ParameterSet", asked: float | None) -> None:
    """Refuse a longest dead time that is no longer than the one that the plant has of its own."""
    from plants.effects.regulator.dead_time import DeadTime
    from plants.errors import InputError

    own = plant.values.get(f"{DeadTime.NAME}.{DeadTime.DELAY}", 0.0)
    if asked and asked <= own:
        raise InputError(
            f"--dead-time: the plant has a dead time of its own, {1000.0 * own:.3g} ms, and is judged with "
            "its interval; give a longer one, which holds that, or 0 for none beside it"
        )


def pi_gains(
    text: str, option: str = "--gains", example: str = "1.2,2.2", rig: "Rig | None" = None
) -> tuple[float, ...]:
    """Kp, Ki of an option: two numbers, or the TOML file that holds them, such as the tuner keeps, in the
    units of a rig."""
    if text.endswith(".toml"):
        from design.tuner.gains_file import read

        return read(text, rig)
    return numbers(text, option, example)


def seconds(value: float, horizon: float = 10.0) -> str:
    """A time for reading; one that is not reached within the run is longer than it."""
    return f"{value:.3g} s" if math.isfinite(value) else f"> {horizon:g} s"
