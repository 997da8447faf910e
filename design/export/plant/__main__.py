"""The plant as C and as units, beside the simulator: python -m design.export.plant writes docs/targets.md.

Every form of every effect is run with the first of its trial values that shows within the 10,000 samples.
"""

import re
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.export.formats.fmu import FMI
from design.export.formats.targets import VERSIONS
from design.export.plant.files import plant_files, plant_part, plant_unit
from design.export.plant.part import PlantPart
from design.export.plant.vectors import STEPS, PlantVector, plant_vector
from design.export.table import into_page, of_plays, written
from plants.effects import EFFECTS
from plants.effects.effect import Effect
from plants.errors import InputError
from plants.wrist import Wrist

HEADING = "## Deviation of the plant"
HEAD = (
    "plant",
    "forms",
    "C: angle [deg]",
    "C: pressure [kPa]",
    *(f"FMI {v}: angle, pressure" for v in VERSIONS),
)
SEEN = 1e-3
"""By how much an effect has to change the angle [deg] or the pressure [kPa] to be part of a comparison."""

Array = NDArray[np.float64]


def showing(form: type[Effect], wrist: Wrist, steps: int = STEPS) -> Wrist:
    """A wrist with the first of an effect's trials that shows in the vector of its plant.

    Raises InputError for a form of which none does.
    """
    without = _both(wrist, steps)
    for trial in form.trials(wrist.rig):
        found = wrist + form(**trial)
        if np.abs(_both(found, steps) - without).max() > SEEN:
            return found
    raise InputError(f"{form.NAME} ({form.FORM}): no trial of it shows in {steps} samples")


def _both(wrist: Wrist, steps: int) -> Array:
    """Angle and pressure that a wrist shows under the vector."""
    return plant_vector(plant_part("flexion", wrist), wrist, steps).shown


def plant_row(label: str, wrists: Iterable[Wrist], steps: int = STEPS) -> list[str]:
    """A line: the largest differences of some plants in C, of angle and pressure, and in each unit."""
    rows = np.array([plant_differences(wrist, steps) for wrist in wrists])
    c, *units = [tuple(f"{x:.1g}" for x in pair) for pair in rows.max(axis=0)]
    return [label, str(len(rows)), *c, *(", ".join(pair) for pair in units)]


def plant_differences(wrist: Wrist, steps: int = STEPS) -> list[tuple[float, float]]:
    """Largest differences from Python of angle and pressure: of C, and of the unit of each version of FMI."""
    made = plant_part("flexion", wrist)
    found = plant_vector(made, wrist, steps)
    files = plant_files(made, found)
    return [_in_c(files), *(_in_unit(made, found, files, fmi) for fmi in VERSIONS)]


def _in_c(files: dict[str, str]) -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as place:
        written(files, Path(place))
        said = subprocess.run(["make", "check"], cwd=place, capture_output=True, text=True, check=False)
    shown = re.search(r"differences (\S+) \(angle\) and (\S+) \(pressure\)", said.stdout)
    if shown is None:
        raise RuntimeError(said.stdout + said.stderr)
    return float(shown[1]), float(shown[2])


def _in_unit(made: PlantPart, found: PlantVector, files: dict[str, str], fmi: FMI) -> tuple[float, float]:
    import fmpy

    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{made.name}.fmu"
        path.write_bytes(plant_unit(made, files, fmi))
        described = fmpy.read_model_description(str(path))
        loaded: Any = fmpy.instantiate_fmu(
            fmpy.extract(str(path), f"{place}/unit"), described, "CoSimulation"
        )
        at = {v.name: v.valueReference for v in described.modelVariables}
        inputs, shown = [at[f.member] for f in made.inputs], [at[f.member] for f in made.outputs]
        put, get = (getattr(loaded, f"{w}{'Real' if fmi == '2.0' else 'Float64'}") for w in ("set", "get"))
        put(inputs, found.given[0].tolist())
        if fmi == "2.0":
            loaded.setupExperiment(startTime=found.begin)
            loaded.enterInitializationMode()
        else:
            loaded.enterInitializationMode(startTime=found.begin)
        loaded.exitInitializationMode()
        worst = np.zeros(2)
        for k, (given, expected) in enumerate(zip(found.given.tolist(), found.shown, strict=True)):
            put(inputs, given)
            loaded.doStep(found.begin + k * made.period, made.period)
            worst = np.maximum(worst, np.abs(np.array(get(shown)) - expected))
        loaded.terminate()
        loaded.freeInstance()
    return float(worst[0]), float(worst[1])


def plant_rows(wrist: Wrist, steps: int = STEPS) -> Iterable[list[str]]:
    """The plant under each law, and with each effect in all its forms."""
    yield plant_row("declared", [wrist], steps)
    yield plant_row("declared, of plays", [of_plays(wrist)], steps)
    for name, forms in EFFECTS.items():
        yield plant_row(name, [showing(form, wrist, steps) for form in forms], steps)


if __name__ == "__main__":
    into_page("python -m design.export.plant", HEADING, HEAD, plant_rows(Wrist.flexion()), __doc__)
