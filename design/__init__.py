"""Controllers for the wrist: design, tuning, evaluation, robustness, comparison.

>>> import design, plants
>>> judged, _, _ = design.run(plants.Wrist.deviation(), design.PI(Kp=6.7, Ki=19.4), 15.0)
>>> bool(judged.overshoot_percent[0] < 5.0)
True

Names are imported when they are first used, so that the command starts fast.
"""

from typing import Any

from plants.facade import named

_HOMES = {  # the module of each name, and what it is called there where that is something else
    "PAPER_GAINS": "design.synthesis.tuning_rules",
    "PI": "design.controllers.pi",
    "RUNGS": "design.robustness.certificates.continuous.search",
    "STEP": "design.evaluation.scenarios",
    "Case": "design.evaluation.cases",
    "Conditions": "design.robustness.samples.conditions",
    "Feedforward": "design.controllers.feedforward",
    "FeedforwardPI": "design.controllers.feedforward",
    "Limits": "design.synthesis.requirements",
    "LoopModel": "design.robustness.loop_model",
    "MarginLimits": "design.synthesis.tune_pi",
    "Metrics": "design.evaluation.metrics",
    "Problem": "design.synthesis.requirements",
    "Question": "design.studies.study",
    "Region": "design.synthesis.tuning",
    "Screened": "design.controllers.measurement.screened",
    "Spread": "design.evaluation.scenarios",
    "Study": "design.studies.study",
    "Task": "design.evaluation.tasks",
    "Trajectory": "design.evaluation.steps",
    "Tuner": "design.tuner",
    "Tuning": "design.synthesis.tuning",
    "assess": "design.robustness.assess",
    "baselines": "design.synthesis.tuning_rules",
    "box_of": "design.robustness.box",
    "break_even": "design.comparison.break_even",
    "by_python_control": "design.open_loops",
    "check_log": "design.studies.check.check",
    "corners": "design.evaluation.scenarios",
    "decide": "design.studies.decision",
    "default_problem": "design.synthesis.requirements",
    "design_feedforward": "design.alternatives.feedforward_design",
    "envelopes": "design.robustness.samples.monte_carlo",
    "evaluate": "design.synthesis.evaluate",
    "gain_plane": "design.robustness.gain_plane",
    "growth_of": "design.robustness.certificates.sampled.growth",
    "limit_cycles": "design.robustness.predictions.limit_cycles",
    "linear_mpc": "design.mpc.formulations.linear",
    "monte_carlo": "design.robustness.samples.monte_carlo",
    "nominal_mpc": "design.mpc.problem:nominal",
    "paper_series": "design.studies.paper:series",
    "performance_bound": "design.limit:limit",
    "play": "design.evaluation.runner",
    "reaction_curve": "design.synthesis.tuning_rules",
    "real_time_mpc": "design.mpc.formulations.real_time",
    "requirement": "design.robustness.requirement",
    "retune": "design.synthesis.retune",
    "robust_mpc": "design.mpc.problem:robust",
    "run": "design.evaluation.steps",
    "run_mpc": "design.mpc.loop:run",
    "stack": "design.evaluation.cases",
    "study": "design.studies.study",
    "tune": "design.synthesis.tuning",
    "tune_pi": "design.synthesis.tune_pi:tune_pi",
    "tune_robustly": "design.robustness.tuning.robust_tuning",
    "tuning_scenarios": "design.evaluation.scenarios",
    "worst_run": "design.studies.robustness_study",
    "write_gains": "design.tuner.gains_file:write",
}
__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    return named("design", _HOMES, name)
