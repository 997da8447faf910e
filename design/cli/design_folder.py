"""The folder that ``wrist design`` wrote, as other commands take it."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from design.alternatives.designs import RequirementDesign
    from design.controllers.pi import PI
    from plants.parameters.quantities import ParameterSet


def motions(folder: Path) -> list[str]:
    """The motions of a design.  Raises InputError for a folder without any."""
    from plants.errors import InputError

    found = sorted(p.stem.removeprefix("plant-") for p in folder.glob("plant-*.toml"))
    if not found:
        raise InputError(
            f"--design: {folder} holds no plant-MOTION.toml; give a folder that `wrist design` wrote"
        )
    return found


def plant_file(folder: Path, motion: str) -> Path:
    """Where the plant of a motion lies."""
    return folder / f"plant-{motion}.toml"


def gains_file(folder: Path, motion: str) -> Path:
    """Where the recommended gains of a motion lie."""
    return folder / f"gains-{motion}.toml"


def stages(folder: Path) -> Path:
    """Where the stages of a design lie."""
    return folder / "stages"


def recommended(folder: Path, plant: "ParameterSet") -> "PI":
    """The recommended controller of a plant's motion.  Raises InputError for a file of gains that is missing
    or wrong."""
    from design.synthesis.structure import with_gains
    from design.tuner.gains_file import read, read_more
    from plants.wrist import Wrist

    path = gains_file(folder, plant.axis)
    (Kp, Ki), (b, Tf) = read(path, plant.rig), read_more(path)
    found: PI = with_gains(Wrist.of(plant), {"Kp": Kp, "Ki": Ki, "b": b, "Tf": Tf})
    return found


def alternatives(folder: Path, plant: "ParameterSet") -> "dict[str, RequirementDesign]":
    """The cascade, the LQI and the feedforward that a design tuned for a plant under the same requirement, by
    name; those that it has."""
    import json

    from design.alternatives.designs import CASCADE_PI, FORWARD_PI, LQI_NAME, RequirementDesign
    from plants.errors import InputError
    from plants.wrist import Wrist

    path = folder / "design.json"
    try:
        records = json.loads(path.read_text(encoding="utf-8"))["designs"].get(plant.axis, {})
        of = {n: records[n] for n in (CASCADE_PI, LQI_NAME, FORWARD_PI) if n in records}
        return {n: RequirementDesign.of(Wrist.of(plant), record) for n, record in of.items()}
    except FileNotFoundError:
        return {}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: no record of a design ({error}); run `wrist design` again") from None
