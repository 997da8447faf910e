"""The source of an exported law: what keeps its state and refuses what is not finite, around CasADi's code.

The law itself is code that CasADi made of the very graph that is simulated; this file copies the
state into it and out of it, so that a sample either happens as a whole or not at all.
"""

from collections.abc import Iterable

from design.export.header import ring_fields
from design.export.part import SEEN, Part

NO_FINITE_MATH = """\
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "compile without -ffast-math: a sensor's NaN would not be seen"
#endif"""


FINITE_ALL = """\
static int finite_all(const double *x, int count)
{
    int i;
    for (i = 0; i < count; i++) {
        if (!isfinite(x[i])) {
            return 0;
        }
    }
    return 1;
}
"""


def source(part: Part) -> str:
    """NAME.c."""
    n, N, out = part.name, part.name.upper(), part.output.member
    count = len(part.state)
    return f"""\
#include "{n}.h"

#include <math.h>

{NO_FINITE_MATH}

#define LEAVES {count}

/* Made by CasADi, in {n}_law.c. */
int {n}_init_law(const double **arg, double **res, int *iw, double *w, int mem);
int {n}_step_law(const double **arg, double **res, int *iw, double *w, int mem);

{FINITE_ALL}
static void put({n}_state *state, const double *x)
{{
{_lines(f"state->{f.member} = x[{i}];" for i, f in part.kept)}
}}

{init_source(part, _filled(part))}
int {n}_step({n}_state *state, const {n}_measured *measured, double *{out})
{{
    double before[LEAVES], seen[3] = {{0.0, 0.0, 0.0}}, after[LEAVES + 1];
    const double *arg[2];
    double *res[1];
{_lines(f"seen[{i}] = measured->{member};" for i, member in _read(part))}
    *{out} = state->last_{out};
    if (!finite_all(seen, 3)) {{
        return {N}_BAD_INPUT;
    }}
{_lines(f"before[{i}] = state->{f.member};" for i, f in part.kept)}
{_late(part)}    arg[0] = before;
    arg[1] = seen;
    res[0] = after;
    {n}_step_law(arg, res, 0, 0, 0);
    if (!finite_all(after, LEAVES + 1)) {{
        return {N}_FAILED;
    }}
    put(state, after);
    state->last_{out} = after[LEAVES];
{_kept(part)}    *{out} = after[LEAVES];
    return {N}_OK;
}}
"""


def init_source(part: Part, filled: str = "") -> str:
    """NAME_init, for a file that defines LEAVES, finite_all and put; filled: statements at its end."""
    n, N, out = part.name, part.name.upper(), part.output.member
    return f"""\
int {n}_init({n}_state *state, double pressure_kPa, double angle_deg)
{{
    double at[2], after[LEAVES + 1];
    const double *arg[1];
    double *res[1];
    at[0] = pressure_kPa;
    at[1] = angle_deg;
    if (!finite_all(at, 2)) {{
        return {N}_BAD_INPUT;
    }}
    arg[0] = at;
    res[0] = after;
    {n}_init_law(arg, res, 0, 0, 0);
    if (!finite_all(after, LEAVES + 1)) {{
        return {N}_BAD_INPUT;
    }}
    put(state, after);
    state->last_{out} = after[LEAVES];
{filled}    return {N}_OK;
}}
"""


def _lines(statements: Iterable[str]) -> str:
    return "\n".join(f"    {s}" for s in statements)


def _read(part: Part) -> list[tuple[int, str]]:
    """Place among what is seen, and member, of each input."""
    return [(SEEN.index(f), f.member) for f in part.inputs]


def _rings(part: Part) -> list[tuple[int, int, str, str]]:
    """First leaf, length, and members of each delay line."""
    found = []
    for row, samples in part.delays:
        line, oldest = ring_fields(part, row)
        # A ring of one is declared without brackets.
        found.append((row, samples + 1, f"state->{line.member}", f"state->{oldest.member}"))
    return found


def _filled(part: Part) -> str:
    """The lines as they are after long rest."""
    text = ""
    for row, size, line, oldest in _rings(part):
        text += f"    {oldest} = 0;\n"
        if size == 1:
            text += f"    {line} = after[{row + 2}];\n"
        else:
            text += f"    {{\n        int i;\n        for (i = 0; i < {size}; i++) {{\n"
            text += f"            {line}[i] = after[{row + 2}];\n        }}\n    }}\n"
    return text


def _late(part: Part) -> str:
    """What a law sees of a line; see `plants.delay`."""
    text = ""
    for row, size, line, oldest in _rings(part):
        near, far = (line, line) if size == 1 else (f"{line}[({oldest} + 1) % {size}]", f"{line}[{oldest}]")
        text += f"    before[{row}] = {near};\n    before[{row + 1}] = {far};\n"
    return text


def _kept(part: Part) -> str:
    """The newest, in the place of the oldest."""
    text = ""
    for row, size, line, oldest in _rings(part):
        if size == 1:
            text += f"    {line} = after[{row + 2}];\n"
        else:
            text += f"    {line}[{oldest}] = after[{row + 2}];\n    {oldest} = ({oldest} + 1) % {size};\n"
    return text
