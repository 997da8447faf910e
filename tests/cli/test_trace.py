"""``wrist trace`` answers in JSON, TOML, a page and words, and finds bad places before it begins."""

import contextlib
import io
import json
from pathlib import Path

import pytest

import design.synthesis.retune
from design.cli import main
from design.cli.places import check_places
from design.synthesis.requirements import default_problem
from design.synthesis.tuning import Region, tune
from plants import InputError
from plants.parameters.files import load
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist
from tests.rig.campaign import make_campaign

pytestmark = pytest.mark.slow

KEYS = {
    "axis", "verdict", "before", "after", "noise_floor", "effects", "unexplained", "cannot_judge", "law",
    "explained_share", "remainder", "correlation", "instrument", "learnt_block",
}  # fmt: skip


def quick_problem(wrist, jobs=None):
    """Tuning on the nominal step alone."""
    return default_problem(wrist, nominal=True, jobs=jobs)


def quick_tune(problem, region=None, starts=5, seed=0, progress=None):
    """Tuning on a coarse map."""
    return tune(problem, Region(points=8), 1, seed, progress)


def run(*arguments):
    """Exit code, stdout and stderr of a command, run once for several tests."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main([str(a) for a in arguments])
        except SystemExit as stop:
            code = int(stop.code or 0)
    return code, out.getvalue(), err.getvalue()


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """A short campaign of a rig with dead time."""
    folder = tmp_path_factory.mktemp("rigs") / "late"
    make_campaign(folder, "flexion", ["dead-time"], seed=4, short=True, variants={"dead-time": 1})
    return folder


@pytest.fixture(scope="module")
def answered(late, tmp_path_factory):
    """Everything at once: folder of what was written, the JSON, and what people read."""
    place = tmp_path_factory.mktemp("out")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design.synthesis.retune, "tune", quick_tune)
        patch.setattr(design.synthesis.retune, "late_problem", quick_problem)
        code, out, err = run(
            "trace", late, "--json", "-", "--save", place / "deep" / "plant.toml", "--out", place / "page",
            "--retune",
        )  # fmt: skip
    assert code == 0, err
    return place, json.loads(out), err


def test_help_carries_an_example(wrist):
    outcome = wrist("trace", "--help")
    assert outcome.code == 0
    assert "wrist trace" in outcome.out.replace("\n", " ")


def test_the_answer_has_the_keys_that_others_read(answered):
    _, record, _ = answered
    assert set(record) == KEYS | {"control"}
    assert record["verdict"] == "explained"
    assert set(record["before"]) == set(record["after"]) == {"angle_rmse_deg", "pressure_rmse_kPa"}
    assert set(record["noise_floor"]) == {"angle_deg", "pressure_kPa"}
    (effect,) = record["effects"]
    assert (effect["name"], effect["stage"]) == ("dead-time", "regulator")
    assert {"alternatives", "form", "parameters"} <= set(effect)
    assert set(effect["parameters"]["delay"]) == {"value", "unit", "std_error"}
    assert record["after"]["pressure_rmse_kPa"] < 0.5 * record["before"]["pressure_rmse_kPa"]
    assert record["unexplained"] is None
    assert record["cannot_judge"] == ["cross-coupling"]


def test_people_read_the_verdict_first_then_errors_effects_and_what_is_open(answered):
    _, _, said = answered
    words = " ".join(said.split())
    assert words.startswith("The pressure answers the command late: with dead-time (transport) added, ")
    assert (
        words.index("RMS error of open-loop simulations") < words.index("s.e.") < words.index("cannot decide")
    )
    assert "cross-coupling: the other motion's pressure was not logged" in words
    assert "On the revised plant, since only data is at hand" in words


def test_the_revised_plant_makes_the_round_trip_and_other_commands_take_it(answered, wrist):
    place, record, _ = answered
    path = place / "deep" / "plant.toml"
    plant = load(path)
    assert plant.values["dead-time.delay"] == record["effects"][0]["parameters"]["delay"]["value"]
    assert load(place / "page" / "revised.toml").values == plant.values
    command = [plant.values["rest_pressure"] / plant.values["gain"]] * 20 + [3.0] * 200
    pressure = open_loop(Wrist.of(plant), command).pressure
    delay = 1000.0 * plant.values["dead-time.delay"]
    moved = int((pressure - pressure[0] > 1e-3).argmax())
    assert moved == pytest.approx(20 + delay, abs=2)
    shown = wrist("show", "--plant", path, "--json", "-").json
    assert shown["dead-time.delay"]["provenance"]["kind"] == "fitted"
    assert wrist("simulate", "--plant", path, "--gains", "2,5").code == 0


def test_the_page_lies_beside_its_figures_and_the_same_answer(answered):
    place, record, said = answered
    names = {p.name for p in (place / "page").iterdir()}
    assert {"trace.html", "trace.json", "revised.toml", "errors.png", "control.png"} <= names
    assert json.loads((place / "page" / "trace.json").read_text()) == record
    assert "trace.html" in said.replace("\n", "")


def test_both_pis_are_reported(answered):
    _, record, _ = answered
    control = record["control"]
    assert control["judge"].startswith("the revised plant")
    for side in ("declared", "revised"):
        assert {"Kp", "Ki", "iae_deg_s", "overshoot_percent", "settling_time_s", "oscillates"} <= set(
            control[side]
        )
    assert control["declared"]["limits_broken_on_the_revised_plant"]
    assert not control["revised"]["limits_broken_on_the_revised_plant"]


@pytest.mark.parametrize("option", ["--save", "--json", "--out"])
@pytest.mark.parametrize("place", ["under a file", "the wrong kind"])
def test_a_bad_place_is_found_before_the_work(wrist, late, tmp_path, monkeypatch, option, place):
    import plants.measured.trace.trace as work

    monkeypatch.setattr(work, "trace_campaign", lambda *_: pytest.fail("the work was begun"))
    (tmp_path / "file").write_text("")
    wrong = tmp_path / "file" if option == "--out" else tmp_path
    outcome = wrist(
        "trace", late, option, wrong if place == "the wrong kind" else tmp_path / "file" / "x" / "y"
    )
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert option in outcome.err
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_looking_at_a_place_leaves_nothing(tmp_path):
    check_places({"--save": tmp_path / "a" / "b.toml", "--json": Path("-")}, tmp_path / "c")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="--save"):
        check_places({"--save": tmp_path})


def test_an_axis_without_built_in_parameters_is_traced_from_the_log_alone(wrist, late, tmp_path):
    own = tmp_path / "own"
    own.mkdir()
    for path in late.iterdir():
        (own / path.name).write_text(path.read_text().replace('"flexion"', '"elbow"'))
    outcome = wrist("trace", own, "--json", tmp_path / "elbow.json", "--save", tmp_path / "elbow.toml")
    assert outcome.code == 0
    record = json.loads((tmp_path / "elbow.json").read_text())
    assert [e["name"] for e in record["effects"]] == ["dead-time"]
    assert record["law"]["name"] == "four-segment"
    assert [o["name"] for o in record["law"]["others"]] == ["prandtl-ishlinskii"]
    assert record["explained_share"]["angle"] > 0.9
    assert record["remainder"]["angle_share_of_range"] < 0.005
    assert load(tmp_path / "elbow.toml").axis == "elbow"


def test_a_campaign_of_the_regulator_alone_has_no_loop_to_tune(wrist, late, tmp_path):
    folder = tmp_path / "regulator"
    folder.mkdir()
    for path in late.glob("*.csv"):
        header, *rows = [line.split(",") for line in path.read_text().splitlines()]
        kept = [i for i, name in enumerate(header) if name != "angle_deg"]
        (folder / path.name).write_text("".join(",".join(r[i] for i in kept) + "\n" for r in (header, *rows)))
    text = (late / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text('stage = "regulator"\n' + text)
    outcome = wrist("trace", folder, "--json", "-", "--retune", "--out", tmp_path / "page")
    assert outcome.code == 0, outcome.err
    assert outcome.json["before"]["angle_rmse_deg"] is None
    assert outcome.json["noise_floor"]["angle_deg"] is None
    assert "no angle" in outcome.json["control"]["refusal"]
    assert (tmp_path / "page" / "fit-pressure.png").exists()
