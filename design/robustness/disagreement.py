"""Where certificates, predictions and samples seem to contradict each other, and how both can be true."""

from design.robustness.assess import Assessment


def disagreements(a: Assessment) -> list[str]:
    """Each seeming contradiction in one sentence or two; empty where the three kinds agree."""
    return [words for found in (_switching, _late, _overshoot, _rare, _cycles) for words in found(a)]


def _switching(a: Assessment) -> list[str]:
    """Stable on each branch, and no proof that it stays so between them."""
    rungs = [c for c in a.ladder if c.dead_time == 0.0]
    if not a.stable or any(c.holds for c in rungs):
        return []
    words = (
        "Linear theory calls the loop stable on every branch, yet no rung proves it for every way of moving "
        "between them."
    )
    if a.word is not None:
        words += (
            f" For slopes and rates that switch at will none can: {a.word}. The wrist itself cannot do "
            "that, since its rate follows the error of the pressure and its slope the pressure."
        )
    return [words + _unharmed(a)]


def _unharmed(a: Assessment) -> str:
    unsettled = [v for v in a.cases.violations if v.requirement == "settles"]
    if not unsettled or unsettled[0].count:
        return ""
    return f" All {unsettled[0].trials} samples settled."


def _late(a: Assessment) -> list[str]:
    """A delay margin that is predicted, and no certificate with that dead time."""
    found = []
    margin = min(float(row["delay_margin_s"]) for row in a.margins)
    for dead_time in dict.fromkeys(c.dead_time for c in a.ladder if c.dead_time > 0.0):
        certified = [c for c in a.ladder if c.holds and c.dead_time == dead_time]
        without = [c for c in a.ladder if c.holds and c.dead_time == 0.0]
        if margin > dead_time and without and not certified:
            found.append(
                f"The predicted delay margin is {1000 * margin:.3g} ms, but no rung certifies the loop with "
                f"{1000 * dead_time:g} ms of dead time: the margin is of one branch at a time, the "
                "certificate "
                "of every way of moving between them."
            )
    return found


def _overshoot(a: Assessment) -> list[str]:
    """Margins that are held, and samples that break a requirement all the same."""
    judged = [s for s in a.predictions if s.holds is not None]
    broken = [v for v in a.cases.violations if v.count]
    if not judged or not broken or not all(s.holds for s in judged):
        return []
    worst = max(broken, key=lambda v: v.count)
    late = a.conditions.dead_time
    words = (
        f"Every predicted margin is held, and yet {worst.count} of {worst.trials} samples break a "
        "requirement "
        f"({worst.words}): margins are of small motions on one branch of the nominal plant"
    )
    return [words + (f", the samples have up to {1000 * late:g} ms of dead time on top." if late else ".")]


def _rare(a: Assessment) -> list[str]:
    """A requirement that hardly any sample breaks, and a scenario that does."""
    found = []
    for v in a.cases.violations:
        if v.requirement in a.worst.violated and v.count <= 0.01 * v.trials:
            found.append(
                f"{v.count} of {v.trials} samples break it ({v.words}), and the search found a scenario that "
                "does: samples are steps from rest, the search may step again before the wrist has come to "
                "rest."
            )
    return found


def _cycles(a: Assessment) -> list[str]:
    """Limit cycles that are predicted and that the simulator does not have."""
    refuted = [c for c in a.cycles if not c.confirmed]
    if not refuted:
        return []
    return [
        f"{len(refuted)} of {len(a.cycles)} limit cycles that the describing functions predict "
        "are not there in simulation: they keep the first harmonic alone, and know nothing of a clipped "
        "command."
    ]
