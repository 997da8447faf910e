"""``python -m benchmarks``: measure, print a table, write build/bench.json.

Exit codes: 0 measured, 1 the contestants do not compute the same, 2 no C compiler that works.
"""

import argparse
import json
import os
import platform
import sys
import tempfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks import commands, logs, monte_carlo, mpc, native, others, rollouts, tuner
from plants.files import write_atomically
from plants.kernel.batches import default_jobs

MEANING = {
    "rollouts.max_difference": "largest difference of a metric, ours and C: |a-b| / max(1, |b|)",
    "rollouts.max_difference_samples": "the same of rise and settling time, in samples",
    "rollouts.vs_simd_c_one_thread": "our throughput / SIMD C's (vectors of 4), both one thread",
    "rollouts.vs_simd_c_8_wide_one_thread": "the same, C with vectors of 8 (only with AVX-512)",
    "rollouts.vs_scalar_c_two_threads": "our throughput on two threads / scalar C's on one",
    "rollouts.vs_python_control": "python-control's time per rollout / ours on two threads",
    "rollouts.vs_do_mpc": "do-mpc's time per rollout / ours; 1 s simulated, times 10",
    "rollouts.ours_ms_per_rollout_one_thread": "ms per rollout",
    "rollouts.ours_ms_per_rollout_two_threads": "ms per rollout",
    "rollouts.simd_c_ms": "ms per rollout, one thread",
    "rollouts.simd_c_8_wide_ms": "ms per rollout, one thread",
    "rollouts.scalar_c_ms": "ms per rollout, one thread",
    "rollouts.python_control_ms": "ms per rollout, response not judged",
    "rollouts.do_mpc_ms": "ms per rollout, response not judged; 1 s simulated, times 10",
    "monte_carlo.rollouts_per_s": "cases per s, box and memories varying, from draw to interval, two threads",
    "monte_carlo.share_of_kernel": "its rate / the bare kernel's on the same cases, both two threads",
    "monte_carlo.share_of_kernel_with_noise": "the same with 100 Hz sensor noise; the kernel without",
    "monte_carlo.dead_time_and_load_share_of_their_kernel": "with dead time and load / kernel with both",
    "monte_carlo.dead_time_and_load_share_of_declared_kernel": "the same / the declared wrist's kernel",
    "monte_carlo.all_conditions_rollouts_per_s": "cases per s, dead time, load, noise and quantum too",
    "monte_carlo.all_conditions_share_of_declared_kernel": "its rate / the declared wrist's kernel",
    **mpc.MEANING,
    **tuner.MEANING,
    **logs.MEANING,
    "cli.help_s": "s, `wrist --help`, a process",
    "cli.second_start_s": "s, `wrist simulate`, a second process",
    "tune.warm_s": "s, `wrist tune`, a second process",
    "trace.warm_s": "s, `wrist trace` of a campaign of 364 s, a second process",
}
"""What each figure says; also the order of the table."""

OTHERS_ROUNDS = 5
"""Rounds beside python-control and do-mpc, one run of which takes up to a second."""

PACKAGES = ("numpy", "numba", "llvmlite", "casadi", "control", "do-mpc", "scipy")


def context(rounds: int) -> dict[str, Any]:
    """The machine and the versions that the figures belong to."""
    versions = {"python": platform.python_version(), "C compiler": native.version()}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    machine = {
        "system": platform.platform(),
        "processor": _processor(),
        "processors_usable": default_jobs(),
        "load_before": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
    }
    return {"machine": machine, "versions": versions, "lanes": rollouts.LANES, "rounds": rounds}


def _processor() -> str:
    """Name of the processor; Linux keeps it in a file."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


def table(figures: dict[str, float | None], why: dict[str, str], about: dict[str, Any]) -> str:
    """The figures for people."""
    machine, wide = about["machine"], max(len(key) for key in MEANING)
    lines = [
        f"{machine['processor']}, {machine['processors_usable']} processors, "
        f"load {machine['load_before']} before",
        "Rollouts: closed loop and metrics, 10 s at 1 ms, steps of +-15 deg; plants and gains by lane;",
        f"  {rollouts.LANES} lanes beside C, {others.LANES} beside python-control and do-mpc;",
        f"  Monte Carlo: {monte_carlo.LANES} cases of the flexion's box, 10 s each.",
        "MPC: 15 deg, both motions and signs, every starting memory; period 20 ms, horizon 30.",
        "Ratios: medians of ratios of neighbouring measurements, the order alternating, over "
        f"{about['rounds']} rounds",
        f"  ({OTHERS_ROUNDS} beside python-control and do-mpc); times: medians.",
        "",
    ]
    for key, meaning in MEANING.items():
        value = figures.get(key)
        shown = "n.a." if value is None else f"{value:.3g}" if value < 100 else f"{value:.0f}"
        lines.append(f"{key:{wide}}  {shown:>9}  {why.get(key, meaning)}")
    return "\n".join(lines)


def main() -> int:
    """Measure everything; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=Path("build/bench.json"), help="where the figures go")
    parser.add_argument("--rounds", type=int, default=15, help="rounds beside the C loops (default 15)")
    options = parser.parse_args()
    try:
        about = context(options.rounds)
        with tempfile.TemporaryDirectory() as folder:
            figures = rollouts.measure(Path(folder), options.rounds)
        figures |= others.measure(OTHERS_ROUNDS)
        figures |= monte_carlo.measure(options.rounds)
        figures |= mpc.measure(OTHERS_ROUNDS)
        figures |= tuner.measure()
        figures |= logs.measure(OTHERS_ROUNDS)
    except native.NoCompiler as missing:
        print(missing, file=sys.stderr)
        return 2
    except rollouts.Disagreement as failed:
        print(failed, file=sys.stderr)
        return 1
    timed, why = commands.measure()
    figures |= timed
    assert figures.keys() == MEANING.keys()
    print(table(figures, why, about))
    write_atomically(options.json, json.dumps({**figures, "context": about}, indent=2) + "\n")
    print(f"\nwritten: {options.json}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
