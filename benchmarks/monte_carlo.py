"""Monte Carlo against the bare kernel: what drawing cases, preparing them and counting them costs."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from benchmarks.rollouts import Disagreement
from benchmarks.timing import duel
from design.controllers.pi import PI
from design.evaluation.metrics import Metrics
from design.evaluation.runner import step_from
from design.robustness.box import box_of
from design.robustness.samples.conditions import NONE, Conditions
from design.robustness.samples.draws import CHUNK, Draw, SamplingTask, draw
from design.robustness.samples.monte_carlo import Samples, monte_carlo
from plants.kernel import pytrees as tree
from plants.parameters.files import built_in
from plants.simulation.closed_loop import advance, clock
from plants.wrist import SAMPLE_TIME

LANES = 8 * CHUNK
"""Cases of a measurement."""

THREADS = 2
CONTROLLER = PI(5.0, 9.0)
DEAD_TIME_AND_LOAD = Conditions(noise=0.0, quantum=0.0)
NOISE = Conditions(dead_time=0.0, load=0.0, quantum=0.0)
STEPS = round(10.0 / SAMPLE_TIME)


def sampled(conditions: Conditions) -> Samples:
    """A Monte Carlo of the flexion's box, from its first draw to its intervals."""
    return monte_carlo(box_of(built_in("flexion")), CONTROLLER, conditions, LANES, jobs=THREADS)


def bare(conditions: Conditions) -> Callable[[], Metrics]:
    """The compiled loop of the same cases behind a perfect sensor, its arrays ready."""
    task = SamplingTask(box_of(built_in("flexion")), CONTROLLER, conditions, 0, 15.0, 10.0)
    cases = [draw(task, chunk) for chunk in range(LANES // CHUNK)]
    first, coefficients = (_joined(parts) for parts in zip(*map(_trees, cases), strict=True))
    times = clock(cases[0].wrist, STEPS)

    def work() -> Metrics:
        last, _ = advance(first, coefficients, STEPS, times, jobs=THREADS)
        judged: Metrics = coefficients.judge.finish(last.judge, STEPS)
        return judged

    return work


def _trees(case: Draw) -> tuple[Any, Any]:
    return step_from(case.wrist, case.state, case.reference).loop(CONTROLLER)


def _joined(parts: tuple[Any, ...]) -> Any:
    """Trees of chunks as one, each leaf an array of all lanes."""
    leaves = zip(*(tree.leaves(part) for part in parts), strict=True)
    return tree.like(parts[0], [np.concatenate([np.broadcast_to(x, CHUNK) for x in leaf]) for leaf in leaves])


def require_same(samples: Samples, judged: Metrics) -> None:
    """Raises Disagreement unless the bare kernel ran the very cases of the Monte Carlo."""
    for field in fields(Metrics):
        if not np.array_equal(getattr(samples.metrics, field.name), getattr(judged, field.name)):
            raise Disagreement(f"Monte Carlo and its bare kernel differ in {field.name}")


def measure(rounds: int) -> dict[str, float | None]:
    """Rates and shares, all on two threads and over box, starting memories and signs of the step."""
    declared, loaded = bare(NONE), bare(DEAD_TIME_AND_LOAD)
    require_same(sampled(NONE), declared())
    require_same(sampled(DEAD_TIME_AND_LOAD), loaded())
    plain = duel(declared, lambda: sampled(NONE), rounds)
    everything = duel(declared, lambda: sampled(Conditions()), rounds)
    return {
        "monte_carlo.rollouts_per_s": LANES / plain.second,
        "monte_carlo.share_of_kernel": plain.ratio,
        "monte_carlo.share_of_kernel_with_noise": duel(declared, lambda: sampled(NOISE), rounds).ratio,
        "monte_carlo.dead_time_and_load_share_of_their_kernel": duel(
            loaded, lambda: sampled(DEAD_TIME_AND_LOAD), rounds
        ).ratio,
        "monte_carlo.dead_time_and_load_share_of_declared_kernel": duel(
            declared, lambda: sampled(DEAD_TIME_AND_LOAD), rounds
        ).ratio,
        "monte_carlo.all_conditions_rollouts_per_s": LANES / everything.second,
        "monte_carlo.all_conditions_share_of_declared_kernel": everything.ratio,
    }
