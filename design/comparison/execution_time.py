"""How long the steps of controllers take beside their period: the deadline ledger of a comparison.

Times are the wall's on the machine that made them, of the law in Python; they say what fits, and nothing
about a target (`design.export` makes the C that runs there).
"""

from collections.abc import Mapping
from dataclasses import replace
from time import perf_counter_ns
from typing import Any

import numpy as np

from design.controllers.controller import Controller, Measured
from design.evaluation.steps import holding, run
from design.mpc import loop as by_periods
from design.mpc.fallback import SOLVED, Info
from design.mpc.timing import Ledger, ledger
from plants.kernel import pytrees as tree
from plants.wrist import STARTS, Wrist

LEAVE_OUT = 20
"""First steps that are not counted: code and caches are loaded there."""

DURATION = 2.0
"""Length of each run [s]: the steps of 15 degrees, both signs from every starting memory."""


def deadlines(
    wrist: Wrist, controllers: Mapping[str, Controller], periodic: Mapping[str, Any] | None = None
) -> dict[str, Ledger]:
    """The ledger of each controller on a wrist, whose effects take no part: those that act every sample at
    1 ms, `periodic` ones at their own period.

    >>> from design.controllers.pi import PI
    >>> found = deadlines(Wrist.flexion(), {"PI": PI(3.1, 10.4)})
    >>> found["PI"].steps, found["PI"].period
    (15980, 0.001)
    """
    bare = replace(wrist, effects=())
    found = {
        name: ledger(_of_samples(bare, c), wrist.rig.sample_time, LEAVE_OUT)
        for name, c in controllers.items()
    }
    for name, c in (periodic or {}).items():
        found[name] = ledger(_of_periods(bare, c), c.problem.period, LEAVE_OUT)
    return found


def _of_samples(wrist: Wrist, controller: Controller) -> list[Info]:
    """Records of a law that is stepped in Python along what it saw in a compiled run."""
    infos = []
    c = controller.sampled(wrist.rig.sample_time)
    for start in STARTS:
        for reference in (wrist.rig.task.step, -wrist.rig.task.step):
            rest = wrist.rest(start)
            went = run(wrist, controller, reference, rest, duration=DURATION, record=True)[2]
            assert went is not None
            state: Any = holding(wrist, controller, rest)
            state = tree.like(state, [float(np.ravel(x)[0]) for x in tree.leaves(state)])
            seen = zip(went.measured[:-1, 0].tolist(), went.pressure[:-1, 0].tolist(), strict=True)
            for angle, pressure in seen:
                started = perf_counter_ns()
                state, _ = c.act(state, Measured(reference - angle, angle, pressure))
                infos.append(Info(SOLVED, "", 0, 0, 0, perf_counter_ns() - started))
    return infos


def _of_periods(wrist: Wrist, controller: Any) -> list[Info]:
    infos = []
    for start in STARTS:
        for reference in (wrist.rig.task.step, -wrist.rig.task.step):
            infos += by_periods.run(wrist, controller, reference, wrist.rest(start), DURATION).periods
    return infos
