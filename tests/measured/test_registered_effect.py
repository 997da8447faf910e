"""An effect that is not in the repository, registered with one call, goes wherever the others go."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from plants import Wrist, built_in, effects, load
from plants.effects import EFFECTS, register
from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.effects.wrist.creep import Creep
from plants.errors import InputError
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.stage import Stage
from plants.measured.trace.ranking.screening import screen
from plants.measured.trace.stages.model import Model
from plants.parameters.files import dump
from plants.parameters.quantities import loop_names


class SampledRunOut(NamedTuple):
    """Error of the reading [deg] and its phase per angle [rad/deg]."""

    size: Number
    per_degree: Number

    def sensor(self, s: Nothing, angle: Number, around: Around) -> Number:
        return angle + self.size * np.sin(self.per_degree * angle)


@dataclass(frozen=True)
class RunOut(Effect):
    """The disc of the angle sensor sits off centre."""

    NAME = "run-out"
    FORM = "one sine"
    STAGE = "sensor"
    HAPPENS = "The disc of the angle sensor sits off centre"

    size: Number = parameter("deg", "error of the reading", -5.0, 5.0, 0.0, (-0.5, 0.5))
    cycles: Number = parameter("1", "cycles a revolution", 1.0, 60.0, 8.0, (8.0, 12.0, 16.0))

    def sampled(self, wrist: Any, dt: float) -> SampledRunOut:
        return SampledRunOut(self.size, np.pi / 180.0 * self.cycles)


@dataclass(frozen=True)
class HalfRunOut(RunOut):
    """The same phenomenon in another form."""

    FORM = "half a sine"


@pytest.fixture
def registered():
    """The effect, known while a test runs."""
    before = dict(EFFECTS)
    yield register(RunOut, after="gyro-drift")
    EFFECTS.clear()
    EFFECTS.update(before)


def test_it_acts_in_its_place(registered):
    names = list(EFFECTS)
    assert names[names.index("gyro-drift") + 1] == "run-out"
    assert names[-1] == "periodic-disturbance"
    wrist = Wrist.flexion() + RunOut(0.5) + Creep(0.1)
    assert wrist.forms == (Creep, RunOut)
    volts = 2.0 + np.sin(np.arange(4000) * 1e-3)
    true = (Wrist.flexion() + Creep(0.1)).simulate(volts).angle
    expected = true + 0.5 * np.sin(8.0 * np.pi / 180.0 * true)
    np.testing.assert_allclose(wrist.simulate(volts).angle, expected, atol=1e-9)


def test_without_a_place_it_acts_last_and_again_it_takes_the_same_place(registered):
    assert register(RunOut) is register(RunOut, after="gyro-drift") is RunOut
    assert list(EFFECTS).index("run-out") == list(EFFECTS).index("gyro-drift") + 1
    register(HalfRunOut)
    assert EFFECTS["run-out"] == (RunOut, HalfRunOut)
    del EFFECTS["run-out"]
    register(RunOut)
    assert list(EFFECTS)[-1] == "run-out"


def test_a_parameter_file_takes_it(registered, tmp_path):
    values = built_in("flexion").values | {"run-out.size": 0.4, "run-out.cycles": 11.0}
    revised = built_in("flexion").revised((RunOut,), values, dict.fromkeys(values), "a log")
    dump(revised, tmp_path / "plant.toml")
    assert Wrist.of(load(tmp_path / "plant.toml")).effects == (RunOut(0.4, 11.0),)


def test_a_trace_tries_it_and_finds_it(registered):
    rng = np.random.default_rng(3)
    time = np.arange(1500) * 0.01
    volts = 2.0 + 1.5 * np.sin(0.9 * time)
    wrist = Wrist.flexion()
    response = (wrist + RunOut(0.5, 12.0)).simulate(np.repeat(volts, 10), every=10)
    angle = response.angle[:-1] + rng.normal(0.0, 0.05, time.size)
    playback = Playback(Recording("log", time, volts, angle))
    declared = built_in("flexion")
    stage = Stage("whole", "angle_deg", 0.05, (playback,), loop_names(declared.parameters), declared.rig)
    assert "run-out" in stage.effects
    model = Model(stage, declared, wrist.values)
    best, *others = screen(model, ["creep", "gyro-drift", "run-out"])
    assert best.form is RunOut
    assert best.drop > 10.0 * max(best.chance, *(r.drop for r in others))


def test_what_an_effect_has_to_say_is_asked_for():
    class Mute(Effect):
        NAME = "mute"
        FORM = "none"
        STAGE = "wrist"

        def sampled(self, wrist: Any, dt: float) -> Any:
            return Nothing()

    with pytest.raises(InputError, match="Mute: lacks HAPPENS"):
        register(Mute)
    with pytest.raises(InputError, match="no effect 'fatigue' to act after; one of dead-time, "):
        effects.register(RunOut, after="fatigue")
    assert "run-out" not in EFFECTS


def test_an_effect_without_a_law_is_refused():
    class Lawless(Effect):
        NAME = "lawless"
        FORM = "none"
        STAGE = "wrist"
        HAPPENS = "Nothing happens"

    with pytest.raises(InputError, match="Lawless: lacks sampled"):
        register(Lawless)


def test_a_form_of_a_known_effect_has_its_place():
    class FastCreep(Creep):
        FORM = "fast"

    with pytest.raises(InputError, match="creep: acts before inertia already"):
        register(FastCreep, after="inertia")
