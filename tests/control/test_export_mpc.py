"""The QP that the exported MPC solves has the answer of another solver, and one without an answer is told."""

import math
from dataclasses import replace

import numpy as np
import pytest

from design.export.formats.folder import contents
from design.export.mpc.laws import laws
from design.export.mpc.linear import of_linear_mpc
from design.export.part import Seen
from design.export.rendering import render
from design.export.vectors import TargetReplay
from design.mpc import observer
from design.mpc.formulations.linear import planner
from design.mpc.prediction import coefficients
from design.mpc.problem import MPCProblem, MPCWeights, robust
from tests.control.c_target import CC, GAINS, WRIST, exported, needs_compiler, objects, program, quick, run

pytestmark = needs_compiler

PROBLEMS = {
    "fast": MPCProblem(WRIST),
    "robust": robust(WRIST),
    "rate at its bound in most periods": MPCProblem(WRIST, rate=0.02),
    "long": MPCProblem(WRIST, horizon=60, rate=0.05),
    "hardly convex": MPCProblem(WRIST, weights=MPCWeights(move=1e-3), rate=0.1),
}

MAIN = """
#include "m.c"
#include <stdio.h>
int main(void)
{
    double theta[4], least, most, u[MOVES];
    while (scanf("%lf %lf %lf %lf %lf %lf", theta, theta + 1, theta + 2, theta + 3, &least, &most) == 6) {
        int code;
        without_bounds(theta, u);
        code = solve(u, least, most, theta[3], RATE);
        printf("%d %.17g\\n", code, u[0]);
    }
    return 0;
}
"""


def solved(problem, questions, folder):
    """Codes and first moves of the C for rows of (h, a, shift - r, was, least, most)."""
    part = of_linear_mpc("m", "an MPC", problem)
    for name, text in {
        "m.h": render("law.h.jinja", part),
        "m.c": render(part.template, part, **part.constants),
        "m_law.c": part.code,
        "q.c": MAIN.replace("RATE", repr(part.constants["rate"])),
    }.items():
        (folder / name).write_text(text)
    said = run(CC, "-std=c99", "-O2", "-Wall", "-Werror", "q.c", "m_law.c", "-lm", "-o", "q", folder=folder)
    assert said.returncode == 0, said.stderr
    (folder / "in").write_text("\n".join(" ".join(repr(float(x)) for x in row) for row in questions))
    answers = run("sh", "-c", "./q < in", folder=folder).stdout.split()
    return np.array(answers, float).reshape(-1, 2).T


def asked(rate, number=200, seed=0):
    """Random questions, some at a bound, some from beyond it."""
    draw = np.random.default_rng(seed)
    for k in range(number):
        h, a, r = draw.uniform(-20.0, 20.0, 3)
        least, most = draw.uniform(-30.0, -5.0), draw.uniform(5.0, 29.0)
        was = {0: least, 1: most + 0.9 * rate}.get(k % 5, draw.uniform(least, most))
        yield h, a, -r, was, least, most


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_first_move_is_that_of_daqp(name, tmp_path):
    problem = PROBLEMS[name]
    of, N = planner(problem, coefficients(WRIST)), problem.horizon
    questions = list(asked(of.rate))
    codes, moves = solved(problem, questions, tmp_path)
    assert (codes == 0).all()
    active = []
    for (h, a, off, was, least, most), move in zip(questions, moves, strict=True):
        f = (of.weights @ (of.free @ [h, a] + off)) @ of.forced
        f[0] -= of.move * was
        low = np.r_[np.full(N, least), was - of.rate, np.full(N - 1, -of.rate)]
        high = np.r_[np.full(N, most), was + of.rate, np.full(N - 1, of.rate)]
        found = of.solve(of.hessian, f, low, high, np.zeros(2 * N, dtype=np.int32))
        assert found.found
        assert move == pytest.approx(found.x[0], abs=1e-6)
        active.append(np.count_nonzero(found.active))
    assert max(active) >= 10  # questions without a bound that is met would ask nothing
    assert min(active) <= 3 or name in ("rate at its bound in most periods", "long", "hardly convex")


def test_bounds_that_contradict_each_other_are_told(tmp_path):
    rate = planner(PROBLEMS["fast"], coefficients(WRIST)).rate
    crossed, out_of_reach = (
        (0.0, 0.0, -5.0, 0.0, 10.0, -10.0),
        (0.0, 0.0, -5.0, -30.0, 1.1 * rate - 30.0, 99.0),
    )
    within = (0.0, 0.0, -5.0, 0.0, -9.0, 9.0)
    codes, _ = solved(PROBLEMS["fast"], [crossed, out_of_reach, within], tmp_path)
    assert codes.tolist() == [1, 1, 0]


MPCS = [k for k in GAINS if k.startswith("mpc")]


@pytest.mark.slow
@pytest.mark.parametrize("kind", MPCS)
@pytest.mark.parametrize("lost", ["reference_deg", "angle_deg", "pressure_kPa"])
def test_a_sensor_that_stays_lost_is_bridged_by_the_plan_then_by_a_pi_or_the_last_command(kind, lost):
    """All of it as `design.mpc.fallback` does; what the ladder remembers tells the rung."""
    made, _ = exported(kind)
    n, N = made.name, made.name.upper()
    rows = [(10.0, 2.0 + 0.01 * k, 120.0 + 0.1 * k) for k in range(40)]
    gone = range(8, 28)
    source = f"""
#include <math.h>
#include <stdio.h>
#include "{n}.h"
int main(void)
{{
    {n}_measured m;
    {n}_state s;
    double x = 0.0;
    int k;
    {n}_init(&s, 100.0, 0.0);
    for (k = 0; k < {len(rows)}; k++) {{
        int code;
        m.reference_deg = 10.0;
        m.angle_deg = 2.0 + 0.01 * k;
        m.pressure_kPa = 120.0 + 0.1 * k;
        if (k >= {gone[0]} && k <= {gone[-1]}) m.{lost} = NAN;
        code = {n}_step(&s, &m, &x);
        code = code == {N}_OK ? 0 : code == {N}_BAD_INPUT ? 1 : 2;
        printf("%d %d %d %.17g\\n", code, s.planned > 0.5, s.by_pi > 0.5, x);
    }}
    return 0;
}}
"""
    said = run(program(kind, f"lost_{lost}", source)).stdout.split()
    codes, planned, by_pi, outputs = np.array(said, float).reshape(-1, 4).T
    member = [f.member for f in made.inputs].index(lost)
    replay = TargetReplay(made)
    replay.begin(100.0, 0.0)
    for k, (row, output) in enumerate(zip(rows, outputs, strict=True)):
        seen = [math.nan if i == member and k in gone else x for i, x in enumerate(row)]
        assert output == pytest.approx(replay.step(Seen(*seen)), abs=1e-6), k
    assert codes.tolist() == [float(k in gone) for k in range(len(rows))]
    bridged = [k in gone and lost != "reference_deg" for k in range(len(rows))]
    below = [b and k >= gone[0] + 5 for k, b in enumerate(bridged)]
    assert planned.astype(bool).tolist() == [not b for b in below]
    assert by_pi.astype(bool).tolist() == [b and lost == "pressure_kPa" for b in below]
    if lost == "angle_deg":
        assert np.unique(outputs[gone[0] + 5 : gone[-1] + 1]).size == 1


@pytest.mark.parametrize("kind", quick(["mpc", "mpc-robust --gains 100,100,1"]))
def test_single_precision_believes_of_a_pressure_near_rest_what_double_does(kind, tmp_path):
    """Where next to nothing of the pressure's error is left its share is no quotient of two roundings."""
    made = exported(kind)[0].at("single")
    n, lack = made.name, next(f.member for f in made.state if f.name == "lack")
    seen = [(0.0, 0.0, 100.0 - 0.05 * ((7 * k) % 5)) for k in range(60)]
    source = f"""
#include <stdio.h>
#include "{n}.h"
int main(void)
{{
    {n}_state s;
    int k;
    {n}_init(&s, 100.0f, 0.0f);
    for (k = 0; k < {len(seen)}; k++) {{
        {n}_measured m = {{0.0f, 0.0f, 100.0f - 0.05f * (float)((7 * k) % 5)}};
        float x;
        {n}_step(&s, &m, &x);
        printf("%.9g\\n", (double)s.{lack});
    }}
    return 0;
}}
"""
    for name, text in (contents(made, WRIST, 60) | {"near.c": source}).items():
        (tmp_path / name).write_text(text)
    said = run(CC, "-std=c99", "-O2", "near.c", f"{n}.c", f"{n}_law.c", "-lm", "-o", "near", folder=tmp_path)
    assert said.returncode == 0, said.stderr
    told = np.array(run(tmp_path / "near").stdout.split(), float)
    replay, believed = TargetReplay(made), []
    replay.begin(100.0, 0.0)
    for row in seen:
        replay.step(Seen(*row))
        believed.append(replay.state.believed.lack)
    assert np.ptp(believed) > 0.01  # something is believed
    np.testing.assert_allclose(told, believed, atol=2e-3)


def test_what_is_exported_is_the_problem_that_was_given():
    problem = replace(PROBLEMS["robust"], horizon=12)
    settings = of_linear_mpc("m", "an MPC", problem).settings
    assert settings["horizon"] == 12
    assert settings["weight move"] == problem.weights.move
    assert len(objects("mpc")) == 2


def test_a_period_ahead_is_two_lags_behind_the_angle_that_is_aimed_at():
    """At the fast rate of the regulator and the joint's time constant, by the closed form of two lags."""
    problem = MPCProblem(WRIST)
    made = laws("m", problem, planner(problem, coefficients(WRIST)), observer.gains(problem))
    (ahead,) = (law for law in made if law.name() == "m_ahead_law")
    fast, slow, T = WRIST.regulator.k_fast, 1.0 / WRIST.Tw, problem.period
    for h, a, u in np.random.default_rng(1).uniform(-20.0, 20.0, (10, 3)):
        by_fast, by_slow = np.exp(-fast * T), np.exp(-slow * T)
        angle = u + (a - u) * by_slow + (h - u) * slow * (by_fast - by_slow) / (slow - fast)
        found = np.ravel(ahead([h, a, u]))
        np.testing.assert_allclose(found, [u + (h - u) * by_fast, angle], rtol=1e-9, atol=1e-9)
