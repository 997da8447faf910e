"""Bad input of an MPC is refused in one line that says what to do."""

import sys

import numpy as np
import pytest

from design.mpc.fallback import Fallback
from design.mpc.formulations.linear import linear_mpc
from design.mpc.loop import run
from design.mpc.problem import MPCProblem, MPCWeights, Observer
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime
from plants.errors import InputError

WRIST = Wrist.flexion()
BAD = {
    "multiple of the sample time": lambda: MPCProblem(WRIST, period=0.0203),
    "period of 0 s": lambda: MPCProblem(WRIST, period=0.0),
    "horizon of 1 ": lambda: MPCProblem(WRIST, horizon=1),
    "horizon of 30.5": lambda: MPCProblem(WRIST, horizon=30.5),
    "horizon of 100000": lambda: MPCProblem(WRIST, horizon=100_000),
    "weight angle": lambda: MPCWeights(angle=-1.0),
    "weight terminal": lambda: MPCWeights(terminal=float("nan")),
    "weight move": lambda: MPCWeights(move=0.0),
    "both 0": lambda: MPCWeights(angle=0.0, terminal=0.0),
    "rate limit": lambda: MPCProblem(WRIST, rate=0.0),
    "low below high": lambda: MPCProblem(WRIST, low=4.0, high=0.0),
    "dead-time": lambda: MPCProblem(WRIST + DeadTime(0.05)),
    "one wrist at a time": lambda: MPCProblem(WRIST.with_values(Tw=np.array([0.1, 0.2]))),
    "bandwidth": lambda: Observer(bandwidth=0.0),
    "share": lambda: Observer(lack=1.5),
    "patience": lambda: Fallback(patience=-1),
    "budget": lambda: Fallback(budget=0.0),
    "duration": lambda: run(WRIST, linear_mpc(MPCProblem(WRIST)), 15.0, duration=0.0),
}


@pytest.mark.parametrize("words", BAD)
def test_it_is_refused_in_one_line(words):
    with pytest.raises(InputError) as refused:
        BAD[words]()
    assert words.strip() in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_missing_solver_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "daqp", None)
    with pytest.raises(InputError, match="pip install daqp"):
        linear_mpc(MPCProblem(WRIST))
