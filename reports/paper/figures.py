"""The paper, redrawn: its figures from the model alone, each saying what it rests on.

The measured curves are not among them: the text reached us without its
figures, and no measurement of that rig is to be had.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from design.studies.shown.panels import Panel
from design.synthesis.tuning_rules import PAPER_FACTOR, PAPER_GAINS
from plants.parameters.files import built_in
from plants.parameters.quantities import REGULATOR_NAMES, Fitted, ParameterSet
from reports.paper import plots
from reports.paper.plots import Plot
from reports.shared.figures.style import styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOP_NAMES = ("a1", "w1", "a2", "w2", "s")


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: its title there, how its series (`design.studies.paper`) are drawn, what is
    to be seen, and the parameters that it rests on; `stand_in` if the PI's gains are too."""

    title: str
    plot: Plot
    see: str
    names: tuple[str, ...]
    motions: tuple[str, ...] = ("flexion", "deviation")
    stand_in: bool = False


FIGURES: Mapping[int, PaperFigure] = {
    5: PaperFigure(
        "Relationship between applied voltage and steady-state pressure",
        plots.steady_line,
        "Commands of 0 to 4 V in steps of 0.5 V, each held for 20 s: the pressure in the steady state is "
        "proportional to the command, and 4 V give 197.6 kPa at a gain of 49.4 kPa/V.",
        ("gain",),
    ),
    6: PaperFigure(
        "Simulation with first order lag model (3 V)",
        plots.regulator_responses,
        "100 kPa, a command of 3 V, and 100 kPa again, by the paper's first-order lag of 0.111 s. The "
        "pressure settles within half a second, whereas the paper reports about 10 s for the real "
        "regulator: the lag is too fast near the end.",
        ("gain",),
    ),
    8: PaperFigure(
        "Simulation with variable P control model (3 V)",
        plots.regulator_responses,
        "The same test with the variable P model, the lag beside it. Both rise alike, but the last few "
        "kilopascals take seconds, as the paper reports of the real regulator. In the paper both motions "
        "share the regulator.",
        REGULATOR_NAMES,
    ),
    10: PaperFigure(
        "Relationship between applied pressure and steady-state angle of wrist",
        plots.initial_motions,
        "The initial motion: from rest at 100 kPa straight to 0, 50, 100, 150 or 200 kPa. Around 100 kPa "
        "is a dead zone in which the wrist does not move (shaded). 4 V do not reach 200 kPa: the last "
        "point is at the pressure of 4 V.",
        LOOP_NAMES,
    ),
    11: PaperFigure(
        "Relationships between applied pressure and time",
        plots.staircase_pressures,
        "The staircase: from 100 kPa by 50 kPa at a time within 0 to 200 kPa (its order and 20 s a level "
        "are assumed), and the pressure of the modelled regulator.",
        REGULATOR_NAMES,
    ),
    12: PaperFigure(
        "Hysteresis loop of pneumatic wrist motions",
        plots.hysteresis_loops,
        "Steady-state angle against pressure on the staircase. At one pressure the wrist has "
        "different angles, depending on its history: line 1 while it moves in the plus direction, "
        "line 2 while it moves in the minus direction, and a transit of constant slope between the two.",
        LOOP_NAMES,
    ),
    13: PaperFigure(
        "Simulation of pneumatic wrist motions",
        plots.angles_on_staircase,
        "The wrist drive system, regulator and wrist in series, on the staircase. The angle at 100 kPa is"
        " not the same on the way up, on the way down and after it.",
        (*REGULATOR_NAMES, *LOOP_NAMES, "Tw"),
    ),
    14: PaperFigure(
        "Results of fixed command control (palmar/dorsal flexion)",
        plots.pi_steps,
        "A step of 15 deg under a PI. The wrist starts late, since the pressure must cross the dead zone "
        "first, and takes several seconds to settle, as in the paper.",
        (*REGULATOR_NAMES, *LOOP_NAMES, "Tw"), ("flexion",), True,
    ),
    15: PaperFigure(
        "Results of fixed command control (radial/ulnar deviation)",
        partial(plots.pi_steps, mark=(6.0, "here the paper's experiment\nleft its simulation")),
        "The same for radial/ulnar deviation. At about 6 s the paper's experiment differs from its "
        "simulation; the paper attributes this to the straight lines drawn through a curved loop, which "
        "this model shares.",
        (*REGULATOR_NAMES, *LOOP_NAMES, "Tw"), ("deviation",), True,
    ),
}  # fmt: skip
"""The figures that the model can redraw, by their numbers in the paper."""

SHORT = {"flexion": "palmar/dorsal flexion", "deviation": "radial/ulnar deviation"}


def _figure(number: int) -> PaperFigure:
    if number not in FIGURES:
        raise ValueError(f"Fig. {number} cannot be redrawn; one of {', '.join(map(str, FIGURES))}")
    return FIGURES[number]


def draw(number: int, panels: tuple[Panel, ...]) -> "Figure":
    """One figure of the paper from its series; raises ValueError for a figure that cannot be redrawn."""
    figure = _figure(number)
    with styled():
        return figure.plot(panels)


def data(number: int, panels: tuple[Panel, ...]) -> dict[str, Any]:
    """What `draw` draws, as lists: {"figure", "title", "caption", "panels": [{"title", "x_label",
    "y_label", "series": [{"name", "x", "y", "role", maybe "low", "high"}]}]}."""
    figure = _figure(number)
    return {
        "figure": number, "title": figure.title, "caption": caption(number),
        "panels": [plain(p) for p in panels],
    }  # fmt: skip


def plain(panel: Panel) -> dict[str, Any]:
    """A panel as dictionaries, lists and floats, for JSON; bounds only where there are any."""
    record = asdict(panel)
    for series in record["series"]:
        for key in ("x", "y", "low", "high"):
            if series[key] is None:
                del series[key]
            else:
                series[key] = [float(v) for v in np.round(series[key], 6)]
    return record


def caption(number: int, sets: Mapping[str, ParameterSet] | None = None) -> str:
    """What to see in a figure, that the measured curve is lacking, and what it rests on.

    sets: the parameter sets that were drawn, by motion; the built-in ones if not given.
    """
    figure = _figure(number)
    rests = _rests_on(figure, sets or {m: built_in(m) for m in ("flexion", "deviation")})
    lost = "The measured curve of the paper is not available."
    return f"Fig. {number} of the paper, redrawn: {figure.title}. {figure.see} {lost} {rests}"


def _rests_on(figure: PaperFigure, sets: Mapping[str, ParameterSet]) -> str:
    of = {m: sets[m] for m in figure.motions if m in sets}
    assumed = {m: [n for n in figure.names if n in s.assumed] for m, s in of.items()}
    fitted = {
        m: [n for n in figure.names if isinstance(s.parameters[n].provenance, Fitted)] for m, s in of.items()
    }
    said = [f"It rests on the assumed parameters {_listed(assumed)}."] if any(assumed.values()) else []
    if any(fitted.values()):
        said.append(f"Fitted to data: {_listed(fitted)}.")
    if figure.stand_in:
        Kp, Ki = PAPER_GAINS
        said.append(
            f"The PI's gains are assumed too, a stand-in for the lost ones: Kp = {Kp:g} kPa/deg and "
            f"Ki = {Ki:g} kPa/(deg s); the band covers a factor of {PAPER_FACTOR:g} either way in both."
        )
    return " ".join(said) or "It rests on no assumed parameter, only on what the paper states."


def _listed(names: Mapping[str, list[str]]) -> str:
    """Names of parameters, once if the motions agree.

    >>> _listed({"flexion": ["a1"], "deviation": ["a1"]}), _listed({"flexion": ["a1"], "deviation": []})
    ('a1', 'a1 of palmar/dorsal flexion')
    """
    different = {tuple(n) for n in names.values()}
    if len(different) == 1:
        return ", ".join(different.pop())
    return " and ".join(f"{', '.join(n)} of {SHORT.get(m, m)}" for m, n in names.items() if n)
