"""What gains do on a rig of the tests: the task's steps from rest both ways and back."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from plants.parameters.quantities import ParameterSet
from tests.rig.core import TICK, Controller
from tests.rig.rig import LoopResult, Noise, Rig, judged

SENSORS_OWN = (
    "gyro-drift", "eccentric-sensor", "sensor-backlash", "valve-current", "wander",
)  # fmt: skip
"""Effects of the sensor: its reading differs from the angle, and any controller believes the reading."""

LATE = 0.05
"""Dead time [s] that the requirement adds to a plant that has none of its own."""


@dataclass(frozen=True)
class Held:
    """The worst of all steps on the rig as it is, and with the added dead time: overshoot as a share of the
    step, settling [s], and whether any oscillates; limit: overshoot that is allowed."""

    as_it_is: tuple[float, float, bool]
    late: tuple[float, float, bool]
    limit: float

    @property
    def kept_as_it_is(self) -> bool:
        """Whether the limit holds and every step settles, on the rig as it is."""
        return self._kept(self.as_it_is)

    @property
    def kept(self) -> bool:
        """Whether the limit holds and every step settles, late or not."""
        return self._kept(self.as_it_is) and self._kept(self.late)

    def _kept(self, seen: tuple[float, float, bool]) -> bool:
        overshoot, settling, oscillates = seen
        return overshoot <= self.limit and np.isfinite(settling) and not oscillates

    def __str__(self) -> str:
        words = []
        for name, (overshoot, settling, oscillates) in (("as it is", self.as_it_is), ("late", self.late)):
            swings = ", oscillates" if oscillates else ""
            words.append(f"{name} {100 * overshoot:.1f} %, {settling:.2f} s{swings}")
        return ("holds: " if self.kept else "BROKEN: ") + "; ".join(words)


def held(rig: Rig, gains: Mapping[str, float], plant: ParameterSet) -> Held:
    """Close the loop on a rig with gains of a PI or a PI with two degrees of freedom; task, limits and the
    range of the command are of the plant's rig."""
    stated = plant.rig
    v = plant.values
    controller = Controller(
        gains["Kp"], gains["Ki"], v["gain"], v["rest_pressure"], *stated.command_range,
        gains.get("b", 1.0), gains.get("Tf", 0.0),
    )  # fmt: skip
    # A load that was picked up in the recordings is an event of theirs, and no case of the requirement.
    free = replace(rig, hidden=rig.hidden._replace(load=type(rig.hidden.load)()))
    own = free.hidden.dead_time
    later = own if "dead-time" in rig.effects else own._replace(form=1, transport_s=LATE)
    slower = replace(free, hidden=free.hidden._replace(dead_time=later))
    return Held(
        _worst(free, controller, stated.task.step, stated.task.duration),
        _worst(slower, controller, stated.task.step, stated.task.duration),
        stated.limits["overshoot_percent"] / 100.0,
    )


def _worst(rig: Rig, controller: Controller, step: float, duration: float) -> tuple[float, float, bool]:
    seen = list(_steps(rig, controller, step, duration))
    return (
        max(r.overshoot for r in seen),
        max(r.settling for r in seen),
        any(r.oscillates for r in seen),
    )


def _steps(rig: Rig, controller: Controller, step: float, duration: float) -> Iterator[LoopResult]:
    """A step out and back either way.  Where the sensor errs by itself the reading without noise is judged,
    elsewhere the true angle, with the noise in the loop."""
    samples = round(duration / TICK)
    errs = any(e in SENSORS_OWN for e in rig.effects)
    of = replace(rig, noise=Noise(0.0, 0.0)) if errs else rig
    for salt, sign in enumerate((1.0, -1.0)):
        asked = np.repeat([sign * step, 0.0], samples)
        run = of.follow(asked, controller, 99 + salt)
        seen = run.measured if errs else run.angle
        out = run._replace(**{n: x[:samples] for n, x in run._asdict().items()})
        yield judged(out._replace(angle=seen[:samples]), sign * step)
        # The way back is a step by -step from where the wrist was asked to be.
        back = run._replace(**{n: x[samples:] for n, x in run._asdict().items()})
        yield judged(
            back._replace(angle=seen[samples:] - sign * step, time=back.time - duration), -sign * step
        )
