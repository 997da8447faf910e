"""What an export can be written as: a folder of C, functional mock-up units, structured text."""

from collections.abc import Callable, Mapping
from pathlib import Path

from design.export.formats.fmu import FMI, unit
from design.export.formats.folder import contents, write
from design.export.formats.structured_text import function_block
from design.export.part import Part
from plants.errors import InputError
from plants.files import write_atomically
from plants.wrist import Wrist

VERSIONS: tuple[FMI, ...] = ("2.0", "3.0")


def write_units(part: Part, wrist: Wrist, folder: Path) -> list[Path]:
    """Write a unit of each version of FMI, with the test vector beside, into a folder; the paths.

    Raises InputError as `design.export.formats.fmu.unit` does, before anything is written.
    """
    files = contents(part, wrist)
    made: dict[str, str | bytes] = {f"{part.name}_fmi{v[0]}.fmu": unit(part, files, v) for v in VERSIONS}
    return write_each(made | {f"{part.name}_vector.csv": files[f"{part.name}_vector.csv"]}, folder)


def write_text(part: Part, wrist: Wrist, folder: Path) -> list[Path]:
    """Write a function block, with the test vector beside, into a folder; the paths.

    Raises InputError for a law that has no straight line of operations, such as an MPC.
    """
    block = function_block(part)
    vector = contents(part, wrist)[f"{part.name}_vector.csv"]
    return write_each({f"{part.name}.st": block, f"{part.name}_vector.csv": vector}, folder)


def write_each(files: Mapping[str, str | bytes], folder: Path) -> list[Path]:
    """Write files by name into a folder; the paths.  Raises InputError, before anything is written, where a
    folder stands in a file's place."""
    for name in files:
        if (folder / name).is_dir():
            raise InputError(f"--out: {folder / name} is a folder; remove it or choose another place")
    for name, content in files.items():
        write_atomically(folder / name, content)
    return [folder / name for name in files]


TARGETS: Mapping[str, Callable[[Part, Wrist, Path], list[Path]]] = {
    "c": write,
    "fmu": write_units,
    "st": write_text,
}
"""How each target is written, by the name that ``--target`` gives."""
