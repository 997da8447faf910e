"""The verdicts of a comparison in sentences."""

from math import isfinite

from design.studies.study import Study
from design.studies.verdict import Rank, Settling, Verdict
from reports.shared.tuning import refused

AGAINST = {
    Rank.AHEAD: "faster than the paper's PI over the whole range of its gains",
    Rank.BEHIND: "slower than the paper's PI over the whole range of its gains",
    Rank.UNDECIDED: "not ranked against the paper's PI, whose gains are too uncertain",
}


def verdict_sentences(study: Study) -> list[str]:
    """What the table says, one sentence a motion."""
    step = study.comparison.rig.task.step
    return [verdict_sentence(motion, v, step) for motion, v in study.verdicts.items()]


def verdict_sentence(motion: str, v: Verdict, step: float) -> str:
    """What the table says of a motion, whose task is a step [deg].

    >>> verdict_sentence("flexion", Settling(1.684, 5.0, 7.0, ()), 15.0)[:68]
    'flexion: the recommended PI settles the worst 15 degree task in 1.68'
    """
    if not isinstance(v, Settling):
        return f"{motion}: {refused(v)}; the tuned gains shown are the nearest found."
    tail = f"; {', '.join(v.breaking)} break the limits" if v.breaking else ""
    return (
        f"{motion}: the recommended PI settles the worst {step:g} degree task in {_seconds(v.tuned)} "
        f"(paper's PI with stand-in gains: {_seconds(v.paper_low)} to {_seconds(v.paper_high)}), "
        f"{AGAINST[v.rank]}{tail}."
    )


def _seconds(value: float) -> str:
    return f"{value:.2f} s" if isfinite(value) else "more than 10 s"
