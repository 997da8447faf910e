"""``wrist export``: a controller, or the plant, for its target, with a test vector."""

import math
from collections.abc import Mapping
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from design.cli.common import (
    Axis,
    AxisOption,
    JsonOption,
    PlantOption,
    parameter_set,
    pi_gains,
    write_json,
)
from design.cli.completion import controllers, files
from design.cli.places import check_places
from design.cli.strict import LARGEST
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from design.export.part import Part
    from design.export.plant.part import PlantPart
    from plants.rig import Rig
    from plants.wrist import Wrist

NAME = "export"
HELP = (
    "Write a controller, or the plant, for its target: C99 with a test vector, functional mock-up units, or "
    "structured text."
)
EXAMPLE = "Example: wrist export pi --gains 3.1,10.4 --out build/c"
NEXT = "make -C OUT check"


class Target(StrEnum):
    """What is written."""

    c = "c"
    fmu = "fmu"
    st = "st"


class PrecisionName(StrEnum):
    """Precisions of the C."""

    double = "double"
    single = "single"


def command(
    controller: Annotated[
        str,
        typer.Argument(
            help="pi, pi-2dof, cascade, lqi, feedforward, feedforward-pi, observer, mpc, mpc-robust, "
            "mpc-real-time or mpc-real-time-robust; or plant, the plant itself with all its effects, as C or "
            "FMU.",
            autocompletion=controllers,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            help="Folder for the files; existing files of the same names are replaced.", autocompletion=files
        ),
    ],
    gains: Annotated[
        str | None,
        typer.Option(
            help="pi: Kp,Ki. pi-2dof: Kp,Ki,b,Tf. cascade: Kp,Ki,b,Kc. lqi: Ke,Kd,Kq,jump,bandwidth. "
            "feedforward: speed. feedforward-pi: Kp,Ki,dead time. observer: bandwidth. Needed by pi, "
            "pi-2dof, cascade, lqi and feedforward-pi. Any mpc: swing,move,delay, the weights of changes of "
            "angle and command and the periods of dead time in its model. For pi, pi-2dof and any mpc a TOML "
            "file with them works too, such as mpc-MOTION.toml of wrist design --mpc."
        ),
    ] = None,
    target: Annotated[
        Target,
        typer.Option(
            help="c: C99. fmu: units of FMI 2.0 and 3.0 for co-simulation. st: IEC 61131-3 function block."
        ),
    ] = Target.c,
    precision: Annotated[
        PrecisionName, typer.Option(help="double, or single: float throughout, for a target without double.")
    ] = PrecisionName.double,
    hand_over: Annotated[
        bool,
        typer.Option(
            "--hand-over",
            help="pi, pi-2dof: inputs for a command by hand, from which the controller takes over without a "
            "jump at any error.",
        ),
    ] = False,
    rate_limit: Annotated[
        float | None, typer.Option(help="pi, pi-2dof: most that the command may move, V/s.", metavar="V/S")
    ] = None,
    axis: AxisOption = Axis.flexion,
    plant: PlantOption = None,
    json: JsonOption = None,
) -> None:
    from design.export.catalogue import part, record
    from design.export.formats.targets import TARGETS
    from design.export.plant.files import PLANT
    from design.synthesis.designed_plant import in_loop
    from plants.wrist import Wrist

    check_places({"--json": json}, out)
    chosen = in_loop(parameter_set(axis, plant))
    wrist = Wrist.of(chosen)
    if controller == PLANT:
        refused = {"--gains": gains, "--rate-limit": rate_limit, "--hand-over": hand_over or None}
        return _plant(chosen.axis, wrist, target, out, refused, precision, json)
    with progress("export") as tell:
        own = None if gains is None else numbers(gains, wrist.rig, controller)
        made = part(controller, chosen.axis, wrist, own, hand_over, rate_limit)
        made = _titled(made, gains).at(precision.value)
        tell("test vector", 0.0)
        written = TARGETS[target.value](made, wrist, out)
    _told(made, written, target, out, json)
    write_json(json, record(made, controller, [p.name for p in written]))


def _plant(
    axis: str,
    wrist: "Wrist",
    target: Target,
    out: Path,
    refused: Mapping[str, object],
    precision: PrecisionName,
    json: Path | None,
) -> None:
    from design.export.plant.files import plant_part, plant_record, write_plant
    from plants.errors import InputError

    for option, given in refused.items():
        if given is not None:
            raise InputError(f"{option}: a plant has none; leave it out")
    if precision is not PrecisionName.double:
        raise InputError("--precision: a plant is written in double precision; leave it out")
    with progress("export") as tell:
        made = plant_part(axis, wrist)
        tell("test vector", 0.0)
        written = write_plant(made, wrist, target.value, out)
    _told(made, written, target, out, json)
    write_json(json, plant_record(made, [p.name for p in written]))


def _told(
    made: "Part | PlantPart", written: list[Path], target: Target, out: Path, json: Path | None
) -> None:
    """Say what was written, and how it is replayed."""
    said = console(json)
    said.print(f"{made.title}: {made.name}_init and {made.name}_step, every {1000 * made.period:g} ms")
    for path in written:
        said.print(f"  {path}", soft_wrap=True)
    if target is Target.c:
        said.print(f"replay the test vector with: make -C {out} check", soft_wrap=True)


def _titled(made: "Part", gains: str | None) -> "Part":
    """The part, whose title says so where a file of gains tells that they break a limit."""
    from design.tuner.gains_file import broken
    from reports.shared.names import broken_gains

    told = broken(gains) if gains is not None and gains.endswith(".toml") else None
    if told is None:
        return made
    return replace(made, title=f"{made.title}, {broken_gains(told.limits, told.nearest)}")


def _of_pi(path: str, rig: "Rig | None", controller: str) -> tuple[float, ...]:
    """Gains of a PI that a file holds, with the second degree of freedom where the controller has it; a plain
    PI would lose it without a word."""
    from design.tuner.gains_file import read_more
    from plants.errors import InputError

    gains, more = pi_gains(path, rig=rig), read_more(path)
    if controller == "pi-2dof":
        return (*gains, *more)
    if controller == "pi" and more != (1.0, 0.0):
        raise InputError(
            f"--gains: {path} has b = {more[0]:g} and Tf = {more[1]:g} s, which a plain PI does not; export "
            "pi-2dof with it"
        )
    return gains


def numbers(text: str, rig: "Rig | None" = None, controller: str = "pi") -> tuple[float, ...]:
    """Numbers with commas between, of either sign, or those of a TOML file with the gains of a PI, of an MPC
    with what was tuned of it, in the units of a rig; raises InputError for anything else.

    >>> numbers("600,-640")
    (600.0, -640.0)
    """
    from plants.errors import InputError

    if text.endswith(".toml") and controller.startswith("mpc"):
        from design.tuner.gains_file import read_mpc

        return read_mpc(text, rig)
    if text.endswith(".toml"):
        return _of_pi(text, rig, controller)
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if not found or not all(math.isfinite(x) and abs(x) <= LARGEST for x in found):
        raise InputError(f"--gains: {text!r} is not finite numbers with commas between, like 3.1,10.4")
    return found
