"""Where no range is told, a feedforward commands what the paper's regulator takes, all of it and no more."""

from functools import partial

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.controllers.feedforward import Feedforward, FeedforwardPI
from plants import Wrist

WRIST = Wrist.flexion()


@pytest.mark.parametrize("range_", [None, (0.5, 3.0)], ids=["default", "told"])
@pytest.mark.parametrize("kind", [Feedforward, partial(FeedforwardPI, Kp=50.0)], ids=["alone", "with a PI"])
def test_far_references_take_the_command_to_both_ends(kind, range_):
    low, high = range_ or (0.0, 4.0)
    controller = kind(WRIST, **({} if range_ is None else {"low": low, "high": high}))
    c, state = controller.sampled(), controller.holding(WRIST.rest().pressure)
    commands = []
    for k in range(1200):
        state, command = c.act(state, Measured(30.0 if k < 600 else -30.0, 0.0, 100.0))
        commands.append(float(command))
    assert (min(commands), max(commands)) == (low, high)
    assert np.abs(np.array(commands)[[599, 1199]] - [high, low]).max() < 1e-9
