"""The wrist as python-control objects: the sampled system, and its linearisation on each branch.

A wrist with effects is no small rational system any more, but has a frequency
response all the same: `responses` multiplies it together from its parts.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise, product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plants import lag
from plants.actuator import regulator
from plants.actuator.regulator import Regulator
from plants.dynamics import step
from plants.effects.effect import Linear
from plants.equilibrium import angles_at, driving_pressure
from plants.hysteresis import Side
from plants.kernel import pytrees as tree
from plants.kernel.graphs import jacobians

if TYPE_CHECKING:
    from plants.wrist import Wrist

RATES = ("slow", "fast")
"""The two ends of the regulator's rate: near to and far from the commanded pressure."""

GRID = 201
"""Pressures over the range of the command among which those of the task are found."""

PIECES = 24
"""Pieces of a range of pressures in which slopes are looked at."""


def nlsys(wrist: "Wrist") -> Any:
    """The sampled wrist as a discrete ``control.nlsys``: command [V] to pressure [kPa] and angle [deg].

    States are pressure, static angle and the rest of the memory, and angle, at 1 ms; they start at 0
    in python-control unless told otherwise, so pass ``wrist_x0(wrist)``.

    >>> import control, numpy as np
    >>> from plants import Wrist
    >>> w, t = Wrist.flexion(), np.arange(1001) * 1e-3
    >>> r = control.input_output_response(nlsys(w), t, np.full(1001, 3.0), wrist_x0(w))
    >>> bool(abs(r.outputs[1, -1] - w.simulate([3.0] * 1000).angle[-1]) < 1e-12)
    True

    Raises ValueError for a wrist with effects, whose delay lines python-control cannot hold.
    """
    import control

    if wrist.effects:
        raise ValueError(f"{_named(wrist)}: no control.nlsys of it is to be had; use Wrist.simulate")
    c, rest = wrist.sampled(), wrist.rest()
    names = {
        "pressure": "pressure_kPa",
        "memory.h": "static_angle_deg",
        "memory.virgin": "virgin",
        "angle": "angle_deg",
    }

    def update(_t: float, x: Any, u: Any, _params: Any) -> Any:
        return np.array(tree.leaves(step(tree.like(rest, list(x)), u[0], c)), float)

    def output(_t: float, x: Any, _u: Any, _params: Any) -> Any:
        return np.array([x[0], x[-1]])

    return control.nlsys(
        update, output, dt=wrist.rig.sample_time, name="wrist", inputs=["command_V"],
        states=[names.get(n, n) for n in tree.names(rest)],
        outputs=["pressure_kPa", "angle_deg"],
    )  # fmt: skip


def wrist_x0(wrist: "Wrist") -> Any:
    """Initial state of `nlsys` for a wrist at rest, shape (states,); (4,) for four segments."""
    return np.array(tree.leaves(wrist.rest()), float)


def task_pressures(wrist: "Wrist") -> tuple[float, float]:
    """Pressures [kPa] between which a wrist rests while it does its rig's task: steps either way from zero,
    with the overshoot that the rig allows and a load on top, on either outer branch; to the next of
    `GRID` pressures outside, within the range of the command.

    >>> from plants import Wrist
    >>> [round(p, 1) for p in task_pressures(Wrist.flexion())]
    [36.6, 164.0]
    """
    rig, pressures = wrist.rig, np.linspace(*wrist.reach, GRID)
    most = rig.task.step * (1.0 + 0.01 * rig.limits.get("overshoot_percent", 0.0)) + rig.uncertainty.load
    least_above = np.flatnonzero(angles_at(wrist, "line2", pressures)[1] > -most)
    most_below = np.flatnonzero(angles_at(wrist, "line1", pressures)[1] < most)
    if not least_above.size or not most_below.size:
        return float(pressures[0]), float(pressures[-1])
    return float(pressures[max(least_above[0] - 1, 0)]), float(pressures[min(most_below[-1] + 1, GRID - 1)])


def branch_slope(wrist: "Wrist", branch: str) -> float:
    """Slope [deg/kPa] of a branch of the wrist's hysteresis law, such as ``transit``, ``line1`` or ``line2``.

    Raises ValueError for another name.
    """
    slopes = branch_slopes(wrist)
    if branch not in slopes:
        raise ValueError(f"unknown branch {branch!r}; one of {', '.join(slopes)}")
    return slopes[branch]


def branch_slopes(
    wrist: "Wrist",
    pressures: tuple[float, float] | None = None,
    within: tuple[float, float] | None = None,
) -> dict[str, float]:
    """Slopes [deg/kPa] of the branches on which the closed loop can work between two pressures [kPa], those
    of the rig's task (`task_pressures`), which it never leaves, where not given; within: pressures [kPa] that
    it never leaves, any where not given.

    What is proved of every motion asks for all pressures that the command can give, `Wrist.reach`.

    >>> from plants import Wrist
    >>> branch_slopes(Wrist.flexion())
    {'transit': 0.0803, 'line1': 0.36, 'line2': 0.36}
    """
    if pressures is None:
        pressures = within = task_pressures(wrist)
    return {name: float(slope) for name, slope in wrist.hysteresis.branches(*pressures, within).items()}


def branch_ss(wrist: "Wrist", branch: str, rate: str = "fast") -> Any:
    """Linearisation on one branch at one regulator rate, a discrete ``control.ss`` at 1 ms.

    Deviations from an equilibrium; input command [V], states pressure [kPa] and
    angle [deg], output angle.  While a branch is not left, the static angle is
    the pressure times the branch's slope, so it is no state of its own.  The two
    rates are the ends of k(e); the slope of k(e) e itself passes its fast end by up
    to an eighth of k_fast - k_slow (at e = sqrt(3) e0), which no branch here shows.
    `rate` is ``fast`` or ``slow``.  Raises ValueError for another name, and for a
    wrist with effects, of which there are only `responses`.

    >>> from plants import Wrist
    >>> w = Wrist.flexion()
    >>> bool(abs(branch_ss(w, "line1").dcgain() - 49.4 * 0.36) < 1e-9)
    True
    """
    import control

    a, b = branch_matrices(wrist, branch, rate)
    return control.ss(
        a, b, [[0.0, 1.0]], [[0.0]], wrist.rig.sample_time, name=f"{branch}_{rate}",
        inputs=["command_V"], states=["pressure_kPa", "angle_deg"], outputs=["angle_deg"],
    )  # fmt: skip


def branch_matrices(wrist: "Wrist", branch: str, rate: str = "fast") -> tuple[Any, Any]:
    """State matrices (2, 2) and (2, 1) of `branch_ss`, which raises as this does; python-control is not
    loaded for them, which takes longer than a tuning."""
    if wrist.effects:
        raise ValueError(
            f"{_named(wrist)}: no control.ss of it is to be had; use plants.linearisation.responses"
        )
    slope = branch_slope(wrist, branch)
    if rate not in RATES:
        raise ValueError(f"unknown regulator rate {rate!r}; one of {', '.join(RATES)}")
    p = wrist.regulator
    k = p.k_fast if rate == "fast" else p.k_slow
    air = regulator.sampled(Regulator(p.gain, k, k, p.e0), wrist.rig.sample_time)
    transient = lag.sampled(wrist.Tw, wrist.rig.sample_time)

    def linear(state: Any, command: Any) -> Any:
        pressure, angle = state
        after = regulator.step(pressure, command, air)
        return after, lag.step(angle, slope * pressure, slope * after, transient)

    a, b = jacobians(linear, (0.0, 0.0), 0.0)
    return np.asarray(a, float), np.asarray(b, float).reshape(2, 1)


def frequency_response(
    a: Any, b: Any, c: Any, d: Any, omega: NDArray[np.float64], dt: float
) -> NDArray[np.complex128]:
    """What ``control.frequency_response`` says of a sampled system with one input, of its state matrices,
    at omega [rad/s], (outputs, omega); python-control without slycot solves for one frequency at a time.

    >>> import control
    >>> from plants import Wrist
    >>> system, omega = branch_ss(Wrist.flexion(), "line1"), np.geomspace(0.1, 3000.0, 50)
    >>> theirs = control.frequency_response(system, omega).complex
    >>> ours = frequency_response(*control.ssdata(system), omega, system.dt)[0]
    >>> bool(np.allclose(ours, theirs, rtol=1e-12, atol=0.0))
    True
    """
    z = np.exp(1j * omega * dt)
    states = np.linalg.solve(z[:, None, None] * np.eye(len(a)) - a, np.broadcast_to(b, (z.size, *b.shape)))
    return np.asarray((c @ states + d)[:, :, 0].T, complex)


@dataclass(frozen=True)
class FrequencyResponse:
    """Frequency responses of the angle [deg/V] and of the pressure [kPa/V] on one branch at one regulator
    rate, shape of omega, with their names; a branch that bends has its least and its largest slope, a rate
    its factors."""

    branch: str
    rate: str
    response: NDArray[np.complex128]
    pressure: NDArray[np.complex128]


def responses(wrist: "Wrist", omega: Any) -> list[FrequencyResponse]:
    """Frequency responses of a wrist with effects at omega [rad/s], on every branch at every rate.

    To the command [V], of small motions about an equilibrium: what comes from
    outside the wrist (load, sinusoid, drift, the other motion) takes no part, nor what
    only acts beyond a threshold (dead band, end stop, supply) or on large motions
    (the loop's widening with the rate, drag); all else is what `Effect.linear`
    says.  Curved branches come with the least and the largest slope at the pressures
    of the rig's task (`task_pressures`), soft ones fresh and fully worked, the
    regulator with the rates of filling and exhausting at both ends of these.  Of several
    effects the extremes at about the same pressure are taken together, so that the list
    holds more than what can occur at once.
    """
    z = np.exp(1j * np.asarray(omega, float) * wrist.rig.sample_time)
    p = wrist.regulator
    pressures = task_pressures(wrist)
    parts = _parts(wrist, z, pressures)
    c = lag.sampled(wrist.Tw, wrist.rig.sample_time)
    joint = next((x.joint for x in parts if x.joint is not None), (c.before + c.after * z) / (z - c.keep))
    before, after = np.full(z.shape, p.gain, complex), joint
    for part in parts:
        before, after = before * part.command, after * part.static
    speeds = _products([x.rates for x in parts])
    flows = [(f"{rate:.3g}/s", rate) for x in parts for rate in x.flows]
    rates = flows or list(zip(RATES, (p.k_slow, p.k_fast), strict=True))
    straight, unit = branch_slopes(wrist, pressures), wrist.rig.unit("deg/kPa")
    found = []
    for branch, slopes in slopes_with_effects(wrist, pressures, left=False).items():
        for slope, (rate, own), speed in product(slopes, rates, speeds):
            share = -np.expm1(-speed * own * wrist.rig.sample_time)
            pressure = before * (share / (z - 1.0 + share))
            bent = "" if slopes == (straight.get(branch),) else f", slope {slope:.3g} {unit}"
            quick = rate if speed == 1.0 else f"{rate} x {speed:.3g}"
            found.append(FrequencyResponse(branch + bent, quick, pressure * after * slope, pressure))
    return found


def _parts(wrist: "Wrist", z: Any, pressures: tuple[float, float]) -> list[Linear]:
    """What is linear of each effect between two pressures [kPa]."""
    return [e.linear(wrist, z, wrist.rig.sample_time, pressures) for e in wrist.effects]


def slopes_with_effects(
    wrist: "Wrist", pressures: tuple[float, float], left: bool = True
) -> dict[str, tuple[float, ...]]:
    """Least and largest slope [deg/kPa] of each branch between two pressures [kPa], with what effects do to
    it; one where they are the same.  Ends of one branch, named after a comma (outer branch, flattest), are
    one branch here.  left: whether motions may come there from pressures outside.

    Where a curve of the law is steep an effect may make it flat again: only what meets at one pressure is
    multiplied, so that the range is looked at in pieces.
    """
    found: dict[str, list[float]] = {}
    edges, still = np.linspace(*pressures, PIECES + 1), np.ones(1)
    driving = np.broadcast_to(driving_pressure(wrist, edges), edges.shape)
    within = None if left else (float(driving.min()), float(driving.max()))
    for piece, driven in zip(pairwise(edges.tolist()), pairwise(driving.tolist()), strict=True):
        parts = _parts(wrist, still, piece)
        for branch, straight in branch_slopes(wrist, (min(driven), max(driven)), within).items():
            sides = wrist.hysteresis.sides(branch)
            bent = [straight * x for x in _products([slope_factors(x.slopes, sides) for x in parts])]
            added = [[x.added[side] for x in parts if side in x.added] for side in sides]
            least = min(sum(low for low, _ in ends) for ends in added)
            most = max(sum(high for _, high in ends) for ends in added)
            found.setdefault(branch.partition(",")[0], []).extend((min(bent) + least, max(bent) + most))
    return {branch: tuple(sorted({float(min(s)), float(max(s))})) for branch, s in found.items()}


def slope_factors(slopes: Mapping[Side, tuple[float, float]], sides: tuple[Side, ...]) -> tuple[float, ...]:
    """Least and largest factor of the slope that an effect has on some sides of the loop."""
    found = [factor for side in sides for factor in slopes.get(side, (1.0,))]
    return tuple(sorted({min(found), max(found)}))


def _products(factors: list[tuple[float, ...]]) -> list[float]:
    """Every product of one factor of each kind, without repetition."""
    return list(dict.fromkeys(float(np.prod(chosen)) for chosen in product(*factors)))


def _named(wrist: "Wrist") -> str:
    return f"a wrist with {', '.join(e.NAME for e in wrist.effects)}"
