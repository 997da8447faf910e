"""Two campaigns of one rig: unchanged between them, or worn in one of three ways."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.rig.campaign import make_rig, record
from tests.rig.rig import Bench, Rig
from tests.rig.suite import Case, cases

LATER = 500
"""Added to a rig's seed for its later campaign: other commands, other noise."""

SIZES = {"slope": 0.12, "leak": 0.05, "tube": 0.05}
"""Usual sizes of the changes: share by which all slopes soften, pressure that pores lose [1/s], delay [s] of
the longer tube."""


def worn(rig: Rig, what: str, size: float | None = None) -> Rig:
    """The rig with a slope that softened, a leak that opened or a tube that was lengthened; unchanged for
    any other word."""
    d, h, by = rig.declared, rig.hidden, SIZES.get(what, 0.0) if size is None else size
    if what == "slope":
        soft = d._replace(a1=(1.0 - by) * d.a1, a2=(1.0 - by) * d.a2, s=(1.0 - by) * d.s)
        return replace(rig, declared=soft)
    if what == "leak":
        return replace(rig, hidden=h._replace(leak=h.leak._replace(form=2, porous=by)))
    if what == "tube":
        longer = h.dead_time._replace(form=max(h.dead_time.form, 1), transport_s=h.dead_time.transport_s + by)
        return replace(rig, hidden=h._replace(dead_time=longer))
    return rig


def drawn(seed: int, count: int, plain: bool = False) -> list[tuple[Case, Rig]]:
    """So many different cases of the judging suite, effects outside the vocabulary among them, and a rig of
    each; plain: only those without an effect."""
    listed = [c for c in cases(seed) if not (plain and c.effects)]
    order = np.random.default_rng([seed, 2000]).permutation(len(listed))[:count]
    return [
        (c, make_rig(c.axis, c.effects, 1000 * seed + k, c.variants))
        for k, c in enumerate(listed[i] for i in order)
    ]


def write(rig: Bench, folder: Path, later: bool = False, short: bool = False) -> Path:
    """A campaign of a rig in a folder; later: with other commands and other noise."""
    of = replace(rig, seed=rig.seed + LATER) if later else rig
    record(of, folder, short=short, with_other="cross-coupling" in rig.effects)
    return folder
