"""The plane of the gains: where the loop is stable, where limits hold, what is certified."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.robustness.certificates.continuous.ladder import certifies
from design.robustness.loop_model import LoopModel
from design.synthesis.evaluate import Evaluation, controller, evaluate_with, join
from design.synthesis.requirements import Problem

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
CHUNK = 128


@dataclass(frozen=True)
class GainPlane:
    """A grid of gains: Kp (n,) [kPa/deg], Ki (m,) [kPa/(deg s)], both log-spaced; at: their evaluation on
    the tuning scenarios, flattened with Kp in rows; certified: by rung, (n, m), where it found a
    certificate for loops without dead time."""

    Kp: Array
    Ki: Array
    at: Evaluation
    certified: Mapping[str, Mask]

    def field(self, name: str) -> Array:
        """The worst value of a limited quantity, such as ``Ms``, shape (n, m)."""
        return self.at.values[name].reshape(self.Kp.size, self.Ki.size)

    @property
    def stable(self) -> Mask:
        """Where the linear loop is stable on every branch at both rates, (n, m)."""
        return np.isfinite(self.field("Ms"))


def gain_plane(
    problem: Problem,
    rungs: tuple[str, ...],
    Kp: tuple[float, float] = (0.3, 40.0),
    Ki: tuple[float, float] = (0.3, 200.0),
    points: int = 20,
    progress: Callable[[str, float], None] | None = None,
    law: Callable[[Problem, Array, Array], PI] = controller,
) -> GainPlane:
    """Evaluate a grid of gains on a problem's scenarios and branches, and try each certificate of `rungs` on
    them.

    law: the controllers of gains (n,), PIs if not given.  Certificates are tried only where the linear loop
    is stable, since there are none elsewhere.
    """
    tell = progress or (lambda stage, share: None)
    rows, columns = np.geomspace(*Kp, points), np.geomspace(*Ki, points)
    grid = np.array([(p, i) for p in rows for i in columns])
    pieces = np.array_split(grid, -(-len(grid) // CHUNK))
    parts = []
    for number, piece in enumerate(pieces):
        tell("gain plane", 0.3 * number / len(pieces))
        some = piece[:, 0], piece[:, 1]
        parts.append(evaluate_with(problem, law(problem, *some), *some))
    at = join(parts)
    stable = np.isfinite(at.values["Ms"])
    certified = {rung: np.zeros(len(grid), bool) for rung in rungs}
    for n, (p, i) in enumerate(grid):
        tell("gain plane", 0.3 + 0.7 * n / len(grid))
        if not stable[n]:
            continue
        model = LoopModel.of(problem.wrist, law(problem, p, i))
        for rung in rungs:
            certified[rung][n] = certifies(model, rung)
    return GainPlane(
        rows, columns, at, {rung: found.reshape(points, points) for rung, found in certified.items()}
    )
