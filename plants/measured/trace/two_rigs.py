"""Recordings that do not seem to come from one rig."""

from collections.abc import Sequence

import numpy as np

from plants.measured.fitting.noise import noise_floor
from plants.measured.trace.result import StageTrace
from plants.measured.trace.stages.model import Model

ALONE = 1.2
"""A recording whose chi-square per row is below this is explained by parameters of its own."""


def rigs_differ(stages: Sequence[StageTrace]) -> tuple[str, ...]:
    """A remark where each recording alone is explained, but not all together: two rigs, or one that
    was changed in between."""
    for s in stages:
        if s.explained or len(s.stage.playbacks) < 2:
            continue
        alone = []
        for i in range(len(s.stage.playbacks)):
            rows = np.zeros(s.stage.edges[-1], bool)
            rows[s.stage.edges[i] : s.stage.edges[i + 1]] = True
            m = s.model.fitted(15, 1e-4, rows)
            own = noise_floor(s.stage.target[rows]) / s.stage.noise  # of this recording alone
            alone.append((float(np.mean(m.residual[rows] ** 2)) / own**2, m))
        if max(c for c, _ in alone) < ALONE:
            name = max(s.model.names, key=lambda n: _spread(n, s.model, [m for _, m in alone]))
            each = ", ".join(
                f"{p.recording.name} {m.values[name]:.3g}"
                for p, (_, m) in zip(s.stage.playbacks, alone, strict=True)
            )
            return (
                f"Each recording alone is explained, but not all with one set of parameters ({name}: "
                f"{each}): they may come from two rigs, or the rig was changed between them.",
            )
    return ()


def _spread(name: str, model: Model, alone: Sequence[Model]) -> float:
    """How far a parameter differs between recordings, as a share of its value."""
    return float(np.ptp([m.values[name] for m in alone])) / (abs(model.values[name]) or 1.0)
