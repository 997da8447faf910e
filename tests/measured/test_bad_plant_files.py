"""A parameter set that is wrong is refused in one line: the file, the parameter, and what to do."""

from dataclasses import replace
from pathlib import Path

import pytest

from plants.errors import InputError
from plants.parameters.files import built_in, dump, load


@pytest.fixture
def plant(tmp_path: Path):
    """The flexion set in a file, with a piece of its text replaced: ``plant(old, new)``."""

    def write(old: str = "", new: str = "") -> Path:
        path = tmp_path / "plant.toml"
        dump(built_in("flexion"), path)
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return path

    return write


def section(path: Path, name: str) -> str:
    """The text of one parameter in a file."""
    text = path.read_text(encoding="utf-8")
    start = text.index(f"[parameters.{name}]")
    end = text.find("[parameters.", start + 1)
    return text[start : end if end > 0 else None]


def value_line(path: Path, name: str) -> str:
    """A parameter's section down to its value."""
    return section(path, name).split("\nunit")[0]


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def with_value(plant, name: str, value: str) -> Path:
    old = value_line(plant(), name)
    return plant(old, old.rsplit("=", 1)[0] + f"= {value}")


def test_the_set_itself_loads(plant):
    assert load(plant()).values == built_in("flexion").values


def test_an_unknown_name(plant):
    path = plant("[parameters.gain]", "[parameters.gian]")
    assert refusal(path).startswith(f"{path}: unknown parameter 'gian'; known are gain, k_fast, ")


def test_a_missing_name(plant):
    path = plant(section(plant(), "Tw"), "")
    assert refusal(path).startswith(f"{path}: parameter 'Tw' is missing; all of gain, k_fast, ")


def test_a_wrong_unit(plant):
    path = plant('"kPa/V"', '"bar/V"')
    assert refusal(path) == f"{path}: parameter 'gain': unit 'bar/V' is wrong; give the value in kPa/V"


def test_a_missing_unit(plant):
    path = plant('unit = "kPa/V"\n', "")
    assert refusal(path) == f"{path}: parameter 'gain': unit None is wrong; give the value in kPa/V"


@pytest.mark.parametrize("value", ["1e6", "-3.0"])
def test_a_value_outside_its_bounds(plant, value):
    path = with_value(plant, "gain", value)
    said = refusal(path)
    assert said.startswith(f"{path}: parameter 'gain': value {float(value):g} is outside its bounds ")
    assert said.endswith(" kPa/V")


@pytest.mark.parametrize(
    ("value", "shown"),
    [('"fast"', "'fast'"), ("nan", "nan"), ("inf", "inf"), ("true", "True"), ("[1.0]", "[1.0]")],
)
def test_a_value_that_is_not_a_number(plant, value, shown):
    path = with_value(plant, "Tw", value)
    assert refusal(path) == f"{path}: parameter 'Tw': value {shown} is not a finite number"


def test_a_parameter_that_is_a_bare_number(tmp_path: Path, plant):
    path = plant(section(plant(), "gain"), "")
    path.write_text(
        path.read_text().replace("[parameters.k_fast]", "[parameters]\ngain = 50.0\n[parameters.k_fast]")
    )
    assert refusal(path) == f"{path}: parameter 'gain': needs value, unit and provenance"


def test_bounds_that_are_not_two_numbers(plant):
    bounds = next(x for x in section(plant(), "gain").splitlines() if x.startswith("bounds"))
    path = plant(bounds, "bounds = [1.0]")
    assert refusal(path) == f"{path}: parameter 'gain': bounds must be two numbers, lower and upper"


def test_a_value_without_provenance(plant):
    line = next(x for x in section(plant(), "gain").splitlines() if x.startswith("provenance"))
    path = plant(line, "")
    assert refusal(path).startswith(f"{path}: parameter 'gain': provenance must be ")


def test_a_transit_steeper_than_a_line_runs_backwards(plant):
    value = built_in("flexion").values["s"]
    bounds = next(x for x in section(plant(), "a1").splitlines() if x.startswith("bounds"))
    path = with_value(plant, "a1", f"{value}")
    path.write_text(path.read_text().replace(bounds, "bounds = [0.01, 5.0]"))
    assert refusal(path) == (
        f"{path}: transit slope s = {value:g} is not below a1 = {value:g}, so the loop runs backwards; "
        "check a1, a2, s, w1 and w2"
    )


def test_lines_that_cross_run_backwards(plant):
    bounds = next(x for x in section(plant(), "a2").splitlines() if x.startswith("bounds"))
    path = with_value(plant, "a2", "4.0")
    path.write_text(path.read_text().replace(bounds, "bounds = [0.01, 5.0]"))
    said = refusal(path)
    assert said.startswith(f"{path}: line 1 lies above line 2 at ")
    assert said.endswith(" kPa, so the loop runs backwards; check a1, a2, s, w1 and w2")


@pytest.mark.parametrize("content", [b"axis = flexion\n", b"[parameters", b"axis = '\xff'\n"])
def test_a_file_that_is_no_toml(tmp_path: Path, content):
    path = tmp_path / "plant.toml"
    path.write_bytes(content)
    said = refusal(path)
    assert said.startswith(f"{path}: not valid TOML (")
    assert said.endswith("; see plants/parameters/flexion.toml")


@pytest.mark.parametrize("content", ["", 'axis = "flexion"\n', "axis = 1\n[parameters]\n"])
def test_a_file_that_holds_something_else(tmp_path: Path, content):
    path = tmp_path / "plant.toml"
    path.write_text(content)
    assert refusal(path).startswith(f'{path}: needs axis = "..." and [parameters.NAME] tables')


def test_a_missing_file(tmp_path: Path):
    path = tmp_path / "none.toml"
    assert refusal(path) == f"{path}: no such parameter set; give a .toml file that exists"


def test_a_folder(tmp_path: Path):
    assert refusal(tmp_path) == f"{tmp_path}: is a folder; give the .toml file of a parameter set"


def test_an_offset_may_be_negative_while_the_lines_stay_apart(tmp_path: Path):
    """Angle 0 lies outside the loop of many rigs that were guessed from a log."""
    flexion = built_in("flexion")
    moved = {n: replace(flexion.parameters[n], value=v, low=-20.0) for n, v in (("w1", 14.0), ("w2", -2.0))}
    dump(replace(flexion, parameters={**flexion.parameters, **moved}), tmp_path / "plant.toml")
    assert load(tmp_path / "plant.toml").values["w2"] == -2.0
    moved["w1"] = replace(moved["w1"], value=1.0)
    dump(replace(flexion, parameters={**flexion.parameters, **moved}), tmp_path / "plant.toml")
    with pytest.raises(InputError, match="line 1 lies above line 2"):
        load(tmp_path / "plant.toml")
