"""Closed-loop rollouts: ours against hand-written C, scalar and SIMD."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks import native
from benchmarks.timing import duel
from design.controllers.pi import PI
from design.evaluation.metrics import Metrics
from design.evaluation.runner import step_from
from design.evaluation.steps import run
from plants import Wrist
from plants.kernel import pytrees as tree
from plants.simulation.closed_loop import ClosedLoop, SampledClosedLoop
from plants.wrist import SAMPLE_TIME

Array = NDArray[np.float64]
DURATION = 10.0
SAMPLES = round(DURATION / SAMPLE_TIME)
LANES = 1536
"""Lanes of the batch: a multiple of `native.BLOCK`, and of our own blocks for two threads."""

TOLERANCE = 1e-9
"""Largest difference of a metric between contestants, relative beyond 1, absolute below."""

IN_SAMPLES = ("rise_time_s", "settling_time_s")
"""Metrics that count samples, in which rounding may decide for the neighbour."""


class Disagreement(Exception):
    """Two contestants did not compute the same."""


@dataclass(frozen=True)
class Case:
    """A batch of closed loops: plants, gains and references [deg], all varying by lane."""

    wrist: Wrist
    controller: PI
    reference: Array

    def trees(self) -> tuple[SampledClosedLoop, ClosedLoop]:
        """Coefficients and first state, as `design.evaluation.steps.run` makes them."""
        first, c = step_from(self.wrist, self.wrist.rest(), self.reference).loop(self.controller)
        return c, first

    def ours(self, jobs: int) -> tuple[Metrics, ClosedLoop]:
        """Metrics and last state by the workbench."""
        judged, last, _ = run(self.wrist, self.controller, self.reference, duration=DURATION, jobs=jobs)
        return judged, last


def case(lanes: int = LANES, seed: int = 0) -> Case:
    """Steps to 15 and -15 deg with plants around flexion and gains over a wide range."""
    draw = np.random.default_rng(seed).uniform
    wrist = Wrist.flexion().with_values(
        a1=draw(0.30, 0.42, lanes),
        w1=draw(5.0, 7.0, lanes),
        Tw=draw(0.10, 0.20, lanes),
        k_fast=draw(7.0, 11.0, lanes),
    )
    controller = PI(Kp=draw(1.0, 8.0, lanes), Ki=draw(1.0, 30.0, lanes))
    return Case(wrist, controller, np.where(np.arange(lanes) % 2 == 0, 15.0, -15.0))


def judge(last: Array, like: ClosedLoop, c: SampledClosedLoop) -> Metrics:
    """Metrics of the stacked last state of a C loop."""
    judged: Metrics = c.judge.finish(tree.like(like, list(last)).judge, SAMPLES)
    return judged


def differences(a: Metrics, b: Metrics) -> tuple[float, float]:
    """Largest differences between two judgements: of the times, in samples, and of all else."""
    worst = {True: 0.0, False: 0.0}
    for field in fields(Metrics):
        x, y = getattr(a, field.name), getattr(b, field.name)
        timed = field.name in IN_SAMPLES
        with np.errstate(invalid="ignore"):  # infinite in both is the same
            scale = SAMPLE_TIME if timed else np.maximum(1.0, np.abs(y))
            gap = np.where(x == y, 0.0, np.abs(x - y) / scale)
        worst[timed] = float(np.max(gap, initial=worst[timed]))
        if np.isnan(gap).any():
            raise Disagreement(f"{field.name} is not a number")
    return worst[True], worst[False]


def require_same(who: str, samples: float, difference: float) -> None:
    """Raises Disagreement unless times agree to a sample and all else to `TOLERANCE`."""
    if round(samples, 6) > 1.0 or difference > TOLERANCE:
        raise Disagreement(
            f"{who} and ours do not compute the same: times differ by up to {samples:.6g} samples "
            f"(1 allowed), other metrics by up to {difference:.3g} ({TOLERANCE:.0e} allowed)"
        )


def measure(folder: Path, rounds: int) -> dict[str, float | None]:
    """Figures of our rollouts and of the C loops, which are compiled in a folder."""
    batch = case()
    c, s = batch.trees()
    coefficients, start = native.stack(c, LANES), native.stack(s, LANES)
    names = [n for n in native.BUILDS if n != "simd_wide" or native.has_avx512()]
    loops = {name: native.build(name, c, s, folder) for name in names}

    def by_c(name: str) -> Callable[[], Array]:
        def work() -> Array:
            state = start.copy()
            loops[name](SAMPLES, coefficients, state)
            return state

        return work

    judged, _ = batch.ours(jobs=2)
    found = {name: differences(judge(by_c(name)(), s, c), judged) for name in names}
    for name, (samples, difference) in found.items():
        require_same(f"{name} C", samples, difference)

    duels = {
        name: duel(by_c(name), lambda: batch.ours(jobs=jobs), rounds)  # noqa: B023  (called at once)
        for name, jobs in (("simd", 1), ("simd_wide", 1), ("scalar", 2))
        if name in loops
    }
    ms = 1e3 / LANES
    wide = duels.get("simd_wide")
    return {
        "rollouts.max_difference": max(difference for _, difference in found.values()),
        "rollouts.max_difference_samples": max(samples for samples, _ in found.values()),
        "rollouts.vs_simd_c_one_thread": duels["simd"].ratio,
        "rollouts.vs_simd_c_8_wide_one_thread": wide.ratio if wide else None,
        "rollouts.vs_scalar_c_two_threads": duels["scalar"].ratio,
        "rollouts.ours_ms_per_rollout_one_thread": duels["simd"].second * ms,
        "rollouts.ours_ms_per_rollout_two_threads": duels["scalar"].second * ms,
        "rollouts.simd_c_ms": duels["simd"].first * ms,
        "rollouts.simd_c_8_wide_ms": wide.first * ms if wide else None,
        "rollouts.scalar_c_ms": duels["scalar"].first * ms,
    }
