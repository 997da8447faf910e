"""The broad comparison: every controller on plants that its model does not describe exactly.

`design.comparison.compare` judges on the plant as it is, without noise.  Here the same controllers meet
plants drawn
within their uncertainty, rigs with an effect that no controller's model has, other tasks (`tasks`), both
motions at once with coupling (`coupled`) and a sensor with noise and a quantum, each controller the very
same cases, so that what is compared are paired differences (`statistics`).  None of these cases was
tuned on.
"""

from design.contest.scores import Contest, Score, contest, contest_record

__all__ = ["Contest", "Score", "contest", "contest_record"]
