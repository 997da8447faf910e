"""Units of FMI 2.0 and 3.0 are valid for FMPy, which replays the vector through them."""

import io
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

from design.export.catalogue import part
from design.export.formats.fmu import _platform, packed, sources, unit
from design.export.formats.folder import contents
from design.export.vectors import vector
from plants import InputError, Wrist
from tests.control.c_target import GAINS, WRIST, needs_compiler

pytestmark = needs_compiler
STEPS = 1500


@pytest.fixture(
    scope="module",
    params=[k for k in GAINS if k not in ("feedforward", "mpc-robust")],
)
def exported(request):
    made = part(request.param.split()[0], "flexion", WRIST, GAINS[request.param])
    return made, contents(made, WRIST, STEPS), vector(made, WRIST, STEPS)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_fmpy_finds_nothing_wrong_and_replays_the_vector(exported, fmi, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    made, files, found = exported
    path = tmp_path / f"{made.name}.fmu"
    path.write_bytes(unit(made, files, fmi))
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path), unzipdir=str(tmp_path / "unit"))
    loaded = fmpy.instantiate_fmu(folder, description, "CoSimulation")
    at = {v.name: v.valueReference for v in description.modelVariables}
    put, get = ("setReal", "getReal") if fmi == "2.0" else ("setFloat64", "getFloat64")
    if fmi == "2.0":
        loaded.setupExperiment(startTime=0.0)
    getattr(loaded, put)([at["start_pressure_kPa"], at["start_angle_deg"]], [found.pressure, found.angle])
    loaded.enterInitializationMode()
    loaded.exitInitializationMode()
    inputs, worst, codes = [at[f.member] for f in made.inputs], 0.0, set()
    columns = [i for i, _ in made.read]
    for k, row in enumerate(found.rows):
        getattr(loaded, put)(inputs, [float(x) for x in row[columns]])
        # Every fifth sample in two steps of the simulator: the law must run in the first of them only.
        halves = (0.5, 0.5) if k % 5 == 0 else (1.0,)
        for i, share in enumerate(halves):
            loaded.doStep((k + 0.5 * i) * made.period, share * made.period)
        value, code = getattr(loaded, get)([at[made.output.member], at["code"]])
        worst = max(worst, abs(value - row[3]))
        codes.add(code)
    loaded.terminate()
    loaded.freeInstance()
    assert worst <= made.tolerance
    assert codes >= {0.0, 3.0}  # spikes among the samples


def test_names_are_escaped_in_the_description():
    made = part("pi", "flexion", Wrist.flexion(), (1.0, 2.0))
    from dataclasses import replace

    hostile = replace(made, title='<script> "x" & $\\alpha$')
    told = sources(hostile, contents(hostile, WRIST, 60), "2.0")["modelDescription.xml"]
    assert ElementTree.fromstring(told).attrib["description"] == hostile.title


def test_the_same_law_is_the_same_unit():
    made = part("pi", "flexion", WRIST, (1.0, 2.0))
    files = contents(made, WRIST, 60)
    first, again = unit(made, files, "2.0"), unit(made, files, "2.0")
    assert first == again
    names = zipfile.ZipFile(io.BytesIO(first)).namelist()
    assert any(n.startswith("binaries/") for n in names)
    assert np.all([".." not in n for n in names])


@pytest.mark.parametrize(
    ("system", "machine", "folders"),
    [
        ("linux", "x86_64", {"2.0": "linux64", "3.0": "x86_64-linux"}),
        ("darwin", "arm64", {"2.0": "darwin64", "3.0": "aarch64-darwin"}),
        ("win32", "AMD64", {"2.0": "win64", "3.0": "x86_64-windows"}),
    ],
)
def test_folders_of_binaries_have_the_names_of_the_standard(monkeypatch, system, machine, folders):
    """FMI 2.0.4, section 2.3: win64, linux64, darwin64; FMI 3.0.1, section 2.5.1.4.1: architecture-system."""
    monkeypatch.setattr("sys.platform", system)
    monkeypatch.setattr("platform.machine", lambda: machine)
    assert {fmi: _platform(fmi) for fmi in folders} == folders


def test_c_that_does_not_compile_is_told_in_a_line_with_what_the_compiler_said(capfd):
    with pytest.raises(InputError, match=r"^--target fmu: \S+ failed: .*error") as refused:
        packed("law", {"sources/law.c": "no C\n"}, "2.0")
    assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")


def test_what_a_unit_unpacks_to_only_its_owner_may_write():
    made = part("pi", "flexion", WRIST, (1.0, 2.0))
    packed_unit = zipfile.ZipFile(io.BytesIO(unit(made, contents(made, WRIST, 60), "3.0")))
    assert {entry.external_attr >> 16 for entry in packed_unit.infolist()} == {0o644}
