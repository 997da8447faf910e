"""How certificates, predictions and samples can seem to contradict each other and all be true."""

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
                "Linear theory calls the loop stable on every branch, yet no rung proves it for every way of "
                "moving between them."
            )
            if d.word is not None:
                words += (
                    f" For arbitrarily switching slopes and rates none can: {d.word}. The wrist itself "
                    "cannot do that, since its rate follows the error of the pressure and its slope the "
                    "pressure."
                )
            return words + (f" All {d.settled} samples settled." if d.settled else "")
        case MarginYetUnproved():
            return (
                f"The predicted delay margin is {1000 * d.margin:.3g} ms, but no rung certifies the loop "
                f"with {1000 * d.dead_time:g} ms of dead time: the margin is of one branch at a time, the "
                "certificate of every way of moving between them."
            )
        case MarginsYetBroken():
            late = f", the samples have up to {1000 * d.dead_time:g} ms of added dead time."
            return (
                f"Every predicted margin is held, and yet {d.worst.count} of {d.worst.trials} samples break "
                f"a requirement ({d.worst.words}): margins are of small motions on one branch of the nominal "
                f"plant{late if d.dead_time else '.'}"
            )
        case RareYetFound():
            v = d.violations
            return (
                f"{v.count} of {v.trials} samples break it ({v.words}), and the search found a scenario that "
                "does: samples are steps from rest, the search may step again before the wrist has come to "
                "rest."
            )
        case CyclesRefuted():
            return (
                f"{d.refuted} of {d.predicted} limit cycles that the describing functions predict are not "
                "there in simulation: they keep the first harmonic alone, and know nothing of a clipped "
                "command."
            )
