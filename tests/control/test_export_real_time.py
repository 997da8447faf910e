"""The C of the MPC by real-time iteration: slopes and QP are those of Python, and what fails is told."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.export.mpc.real_time import of_real_time_mpc
from design.export.rendering import render
from design.export.table import of_plays
from design.mpc import observer, qp
from design.mpc.formulations.real_time import real_time_mpc
from design.mpc.prediction import coefficients, linearise, start_of
from design.mpc.problem import MPCProblem, MPCWeights, robust
from plants.kernel import pytrees as tree
from tests.control.c_target import CC, OWN, WRIST, exported, needs_compiler, program, run

N = 12
PROBLEMS = {
    "fast": MPCProblem(WRIST, horizon=N),
    "robust": robust(WRIST, horizon=N),
    "rate at its bound in most periods": MPCProblem(WRIST, horizon=N, rate=0.02),
    "hardly convex": MPCProblem(WRIST, horizon=N, weights=MPCWeights(move=1e-3), rate=0.1),
    "of plays": MPCProblem(of_plays(WRIST), horizon=N),
}

MAIN = """
#include "m.c"
#include <stdio.h>
static int read_all(double *x, int count)
{
    int i;
    for (i = 0; i < count; i++) {
        if (scanf("%lf", x + i) != 1) return 0;
    }
    return 1;
}
int main(void)
{
    /* belief, plan, command before, reference, guess -> slopes by each command, u, code */
    double x[LEAVES], before, reference, guess[MOVES], angles[MOVES], H[MOVES * MOVES], u[MOVES];
    double room[ACTIVE][MOVES];
    int i, j, code;
    while (read_all(x, BELIEVED) && read_all(x + PLAN, MOVES) && read_all(&before, 1)
           && read_all(&reference, 1) && read_all(guess, MOVES)) {
        double off = x[SHIFT] - reference;
        (void)linearise(x, x[LACK] / GAIN, x + PLAN, off, angles, room);
        for (i = 0; i < MOVES; i++) for (j = 0; j < MOVES; j++) printf("%.17g ", room[i][j]);
        condense(room, angles, x + PLAN, before, off, H, u);
        code = factorise(H);
        divide(H, 0, u);
        for (i = 0; i < MOVES; i++) u[i] = x[PLAN + i] - u[i];
        code += solve(u, LOW, HIGH, before, RATE, guess, H, room);
        for (i = 0; i < MOVES; i++) printf("%.17g ", u[i]);
        printf("%d\\n", code);
    }
    return 0;
}
"""


def answers(problem, questions, folder):
    """Of the C for each question: J, u and the code of its QP."""
    part = of_real_time_mpc("m", "an MPC", problem)
    c = part.constants
    told = {"SHIFT": c["shift"], "LACK": c["lack"], "GAIN": c["gain"], "LOW": c["lowest"],
            "HIGH": c["highest"], "RATE": c["change"]}  # fmt: skip
    defined = "".join(f"#define {name} {value!r}\n" for name, value in told.items())
    for name, text in {
        "m.h": render("law.h.jinja", part),
        "m.c": render(part.template, part, **part.constants),
        "m_law.c": part.code,
        "q.c": defined + MAIN,
    }.items():
        (folder / name).write_text(text)
    said = run(CC, "-std=c99", "-O2", "-Wall", "-Werror", "q.c", "m_law.c", "-lm", "-o", "q", folder=folder)
    assert said.returncode == 0, said.stderr
    lines = [" ".join(repr(float(x)) for x in np.hstack(q)) for q in questions]
    (folder / "in").write_text("\n".join(lines))
    rows = np.array(run("sh", "-c", "./q < in", folder=folder).stdout.split(), float)
    rows = rows.reshape(len(lines), N * N + N + 1)
    return rows[:, : N * N].reshape(-1, N, N), rows[:, N * N : -1], rows[:, -1]


def believed(problem, draw):
    """What is believed of a wrist that was moved about, beside its model by a little."""
    c, g = coefficients(problem.wrist), observer.gains(problem)
    belief = observer.begin(0.0, 100.0, problem.wrist)
    for command in draw.uniform(0.5, 3.5, draw.integers(0, 6)):
        pressure = belief.plant.pressure + draw.uniform(-20.0, 20.0)
        belief = observer.update(belief, command, Measured(0.0, draw.uniform(-15.0, 15.0), pressure), g, c)
    return belief


def asked(problem, number=60, seed=0):
    """Belief, plan, command before, reference, guess: a plan about the command, at a bound, or anywhere."""
    draw = np.random.default_rng(seed)
    for k in range(number):
        before = draw.uniform(problem.low, problem.high)
        steps = draw.uniform(-problem.rate, problem.rate, N) * [0.0, 0.3, 1.0][k % 3]
        plan = np.clip(before + np.cumsum(steps), problem.low, problem.high)
        guess = [plan, np.full(N, 2.0), draw.choice([problem.low, 2.0, problem.high], N)][k % 3]
        yield believed(problem, draw), plan, before, draw.uniform(-25.0, 25.0), guess


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("name", PROBLEMS)
def test_slopes_and_the_answer_of_the_QP_are_those_of_Python(name, tmp_path):
    """Whatever active set is guessed first."""
    problem = PROBLEMS[name]
    questions = list(asked(problem))
    J, moves, codes = answers(problem, [(tree.leaves(b), *rest) for b, *rest in questions], tmp_path)
    assert (codes == 0).all()
    c, solve, active = coefficients(problem.wrist), qp.solver(problem.differences), []
    for (belief, plan, before, reference, _), slopes, u in zip(questions, J, moves, strict=True):
        about = linearise(
            problem, c, problem.stage_weights, problem.move_hessian, start_of(belief), belief.lack, plan
        )
        np.testing.assert_allclose(slopes.T, about.by_command, atol=1e-9)
        missing = about.angles - about.by_command @ plan + belief.shift - reference
        f = (problem.angle_hessian @ missing) @ about.by_command
        f[0] -= problem.weights.move * before
        found = solve(about.hessian, f, *problem.bounds(before), np.zeros(2 * N, dtype=np.int32))
        assert found.found
        np.testing.assert_allclose(u, found.x, atol=1e-5)
        active.append(np.count_nonzero(found.active))
    assert max(active) >= 5  # questions without a bound that is met would ask nothing
    assert np.abs(J).max() > 1.0


@needs_compiler
def test_a_plan_without_an_answer_is_gone_on_with_and_said_so():
    made, _ = exported("mpc-real-time")
    n = made.name
    source = f"""
#include <math.h>
#include <stdio.h>
#include "{n}.h"
int main(void)
{{
    {n}_measured m = {{10.0, 0.0, 100.0}};
    {n}_state s;
    double x = 0.0, next;
    int codes = 0, k;
    {n}_init(&s, 100.0, 0.0);
    for (k = 0; k < 3; k++) codes += {n}_step(&s, &m, &x);
    next = s.plan_V[0];
    s.plan_V[3] = 1e300; /* as after a bit flipped in memory */
    printf("%d %d", codes, {n}_step(&s, &m, &x));
    printf(" %d", x == next);
    s.plan_V[0] = NAN;
    next = x;
    printf(" %d", {n}_step(&s, &m, &x));
    printf(" %d %d %d", s.by_pi > 0.5, s.planned > 0.5, fabs(x - next) < 1e-12);
    printf(" %d", {n}_step(&s, &m, &x));
    printf(" %d %d\\n", s.by_pi > 0.5, s.planned > 0.5);
    return 0;
}}
"""
    # The plan of before, then a PI that begins without a jump, then a plan again.
    assert run(program("mpc-real-time", "flipped", source)).stdout == "0 2 1 2 1 0 1 0 0 1\n"


def test_a_plan_that_stays_in_the_dead_zone_is_left_with_and_without_a_preparation():
    controller = real_time_mpc(MPCProblem(WRIST))
    at_rest = Measured(0.0, 0.0, 100.0)
    state, held, _ = controller.step(controller.init(at_rest), at_rest)
    assert state.plan == pytest.approx(held)
    for prepared in (state.prepared, None):
        # A plan for this reference that was found to stay where it is: nothing jumps.
        before = state._replace(prepared=prepared, reference=5.0)
        assert controller.attempt(before, state.believed, 5.0).command > held + 0.1


def test_a_plan_is_stuck_where_the_angle_that_is_measured_stays_away():
    """Which is that of the plant that is believed, and what it lacks."""
    controller = real_time_mpc(MPCProblem(WRIST))
    believed = observer.begin(0.0, 100.0, WRIST)._replace(shift=2.0)
    there = SimpleNamespace(states=[tree.leaves(believed.plant)])
    assert not controller._stuck(there, believed, 2.0)
    assert controller._stuck(there, believed, -2.0)


def test_what_is_exported_is_the_problem_that_was_given():
    problem = replace(PROBLEMS["robust"], horizon=7)
    part = of_real_time_mpc("m", "an MPC", problem)
    assert part.settings["horizon"] == 7
    assert part.settings["weight move"] == problem.weights.move
    assert {f.name: f.size for f in part.state}["plan"] == 7


@needs_compiler
def test_the_stack_that_is_told_is_about_what_the_compiler_gives_its_functions():
    made, folder = exported("mpc-real-time")
    said = run(CC, "-std=c99", "-O2", "-fstack-usage", "-c", f"{made.name}.c", "-o", "usage.o", folder=folder)
    usage = [*folder.glob("*usage*.su"), *folder.glob(f"{made.name}*.su")]
    if said.returncode or not usage:
        pytest.skip("this compiler tells no stack")
    sizes = [int(line.split("\t")[1]) for line in usage[0].read_text().splitlines()]
    told = re.search(r"about\s+(\d+)\s+kB\s+of\s+stack", (folder / "README.md").read_text())
    assert told is not None
    # The large ones stand in one chain of calls: a step, an attempt, and the solver or the slopes.
    assert float(told[1]) == pytest.approx(sum(s for s in sizes if s > 500) / 1000.0, rel=0.15)


@needs_compiler
def test_the_stack_that_a_step_takes_is_what_is_said(tmp_path):
    """Of the compiler's own count: a step calls one of the three largest functions within another."""
    made, folder = exported("mpc-real-time")
    counted = run(CC, *OWN, "-fstack-usage", "-c", f"{made.name}.c", "-o", tmp_path / "m.o", folder=folder)
    if counted.returncode:
        pytest.skip("this compiler does not count stacks (-fstack-usage)")
    frames = sorted(int(line.split("\t")[1]) for line in (tmp_path / "m.su").read_text().splitlines())
    said = re.search(r"takes about (\d+) kB of stack", " ".join((folder / "README.md").read_text().split()))
    assert int(said[1]) == pytest.approx(sum(frames[-3:]) / 1000.0, rel=0.05)
