"""Tasks on plants: a case by itself, and many side by side as lanes of the runner.

Tuning, comparison, contest, Monte Carlo, the search for the worst case and break-even all put tasks on
plants, and none has a loop of its own.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.evaluation import metrics
from design.evaluation.runner import Lanes
from design.evaluation.tasks import Judged, Task, calm
from plants.equilibrium import holding_command, obstacle
from plants.kernel import pytrees
from plants.simulation.disturbance import BEFORE, at_rest, burdened
from plants.simulation.reference_profile import ReferenceProfile
from plants.wrist import Start, State, Wrist

Number = Any
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A task on a plant: `plant` says in words which wrist it is; dead_time [s]: beside the wrist's own."""

    task: Task
    wrist: Wrist
    plant: str = "nominal"
    dead_time: float = 0.0

    @property
    def of_task(self) -> bool:
        """Whether the step that is judged is the rig's: of its size, between 0 and that, begun calmly and not
        a mere load."""
        t, ends = self.task, {0.0, self.wrist.rig.task.step}
        calmly = len(t.references) == 1 or t.holds[-2] >= calm(self.wrist.rig)[0]
        return {abs(t.before), abs(t.reference)} == ends and calmly and t.load_at < 0.0

    @property
    def name(self) -> str:
        """In words: a step by itself as ``0 to +15 deg from line1, nominal plant``, others as ``+15 for 0.8
        s, then -10 deg, from line2, nominal plant, 40 ms of dead time``."""
        t, unit = self.task, self.wrist.rig.units.angle
        more = f", {1000 * self.dead_time:.3g} ms of dead time" if self.dead_time else ""
        more += f", load {t.load:+.3g} {unit}" if t.load else ""
        more += f" after {t.load_at:.3g} s" if t.load and t.load_at >= 0.0 else ""
        return f"{self._asked(unit)}, {self.plant} plant{more}"

    def _asked(self, unit: str) -> str:
        t = self.task
        if t.judged == "own band" and len(t.references) == 1:
            return f"{_signed(t.angle)} to {_signed(t.reference)} {unit} from {t.start}"
        held = zip(t.references[:-1], t.holds[:-1], strict=True)
        steps = [f"{_signed(r)} for {h:.3g} s" for r, h in held]
        begin = f"{_signed(t.angle)} {unit}, {t.start}" if t.angle else t.start
        last = f"{_signed(t.reference)} {unit}, from {begin}"
        return ", ".join([*steps, f"then {last}" if steps else last])


def _signed(angle: float) -> str:
    """An angle with its sign, of which 0 has none."""
    return f"{angle:+.3g}" if angle else "0"


def stack(cases: Iterable[Case]) -> Lanes:
    """Cases, of wrists with the same effects and tasks that are judged alike, as lanes of the runner.

    Dead time and load are effects of all where one has them.

    >>> from design.controllers.pi import PI
    >>> from design.evaluation.runner import play
    >>> one = Case(Task("virgin", 0.0, (15.0,)), Wrist.flexion())
    >>> two = Case(Task("virgin", 0.0, (15.0, 0.0), (0.5, 10.0)), Wrist.flexion())
    >>> played = play(stack([one, two]), PI(1.2, 2.2))
    >>> played.metrics.settling_time_s.round(2).tolist(), played.start.round(2).tolist()
    ([5.59, inf], [0.0, 1.71])
    """
    given = list(cases)
    values = [c.wrist.values for c in given]
    wrist = given[0].wrist.made_of({n: np.array([v[n] for v in values], float) for n in values[0]})
    dead_time = np.array([c.dead_time for c in given], float)
    return on_lanes(wrist, [c.task for c in given], dead_time if dead_time.any() else None)


def on_lanes(wrist: Wrist, tasks: Sequence[Task], dead_time: Number | None = None, longest: int = 1) -> Lanes:
    """Tasks that are judged alike on the lanes of a wrist; dead time [s] as of `as_lanes`.

    One that is shorter than others, or has fewer than `longest` references, first holds its start for no
    time.  Raises ValueError for tasks that are not judged alike.
    """
    if len(alike := {t.judged for t in tasks}) != 1:
        raise ValueError(f"tasks that are judged in different ways do not run side by side: {sorted(alike)}")
    (judged,) = alike
    pad = max(longest, *(len(t.references) for t in tasks))
    ahead = [pad - len(t.references) for t in tasks]
    references = np.array([(t.angle,) * n + t.references for t, n in zip(tasks, ahead, strict=True)]).T
    holds = np.array([(0.0,) * n + t.holds for t, n in zip(tasks, ahead, strict=True)]).T
    angle, load, load_at = (
        np.array([getattr(t, n) for t in tasks], float) for n in ("angle", "load", "load_at")
    )
    return as_lanes(
        wrist, [t.start for t in tasks], angle, references, holds, dead_time, load if load.any() else None,
        load_at, judged, np.array([t.counted for t in tasks]),
    )  # fmt: skip


def as_lanes(
    wrist: Wrist,
    starts: Sequence[Start],
    angle: Number,
    references: Array,
    holds: Array,
    dead_time: Number | None = None,
    load: Number | None = None,
    load_at: Number = BEFORE,
    judged: Judged = "task band",
    counted: Number = 1,
) -> Lanes:
    """What `design.evaluation.tasks.Task` says of each lane as arrays: a wrist with lanes or floats, a start
    for each lane, angles [deg] (lanes,), references [deg] and holds [s] (k, lanes); dead time [s] and load
    [deg], there from load_at [s] on, None where there is none.

    Raises ValueError for lanes of different lengths that are judged stair by stair.
    """
    count, dt = len(starts), wrist.rig.sample_time
    angle = np.broadcast_to(np.asarray(angle, float), (count,))
    load_at = np.broadcast_to(np.asarray(load_at, float), (count,))
    state = _rests(wrist, starts, angle, dead_time, load, load_at)
    ends = np.round(np.cumsum(np.asarray(holds, float), axis=0) / dt)
    switches = np.vstack([np.zeros_like(ends[:1]), ends[:-1]])
    whole = switches[-1] + np.maximum(np.round(np.asarray(holds, float)[-1] / dt), 1.0)
    alike = bool(np.all(whole == whole.max()))
    profile = ReferenceProfile(tuple(np.asarray(references, float)), tuple(switches[1:]), angle)
    loaded, seconds = burdened(wrist, dead_time, load, load_at), int(whole.max()) * dt
    if judged == "stairs":
        if not alike:
            raise ValueError("tasks that are judged stair by stair run side by side where they last as long")
        begins = switches[len(references) - np.broadcast_to(counted, (count,)), np.arange(count)]
        judge = metrics.of_stairs(wrist.rig.task.step, begins, whole - begins, wrist.rig)
        return Lanes(loaded, state, profile, judge, seconds)
    if judged == "own band" and len(references) == 1 and alike:  # no window, which would cost
        judge = metrics.of_step(state.angle, profile.references[0], wrist.rig)
        return Lanes(loaded, state, profile, judge, seconds)
    band = wrist.rig.task.step if judged == "task band" else None
    judge = metrics.of_step_under_way(switches[-1], whole - switches[-1], wrist.rig, band)
    return Lanes(loaded, state, profile, judge, seconds, lasts=whole.astype(np.intp))


def _rests(
    wrist: Wrist,
    starts: Sequence[Start],
    angle: Array,
    dead_time: Number | None,
    load: Number | None,
    load_at: Array,
) -> State:
    """The state of each lane at rest at its angle [deg], having come there by its start."""
    like = burdened(wrist, dead_time, load, load_at).rest()
    found: list[Array] = [np.empty(len(starts)) for _ in pytrees.leaves(like)]
    names = np.array(starts)
    for start in dict.fromkeys(starts):
        here = np.flatnonzero(names == start)
        late = None if dead_time is None else np.broadcast_to(dead_time, angle.shape)[here]
        shift = None if load is None else np.broadcast_to(load, angle.shape)[here]
        state = at_rest(lanes_of(wrist, here), start, angle[here], late, shift, load_at[here])
        for into, leaf in zip(found, pytrees.leaves(state), strict=True):
            into[here] = leaf
    rested: State = pytrees.like(like, found)
    return rested


def lanes_of(wrist: Wrist, pick: NDArray[np.intp]) -> Wrist:
    """Some lanes of a wrist with lanes; one without is its own lanes."""
    values = wrist.values
    lanes = np.broadcast_shapes(*(np.shape(v) for v in values.values()))
    if not lanes:
        return wrist
    return wrist.made_of({n: np.broadcast_to(np.asarray(v, float), lanes)[pick] for n, v in values.items()})


def repeated(lanes: Lanes, n: int) -> Lanes:
    """Lanes n times over, one copy after the other."""
    count = lanes.count

    def again(x: Number) -> Number:
        return np.tile(np.broadcast_to(x, (count,)), n)

    def tree(of: Any) -> Any:
        return pytrees.like(of, [again(x) for x in pytrees.leaves(of)])

    return replace(
        lanes,
        wrist=lanes.wrist.made_of({k: again(v) for k, v in lanes.wrist.values.items()}),
        state=tree(lanes.state),
        reference=tree(lanes.reference),
        judge=tree(lanes.judge),
        lasts=None if lanes.lasts is None else again(lanes.lasts),
        noise=None if lanes.noise is None else np.tile(lanes.noise, n),
    )


def unreachable(case: Case, low: float, high: float) -> float:
    """By how many volts the command that holds the case's last reference lies outside a range [V].

    The wrist is held on the line that it arrives on; 0 where the range suffices,
    infinite where no command at all does, for the reason that `hindrance` gives.

    >>> unreachable(Case(Task("virgin", 0.0, (15.0,)), Wrist.flexion()), 0.0, 4.0)
    0.0
    """
    wrist, t = case.wrist, case.task
    p, plus = wrist.hysteresis, t.reference > t.before
    if hindrance(case):
        return float("inf")
    if wrist.effects:
        start: Start = "line1" if plus else "line2"
        command = holding_command(wrist, wrist.rest(start, t.reference).pressure)
    else:
        pressure = (p.ascending_pressure if plus else p.descending_pressure)(t.reference)
        command = pressure / wrist.regulator.gain
    return float(max(low - command, command - high, 0.0))


def hindrance(case: Case) -> str | None:
    """What keeps the case's wrist from its last reference, or from its start, whatever the command: an
    end stop or a supply that is too low, in words.  None for a declared wrist, and where nothing does."""
    t = case.task
    there: Start = "line1" if t.reference > t.before else "line2"
    words = obstacle(case.wrist, there, t.reference)
    if words is None and t.start in ("line1", "line2"):
        words = obstacle(case.wrist, t.start, t.angle)
    return words
