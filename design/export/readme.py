"""The README of an exported folder: what a person who has only the folder needs to know."""

from collections.abc import Iterable
from importlib.metadata import version
from textwrap import fill

from design.export.fields import Field
from design.export.header import ring_fields, unit
from design.export.part import Part


def readme(part: Part) -> str:
    """README.md."""
    n, N, out = part.name, part.name.upper(), part.output
    state = [f for _, f in part.kept] + [f for row, _ in part.delays for f in ring_fields(part, row)]
    bounds = (
        f" from `{N}_LOWEST_{out.unit}` ({part.low:g} {out.unit}) to `{N}_HIGHEST_{out.unit}` "
        f"({part.high:g} {out.unit})"
        if part.low is not None and part.high is not None
        else ""
    )
    set_inputs = "\n".join(f"    m.{f.member} = ...;" for f in part.inputs)
    settings = "\n".join(f"| {name} | {value!r} |" for name, value in part.settings.items())
    notes = "\n\n".join(fill(note, 110) for note in part.notes)
    lost = fill(
        f"Where a measurement is not finite (NaN, infinite), {part.lost}. The return code is "
        f"`{N}_BAD_INPUT`. So a lost sample costs one period and nothing is poisoned.",
        110,
    )
    return f"""\
# {n}

{part.title}.

Made by wrist-workbench {version("wrist-workbench")}. C99 in double precision; it allocates nothing and has no
global state, so that several joints may each have a `{n}_state`.

| file | what it is |
| --- | --- |
| `{n}.h` | structs, functions, units |
| `{n}.c` | keeps the state, refuses what is not finite |
| `{n}_law.c` | the law, made by CasADi from the graph that is simulated; do not edit |
| `{n}_vector.csv`, `test_vector.c` | test vector and the program that replays it |
| `Makefile` | `make check` |

## Use

```c
#include "{n}.h"

{n}_state s;
{n}_measured m;
double {out.member};

{n}_init(&s, pressure_kPa, angle_deg);      /* at rest */
for (;;) {{                                  /* every {N}_PERIOD_S = {part.period:g} s */
{set_inputs}
    int code = {n}_step(&s, &m, &{out.member});
}}
```

Call `{n}_step` once in every period of {part.period:g} s, at equal distances: the coefficients belong to that
period. Coefficients are constants of the code. For other settings export again, so that the test
vector belongs to what runs.

## Input and output

| quantity | unit | meaning |
| --- | --- | --- |
{_rows(part.inputs)}
{_rows((out,))}

The output is `{out.member}`{bounds}.

{notes}

## When a sensor fails

{lost}

How long that may go on is for the caller to decide: count the codes, and stop the joint when there are too
many in a row. `{N}_FAILED` says that there is no finite result: the output is held too. Do not compile with
`-ffast-math`; the code refuses to, because such a compiler removes the test for NaN.

## State

| member | unit | meaning |
| --- | --- | --- |
{_rows(state)}
{_rows((out._replace(name=f"last_{out.name}", meaning="output of the last good sample"),))}

## Check it

```
make check
```

or, with the target's compiler, `cc -std=c99 -O2 -o test_vector test_vector.c {n}.c {n}_law.c -lm`.
`test_vector` replays `{n}_vector.csv`, a loop with noise, saturation and lost samples, and fails where an
output is off by more than {part.tolerance:g} {out.unit} from what Python computed.

## Settings

| setting | value |
| --- | --- |
{settings}
"""


def _rows(fields: Iterable[Field]) -> str:
    return "\n".join(f"| `{f.member}` | {unit(f)} | {f.meaning} |" for f in fields)
