"""One of two numbers, as a machine instruction: what emitted code chooses with.

Only emitted code imports this, since numba is slow to load.
"""

from typing import Any

from numba import types
from numba.extending import intrinsic


@intrinsic
def select(typing: Any, condition: Any, yes: Any, no: Any) -> Any:
    """``yes if condition else no`` of numbers, both of which are known.

    Without a branch: each branch would be two more blocks for numba to look through, time and again, and of
    a law of hundreds of choices it would compile for as long again.
    """
    number = types.float64

    def instruction(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        chosen, one, other = (
            context.cast(builder, value, given, wanted)
            for value, given, wanted in zip(
                arguments, signature.args, (types.boolean, number, number), strict=True
            )
        )
        return builder.select(chosen, one, other)

    return number(condition, yes, no), instruction
