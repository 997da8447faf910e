"""How certificates, predictions and samples can appear to contradict each other and all be true."""

from design.robustness.assess import Assessment
from design.robustness.disagreement import (
    CyclesRefuted,
    Disagreement,
    MarginsYetBroken,
    MarginYetUnproved,
    RareYetFound,
    StableYetUnproved,
    disagreements,
)
from reports.shared.tables import spaced


def disagreement_sentences(a: Assessment) -> list[str]:
    """Each seeming contradiction in one sentence or two; empty where the three kinds agree."""
    return [sentence(d) for d in disagreements(a)]


def sentence(d: Disagreement) -> str:
    """A seeming contradiction, and how both sides can be true.

    >>> sentence(MarginYetUnproved(0.0712, 0.05))[:44]
    'The predicted delay margin is 71.2 ms, but n'
    """
    match d:
        case StableYetUnproved():
            words = (
                "Linear theory predicts stability on every branch, but no certificate proves it for "
                "arbitrary switching between them."
            )
            if d.word is not None:
                words += (
                    f" For arbitrarily switching slopes and rates none exists: {spaced(str(d.word))}. "
                    "The wrist itself "
                    "cannot switch arbitrarily: its rate follows the pressure error, its slope the pressure."
                )
            return words + (f" All {d.settled} samples settled." if d.settled else "")
        case MarginYetUnproved():
            return (
                f"The predicted delay margin is {1000 * d.margin:.3g} ms, but no certificate covers the "
                f"loop with {1000 * d.dead_time:.3g} ms of dead time: a margin concerns one branch at a "
                "time, a certificate every sequence of branches."
            )
        case MarginsYetBroken():
            late = f", the samples have up to {1000 * d.dead_time:.3g} ms of added dead time."
            return (
                f"All predicted margins meet their limits, but {d.worst.count} of {d.worst.trials} samples "
                f"break a requirement ({d.worst.words}): margins concern small motions on one branch of the "
                f"nominal plant{late if d.dead_time else '.'}"
            )
        case RareYetFound():
            v = d.violations
            return (
                f"{v.count} of {v.trials} samples break it ({v.words}), but the search found a scenario that "
                "does: samples are steps from rest, whereas the search may command a step before the last "
                "has settled."
            )
        case CyclesRefuted():
            return (
                f"{d.refuted} of {d.predicted} limit cycles that the describing functions predict do not "
                "appear in simulation: describing functions keep only the first harmonic and ignore clipping "
                "of the command."
            )
