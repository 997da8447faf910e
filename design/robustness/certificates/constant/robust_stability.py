"""Robust stability against constant parameters on one branch, by the structured singular value.

The centre of the box is stable; at no frequency and for no parameters of the box, grown about its centre
by 1/mu, has the loop a root on the imaginary axis; so all of it is stable.  Proved for the loop in
continuous time, on one branch at one rate for good, parameters constant: see `uncertain_loop`.  Stability
at one dead time is stability at every smaller one, since the loop has one gain crossing
(`uncertain_search`).
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from enum import Enum
from itertools import product
from typing import Any

import numpy as np

from design.controllers.pi import PI
from design.robustness.box import Box
from design.robustness.certificates.constant.mu_sweep import STEP, Cover, Incomplete, cover
from design.robustness.certificates.constant.uncertain_loop import (
    NAMES,
    REACH,
    UncertainLoop,
    pade_error,
    pade_response,
    systems,
)
from design.robustness.certificates.constant.uncertain_search import (
    Destabilising,
    dynamics,
    slack,
    smallest,
)
from design.robustness.loop_model import LoopModel
from design.robustness.statement import Claim, Reason, Statement
from design.status import Status, of_proof
from plants.errors import InputError
from plants.linearisation import RATES, branch_slopes

MOST_LMIS = 300
"""Linear matrix inequalities that one cover may take; where they do not do, it is a prediction."""

POINTS = 2000
"""Random members of the certified set whose stability is looked at one by one."""


class Refuted(Enum):
    """What the check outside the theory says against a certificate."""

    UNSTABLE_MEMBER = "an unstable loop was found within the set"
    POOR_APPROXIMANT = "the approximant of the dead time is worse than its bound"


class Centre(Enum):
    """Where nothing else matters."""

    UNSTABLE = "unstable at the centre of the box"
    DYNAMICS = "the residual, as unmodelled dynamics, can make the centre of the box unstable"


@dataclass(frozen=True)
class StableWhileConstant(Claim):
    """Stable for every constant slope, rate and Tw (and gain, where that is uncertain) within the box, with
    up to a dead time [s]; dynamics: and with unmodelled dynamics of the residual's weight."""

    gain: bool
    dead_time: float
    dynamics: bool = False


@dataclass(frozen=True)
class RobustStability:
    """What is known of one branch at one rate.

    upper: mu at no frequency is more than this, proved where `certified`, else only at the frequencies
    looked at; inf where the centre is unstable.  lower: 1/growth of the smallest grown box in which an
    unstable loop was found, whose parameters are `destabilising`.  names, centre, radius: of the box in
    slope [deg/kPa], rate [1/s], lag = 1/Tw [1/s], gain [1]; dead_time [s]: of the loop in all.  worst
    [rad/s]: the frequency that decided; intervals: that cover all frequencies; margin: least share by
    which the inequalities held where they were looked at again; solver: of the inequalities; reason: why
    not certified, or why nothing else matters; left_out: effects of the plant that the loop knows nothing of.
    """

    branch: str
    rate: str
    dead_time: float
    loop: UncertainLoop
    upper: float
    lower: float
    certified: bool
    worst: float
    intervals: int
    margin: float
    solver: str
    destabilising: Destabilising | None
    reason: Incomplete | Refuted | Centre | None = None
    left_out: tuple[str, ...] = field(default=())

    @property
    def growth(self) -> float:
        """Factor by which the box may grow about its centre; below 1 it must shrink."""
        return np.inf if self.upper == 0.0 else 1.0 / self.upper

    @property
    def holds(self) -> bool | None:
        """Whether the box is stable; None where neither a proof nor a counterexample was found."""
        return True if self.upper <= 1.0 else False if self.lower >= 1.0 else None

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Bounds of the uncertain parameters, grown by `growth`."""
        size = self.growth if np.isfinite(self.growth) else 1.0
        ends = zip(NAMES, self.loop.centre, self.loop.radius, strict=True)
        return {n: (c - size * r, c + size * r) for n, c, r in ends if r > 0.0}


@dataclass(frozen=True)
class MuBounds(Reason):
    """The bounds of mu of a branch at a rate."""

    row: RobustStability


def robust_stability(
    box: Box, controller: PI, branch: str, rate: str, dead_time: float = 0.0, step: float = STEP
) -> RobustStability:
    """Bounds of mu for the box's slope, rate, Tw and gain on a branch at a rate of the regulator.

    dead_time [s]: beside the plant's own (of which the box's largest is taken); step: share by which
    `upper` is above the bound that the worst frequency has.  Raises InputError for a branch or a rate
    that there is not, a negative dead time, and where the loop at the centre of the box is unstable
    without that dead time.

    >>> from plants.parameters.files import built_in
    >>> from design.robustness.box import box_of
    >>> row = robust_stability(box_of(built_in("flexion")), PI(3.13, 10.4), "line1", "slow")
    >>> row.certified, row.holds, bool(3.5 < row.growth < 1 / row.lower < 3.6)
    (True, True, True)
    """
    branches = tuple(branch_slopes(box.wrist, box.wrist.reach))
    if branch not in branches or rate not in RATES:
        raise InputError(
            f"robustness: no branch {branch!r} at rate {rate!r}; {branches} at {RATES} there are"
        )
    if not 0.0 <= dead_time < np.inf:
        raise InputError(f"robustness: a dead time of {dead_time:g} s; give one of 0 or more")
    own = sum(box.bounds(f"{e.NAME}.{e.DELAY}")[1] for e in box.plant.effects if e.DELAY)
    left_out = LoopModel.of(box.wrist, controller).left_out
    loop = UncertainLoop.of(box, controller, branch, rate, own + dead_time)
    centre = np.array(loop.centre)
    if slack(UncertainLoop.of(box, controller, branch, rate, own), centre) <= 0.0:
        raise InputError(
            f"robustness: {branch}, {rate} regulator rate: the loop is unstable at the centre of the box with"
            f" Kp = {loop.Kp:g} kPa/deg, Ki = {loop.Ki:g} kPa/(deg s); give gains that are stable there"
        )
    lost = Centre.UNSTABLE if slack(loop, centre) <= 0.0 else None
    if lost is None and dynamics(loop, centre)[0] <= 1.0:
        lost = Centre.DYNAMICS
    if lost is not None:
        return RobustStability(
            branch, rate, loop.dead_time, loop, np.inf, np.inf, True, np.nan, 0, np.nan, "", None,
            lost, left_out,
        )  # fmt: skip
    if not loop.uncertain.any() and loop.weight is None:
        return RobustStability(
            branch, rate, loop.dead_time, loop, 0.0, 0.0, True, np.nan, 0, np.nan, "", None, None, left_out
        )
    worst = smallest(loop) if loop.uncertain.any() else None
    beta = 0.0 if worst is None else (1.0 + step) / worst.growth
    peak, covers = np.nan if worst is None else abs(worst.root.imag), list[Cover]()
    for system in systems(loop):
        if not np.isfinite(beta):
            break
        covers.append(cover(system, beta, MOST_LMIS, step))
        beta, peak = covers[-1].beta, peak if covers[-1].peak is None else covers[-1].peak
    reason = next((c.reason for c in covers if not c.complete), None) or _refuted(loop, beta)
    worst = worst if worst is not None and worst.confirmed else None
    lower = 0.0 if worst is None else 1.0 / worst.growth
    solvers = dict.fromkeys(p.scalings.solver for c in covers for p in c.pieces)
    return RobustStability(
        branch, rate, loop.dead_time, loop, beta, lower, reason is None, float(peak),
        sum(len(c.pieces) for c in covers), min(c.margin for c in covers), " and ".join(solvers),
        worst, reason, left_out,
    )  # fmt: skip


def _refuted(loop: UncertainLoop, beta: float) -> Refuted | None:
    """What the check outside the theory says against a certificate, None where nothing: members of the
    certified set, corners among them, are stable one by one; the approximant of the dead time is as good
    as its bound."""
    rng = np.random.default_rng(0)
    corners = np.array(list(product((-1.0, 1.0), repeat=4)))
    delta = np.vstack([corners, rng.uniform(-1.0, 1.0, (POINTS, 4))])
    members = loop.at(delta / beta if beta > 0.0 else 0.0 * delta)
    if np.any(slack(loop, members) <= 0.0) or np.any(dynamics(loop, members)[0] <= 1.0):
        return Refuted.UNSTABLE_MEMBER
    if loop.dead_time == 0.0:
        rightmost = float(np.max(np.linalg.eigvals(loop.matrix(members)).real))
        return None if rightmost < 0.0 else Refuted.UNSTABLE_MEMBER
    x = REACH * rng.random(POINTS)
    error = np.abs(pade_response(loop.dead_time, x / loop.dead_time) - np.exp(-1j * x))
    return None if np.max(error) <= pade_error(REACH) else Refuted.POOR_APPROXIMANT


def robust_stability_everywhere(
    box: Box, controller: PI, dead_time: float = 0.0, step: float = STEP
) -> list[RobustStability]:
    """`robust_stability` on every branch at both rates of the regulator, with a dead time [s].

    Branches whose parameters are the same share one computation.  Raises InputError as that does.
    """
    found: list[RobustStability] = []
    for branch, rate in product(branch_slopes(box.wrist, box.wrist.reach), RATES):
        own = UncertainLoop.of(box, controller, branch, rate)
        same = next((r for r in found if _same(r.loop, own)), None)
        if same is None:
            found.append(robust_stability(box, controller, branch, rate, dead_time, step))
        else:
            found.append(RobustStability(**{**vars(same), "branch": branch, "rate": rate}))
    return found


def _same(one: UncertainLoop, other: UncertainLoop) -> bool:
    return one.centre == other.centre and one.radius == other.radius


def statements(rows: Iterable[RobustStability]) -> list[Statement]:
    """The rows as statements: proved or disproved where every frequency is covered (or an unstable loop was
    found in the box), else predicted."""
    return [_statement(r) for r in rows]


def _statement(r: RobustStability) -> Statement:
    return Statement(
        of_proof(r.holds) if r.certified or r.holds is False else Status.PREDICTED,
        StableWhileConstant(bool(r.loop.radius[3] > 0.0), r.dead_time, r.loop.weight is not None),
        r.holds,
        r.growth if np.isfinite(r.growth) else None,
        MuBounds(r),
        "x the box",
        f"{r.branch}, {r.rate} regulator rate",
        _evidence(r),
    )


def _evidence(r: RobustStability) -> dict[str, Any]:
    d = r.destabilising
    weight = {} if r.loop.weight is None else {"weight": asdict(r.loop.weight)}
    return weight | {
        "mu_upper": _finite(r.upper),
        "mu_lower": _finite(r.lower),
        "certified": r.certified,
        "worst_frequency_rad_s": _finite(r.worst),
        "intervals": r.intervals,
        "margin": _finite(r.margin),
        "dead_time_s": r.dead_time,
        "solver": r.solver,
        "certified_bounds": {n: list(b) for n, b in r.bounds.items()}
        if r.certified and r.upper < np.inf
        else {},
        "destabilising": d.parameters if d is not None else {},
        "left_out": list(r.left_out),
    }


def _finite(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None
