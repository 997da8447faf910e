"""Bad input ends in one line on stderr and exit code 2, with nothing half-written."""

import pytest

CASES = {
    "campaign that is not there": (["fit", "nowhere"], "nowhere"),
    "plant that is not there": (["show", "--plant", "nowhere.toml"], "nowhere.toml"),
    "gains that are no numbers": (["simulate", "--gains", "a,b"], "--gains"),
    "one gain": (["simulate", "--gains", "1.2"], "--gains"),
    "negative gain": (["simulate", "--gains", "1.2,-1"], "--gains"),
    "two corners": (["tune", "--corners", "0.2,0.1"], "--corners"),
    "corner that leaves nothing": (["tune", "--corners", "0.2,1.0,0.2"], "below 1"),
    "no step": (["simulate", "--gains", "1,1", "--step", "0"], "--step"),
    "unknown memory": (["simulate", "--start", "line3"], "line3"),
    "figure without a model": (["simulate", "--figure", "1"], "5, 6, 8, 10"),
    "unknown cost": (["tune", "--cost", "beauty"], "beauty"),
    "volts that are not finite": (["simulate", "--volts", "nan"], "--volts"),
    "recording that is not there": (["simulate", "--recording", "x.csv"], "x.csv"),
}


@pytest.mark.parametrize("arguments", [c[0] for c in CASES.values()], ids=list(CASES))
def test_one_line_and_exit_code_2(wrist, arguments):
    outcome = wrist(*arguments)
    said = next(words for given, words in CASES.values() if given is arguments)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert said in outcome.err
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize("arguments", [("--verbose", "fit", "nowhere"), ("fit", "nowhere", "--verbose")])
def test_verbose_shows_the_traceback_before_the_line(wrist, arguments):
    outcome = wrist(*arguments)
    assert outcome.code == 2
    assert "Traceback" in outcome.err
    assert outcome.err.splitlines()[-1].startswith("wrist: nowhere")


def test_a_fit_that_fails_leaves_no_file(wrist, tmp_path):
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "campaign.toml").write_text('axis = "flexion"\n')
    outcome = wrist("fit", tmp_path / "c", "--save", tmp_path / "out.toml")
    assert outcome.code == 2
    assert [p.name for p in tmp_path.iterdir()] == ["c"]


def test_output_that_cannot_be_written_is_said_in_one_line(wrist, tmp_path):
    (tmp_path / "file").write_text("")
    outcome = wrist("simulate", "--json", tmp_path / "file" / "x.json")
    assert outcome.code == 2
    assert "cannot be written" in outcome.err
