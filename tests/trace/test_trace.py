"""A few campaigns of the independent rig: one effect, two, none, one that no library lists."""

import pytest

from plants.parameters.files import dump, load
from plants.wrist import Wrist
from tests.rig.campaign import make_campaign
from tests.trace.traces import trace_folder

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def creeping(tmp_path_factory):
    folder = tmp_path_factory.mktemp("creep") / "c"
    rig = make_campaign(folder, "flexion", ["creep"], seed=41)
    return rig, trace_folder(folder)


def test_one_effect_is_named_and_the_error_falls_to_the_noise(creeping):
    _, trace = creeping
    assert (trace.verdict, [e.name for e in trace.effects]) == ("explained", ["creep"])
    assert trace.before["angle_deg"] > 3.0 * trace.noise["angle_deg"]
    assert trace.after["angle_deg"] < 1.2 * trace.noise["angle_deg"]
    assert trace.after_interval["angle_deg"][1] < trace.before_interval["angle_deg"][0]


def test_the_noise_floor_is_the_rigs(creeping):
    rig, trace = creeping
    assert trace.noise["angle_deg"] == pytest.approx(rig.noise.angle_deg, rel=0.05)
    assert trace.noise["pressure_kPa"] == pytest.approx(rig.noise.pressure_kPa, rel=0.05)


def test_declared_parameters_come_back_once_the_cause_is_known(creeping):
    rig, trace = creeping
    for name in ("a1", "a2", "s", "w1", "w2"):
        error = trace.revised.parameters[name].provenance.std_error
        truth = getattr(rig.declared, name)
        assert abs(trace.revised.values[name] - truth) < max(6.0 * error, 0.02 * truth), name


def test_the_revised_plant_can_be_saved_and_read(creeping, tmp_path):
    _, trace = creeping
    dump(trace.revised, tmp_path / "revised.toml")
    again = load(tmp_path / "revised.toml")
    assert again.values == pytest.approx(trace.revised.values)
    assert Wrist.of(again).forms == Wrist.of(trace.revised).forms


@pytest.mark.suite
def test_two_effects_at_two_stages(tmp_path):
    make_campaign(tmp_path / "c", "deviation", ["dead-time", "end-stop"], seed=42)
    trace = trace_folder(tmp_path / "c")
    assert sorted(e.name for e in trace.effects) == ["dead-time", "end-stop"]
    assert trace.verdict == "explained"


@pytest.mark.suite
def test_a_pair_at_one_stage(tmp_path):
    make_campaign(tmp_path / "c", "flexion", ["softening", "gyro-drift"], seed=43)
    trace = trace_folder(tmp_path / "c")
    assert sorted(e.name for e in trace.effects) == ["gyro-drift", "softening"]


@pytest.mark.parametrize("correlation", [0.0, 0.1])
def test_a_rig_that_is_as_declared(tmp_path, correlation):
    make_campaign(tmp_path / "c", "deviation", [], seed=44, correlation_s=correlation)
    trace = trace_folder(tmp_path / "c")
    assert (trace.verdict, trace.effects) == ("nothing-missing", ())
    assert trace.after == trace.before


@pytest.mark.suite
def test_an_effect_that_no_library_lists_is_described_but_not_named(tmp_path):
    make_campaign(tmp_path / "c", "flexion", ["eccentric-sensor"], seed=45)
    trace = trace_folder(tmp_path / "c")
    assert trace.verdict == "unexplained"
    (stage,) = trace.unexplained
    assert stage.name == "wrist"
    assert stage.after.depends_on
    assert trace.after["angle_deg"] <= trace.before["angle_deg"]
