"""The structured singular value over all frequencies, closed between grid points by a Hamiltonian test.

With scalings D, G that do not vary, F(omega) = M'DM + j(GM - M'G) - (1 - m) N D N is a rational
function of the frequency; it is singular where a Hamiltonian matrix has the eigenvalue j omega.  So what
holds at one frequency holds up to the nearest of these on both sides, ends included.  Where intervals of
that kind cover all frequencies, beta is above mu at every one of them, not only on a grid.

Sources: Lawrence, Tits, Van Dooren, A fast algorithm for the computation of an upper bound on the
mu-norm, Automatica 36 (2000); Ferreres, Magni, Biannic, Robustness analysis of flexible structures:
practical algorithms, Int. J. Robust Nonlinear Control 13 (2003) 715, doi 10.1002/rnc.742.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.constant.mu import Blocks, Scalings, margin, scalings, sizes, upper_bound

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SPARE = 1e-3
"""m: the share by which the inequality is to hold on the whole of an interval, ends included."""

ON_AXIS = 1e-5
"""An eigenvalue this close to the imaginary axis, as a share of its size, counts as on it: what is
counted too much only shortens an interval."""

SHAVE = 1e-7
"""Share by which an interval is shorter than to its end, which is only computed to so many digits."""

STEP = 0.005
"""Share by which beta is above the bound at the worst frequency."""

CHECKS = 12
"""Random frequencies in each interval at which the inequality is looked at again."""


@dataclass(frozen=True)
class System:
    """M(s) = C (sI - A)^-1 B + E, seen by Delta of `blocks`, on frequencies [rad/s] from low to high.

    A (x, x), B (x, n), C (n, x), E (n, n).  No eigenvalue of A on the imaginary axis between low and high.
    """

    A: Array
    B: Array
    C: Array
    E: Array
    blocks: Blocks
    low: float = 0.0
    high: float = np.inf

    @property
    def fastest(self) -> float:
        """Size of the largest eigenvalue of A [1/s]."""
        return float(np.max(np.abs(np.linalg.eigvals(self.A))))

    def response(self, omega: float | Array) -> Complex:
        """M(j omega), shape of omega + (n, n)."""
        s = 1j * np.asarray(omega, float)[..., None, None]
        states = np.linalg.solve(s * np.eye(len(self.A)) - self.A, self.B.astype(complex))
        found: Complex = np.asarray(self.C @ states + self.E, complex)
        return found


@dataclass(frozen=True)
class Piece:
    """Frequencies [rad/s] from low to high, ends included, on which one pair of scalings holds."""

    low: float
    high: float
    at: float
    scalings: Scalings


@dataclass(frozen=True)
class Gap:
    """So many matrix inequalities left frequencies [rad/s] without a proof, from `low` to `high`."""

    tried: int
    low: float
    high: float


@dataclass(frozen=True)
class NoBound:
    """There is no bound at a frequency [rad/s]."""

    at: float


@dataclass(frozen=True)
class HoldsBarely:
    """An inequality holds by this share only where it was looked at again."""

    share: float


Incomplete = Gap | NoBound | HoldsBarely
"""Why not every frequency is covered."""


@dataclass(frozen=True)
class Cover:
    """beta above mu at every frequency, where `complete`; else `reason` says why not, inf where a frequency
    has no bound.

    peak [rad/s]: the frequency that decided beta, None where the beta given at first was enough;
    margin: least share by which the inequality held where it was looked at again, -inf where it did not.
    """

    beta: float
    complete: bool
    pieces: tuple[Piece, ...]
    peak: float | None
    margin: float
    reason: Incomplete | None = None


def crossings(system: System, s: Scalings, at: float, beta: float, spare: float = SPARE) -> Array | None:
    """The frequencies [rad/s], ascending and of either sign, at which F is singular, seen from `at`.

    The eigenvalues lambda of the Hamiltonian matrix that are imaginary, by way of those of
    (H - j at I)^-1, so that the nearest to `at` come out best, and H, which does not exist where F is
    singular at infinity, is not needed.  None where F is singular at `at`.
    """
    import scipy.linalg

    A, B, C, E = system.A, system.B, system.C, system.E
    N = sizes(system.blocks, beta)
    Q = C.T @ s.D @ C
    S = C.T @ s.D @ E - 1j * C.T @ s.G
    half = 1j * s.G @ E
    R = E.T @ s.D @ E + half + half.conj().T - (1.0 - spare) * N[:, None] * s.D * N
    # States x' = Ax + Bu and l' = -A'l - Qx - Su, with u such that S'x + B'l + Ru = 0.
    x = len(A)
    shift = 1j * at * np.eye(x)
    pencil = np.block([[A - shift, np.zeros((x, x)), B], [-Q, -A.T - shift, -S], [S.conj().T, B.T, R]])
    try:
        inverse = np.linalg.solve(pencil, np.eye(len(pencil))[:, : 2 * x])[: 2 * x]
    except np.linalg.LinAlgError:
        return None
    nu = np.linalg.eigvals(scipy.linalg.matrix_balance(inverse, permute=False)[0])
    near = np.abs(nu.real) <= ON_AXIS * np.abs(nu) + 1e-11 * np.max(np.abs(nu))
    with np.errstate(divide="ignore"):
        found: Array = np.sort(at - 1.0 / nu.imag[near])  # nu = 1 / (j (omega - at))
    return found


def piece(system: System, s: Scalings, at: float, beta: float, spare: float = SPARE) -> Piece | None:
    """The frequencies about `at` on which the scalings prove beta; None where they do not at `at`."""
    if margin(system.response(at), s, system.blocks, beta) <= spare:
        return None
    omega = crossings(system, s, at, beta, spare)
    if omega is None:
        return None
    low = np.max(omega[omega < at], initial=-np.inf)
    high = np.min(omega[omega > at], initial=np.inf)
    # A little less than that, for rounding; ends at infinity, where F keeps its sign, stay there.
    low, high = at - (at - low) * (1.0 - SHAVE), at + (high - at) * (1.0 - SHAVE)
    return Piece(max(system.low, low), min(system.high, high), at, s)


def cover(system: System, beta: float, most: int = 200, step: float = STEP) -> Cover:
    """The least beta, no less than the one given, that is proved at every frequency of a system.

    Widest gap first; at a frequency where beta is no bound it is raised to `step` above the bound there,
    which takes nothing from the intervals found before.  Ends after `most` linear matrix inequalities,
    or where a frequency has no bound at all, with what there is.
    """
    pieces: list[Piece] = []
    peak = None
    for _ in range(most):
        gap = _gap(system, pieces)
        if gap is None:
            found = Cover(beta, True, tuple(pieces), peak, np.nan)
            return _checked(system, found)
        at = _inside(system, gap)
        s = scalings(system.response(at), system.blocks, beta)
        new = None if s is None else piece(system, s, at, beta)
        if new is not None and new.high - new.low > 1e-7 * at:
            pieces.append(new)
            continue
        bound, _ = upper_bound(system.response(at), system.blocks)
        if not np.isfinite(bound):
            return Cover(np.inf, False, tuple(pieces), at, -np.inf, NoBound(at))
        beta, peak = max(beta, bound) * (1.0 + step), at
    return Cover(beta, False, tuple(pieces), peak, -np.inf, Gap(most, *gap) if gap else None)


def _gap(system: System, pieces: list[Piece]) -> tuple[float, float] | None:
    """The first frequencies that no piece covers; their ends, None where every one is covered."""
    reached = system.low
    started = False
    for p in sorted(pieces, key=lambda p: p.low):
        if p.low > reached or (not started and p.low > system.low):
            return reached, p.low
        started = True
        reached = max(reached, p.high)
    return None if started and reached >= system.high else (reached, system.high)


def _inside(system: System, gap: tuple[float, float]) -> float:
    """A frequency in a gap: its middle by ratio; the lowest of all first, then one far above all others."""
    low, high = gap
    if not np.isfinite(high):
        return 1e2 * max(system.fastest, low) if low <= system.low else 10.0 * low
    if low <= 0.0:
        return 0.0
    return float(np.sqrt(low * high))


def _checked(system: System, found: Cover) -> Cover:
    """The cover with the inequality looked at again, in NumPy: at the ends and at random inside."""
    rng = np.random.default_rng(0)
    least = np.inf
    for p in found.pieces:
        high = p.high if np.isfinite(p.high) else 1e3 * max(p.at, p.low, system.fastest)
        # Evenly by ratio and evenly by difference, since pieces may span decades.
        share = rng.random(CHECKS)
        low = max(p.low, 1e-6 * high)
        omega = np.concatenate(
            [[p.low, p.at, high], p.low + (high - p.low) * share, low * (high / low) ** share]
        )
        least = min(least, margin(system.response(omega), p.scalings, system.blocks, found.beta))
        if not np.isfinite(p.high):
            least = min(least, margin(system.E.astype(complex), p.scalings, system.blocks, found.beta))
    held = least >= 0.5 * SPARE
    return replace(found, complete=held, margin=least, reason=None if held else HoldsBarely(least))
