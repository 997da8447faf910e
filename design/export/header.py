"""The header of an exported law: structs, functions and macros, with units, and what it was made from."""

from collections.abc import Iterable
from importlib.metadata import version
from textwrap import wrap

from design.export.fields import Field
from design.export.part import Part


def header(part: Part) -> str:
    """NAME.h, C99 and C++."""
    n, N = part.name, part.name.upper()
    ring = [f for row, _ in part.delays for f in ring_fields(part, row)]
    return f"""\
{comment(f"{part.title}.", "", *origin(part))}
#ifndef {N}_H
#define {N}_H

#ifdef __cplusplus
extern "C" {{
#endif

{macros(part)}

{comment("What the law remembers. Fill it with " + n + "_init; one for each joint that is controlled.")}
typedef struct {{
{members(f for _, f in part.kept)}{members(ring)}    double last_{part.output.member}; /* {
        unit(part.output)
    }: output of the last good sample */
}} {n}_state;

{comment("What is measured in one sample.")}
typedef struct {{
{members(part.inputs)}}} {n}_measured;

{
        comment(
            f"Start from rest at a pressure [kPa] and an angle [deg]. The first output holds the joint still "
            f"while the reference is its angle. Returns {N}_OK, or {N}_BAD_INPUT for a number that is not "
            f"finite; the state is then left as it was."
        )
    }
int {n}_init({n}_state *state, double pressure_kPa, double angle_deg);

{
        comment(
            f"One sample, to be called every {N}_PERIOD_S seconds: {part.output.meaning} "
            f"[{part.output.unit}] from what is measured. Returns {N}_OK; {N}_BAD_INPUT where a measurement "
            f"is not finite; {N}_FAILED where there is no finite result. Where a measurement is not finite, "
            f"{part.lost}."
        )
    }
int {n}_step({n}_state *state, const {n}_measured *measured, double *{part.output.member});

#ifdef __cplusplus
}}
#endif

#endif
"""


def macros(part: Part) -> str:
    """Period, return codes, range of the output."""
    N, unit = part.name.upper(), part.output.unit
    values = {"PERIOD_S": repr(part.period)}
    if part.low is not None and part.high is not None:
        values |= {f"LOWEST_{unit}": repr(part.low), f"HIGHEST_{unit}": repr(part.high)}
    values |= {"OK": "0", "BAD_INPUT": "1", "FAILED": "2"}
    return "\n".join(f"#define {N}_{name} {value}" for name, value in values.items())


def origin(part: Part) -> list[str]:
    """Version and settings, the same for the same law whenever and wherever it is exported."""
    settings = [f"  {name} = {value!r}" for name, value in part.settings.items()]
    return [f"Made by wrist-workbench {version('wrist-workbench')} with", *settings, *part.notes]


def ring_fields(part: Part, row: int) -> list[Field]:
    """Members that keep the delay line whose first leaf is `row` of the state."""
    samples = dict(part.delays)[row]
    kept = part.state[row]
    name = kept.name.removesuffix("_near")
    return [
        Field(f"{name}_line", kept.unit, "what the delay holds, a ring", samples + 1),
        Field(f"{name}_oldest", "", "place of the oldest in the ring", counts=True),
    ]


def unit(f: Field) -> str:
    """The unit as a comment gives it."""
    return f.unit or "no unit"


def members(fields: Iterable[Field]) -> str:
    """Members of a struct, one a line."""
    return "".join(f"    {f.declaration} /* {unit(f)}: {f.meaning} */\n" for f in fields)


def comment(*paragraphs: str) -> str:
    """A block comment, its lines at most 100 characters long."""
    lines = [
        line for p in paragraphs for line in (wrap(p, 96, subsequent_indent="  " * p.startswith(" ")) or [""])
    ]
    text = "\n".join(f"   {line}".rstrip() for line in lines).replace("*/", "* /")
    return "/*" + text[2:] + " */"
