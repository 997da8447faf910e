"""C in single precision, of the same C in double: for targets whose floating-point unit has no double.

Types, constants and functions change and nothing else, so that one law is written once.
"""

import re
from typing import Literal

Precision = Literal["double", "single"]

FUNCTIONS = "fabs fmax fmin sqrt exp log pow sin cos tan atan atan2 asin acos floor ceil tanh fmod"
"""Functions of math.h that a law may call; those of CasADi's own names are not among them."""

TOLERANCE = {"law.c.jinja": 5e-3, "mpc.c.jinja": 2e-2, "real_time.c.jinja": 0.5}
"""How far single precision may be from Python, in the unit of the output, by the template of the source: an
inverse of a hysteresis divides by small slopes, the QP of an MPC is ill conditioned, and the plans of the MPC
by real-time iteration bend at the lines of the loop: after a reversal it was 0.3 V off in one of six vectors,
where in double precision a relative change of its belief by 1e-5 does the same."""

_TOKEN = re.compile(
    r"(?P<kept>/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\])*\"|\#include[^\n]*)"
    r"|(?P<number>(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][+-]?\d+)?(?![\w.]))"
    r"|(?P<name>\b[A-Za-z_]\w*\b)",
    re.DOTALL,
)
_NAMES = {"double": "float"} | {name: f"{name}f" for name in FUNCTIONS.split()}


def in_single(code: str) -> str:
    """A source or header with float in the place of double throughout, constants and functions included.

    >>> in_single("double x = fmax(y[10], 1.5e3) + 2 * 1.; /* a double, 1.0 */")
    'float x = fmaxf(y[10], 1.5e3f) + 2 * 1.f; /* a double, 1.0 */'
    """

    def changed(found: re.Match[str]) -> str:
        if found["number"]:
            return f"{found['number']}f"
        return _NAMES.get(found["name"], found[0]) if found["name"] else found[0]

    return _TOKEN.sub(changed, code)
