"""The source of the exported MPC: what strings observer, QP and first move together."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.export.active_set import SOLVER
from design.export.source import FINITE_ALL, NO_FINITE_MATH, init_source

Array = NDArray[np.float64]

LAWS = ("init", "believe", "target", "wanted", "press")


def mpc_source(part: Any, problem: Any, rate: float, T: Array, G: Array) -> str:
    """NAME.c of an MPC; rate [deg]: of u in a period; T, G as `design.export.mpc` says."""
    n, N, M = part.name, problem.horizon, part.name.upper()
    members = [f.member for f in part.state]
    laws = "\n".join(
        f"int {n}_{law}_law(const double **arg, double **res, int *iw, double *w, int mem);" for law in LAWS
    )
    get = "\n".join(f"    x[{i}] = state->{m};" for i, m in enumerate(members))
    put = "\n".join(f"    state->{m} = x[{i}];" for i, m in enumerate(members))
    return f"""\
#include "{n}.h"

#include <math.h>

{NO_FINITE_MATH}

#define LEAVES {len(members)}
#define BELIEVED {len(members) - 2}
#define ROWS {2 * N}
#define ACTIVE {N + 1}
#define ROUNDS {20 * N}
#define RATE {rate!r}

/* Bounds of the rows: u itself, then its changes, the first of which is u less what it was. */
#define LOW(i) ((i) < {N} ? least : (i) == {N} ? was - RATE : -RATE)
#define HIGH(i) ((i) < {N} ? most : (i) == {N} ? was + RATE : RATE)

/* Made by CasADi, in {n}_law.c. */
{laws}

{_table("T", T)}
{_table("G", G)}{SOLVER}
static void get(const {n}_state *state, double *x)
{{
{get}
}}

static void put({n}_state *state, const double *x)
{{
{put}
}}

{FINITE_ALL}
/* Pressure [kPa] at the end of a period in which a command [V] is held. */
static double pressed(double pressure, double command)
{{
    double at[2], after;
    const double *arg[1];
    double *res[1];
    at[0] = pressure;
    at[1] = command;
    arg[0] = at;
    res[0] = &after;
    {n}_press_law(arg, res, 0, 0, 0);
    return after;
}}

/* The command [V] between low and high after which the pressure is the one wanted, or the nearest: false
   position, the Illinois variant, since the pressure after a period rises with the command. */
static double follow(double pressure, double wanted, double push, double low, double high)
{{
    double below = pressed(pressure, low + push) - wanted, above, value = high;
    int side = 0, j;
    if (below >= 0.0) {{
        return low;
    }}
    above = pressed(pressure, high + push) - wanted;
    if (above <= 0.0) {{
        return high;
    }}
    for (j = 0; j < 28; j++) {{
        double missed;
        value = (low * above - high * below) / (above - below);
        missed = pressed(pressure, value + push) - wanted;
        if (fabs(missed) < 1e-9) {{
            break;
        }}
        if (missed < 0.0) {{
            low = value;
            below = missed;
            if (side == -1) {{
                above *= 0.5;
            }}
            side = -1;
        }} else {{
            high = value;
            above = missed;
            if (side == 1) {{
                below *= 0.5;
            }}
            side = 1;
        }}
    }}
    return value;
}}

{init_source(part)}
int {n}_step({n}_state *state, const {n}_measured *measured, double *command_V)
{{
    double x[LEAVES], after[LEAVES], seen[4], held[2], target[6], u, wanted, push, low, high, value;
    const double *arg[3];
    double *res[1];

    *command_V = state->last_command_V;
    get(state, x);
    held[0] = state->last_command_V;
    seen[2] = isfinite(measured->angle_deg) ? 1.0 : 0.0;
    seen[3] = isfinite(measured->pressure_kPa) ? 1.0 : 0.0;
    seen[0] = seen[2] > 0.5 ? measured->angle_deg : 0.0;
    seen[1] = seen[3] > 0.5 ? measured->pressure_kPa : 0.0;
    arg[0] = x;
    arg[1] = held;
    arg[2] = seen;
    res[0] = after;
    {n}_believe_law(arg, res, 0, 0, 0);
    after[BELIEVED] = x[BELIEVED];
    after[BELIEVED + 1] = x[BELIEVED + 1];
    if (!finite_all(after, LEAVES)) {{
        return {M}_FAILED;
    }}
    put(state, after);
    if (!isfinite(measured->reference_deg) || seen[2] < 0.5 || seen[3] < 0.5) {{
        return {M}_BAD_INPUT;
    }}

    held[1] = measured->reference_deg;
    arg[0] = after;
    res[0] = target;
    {n}_target_law(arg, res, 0, 0, 0);
    if (!finite_all(target, 6) || solve(target, target[4], target[5], target[3], &u) || !isfinite(u)) {{
        return {M}_FAILED;
    }}

    held[0] = u;
    res[0] = &wanted;
    {n}_wanted_law(arg, res, 0, 0, 0);
    low = fmax({problem.low!r}, state->last_command_V - {problem.rate!r});
    high = fmin({problem.high!r}, state->last_command_V + {problem.rate!r});
    push = after[{_lack(part)}] / {float(problem.wrist.regulator.gain)!r};
    value = follow(after[0], wanted, push, low, high);
    if (!isfinite(value)) {{
        return {M}_FAILED;
    }}
    after[BELIEVED] = u;
    after[BELIEVED + 1] = 1.0;
    put(state, after);
    state->last_command_V = value;
    *command_V = value;
    return {M}_OK;
}}
"""


def _lack(part: Any) -> int:
    return [f.name for f in part.state].index("lack")


def _table(name: str, values: Array) -> str:
    """A table of constants, as exact as they are."""
    rows = ",\n".join("    {" + ", ".join(repr(float(x)) for x in row) + "}" for row in values)
    return f"static const double {name}[{values.shape[0]}][{values.shape[1]}] = {{\n{rows}\n}};\n"
