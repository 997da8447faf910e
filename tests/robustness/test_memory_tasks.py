"""Runs of the tasks come to where the loop decays; where they do not, nothing is said of them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import run as simulated
from design.evaluation.tasks import comparison_tasks
from design.robustness.box import box_of
from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.memory.form import LineForm
from design.robustness.certificates.memory.ladder import certify_memory, for_tasks, lines_of
from design.robustness.certificates.memory.loop import FixedLawLoop, Plants, growth_of
from design.robustness.certificates.memory.programme import Visited, _at, _unscaled, line, sizes
from design.robustness.certificates.memory.region import _states, arrivals, level
from design.robustness.certificates.memory.runs import Runs, run
from design.robustness.certificates.memory.unknowns import MemoryUnknowns
from design.robustness.certificates.reasons import NotOnePlay, UnstableMode
from design.robustness.certificates.statements import of_tasks
from design.robustness.loop_model import LoopModel
from design.status import Status
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime
from plants.hysteresis import PrandtlIshlinskii, RoughLoop
from plants.parameters.files import built_in
from plants.simulation.disturbance import burdened

WRISTS = {"flexion": Wrist.flexion(), "deviation": Wrist.deviation()}


def certified(wrist: Wrist, Kp: float, Ki: float, dead_time: float) -> Certificate:
    pi = PI.of(wrist, Kp, Ki)
    return certify_memory(LoopModel.of(wrist, pi), wrist, pi, (dead_time,))[1]


@cache
def played(wrist: Wrist, Kp: float, Ki: float, samples: int) -> tuple[FixedLawLoop, Runs]:
    pi = PI.of(wrist, Kp, Ki)
    model = LoopModel.of(wrist, pi)
    return FixedLawLoop.of(model, samples), run(wrist, pi, comparison_tasks(wrist.rig), samples, model.dt)


@pytest.mark.parametrize("samples", [0, 20])
def test_what_a_function_is_made_small_at_is_what_it_is_worth_there(samples: int) -> None:
    """In numbers that are sought, of states on the line and off it, over the square of the size of e."""
    loop = FixedLawLoop.of(LoopModel.of(WRISTS["flexion"], PI(2.0, 6.0)), samples)
    n, draw = loop.states, np.random.default_rng(samples)
    u = MemoryUnknowns(n, forms=2, numbers=n + 1)
    on, far, cross, gap = u.form(), u.form(), u.vector(n), u.number()
    scale = sizes(loop)
    w, F = scale[:n] * draw.normal(size=(40, n)), scale[n] * np.repeat([0.0, 0.7], 20)
    seen = Visited(w, (draw.uniform(size=40) * scale[-1] ** 2, draw.uniform(size=40) * scale[-1] ** 2), F)
    for x in draw.uniform(0.1, 1.0, (10, u.count)):
        one, other = (_unscaled(loop, form, x) for form in (on, far))
        line_form = LineForm(
            one, other, x @ cross / (scale[:n] * scale[n]), float(x @ gap) / scale[n] ** 2, (), (), (), 0.1
        )
        worth = level(line_form, loop, seen.w, seen.window, seen.F)
        sought = np.maximum(x @ _at(loop, on, seen, cross, gap), x @ _at(loop, far, seen))
        np.testing.assert_allclose(sought * scale[0] ** 2, worth, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("motion", WRISTS)
@pytest.mark.parametrize("gains", [(1.2, 2.2), (2.0, 6.0)])
def test_tasks_come_to_half_the_rate_of_the_slowest_pole_behind_50_ms(
    motion: str, gains: tuple[float, float]
) -> None:
    found = certified(WRISTS[motion], *gains, 0.05)
    tasks = found.evidence["tasks"]
    assert found.holds
    assert tasks["covered"]
    assert tasks["decay"] == pytest.approx(0.5 * found.evidence["slowest_pole_1_s"])
    assert found.decay is not None
    assert tasks["decay"] <= found.decay <= found.evidence["slowest_pole_1_s"]
    (statement,) = of_tasks([found], 15.0)
    assert statement.status is Status.PROVED


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "gains", "samples"), [("flexion", (2.0, 6.0), 50), ("deviation", (3.13, 10.4), 0)]
)
def test_from_where_a_run_arrives_it_meets_no_other_line_and_decays_as_claimed(
    motion: str, gains: tuple[float, float], samples: int
) -> None:
    wrist = WRISTS[motion]
    loop, runs = played(wrist, *gains, samples)
    law, decay = wrist.hysteresis, 0.1
    forms = for_tasks(loop, law, lines_of(loop.plants, law), runs, decay)
    for side, form in forms.items():
        found = arrivals({side: form}, loop, law, runs)
        for lane in np.flatnonzero(np.isfinite(found.time)):
            begin = runs.begins[lane] + round(found.time[lane] / loop.model.dt)
            P, h, r = (x[begin:, lane] for x in (runs.pressure, runs.static, runs.reference))
            other = law.descending(P) - h if side == "ascending" else h - law.ascending(P)
            assert (other > 1e-6).all()
            assert not runs.clipped[begin:, lane].any()
            fades = found.error * np.exp(-decay * loop.model.dt * np.arange(len(h)))
            assert (np.abs(h - r) <= fades + 1e-9).all()


def test_runs_are_those_of_the_simulator() -> None:
    wrist, pi = WRISTS["flexion"], PI.of(WRISTS["flexion"], 5.0, 40.0)
    _, runs = played(wrist, 5.0, 40.0, 50)
    late = burdened(wrist, 0.05, None)
    for lane, task in enumerate(comparison_tasks(wrist.rig)[:8]):
        _, _, went = simulated(late, pi, task.references[0], late.rest(task.start, 0.0), record=True)
        assert went is not None
        samples = len(went.angle)
        assert np.allclose(runs.angle[:samples, lane], went.angle[:, 0], atol=1e-9)
        assert np.allclose(runs.static[:samples, lane], went.static_angle[:, 0], atol=1e-9)
    assert runs.clipped.any(axis=0).all()


def test_states_of_runs_and_what_is_under_way_are_those_written_out() -> None:
    loop, runs = played(WRISTS["flexion"], 2.0, 6.0, 5)
    dt, N, decay = loop.model.dt, 5, 0.3
    at, growth = np.array([0, 3, 40, 700]), float(growth_of(decay, dt))
    w, (squares, weighted) = _states(loop, runs, at, decay)
    table = np.asarray(loop.window.table, float)
    for row, k in enumerate(at.tolist()):
        for lane in (0, 5, len(runs.names) - 1):
            given = [float(runs.rest[lane])] * (N + 1) + runs.command[: k + 1, lane].tolist()
            late = [(given[-i] - given[-i - 1]) / dt * growth**-i for i in range(1, N + 1)]
            angle, reference = runs.angle[k, lane], runs.reference[k, lane]
            q = given[-N - 1] - runs.pressure[k, lane]
            moments = [np.dot(of[:N], late) / N for of in table]
            expected = [reference - angle, runs.static[k, lane] - angle, q, *moments]
            np.testing.assert_allclose(w[row, lane], expected, rtol=1e-9, atol=1e-12)
            assert squares[row, lane] == pytest.approx(dt * np.sum(np.square(late)))
            ages = [(N + 1 - i) * dt for i in range(1, N + 1)]
            assert weighted[row, lane] == pytest.approx(dt * np.dot(ages, np.square(late)))
    assert np.count_nonzero(weighted) > 10


def test_a_level_is_the_larger_of_two_functions_and_grows_with_what_the_law_may_hold() -> None:
    loop, runs = played(WRISTS["flexion"], 2.0, 6.0, 5)
    form = line(loop, (0.36,), 0.1).form
    assert form is not None
    w, window = _states(loop, runs, np.array([40, 300]), form.decay)
    for F in (0.0, 2.0):
        found = level(form, loop, w, window, np.full(w.shape[:2], F))
        for k, lane in ((0, 0), (1, 3)):
            x, values = w[k, lane], []
            for of in (form.line, form.transit):
                held = of.S * window[0][k, lane] + of.R * window[1][k, lane]
                values.append(x @ of.P @ x + held + 2.0 * of.popov * loop.sector * x[2] ** 2)
            values[0] += 2.0 * F * float(x @ form.cross) - form.gap * F**2
            assert found[k, lane] == pytest.approx(max(values), rel=1e-9)


@pytest.mark.slow
def test_runs_that_are_clipped_at_first_arrive_too() -> None:
    tasks = certified(WRISTS["flexion"], 10.0, 30.0, 0.0).evidence["tasks"]
    assert tasks["covered"]
    assert tasks["clipped"] == tasks["runs"]


@pytest.mark.slow
def test_a_loop_that_hunts_is_not_covered_though_every_branch_is_stable() -> None:
    """A flat transit and a strong integral: the swing lasts, as 40 s of simulation show."""
    wrist = WRISTS["flexion"].with_values(s=0.001)
    pi = PI.of(wrist, 0.5, 10.0)
    _, _, went = simulated(wrist, pi, 15.0, wrist.rest("line1"), duration=40.0, record=True)
    assert went is not None
    assert np.ptp(went.angle[-10_000:, 0]) > 0.3
    found = certified(wrist, 0.5, 10.0, 0.0)
    assert not found.evidence.get("tasks", {"covered": False})["covered"]
    for statement in of_tasks([found], 15.0):
        assert statement.status is Status.OPEN


def test_a_limit_cycle_is_disproved() -> None:
    for found in certify_memory(
        LoopModel.of(WRISTS["flexion"], PI(1.0, 40.0)), WRISTS["flexion"], PI(1.0, 40.0), (0.0, 0.05)
    ):
        assert found.status is Status.DISPROVED
        assert isinstance(found.reason, UnstableMode)


def test_a_law_of_many_plays_has_no_line() -> None:
    wrist = WRISTS["flexion"]
    rough = RoughLoop.of_equal_plays(0.36, 0.08, 20.0, 100.0, 20.0, 180.0)
    law = PrandtlIshlinskii.from_values(PrandtlIshlinskii.guess(rough))
    other = replace(wrist, hysteresis=law)
    assert lines_of(Plants.of(LoopModel.of(other, PI(1.2, 2.2))), law) == {}
    assert isinstance(certified(other, 1.2, 2.2, 0.0).reason, NotOnePlay)


@pytest.mark.suite
def test_the_plants_own_dead_time_and_that_beside_it_add_up() -> None:
    wrist = WRISTS["flexion"]
    late = certified(wrist + DeadTime(0.03), 2.0, 6.0, 0.02)
    same = certified(wrist, 2.0, 6.0, 0.05)
    assert late.decay == same.decay
    assert late.evidence["tasks"]["latest_s"] == same.evidence["tasks"]["latest_s"]


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["flexion", pytest.param("deviation", marks=pytest.mark.suite)])
def test_every_plant_of_the_assumed_box_decays_at_half_the_slowest_rate_behind_50_ms(motion: str) -> None:
    wrist, box = WRISTS[motion], box_of(built_in(motion))
    pi = PI.of(wrist, 1.6, 4.0)
    *_, found = certify_memory(LoopModel.of(wrist, pi), wrist, pi, (0.05,), box)
    assert found.about is not None
    assert found.about.lag == box.bounds("Tw")
    assert found.about.slopes == pytest.approx((0.9 * wrist.hysteresis.s, 1.1 * wrist.hysteresis.a1))
    assert found.about.rates == pytest.approx((0.8 * 0.55, 1.2 * 9.0))
    assert found.decay is not None
    assert found.decay > 0.5 * found.evidence["slowest_pole_1_s"]


@pytest.mark.slow
def test_a_box_with_a_plant_that_does_not_decay_has_no_function() -> None:
    wrist, pi = WRISTS["flexion"], PI.of(WRISTS["flexion"], 1.0, 16.0)
    slow = LoopModel.of(wrist.with_values(Tw=0.4), pi)
    assert max(np.linalg.eigvals(slow.matrix(0.36, 0.55)).real) > 0.0
    box = box_of(built_in("flexion"), given={"Tw": (0.16, 0.4)})
    _, alone, found = certify_memory(LoopModel.of(wrist, pi), wrist, pi, (0.0,), box)
    assert alone.holds
    assert found.status is Status.OPEN


@pytest.mark.suite
def test_what_is_covered_comes_to_rest_and_what_swings_for_long_is_not_covered() -> None:
    """Gains, flatness of the transit and dead time at random: 40 s of each."""
    random, covered, swinging = np.random.default_rng(5), 0, 0
    for case in range(16):
        flat = (-3.0, -2.5) if case % 2 else (-2.0, -1.0)
        wrist = WRISTS["flexion"].with_values(s=float(10.0 ** random.uniform(*flat)))
        Kp, Ki = (float(10.0 ** random.uniform(*of)) for of in ((-0.5, 0.5), (0.6, 1.2)))
        pi, samples = PI.of(wrist, Kp, Ki), int(random.choice([0, 50, 150]))
        model = LoopModel.of(wrist, pi)
        tasks = [replace(t, holds=(40.0,)) for t in comparison_tasks(wrist.rig)[:4]]
        runs = run(wrist, pi, tasks, samples, model.dt)
        loop, rate = FixedLawLoop.of(model, samples), 0.1 * model.k_slow * wrist.hysteresis.s * Ki
        forms = for_tasks(loop, wrist.hysteresis, lines_of(loop.plants, wrist.hysteresis), runs, rate)
        if not forms:
            continue
        found = arrivals(forms, loop, wrist.hysteresis, runs)
        late = np.abs(runs.static - runs.reference)[-5000:].max(axis=0)
        fades = found.error * np.exp(-rate * (35.0 - found.time))
        assert (late <= fades + 1e-9)[np.isfinite(found.time)].all()
        covered += int(found.all)
        swinging += int((late > 0.2).any() and not found.all)
    assert covered >= 4
    assert swinging >= 1
