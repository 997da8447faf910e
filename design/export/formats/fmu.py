"""Functional mock-up units of FMI 2.0 and 3.0 for co-simulation, from the C that goes to the target.

A unit is an archive with a description in XML, the sources, and the library that the compiler of this machine
makes of them.  Its functions are declared in the template as the standards define them, so that nobody's
headers are needed.
"""

import hashlib
import io
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from design.export.fields import MANUAL, MANUAL_COMMAND, PRESSURE
from design.export.part import Part
from design.export.rendering import render
from plants.errors import InputError

FMI = Literal["2.0", "3.0"]

REFUSED = {
    "2.0": "fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2SetInteger fmi2SetBoolean fmi2SetString "
    "fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate fmi2SerializedFMUstateSize fmi2SerializeFMUstate "
    "fmi2DeSerializeFMUstate fmi2GetDirectionalDerivative fmi2SetRealInputDerivatives "
    "fmi2GetRealOutputDerivatives fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus fmi2GetBooleanStatus "
    "fmi2GetStringStatus",
    "3.0": "fmi3EnterEventMode "
    "fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 "
    "fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64 fmi3GetBoolean fmi3GetString fmi3GetBinary fmi3GetClock "
    "fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 "
    "fmi3SetInt64 fmi3SetUInt64 fmi3SetBoolean fmi3SetString fmi3SetBinary fmi3SetClock "
    "fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies fmi3GetFMUState fmi3SetFMUState "
    "fmi3FreeFMUState fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState "
    "fmi3GetDirectionalDerivative fmi3GetAdjointDerivative fmi3EnterConfigurationMode "
    "fmi3ExitConfigurationMode fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal "
    "fmi3GetShiftFraction fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal "
    "fmi3SetShiftFraction fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates fmi3EnterContinuousTimeMode "
    "fmi3CompletedIntegratorStep fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives "
    "fmi3GetEventIndicators fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates "
    "fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates fmi3EnterStepMode "
    "fmi3GetOutputDerivatives fmi3ActivateModelPartition",
}
"""Functions that a unit has to have and this one answers with an error: it has reals and no more."""


@dataclass(frozen=True)
class UnitVariable:
    """A variable of a unit: place in its table, which is its value reference; name with its unit, unit,
    meaning; causality and variability as FMI has them; start, None for what is computed."""

    place: int
    name: str
    unit: str
    meaning: str
    causality: str
    variability: str
    start: float | None


def variables(part: Part) -> list[UnitVariable]:
    """Time, where the law starts from, its inputs, its output and its return code."""
    rest = part.sensors.rest_pressure, part.sensors.rest_angle
    held = part.within(part.begin(*rest)[1])
    at_rest = {PRESSURE: rest[0], MANUAL: 0.0, MANUAL_COMMAND: held}
    rows: list[tuple[str, str, str, str, str, float | None]] = [
        ("time", "s", "time of the simulation", "independent", "continuous", None),
        ("start_pressure_kPa", "kPa", "pressure at which it starts from rest", "parameter", "fixed", rest[0]),
        ("start_angle_deg", "deg", "angle at which it starts from rest", "parameter", "fixed", rest[1]),
        *((f.member, f.unit, f.meaning, "input", "discrete", at_rest.get(f, rest[1])) for f in part.inputs),
        (part.output.member, part.output.unit, part.output.meaning, "output", "discrete", None),
        ("code", "", "return code of the last sample: 0 where all was believed", "output", "discrete", None),
    ]
    return [UnitVariable(i, *row) for i, row in enumerate(rows)]


def sources(part: Part, files: dict[str, str], fmi: FMI) -> dict[str, str]:
    """Files of a unit as text, by their places in it; files: those of the part's C export."""

    def drawn(template: str, **values: Any) -> str:
        return render(template, part, **values)

    return texts(part.name, files, variables(part), fmi, "fmu.c.jinja", drawn)


def texts(
    name: str,
    files: dict[str, str],
    listed: list[UnitVariable],
    fmi: FMI,
    template: str,
    drawn: Callable[..., str],
) -> dict[str, str]:
    """Files of the unit of anything that is exported as C under a name, as text, by their places in it.

    files: those of the C; listed: its variables; template: of what joins the C to the standard's functions;
    drawn: fills a template.
    """
    own = {n: files[n] for n in (f"{name}.h", f"{name}.c", f"{name}_law.c")}
    token = hashlib.sha256("\0".join([fmi, *own.values()]).encode()).hexdigest()[:32]
    settable = [v.place for v in listed if v.causality in ("parameter", "input")]
    values = {
        "fmi": fmi, "variables": listed, "token": f"{{{token}}}", "refused": REFUSED[fmi].split(),
        "settable": max(settable), "units": sorted({v.unit for v in listed if v.unit}),
        "parameters": sum(v.causality == "parameter" for v in listed),
        "sources": ["fmu.c", f"{name}.c", f"{name}_law.c"],
    }  # fmt: skip
    own["fmu.c"] = drawn(template, **values)
    described = drawn(f"fmu{fmi[0]}.xml.jinja", **values)
    return {"modelDescription.xml": described} | {f"sources/{n}": text for n, text in own.items()}


def unit(part: Part, files: dict[str, str], fmi: FMI) -> bytes:
    """A unit of a part for this machine; files: those of its C export.

    Raises InputError for a part in single precision, and where there is no C compiler.
    """
    if part.precision != "double":
        raise InputError("--precision: a functional mock-up unit is in double precision; leave it out")
    return packed(part.name, sources(part, files, fmi), fmi)


def packed(named: str, files: dict[str, str], fmi: FMI) -> bytes:
    """The archive of a unit's files, with the library that the compiler of this machine makes of them.

    Raises InputError where there is no C compiler.
    """
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as out:
        for name, data in [*((n, t.encode()) for n, t in files.items()), _library(named, files, fmi)]:
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            out.writestr(entry, data)
    return archive.getvalue()


def _library(named: str, files: dict[str, str], fmi: FMI) -> tuple[str, bytes]:
    """The library of this machine, and its place in a unit."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise InputError("--target fmu: needs a C compiler (cc, gcc or clang); install one")
    ending = {"darwin": "dylib", "win32": "dll"}.get(sys.platform, "so")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, text in files.items():
            (folder / Path(name).name).write_text(text, encoding="utf-8")
        words = [compiler, "-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off"]
        made = sorted(Path(n).name for n in files if n.endswith(".c"))
        said = subprocess.run(
            [*words, "-o", "unit", *made, "-lm"], cwd=folder, capture_output=True, text=True, check=False
        )
        if said.returncode:
            raise InputError(f"--target fmu: {compiler} failed: {' '.join(said.stderr.split())[:300]}")
        return f"binaries/{_platform(fmi)}/{named}.{ending}", (folder / "unit").read_bytes()


def _platform(fmi: FMI) -> str:
    """Folder of this machine's binaries, as the version of the standard names it."""
    system = {"darwin": "darwin", "win32": "win" if fmi == "2.0" else "windows"}.get(sys.platform, "linux")
    machine = platform.machine().lower().replace("amd64", "x86_64").replace("arm64", "aarch64")
    return f"{system}64" if fmi == "2.0" else f"{machine}-{system}"
