"""What a trace makes of soft actuators drawn at random, from their logs alone: the error before and after,
and whether gains that are tuned on the revised plant hold on the actuator.

python -m tests.promise.soft --seed 0 --count 20
python -m tests.promise.soft --seed 0 --count 10 --gains
python -m tests.promise.soft --seed 0 --count 10 --without pressure_kPa
python -m tests.promise.soft --seed 0 --count 10 --joint preisach
"""

import argparse
import tempfile
import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from design.robustness.tuning.recommended import tune_candidates
from design.studies.design_study import Taken, required_of
from design.synthesis.designed_plant import designed
from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.result import Trace
from plants.measured.trace.trace import trace_campaign, trace_for_design
from plants.parameters.quantities import ParameterSet
from plants.simulation.disturbance import dead_time_left
from plants.wrist import Wrist
from tests.promise.held import LATE, Held
from tests.rig.campaign import drop
from tests.rig.core import TICK, Controller
from tests.rig.soft.drawn import preisach_actuator, recordings, soft_actuator
from tests.rig.soft.rig import SoftRig

JOINTS = {"plays": soft_actuator, "preisach": preisach_actuator}

WAYS = (0.0, 1.0, 0.0, -1.0, 0.0, 1.0, -1.0)
"""References over the step of the task, each held for its duration; the first is not judged."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0, help="of the first actuator")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--gains", action="store_true", help="also tune, and close the loop on the actuator")
    parser.add_argument("--without", nargs="+", default=(), metavar="COLUMN", help="what was not logged")
    parser.add_argument("--joint", choices=sorted(JOINTS), default="plays", help="what the joint is made of")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    ratios, kept = [], []
    for seed in range(asked.seed, asked.seed + asked.count):
        rig = JOINTS[asked.joint](seed)
        found = _traced(seed, rig, asked.gains, asked.without)
        if found is None:
            continue
        trace, plant = found
        ratios.append(trace.after["angle_deg"] / trace.before["angle_deg"])
        if asked.gains:
            kept.append(_tuned(rig, plant))
    worse = sum(r > 1.0 for r in ratios)
    print(f"{len(ratios)} of {asked.count} traced, {worse} worse after; median of after / before ", end="")
    print(f"{np.median(ratios):.2f}" if ratios else "-")
    if asked.gains:
        tuned = [k for k in kept if k is not None]
        print(f"{len(tuned)} of {len(kept)} get gains, {sum(tuned)} hold on the actuator, late too")


def _traced(
    seed: int, rig: SoftRig, design: bool, without: Sequence[str]
) -> tuple[Trace, ParameterSet] | None:
    """A line of one actuator, its trace, and the plant, as a design takes it where one follows; None where it
    was refused."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as root:
        folder = Path(root) / "rig"
        rig.write(folder, recordings(seed), ("check",))
        drop(folder, without)
        try:
            campaign = load_campaign(folder)
            trace, plant = (
                trace_for_design(campaign) if design else (t := trace_campaign(campaign), t.revised)
            )
        except InputError as wrong:
            print(f"{seed:4d} refused: {wrong}", flush=True)
            return None
    before, after, noise = (errors["angle_deg"] for errors in (trace.before, trace.after, trace.noise))
    named = ", ".join("|".join((e.name, *e.alternatives)) for e in trace.effects) or "nothing"
    print(
        f"{seed:4d} {trace.verdict}: {before:.3f} to {after:.3f} deg, noise {noise:.3f}; {trace.law.name}; "
        f"{named}; {time.process_time() - began:.0f} s",
        flush=True,
    )
    return trace, plant


def _tuned(rig: SoftRig, plant: ParameterSet) -> bool | None:
    """A line of the gains of one actuator; whether they hold on it, None where none hold in the model."""
    tuned = tune_candidates(required_of(designed(plant), Taken())).best
    gains = tuned.final.gains
    seen = held(rig, gains, plant)
    said = ", ".join(f"{k} {v:.3g}" for k, v in gains.items())
    print(f"     {said} ({'held' if tuned.holds else tuned.ended} in the model); {seen}", flush=True)
    return seen.kept if tuned.holds else None


def held(rig: SoftRig, gains: Mapping[str, float], plant: ParameterSet) -> Held:
    """Close the loop on a soft actuator with gains of a PI or a PI with two degrees of freedom; task, limits,
    range of the command and zero of the angle are of the plant's rig.  Late: with as much more dead time as
    the requirement adds to the plant's own."""
    stated, v = plant.rig, plant.values
    controller = Controller(
        gains["Kp"], gains["Ki"], v["gain"], v["rest_pressure"], *stated.command_range,
        gains.get("b", 1.0), gains.get("Tf", 0.0),
    )  # fmt: skip
    samples, task = round(stated.task.duration / TICK), stated.task
    reference = task.step * np.repeat(WAYS, samples)

    def worst(late: float) -> tuple[float, float, bool]:
        angle = rig.follow(reference, controller, stated.sample_time, stated.zero.angle, late)
        error = (angle - reference).reshape(len(WAYS), samples)[1:]
        steps = task.step * np.diff(WAYS)[:, None]
        outside = np.abs(error) > task.band * task.step
        settling = np.where(outside.any(axis=1), samples - outside[:, ::-1].argmax(axis=1), 0) * TICK
        settling[outside[:, -1]] = np.inf
        return float(np.max(error / steps)), float(settling.max()), False

    added = dead_time_left(Wrist.of(plant), LATE)
    return Held(worst(0.0), worst(added), stated.limits["overshoot_percent"] / 100.0)


if __name__ == "__main__":
    main()
