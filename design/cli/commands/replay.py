"""``wrist simulate --scenario``: a saved worst case, played again."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.cli.common import seconds, write_json
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from design.robustness.samples.scenario_file import Saved


def replay(path: Path, json: Path | None, out: Path | None) -> None:
    """Play a scenario file again; tell its metrics beside those saved, write JSON and draw it.

    Raises InputError for a file that is none, see `design.robustness.samples.scenario_file.load`.
    """
    from design.robustness.samples.scenario_file import load

    saved = load(path)
    with progress("play"):
        result = played(saved)
    said = console(json)
    said.print(f"{saved.plant.title}: {result['summary']}")
    if out is not None:
        said.print(f"picture in {_picture(out, saved, result)}", soft_wrap=True)
    write_json(json, {"axis": saved.plant.axis, "plant": saved.plant.title, **result})


def played(saved: "Saved") -> dict[str, Any]:
    """The run of a scenario as `wrist simulate` tells runs: summary, metrics of the last step, signals."""
    from design.evaluation.cases import stack
    from design.evaluation.runner import play
    from plants.parameters.quantities import kinds_of

    case, c = saved.case, saved.controller
    run = play(stack([case]), c, record=True)
    t = run.trajectory
    assert t is not None
    metrics = {n: float(v[0]) for n, v in vars(run.metrics).items()}
    differs = [n for n, v in metrics.items() if v != saved.metrics[n]]
    same = f"not as saved: {', '.join(differs)}" if differs else "all as saved"
    summary = (
        f"{case.name}, with Kp {c.Kp:.4g} kPa/deg, Ki {c.Ki:.4g} kPa/(deg s); the last step, of "
        f"{run.size[0]:.3g} deg from {run.start[0]:+.3g} deg, settles in "
        f"{seconds(metrics['settling_time_s'], case.task.holds[-1])}, overshoot "
        f"{metrics['overshoot_percent']:.3g} %, "
        f"IAE {metrics['iae_deg_s']:.3g} deg s ({same})"
    )
    every, kinds = slice(None, None, 10), kinds_of(case.wrist.values, case.wrist.forms)
    return {
        "summary": summary,
        "scenario": case.name,
        "parameters": {n: {"value": v, "unit": kinds[n].unit} for n, v in case.wrist.values.items()},
        "metrics": metrics,
        "metrics_saved": saved.metrics,
        "same_as_saved": not differs,
        "time_s": t.time[every],
        "reference_deg": run.reference[every, 0],
        "command_V": t.command[every, 0],
        "pressure_kPa": t.pressure[every, 0],
        "static_angle_deg": t.static_angle[every, 0],
        "angle_deg": t.angle[every, 0],
    }


def _picture(folder: Path, saved: "Saved", result: dict[str, Any]) -> Path:
    from plants.files import file_name
    from reports.shared.figures.signals import draw
    from reports.shared.figures.style import BLACK, save, styled

    case, asked = saved.case, saved.case.task
    # The whole name is too long for a line of the page: the references are drawn anyway.
    burden = f", {1000 * case.dead_time:.3g} ms of dead time" if case.dead_time else ""
    burden += f", load {asked.load:+.2g} deg" if asked.load else ""
    figure = draw(result, f"{saved.plant.title}, from {asked.start}{burden}")
    with styled():
        panel = figure.axes[0]
        panel.plot(
            result["time_s"], result["reference_deg"], drawstyle="steps-post", color=BLACK, linewidth=0.9,
            label="reference",
        )  # fmt: skip
        panel.legend(loc="best")
    path = folder / f"scenario-{file_name(saved.plant.axis)}.png"
    save(figure, path)
    return path
