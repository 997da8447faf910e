"""A worst case as a TOML file that is complete in itself, to be played again by ``wrist simulate``.

The file is a parameter set (``axis``, ``parameters``, ``effects``, so that ``--plant`` takes it too)
with the tables ``scenario``, ``controller`` and ``metrics`` beside.  Numbers are written with as many
digits as give them back to the last bit.
"""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.evaluation.cases import Case
from design.evaluation.metrics import UNITS, Metrics
from design.evaluation.tasks import Task
from design.robustness.box import SHIFT
from design.robustness.samples.worst import Worst
from plants.effects.wrist.remainder import ColouredRemainder
from plants.errors import InputError
from plants.files import write_atomically
from plants.parameters import files as parameter_files
from plants.parameters.quantities import ParameterSet
from plants.simulation.disturbance import BEFORE
from plants.toml import check_keys, is_number, read_toml
from plants.wrist import STARTS, Wrist

SETTINGS = {
    "Kp": "kPa/deg",
    "Ki": "kPa/(deg s)",
    "gain": "kPa/V",
    "rest_pressure": "kPa",
    "low": "V",
    "high": "V",
}
"""What a file says of the controller, by the names of `design.controllers.pi.PI`, with units."""

REMAINDER = "remainder_shift"
"""Which part of the plant's residual the run meets, where it meets one."""

KEYS = (
    "start", "angle", "references", "holds", "dead_time", "load", "load_at", REMAINDER, "plant", "violated",
)  # fmt: skip
"""What a file says of the run."""

MORE = {"b": "1", "Tf": "s"}
"""What it says beside of one with two degrees of freedom (`design.controllers.pi_two_dof`)."""

FASTEST, LONGEST = 1e6, 3600.0
"""Greatest gain and longest run [s] that a file may ask for."""


@dataclass(frozen=True)
class Saved:
    """What a scenario file says: the run, its plant without dead time and load, its controller, and the
    metrics of the last step that were seen when it was saved."""

    case: Case
    plant: ParameterSet
    controller: PI
    metrics: dict[str, float]


def save(worst: Worst, path: str | Path) -> None:
    """Write a worst case of a PI as a scenario file, complete or not at all; raises InputError where that
    fails, and for another controller."""
    import tomlkit

    if not isinstance(worst.controller, PI):
        kind = type(worst.controller).__name__
        raise InputError(
            f"{path}: a scenario file holds the settings of a PI, not of a {kind}; save its record"
        )

    case, asked = worst.case, worst.case.task
    document = tomlkit.parse(_plant_text(worst.plant))
    scenario = tomlkit.table()
    scenario.comment("references in deg, holds in s; the last step is judged")
    scenario["start"], scenario["angle"] = asked.start, asked.angle
    scenario["references"], scenario["holds"] = list(asked.references), list(asked.holds)
    scenario["dead_time"], scenario["load"], scenario["plant"] = case.dead_time, asked.load, case.plant
    if asked.load_at >= 0.0:
        scenario["load_at"] = asked.load_at
    met = case.wrist.values.get(SHIFT)
    if met is not None:
        scenario[REMAINDER] = float(met)
    scenario["violated"] = list(worst.violated)
    document["scenario"] = scenario
    controller = tomlkit.table()
    own = SETTINGS | (MORE if isinstance(worst.controller, TwoDofPI) else {})
    for name, unit in own.items():
        controller[name] = float(getattr(worst.controller, name))
        controller[name].comment(unit)
    document["controller"] = controller
    metrics = tomlkit.table()
    for name, unit in UNITS.items():
        metrics[name] = float(worst.metrics[name])
        metrics[name].comment(unit)
    document["metrics"] = metrics
    write_atomically(path, tomlkit.dumps(document))


def load(path: str | Path) -> Saved:
    """What a scenario file says.

    Raises InputError, in one line with the file and what is wrong with it, for a file that is no
    parameter set (see `plants.parameters.files.load`), for a table or an entry that is missing, unknown
    or of a wrong kind, and for numbers that make no run.
    """
    plant = parameter_files.load(path)
    text = read_toml(path, "scenario file", "`wrist robust --worst`")
    asked, settings, seen = (_table(path, text, n) for n in ("scenario", "controller", "metrics"))
    names = {f.name for f in fields(Metrics)}
    for table, name, known in (
        (asked, "scenario", KEYS),
        (settings, "controller", (*SETTINGS, *MORE)),
        (seen, "metrics", sorted(names)),
    ):  # fmt: skip
        check_keys(table, known, f"{path}: {name}")
    metrics = {n: _number(path, f"metrics.{n}", seen.get(n), finite=False) for n in sorted(names)}
    controller = {n: _number(path, f"controller.{n}", settings.get(n)) for n in SETTINGS}
    if not all(0.0 <= controller[n] <= FASTEST for n in ("Kp", "Ki")):
        raise InputError(f"{path}: controller.Kp and controller.Ki must be gains of 0 to {FASTEST:g}")
    if controller["gain"] <= 0.0 or not controller["low"] < controller["high"]:
        raise InputError(f"{path}: controller needs gain above 0 and low below high")
    more = {n: _number(path, f"controller.{n}", settings[n]) for n in MORE if n in settings}
    if not all(0.0 <= v <= FASTEST for v in more.values()):
        raise InputError(f"{path}: controller.b and controller.Tf must be numbers of 0 to {FASTEST:g}")
    made = TwoDofPI(**controller, **more) if more else PI(**controller)
    return Saved(_case(path, asked, plant), plant, made, metrics)


def _case(path: str | Path, asked: Mapping[str, Any], plant_set: ParameterSet) -> Case:
    wrist = Wrist.of(plant_set)
    start = asked.get("start")
    if start not in STARTS:
        raise InputError(f"{path}: scenario.start {start!r} is no memory; give one of {', '.join(STARTS)}")
    angle, dead_time, shift = (
        _number(path, f"scenario.{n}", asked.get(n)) for n in ("angle", "dead_time", "load")
    )
    references, holds = (_numbers(path, f"scenario.{n}", asked.get(n)) for n in ("references", "holds"))
    if len(references) != len(holds):
        raise InputError(
            f"{path}: scenario has {len(references)} references but {len(holds)} holds; give as many of each"
        )
    if min(holds[:-1], default=0.0) < 0.0 or holds[-1] < 0.01 or sum(holds) > LONGEST:
        raise InputError(f"{path}: scenario.holds must be times, together of 0.01 to {LONGEST:g} s")
    if start == "virgin" and angle != 0.0:
        raise InputError(f"{path}: scenario.angle is {angle:g} deg, but a virgin wrist rests at 0")
    if max(map(abs, (angle, *references))) > 90.0:
        raise InputError(f"{path}: scenario.angle and scenario.references must lie within -90 to 90 deg")
    if not 0.0 <= dead_time <= 0.4 or abs(shift) > 30.0:
        raise InputError(f"{path}: scenario.dead_time must be 0 to 0.4 s and scenario.load -30 to 30 deg")
    plant = asked.get("plant", "nominal")
    load_at = _number(path, "scenario.load_at", asked.get("load_at", BEFORE))
    if load_at > LONGEST:
        raise InputError(f"{path}: scenario.load_at must be at most {LONGEST:g} s")
    if REMAINDER in asked:
        left = ColouredRemainder.of(plant_set.remainder.get("angle_deg"))
        if left is None:
            raise InputError(f"{path}: scenario.{REMAINDER} is of a residual that [remainder] does not tell")
        wrist = wrist + replace(left, shift=_number(path, f"scenario.{REMAINDER}", asked[REMAINDER]))
    task = Task(start, angle, references, holds, "task band", shift, load_at)
    return Case(task, wrist, str(plant), dead_time)


def _table(path: str | Path, text: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = text.get(name)
    if not isinstance(table, dict):
        raise InputError(
            f"{path}: has no table [{name}]; give a scenario file, such as a search for the worst saves"
        )
    return table


def _number(path: str | Path, where: str, value: Any, finite: bool = True) -> float:
    if not is_number(value) and (finite or not isinstance(value, float)):
        raise InputError(f"{path}: {where} {'is missing' if value is None else f'= {value!r} is no number'}")
    return float(value)


def _numbers(path: str | Path, where: str, values: Any) -> tuple[float, ...]:
    if not isinstance(values, list) or not 1 <= len(values) <= 20:
        raise InputError(f"{path}: {where} must be a list of 1 to 20 numbers")
    return tuple(_number(path, f"{where}[{i}]", v) for i, v in enumerate(values))


def _plant_text(plant: ParameterSet) -> str:
    """A parameter set as the text that its own writer makes."""
    with tempfile.TemporaryDirectory() as folder:
        parameter_files.dump(plant, Path(folder) / "plant.toml")
        return (Path(folder) / "plant.toml").read_text(encoding="utf-8")
