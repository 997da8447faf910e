"""``wrist robust`` answers in three kinds of statement, and refuses bad input in one line."""

import json

import pytest

from design.cli import main
from design.cli.commands.robust import controller, intervals
from design.controllers.pi import PI
from plants import InputError, Wrist
from plants.effects import DeadTime
from plants.parameters.files import built_in, dump

pytestmark = pytest.mark.slow

QUICK = ("--samples", "64", "--budget", "300", "--points", "4")


@pytest.fixture(scope="module")
def assessed(tmp_path_factory):
    """What the command leaves for gains that are certified: the JSON, and the folder of the page."""
    folder = tmp_path_factory.mktemp("robust")
    main_quietly(
        ["robust", "--gains", "1.2,2.2", *QUICK, "--json", str(folder / "r.json"), "--out", str(folder)]
    )
    return json.loads((folder / "r.json").read_text()), folder


def main_quietly(arguments: list[str]) -> int:
    try:
        main(arguments)
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_json_has_the_three_kinds_and_the_worst_case(assessed):
    record, _ = assessed
    for kind in ("certificates", "predictions", "samples"):
        assert record[kind], kind
        for row in record[kind]:
            assert {"statement", "holds", "value", "branch"} <= set(row)
            assert row["holds"] in (True, False, None)
    assert {"scenario", "references_deg", "metrics", "violated"} <= set(record["worst_case"])


def test_the_ladder_is_told_rung_by_rung(assessed):
    record, _ = assessed
    found = {(c["rung"], c["dead_time_s"]): c for c in record["certificates"] if "rung" in c}
    assert found["common quadratic", 0.0]["holds"] is None  # it exists only for timid gains
    assert found["quadratic and Popov", 0.0]["holds"] is True
    assert found["quadratic and Popov", 0.05]["value"] > 0.0
    assert found["discrete-time forms of degree 6", 0.0]["holds"] is True


def test_the_page_and_its_companions_are_written(assessed):
    _, folder = assessed
    names = {p.name for p in folder.iterdir()}
    figures = {"gains.png", "nyquist.png", "sensitivities.png", "describing.png", "samples.png", "worst.png"}
    figures |= {"signature.png", "dead-time.png", "bode.png"}
    assert {"robust.html", "robust.json", "worst.toml"} | figures <= names


def test_the_page_stands_alone_and_is_complete(assessed):
    record, folder = assessed
    page = (folder / "robust.html").read_text()
    for section in (
        "verdict",
        "gains",
        "margins",
        "certificates",
        "cycles",
        "samples",
        "worst",
        "box",
        "made",
    ):
        assert f'id="{section}"' in page
    assert page.count("<figure>") == page.count("<figcaption>") == 10
    assert 'src="' not in page
    assert 'href="http' not in page
    for nothing in ("nan<", "None<", "inf<"):
        assert f">{nothing}" not in page
    for words in record["disagreements"]:
        assert words[:40] in page


def test_the_worst_scenario_can_be_replayed_to_the_same_figures(assessed, wrist):
    record, folder = assessed
    again = wrist("simulate", "--scenario", folder / "worst.toml", "--json", "-").json
    assert again["metrics"]["overshoot_percent"] == record["worst_case"]["metrics"]["overshoot_percent"]


def test_the_predictions_are_those_of_the_comparison(assessed):
    from design.controllers.pi import PI
    from design.open_loops import by_python_control
    from plants import Wrist

    record, _ = assessed
    theirs = max(r["Ms"] for r in by_python_control(Wrist.flexion(), PI(1.2, 2.2)))
    (ours,) = [p["value"] for p in record["predictions"] if p["statement"].startswith("Ms ")]
    assert ours == pytest.approx(theirs, rel=1e-9)


def test_unstable_gains_are_a_no_with_nothing_proved(wrist):
    outcome = wrist("robust", "--gains", "0.5,150", *QUICK, "--json", "-")
    assert outcome.code == 1
    record = outcome.json
    assert record["stable"] is False
    assert not any(c["holds"] for c in record["certificates"] if "rung" in c)
    stable = [p for p in record["predictions"] if "stable on every branch" in p["statement"]]
    assert [p["holds"] for p in stable] == [False]


def test_a_filter_of_the_angle_stands_in_the_loop_and_nothing_is_claimed_of_it(wrist, tmp_path):
    from design.controllers.pi_two_dof import TwoDofPI
    from design.margins import branch_responses, margins
    from design.tuner.gains_file import write
    from plants import Wrist

    gains = {"Kp": 3.0, "Ki": 6.0, "b": 0.7, "Tf": 0.03}
    record = wrist("robust", "--gains", write(tmp_path / "g", gains), *QUICK, "--json", "-").json
    assert {n: record[n] for n in gains} == gains
    rungs = [c for c in record["certificates"] if "rung" in c or "constant" in c["statement"]]
    assert len(rungs) > 10
    assert {(c["status"], c["holds"], c["value"]) for c in rungs} == {("open", None, None)}
    assert all("filter of the angle" in c["because"] for c in rungs)
    theirs = margins(branch_responses(Wrist.flexion()), TwoDofPI(**gains))
    (ours,) = [p["value"] for p in record["predictions"] if p["statement"].startswith("Ms ")]
    assert ours == pytest.approx(float(theirs.Ms), rel=1e-4)
    assert ours > max(m["Ms"] for m in plain_margins(3.0, 6.0)) * 1.02


def plain_margins(Kp: float, Ki: float) -> list[dict[str, float]]:
    from design.controllers.pi import PI
    from design.open_loops import by_python_control
    from plants import Wrist

    return by_python_control(Wrist.flexion(), PI(Kp, Ki))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--gains", "0,2.2"], "--gains: '0,2.2': Kp and Ki must both be above 0"),
        (["--gains", "1.2,0"], "without Ki the error never goes"),
        (["--gains", "-1,2"], "--gains: '-1,2' is not 2 numbers"),
        (["--gains", "1.2,2.2", "--box", "a1=0.38:0.34"], "is inverted"),
        (["--gains", "1.2,2.2", "--box", "a1=0.36:0.36"], "is empty"),
        (["--gains", "1.2,2.2", "--box", "a1"], "--box: 'a1' is not name=low:high"),
        (["--gains", "1.2,2.2", "--box", "nobody=1:2"], "no parameter 'nobody'"),
        (["--gains", "1.2,2.2", "--corners", "1.2,0.1,0.1"], "must be shares below 1"),
        (["--gains", "1.2,2.2", "--plant", "nowhere.toml"], "nowhere.toml"),
        (["--gains", "1.2,2.2", "--load", "14"], "give a smaller load"),
    ],
)
def test_bad_input_is_refused_in_one_line(wrist, arguments, words):
    outcome = wrist("robust", *arguments, *QUICK)
    assert outcome.code == 2
    assert words in outcome.err
    assert outcome.err.count("\n") == 1


def test_a_scheduler_that_is_not_there_is_named(wrist):
    outcome = wrist("robust", "--gains", "1.2,2.2", *QUICK, "--scheduler", "tcp://127.0.0.1:1")
    assert outcome.code == 2
    assert "tcp://127.0.0.1:1" in outcome.err


def test_a_place_that_cannot_be_written_to_is_found_first(wrist, tmp_path):
    (tmp_path / "file").write_text("")
    outcome = wrist("robust", "--gains", "1.2,2.2", "--out", tmp_path / "file")
    assert outcome.code == 2
    assert "is a file; give a folder" in outcome.err


def test_gains_of_two_degrees_of_freedom_are_taken_in_line():
    found = controller("3.1,10.4,0.7,0.01", Wrist.flexion())
    assert (found.Kp, found.Ki, found.b, found.Tf) == (3.1, 10.4, 0.7, 0.01)
    assert type(controller("3.1,10.4,1,0", Wrist.flexion())) is PI


@pytest.mark.parametrize("command", [("robust", "--gains", "1.2,2.2", *QUICK), ("tune", "--two-dof")])
def test_a_dead_time_within_a_plant_s_own_is_refused(wrist, tmp_path, command):
    plant = built_in("flexion").revised([DeadTime], {"dead-time.delay": 0.02}, {}, "p1")
    dump(plant, tmp_path / "late.toml")
    outcome = wrist(*command, "--plant", tmp_path / "late.toml", "--dead-time", "0.015")
    assert outcome.code == 2
    assert "has a dead time of its own, 20 ms" in outcome.err
    assert "give a longer one" in outcome.err


def test_an_interval_that_is_given_twice_is_refused():
    with pytest.raises(InputError, match="given twice"):
        intervals(["a1=0.3:0.4", "a1=0.3:0.5"])


@pytest.mark.suite
def test_what_is_proved_of_a_revised_plant_says_what_it_leaves_out(wrist, tmp_path):
    from plants.effects import Creep
    from plants.parameters.files import built_in, dump

    values = {"creep.gain": 0.1, "creep.time_constant": 4.0}
    plant = built_in("flexion").revised([Creep], values, {n: 0.1 * v for n, v in values.items()}, "a rig")
    dump(plant, tmp_path / "revised.toml")
    outcome = wrist(
        "robust", "--gains", "1.2,2.2", "--plant", tmp_path / "revised.toml", *QUICK, "--json", "-"
    )
    record = outcome.json
    assert record["left_out_of_certificates"] == ["creep"]
    held = [c for c in record["certificates"] if "rung" in c and c["holds"]]
    assert held
    assert all("without creep" in c["because"] for c in held)
    assert "creep.gain" in record["box"]
    assert "Certificates do not include the effects creep" in " ".join(outcome.err.split())
