"""A revised set goes through a file unchanged to the last bit; one that is wrong is refused in one line."""

import numpy as np
import pytest

from plants import InputError, Wrist
from plants.effects import Creep, DeadTime, TwoTimeCreep, known_effects
from plants.parameters.files import built_in, dump, load
from plants.parameters.quantities import Fitted, kinds_of
from tests.design.effect_samples import FORMS, IDS, present

VALUES = {"creep.gain": 0.064, "creep.time_constant": 3.3, "dead-time.delay": 0.1, "a1": 0.341}
ERRORS = {"creep.gain": 0.001, "dead-time.delay": None, "a1": 0.002}

DECLARED = built_in("flexion").parameters


def revised():
    return built_in("flexion").revised([Creep, DeadTime], VALUES, ERRORS, "p1 (sha256 ab12)")


@pytest.fixture
def plant(tmp_path):
    """The revised set in a file, with a piece of its text replaced: ``plant(old, new)``."""

    def write(old="", new=""):
        path = tmp_path / "revised.toml"
        dump(revised(), path)
        text = path.read_text()
        assert old in text
        head, _, effects = text.partition("[effects.")
        path.write_text(head + ("[effects." + effects).replace(old, new, 1))
        return path

    return write


def refusal(path):
    with pytest.raises(InputError) as caught:
        load(path)
    said = str(caught.value)
    assert "\n" not in said
    assert said.startswith(f"{path}: ")
    return said.removeprefix(f"{path}: ")


@pytest.mark.parametrize("form", FORMS, ids=IDS)
def test_every_form_comes_back_from_its_file(form, tmp_path):
    rng = np.random.default_rng(5)
    values = {f"{form.NAME}.{n}": float(rng.uniform(k.low, k.high)) for n, k in form.kinds().items()}
    errors = dict.fromkeys(values, float(rng.uniform()))
    one = built_in("deviation").revised([form], values, errors, "p2", title="Deviation, revised")
    dump(one, tmp_path / "revised.toml")
    again = load(tmp_path / "revised.toml")
    assert again == one
    assert Wrist.of(again) == Wrist.of(built_in("deviation")) + form.from_values(values)
    dump(again, tmp_path / "twice.toml")
    assert (tmp_path / "twice.toml").read_bytes() == (tmp_path / "revised.toml").read_bytes()


def test_a_set_without_effects_has_no_table_of_them(tmp_path):
    dump(built_in("flexion"), tmp_path / "declared.toml")
    assert "effects" not in (tmp_path / "declared.toml").read_text()
    assert load(tmp_path / "declared.toml") == built_in("flexion")


def test_effects_stand_in_the_order_in_which_they_act(plant):
    assert revised().effects == (DeadTime, Creep)
    assert list(revised().parameters) == [*DECLARED, "dead-time.delay", "creep.gain", "creep.time_constant"]
    assert load(plant()) == revised()


def test_what_was_revised_is_fitted_and_the_rest_is_as_before():
    before, after = built_in("flexion"), revised()
    assert after.parameters["creep.gain"].provenance == Fitted("p1 (sha256 ab12)", 0.001)
    assert after.parameters["creep.time_constant"].provenance == Fitted("p1 (sha256 ab12)", None)
    assert after.parameters["a1"].provenance == Fitted("p1 (sha256 ab12)", 0.002)
    assert {n: p for n, p in after.parameters.items() if n in DECLARED and n != "a1"} == {
        n: p for n, p in before.parameters.items() if n != "a1"
    }
    assert after.title == "flexion with dead-time, creep, fitted to p1 (sha256 ab12)"
    assert after.assumed == [n for n in before.assumed if n != "a1"]
    assert after.record["creep.gain"] == {
        "value": 0.064, "unit": "1",
        "provenance": {"kind": "fitted", "data": "p1 (sha256 ab12)", "std_error": 0.001},
    }  # fmt: skip


def test_revising_again_takes_another_form_in_place_of_the_first():
    values = {f"creep.{n}": v for n, v in vars(TwoTimeCreep(0.05, 1.0, 0.03, 9.0)).items()}
    again = revised().revised([TwoTimeCreep], values, {}, "p2")
    assert again.effects == (DeadTime, TwoTimeCreep)
    assert Wrist.of(again).values["creep.ratio"] == 9.0
    assert again.parameters["dead-time.delay"].provenance == Fitted("p1 (sha256 ab12)", None)


@pytest.mark.parametrize(
    "values", [{"creep.gain": 0.1}, {"creep.gain": 0.1, "creep.time_constant": 3.0, "creep.depth": 0.1}]
)
def test_a_value_that_lacks_or_is_nobodys_is_refused(values):
    with pytest.raises(KeyError, match=r"creep\.(time_constant|depth)"):
        built_in("flexion").revised([Creep], values, {}, "p1")


def test_a_parameter_of_an_effect_has_a_kind():
    assert kinds_of(DECLARED, [Creep])["creep.gain"].high == 1.0
    assert kinds_of(DECLARED)["gain"].unit == "kPa/V"
    for name in ("creep.gain", "nonsense"):
        with pytest.raises(KeyError):
            kinds_of(DECLARED, [DeadTime])[name]


def test_unbounded_goes_to_the_widest_bounds_of_effects_too(plant):
    path = plant("bounds = [0.4, 200.0]", "bounds = [3.0, 5.0]")
    narrow = load(path).parameters["creep.time_constant"]
    assert (narrow.low, narrow.high) == (3.0, 5.0)
    wide = load(path).unbounded().parameters["creep.time_constant"]
    assert (wide.low, wide.high) == (0.4, 200.0)


def test_an_unknown_effect(plant):
    said = refusal(plant("[effects.creep]", "[effects.crepe]\nform = 'x'\n[effects.creep]"))
    assert said == f"unknown effect 'crepe'; known are {', '.join(known_effects())}"


def test_an_unknown_form(plant):
    said = refusal(plant('form = "one time constant"', 'form = "no time constant"'))
    assert said == (
        "effect 'creep': unknown form 'no time constant'; known are 'one time constant', "
        "'two time constants', 'logarithm of time'"
    )


def test_no_form(plant):
    assert refusal(plant('form = "one time constant"', "")).startswith("effect 'creep': unknown form None; ")


def test_an_unknown_parameter(plant):
    said = refusal(plant("[effects.creep.parameters.gain]", "[effects.creep.parameters.gian]"))
    assert said == "effect 'creep': unknown parameter 'gian'; known are gain, time_constant"


def test_a_missing_parameter(plant):
    said = refusal(plant('form = "one time constant"', 'form = "two time constants"'))
    assert said == (
        "effect 'creep': parameter 'gain_late' is missing; all of gain, time_constant, gain_late, ratio "
        "are needed"
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('unit = "1"', 'unit = "deg"', "unit 'deg' is wrong; give the value in 1"),
        ("value = 0.064", "value = 1.5", "value 1.5 is outside its bounds 0 to 1 1"),
        ("value = 0.064", "value = true", "value True is not a finite number"),
        ('064\nunit = "1"\nbounds = [0.0, 1.0]', '064\nunit = "1"\nbounds = [1.0]',
         "bounds must be two numbers, lower and upper"),
        ('kind = "fitted"', 'kind = "guessed"', None),
    ],
)  # fmt: skip
def test_a_wrong_entry_is_named_with_effect_and_parameter(plant, old, new, said):
    path = plant(*(("[effects.dead-time]", "[effects.dead-time]") if said is None else (old, new)))
    if said is None:
        head, mark, tail = path.read_text().rpartition("[effects.creep.parameters.gain]")
        path.write_text(head + mark + tail.replace(old, new, 1))
        assert refusal(path).startswith("effect 'creep': parameter 'gain': provenance must be ")
    else:
        assert refusal(path) == f"effect 'creep': parameter 'gain': {said}"


@pytest.mark.parametrize("text", ["effects = 3\n", "effects = ['creep']\n"])
def test_effects_that_are_no_tables(tmp_path, text):
    path = tmp_path / "revised.toml"
    dump(built_in("flexion"), path)
    path.write_text(text + path.read_text())
    assert refusal(path).startswith("effects must be [effects.NAME] tables; known are dead-time, ")


def test_an_effect_without_parameters(plant, tmp_path):
    path = tmp_path / "bare.toml"
    dump(built_in("flexion"), path)
    path.write_text(path.read_text() + '\n[effects.creep]\nform = "one time constant"\n')
    assert refusal(path) == (
        "effect 'creep': needs form = \"...\" and [effects.creep.parameters.NAME] tables"
    )


def test_samples_of_every_form_are_within_their_bounds():
    for form in FORMS:
        for name, kind in form.kinds().items():
            assert kind.low <= getattr(present(form), name) <= kind.high
