"""Margins of wrists with effects: responses as simulated, stability as poles and python-control say."""

from dataclasses import replace
from itertools import product

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.margins import branch_responses, margins, winds_not
from design.open_loops import by_python_control
from plants import PrandtlIshlinskii, Wrist
from plants.effects import (
    Bow,
    Creep,
    DeadTime,
    DraggedInertia,
    Drift,
    HardStop,
    Hum,
    Inertia,
    Latch,
    LoadStep,
    LogCreep,
    Polynomial,
    PressureDependentRates,
    Saturation,
    SecondOrderDeadTime,
    SmoothCurve,
    SofteningByWork,
    TubeDeadTime,
    TwoRates,
    TwoTimeCreep,
    Viscous,
)
from plants.equilibrium import angles_at, at_pressure
from plants.linearisation import (
    RATES,
    branch_slope,
    branch_slopes,
    branch_ss,
    nlsys,
    responses,
    task_pressures,
)

BRANCHES = tuple(branch_slopes(Wrist.flexion()))

DT = 0.001
WRIST = Wrist.flexion()
RESPONSES = {(b.branch, b.rate): b for b in branch_responses(WRIST)}
OMEGA = np.geomspace(0.5, 300.0, 25)
GAINS = [(1.2, 2.2), (3.13, 10.4), (9.0, 27.0), (20.0, 40.0)]
Z = np.exp(1j * OMEGA * DT)


@pytest.mark.parametrize(
    "effects",
    [
        [], [DeadTime(0.1)], [DeadTime(0.0365)], [TubeDeadTime(0.03, 0.04)],
        [SecondOrderDeadTime(0.03, 0.05, 0.6)], [Creep(0.1, 0.7)],
        [TwoTimeCreep(0.06, 0.4, 0.05, 3.0)], [LogCreep(0.12, 0.02)], [Inertia(0.05)], [Inertia(0.2)],
        [DeadTime(0.05), Creep(0.1, 0.7), Inertia(0.15)], [DraggedInertia(0.1, 0.0)],
    ],
    ids=lambda e: " and ".join(x.FORM for x in e) or "declared",
)  # fmt: skip
def test_the_response_on_line_1_is_that_of_a_simulated_step(effects):
    # A regulator of one rate: the pressure rises for good, so that line 1 is never left.
    w = WRIST.with_values(k_slow=9.0, k_fast=9.0, Tw=0.08)
    for effect in effects:
        w = w + effect
    start = at_pressure(w, "line1", 110.0)
    seen = w.simulate(np.full(40_000, 120.0 / w.regulator.gain), start).angle
    size = (120.0 - 110.0) / w.regulator.gain
    impulse = np.diff(seen) / size  # the row after a command shows what it did
    k = np.arange(1, len(impulse) + 1)
    simulated = np.array([np.sum(impulse * np.exp(-1j * o * DT * k)) for o in OMEGA])
    if effects:
        (line1,) = {r.response.tobytes(): r for r in responses(w, OMEGA) if r.branch == "line1"}.values()
        ours = line1.response
    else:
        ours = control.frequency_response(branch_ss(w, "line1"), OMEGA).complex
    # Creep of many seconds is not over when the simulation ends.
    np.testing.assert_allclose(ours, simulated, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize(
    "effect", [Drift(0.1), Hum(1.0, 0.2), HardStop(-11.0, 11.0), Latch(3.0), LoadStep(1.0), Viscous(0.01)]
)
def test_effects_without_a_linear_part_leave_the_declared_responses(effect):
    for ours, declared in zip(branch_responses(WRIST + effect), branch_responses(WRIST), strict=True):
        assert (ours.branch, ours.rate) == (declared.branch, declared.rate)
        np.testing.assert_allclose(ours.response, declared.response, rtol=1e-8)


def sloped(w, pressure, line):
    """Slope [deg/kPa] of a line at a pressure, from two rests."""
    a, b = (at_pressure(w, line, pressure + d).angle for d in (-0.01, 0.01))
    return (b - a) / 0.02


@pytest.mark.parametrize(
    "effect",
    [Polynomial(0.1, 0.1), Saturation(150.0), Bow(-2.0, 3.0, 1.0), SmoothCurve(0.05, -0.04, 0.02)],
    ids=lambda e: e.FORM,
)
def test_a_curved_branch_has_the_least_and_the_largest_of_its_slopes(effect):
    w, omega = WRIST + effect, np.array([1.0])
    grid = np.linspace(*task_pressures(w), 100)
    plain = {
        b: control.frequency_response(branch_ss(WRIST, b, "slow"), omega).complex.ravel()[0] for b in BRANCHES
    }
    for line in ("line1", "line2"):
        slopes = [sloped(w, p, line) for p in grid]
        found = [r.response[0] for r in responses(w, omega) if r.branch.startswith(line) and r.rate == "slow"]
        factors = sorted((r / plain[line]).real for r in found)
        assert factors == pytest.approx(
            np.array([min(slopes), max(slopes)]) / branch_slope(w, line), rel=2e-3
        )


def test_softening_counts_fresh_and_fully_worked():
    found = responses(WRIST + SofteningByWork(0.2, 0.0, 0.5), np.array([1.0]))
    size = {
        b: [abs(r.response[0]) for r in found if r.branch.startswith(b) and r.rate == "fast"]
        for b in BRANCHES
    }
    assert {b: max(v) / min(v) for b, v in size.items()} == pytest.approx(
        {"line1": 1.2, "line2": 1.2, "transit": 1.1}
    )


@pytest.mark.parametrize(
    ("effect", "factors"),
    [
        (TwoRates(1.4), lambda low, high: {1.0, 1.4}),
        (
            PressureDependentRates(1.4, -0.3, 0.4),
            lambda low, high: {1 - 0.3 * low, 1 - 0.3 * high, 1.4 * (1 + 0.4 * low), 1.4 * (1 + 0.4 * high)},
        ),
    ],
)
def test_unequal_valves_add_rates(effect, factors):
    half = WRIST.rig.half_range
    factors = factors(*(p / half - 1.0 for p in task_pressures(WRIST)))
    found = responses(WRIST + effect, np.array([0.01]))
    assert len(found) == len(BRANCHES) * len(RATES) * len(factors)
    # A lag of rate k has the phase -omega / k: that of the slow rate tells them apart.
    declared = WRIST.regulator.k_slow
    rest = np.angle(responses(WRIST + Creep(), np.array([0.01]))[0].response[0]) + np.arctan(0.01 / declared)
    slow = [r for r in found if r.branch == "transit" and r.rate.startswith("slow")]
    rates = [0.01 / np.tan(rest - np.angle(r.response[0])) / declared for r in slow]
    assert sorted(rates) == pytest.approx(sorted(factors), rel=2e-3)


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_without_effects_winding_and_poles_agree_over_a_map_of_gains(axis):
    w = getattr(Wrist, axis)()
    Kp, Ki = (g.ravel() for g in np.meshgrid(np.geomspace(0.3, 2e4, 25), np.geomspace(0.3, 2e4, 25)))
    by_poles = np.isfinite(margins(branch_responses(w), PI(Kp, Ki)).Ms)
    by_winding = np.isfinite(margins(branch_responses(w + DeadTime(0.0)), PI(Kp, Ki)).Ms)
    assert 0 < by_poles.sum() < by_poles.size
    np.testing.assert_array_equal(by_winding, by_poles)


def delayed_system(gains, branch, rate, samples):
    """PI, a shift register and the wrist on one branch, as a discrete control.ss."""
    register = control.ss(
        np.eye(samples, k=-1), np.eye(samples)[:, :1], np.eye(samples)[-1:], [[0.0]], DT
    )  # fmt: skip
    c = gains[0] + gains[1] * control.tf([DT], [1.0, -1.0], DT)
    return control.ss(c / WRIST.regulator.gain) * register * branch_ss(WRIST, branch, rate)


@pytest.mark.slow
@pytest.mark.parametrize("gains", GAINS)
def test_behind_a_dead_time_of_100_ms_it_is_python_controls_loop_with_a_shift_register(gains):
    found = branch_responses(WRIST + DeadTime(0.1))
    rows = by_python_control(WRIST + DeadTime(0.1), PI(*gains))
    stable = []
    for response, row, place in zip(found, rows, product(BRANCHES, RATES), strict=True):
        loop = delayed_system(gains, *place, 100)
        theirs = control.frequency_response(loop, OMEGA).complex
        c = (gains[0] + gains[1] * DT / (Z - 1.0)) / WRIST.regulator.gain
        ours = c * np.interp(np.log(OMEGA), np.log(response.omega), np.abs(response.response))
        np.testing.assert_allclose(np.abs(ours), np.abs(theirs).ravel(), rtol=1e-3)
        poles = control.feedback(loop, 1).poles()
        stable.append(bool(np.abs(poles).max() < 1.0 - 1e-9))
        one = margins([response], PI(*gains))
        assert np.isfinite(float(one.Ms)) == row["stable"] == stable[-1]
        if stable[-1]:
            fine = np.geomspace(0.01, 1000.0, 3000)
            z = np.exp(1j * fine * DT)
            plant = control.frequency_response(branch_ss(WRIST, *place), fine).complex.ravel()
            L = (gains[0] + gains[1] * DT / (z - 1.0)) / WRIST.regulator.gain * plant * z**-100
            assert float(one.Ms) == pytest.approx(1.0 / np.abs(1.0 + L).min(), rel=1e-3)
            without = margins([RESPONSES[place]], PI(*gains))
            assert float(one.delay_margin_s) == pytest.approx(float(without.delay_margin_s) - 0.1, abs=1e-4)
            assert row["delay_margin_s"] == pytest.approx(float(one.delay_margin_s), rel=1e-3)
    assert all(stable) == (gains in GAINS[:2])


def test_a_loop_without_an_integrator_part_is_not_called_stable():
    assert float(margins(branch_responses(WRIST + DeadTime(0.01)), PI(1.0, 0.0)).Ms) == np.inf


def test_a_loop_that_circles_the_point_is_not_stable():
    omega = np.geomspace(0.01, 3000.0, 2000)
    for gain, stable in ((0.5, True), (0.99, True), (1.01, False), (5.0, False)):  # 8 / (s + 1)^3 at its edge
        loop = gain * 8.0 / (1j * omega + 1.0) ** 3
        assert bool(winds_not(loop[None])[0]) is stable


@pytest.mark.parametrize("effect", [Bow(0.0, 0.0, -0.2), Polynomial(0.0, -0.15), Saturation(120.0)])
def test_what_a_law_and_an_effect_do_to_the_slope_is_taken_together_where_it_meets(effect):
    # A curve that is steep where the effect is flat: the product of their extremes occurs nowhere.
    law = PrandtlIshlinskii(0.08, (0.1, 0.18), 12.0, span=8.0, b2=2.0, b1=1.5, c1=1.5, c2=2.0)
    w, omega = replace(WRIST, hysteresis=law) + effect, np.array([1e-3])
    grid = np.linspace(*task_pressures(w), 400)
    angles = {line: angles_at(w, line, grid)[1] for line in ("line1", "line2")}
    least, most = angles["line2"][0], angles["line1"][-1]  # the task goes no further
    slopes = [
        sloped(w, p, line) for line in angles for p, a in zip(grid, angles[line], strict=True)
        if least <= a <= most
    ]  # fmt: skip
    outer = [r.response[0].real for r in responses(w, omega) if r.branch.startswith("outer branch")]
    found = np.array([min(outer), max(outer)]) / w.regulator.gain
    assert found[0] <= 1.002 * min(slopes)
    assert found[1] >= 0.998 * max(slopes)
    assert found == pytest.approx([min(slopes), max(slopes)], rel=0.15)


def test_the_pressures_of_the_task_hold_its_steps_with_overshoot_and_load_and_little_more():
    w = WRIST + Polynomial(0.1, 0.1)
    rig = w.rig
    most = 1.05 * rig.task.step + rig.uncertainty.load
    ends = w.rest("line2", -most).pressure, w.rest("line1", most).pressure
    low, high = task_pressures(w)
    spacing = np.ptp(w.reach) / 200.0
    assert ends[0] - spacing <= low <= ends[0]
    assert ends[1] <= high <= ends[1] + spacing
    narrow = replace(w, rig=replace(rig, command_range=(1.5, 2.5)))
    assert task_pressures(narrow) == pytest.approx(narrow.reach)


def test_what_python_control_cannot_hold_is_refused_in_one_line():
    w = WRIST + DeadTime(0.1) + Creep(0.1)
    for make in (nlsys, lambda w: branch_ss(w, "line1")):
        with pytest.raises(
            ValueError, match=r"a wrist with dead-time, creep: no control\.\w+ of it .*; use"
        ) as no:
            make(w)
        assert "\n" not in str(no.value)
