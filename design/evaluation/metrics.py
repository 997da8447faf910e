"""How a step response is judged, computed while it is simulated.

Definitions as in Astrom & Hagglund, Advanced PID Control (2006), and, where both
apply, as ``control.step_info`` computes them: times are those of samples, and
the response is normalised to run from 0 at the start to 1 at the reference.
"""

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from plants.kernel import pytrees
from plants.rig import Rig, built_in_rig
from plants.simulation.reference_profile import Asked
from plants.wrist import State

Number = Any
SETTLING_BAND = built_in_rig().task.band
"""Half-width of the settling band of the built-in rig, as a share of the step."""


class Step(NamedTuple):
    """What a response is normalised by: the angle that it starts from [deg], 1 / step [1/deg]; of one under
    way, 0 where the joint has not yet reached the reference that it is sent back to, else 1."""

    start: Number
    per_step: Number
    ahead: Any = ()


class Window(NamedTuple):
    """Samples that are judged: the first of them, and how many; where the band is that of a task's step, and
    not of the step that begins there, 1 / that step [1/deg]."""

    begins: Number
    lasts: Number
    per_step: Any = ()


class Stairs(NamedTuple):
    """Coefficient of a judgement stair by stair: 1 / the step [1/deg] whose share the band is."""

    per_step: Number


class StairTally(NamedTuple):
    """Of the stairs so far: most samples until one was settled, whether one was not, and the travel of the
    pressure [kPa]."""

    latest: Number
    unsettled: Number
    travel: Number


class Tally(NamedTuple):
    """Running sums and marks of one response."""

    iae: Number
    ise: Number
    itae: Number
    variation: Number
    command: Number  # of the sample before [V]
    peak: Number  # highest normalised response so far
    below10: Number  # samples before the response first reached 10 %
    below90: Number
    outside: Number  # samples up to and with the last one outside the settling band
    error: Number  # of the last sample [deg]
    step: Any = ()  # a `Step`, where it is known only once the window begins
    stairs: Any = ()  # a `StairTally`, where stairs are judged one by one


class Yardstick(NamedTuple):
    """The judge: what a response is measured against, sample time [s] and half-width of the settling band, as
    a share of the step, first.

    One step whose start is known has a `Step`.  One that begins under way, with a `Window`, is judged from
    the angle where the joint then is.  Several stairs have `Stairs`: the settling band, and the overshoot
    beyond a reference in the direction of its change, are relative to the same step for all of them; the
    slowest to settle counts.
    """

    dt: Number
    band: Number
    step: Any = ()
    window: Any = ()
    stairs: Any = ()

    def begin(self, command: Number, angle: Number = 0.0) -> Tally:
        """Tally before the first sample; `command` [V] is what was held until then, the joint at an angle
        [deg]."""
        known = self.step or self.stairs
        return Tally(
            0.0, 0.0, 0.0, 0.0, command, 0.0, 0.0, 0.0, 0.0, 0.0,
            () if known else Step(angle, 0.0, 0.0), StairTally(0.0, 0.0, 0.0) if self.stairs else (),
        )  # fmt: skip

    def update(
        self, t: Tally, sample: Number, asked: Asked, before: State, after: State, command: Number
    ) -> Tally:
        """Tally with one more sample: its index, what is asked, the plant before and after it and the command
        [V] given for it."""
        if not self.window:
            return self._one_more(t, sample, asked, before, after, command)
        since = sample - self.window.begins
        new = self._one_more(t, since, asked, before, after, command)
        # Lanes are judged in windows of their own: before and after, the sums stand still.
        inside = np.where(since >= 0.0, np.where(since < self.window.lasts, 1.0, 0.0), 0.0) > 0.5
        leaves = zip(pytrees.leaves(new), pytrees.leaves(t), strict=True)
        kept: Tally = pytrees.like(t, [np.where(inside, a, b) for a, b in leaves])
        return kept._replace(command=command)

    def _one_more(
        self, t: Tally, since: Number, asked: Asked, before: State, after: State, command: Number
    ) -> Tally:
        """As `update`, `since` being the samples that were judged before."""
        angle = before.angle
        error = asked.reference - angle
        size = np.abs(error) * self.dt
        step, stairs = t.step, t.stairs
        if self.stairs:
            way = np.where(asked.reference > asked.before, 1.0, 0.0)
            way = np.where(asked.reference < asked.before, -1.0, way)
            response, distance = 1.0 - way * error * self.stairs.per_step, error * self.stairs.per_step
            since = since + self.window.begins - asked.begins
        else:
            if not self.step:
                fresh = since == 0.0
                new = Step(angle, *self._under_way(error, asked.reference - asked.before))
                step = Step(*(np.where(fresh, a, b) for a, b in zip(new, step, strict=True)))
            of = self.step or step
            response, distance = (angle - of.start) * of.per_step, error * of.per_step
            response = response if self.step else response * of.ahead
            if self.window and not isinstance(self.window.per_step, tuple):
                distance = error * self.window.per_step
        peak = np.maximum(t.peak, response)
        outside = t.outside
        if self.stairs:
            stairs = self._next_stair(t, since == 0.0, np.abs(after.pressure - before.pressure))
            outside = np.where(since == 0.0, 0.0, outside)
        outside = np.where(np.abs(distance) >= self.band, since + 1.0, outside)
        return Tally(
            t.iae + size,
            t.ise + size * np.abs(error),
            t.itae + size * (since * self.dt),
            t.variation + np.abs(command - t.command),
            command,
            peak,
            t.below10 + np.where(peak < 0.1, 1.0, 0.0),
            t.below90 + np.where(peak < 0.9, 1.0, 0.0),
            outside,
            error,
            step,
            stairs,
        )

    def _under_way(self, size: Number, change: Number) -> tuple[Number, Number]:
        """What a step under way is normalised by, the reference having changed, and whether it is ahead; one
        within the task's band is none, and told in shares of the task's, one of no size has no response.

        Overshoot is motion beyond the reference in the direction of its change.  A joint that has not yet
        reached the reference that it is sent back to moves the other way, so its response is 0.
        """
        ahead = np.where(size * change < 0.0, 0.0, 1.0)
        if isinstance(self.window.per_step, tuple):
            some = np.where(size == 0.0, 0.0, 1.0)
            return some / np.where(size == 0.0, 1.0, size), ahead
        least = np.abs(size) * self.window.per_step > self.band
        return np.where(least, 1.0 / np.where(least, size, 1.0), self.window.per_step), ahead

    def _next_stair(self, t: Tally, fresh: Number, travel: Number) -> StairTally:
        """The stairs' tally with one more sample, the first of a stair where `fresh`; travel: of the pressure
        in it [kPa]."""
        latest, unsettled = self._stairs_until(t)
        return StairTally(
            np.where(fresh, latest, t.stairs.latest),
            np.where(fresh, unsettled, t.stairs.unsettled),
            t.stairs.travel + travel,
        )

    def _stairs_until(self, t: Tally) -> tuple[Number, Number]:
        """Most samples until a stair was settled, and whether one was not, the one under way included."""
        far = np.where(np.abs(t.error * self.stairs.per_step) >= self.band, 1.0, 0.0)
        return np.maximum(t.stairs.latest, t.outside), np.maximum(t.stairs.unsettled, far)

    def finish(self, t: Tally, samples: Number) -> "Metrics":
        """Metrics of a response of a number of samples, of which its window, where there is one, counts."""
        t = pytrees.like(t, [np.asarray(x, float) for x in pytrees.leaves(t)])
        samples = self.window.lasts if self.window else samples
        outside, settles = t.outside, t.outside < samples
        rises = t.below90 < samples
        if self.step:
            settles = settles & (np.asarray(self.step.per_step) != 0.0)  # of no size: see `of_step`
        if self.stairs:
            outside, unsettled = self._stairs_until(t)
            settles = unsettled < 0.5
            rises = np.full_like(t.below90, False)  # no stair alone is normalised from where it begins
        return Metrics(
            rise_time_s=np.where(rises, (t.below90 - t.below10) * self.dt, np.inf),
            settling_time_s=np.where(settles, outside * self.dt, np.inf),
            overshoot_percent=np.maximum(t.peak - 1.0, 0.0) * 100.0,
            steady_state_error_deg=np.abs(t.error),
            iae_deg_s=t.iae,
            ise_deg2_s=t.ise,
            itae_deg_s2=t.itae,
            total_variation_V=t.variation,
        )


def _yardstick(rig: Rig | None, **parts: Any) -> Yardstick:
    """A judge with the sample time and the band of a rig, the built-in one where not given."""
    rig = rig or built_in_rig()
    return Yardstick(rig.sample_time, rig.task.band, **parts)


def of_step(start: Number, reference: Number, rig: Rig | None = None) -> Yardstick:
    """The judge of a step of a rig from `start` to `reference` [deg].

    A step that begins at its reference neither rises nor settles: a controller that has never left the
    start is given no credit for a return to it.
    """
    size = np.asarray(reference, float) - start
    per_step = np.divide(1.0, size, out=np.zeros_like(size), where=size != 0.0)[()]
    return _yardstick(rig, step=Step(start, per_step))


def of_step_under_way(
    begins: Number, lasts: Number, rig: Rig | None = None, task: Number | None = None
) -> Yardstick:
    """The judge of a step of a rig that begins at a sample, from where the joint then is, and lasts for so
    many; task [deg]: the step whose band it settles in, its own where not given."""
    return _yardstick(rig, window=Window(begins, lasts, () if task is None else 1.0 / task))


def of_stairs(step: float, begins: Number, lasts: Number, rig: Rig | None = None) -> Yardstick:
    """The judge of stairs of a rig from a sample on, for so many; relative to a step [deg]."""
    return _yardstick(rig, window=Window(begins, lasts), stairs=Stairs(1.0 / step))


@dataclass(frozen=True)
class Metrics:
    """Judgement of one response, or of many: every field a float or an array of lanes.

    rise_time_s (10 to 90 %, of one step) and settling_time_s (into the rig's band) are infinite where the
    response does not get there; overshoot_percent is relative to the step.
    """

    rise_time_s: Number
    settling_time_s: Number
    overshoot_percent: Number
    steady_state_error_deg: Number
    iae_deg_s: Number
    ise_deg2_s: Number
    itae_deg_s2: Number
    total_variation_V: Number

    @property
    def unsettled(self) -> Number:
        """Whether a response does not settle."""
        return np.isinf(self.settling_time_s)

    def __getitem__(self, lanes: Any) -> "Metrics":
        """The metrics of some lanes."""
        return Metrics(*(getattr(self, f.name)[lanes] for f in fields(self)))

    def reshape(self, *shape: int) -> "Metrics":
        """The same metrics, the lanes arranged in another shape."""
        return Metrics(*(np.reshape(getattr(self, f.name), shape) for f in fields(self)))


UNITS = {
    "rise_time_s": "s", "settling_time_s": "s", "overshoot_percent": "%", "steady_state_error_deg": "deg",
    "iae_deg_s": "deg s", "ise_deg2_s": "deg² s", "itae_deg_s2": "deg s²", "total_variation_V": "V",
}  # fmt: skip
"""Unit of each metric, for tables."""
