"""A study of a PI's robustness: what can be trusted of its gains, and all that its page shows beside."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from design.controllers.pi import PI
from design.evaluation.cases import stack
from design.evaluation.runner import PlayedTask, play
from design.margins import with_dynamics
from design.robustness.assess import Assessment
from design.robustness.certificates.continuous.search import RUNGS
from design.robustness.gain_plane import GainPlane, gain_plane
from design.robustness.samples.monte_carlo import Envelopes, envelopes
from design.robustness.samples.worst import Worst
from design.studies.shown.branch_steps import BranchSteps, branch_steps
from design.studies.shown.cell_steps import CellSteps, cell_steps
from design.studies.shown.load_response import LoadResponse, load_response
from design.synthesis.requirements import default_problem
from design.synthesis.tuning_rules import PAPER_GAINS, baselines

Tell = Callable[[str, float], None]


@dataclass(frozen=True)
class RobustnessStudy:
    """An assessment with what is drawn of it.

    plane: of the gains; envelopes: of the samples, None where none is within reach; worst_run: the worst
    scenario, with its signals; gains: of the textbook rules and the paper's stand-in, for comparison;
    branches: steps of all of these from every initial state, and their overshoot behind a dead time; cells:
    steps under every cell of the plane; load: response to a load, None where the rig has none.
    """

    assessment: Assessment
    plane: GainPlane
    envelopes: Envelopes | None
    worst_run: PlayedTask
    gains: Mapping[str, tuple[float, float]]
    branches: BranchSteps
    cells: CellSteps
    load: LoadResponse | None = None


def robustness_study(
    assessment: Assessment, points: int = 20, jobs: int | None = None, progress: Tell | None = None
) -> RobustnessStudy:
    """The study of an assessment, with a plane of `points` gains either way, which takes its time."""
    problem = default_problem(assessment.wrist, assessment.limits, jobs=jobs)
    branches = with_dynamics(problem.branches, assessment.weight)
    problem = replace(problem, branches=tuple(branches))
    plane = gain_plane(
        problem, tuple(RUNGS), points=points, progress=progress,
        law=lambda problem, Kp, Ki: replace(assessment.controller, Kp=Kp, Ki=Ki),
    )  # fmt: skip
    return study_of(assessment, plane)


def study_of(assessment: Assessment, plane: GainPlane) -> RobustnessStudy:
    """The study of an assessment with a plane that is known."""
    rules = {n: (float(c.Kp), float(c.Ki)) for n, c in baselines(assessment.wrist).items() if n != "paper"}
    gains, wrist = {"paper's PI (stand-in)": PAPER_GAINS, **rules}, assessment.wrist
    pis = {"these gains": assessment.controller, **{n: PI.of(wrist, *k) for n, k in gains.items()}}
    return RobustnessStudy(
        assessment, plane, envelopes(assessment.cases), worst_run(assessment.worst), gains,
        branch_steps(wrist, pis),
        cell_steps(wrist, replace(assessment.controller, Kp=plane.at.Kp, Ki=plane.at.Ki)),
        load_response(wrist, pis),
    )  # fmt: skip


def worst_run(worst: Worst) -> PlayedTask:
    """A worst scenario, simulated, with its signals."""
    return play(stack([worst.case]), worst.controller, record=True)
