"""Ctrl-C ends the command, whatever it is doing, with exit code 130 and without half a file."""

import os
import sys

import pytest

from plants import files
from tests.cli.terminal import ROOT, on_terminal

CTRL_C = "\x03"
EXAMPLE = ROOT / "plants/measured/examples/flexion"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "sign"),
    [
        (("tune", "--plain", "--starts", "100"), "local search"),
        (("fit", EXAMPLE, "--starts", "50"), "fit flexion"),
        (("robust", "--gains", "2.3,6.4"), "certificates"),
    ],
    ids=["tune, in compiled rollouts", "fit, in threads", "robust, in a solver"],
)
def test_ctrl_c_at_work(tmp_path, arguments, sign):
    seen = on_terminal(*arguments, "--out", tmp_path, press=(CTRL_C, lambda screen: sign in screen))
    assert seen.code == 130
    assert seen.screen.count("wrist: stopped") == 1
    assert "Traceback" not in seen.screen
    assert seen.screen.rindex("\x1b[?25h") > seen.screen.rfind("\x1b[?25l")  # the cursor is back
    assert list(tmp_path.iterdir()) == []


STUBBORN = """
import sys, threading, time
from design.cli import errors
from design.cli.terminal import stopping

def swallows():
    while True:
        try:
            print("busy", flush=True)
            time.sleep(60)
        except KeyboardInterrupt:
            pass

def waits_for_a_thread():
    threading.Thread(target=time.sleep, args=(600,)).start()
    print("busy", flush=True)
    time.sleep(600)

def stays_in_compiled_code():
    import numpy
    matrix = numpy.random.default_rng(0).random((6000, 6000))
    threading.Timer(0.5, print, ["busy"], {"flush": True}).start()  # when svd is at work
    numpy.linalg.svd(matrix)  # minutes

stop = stopping.hear_stop()
try:
    globals()[sys.argv[1]]()
except KeyboardInterrupt:
    pass
"""


@pytest.mark.slow
@pytest.mark.parametrize("how", ["swallows", "waits_for_a_thread", "stays_in_compiled_code"])
def test_ctrl_c_where_python_does_not_act_on_it(how):
    seen = on_terminal(
        how,
        command=[sys.executable, "-c", STUBBORN],
        press=(CTRL_C, lambda screen: "busy" in screen),
        OPENBLAS_NUM_THREADS="1",
    )
    assert seen.code == 130
    assert seen.screen.count("wrist: stopped") == 1


def test_ctrl_c_that_comes_out_of_an_import_as_another_error_is_still_ctrl_c(wrist, monkeypatch):
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("plants.parameters.files.built_in", interrupted)
    outcome = wrist("show")
    assert (outcome.code, outcome.out, outcome.err) == (130, "", "wrist: stopped\n")


@pytest.mark.parametrize("call", ["replace", "chmod"])
def test_a_file_that_was_interrupted_keeps_its_old_content(tmp_path, monkeypatch, call):
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    path = tmp_path / "page.html"
    path.write_text("old")
    monkeypatch.setattr(os, call, interrupted)
    with pytest.raises(KeyboardInterrupt):
        files.write_atomically(path, "new")
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]
    assert path.read_text() == "old"
