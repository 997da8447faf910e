"""What a plant is written as: a folder of C, or functional mock-up units of FMI 2.0 and 3.0."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from design.export.catalogue import identifier
from design.export.formats.fmu import FMI, UnitVariable, packed, texts
from design.export.formats.folder import with_manifest, write_together
from design.export.formats.targets import VERSIONS, write_each
from design.export.plant.part import PlantPart, of_plant
from design.export.plant.vectors import PlantVector, plant_csv, plant_vector
from design.export.rendering import render_named
from plants.errors import InputError
from plants.wrist import Wrist

PLANT = "plant"
"""What the command calls it, beside the controllers."""


def plant_part(axis: str, wrist: Wrist) -> PlantPart:
    """The part of a plant, named after its motion.

    >>> plant_part("flexion", Wrist.flexion()).name
    'flexion_plant'
    """
    beside = ", ".join(e.NAME for e in wrist.effects)
    what = f"regulator, {wrist.hysteresis.NAME} hysteresis, lag" + (f", {beside}" if beside else "")
    return of_plant(identifier(f"{axis[:40]}_{PLANT}"), f"The plant: {what}", wrist)


def plant_files(part: PlantPart, found: PlantVector) -> dict[str, str]:
    """Files by name: header, sources, README, test vector and what replays it, checksums."""
    n = part.name
    return with_manifest(
        {
            f"{n}.h": _drawn(part, "plant.h.jinja"),
            f"{n}.c": _drawn(part, "plant.c.jinja"),
            f"{n}_law.c": part.code,
            f"{n}_vector.csv": plant_csv(part, found),
            "test_vector.c": _drawn(part, "plant_vector.c.jinja", found=found),
            "Makefile": _drawn(part, "Makefile.jinja", real="double"),
            "README.md": _drawn(part, "plant.md.jinja"),
        }
    )


def _drawn(part: PlantPart, template: str, **values: Any) -> str:
    return render_named(template, part.name, part=part, **values)


def plant_variables(part: PlantPart) -> list[UnitVariable]:
    """Time, its inputs as they are at rest, what its sensors show, and its return code."""
    rows: list[tuple[str, str, str, str, str, float | None]] = [
        ("time", "s", "time of the simulation", "independent", "continuous", None),
        *(
            (f.member, f.unit, f.meaning, "input", "discrete", at)
            for f, at in zip(part.inputs, part.at_rest, strict=True)
        ),
        *((f.member, f.unit, f.meaning, "output", "discrete", None) for f in part.outputs),
        ("code", "", "return code of the last sample: 0 where it moved", "output", "discrete", None),
    ]
    return [UnitVariable(i, *row) for i, row in enumerate(rows)]


def plant_unit(part: PlantPart, files: dict[str, str], fmi: FMI) -> bytes:
    """A unit of a plant for this machine; files: those of its C export.

    Raises InputError where there is no C compiler.
    """

    def drawn(template: str, **values: Any) -> str:
        return _drawn(part, template, **values)

    own = texts(part.name, files, plant_variables(part), fmi, "plant_fmu.c.jinja", drawn)
    return packed(part.name, own, fmi)


def _c(part: PlantPart, wrist: Wrist, folder: Path) -> list[Path]:
    return write_together(plant_files(part, plant_vector(part, wrist)), folder)


def _units(part: PlantPart, wrist: Wrist, folder: Path) -> list[Path]:
    files = plant_files(part, plant_vector(part, wrist))
    made: dict[str, str | bytes] = {
        f"{part.name}_fmi{v[0]}.fmu": plant_unit(part, files, v) for v in VERSIONS
    }
    return write_each(made | {f"{part.name}_vector.csv": files[f"{part.name}_vector.csv"]}, folder)


_TARGETS: Mapping[str, Callable[[PlantPart, Wrist, Path], list[Path]]] = {"c": _c, "fmu": _units}


def write_plant(part: PlantPart, wrist: Wrist, target: str, folder: Path) -> list[Path]:
    """Write a plant for a target, ``c`` or ``fmu``; the paths.

    Raises InputError, before anything is written, for another target, where there is no C compiler, and where
    a folder stands in a file's place.
    """
    if target not in _TARGETS:
        raise InputError(f"--target {target}: a plant is written as {' or '.join(_TARGETS)}; choose one")
    return _TARGETS[target](part, wrist, folder)


def plant_record(part: PlantPart, files: list[str]) -> dict[str, Any]:
    """What ``--json`` says: files, layout of the structs with units, parameters."""

    def layout(fields: Any) -> list[dict[str, Any]]:
        return [
            {"name": f.member, "type": "int" if f.counts else "double", "count": f.size, "unit": f.unit,
             "meaning": f.meaning} for f in fields
        ]  # fmt: skip

    return {
        "plant": part.title, "name": part.name, "period_s": part.period, "files": files,
        "state": layout(part.members), "given": layout(part.inputs), "shown": layout(part.outputs),
        "settings": dict(part.settings), "tolerance": list(part.tolerance),
    }  # fmt: skip
