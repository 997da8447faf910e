"""The exported plant is the simulated one: with every effect, under both laws, as C and as FMU."""

import subprocess
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.controllers.pi import PI
from design.export.catalogue import part
from design.export.formats.fmu import unit
from design.export.formats.folder import contents
from design.export.plant.files import plant_files, plant_part, plant_unit, write_plant
from design.export.plant.vectors import BEGIN, plant_vector
from plants import InputError, Wrist, dynamics
from plants.effects import EFFECTS, FlowLimits
from plants.effects.effect import Effect, parameter
from plants.effects.regulator.dead_time import DeadTime, TubeDeadTime
from plants.effects.regulator.leak import LaminarLeak
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.cross_coupling import PressureCoupling
from plants.rig import Units
from plants.wrist import State
from tests.control.c_target import CC, WRIST, needs_compiler
from tests.laws.second_law import second_law_set

BURDENED = WRIST + TubeDeadTime(0.0305, 0.01) + LaminarLeak(0.02) + PressureCoupling(0.08) + Creep(0.1, 4.0)
PLANTS = {"flexion": WRIST, "with effects": BURDENED, "of plays": Wrist.of(second_law_set())}
NOT_OF_A_FORM = {"moment": 0.4, "supply": 150.0, "low": -8.0, "high": 8.0, "delay": 0.0305}


def written(wrist, folder, steps):
    made = plant_part("flexion", wrist)
    found = plant_vector(made, wrist, steps)
    files = plant_files(made, found)
    for name, text in files.items():
        (folder / name).write_text(text)
    return made, found, files


def checked(folder, *variables):
    return subprocess.run(
        ["make", "check", *variables], cwd=folder, capture_output=True, text=True, check=False
    )


def felt(form):
    """An effect of a form that shows within the first seconds."""
    own = {f.name: NOT_OF_A_FORM[f.name] for f in fields(form) if f.name in NOT_OF_A_FORM}
    strongest = 0 if form is FlowLimits else -1  # of its trials the last is faster than the regulator
    return form(**{**list(form.trials(WRIST.rig))[strongest], **own})


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("name", EFFECTS)
def test_every_form_of_every_effect_does_what_it_does_in_python(name, tmp_path):
    declared = WRIST.simulate(plant_vector(plant_part("flexion", WRIST), WRIST, 2000).given[:, 0]).angle[1:]
    for i, form in enumerate(EFFECTS[name]):
        folder = tmp_path / str(i)
        folder.mkdir()
        _, found, _ = written(WRIST + felt(form), folder, 2000)
        assert np.abs(found.shown[:, 0] - declared).max() > 1e-3, form.FORM
        said = checked(folder, "CFLAGS=-O0")
        assert said.returncode == 0, (form.FORM, said.stdout, said.stderr)


@needs_compiler
@pytest.mark.parametrize("wrist", PLANTS.values(), ids=PLANTS)
def test_c_replays_ten_thousand_samples(wrist, tmp_path):
    made, found, _ = written(wrist, tmp_path, 10_000)
    assert found.given.shape == (10_000, len(made.inputs))
    said = checked(tmp_path)
    assert said.returncode == 0, said.stdout + said.stderr
    assert "10000 steps, 0 refused" in said.stdout


@needs_compiler
def test_c_that_answers_otherwise_is_seen(tmp_path):
    made, found, _ = written(BURDENED, tmp_path, 300)
    shown = found.shown.copy()
    shown[200, 1] += 1e-5
    for name, text in plant_files(made, found._replace(shown=shown)).items():
        (tmp_path / name).write_text(text)
    assert checked(tmp_path).returncode != 0


class Unit:
    """A unit that FMPy has loaded."""

    def __init__(self, content, fmi, folder, begin=0.0):
        fmpy = pytest.importorskip("fmpy")
        folder.mkdir()
        path = folder / "one.fmu"
        path.write_bytes(content)
        self.description = fmpy.read_model_description(str(path))
        self.loaded = fmpy.instantiate_fmu(
            fmpy.extract(str(path), unzipdir=str(folder / "unit")), self.description, "CoSimulation"
        )
        self.at = {v.name: v.valueReference for v in self.description.modelVariables}
        self.kind, self.begin = ("Real" if fmi == "2.0" else "Float64"), begin
        self.path, self.fmi = path, fmi

    def start(self, **given):
        if self.fmi == "2.0":
            self.loaded.setupExperiment(startTime=self.begin)
        self.put(**given)
        self.loaded.enterInitializationMode(**({} if self.fmi == "2.0" else {"startTime": self.begin}))
        self.loaded.exitInitializationMode()

    def put(self, **given):
        getattr(self.loaded, f"set{self.kind}")([self.at[n] for n in given], list(given.values()))

    def get(self, *names):
        return getattr(self.loaded, f"get{self.kind}")([self.at[n] for n in names])

    def end(self):
        self.loaded.terminate()
        self.loaded.freeInstance()


@needs_compiler
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
@pytest.mark.parametrize("wrist", PLANTS.values(), ids=PLANTS)
def test_fmpy_finds_nothing_wrong_and_replays_the_vector(wrist, fmi, tmp_path):
    pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    made, found, files = written(wrist, tmp_path, 3000)
    one = Unit(plant_unit(made, files, fmi), fmi, tmp_path / "fmu", BEGIN)
    assert validate_fmu(str(one.path)) == []
    names, shown = [f.member for f in made.inputs], [f.member for f in made.outputs]
    one.start(**dict(zip(names, map(float, found.given[0]), strict=True)))
    worst, before = np.zeros(2), one.get(*shown)
    for k, row in enumerate(found.given):
        begin = BEGIN + k * made.period
        one.put(**dict(zip(names, map(float, row), strict=True)))
        if k % 5 == 0:  # half a sample changes nothing that is shown, nor does an input after its begin
            one.loaded.doStep(begin, 0.5 * made.period)
            assert one.get(*shown) == before
            one.put(**{names[0]: 0.0})
            one.loaded.doStep(begin + 0.5 * made.period, 0.5 * made.period)
        else:
            one.loaded.doStep(begin, made.period)
        before = one.get(*shown)
        worst = np.maximum(worst, np.abs(np.array(before) - found.shown[k]))
    assert one.get("code") == [0.0]
    one.end()
    assert np.all(worst <= made.tolerance), worst


@needs_compiler
def test_a_step_of_the_simulator_may_be_many_samples(tmp_path):
    made, _, files = written(WRIST, tmp_path, 60)
    one = Unit(plant_unit(made, files, "3.0"), "3.0", tmp_path / "fmu")
    one.start()
    one.put(command_V=3.0)
    one.loaded.doStep(0.0, 0.2)
    expected = WRIST.simulate([3.0] * 200)
    assert one.get("angle_deg", "pressure_kPa") == pytest.approx(
        [expected.angle[-1], expected.pressure[-1]], abs=1e-9
    )
    one.end()


@needs_compiler
@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_the_units_of_controller_and_plant_close_the_loop_of_the_simulator(fmi, tmp_path):
    wrist = WRIST + DeadTime(0.02)
    law = part("pi", "flexion", WRIST, (1.2, 2.2))
    made, _, files = written(wrist, tmp_path, 60)
    plant = Unit(plant_unit(made, files, fmi), fmi, tmp_path / "plant")
    control = Unit(unit(law, contents(law, WRIST, 60), fmi), fmi, tmp_path / "control")
    plant.start()
    angle, pressure = plant.get("angle_deg", "pressure_kPa")
    control.start(start_angle_deg=angle, start_pressure_kPa=pressure)

    controller, c = PI.of(WRIST, 1.2, 2.2), wrist.sampled()
    k, state = controller.sampled(made.period), wrist.rest()
    memory = controller.holding(state.pressure, Measured(0.0, 0.0, state.pressure))
    furthest = 0.0
    for i in range(1500):
        reference = 15.0 if i < 800 else -10.0
        angle, pressure = plant.get("angle_deg", "pressure_kPa")
        assert (angle, pressure) == pytest.approx((float(state.angle), float(state.pressure)), abs=1e-8)
        control.put(reference_deg=reference, angle_deg=angle)
        control.loaded.doStep(i * made.period, made.period)
        plant.put(command_V=control.get("command_V")[0])
        plant.loaded.doStep(i * made.period, made.period)
        memory, command = k.act(memory, Measured(reference - state.angle, state.angle, state.pressure))
        state = stepped(state, float(np.clip(command, *wrist.rig.command_range)), c, made.period * i)
        furthest = max(furthest, float(state.angle))
    plant.end()
    control.end()
    assert furthest > 4.0 > 3.0 > float(state.angle)  # it began to follow both steps


LINE: list[float] = []


def stepped(state, command, c, time):
    """A step of the plant whose dead time is 20 whole samples, its line kept here."""
    if time == 0.0:
        LINE[:] = [state.effects[0].line.newest] * 21
    tube = state.effects[0]
    tube = tube._replace(line=tube.line._replace(near=LINE[-20], far=LINE[-21]))
    after = dynamics.step(state._replace(effects=(tube,)), command, c)
    LINE.append(float(after.effects[0].line.newest))
    del LINE[:-21]
    return State(after.pressure, after.memory, after.angle, after.effects)


HOSTILE = """
#include "flexion_plant.h"
#include <math.h>
#include <stdio.h>
int main(void)
{
    flexion_plant_state s;
    flexion_plant_given g;
    flexion_plant_shown a, b;
    int i;
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e308, -1e308};
    g.command_V = NAN;
    if (flexion_plant_init(&s, INFINITY, &g, &a) != FLEXION_PLANT_BAD_INPUT) return 1;
    if (!isfinite(a.angle_deg)) return 1;
    for (i = 0; i < 5; i++) {
        g.command_V = bad[i];
        if (flexion_plant_step(&s, &g, &b) == FLEXION_PLANT_OK) return 2;
        if (a.angle_deg != b.angle_deg || a.pressure_kPa != b.pressure_kPa) return 3;
    }
    g.command_V = 3.0;
    for (i = 0; i < 1000; i++) {
        if (flexion_plant_step(&s, &g, &b) != FLEXION_PLANT_OK) return 4;
    }
    return b.pressure_kPa > 140.0 && b.pressure_kPa < 149.0 ? 0 : 5;
}
"""


@needs_compiler
def test_what_is_no_number_leaves_the_plant_as_it_was(tmp_path):
    written(WRIST, tmp_path, 60)
    (tmp_path / "hostile.c").write_text(HOSTILE)
    made = ["flexion_plant.c", "flexion_plant_law.c", "-lm", "-o", "hostile"]
    words = [CC, "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "hostile.c", *made]
    assert subprocess.run(words, cwd=tmp_path, check=False).returncode == 0
    assert subprocess.run(["./hostile"], cwd=tmp_path, check=False).returncode == 0


@needs_compiler
def test_units_of_a_rig_are_names_and_text_and_no_code(tmp_path):
    fmpy = pytest.importorskip("fmpy")
    units = Units('x; system("ls") */', "<script>&|\n", "$\\alpha$%s\\")
    wrist = replace(BURDENED, rig=replace(WRIST.rig, units=units))
    made, _, files = written(wrist, tmp_path, 60)
    said = checked(tmp_path)
    assert said.returncode == 0, said.stdout + said.stderr
    assert [f.member for f in made.inputs] == ["command_x_system_ls_per", "other_pressure_script"]
    assert "<script>" not in files["README.md"]
    (tmp_path / "one.fmu").write_bytes(plant_unit(made, files, "3.0"))
    described = fmpy.read_model_description(str(tmp_path / "one.fmu"))
    told = {v.name: v.unit for v in described.modelVariables}
    assert told["command_x_system_ls_per"] == units.command


def test_names_of_the_state_are_those_of_its_effects():
    names = [f.member for f in plant_part("flexion", BURDENED).members]
    assert {"pressure_kPa", "creep_angles_0_deg", "dead_time_line_line_kPa", "dead_time_behind_kPa"} <= set(
        names
    )


class Untold(NamedTuple):
    """A state that says nothing of itself."""

    level: float


class Undescribed(NamedTuple):
    """Its coefficients."""

    share: float

    def target(self, s, target, around):
        return s, target


@dataclass(frozen=True)
class Silent(Effect):
    """An effect whose state nobody can name."""

    NAME = "silent"
    FORM = "silent"
    STAGE = "regulator"
    HAPPENS = "Nothing is told"
    share: float = parameter("1", "share", 0.0, 1.0, 0.0)

    def sampled(self, wrist, dt):
        return Undescribed(self.share)

    def rest(self, wrist, pressure, angle):
        return Untold(0.0)


class Branching(Undescribed):
    """A law that asks a symbol whether it is positive."""

    def target(self, s, target, around):
        return s, target if target > 0.0 else 0.0


@dataclass(frozen=True)
class Decided(Silent):
    """An effect that has no C."""

    def sampled(self, wrist, dt):
        return Branching(self.share)


@pytest.mark.parametrize(
    ("effect", "words"), [(Silent(), "Untold.level: a state without unit"), (Decided(), "silent.*has no C")]
)
def test_an_effect_that_has_no_c_is_refused_in_one_line(effect, words):
    with pytest.raises(InputError, match=words) as refused:
        plant_part("flexion", WRIST + effect)
    assert "\n" not in str(refused.value)


def test_a_target_that_a_plant_has_not_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match="--target st: a plant is written as c or fmu"):
        write_plant(plant_part("flexion", WRIST), WRIST, "st", tmp_path / "new")
    assert not (tmp_path / "new").exists()
