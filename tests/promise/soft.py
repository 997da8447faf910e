"""What a trace makes of soft actuators drawn at random, from their logs alone: error before and after.

python -m tests.promise.soft --seed 0 --count 20
"""

import argparse
import tempfile
import time
import warnings
from pathlib import Path

from plants.errors import InputError
from plants.measured.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign
from tests.rig.soft_random import recordings, soft_actuator


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0, help="of the first actuator")
    parser.add_argument("--count", type=int, default=10)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    ratios = [r for seed in range(asked.seed, asked.seed + asked.count) if (r := _traced(seed)) is not None]
    worse = sum(r > 1.0 for r in ratios)
    print(f"{len(ratios)} of {asked.count} traced, {worse} worse after; median of after / before ", end="")
    print(f"{sorted(ratios)[len(ratios) // 2]:.2f}" if ratios else "-")


def _traced(seed: int) -> float | None:
    """A line of one actuator; its error of the angle after over that before, None where it was refused."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as root:
        folder = Path(root) / "rig"
        soft_actuator(seed).write(folder, recordings(seed), ("check",))
        try:
            trace = trace_campaign(load_campaign(folder))
        except InputError as wrong:
            print(f"{seed:4d} refused: {wrong}", flush=True)
            return None
    before, after, noise = (errors["angle_deg"] for errors in (trace.before, trace.after, trace.noise))
    named = ", ".join(e.name for e in trace.effects) or "nothing"
    print(
        f"{seed:4d} {trace.verdict}: {before:.3f} to {after:.3f} deg, noise {noise:.3f}; {trace.law.name}; "
        f"{named}; {time.process_time() - began:.0f} s",
        flush=True,
    )
    return after / before


if __name__ == "__main__":
    main()
