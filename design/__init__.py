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
    "Metrics": "design.metrics",
    "Trajectory": "design.loop",
    "run": "design.loop",
    "by_python_control": "design.margins",
    "Scenario": "design.tasks",
    "Spread": "design.tasks",
    "tuning_scenarios": "design.tasks",
    "Limits": "design.requirements",
    "Problem": "design.requirements",
    "Question": "design.studies.study",
    "Study": "design.studies.study",
    "study": "design.studies.study",
    "Region": "design.tuning",
    "Tuning": "design.tuning",
    "tune": "design.tuning",
    "baselines": "design.rules",
}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'design' has no attribute {name!r}")
