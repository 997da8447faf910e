"""Controllers x plants x tasks -> scores with paired intervals, and ranks no finer than they support."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.contest import statistics
from design.contest.plants import (
    COUPLING,
    PLANTS,
    RIGS,
    SHARE,
    PlantField,
    day_to_day,
    first,
    nominal,
    perturbed,
    rig,
)
from design.contest.play import METRICS, WORST, both_motions, by_plant, lanes_for, play, told
from design.contest.statistics import FEWEST, ConfidenceInterval
from design.controllers.controller import Controller
from design.evaluation.cases import lanes_of
from design.evaluation.tasks import Task, families, lasts, side_by_side
from design.robustness.samples.conditions import Conditions
from plants.parameters.quantities import ParameterSet
from plants.rig import Rig
from plants.simulation.periodic import Periodic
from plants.simulation.sensor import HOLD
from plants.wrist import Wrist

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]

JUDGED = ("iae_deg_s", "settling_time_s", "total_variation_V")
"""Metrics whose differences get an interval; ranks are given of the first two."""

BOTH = "both at once"

BESIDE = ", with MPCs"
"""What a field is called on which controllers that act once a period are played too."""


@dataclass(frozen=True)
class Score:
    """One controller on one family of tasks in one field of plants.

    mean: of each metric over the plants, where a plant's value is the mean over the tasks, or the worst
    (settling, overshoot, unsettled: share of the plants on which something did not settle); settling_q95
    [s]: 95 % quantile over the plants; against: paired differences to the reference controller; ranks:
    best and worst that the pairs support, of the error and of the settling time.
    """

    motion: str
    field: str
    family: str
    controller: str
    plants: int
    mean: Mapping[str, float]
    settling_q95: float
    against: Mapping[str, ConfidenceInterval]
    ranks: Mapping[str, tuple[int, int]]


@dataclass(frozen=True)
class Contest:
    """Scores, the name of the reference controller, what the sensor was like, plants set aside by motion
    and field, the share of the spread from day to day that each motion's plants
    have, the seed, and the rig."""

    scores: tuple[Score, ...]
    reference: str
    conditions: Conditions
    set_aside: Mapping[tuple[str, str], int]
    spread: Mapping[str, float]
    plants: int
    seed: int
    rig: Rig

    def of(self, motion: str, field: str, family: str) -> list[Score]:
        """The scores of one table, in the order of the controllers."""
        return [s for s in self.scores if (s.motion, s.field, s.family) == (motion, field, family)]

    @property
    def tables(self) -> list[tuple[str, str, str]]:
        """Motion, field and family of each table."""
        return list({(s.motion, s.field, s.family): None for s in self.scores})


def contest(
    plants: Mapping[str, ParameterSet],
    controllers: Mapping[str, Mapping[str, Controller]],
    reference: str = "tuned",
    count: int = PLANTS,
    seed: int = 0,
    jobs: int | None = None,
    progress: Tell | None = None,
    periodic: Mapping[str, Mapping[str, Periodic]] | None = None,
    periodic_count: int = FEWEST,
) -> Contest:
    """Play all controllers of each motion on the perturbed plants and the rigs, and of two motions at once.

    `controllers`: by motion and name, `reference` among them; `count`: plants that are drawn; `periodic`:
    controllers that act once a period and are slow to simulate, so that they meet the plant as it is, with
    and without the effects of the rigs, the first `periodic_count` of the drawn ones, on the steps, and one
    pair of coupled motions; all others are played there once more beside them.  Raises
    InputError as `perturbed` and for a plant with effects of its own.
    """
    tell = progress or (lambda stage, share: None)
    conditions, scores, aside = Conditions(dead_time=0.0, load=0.0), list[Score](), {}
    fields: dict[str, PlantField] = {m: perturbed(p, count, seed) for m, p in plants.items()}
    for number, (motion, drawn) in enumerate(fields.items()):
        given = side_by_side(plants[motion].rig)
        steps = [t for t in given if t.family == "steps"]
        slow = (periodic or {}).get(motion, {})
        declared = nominal(Wrist.of(plants[motion]))
        met: list[tuple[PlantField, list[Task], bool]] = [(declared, given, True), (drawn, given, False)]
        met += [(rig(name, drawn), steps, False) for name in RIGS]
        if slow:
            met += [(first(drawn, periodic_count, f"{drawn.name}{BESIDE}"), steps, True)]
            met += [(rig(n, declared, 1, f"{n}{BESIDE}"), steps, True) for n in RIGS]
        for place, (field, asked, all_) in enumerate(met):
            tell(f"{motion}, {field.name}", place / len(met))
            aside[motion, field.name] = field.set_aside
            entrants: dict[str, Controller | Periodic] = {**controllers[motion], **(slow if all_ else {})}
            played = play(field, entrants, asked, conditions, 10 * seed + number, jobs)
            for family in dict.fromkeys(t.family for t in asked):
                here = [i for i, t in enumerate(asked) if t.family == family]
                values = {n: by_plant(r, here) for n, r in played.items()}
                scores += scored(motion, field.name, family, values, reference, seed)
    if len(plants) == 2:
        tell(BOTH, 0.0)
        scores += coupled_scores(fields, controllers, conditions, reference, seed, jobs)
        if periodic:
            few = {m: first(f, 1, f.name) for m, f in fields.items()}
            every: dict[str, dict[str, Controller | Periodic]] = {
                m: {**controllers[m], **periodic[m]} for m in fields
            }
            scores += coupled_scores(few, every, conditions, reference, seed, jobs, BESIDE)
    spread = {m: day_to_day(p)[1] for m, p in plants.items()}
    return Contest(
        tuple(scores), reference, conditions, aside, spread, count, seed, next(iter(plants.values())).rig
    )


def scored(
    motion: str, field: str, family: str, values: Mapping[str, Mapping[str, Array]], reference: str, seed: int
) -> list[Score]:
    """Scores of the controllers of one table, from each metric of each plant by controller."""
    count = len(next(iter(values.values()))["iae_deg_s"])
    against: dict[str, dict[str, ConfidenceInterval]] = {n: {} for n in values}
    for metric in JUDGED:
        differences = np.array([v[metric] - values[reference][metric] for v in values.values()])
        for name, interval in zip(values, statistics.intervals(differences, seed=seed), strict=True):
            against[name][metric] = interval
    ranks = {m: statistics.ranks({n: v[m] for n, v in values.items()}, seed=seed) for m in JUDGED[:2]}
    return [
        Score(
            motion, field, family, name, count,
            {m: float(v[m].mean()) for m in METRICS},
            float(np.quantile(v["settling_time_s"], 0.95)),
            against[name], {m: r[name] for m, r in ranks.items()},
        )
        for name, v in values.items()
    ]  # fmt: skip


def coupled_scores(
    fields: Mapping[str, PlantField],
    controllers: Mapping[str, Mapping[str, Controller | Periodic]],
    conditions: Conditions,
    reference: str,
    seed: int,
    jobs: int | None,
    beside: str = "",
) -> list[Score]:
    """Steps of both motions at once, all four pairs of signs, from rest, on some of the perturbed plants
    with coupling: the later settling, errors and travels added up."""
    one, two = fields
    count = min(f.count for f in fields.values())
    pick = np.arange(0, count, SHARE)
    virgin = [t for t in side_by_side(fields[one].wrist.rig) if t.family == "steps" and t.start == "virgin"]
    pairs = [(i, a, b) for i in range(pick.size) for a in (0, 1) for b in (0, 1)]
    lanes = []
    for me, motion in enumerate((one, two)):
        gains = {"cross-coupling.gain": np.full(pick.size, COUPLING)}
        wrist = lanes_of(fields[motion].wrist, pick).with_values(**gains)
        field = PlantField(motion, wrist, pick.size)
        asked = [virgin[p[1 + me]] for p in pairs]
        lanes.append(lanes_for(field, [p[0] for p in pairs], asked, conditions, seed, 1000 + me))
    values = {}
    for name in (n for n in controllers[one] if n in controllers[two]):
        a, b = both_motions((controllers[one][name], controllers[two][name]), (lanes[0], lanes[1]), jobs)
        ours, theirs = told(a), told(b)
        joined = {
            m: (np.maximum(v, theirs[m]) if m in WORST else v + theirs[m]).reshape(pick.size, 4)
            for m, v in ours.items()
        }
        values[name] = by_plant(joined, [0, 1, 2, 3])
    return scored(BOTH, f"coupled, {COUPLING:g} deg/kPa{beside}", "steps", values, reference, seed)


def contest_record(found: Contest) -> dict[str, Any]:
    """A contest for JSON: how it was played, and every score flat."""
    scores, rig = [], found.rig
    for s in found.scores:
        record = {n: getattr(s, n) for n in ("motion", "field", "family", "controller", "plants")}
        record |= {**s.mean, "settling_q95_s": s.settling_q95}
        for metric, interval in s.against.items():
            record |= {f"{metric}_difference{end}": v for end, v in
                       (("", interval.mean), ("_low", interval.low), ("_high", interval.high))}  # fmt: skip
        for metric, (best, worst) in s.ranks.items():
            record |= {f"{metric}_rank_best": best, f"{metric}_rank_worst": worst}
        scores.append(record)
    return {
        "reference": found.reference,
        "interval": f"paired, {100 * statistics.LEVEL:g} % BCa bootstrap of the mean over plants; ranks "
        "hold together at this level (Bonferroni over the pairs of a table)",
        "plants_drawn": found.plants, "seed": found.seed, "duration_s": lasts("side by side", rig),
        "band_deg": rig.task.band * rig.task.step, "sample_s": rig.sample_time,
        "command_range_V": list(rig.command_range),
        "sensor": {"noise_deg": found.conditions.noise, "noise_held_s": HOLD * rig.sample_time,
                   "quantum_deg": found.conditions.quantum},
        "share_of_the_day_to_day_spread": dict(found.spread),
        "families": families(rig), "rigs": RIGS, "coupling_deg_per_kPa": COUPLING,
        "set_aside": [{"motion": m, "field": f, "plants": n} for (m, f), n in found.set_aside.items() if n],
        "scores": scores,
    }  # fmt: skip
