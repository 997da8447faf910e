"""What to do about the wrist: controllers, how they are judged, tuning, comparison.

>>> import design, plants
>>> judged, _, _ = design.run(plants.Wrist.deviation(), design.PI(Kp=6.7, Ki=19.4), 15.0)
>>> bool(judged.overshoot_percent[0] < 5.0)
True

Names are imported when they are first used, so that the command starts fast.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "PI": "design.controllers.pi",
    "Metrics": "design.evaluation.metrics",
    "Trajectory": "design.evaluation.steps",
    "run": "design.evaluation.steps",
    "by_python_control": "design.margins",
    "Scenario": "design.evaluation.scenarios",
    "Spread": "design.evaluation.scenarios",
    "tuning_scenarios": "design.evaluation.scenarios",
    "Limits": "design.synthesis.requirements",
    "Problem": "design.synthesis.requirements",
    "Question": "design.studies.study",
    "Study": "design.studies.study",
    "study": "design.studies.study",
    "Region": "design.synthesis.tuning",
    "Tuning": "design.synthesis.tuning",
    "tune": "design.synthesis.tuning",
    "baselines": "design.synthesis.tuning_rules",
}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'design' has no attribute {name!r}")
