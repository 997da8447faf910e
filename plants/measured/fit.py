"""Fitting the declared wrist to a campaign: regulator on the pressure, then the wrist on the angle.

Where the pressure was not logged both stages are fitted together on the angle.
Residuals are free-run simulations from the command, so that the error counted
is the one that a user of the model will see.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError
from plants.hysteresis import Memory
from plants.measured.campaign import Campaign
from plants.measured.estimate import Estimate, estimate
from plants.measured.noise import noise_of
from plants.measured.playback import Playback
from plants.measured.recording import Recording
from plants.quantities import REGULATOR_NAMES, WRIST_NAMES, ParameterSet, loop_problem
from plants.simulate import default_jobs
from plants.wrist import State, Wrist

Array = NDArray[np.float64]
Errors = dict[str, float | None]
Role = Literal["fit", "validate"]
CHANNELS = ("pressure_kPa", "angle_deg")


@dataclass(frozen=True)
class Run:
    """A recording beside its simulations with the fitted and the starting set, shape (n,)
    each; angles are None for a campaign of the regulator alone."""

    recording: Recording
    role: Role
    pressure: Array
    angle: Array | None
    pressure_before: Array
    angle_before: Array | None


@dataclass(frozen=True)
class Fit:
    """A wrist fitted to a campaign.

    before, fitted: the starting and the fitted parameter set.  noise: floor of
    each channel, from the data.  fit_rmse, validate_rmse, validate_rmse_before:
    errors of free runs by channel, None where a channel was not logged.
    stages: how each estimate went.  at_bounds: parameters that ran into a bound.
    """

    campaign: Campaign
    before: ParameterSet
    fitted: ParameterSet
    noise: Errors
    fit_rmse: Errors
    validate_rmse: Errors
    validate_rmse_before: Errors
    runs: tuple[Run, ...]
    stages: dict[str, Estimate]
    at_bounds: tuple[str, ...]


def fit_campaign(
    campaign: Campaign,
    start: ParameterSet,
    starts: int = 6,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Fit:
    """Fit the declared wrist to the recordings of a campaign that may be fitted on.

    `start` gives the starting values, bounds and what is not fitted; `starts` is
    the number of starting points of each stage, the first being `start`, the
    others drawn around it with `seed`.  Raises InputError where the recordings
    hold no motion to fit on.
    """
    tell = progress or (lambda stage, share: None)
    noise: Errors = {}
    for channel in CHANNELS:
        logged = [v for r in (*campaign.fit, *campaign.validate) if (v := measured(r, channel)) is not None]
        noise[channel] = noise_of(logged)
    # A wrist that does not start at rest moves without a command that does.
    if campaign.start == "rest" and all(np.ptp(r.command) == 0.0 for r in campaign.fit):
        raise InputError(
            f"{campaign.name}: the command never moves in the recordings to fit on; add one that moves"
        )

    has_pressure = all(r.pressure is not None for r in campaign.fit)
    plan: list[tuple[str, tuple[str, ...], tuple[str, ...]]] = []
    if has_pressure:
        plan.append(("regulator", REGULATOR_NAMES, ("pressure_kPa",)))
    if campaign.stage == "wrist":
        names: tuple[str, ...] = WRIST_NAMES if has_pressure else REGULATOR_NAMES + WRIST_NAMES
        plan.append(("wrist", names, ("angle_deg",)))

    values: dict[str, float] = dict(start.values)
    errors: Errors = {}
    stages: dict[str, Estimate] = {}
    begins: list[State] | None = None
    for number, (stage, names, channels) in enumerate(plan):
        tell(stage, number / len(plan))
        problem = _Problem(campaign.fit, values, names, channels, noise, campaign.start == "unknown", begins)
        found = estimate(problem, _bounds(problem, start), starts, seed)
        stages[stage] = found
        values |= {n: float(found.x[i]) for i, n in enumerate(names)}
        errors |= {n: found.std_errors[i] for i, n in enumerate(names)}
        begins = problem.states(found.x[None, :])
    tell("done", 1.0)
    trouble = loop_problem(values, 0.0, 4.0 * values["gain"]) if campaign.stage == "wrist" else None
    if trouble:
        raise InputError(
            f"{campaign.name}: the best fit makes no loop ({trouble}); the data may not be a wrist's"
        )

    origin = f"{campaign.name} (sha256 {campaign.checksum[:12]})"
    fitted = replace(start, axis=campaign.axis).fitted({n: values[n] for n in errors}, errors, origin)
    runs = tuple(_runs(campaign, start, fitted))
    bounds = {n: (p.low, p.high) for n, p in start.parameters.items()}
    edges = tuple(n for n in errors if min(abs(values[n] - b) for b in bounds[n]) < 1e-3 * np.ptp(bounds[n]))
    return Fit(
        campaign, start, fitted, noise,
        rmse(runs, "fit"), rmse(runs, "validate"), rmse(runs, "validate", before=True), runs, stages, edges,
    )  # fmt: skip


def measured(recording: Recording, channel: str) -> Array | None:
    """A measured channel of a recording by its column name, None where it was not logged."""
    return recording.pressure if channel == "pressure_kPa" else recording.angle


class _Problem:
    """Standardised residuals of lanes of parameter vectors, over recordings.

    A vector holds the named parameters and, where the start of the recordings
    is unknown, a starting pressure and angle for each of them.
    """

    def __init__(
        self,
        recordings: Sequence[Recording],
        values: dict[str, float],
        names: tuple[str, ...],
        channels: tuple[str, ...],
        noise: Errors,
        unknown_start: bool,
        begins: list[State] | None = None,
    ) -> None:
        self.names, self.channels, self.unknown_start = names, channels, unknown_start
        self.values, self.begins = values, begins
        self.playbacks = [Playback(r) for r in recordings]
        self.scale = {c: noise[c] or 1.0 for c in channels}
        self.blocks = np.concatenate([self._blocks(p.recording) for p in self.playbacks])
        _, self.blocks = np.unique(self.blocks, return_inverse=True)

    def _blocks(self, recording: Recording, seconds: float = 2.0) -> Array:
        """Number of the block of time that each residual of a recording falls in."""
        index = next(i for i, p in enumerate(self.playbacks) if p.recording is recording)
        block = index * 1e6 + np.floor((recording.time - recording.time[0]) / seconds)
        return np.tile(block, len(self.channels))

    def wrist(self, x: Array) -> Wrist:
        """Wrists of vectors (lanes, n)."""
        lanes = {n: np.full(len(x), v) for n, v in self.values.items()}
        return Wrist.from_values({**lanes, **{n: x[:, i] for i, n in enumerate(self.names)}})

    def states(self, x: Array) -> list[State]:
        """Starting state of each recording for vectors (lanes, n)."""
        wrist, found = self.wrist(x), []
        for i in range(len(self.playbacks)):
            if not self.unknown_start:
                found.append(wrist.rest())
                continue
            pressure, angle = (x[:, len(self.names) + 2 * i + j] for j in (0, 1))
            if self.begins is not None and "pressure_kPa" not in self.channels:
                pressure = np.full(len(x), self.begins[i].pressure)  # known from the stage before
            found.append(State(pressure, Memory(angle, np.zeros(len(x))), angle))
        return found

    def residuals(self, x: Array) -> Array:
        """Simulated minus measured, in units of the noise, shape (rows, lanes) for vectors (lanes, n)."""
        wrist, states = self.wrist(x), self.states(x)

        def one(i: int) -> list[Array]:
            playback, parts = self.playbacks[i], []
            pressure, angle = playback.play(wrist, states[i])
            for channel in self.channels:
                truth = measured(playback.recording, channel)
                assert truth is not None
                simulated = pressure if channel == "pressure_kPa" else angle
                parts.append((simulated - truth[:, None]) / self.scale[channel])
            return parts

        with ThreadPoolExecutor(default_jobs()) as pool:
            return np.concatenate(
                [part for parts in pool.map(one, range(len(self.playbacks))) for part in parts]
            )


def _bounds(problem: _Problem, start: ParameterSet) -> Array:
    """Start, lower and upper bound of each entry of the problem's vector, shape (3, n)."""
    rows = [(problem.values[n], start.parameters[n].low, start.parameters[n].high) for n in problem.names]
    if problem.unknown_start:
        for playback in problem.playbacks:
            r = playback.recording
            for truth, rest in ((r.pressure, problem.values["rest_pressure"]), (r.angle, 0.0)):
                first = rest if truth is None else float(np.median(truth[:3]))
                reach = 20.0 if truth is None else 3.0 * float(np.ptp(truth[:20])) + 1.0
                rows.append((first, first - reach, first + reach))
    return np.array(rows, float).T


def _runs(campaign: Campaign, start: ParameterSet, fitted: ParameterSet) -> list[Run]:
    """Every recording beside its simulations; unknown starts are taken from its first rows."""
    found = []
    roles: tuple[tuple[Role, tuple[Recording, ...]], ...] = (
        ("fit", campaign.fit),
        ("validate", campaign.validate),
    )
    for role, recordings in roles:
        for recording in recordings:
            sides = []
            for parameters in (fitted, start):
                wrist = Wrist.from_values(parameters.values)
                state = first_state(recording, wrist) if campaign.start == "unknown" else None
                sides.append(Playback(recording).play(wrist, state))
            angles = [None, None] if campaign.stage == "regulator" else [angle for _, angle in sides]
            found.append(Run(recording, role, sides[0][0], angles[0], sides[1][0], angles[1]))
    return found


def first_state(recording: Recording, wrist: Wrist) -> State:
    """The state that the first rows of a recording show: its pressure, and an angle at rest.

    Where a channel was not logged the wrist's own rest stands in for it.
    """
    rest = wrist.rest()
    pressure = rest.pressure if recording.pressure is None else float(np.median(recording.pressure[:3]))
    angle = 0.0 if recording.angle is None else float(np.median(recording.angle[:3]))
    return State(pressure, Memory(angle, 0.0), angle)


def rmse(runs: Sequence[Run], role: str, before: bool = False) -> Errors:
    """Root mean square error of the runs of a role, by channel; None where it was not logged."""
    found: Errors = {}
    for channel in CHANNELS:
        name = ("pressure" if channel == "pressure_kPa" else "angle") + ("_before" if before else "")
        pairs = [(getattr(r, name), measured(r.recording, channel)) for r in runs if r.role == role]
        squares = [(a - b) ** 2 for a, b in pairs if a is not None and b is not None]
        found[channel] = float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else None
    return found
