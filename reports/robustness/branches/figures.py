"""Figures of the loop with the branches overlaid: Nyquist, Bode, sensitivities, describing function."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from design.controllers.pi import PI
from design.margins import winds_not
from design.open_loops import OpenLoopTransfer, open_loops
from design.robustness.predictions.describing_function import (
    centre_of,
    hysteresis_function,
    regulator_rate,
)
from design.robustness.predictions.harmonic_balance import parts, regulator_response
from design.robustness.predictions.limit_cycles import LimitCycle
from design.synthesis.requirements import Limits
from plants.wrist import Wrist
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    LINES,
    PALE,
    VERMILLION,
    new_figure,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MS_DISC = 2.0
"""Peak of the sensitivity whose disc is marked: loops that stay out of it have Ms of 2 at the most."""


RATES = {"fast": BLUE, "slow": VERMILLION}
"""Colour of the loops at each rate of the regulator; those at another rate are green."""


def frequencies(wrist: Wrist) -> Any:
    """Frequencies [rad/s] of the curves, up to nine tenths of Nyquist's."""
    return np.geomspace(3e-2, 0.9 * np.pi / wrist.rig.sample_time, 3000)


def overlaid(wrist: Wrist, controller: PI) -> dict[str, OpenLoopTransfer]:
    """The open loops that differ, by the branch and rate they belong to in words, those that are alike
    under one name; the largest slopes first.  Of a branch that effects bend, and of a rate that they change,
    the one of largest Ms: eight rates on each of six slopes are no figure."""
    omega = frequencies(wrist)
    worst: dict[tuple[str, str], OpenLoopTransfer] = {}
    for loop in sorted(open_loops(wrist, controller), key=lambda loop: _distance(loop.at(omega[::10]))):
        rate = loop.rate.partition(" x ")[0]
        worst.setdefault((loop.branch.partition(", slope ")[0], rate), replace(loop, rate=rate))
    seen: dict[bytes, list[OpenLoopTransfer]] = {}
    for loop in worst.values():
        seen.setdefault(loop.at(omega[::300]).round(12).tobytes(), []).append(loop)
    alike = sorted(seen.values(), key=lambda same: -abs(same[0].at(omega[:1])[0]))
    names = (f"{_together([x.branch for x in same])}, {same[0].rate}" for same in alike)
    return dict(zip(names, (same[0] for same in alike), strict=True))


def _distance(loop: Any) -> float:
    """Least distance of an open loop from -1, which is 1/Ms; negative where it is unstable when closed."""
    least = float(np.abs(1.0 + loop).min())
    return least if winds_not(loop[None])[0] else -1.0 / least


def _together(branches: list[str]) -> str:
    words = [b.replace("line1", "line 1").replace("line2", "line 2") for b in branches]
    return "lines 1 and 2" if words == ["line 1", "line 2"] else " and ".join(words)


def _looks(names: list[str]) -> dict[str, dict[str, Any]]:
    """Colour by the rate of the regulator and line style by place, the same in every panel and figure."""
    return {n: {**LINES[i % len(LINES)], "color": _colour(n)} for i, n in enumerate(names)}


def _colour(words: str) -> str:
    return next((c for rate, c in RATES.items() if words.endswith(rate)), GREEN)


def nyquist(wrist: Wrist, controllers: Mapping[str, PI]) -> "Figure":
    """Nyquist curves of each controller on every branch at both rates, near the point -1; the disc is
    the one that loops of Ms at most 2 stay out of.

    Raises ValueError where there is no controller.
    """
    if not controllers:
        raise ValueError("no controller to draw")
    columns = min(len(controllers), 3)
    rows = -(-len(controllers) // columns)
    looks = _looks(list(overlaid(wrist, next(iter(controllers.values())))))
    with styled():
        figure, axes = new_figure(rows, columns, height=0.9 + rows * (4.7, 3.8, 2.9)[columns - 1])
        for panel, (name, controller) in zip(axes, controllers.items(), strict=False):
            for words, loop in overlaid(wrist, controller).items():
                L = loop.at(frequencies(wrist))
                panel.plot(L.real, L.imag, label=words, **looks.get(words, LINES[0]))
            _around_minus_one(panel)
            panel.set_title(f"{name}\nKp {controller.Kp:.3g} kPa/deg\nKi {controller.Ki:.3g} kPa/(deg s)")
            panel.set_xlabel("Real part of L [1]")
        for panel in axes[len(controllers) :]:
            panel.set_visible(False)
        for row in range(rows):
            axes[row * columns].set_ylabel("Imaginary part of L [1]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _around_minus_one(axes: "Axes") -> None:
    """The point -1, the disc of Ms, the unit circle, and the region that matters."""
    from matplotlib.patches import Circle

    axes.add_patch(
        Circle((-1.0, 0.0), 1.0 / MS_DISC, facecolor=PALE, edgecolor=GREY, linewidth=0.8, zorder=1)
    )
    axes.add_patch(Circle((0.0, 0.0), 1.0, facecolor="none", edgecolor=GREY, linewidth=0.7, linestyle=DOTTED))
    axes.plot(-1.0, 0.0, "+", color=BLACK, ms=9, mew=1.6, zorder=5)
    axes.annotate("−1", (-1.0, 0.0), (-4, 5), textcoords="offset points", fontsize=8.5, ha="right")
    axes.annotate(
        f"Ms > {MS_DISC:g}", (-1.0, 0.5), (0, 3), textcoords="offset points", fontsize=8.5, color=GREY,
        ha="center", va="bottom",
    )  # fmt: skip
    axes.set(xlim=(-2.6, 1.2), ylim=(-2.8, 1.0), aspect="equal")
    axes.set(xticks=(-2, -1, 0, 1), yticks=(-2, -1, 0, 1))


def bode(wrist: Wrist, controller: PI) -> "Figure":
    """Magnitude and phase of the open loop, branches overlaid; dots: gain crossover, whose phase above -180
    deg is the phase margin."""
    with styled():
        figure, (above, below) = new_figure(2, 1, height=5.2, sharex=True)
        loops, omega = overlaid(wrist, controller), frequencies(wrist)
        looks = _looks(list(loops))
        for words, loop in loops.items():
            L = loop.at(omega)
            size, phase = np.abs(L), np.degrees(np.unwrap(np.angle(L)))
            above.plot(omega, size, label=words, **looks[words])
            below.plot(omega, phase, **looks[words])
            for at in np.flatnonzero((size[:-1] >= 1.0) & (size[1:] < 1.0)):
                for axes, value in ((above, 1.0), (below, phase[at])):
                    axes.plot(omega[at], value, "o", color=looks[words]["color"], ms=4.5, zorder=4)
        above.set(xscale="log", yscale="log", xlim=(0.1, 300.0), ylim=(1e-3, 1e2), ylabel="|L| [1]")
        above.axhline(1.0, color=GREY, linewidth=0.8)
        above.yaxis.set_major_formatter(lambda v, _: f"{v:g}")
        below.axhline(-180.0, color=GREY, linewidth=0.8)
        below.set(ylim=(-270.0, -60.0), yticks=(-270, -180, -90), ylabel="Phase of L [deg]")
        below.set_xlabel("Frequency [rad/s]")
        below.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
        figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def sensitivities(wrist: Wrist, controller: PI, limits: Limits) -> "Figure":
    """|S| and |T| over the frequency, branches overlaid, with the limit of Ms and, for the limit of the
    delay margin, what |T| may be so that no dead time up to it can matter: a sufficient bound,
    1 / |exp(-j w d) - 1| for the worst d up to the limit (small gain)."""
    with styled():
        figure, (left, right) = new_figure(1, 2, height=3.9, sharey=True)
        loops, omega = overlaid(wrist, controller), frequencies(wrist)
        looks = _looks(list(loops))
        for words, loop in loops.items():
            L = loop.at(omega)
            left.plot(omega, np.abs(1.0 / (1.0 + L)), label=words + _verdict(loop, L), **looks[words])
            right.plot(omega, np.abs(L / (1.0 + L)), **looks[words])
        if limits.Ms is not None:
            _limit(left, omega, np.full(omega.size, limits.Ms), f"limit: Ms {limits.Ms:g}")
        if limits.delay_margin_s is not None and limits.delay_margin_s > 0.0:
            turn = np.minimum(omega * limits.delay_margin_s, np.pi)
            words = f"below: {1e3 * limits.delay_margin_s:.3g} ms of\ndelay are safe"
            _limit(right, omega, 0.5 / np.sin(0.5 * turn), words)
        for axes, title, label in (
            (left, "Sensitivity S", "|S|, |T| [1]"),
            (right, "Complementary sensitivity T", ""),
        ):
            axes.set(xscale="log", yscale="log", title=title, xlim=(0.1, 300.0), ylim=(0.02, 8.0))
            axes.set(xlabel="Frequency [rad/s]", ylabel=label)
            axes.axhline(1.0, color=GREY, linewidth=0.8)
            axes.yaxis.set_major_formatter(lambda v, _: f"{v:g}")
            axes.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _verdict(loop: OpenLoopTransfer, L: Any) -> str:
    """What stands behind the name of a loop that is unstable when closed, whose S and T mean nothing."""
    stable = bool(winds_not(L[None])[0]) if loop.stable is None else loop.stable
    return "" if stable else " (unstable)"


def _limit(axes: "Axes", omega: Any, bound: Any, words: str) -> None:
    axes.plot(omega, bound, color=BLACK, linestyle=DASHED, linewidth=1.1)
    axes.text(
        0.98, 0.965, words, transform=axes.transAxes, fontsize=8.5, ha="right", va="top",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
    )  # fmt: skip


def describing(
    wrist: Wrist, controller: PI, cycles: Sequence[LimitCycle], reference: float = 0.0
) -> "Figure":
    """-1/N(A) of the hysteresis, from the transit's slope to the lines', with the Nyquist curves of the
    loop without it: at the slow rate, at the fast one, and at the rate of each limit cycle that is
    predicted, which is where its curve meets -1/N."""
    loop = wrist.hysteresis
    A = wrist.rig.half_range * np.geomspace(0.01, 2.5, 2000)
    N, _ = hysteresis_function(loop, A, centre_of(loop, A, reference))
    inverse, omega = -1.0 / N[np.abs(N) > 1e-12], frequencies(wrist)
    with styled():
        figure, (axes,) = new_figure(height=5.0)
        axes.plot(inverse.real, inverse.imag, color=BLACK, linewidth=2.2, label="−1/N(A), hysteresis")
        _amplitudes(axes, wrist, reference)
        for look, rate in zip(LINES, RATES, strict=False):
            speed = float(getattr(wrist.regulator, f"k_{rate}"))
            L = _without(wrist, controller, omega, speed)
            axes.plot(L.real, L.imag, label=f"loop without N, {rate} rate", **{**look, "color": RATES[rate]})
        for look, cycle in zip(LINES[2:], cycles, strict=False):
            _cycle(axes, wrist, controller, cycle, look)
        left = 1.25 * min(float(inverse.real.min()), -1e-6)
        axes.set(xlim=(left, -0.25 * left), ylim=(0.85 * left, 0.4 * abs(left)))
        axes.set(xlabel="Real part [kPa/deg]", ylabel="Imaginary part [kPa/deg]")
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        axes.axvline(0.0, color=GREY, linewidth=0.8)
        said = f"{len(cycles) or 'no'} limit cycle{'s' if len(cycles) > 1 else ''} predicted"
        axes.set_title(f"Kp {controller.Kp:.3g} kPa/deg, Ki {controller.Ki:.3g} kPa/(deg s): {said}")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _without(wrist: Wrist, controller: PI, omega: Any, rate: Any) -> Any:
    """Frequency response [kPa/deg] of the loop without its hysteresis, at one rate [1/s]."""
    known = parts(wrist, controller, omega)
    return (
        known.controller
        * known.command
        * known.joint
        * regulator_response(rate, known.z, wrist.rig.sample_time)
    )


def _amplitudes(axes: "Axes", wrist: Wrist, reference: float) -> None:
    """Dots at some amplitudes [kPa] on -1/N(A), those that lie apart."""
    loop, last = wrist.hysteresis, None
    for share in (0.1, 0.24, 0.3, 0.4, 0.6, 1.0):
        A = share * wrist.rig.half_range
        N, _ = hysteresis_function(loop, A, centre_of(loop, A, reference))
        at = -1.0 / N[0]
        if last is not None and abs(at - last) < 0.13 / loop.flattest:
            continue
        last = at
        aside = (-4, -12) if share < 0.28 else (-3, 6)  # off the curve, which falls at first and then rises
        axes.plot(at.real, at.imag, "o", color=BLACK, markerfacecolor="white", ms=4.5, zorder=4)
        axes.annotate(
            f"{A:g} kPa", (at.real, at.imag), aside, textcoords="offset points", fontsize=8.5, ha="right",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.3, "alpha": 0.8},
        )  # fmt: skip


def _cycle(axes: "Axes", wrist: Wrist, controller: PI, cycle: LimitCycle, look: dict[str, Any]) -> None:
    """The Nyquist curve at a cycle's own rate, and the cycle on it."""
    w, omega = cycle.frequency_rad_s, frequencies(wrist)
    rate = float(regulator_rate(wrist.regulator, cycle.amplitude_kPa * w))
    L = _without(wrist, controller, omega, rate)
    kind = "stable" if cycle.stable else "unstable"
    words = f"{kind}: {cycle.amplitude_kPa:.3g} kPa, {w:.3g} rad/s (rate {rate:.2g}/s)"
    axes.plot(L.real, L.imag, label=words, **{**look, "linewidth": 1.2})
    here = complex(_without(wrist, controller, np.array([w]), rate)[0])
    face = VERMILLION if cycle.stable else "white"
    axes.plot(
        here.real, here.imag, "D", color=BLUE, markeredgecolor=BLACK, markerfacecolor=face, ms=7, zorder=6
    )
