"""No compiled kernel reads or writes beyond an array: run once with every index checked.

Numba checks indices only where it is told so before it is loaded, so that this needs a process of its own.
"""

import os
import subprocess
import sys

import pytest

from tests.cli.terminal import ROOT

BEGIN = """
import numpy as np
import design
from design.controllers.controller import Measured
from plants import Wrist
wrist = Wrist.flexion()
"""

CASES = {
    "lanes with a dead time": """
from plants.effects import DeadTime
late = wrist + DeadTime(0.0305)
design.run(late, design.PI(2.0, 5.0), 15.0, duration=0.8)
late.simulate([3.0] * 700)
""",
    "linear MPC": """
controller = design.linear_mpc(design.nominal_mpc(wrist))
state = controller.init(Measured(0.0, 0.0, 100.0))
for angle in (0.0, 0.5, 2.0, 1.0):
    state, _, info = controller.step(state, Measured(15.0 - angle, angle, 110.0))
    assert info.rung == "solved", info
""",
    "real-time MPC": """
controller = design.real_time_mpc(design.robust_mpc(wrist))
state = controller.init(Measured(0.0, 0.0, 100.0))
for angle in (0.0, 0.5, 2.0, 1.0):
    state, _, info = controller.step(state, Measured(15.0 - angle, angle, 110.0))
    assert info.rung == "solved", info
""",
    "a lost pressure": """
from design.mpc import observer
from design.mpc.prediction import coefficients
problem = design.nominal_mpc(wrist)
believed = observer.begin(0.0, 100.0, wrist)
for pressure in (105.0, float("nan")):
    believed = observer.update(
        believed, 2.5, Measured(0.0, 0.0, pressure), observer.gains(problem), coefficients(wrist))
""",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_no_index_is_out_of_bounds(name):
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "PYTHONPATH": str(ROOT)}
    line = [sys.executable, "-c", BEGIN + CASES[name]]
    said = subprocess.run(line, env=environment, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stderr[-600:]


@pytest.mark.slow
def test_an_index_out_of_bounds_is_seen():
    code = """
from plants.kernel import cache
from plants.kernel.templates import module
cache.load(module("a test", "def run(m, n):\\n    m[n] = 1.0\\n"))(__import__("numpy").empty(3), 3)
"""
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "PYTHONPATH": str(ROOT)}
    said = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert "IndexError" in said.stderr
