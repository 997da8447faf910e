"""A reader that goes away, or a full disk under stdout, keeps no file from being written."""

import json
import subprocess
from pathlib import Path

import pytest

from tests.cli.terminal import COMMAND, PATIENCE, environment, piped

PLAY = ("simulate", "--gains", "1.2,2.2")


@pytest.mark.slow
def test_a_reader_that_leaves_is_no_error(tmp_path):
    process = subprocess.Popen(
        [*COMMAND, *PLAY, "--out", str(tmp_path), "--json", str(tmp_path / "run.json")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment(),
    )  # fmt: skip
    process.stdout.close()  # as `head` does when it has its lines, before anything is written
    said = process.stderr.read().decode()
    process.stderr.close()
    assert process.wait(PATIENCE) == 0
    assert said == ""
    assert {p.name for p in tmp_path.iterdir()} == {"run.json", "simulate-flexion.png"}
    assert json.loads((tmp_path / "run.json").read_text())["metrics"]["settling_time_s"] > 0.0


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_under_stdout_is_said_and_files_are_written(tmp_path):
    with open("/dev/full", "w") as full:
        outcome = subprocess.run(
            [*COMMAND, *PLAY, "--json", str(tmp_path / "run.json")],
            stdout=full, stderr=subprocess.PIPE, text=True, timeout=PATIENCE, env=environment(),
        )  # fmt: skip
    assert outcome.returncode == 2
    assert outcome.stderr.count("\n") == 1
    assert "stdout cannot be written" in outcome.stderr
    assert json.loads((tmp_path / "run.json").read_text())["axis"] == "flexion"


@pytest.mark.slow
def test_a_process_without_stdout_does_its_work(tmp_path):
    line = f'exec "$@" --json {tmp_path / "run.json"} >&-'
    outcome = subprocess.run(
        ["sh", "-c", line, "sh", *COMMAND, *PLAY],
        stderr=subprocess.PIPE, text=True, timeout=PATIENCE, env=environment(),
    )  # fmt: skip
    assert outcome.returncode == 0, outcome.stderr
    assert (tmp_path / "run.json").exists()


@pytest.mark.slow
def test_json_is_all_there_is_on_stdout_and_words_go_to_stderr():
    outcome = piped(*PLAY, "--json", "-")
    assert json.loads(outcome.stdout)["axis"] == "flexion"
    assert "settles in" in outcome.stderr


@pytest.mark.slow
def test_the_answer_no_is_json_too():
    outcome = piped("tune", "--plain", "--points", "6", "--starts", "1", "--variation", "0.1", "--json", "-")
    assert outcome.returncode == 1
    assert "total_variation_V" in json.loads(outcome.stdout)["refusal"]


def test_bad_input_leaves_stdout_empty():
    outcome = piped("simulate", "--gains", "a,b", "--json", "-")
    assert outcome.returncode == 2
    assert outcome.stdout == ""


@pytest.mark.slow
def test_letters_that_the_encoding_lacks_are_no_reason_to_stop():
    outcome = piped(
        "tune", "--plain", "--points", "6", "--starts", "1", "--cost", "itae", PYTHONIOENCODING="ascii"
    )
    assert outcome.returncode == 0, outcome.stderr
    assert "deg s?" in outcome.stdout  # deg s² elsewhere
