"""A judging suite: many campaigns in one folder, with answers.json beside them as in the practice data."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.rig.campaign import answer, make_campaign, record
from tests.rig.effects import CATALOGUE, OPEN, VOCABULARY
from tests.rig.physics import make_physics_rig

# Pairs of which each partner leaves a trace of its own; those that mimic each other are left out.
PAIRS = (
    ("creep", "dead-time"),
    ("gyro-drift", "fill-exhaust-asymmetry"),
    ("load-step", "periodic-disturbance"),
    ("softening", "fill-exhaust-asymmetry"),
    ("branch-curvature", "gyro-drift"),
    ("cross-coupling", "creep"),
    ("inertia", "dead-time"),
    ("rate-dependence", "load-step"),
    ("end-stop", "periodic-disturbance"),
    ("supply-droop", "cross-coupling"),
    ("creep", "gyro-drift"),
    ("regulator-deadband", "inertia"),
    ("branch-curvature", "dead-time"),
    ("softening", "cross-coupling"),
)
LOUD_ONLY = ("speed-noise", "burst-noise")  # no structure to find: not fit for judging a verdict


class Case(NamedTuple):
    """One campaign of a suite."""

    axis: str
    effects: tuple[str, ...]
    variants: dict[str, int]


def cases(seed: int) -> Iterator[Case]:
    """Every effect on both motions with two variants, 6 pairs, 6 with nothing, 5 outside the vocabulary."""
    rng = np.random.default_rng([seed, 1000])
    axes = ("flexion", "deviation")
    for name in VOCABULARY:
        forms = rng.permutation(np.arange(1, CATALOGUE[name].forms + 1))[:2]
        for axis, form in zip(axes, forms, strict=True):
            yield Case(axis, (name,), {name: int(form)})
    for i in rng.permutation(len(PAIRS))[:6]:
        variants = {name: int(rng.integers(1, CATALOGUE[name].forms + 1)) for name in PAIRS[i]}
        yield Case(str(rng.choice(axes)), PAIRS[i], variants)
    for i in range(6):
        yield Case(axes[i % 2], (), {})
    structured = [name for name in OPEN if name not in LOUD_ONLY]
    for i, name in enumerate(rng.permutation(structured)[:5]):
        yield Case(axes[i % 2], (str(name),), {})


def write_suite(folder: Path, seed: int) -> dict[str, dict[str, object]]:
    """Campaigns s01, s02, ... in a random order, answers.json, and truth.json with every parameter.

    The last is the wrist from first principles.
    """
    listed = list(cases(seed))
    order = np.random.default_rng([seed, 1001]).permutation(len(listed))
    answers, truths = {}, {}
    for number, i in enumerate(order, start=1):
        case, name = listed[i], f"s{number:02d}"
        rig = make_campaign(folder / name, case.axis, case.effects, 1000 * seed + number, case.variants)
        answers[name], truths[name] = answer(rig), rig.truth | {"variants": case.variants}
    name, physics = (
        f"s{len(listed) + 1:02d}",
        make_physics_rig(("flexion", "deviation")[seed % 2], 1000 * seed),
    )
    record(physics, folder / name)
    answers[name], truths[name] = answer(physics), physics.truth
    (folder / "answers.json").write_text(json.dumps(answers, indent=1) + "\n")
    (folder / "truth.json").write_text(json.dumps(truths, indent=1) + "\n")
    return answers
