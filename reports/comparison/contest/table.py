"""The broad comparison on a page: tables with paired intervals and ranks, and the differences as a figure."""

from typing import TYPE_CHECKING, Any

import numpy as np

from design.comparison.compare import TUNED, Comparison
from design.contest.scores import BESIDE, BOTH, Contest, Score
from design.contest.statistics import FEWEST, LEVEL, ConfidenceInterval
from design.evaluation.tasks import lasts
from reports.shared.figures.style import BLACK, GREY, controller_line, new_figure, styled
from reports.shared.names import name_of, title_of
from reports.shared.tables import Cell, Column, Group, Table, fixed, listed, row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAIN = ("perturbed plants", "steps")
"""Field and family of the table that stands in the open; the others are folded."""

CAPTION = (
    "Steps of 15 deg on the perturbed plants: mean difference of the IAE to that of the recommended PI on "
    f"the same plants, with its {100 * LEVEL:g} % interval; an arrow where it is beyond the axis."
)


def differences_caption(found: Contest, nominal: Comparison) -> str:
    """How many controllers have less error than the recommended PI, which of these break a limit on the
    nominal plant, and what is drawn."""
    said = []
    for motion in _motions(found):
        others = [s for s in found.of(motion, *MAIN) if s.controller != TUNED]
        less = [s.controller for s in others if s.against["iae_deg_s"].high < 0.0]
        broken = {s.controller for s in nominal.standings if s.motion == motion and s.breaks}
        beyond = [name_of(n) for n in less if n in broken]
        but = f" ({listed(beyond)} break{'s' * (len(beyond) == 1)} limits)" if beyond else ""
        said.append(f"{motion}: {len(less)} of {len(others)} controllers{but}")
    return f"Less error than the recommended PI, the interval below zero: {'; '.join(said)}. {CAPTION}"


def _motions(found: Contest) -> list[str]:
    """The motions that have the main table."""
    return [m for m, field, family in found.tables if (field, family) == MAIN]


def main_table(found: Contest, overshoot: float | None) -> Table:
    """The steps on the perturbed plants, and both motions at once; overshoot beyond the limit is marked."""
    keys = [k for k in found.tables if is_main(k)]
    return _table(found, keys, overshoot)


def is_main(key: tuple[str, str, str]) -> bool:
    """Whether a table (motion, field, family) is of steps on perturbed plants, or of both motions."""
    motion, field, family = key
    return motion == BOTH or (field.removesuffix(BESIDE), family) == MAIN


def _table(found: Contest, keys: list[tuple[str, str, str]], overshoot: float | None) -> Table:
    groups = []
    for motion, field, family in keys:
        scores = found.of(motion, field, family)
        aside = found.set_aside.get((motion, field), 0)
        plants = f"{scores[0].plants} plant{'s' * (scores[0].plants != 1)}"
        plants += f", {aside} set aside as out of reach" if aside else ""
        heading = (
            f"{'Both motions at once' if motion == BOTH else title_of(motion)}: {field}, {family} ({plants})"
        )
        lasting = lasts("side by side", found.rig)
        shown = _not_above(found, (motion, field, family), scores)
        rows = tuple(_row(s, overshoot, lasting) for s in shown)
        groups.append(
            Group(heading, rows, tuple(i for i, s in enumerate(shown) if s.controller == found.reference))
        )
    columns = (
        Column("Controller", number=False), Column("IAE", "deg s"),
        Column("minus recommended PI", "deg s"), Column("Rank", "1"), Column("Settling", "s"),
        Column("minus recommended PI", "s"), Column("Rank", "1"), Column("95 % settle in", "s"),
        Column("Not settled", "%"),
        Column("Overshoot", "%"), Column("Total variation", "V"), Column("Pressure travel", "kPa"),
    )  # fmt: skip
    return Table(columns, tuple(groups))


def _not_above(found: Contest, key: tuple[str, str, str], scores: list[Score]) -> list[Score]:
    """The scores that a table shows: on the few plants of the MPCs, these and the reference alone, since the
    table above has the others on all plants."""
    motion, field, family = key
    above = (motion, field.removesuffix(BESIDE), family)
    if not field.endswith(BESIDE) or above not in found.tables:
        return scores
    others = {s.controller for s in found.of(*above)} - {found.reference}
    return [s for s in scores if s.controller not in others]


def _row(s: Score, overshoot: float | None, lasting: float) -> tuple[Cell, ...]:
    m = s.mean
    beyond = overshoot is not None and m["overshoot_percent"] > overshoot
    return row(
        name_of(s.controller), fixed(m["iae_deg_s"], 2), _difference(s.against["iae_deg_s"]),
        _rank(s, "iae_deg_s"), fixed(m["settling_time_s"], 2), _difference(s.against["settling_time_s"]),
        _rank(s, "settling_time_s"),
        fixed(s.settling_q95, 2) if s.settling_q95 < lasting else f"> {lasting:g}",
        fixed(100.0 * m["unsettled"], 0),
        Cell(fixed(m["overshoot_percent"], 1), "", beyond),
        fixed(m["total_variation_V"], 1), fixed(m["pressure_travel_kPa"], 0),
    )  # fmt: skip


def _difference(i: ConfidenceInterval) -> Cell:
    if i.low == i.high == 0.0:
        return Cell("–")
    text = f"+{fixed(i.mean, 2)}" if i.mean > 0.0 else fixed(i.mean, 2)
    return Cell(text, f"{fixed(i.low, 2)} to {fixed(i.high, 2)}" if np.isfinite(i.low) else "")


def _rank(s: Score, metric: str) -> str:
    if s.plants < FEWEST:
        return "–"
    best, worst = s.ranks[metric]
    return f"{best}" if best == worst else f"{best} to {worst}"


def _less(found: Contest) -> str:
    """Where a loop allows only a share of the spread, in words."""
    parts = [f"{100 * share:g} % of it for {motion}" for motion, share in found.spread.items() if share < 1.0]
    return f" ({' and '.join(parts)}, since its lines would cross with more)" if parts else ""


def differences_figure(found: Contest) -> "Figure":
    """Paired differences of the IAE on the perturbed plants, one panel a motion."""
    motions = _motions(found)
    with styled():
        most = max(len(found.of(m, *MAIN)) for m in motions)
        figure, axes = new_figure(1, len(motions), height=0.9 + 0.22 * most, sharey=True)
        for panel, motion in zip(axes, motions, strict=True):
            _panel(panel, found.of(motion, *MAIN))
            panel.set(title=title_of(motion), xlabel="IAE difference [deg s]")
    return figure


def _panel(axes: "Axes", scores: list[Score]) -> None:
    shown = [s for s in scores if s.controller != TUNED]
    means = np.array([s.against["iae_deg_s"].mean for s in shown])
    # One that is far behind would press all others into a corner.
    reach = 1.6 * float(np.quantile(np.abs(means), 0.7)) if means.size else 1.0
    axes.grid(axis="y", visible=False)
    axes.axvline(0.0, color=BLACK, linewidth=0.9)
    for place, s in enumerate(shown):
        i, look = s.against["iae_deg_s"], controller_line(s.controller, place)
        bar: dict[str, Any] = {"color": look["color"], "linewidth": 2.2, "solid_capstyle": "butt"}
        if abs(i.mean) > reach:
            side, signed = float(np.sign(i.mean)), f"{i.mean:+.1f}".replace("-", "−")
            axes.plot(side * reach, place, ">" if side > 0.0 else "<", color=look["color"], ms=7)
            axes.annotate(
                signed, (side * reach, place), (-8 * side, 0), textcoords="offset points",
                ha="right" if side > 0.0 else "left", va="center", fontsize=8.5, color=GREY,
            )  # fmt: skip
            continue
        axes.plot([i.low, i.high], [place, place], **bar)
        axes.plot(i.mean, place, "o", color=look["color"], ms=5)
    axes.set_yticks(range(len(shown)), [name_of(s.controller) for s in shown])
    axes.set(xlim=(-1.1 * reach, 1.1 * reach), ylim=(len(shown) - 0.5, -0.5))


def how(found: Contest) -> list[str]:
    """How the contest was played, in sentences."""
    c, rig = found.conditions, found.rig
    band = f"{rig.task.band * rig.task.step:g} {rig.units.angle}"
    lasting = f"{lasts('side by side', rig):g} s"
    return [
        f"{found.plants} plants of each motion, drawn within the day-to-day spread or two standard errors, "
        f"whichever is wider{_less(found)}; the same plants for every controller; none was used in tuning. "
        "Sensor: "
        f"white noise of {c.noise:g} deg, held for 10 ms, quantised to {c.quantum:g} deg. The pressure is "
        "measured without noise.",
        "Per plant: mean IAE, worst settling time and overshoot over the tasks of a family; not settled "
        f"within ±{band} counts as {lasting}. Paired {100 * LEVEL:g} % intervals: bootstrap over the plants "
        f"(BCa); fewer than {FEWEST} plants give neither interval nor rank.",
        f"“{BESIDE.strip(', ')}”: the MPCs are slow to simulate and run on the first plants only. Their "
        "weights are not tuned on scenarios. Ranks are among all controllers on these plants, which "
        "contest.csv lists.",
    ]
