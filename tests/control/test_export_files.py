"""What is exported depends on the law alone, says what it is, and refuses what cannot be exported."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from design.controllers.feedforward import Feedforward
from design.controllers.lqi import LQI
from design.controllers.measurement.memory_estimator import MemoryObserver
from design.export.catalogue import CATALOGUE, part
from design.export.fields import described
from design.export.formats.folder import contents
from plants import InputError, Wrist
from plants.effects import Creep
from plants.rig import Units, Zero
from tests.control.c_target import CC, GAINS, OWN, WRIST, exported, needs_compiler, quick, run

TEXTS = ("h", "c", "README.md")


def texts(kind):
    """Header, source and README of a controller, by their suffix or name."""
    made, folder = exported(kind)
    return {
        "h": (folder / f"{made.name}.h").read_text(),
        "c": (folder / f"{made.name}.c").read_text(),
        "law": (folder / f"{made.name}_law.c").read_text(),
        "README.md": (folder / "README.md").read_text(),
        "test": (folder / "test_vector.c").read_text(),
    }


@pytest.mark.parametrize("kind", ["pi", "mpc", "mpc-real-time"])
def test_the_same_law_gives_the_same_bytes(kind):
    first, again = (
        contents(part(kind, "flexion", Wrist.flexion(), GAINS[kind]), Wrist.flexion(), 50) for _ in range(2)
    )
    assert first == again
    assert len(first) == 8


def test_every_file_ends_with_the_end_of_a_line():
    """As C99 (5.1.1.2) asks of a source that is not empty."""
    files = contents(part("pi", "flexion", WRIST, GAINS["pi"]), WRIST, 50)
    assert {name for name, text in files.items() if not re.search(r"\S\n\Z", text)} == set()


@pytest.mark.parametrize("kind", quick(GAINS))
def test_no_date_and_no_path_of_the_machine(kind):
    places = [f"/{folder.name}/" for folder in Path("/").iterdir()]  # where any path of this machine begins
    assert places
    for name, text in texts(kind).items():
        assert not re.search(r"\b20\d\d-\d\d|\b\d\d:\d\d\b", text), name
        assert [place for place in places if place in text] == [], name
        assert str(Path.cwd()) not in text


@pytest.mark.parametrize("kind", quick(GAINS))
def test_every_setting_period_unit_and_member_is_told(kind):
    made, found = exported(kind)[0], texts(kind)
    assert f"#define {made.name.upper()}_PERIOD_S {made.period!r}\n" in found["h"]
    for name, value in made.settings.items():
        assert f"{name} = {value!r}" in found["h"]
        assert f"| {name} | {value!r} |" in found["README.md"]
    for f in (*made.inputs, *(f for _, f in made.kept)):
        assert f"{f.declaration} /* {f.unit or 'no unit'}: {f.meaning} */" in found["h"]
        assert f"| `{f.member}` | {f.unit or 'no unit'} | {f.meaning} |" in found["README.md"]
    assert (0.02 if kind.startswith("mpc") else 0.001) == made.period


def test_a_law_asks_only_for_what_it_reads():
    assert [f.member for f in exported("pi")[0].inputs] == ["reference_deg", "angle_deg"]
    assert [f.member for f in exported("feedforward")[0].inputs] == ["reference_deg"]
    assert [f.member for f in exported("observer")[0].inputs] == ["angle_deg", "pressure_kPa"]
    assert [f.member for f in exported("lqi")[0].inputs] == ["reference_deg", "angle_deg", "pressure_kPa"]


def test_the_catalogue_builds_what_the_classes_build():
    w = Wrist.deviation()
    assert part("feedforward", "deviation", w).settings == Feedforward.of(w).settings
    assert part("observer", "deviation", w).settings == MemoryObserver.of(w).settings
    p, settings = w.hysteresis, part("lqi", "deviation", w, GAINS["lqi"]).settings
    assert settings == vars(
        LQI(600.0, -640.0, -70.0, 8.0, (p.a1 + p.a2) / 2, w.Tw, 45.0, gain=w.regulator.gain)
    )


@pytest.mark.parametrize(
    ("kind", "gains", "words"),
    [
        ("pid", (1.0, 2.0), "no controller 'pid'"),
        ("pi", None, "--gains: not given"),
        ("pi", (1.0, -2.0), "not negative"),
        ("pi", (0.0, 0.0), "both 0"),
        ("pi", (1.0, 2.0, 3.0), "3 given"),
        ("lqi", (0.0, 1.0, 1.0, 1.0, 1.0), "must be positive"),
        ("feedforward", (0.0,), "must be positive"),
        ("feedforward-pi", (1.0, 1.0, 0.6), "longer than 0.51 s"),
        ("observer", (-1.0,), "not be negative"),
        ("mpc", (1.0,), "1 given; mpc takes swing [1/deg^2], move [1/V^2], delay [periods]"),
        ("mpc-real-time", (3.0, 0.05, 1.5), "delay of 1.5: give a whole number of periods"),
        ("mpc-robust", (3.0, 0.05, -1.0), "give a whole number of periods, 0 or more"),
        ("mpc-robust", (3.0, 0.05, 26.0), "longer than 0.51 s"),
        ("mpc-robust", (3.0, 0.0, 2.0), "weight move of the MPC is 0"),
    ],
)
def test_bad_requests_are_refused_in_a_line(kind, gains, words):
    with pytest.raises(InputError, match=re.escape(words)) as refused:
        part(kind, "flexion", WRIST, gains)
    assert "\n" not in str(refused.value)
    assert kind in CATALOGUE or "mpc" in str(refused.value)


def test_an_mpc_has_the_weights_that_it_is_given_else_those_of_its_setting():
    own, given = (part("mpc-real-time-robust", "flexion", WRIST, g) for g in (None, (25.0, 50.0, 2.0)))
    changed = {n for n, v in own.settings.items() if given.settings[n] != v}
    assert changed == {"weight swing", "weight move", "delay"}
    assert [given.settings[n] for n in sorted(changed)] == [2.0, 50.0, 25.0]
    assert own.settings["delay"] == 0.0
    late = [f for f in given.members if f not in own.members]
    assert [f.declaration for f in late] == ["double command_line_V[2];", "int command_oldest;"]


def test_a_plant_that_has_no_inverse_is_refused():
    with pytest.raises(InputError, match="no inverse of the effect creep"):
        part("feedforward", "flexion", WRIST + Creep(0.1, 4.0))


def test_a_state_that_nobody_has_described_is_refused():
    from typing import NamedTuple

    class Unknown(NamedTuple):
        secret: float

    with pytest.raises(InputError, match=r"Unknown\.secret"):
        described(Unknown(1.0))


@needs_compiler
@pytest.mark.parametrize(
    ("zero", "converted"),
    [(Zero(-300.0, 26.0), (300.0 + 100.0, 12.0 - 26.0)), (Zero(0.0, 26.0, True), (100.0, 26.0 - 12.0))],
)
def test_what_a_log_counts_from_another_zero_is_converted(tmp_path, zero, converted):
    wrist = replace(WRIST, rig=replace(WRIST.rig, zero=zero))
    made = part("pi", "flexion", wrist, GAINS["pi"])
    files = contents(made, wrist, 50)
    readme, n = files["README.md"], made.name
    assert f"{n}_angle_of_log(angle_deg)" in readme
    assert f"m.reference_deg = {n}_angle_of_log(reference_deg)" in readme
    assert (f"{n}_pressure_of_log(pressure_kPa)" in readme) == bool(zero.pressure)
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    shown = f"{n}_pressure_of_log(100.0)" if zero.pressure else "100.0"
    (tmp_path / "main.c").write_text(
        f'#include <stdio.h>\n#include "{n}.h"\n'
        f'int main(void) {{ printf("%.17g %.17g", {shown}, {n}_angle_of_log(12.0)); return 0; }}\n'
    )
    assert run(CC, *OWN, "main.c", "-o", "main", folder=tmp_path).returncode == 0
    assert tuple(map(float, run("./main", folder=tmp_path).stdout.split())) == pytest.approx(converted)


def test_a_rig_that_counts_from_zero_converts_nothing():
    assert "of_log" not in texts("pi")["h"] + texts("pi")["README.md"]


def test_a_rig_of_other_units_says_what_those_of_the_names_stand_for():
    rig = replace(WRIST.rig, units=Units("counts", "kPa", "<mm>"))
    made = part("pi", "bend", replace(Wrist.flexion(), rig=rig), GAINS["pi"])
    files = contents(made, WRIST, 50)
    said = "V stands for counts, deg for &lt;mm&gt;"
    assert said in " ".join(files["README.md"].split())
    assert said in " ".join(files[f"{made.name}.h"].split())
    plain = part("pi", "bend", Wrist.flexion(), GAINS["pi"])
    assert not any("stands for" in note for note in plain.notes)
