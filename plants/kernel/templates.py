"""Loops that straight-line code is laid into: steps over lanes, with delay lines and signals held."""

from collections.abc import Callable
from typing import Any

from plants.actuator.delay import LONGEST, DelayLine, SampledDelay
from plants.kernel import pytrees
from plants.kernel.emitter import program
from plants.kernel.graphs import graph

LANES = 16
"""Rollouts that advance together in one loop; batches are padded to a multiple of it."""

_HEAD = '''"""Emitted code: {name}. Do not edit; it is made anew when the law changes."""
import math
import numpy as np
from numba import njit
from plants.kernel import arithmetic

'''
_RUN = '@njit(nogil=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"})\n'

_LANES = """\
def run(m, lane, signals{given}, steps, every, recorded, rows):
{lines}
    for k in range(steps):
{inputs}
{read}
        for l in range({lanes}):
            law(m, l, {arguments})
{written}
        if every > 0 and (k + 1) % every == 0:
            for j in range(recorded.size):
                for l in range({lanes}):
                    rows[j, (k + 1) // every, lane + l] = m[recorded[j], l]
"""


def module(name: str, run: str, **laws: str) -> str:
    """Source of a module whose function `run` is compiled at its first call; laws: what it calls, as the
    source of an intrinsic of `plants.kernel.arithmetic`."""
    made = "".join(f"{law} = {source}\n" for law, source in laws.items())
    return _HEAD.format(name=name) + made + _RUN + run


def emit(
    name: str,
    step: Callable[..., Any],
    state: Any,
    inputs: tuple[str, ...],
    coefficients: Any,
    held: tuple[str, ...] = (),
) -> str:
    """Source of a module whose ``run`` advances a block of lanes by ``step(state, inputs, coefficients)``.

    `state` and `coefficients` are examples of the trees; `inputs` names the
    signals that all lanes share, of which ``sample`` is the index of the step,
    and those of `held`, of which each lane has its own.  What lanes have of
    their own are the rows of one array, (rows, `LANES`): coefficients, then the
    state, then what is held.
    """
    n_c, n_s = len(pytrees.leaves(coefficients)), len(pytrees.leaves(state))
    kept = {i: n_c + n_s + j for j, i in enumerate(held)}  # rows of what keeps a value while it is held
    shared = [i for i in inputs if i not in held]
    of_state = [("row", n_c + j) for j in range(n_s)]
    of_inputs = [("row", kept[i]) if i in kept else ("argument", shared.index(i)) for i in inputs]
    of_coefficients = [("row", j) for j in range(n_c)]
    law = program(
        graph(step, state, inputs, coefficients), [of_state, of_inputs, of_coefficients],
        [row for _, row in of_state],
    )  # fmt: skip
    # Read before lanes are gone through: within, what a lane writes might be a signal.
    signals = [i for i in shared if i != "sample"]
    reads = [f"        u{j} = " + (f"signals[{signals.index(i)}, k]" if i in signals else "float(k)")
             for j, i in enumerate(shared)]  # fmt: skip
    run = _LANES.format(
        lanes=LANES, given=", held, hold" if held else "",
        inputs="\n".join(reads + _held_code([*kept.values()])),
        arguments=", ".join(f"u{j}" for j in range(len(shared))),
        **_delay_code(_delays(state, coefficients, n_c)),
    )  # fmt: skip
    return module(name, run, law=f'arithmetic.advance("""\\\n{law}""", {LANES})')


def _held_code(rows: list[int]) -> list[str]:
    """What a template needs to renew, every `hold` steps, the signals of which each lane has its own."""
    renew = [f"                m[{row}, l] = held[{j}, k // hold, lane + l]" for j, row in enumerate(rows)]
    return ["        if k % hold == 0:", f"            for l in range({LANES}):", *renew] if rows else []


def _delays(state: Any, coefficients: Any, offset: int) -> list[tuple[int, int]]:
    """Row of the first leaf of each delay line, and of the whole samples of its delay."""
    lines = [offset + row for row in pytrees.places(state, DelayLine)]
    return list(zip(lines, pytrees.places(coefficients, SampledDelay), strict=True))


def _delay_code(delays: list[tuple[int, int]]) -> dict[str, str]:
    """What a template needs to keep delay lines: ring buffers, of a power of two of samples."""
    size, lines, read, written = LONGEST + 1, [], [], []
    for i, (near, delay) in enumerate(delays):
        far, newest, lanes = near + 1, near + 2, f"for l in range({LANES}):"
        lines += [f"    line{i} = np.empty(({size}, {LANES}))", f"    for j in range({size}):",
                  f"        {lanes}", f"            line{i}[j, l] = m[{newest}, l]"]  # fmt: skip
        read += [f"        {lanes}", f"            back = k - int(m[{delay}, l])",
                 f"            m[{near}, l] = line{i}[back & {size - 1}, l]",
                 f"            m[{far}, l] = line{i}[(back - 1) & {size - 1}, l]"]  # fmt: skip
        written += [f"        {lanes}", f"            line{i}[k & {size - 1}, l] = m[{newest}, l]"]
    return {name: "\n".join(part) for name, part in (("lines", lines), ("read", read), ("written", written))}
