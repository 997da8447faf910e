"""Which controllers trade speed against robustness best."""

from collections.abc import Iterable
from math import isfinite

from design.comparison.rows import Standing


def margin_s(standing: Standing) -> float:
    """Delay margin [s] by which a controller is judged: of its linear loop, else what it tolerates in
    simulation."""
    tolerated = standing.tolerated_delay_s
    return standing.delay_margin_s if tolerated is None else tolerated


def pareto_front(standings: Iterable[Standing]) -> list[Standing]:
    """Of controllers of one motion that break no limit, those that no other beats in one of worst settling
    time and delay margin without losing in the other; fastest first.  A controller without a loop, whose
    margin is infinite, and one that does not settle are not on it."""
    able = [s for s in standings if not s.breaks and isfinite(margin_s(s)) and isfinite(s.worst_settling_s)]
    able.sort(key=lambda s: (s.worst_settling_s, -margin_s(s)))
    front: list[Standing] = []
    for s in able:
        if not front or margin_s(s) > margin_s(front[-1]):
            front.append(s)
    return front
