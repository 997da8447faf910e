"""The worst case inside a box: plant, starting memory, references, dead time and load, searched for.

What is maximised is the largest excess over the limits that a run shows (overshoot, steady error,
total variation of the command, as `design.evaluation.scaled.scaled` states them) as a share of the limit;
where nothing is found that breaks a limit, the IAE per degree of the last step.  A found worst case is a
lower bound of the true one: a sample, never a proof that there is none worse.

What is fair to the gains: the last reference is at least `SMALLEST` away from the one before, which was held
until the wrist is calm (`design.evaluation.tasks.calm`); those before it may follow each other in full
motion.
The step is judged from the angle where the wrist then is, and overshoot is what lies beyond the
reference, in percent of that step, of `SMALLEST` at least.  A sequence with a reference that no command
can hold says nothing about gains and counts as the mildest of all.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.robustness.box import Box
from design.robustness.samples.search_space import SEQUENCES, Kind, Space
from design.robustness.samples.worst import (
    ASIDE,
    SIMULATED,
    Objective,
    Plain,
    Worst,
    excesses,
    named_plant,
    plain_worst,
    scores,
)
from design.synthesis.requirements import Limits
from plants.errors import InputError
from plants.simulation.periodic import Periodic

Array = NDArray[np.float64]

LANES = (32, 96)
"""Fewest and most runs of a generation, blocks of 16, which the vector units fill; and so many
`GENERATIONS` are aimed at in between."""
GENERATIONS = 40

LOCAL_SHARE, LOCAL_STARTS, LONGEST_LOCAL = 0.25, 3, 400
"""Share of the budget for local searches, their number, and the most runs that one may take: a
single run costs as much time as the 16 of a block."""

APART, OTHERS = 0.2, 3
"""Places of the cube are told apart where a coordinate differs by so much; and so many runners-up are
told beside the worst case."""


class Search:
    """One search: counts its runs, and keeps those that were tried and how they came out."""

    def __init__(
        self,
        space: Space,
        controller: Controller | Periodic,
        limits: Limits,
        objective: Objective,
        jobs: int | None,
    ):
        self.space, self.controller, self.jobs = space, controller, jobs
        self.limits, self.objective = limits, objective
        self.places: list[Array] = []
        self.heights: list[Array] = []
        self.aside = 0

    @property
    def used(self) -> int:
        """Runs so far."""
        return sum(h.size for h in self.heights)

    def height(self, x: Array) -> Array:
        """What is minimised at places x, shape (size, lanes): the score with its sign turned."""
        x = np.clip(x, 0.0, 1.0)
        ok = self.space.reachable(x)
        values = play(self.space.lanes(x), self.controller, jobs=self.jobs).values
        step = self.space.box.wrist.rig.task.step
        height = np.where(ok, -scores(values, self.limits, self.objective, step), ASIDE)
        self.places.append(x)
        self.heights.append(height)
        self.aside += int(np.sum(~ok))
        return height

    def run(self, budget: int, seed: int, tell: Callable[[str, float], None]) -> Array:
        """The place of the worst case, shape (size,)."""
        local = min(int(LOCAL_SHARE * budget), LOCAL_STARTS * LONGEST_LOCAL)
        self.globally(budget - local, seed, tell)
        for number, x in enumerate(self.best(LOCAL_STARTS)):
            tell(f"{self.objective}: local search", number / LOCAL_STARTS)
            self.locally(x, local // LOCAL_STARTS)
        return self.best(1)[0]

    def globally(self, budget: int, seed: int, tell: Callable[[str, float], None]) -> None:
        """Differential evolution over the whole space."""
        from scipy.optimize import differential_evolution

        rng = np.random.default_rng(seed)
        lanes = int(np.clip(budget // GENERATIONS // 16 * 16, *LANES))
        generations = max(budget // lanes - 1, 0)
        begin = _stratified(rng, lanes, self.space.size)
        # The worst plant often is a corner, which chance would not draw.
        corners = begin[: lanes // 2, : len(self.space.box.intervals)]
        corners[:] = np.round(corners)
        done = 0

        def generation(*_: object) -> None:
            nonlocal done
            done += 1
            tell(f"{self.objective}: global search", done / max(generations, 1))

        differential_evolution(
            self.height, [(0.0, 1.0)] * self.space.size, init=begin, maxiter=generations, tol=0.0, atol=0.0,
            polish=False, vectorized=True, updating="deferred", seed=rng, callback=generation,
        )  # fmt: skip

    def locally(self, x: Array, budget: int) -> None:
        """Nelder-Mead from a place: one run at a time."""
        from scipy.optimize import minimize

        steps = np.where(x > 0.5, -0.05, 0.05)
        simplex = np.vstack([x, x + np.diag(steps)])
        cube = [(0.0, 1.0)] * x.size
        options = {"initial_simplex": simplex, "maxfev": max(budget, 1), "adaptive": True}
        minimize(
            lambda y: float(self.height(y[:, None])[0]), x, method="Nelder-Mead", bounds=cube,
            options={**options, "xatol": 1e-6, "fatol": 1e-9},
        )  # fmt: skip

    def best(self, count: int) -> list[Array]:
        """The worst places found, worst first, each `APART` from the others.

        Raises InputError where no place gave a run that counts.
        """
        places, heights = np.hstack(self.places), np.concatenate(self.heights)
        found: list[Array] = []
        for i in np.argsort(heights, kind="stable"):
            x = places[:, i]
            if heights[i] < ASIDE and all(np.max(np.abs(x - other)) > APART for other in found):
                found.append(x)
            if len(found) == count:
                return found
        if not found:
            raise InputError(
                "box: no sequence was found whose references a command in the range holds; give a smaller one"
            )
        return found


def _stratified(rng: np.random.Generator, lanes: int, size: int) -> Array:
    """A Latin hypercube, shape (lanes, size)."""
    rows = np.array([rng.permutation(lanes) for _ in range(size)]).T
    return (rows + rng.random((lanes, size))) / lanes


def worst_case(
    box: Box,
    controller: Controller | Periodic,
    objective: Objective = "excess",
    limits: Limits | None = None,
    dead_time: float = 0.0,
    load: float = 0.0,
    steps: int = 3,
    seed: int = 0,
    jobs: int | None = None,
    progress: Callable[[str, float], None] | None = None,
    budget: int = 20_000,
    duration: float = 10.0,
    kinds: tuple[Kind, ...] = SEQUENCES,
) -> Worst:
    """The worst that was found of a controller of any kind in a box, in `budget` runs.

    objective: ``excess``, after which, where no limit is found broken, ``cost`` is searched for with a
    budget of its own; or ``cost`` alone.  dead_time [s]: up to so much beside the plant's own; load [deg]: a
    constant one of up to so much to either side; steps: references of a sequence; duration [s]: for which
    the last step is judged; kinds: of cases, see `search_space`.  The same for a seed whatever the number of
    threads.

    First differential evolution (Storn and Price 1997, doi 10.1023/A:1008202821328), a generation at
    a time in vector lanes, half of it begun at corners of the box; then Nelder-Mead with the
    coefficients of Gao and Han (2012, doi 10.1007/s10589-010-9329-3) from the best that differ.
    Raises InputError for a dead time, load, budget, duration or number of steps that makes no sense,
    and where no sequence was found that is within reach.
    """
    _refuse(dead_time, load, steps, budget, duration)
    limits, tell = limits or Limits.of(box.plant.rig), progress or (lambda stage, share: None)
    space = Space(box, steps, dead_time, load, duration, kinds)
    wanted: list[Objective] = [objective]
    if not any(n in SIMULATED for n in limits.named):
        wanted = ["cost"]
    plain = plain_worst(box, controller, limits, duration, jobs)
    used, aside, greatest = 0, 0, -np.inf
    for goal in wanted:
        search = Search(space, controller, limits, goal, jobs)
        x = search.run(budget, seed, tell)
        used, aside = used + search.used, aside + search.aside
        found = _described(search, x, plain)
        greatest = max(greatest, found.excess)
        if goal == "excess" and not found.violated:
            wanted.append("cost")
    tell("done", 1.0)
    return replace(found, evaluations=used, set_aside=aside, greatest_excess=greatest, others=_others(search))


def _refuse(dead_time: float, load: float, steps: int, budget: int, duration: float) -> None:
    if not 0.0 <= dead_time <= 0.4:
        raise InputError(f"dead time: {dead_time:g} s is none that is searched; give 0 to 0.4 s")
    if not 0.0 <= load <= 30.0:
        raise InputError(f"load: {load:g} deg is none that is searched; give 0 to 30 deg")
    if not 1 <= steps <= 4:
        raise InputError(f"steps: {steps} references make no sequence that is searched; give 1 to 4")
    if budget < 2 * LANES[0]:
        raise InputError(f"budget: {budget} runs are too few to search; give {2 * LANES[0]} or more")
    if not 1.0 <= duration <= 100.0:
        raise InputError(f"duration: {duration:g} s is none to judge a step in; give 1 to 100 s")


def _others(search: Search) -> tuple[Case, ...]:
    """Runners-up of a search for excess that break a limit, each run by itself."""
    if search.objective == "cost":
        return ()
    runs = [search.space.case(x)[0] for x in search.best(1 + OTHERS)[1:]]
    played = [play(stack([c]), search.controller, jobs=search.jobs).values for c in runs]
    broken = [float(scores(v, search.limits, "excess", 1.0)[0]) > 0.0 for v in played]
    return tuple(c for c, breaks in zip(runs, broken, strict=True) if breaks)


def _described(search: Search, x: Array, plain: Plain) -> Worst:
    """The worst case at a place, run once more by itself: what is told of it is what a replay shows."""
    space, controller, limits = search.space, search.controller, search.limits
    case, values = space.case(x)
    played = play(stack([case]), controller, jobs=search.jobs)
    beyond = {n: float(v[0]) for n, v in excesses(played.values, limits).items()}
    name = max(beyond, key=lambda n: beyond[n], default="")
    return Worst(
        case=case,
        plant=named_plant(space.box, values),
        controller=controller,
        objective=search.objective,
        metrics={n: float(v[0]) for n, v in vars(played.metrics).items()},
        values={n: float(v[0]) for n, v in played.values.items()},
        start=float(played.start[0]),
        size=float(played.size[0]),
        excess=beyond.get(name, -1.0),
        excess_of=name,
        greatest_excess=beyond.get(name, -1.0),
        violated=tuple(n for n, v in beyond.items() if v > 0.0),
        evaluations=0,
        set_aside=0,
        plain=plain,
    )
