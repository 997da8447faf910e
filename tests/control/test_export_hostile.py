"""Whatever exported C is told, from `init` on, its output is a number in its range, and that of Python."""

import math

import numpy as np
import pytest

from design.export.fields import REFERENCE
from design.export.part import SEEN, Seen
from design.export.vectors import TargetReplay
from tests.control.c_target import GAINS, WRIST, exported, needs_compiler, program, quick, run

pytestmark = needs_compiler

INITS = [
    *((p, 0.0) for p in (250.0, -50.0, 1000.0, 400.0, 0.0, 1e300, -1e300, math.nan, math.inf, -math.inf)),
    *((100.0, a) for a in (60.0, -80.0, 1e9, 1e300, -1.7e308, math.nan, math.inf)),
    (math.nan, math.nan),
    (400.0, 89.0),
]
"""Pressures [kPa] and angles [deg] that a start may be told."""

NONE = (math.nan, math.inf, -math.inf)
HOSTILE = (*NONE, 1e9, -1e9, 1e300, -1e300, 1.7e308, -1.7e308, 1e4, 399.0, -199.0)

MAIN = """
#include "{n}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
int main(void)
{{
    char line[256];
    {n}_state s;
    {n}_measured m;
    memset(&s, 255, sizeof s); /* nobody has filled it */
    while (fgets(line, sizeof line, stdin) != NULL) {{
        char *at = line + 1;
        double x[3], out = 0.0;
        int i, code;
        for (i = 0; i < 3; i++) x[i] = strtod(at, &at);
        if (line[0] == 'i') {{
            code = {n}_init(&s, x[0], x[1]);
            out = s.last_{out};
        }} else {{
            {read}
            code = {n}_step(&s, &m, &out);
        }}
        printf("%d %.17g\\n", code, out);
    }}
    return 0;
}}
"""


def answers(kind, told):
    """Code and output of the C for each row: 'i', pressure, angle, 0 or 's', reference, angle, pressure."""
    made, folder = exported(kind)
    read = " ".join(f"m.{f.member} = x[{i}];" for i, f in made.read)
    path = program(kind, "hostile", MAIN.format(n=made.name, out=made.output.member, read=read))
    (folder / "told").write_text("".join(f"{w} {a!r} {b!r} {c!r}\n" for w, a, b, c in told))
    said = run("sh", "-c", f"{path} < told", folder=folder)
    assert said.returncode == 0, said.stderr
    return np.array(said.stdout.split(), float).reshape(-1, 2).T


def hostile(steps, seed):
    """Starts of every kind, each followed by samples: first lost, then good and bad ones mixed."""
    draw = np.random.default_rng(seed)
    for k, (pressure, angle) in enumerate(INITS):
        yield ("i", pressure, angle, 0.0)
        for step in range(steps // len(INITS)):
            sample = draw.uniform((-25.0, -30.0, 0.0), (25.0, 30.0, 200.0)).tolist()
            for i in range(3):
                if draw.random() < (1.0 if step == 0 and k % 2 else 0.3):
                    # Of readings also the least there is; a reference of it is where the virgin loop jumps.
                    sample[i] = float(draw.choice(HOSTILE + (5e-324,) * (i > 0)))
            yield ("s", *sample)


@pytest.mark.slow
@pytest.mark.parametrize("kind", GAINS)
def test_the_output_is_in_range_from_the_first_sample_on_and_that_of_Python(kind):
    made, _ = exported(kind)
    steps = 1900 if kind.startswith(("mpc", "feedforward")) else 5700
    told = list(hostile(steps, seed=len(kind)))
    codes, outputs = answers(kind, told)
    assert np.isfinite(outputs).all()
    if made.low is not None:
        assert outputs.min() >= made.low
        assert outputs.max() <= made.high
    assert {0, 1, 3} <= set(codes.tolist()) <= {0, 1, 3}  # none failed
    replay, worst = TargetReplay(made), 0.0
    for (what, *x), output in zip(told, outputs, strict=True):
        expected = replay.begin(*x[:2]) if what == "i" else replay.step(Seen(*x))
        worst = max(worst, abs(expected - output))
    assert worst <= (1e-6 if kind.startswith("mpc") else 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [k for k in GAINS if k != "observer"])
@pytest.mark.parametrize("pressure", [250.0, 1000.0, -50.0])
def test_a_start_outside_the_range_and_a_lost_sample_hold_the_end_of_the_range(kind, pressure):
    _, outputs = answers(kind, [("i", pressure, 0.0, 0.0), ("s", math.nan, math.nan, math.nan)])
    rest = WRIST.hysteresis.rest_pressure / WRIST.regulator.gain
    assert outputs[1] == pytest.approx({250.0: 4.0, -50.0: 0.0, 1000.0: rest}[pressure], abs=1e-9)


@pytest.mark.parametrize("kind", quick(k for k in GAINS if k.startswith("mpc")))
@pytest.mark.parametrize("pressure", [400.0, -199.0])
def test_good_samples_after_any_start_have_a_plan(kind, pressure):
    good = [("s", 15.0, 0.01 * k % 0.3, 100.0) for k in range(3000)]
    codes, outputs = answers(kind, [("i", pressure, 0.0, 0.0), *good])
    assert (codes == 0).all()
    assert outputs.max() <= 4.0


@pytest.mark.parametrize("kind", quick(k for k in GAINS if k != "observer"))
def test_a_sensor_that_was_wrong_is_believed_again_within_a_second(kind):
    made, _ = exported(kind)
    within = round(1.0 / made.period)
    elsewhere = [("s", 0.0, -60.0, 300.0)]  # believed, for nothing was seen before
    codes, _ = answers(kind, [("i", 100.0, 0.0, 0.0), *elsewhere, *[("s", 0.0, 5.0, 100.0)] * within])
    assert codes[-1] == 0
    if any(f != REFERENCE for f in made.inputs):
        assert codes[2] == 3
    assert len(SEEN) == 3


def test_an_uninitialised_state_gives_a_number_in_range():
    codes, outputs = answers("pi", [("s", 5.0, 0.0, 100.0), ("s", math.nan, 0.0, 100.0)])
    assert ((outputs >= 0.0) & (outputs <= 4.0)).all()
    assert codes[0] != 0
