"""The C of a controller keeps its state in the caller's struct alone, and a lost sample does not touch it."""

import shutil

import pytest

from tests.control.c_target import CC, GAINS, exported, needs_compiler, objects, program, quick, run

pytestmark = needs_compiler

OUTSIDE = {"fmax", "fmin", "exp", "log", "fabs", "sqrt", "memcpy", "memset", "memmove"}
OUTSIDE |= {
    "_GLOBAL_OFFSET_TABLE_",
    "__stack_chk_fail",
}  # of position independent code, of hardened compilers
"""What an object may want of others; no allocation, no files."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", GAINS)
@pytest.mark.skipif(shutil.which("nm") is None, reason="no nm on this machine")
def test_no_allocation_and_no_writable_data(kind):
    _, folder = exported(kind)
    for name in objects(kind):
        for line in run("nm", "-P", name, folder=folder).stdout.splitlines():
            symbol, sort = line.split()[:2]
            assert sort not in "bBdDgGsSC", line  # writable: zero, initialised, small, common
            assert sort != "U" or symbol.startswith("flexion_") or symbol in OUTSIDE, line


def inputs(kind, values):
    """Statements that set what is measured."""
    made, _ = exported(kind)
    return " ".join(f"m.{f.member} = {v};" for f, v in zip(made.inputs, values, strict=False))


def around(kind, declarations, body):
    """A program that includes the header of a controller."""
    made, _ = exported(kind)
    return f"""
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "{made.name}.h"
int main(void)
{{
    {made.name}_measured m;
    {declarations}
    {body}
    return 0;
}}
"""


@pytest.mark.parametrize("kind", quick(GAINS))
def test_two_joints_do_not_know_of_each_other(kind):
    n = exported(kind)[0].name
    mine = inputs(
        kind, ["10.0 * sin(0.005 * k)", "8.0 * sin(0.005 * k - 0.2)", "100.0 + 30.0 * sin(0.005 * k)"]
    )
    other = inputs(kind, ["-20.0", "0.01 * k", "90.0"])
    source = around(
        kind,
        f"{n}_state alone, one, two; double a = 0.0, b = 0.0, c = 0.0; int k, apart = 0;",
        f"""
    memset(&alone, 0, sizeof alone);
    memset(&one, 255, sizeof one);
    {n}_init(&alone, 100.0, 0.0);
    {n}_init(&one, 100.0, 0.0);
    {n}_init(&two, 80.0, -1.0);
    for (k = 0; k < 2000; k++) {{
        {mine}
        {n}_step(&alone, &m, &a);
    }}
    for (k = 0; k < 2000; k++) {{
        {mine}
        {n}_step(&one, &m, &b);
        {other}
        {n}_step(&two, &m, &c);
        apart += b != c;
    }}
    printf("%d %d %d\\n", a == b, apart > 1000, isfinite(c) != 0);""",
    )  # fmt: skip
    assert run(program(kind, "two", source)).stdout == "1 1 1\n"


@pytest.mark.parametrize("kind", [k for k in GAINS if not k.startswith("mpc")])  # whose observer goes on
@pytest.mark.parametrize("lost", ["NAN", "INFINITY", "-INFINITY"])
def test_a_lost_sample_holds_the_output_and_leaves_the_state(kind, lost):
    made, _ = exported(kind)
    n = made.name
    good = inputs(kind, ["5.0", "1.0", "110.0"])
    # How long ago a reading was believed is counted on.
    ages = " ".join(f"s.{w.age} = before.{w.age}; s.{w.last} = before.{w.last};" for w in made.watched)
    each = "".join(
        f"{good} m.{f.member} = {lost}; x = 99.0; codes += {n}_step(&s, &m, &x) == {n.upper()}_BAD_INPUT; "
        f"same += x == last; {ages} whole += memcmp(&s, &before, sizeof s) == 0;"
        for f in made.inputs
    )
    source = around(
        kind,
        f"{n}_state s, before; double x = 0.0, last; int k, codes = 0, same = 0, whole = 0;",
        f"""
    {n}_init(&s, 100.0, 0.0);
    {good}
    for (k = 0; k < 50; k++) codes += {n}_step(&s, &m, &x);
    last = x;
    memcpy(&before, &s, sizeof s);
    {each}
    printf("%d %d %d", codes, same, whole);
    codes = {n}_init(&s, {lost}, 0.0) == {n.upper()}_BAD_INPUT;
    codes += {n}_init(&s, 100.0, {lost}) == {n.upper()}_BAD_INPUT;
    {good}
    printf(" %d %d\\n", codes, {n}_step(&s, &m, &x) == {n.upper()}_OK && isfinite(x));""",
    )  # fmt: skip
    k = len(made.inputs)
    assert run(program(kind, "lost", source)).stdout == f"{k} {k} {k} 2 1\n"


@pytest.mark.parametrize("kind", ["pi", "lqi", "feedforward", "feedforward-pi", "mpc", "mpc-real-time"])
def test_a_start_from_rest_holds_still(kind):
    n = exported(kind)[0].name
    source = around(
        kind,
        f"{n}_state s; double x = 0.0; int k; {n}_init(&s, 100.0, 0.0);",
        f"{inputs(kind, ['0.0', '0.0', '100.0'])} for (k = 0; k < 1000; k++) {n}_step(&s, &m, &x);"
        f'printf("%.9f\\n", x * 49.4);',
    )
    assert float(run(program(kind, "rest", source)).stdout) == pytest.approx(100.0, abs=1e-6)


def test_a_result_that_would_not_be_finite_is_refused():
    n = exported("lqi")[0].name
    source = around(
        "lqi",
        f"{n}_state s, before; double x = 0.0, last; int code; {n}_init(&s, 100.0, 0.0);",
        f"""m.reference_deg = 0.0; m.angle_deg = 0.0; m.pressure_kPa = 100.0;
    code = {n}_step(&s, &m, &x);
    last = x;
    s.static_angle_deg = 1.7e308; /* as after a bit flipped in memory */
    s.angle_deg = -1.7e308;
    memcpy(&before, &s, sizeof s);
    printf("%d %d", code, {n}_step(&s, &m, &x));
    s.angle_age = before.angle_age;
    s.pressure_age = before.pressure_age;
    printf(" %d %d\\n", memcmp(&s, &before, sizeof s), x == last);""",
    )
    assert run(program("lqi", "huge", source)).stdout == "0 2 0 1\n"


def test_a_compiler_that_does_away_with_NaN_is_refused():
    made, folder = exported("pi")
    said = run(CC, "-std=c99", "-ffast-math", "-c", f"{made.name}.c", "-o", "fast.o", folder=folder)
    assert said.returncode != 0
    assert "-ffast-math" in said.stderr


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler on this machine")
def test_the_header_serves_cpp_twice_included():
    made, folder = exported("feedforward-pi")
    (folder / "use.cpp").write_text(
        f'#include "{made.name}.h"\n#include "{made.name}.h"\n'
        f"int main() {{ {made.name}_state s; return {made.name}_init(&s, 100.0, 0.0); }}\n"
    )
    said = run(
        "c++",
        "-Wall",
        "-Wextra",
        "-Werror",
        "use.cpp",
        *objects("feedforward-pi"),
        "-o",
        "use",
        folder=folder,
    )
    assert said.returncode == 0, said.stderr
    assert run(folder / "use").returncode == 0


@pytest.mark.skipif(shutil.which("make") is None, reason="no make on this machine")
def test_the_makefile_checks_the_folder():
    _, folder = exported("pi")
    said = run("make", "check", folder=folder)
    assert said.returncode == 0, said.stderr
    assert "10000 steps" in said.stdout
