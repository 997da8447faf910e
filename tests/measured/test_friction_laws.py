"""Friction from a log: springs that slip, a load, plain friction, each found by the parts that it has."""

import numpy as np
import pytest

from benchmarks.real_rigs import friction
from benchmarks.real_rigs.black_box import Logged, Task, arx, error, hammerstein_wiener, sindy
from benchmarks.real_rigs.friction import ForceTask, bouc_wen, coulomb
from plants.measured.friction import ForceRun, FrictionParts, fit_friction

DT = 0.01


def wandering(seed, n=2000):
    rng = np.random.default_rng(seed)
    t = np.arange(n) * DT
    return 10.0 * np.sin(0.7 * t + seed) + 4.0 * np.sin(2.3 * t) + np.cumsum(rng.normal(0.0, 0.01, n))


def springs(x, first=0.0):
    """Force of springs that slip at a force each, step by step."""
    stiff, most = np.array([3.0, 2.0]), np.array([2.4, 6.0])
    now = first * most
    force = [now.sum()]
    for step in np.diff(x):
        now = np.clip(now + stiff * step, -most, most)
        force.append(now.sum())
    return np.array(force)


def rms(law, run):
    return np.sqrt(np.mean((law.force(run) - run.force) ** 2)) / np.ptp(run.force)


def slipping(seed):
    x = wandering(seed)
    return ForceRun(x, springs(x) + 0.5 * x)


@pytest.fixture(scope="module")
def found():
    return fit_friction([slipping(1), slipping(2)])


def test_springs_that_slip_are_found(found):
    plain = fit_friction([slipping(1), slipping(2)], [FrictionParts()])
    assert found.law.parts.presliding
    assert found.law.parts.knots == 0
    assert rms(found.law, slipping(3)) < 0.4 * rms(plain.law, slipping(3))
    assert rms(found.law, slipping(3)) < 0.03


def test_the_memory_of_a_run_is_recalled_from_its_first_rows(found):
    x = wandering(4)
    forward, back = (ForceRun(x, springs(x, side) + 0.5 * x) for side in (1.0, -1.0))
    ours = found.law.force(forward)[:20] - found.law.force(back)[:20]
    np.testing.assert_allclose(ours, (forward.force - back.force)[:20], atol=4.0)
    assert np.all(ours > 0.0)


def test_plain_friction_keeps_no_parts():
    x = wandering(5, 4000)
    run = ForceRun(x, np.zeros(4000))
    noise = np.random.default_rng(0).normal(0.0, 0.3, 4000)
    coulombs = 3.0 * np.clip(run.speed / (0.02 * np.quantile(np.abs(run.speed), 0.99)), -1.0, 1.0)
    assert fit_friction([ForceRun(x, coulombs + 0.2 * x + noise)]).law.parts == FrictionParts()


def test_an_area_is_found_from_a_load_that_hardly_changes():
    x = wandering(6)
    load = 5.0 + 0.05 * np.sin(np.arange(2000) * DT)
    run = ForceRun(x, 50.0 * load + 3.0 * np.sign(np.gradient(x)), load)
    law = fit_friction([run], [FrictionParts()]).law
    assert law.weights[0] == pytest.approx(50.0, rel=0.01)


def test_rows_that_no_weights_describe_count_little():
    run = slipping(7)
    force = run.force.copy()
    force[:60] += 80.0
    spoilt = fit_friction([ForceRun(run.displacement, force)], [FrictionParts(presliding=True)]).law
    assert rms(spoilt, slipping(8)) < 0.05


def test_nothing_to_fit_is_refused():
    with pytest.raises(ValueError, match="fewer than 10 rows"):
        fit_friction([])


def test_laws_of_the_field_find_their_own_friction():
    x = wandering(9)
    runs = [ForceRun(x, 4.0 * friction.slipping(x, 0.8, 0.6, 1.5) + 0.3 * x)]
    task = ForceTask("made by Bouc-Wen", tuple(runs), tuple(runs))
    left = {law: np.std(law(task)[0] - runs[0].force) for law in (bouc_wen, coulomb)}
    assert left[bouc_wen] < 0.1 * left[coulomb]


def known(seed):
    """A linear difference equation behind a cubic, its output measured exactly."""
    u = np.repeat(np.random.default_rng(seed).uniform(-1.0, 1.0, 60), 10)
    y = np.zeros(600)
    for i in range(1, 600):
        y[i] = 0.9 * y[i - 1] + 0.1 * (u[i - 1] + 0.8 * u[i - 1] ** 3)
    return Logged(u[:, None], y, DT)


def test_black_boxes_run_free_from_the_first_rows():
    task = Task((known(1), known(2)), (known(3),))
    assert error(task, hammerstein_wiener)["share_of_range"] < 0.02
    assert 0.02 < error(task, arx)["share_of_range"] < 0.2


def test_a_library_that_is_not_installed_has_no_error(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pysindy", None)
    task = Task((known(1),), (known(3),))
    assert error(task, sindy) == {"error": None, "why": "not installed"}
