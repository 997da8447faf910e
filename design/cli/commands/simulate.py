"""``wrist simulate``: open loop, closed loop, a recorded command, a saved scenario, or a figure of the
paper."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.commands.replay import replay
from design.cli.common import (
    Axis,
    AxisOption,
    JobsOption,
    JsonOption,
    OutOption,
    PlantOption,
    parameter_set,
    pi_gains,
    seconds,
    write_json,
)
from design.cli.completion import figures, files, starts
from design.cli.places import check_places
from design.cli.strict import refuse
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from plants.parameters.quantities import ParameterSet
    from plants.wrist import Start, Wrist

NAME, HELP = (
    "simulate",
    "Simulate the wrist: constant voltage, recorded command, PI step, or a figure of the paper.",
)
EXAMPLE = "Example: wrist simulate --axis flexion --gains 1.2,2.2 --step 15 --json -"
NEXT = "wrist tune"

OPTIONS = {
    "--axis", "--plant", "--volts", "--recording", "--gains", "--step", "--start", "--duration", "--figure",
    "--scenario",
}  # fmt: skip
"""Options that select what is simulated; each kind of simulation takes some of them."""


def command(
    axis: AxisOption = Axis.flexion,
    plant: PlantOption = None,
    volts: Annotated[float, typer.Option(help="Command held in open loop [V].")] = 3.0,
    recording: Annotated[
        Path | None,
        typer.Option(help="Recording whose command is applied in open loop.", autocompletion=files),
    ] = None,
    gains: Annotated[
        str | None, typer.Option(help="Kp,Ki of a PI, or a TOML file with them: close the loop.")
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(help="Reference of the closed loop; by default the step of the rig's task."),
    ] = None,
    start: Annotated[
        str,
        typer.Option(help="Initial hysteresis state: virgin, line1, line2 or inside.", autocompletion=starts),
    ] = "virgin",
    duration: Annotated[float, typer.Option(help="Length of the run [s].", min=0.01, max=3600.0)] = 10.0,
    figure: Annotated[
        int | None,
        typer.Option(help="Redraw a figure of the paper: 5, 6, 8, 10 to 15.", autocompletion=figures),
    ] = None,
    scenario: Annotated[
        Path | None,
        typer.Option(help="Saved worst case (TOML) to simulate again.", autocompletion=files),
    ] = None,
    json: JsonOption = None,
    out: OutOption = None,
    jobs: JobsOption = None,
) -> None:
    from design.synthesis.designed_plant import in_loop
    from plants.errors import InputError
    from plants.wrist import STARTS, Wrist

    check_places({"--json": json}, out)
    if scenario is not None:
        refuse(OPTIONS - {"--scenario"}, "a scenario file is complete in itself")
        replay(scenario, json, out)
        return
    if figure is not None:
        refuse(OPTIONS - {"--figure", "--plant"}, "a figure of the paper shows what the paper did")
        _figure(figure, axis, plant, json, out)
        return
    if gains is not None:
        refuse(("--recording", "--volts"), "with --gains the controller gives the command")
    elif recording is not None:
        refuse(("--volts", "--start", "--duration"), "the recording says it")
    if gains is None:
        refuse(("--step",), "a step needs a controller, --gains")
    if start not in STARTS:
        raise InputError(f"--start: unknown memory {start!r}; one of {', '.join(STARTS)}")
    chosen = parameter_set(axis, plant)
    wrist = Wrist.of(chosen)
    with progress("simulate"):
        if gains is not None:
            asked = wrist.rig.task.step if step is None else step
            looped = Wrist.of(in_loop(chosen))
            result = _closed(looped, pi_gains(gains, rig=wrist.rig), asked, start, duration)
        elif recording is not None:
            result = _played(wrist, recording)
        else:
            result = _open(wrist, volts, start, duration)
    said = console(json)
    said.print(f"{chosen.title}: {result['summary']}")
    if out is not None:
        said.print(f"picture in {_picture(out, chosen, result)}", soft_wrap=True)
    write_json(json, {"axis": chosen.axis, "plant": chosen.title, **result})


def _open(wrist: "Wrist", volts: float, start: "Start", duration: float) -> dict[str, Any]:
    import warnings

    from plants.errors import InputError, InputWarning

    if not abs(volts) <= 100.0:
        raise InputError(f"--volts: {volts} is no voltage of a regulator; give one of 0 to 4")
    low, high = wrist.rig.command_range
    if not low <= volts <= high:
        words = f"--volts: {volts:g} V is outside the range of {low:g} to {high:g} V"
        warnings.warn(words, InputWarning, stacklevel=2)
    count = round(duration / wrist.rig.sample_time)
    r = wrist.simulate([volts] * count, wrist.rest(start), every=10 if count % 10 == 0 else 1)
    summary = f"{volts:g} V for {duration:g} s leads to {r.pressure[-1]:.2f} kPa and {r.angle[-1]:.3f} deg"
    return {
        "summary": summary,
        "time_s": r.time,
        "command_V": [volts] * len(r.time),
        "pressure_kPa": r.pressure,
        "static_angle_deg": r.static_angle,
        "angle_deg": r.angle,
    }


def _played(wrist: "Wrist", path: Path) -> dict[str, Any]:
    import numpy as np

    from plants.measured.campaigns.begin import first_begin
    from plants.measured.campaigns.campaign import load_recording
    from plants.measured.campaigns.playback import Playback
    from plants.measured.fitting.stage import begun

    r = load_recording(path, rig=wrist.rig)
    # Counted from mid-range, a rig at rest is not where its recordings begin.
    begin = first_begin(r, float(wrist.hysteresis.rest_pressure), wrist.rig) if wrist.rig.zero.rest else None
    pressure, angle = Playback(r, wrist.rig.sample_time).play(wrist, begun(wrist, begin))
    result: dict[str, Any] = {
        "time_s": r.time,
        "command_V": r.command,
        "pressure_kPa": pressure,
        "angle_deg": angle,
        "measured_angle_deg": r.angle,
        "measured_pressure_kPa": r.pressure,
    }
    errors = [
        f"{np.sqrt(np.mean((a - b) ** 2)):.3g} {unit}"
        for a, b, unit in ((angle, r.angle, "deg"), (pressure, r.pressure, "kPa"))
        if b is not None
    ]
    return {
        "summary": f"{r.name} played from {'rest' if begin is None else 'its first rows'}; "
        f"rms error against the recording {' and '.join(errors)}",
        **result,
    }


def _closed(
    wrist: "Wrist", gains: tuple[float, ...], step: float, start: "Start", duration: float
) -> dict[str, Any]:
    import math

    from design.controllers.measurement.plausible import SensorLimits
    from design.controllers.pi import PI
    from design.evaluation.steps import run
    from plants.errors import InputError

    if not math.isfinite(step) or step == 0.0:
        raise InputError(f"--step: {step} is no step; give an angle in deg that is not 0")
    sensor = SensorLimits.of(wrist).angle
    if not sensor.holds(step):
        raise InputError(
            f"--step: {step:g} deg is no angle of this rig; give {sensor.low:.0f} to {sensor.high:.0f}"
        )
    controller = PI.of(wrist, *gains)
    judged, _, t = run(wrist, controller, step, wrist.rest(start), duration=duration, record=True)
    assert t is not None
    metrics = {n: float(v[0]) for n, v in vars(judged).items()}
    summary = (
        f"step of {step:g} deg with Kp {gains[0]:g} kPa/deg, Ki {gains[1]:g} kPa/(deg s) settles in "
        f"{seconds(metrics['settling_time_s'], duration)}, overshoot {metrics['overshoot_percent']:.2g} %, "
        f"IAE {metrics['iae_deg_s']:.3g} deg s"
    )
    every = slice(None, None, 10)
    return {
        "summary": summary,
        "metrics": metrics,
        "time_s": t.time[every],
        "command_V": t.command[every, 0],
        "pressure_kPa": t.pressure[every, 0],
        "static_angle_deg": t.static_angle[every, 0],
        "angle_deg": t.angle[every, 0],
    }


def _figure(number: int, axis: Axis, plant: Path | None, json: Path | None, out: Path | None) -> None:
    from design.studies.paper import series
    from plants.errors import InputError
    from plants.wrist import Wrist
    from reports.paper import figures as paper
    from reports.shared.figures.style import save

    if number not in paper.FIGURES:
        known = ", ".join(map(str, paper.FIGURES))
        raise InputError(f"--figure: {number} is not a figure that the model can redraw; one of {known}")
    sets = {a.value: parameter_set(a, None) for a in Axis}
    if plant is not None:
        given = parameter_set(axis, plant)
        if given.axis not in sets:
            known = ", ".join(sets)
            raise InputError(f"{plant}: {given.axis!r} is no motion of the paper; its figures are of {known}")
        sets[given.axis] = given
    wrists = [Wrist.of(s) for s in sets.values()]
    with progress("simulate"):
        panels = series(number, *wrists)
    path = (out or Path("build/figures")) / f"figure-{number:02d}.png"
    with progress("draw"):
        save(paper.draw(number, panels), path)
    said = console(json)
    said.print(f"Fig. {number} redrawn in {path}", soft_wrap=True)
    caption = paper.caption(number, sets)
    said.print(caption)
    write_json(json, {**paper.data(number, panels), "caption": caption})


def _picture(folder: Path, chosen: "ParameterSet", result: dict[str, Any]) -> Path:
    from plants.files import file_name
    from reports.shared.figures.signals import draw
    from reports.shared.figures.style import save

    path = folder / f"simulate-{file_name(chosen.axis)}.png"
    save(draw(result, chosen.title, chosen.rig.command_range), path)
    return path
