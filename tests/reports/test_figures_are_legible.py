"""In every figure of every page text is within the canvas, over no other text, and crossed by no line."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from design.controllers.pi import PI
from design.evaluation.scenarios import tuning_scenarios
from design.status import Status
from design.studies.paper import redrawn
from design.studies.shown.branch_steps import branch_steps
from design.synthesis.requirements import Limits, Problem
from design.synthesis.tuning import Region, tune
from design.synthesis.tuning_rules import baselines
from plants import Wrist, built_in
from reports.comparison.contest.table import differences_figure
from reports.comparison.page import main_figures
from reports.paper import figures as paper
from reports.robustness import page as robust
from reports.robustness.branches.signature import COMPARED, signature
from reports.shared.card import CardRow
from reports.shared.figures.dead_time_figure import dead_time_figure
from reports.shared.figures.decision_card import draw_card, draw_steps
from reports.shared.figures.direct_labels import label_ends
from reports.shared.figures.gain_map import gain_map
from reports.shared.figures.point_labels import label_points
from reports.shared.figures.style import new_figure, styled
from reports.trace import page as trace
from tests.reports.legible import faults
from tests.reports.report_samples import (
    small_contest,
    small_decision,
    small_robustness,
    small_trace,
    whole_study,
)


def signatures():
    """The loop on every branch, of a motion whose lines are parallel and of one with six loops."""
    found = {}
    for motion in ("flexion", "deviation"):
        wrist = Wrist.of(built_in(motion))
        rules = baselines(wrist)
        pis = {"these gains": PI(3.0, 10.0), **{n: PI.of(wrist, r.Kp, r.Ki) for n, r in rules.items()}}
        steps = branch_steps(wrist, pis)
        found[f"signature, {motion}"] = signature(wrist, steps, Limits())
        found[f"without a limit, {motion}"] = signature(wrist, steps, Limits(Ms=None))
        found[f"dead time, {motion}"] = dead_time_figure({"": steps.late}, 5.0, {"": COMPARED})
    return found


def gain_maps():
    """Maps of the gains of both motions, and one on which no gains meet the limits."""
    found = {}
    for motion, limits in (("flexion", Limits()), ("deviation", Limits()), ("flexion", Limits(Ms=1.05))):
        wrist = Wrist.of(built_in(motion))
        problem = Problem.of(wrist, tuning_scenarios(wrist)[:4], limits, duration=4.0)
        found[f"{motion}, Ms {limits.Ms}"] = gain_map(tune(problem, Region(points=6), starts=1))
    return found


def cards():
    """The steps of a card, one motion and both."""
    d = small_decision()
    row = CardRow(d.motion, d.controller, d.gains, d.matrix, d.evidence["proved"], d.band)
    proved = {**row.proved, "status": Status.OPEN, "rate_1_s": 0.043}
    gains = {"Kp": 12.94, "Ki": 11.29, "b": 0.6, "Tf": 0.0123}
    two = [row, replace(row, gains=gains, proved=proved)]
    return {"one motion": draw_steps([row]), "both": draw_steps(two), "whole card": draw_card(two)}


def paper_figures():
    """The figures of the paper, redrawn."""
    wrists = {m: Wrist.of(built_in(m)) for m in ("flexion", "deviation")}
    return {f"figure {n}": paper.draw(n, panels) for n, panels in redrawn(wrists).items()}


def differences():
    """Paired differences of controllers of which one is far ahead, one far behind."""
    near = {"SIMC": -0.5, "AMIGO": -1.0, "feedforward": 1.0, "robust LQI": 0.8, "convex-concave PI": -0.7}
    means = {**near, "Ziegler-Nichols": -30.0, "PI + feedforward": 40.0}
    small, scores = small_contest(), []
    for s in small.scores:
        scores.append(s)
        for name, mean in means.items() if s.controller == "paper" else ():
            i = replace(s.against["iae_deg_s"], mean=mean, low=mean - 0.1, high=mean + 0.1)
            scores.append(replace(s, controller=name, against={**s.against, "iae_deg_s": i}))
    return {"differences": differences_figure(replace(small, scores=tuple(scores)))}


def crowds():
    """Speed against robustness of a dozen controllers, several of them close together, beside a limit."""
    places = {
        "recommended PI": (180, 1.92), "PI tuned without dead time": (326, 1.72), "SIMC": (135, 2.35),
        "convex-concave PI": (279, 3.09), "robust LQI": (167, 3.98), "PI + feedforward": (180, 1.43),
        "feedforward": (6300, 0.34), "paper's PI (stand-in)": (1552, 5.75), "AMIGO": (181, 3.33),
        "Ziegler-Nichols": (36, 1.86), "linear MPC": (10, 0.378), "real-time MPC": (10, 0.296),
        "robust MPC": (85, 0.839),
    }  # fmt: skip
    ends = {"PI + feedforward": 2.4, "paper's PI (stand-in)": 1.0, "feedforward": 0.0, "AMIGO": 60.0}
    front = ("robust MPC", "PI + feedforward", "PI tuned without dead time", "paper's PI (stand-in)")
    with styled():
        crowd, (axes,) = new_figure(height=3.0)
        axes.set(xscale="log", yscale="log", xlim=(4, 7000), ylim=(0.2, 9.0))
        axes.plot(*np.array([places[n] for n in front]).T)
        axes.axvline(60.0)
        for x, y in places.values():
            axes.plot(x, y, "o")
        label_points(axes, places)
        curves, (beside,) = new_figure(height=3.0)
        beside.set(xlim=(0.0, 1.0), ylim=(0.0, 65.0))
        label_ends(beside, ends)
    return {"crowd": crowd, "curves": curves}


ROOMS = {
    "crowd": crowds,
    "differences": differences,
    "signature": signatures,
    "gain maps": gain_maps,
    "card": cards,
    "paper": paper_figures,
    "comparison": lambda: main_figures(whole_study()),
    "robustness": lambda: robust.draw_all(small_robustness()),
    "trace": lambda: trace.draw_all(small_trace()),
}


@pytest.mark.slow
@pytest.mark.parametrize("room", ROOMS)
def test_no_text_leaves_the_canvas_overlaps_another_or_is_crossed_by_a_line(room):
    found = {name: said for name, figure in ROOMS[room]().items() if (said := faults(figure))}
    assert found == {}


def test_a_fault_is_found_where_there_is_one():
    figure = Figure(figsize=(3, 2))
    figure.text(0.5, 0.5, "one")
    figure.text(0.52, 0.51, "other")
    figure.text(0.95, 0.2, "far too long for here")
    assert len(faults(figure)) == 2


def test_a_line_through_a_text_is_found():
    figure = Figure(figsize=(3, 2))
    axes = figure.add_subplot()
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    axes.plot([0.0, 1.0], [0.5, 0.5])
    axes.text(0.5, 0.5, "crossed", va="center")
    axes.text(0.5, 0.8, "clear", va="center")
    assert faults(figure) == ["a line runs through 'crossed'"]


def test_a_leader_through_the_name_of_another_is_found():
    figure = Figure(figsize=(3, 2))
    axes = figure.add_subplot()
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    axes.annotate("far", (0.1, 0.1), (0.8, 0.9), arrowprops={"arrowstyle": "-"})
    axes.text(0.45, 0.5, "between", va="center", ha="center")
    assert faults(figure) == ["a line runs through 'between'"]
