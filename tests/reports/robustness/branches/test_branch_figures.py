"""Figures of the branches show every loop that differs, the point -1, the limits and the limit cycles."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.open_loops import by_python_control
from design.robustness.predictions.limit_cycles import predicted
from design.synthesis.requirements import Limits
from plants import Wrist
from plants.effects import Bow, DeadTime, PressureDependentRates
from reports.robustness.branches.figures import bode, describing, nyquist, overlaid, sensitivities
from reports.shared.figures.style import save

FLEXION, DEVIATION = Wrist.flexion(), Wrist.deviation()
TUNED = PI(3.13, 10.4)


def legend(figure) -> list[str]:
    return [t.get_text() for box in figure.legends for t in box.get_texts()]


def test_loops_that_are_alike_are_drawn_once():
    assert set(overlaid(FLEXION, TUNED)) == {
        "lines 1 and 2, slow", "lines 1 and 2, fast", "transit, slow", "transit, fast",
    }  # fmt: skip
    assert len(overlaid(DEVIATION, TUNED)) == 6


@pytest.mark.slow
def test_of_a_branch_that_effects_bend_the_worst_slope_and_rate_is_drawn():
    wrist = FLEXION + Bow(-2.0, 3.0, 1.0) + PressureDependentRates(1.4, -0.3, 0.4)
    rows = by_python_control(wrist, TUNED)
    assert len(rows) > 30
    drawn = overlaid(wrist, TUNED)
    assert len(drawn) == 6
    assert {words.rpartition(", ")[2] for words in drawn} == {"slow", "fast"}
    omega = np.geomspace(1e-2, 3e3, 3000)
    worst = max(float(np.max(1.0 / np.abs(1.0 + loop.at(omega)))) for loop in drawn.values())
    assert worst == pytest.approx(max(row["Ms"] for row in rows), rel=1e-3)


@pytest.mark.parametrize("wrist", [FLEXION, DEVIATION, FLEXION + DeadTime(0.05)])
def test_nyquist_has_a_panel_a_controller_with_its_loops_the_disc_and_the_point(wrist):
    figure = nyquist(wrist, {"tuned": TUNED, "paper": PI(1.2, 2.2)})
    assert legend(figure) == list(overlaid(wrist, TUNED))
    for axes, controller in zip(figure.axes, (TUNED, PI(1.2, 2.2)), strict=True):
        curves = [line for line in axes.lines if len(line.get_xdata()) > 100]
        assert len({str(c._dash_pattern) for c in curves}) == len(curves)  # told apart without colour
        for curve, loop in zip(curves, overlaid(wrist, controller).values(), strict=True):
            left, right, bottom, top = (*axes.get_xlim(), *axes.get_ylim())
            x, y = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
            assert ((x > left) & (x < right) & (y > bottom) & (y < top)).sum() > 200
            assert complex(x[0], y[0]) == pytest.approx(complex(loop.at(np.array([0.03]))[0]))
        assert any(np.allclose(line.get_xydata(), [[-1.0, 0.0]]) for line in axes.lines)
        assert any((p.center, p.radius) == ((-1.0, 0.0), 0.5) for p in axes.patches)


def test_nyquist_of_no_controller_is_refused():
    with pytest.raises(ValueError, match="no controller"):
        nyquist(FLEXION, {})


@pytest.mark.parametrize("wrist", [FLEXION, DEVIATION, FLEXION + DeadTime(0.05)])
def test_the_phase_at_crossover_is_the_phase_margin_that_python_control_finds(wrist):
    above, below = bode(wrist, TUNED).axes
    dots = [line for line in below.lines if len(line.get_xdata()) == 1]
    assert [line.get_xdata()[0] for line in above.lines if len(line.get_xdata()) == 1] == [
        dot.get_xdata()[0] for dot in dots
    ]
    drawn = {round(float(dot.get_ydata()[0]) + 180.0, 0) for dot in dots}
    margins = {round(row["phase_margin_deg"], 0) for row in by_python_control(wrist, TUNED)}
    assert len(dots) == len(overlaid(wrist, TUNED))
    assert all(min(abs(m - d) for d in drawn) <= 1.0 for m in margins)


def test_sensitivities_peak_where_the_margins_say_and_show_their_limits():
    figure = sensitivities(FLEXION, TUNED, Limits())
    left, right = figure.axes
    curves = [line for line in left.lines if len(line.get_xdata()) > 100 and line.get_color() != "#000000"]
    assert max(float(np.max(c.get_ydata())) for c in curves) == pytest.approx(1.9773, abs=2e-3)
    assert [t.get_text() for a in (left, right) for t in a.texts] == [
        "limit: Ms 2", "below: 60 ms of\ndelay are safe",
    ]  # fmt: skip
    bound = next(line for line in right.lines if line.get_color() == "#000000")
    omega = np.asarray(bound.get_xdata())
    delays = np.linspace(1e-4, 0.06, 200)
    worst = np.abs(np.exp(-1j * omega[::50, None] * delays) - 1.0).max(axis=1)  # over delays up to the limit
    np.testing.assert_allclose(np.asarray(bound.get_ydata())[::50], 1.0 / worst, rtol=2e-2)


def test_sensitivities_without_limits_show_none_and_name_what_is_unstable():
    figure = sensitivities(FLEXION, PI(0.5, 300.0), Limits(Ms=None, delay_margin_s=None))
    assert not [t for a in figure.axes for t in a.texts]
    assert any("(unstable)" in words for words in legend(figure))
    assert not any("(unstable)" in words for words in legend(sensitivities(FLEXION, TUNED, Limits())))


def test_the_describing_function_shows_cycles_where_the_curves_meet():
    figure = describing(FLEXION, PI(1.0, 40.0), predicted(FLEXION, PI(1.0, 40.0)))
    (axes,) = figure.axes
    assert [w.split(":")[0] for w in legend(figure)[-2:]] == ["unstable", "stable"]
    inverse = axes.lines[0].get_xydata()
    marks = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "D"]
    assert len(marks) == 2
    for mark in marks:
        assert np.hypot(*(inverse - mark).T).min() < 0.05
    assert "no limit cycle" in describing(DEVIATION, TUNED, predicted(DEVIATION, TUNED)).axes[0].get_title(
        loc="left"
    )


def test_they_can_be_saved_the_same_each_time(tmp_path):
    one, two = (save(nyquist(FLEXION, {"tuned": TUNED}), tmp_path / n, dpi=40) for n in ("a.png", "b.png"))
    assert one.read_bytes() == two.read_bytes()
