"""The QP that the exported MPC solves has the answer of another solver, and one without an answer is told."""

from dataclasses import replace

import numpy as np
import pytest

from design.export.mpc import of_linear_mpc
from design.export.rendering import render
from design.mpc.linear import planner
from design.mpc.prediction import coefficients
from design.mpc.problem import MPCProblem, MPCWeights, robust
from tests.control.c_target import CC, WRIST, exported, needs_compiler, objects, program, run

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
    double theta[4], least, most, u = 0.0;
    while (scanf("%lf %lf %lf %lf %lf %lf", theta, theta + 1, theta + 2, theta + 3, &least, &most) == 6) {
        int code = solve(theta, least, most, theta[3], &u);
        printf("%d %.17g\\n", code, u);
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
        "q.c": MAIN,
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


def test_a_lost_sample_holds_the_command_while_the_observer_goes_on():
    n = exported("mpc")[0].name
    source = f"""
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "{n}.h"
int main(void)
{{
    {n}_measured m = {{10.0, 2.0, 120.0}}, lost;
    {n}_state s, before;
    double x = 0.0, last;
    int k, codes = 0, same = 0, moved = 0;
    {n}_init(&s, 100.0, 0.0);
    for (k = 0; k < 5; k++) codes += {n}_step(&s, &m, &x);
    last = x;
    for (k = 0; k < 3; k++) {{
        lost = m;
        if (k == 0) lost.reference_deg = NAN;
        if (k == 1) lost.angle_deg = INFINITY;
        if (k == 2) lost.pressure_kPa = NAN;
        before = s;
        codes += {n}_step(&s, &lost, &x);
        same += x == last;
        moved += memcmp(&s, &before, sizeof s) != 0 && isfinite(s.believed_plant_pressure_kPa);
    }}
    printf("%d %d %d\\n", codes, same, moved);
    return 0;
}}
""".replace("believed_plant_pressure", exported("mpc")[0].state[0].name)  # fmt: skip
    assert run(program("mpc", "lost", source)).stdout == "3 3 3\n"


def test_what_is_exported_is_the_problem_that_was_given():
    problem = replace(PROBLEMS["robust"], horizon=12)
    settings = of_linear_mpc("m", "an MPC", problem).settings
    assert settings["horizon"] == 12
    assert settings["weight move"] == problem.weights.move
    assert len(objects("mpc")) == 2
