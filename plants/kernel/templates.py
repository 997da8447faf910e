"""Loops that straight-line code is laid into: steps over lanes, with delay lines and signals held."""

from collections.abc import Callable
from typing import Any

from plants.actuator.delay import LONGEST, DelayLine, SampledDelay
from plants.kernel import pytrees
from plants.kernel.emitter import statements
from plants.kernel.graphs import graph

LANES = 16
"""Rollouts that advance together in one loop; batches are padded to a multiple of it."""

_HEAD = '''"""Emitted code: {name}. Do not edit; it is made anew when the law changes."""
import math
import numpy as np
from numba import njit
from plants.kernel.selection import select

@njit(nogil=True, error_model="numpy", fastmath={{"contract", "nsz", "arcp"}})
'''

_LANES = """\
def run(coefficients, state, signals{given}, steps, every, recorded, rows):
    # One array for everything, so that the compiler sees that no two rows overlap.
    m = np.empty({total} * {lanes})
{lines}
    for block in range(state.shape[1] // {lanes}):
        first = block * {lanes}
        for j in range({n_coefficients}):
            for l in range({lanes}):
                m[j * {lanes} + l] = coefficients[j, first + l]
        for j in range({n_state}):
            for l in range({lanes}):
                m[({n_coefficients} + j) * {lanes} + l] = state[j, first + l]
{filled}
        for k in range(steps):
{inputs}
{read}
            for l in range({lanes}):
{body}
{written}
            if every > 0 and (k + 1) % every == 0:
                for j in range(recorded.shape[0]):
                    row = ({n_coefficients} + recorded[j]) * {lanes}
                    for l in range({lanes}):
                        rows[j, (k + 1) // every, first + l] = m[row + l]
        for j in range({n_state}):
            for l in range({lanes}):
                state[j, first + l] = m[({n_coefficients} + j) * {lanes} + l]
"""


def module(name: str, run: str) -> str:
    """Source of a module whose function `run` is compiled at its first call."""
    return _HEAD.format(name=name) + run


def emit(
    name: str,
    step: Callable[..., Any],
    state: Any,
    inputs: tuple[str, ...],
    coefficients: Any,
    held: tuple[str, ...] = (),
) -> str:
    """Source of a module whose ``run`` advances blocks of lanes by ``step(state, inputs, coefficients)``.

    `state` and `coefficients` are examples of the trees; `inputs` names the
    signals that all lanes share, of which ``sample`` is the index of the step,
    and those of `held`, of which each lane has its own.
    """
    function = graph(step, state, inputs, coefficients)
    n_c, n_s = len(pytrees.leaves(coefficients)), len(pytrees.leaves(state))
    cell = [f"m[{j * LANES} + l]" for j in range(n_c + n_s)]
    loads = [f"c{j} = {cell[j]}" for j in range(n_c)] + [f"s{j} = {cell[n_c + j]}" for j in range(n_s)]
    rows = {i: n_c + n_s + j for j, i in enumerate(held)}  # of `m`, that keep a value while it is held
    loads += [f"u_{i} = m[{row * LANES} + l]" for i, row in rows.items()]
    # Prefixed, so that no signal is called like a variable of the template.
    sources = [[f"s{j}" for j in range(n_s)], [f"u_{i}" for i in inputs], [f"c{j}" for j in range(n_c)]]
    body = loads + statements(function, sources, cell[n_c:])
    delays = _delays(state, coefficients, n_c)
    signals = [i for i in inputs if i != "sample" and i not in held]
    reads = [f"u_{i} = signals[{j}, k]" for j, i in enumerate(signals)] + ["u_sample = float(k)"]
    return module(name, _LANES.format(
        lanes=LANES, total=n_c + n_s + len(held), n_coefficients=n_c, n_state=n_s,
        given=", held, hold, lane" if held else "",
        inputs="\n".join(" " * 12 + r for r in reads + _held_code(rows)),
        body="\n".join(" " * 16 + s for s in body),
        **_delay_code(delays),
    ))  # fmt: skip


def _held_code(rows: dict[str, int]) -> list[str]:
    """What a template needs to renew, every `hold` steps, the signals of which each lane has its own."""
    renew = [f"        m[{row * LANES} + l] = held[{j}, k // hold, lane + first + l]"
             for j, row in enumerate(rows.values())]  # fmt: skip
    return ["if k % hold == 0:", f"    for l in range({LANES}):", *renew] if rows else []


def _delays(state: Any, coefficients: Any, offset: int) -> list[tuple[int, int]]:
    """Row of the first leaf of each delay line, and of the whole samples of its delay."""
    lines = [offset + row for row in pytrees.places(state, DelayLine)]
    return list(zip(lines, pytrees.places(coefficients, SampledDelay), strict=True))


def _delay_code(delays: list[tuple[int, int]]) -> dict[str, str]:
    """What a template needs to keep delay lines: ring buffers, of a power of two of samples."""
    size, made, filled, read, written = LONGEST + 1, [], [], [], []
    for i, (row, delay) in enumerate(delays):
        near, far, newest = (f"m[{(row + j) * LANES} + l]" for j in range(3))
        made.append(f"    line{i} = np.empty({size} * {LANES})")
        filled += [f"        for j in range({size}):", f"            for l in range({LANES}):",
                   f"                line{i}[j * {LANES} + l] = {newest}"]  # fmt: skip
        read += [f"            for l in range({LANES}):",
                 f"                back = k - int(m[{delay * LANES} + l])",
                 f"                {near} = line{i}[(back & {size - 1}) * {LANES} + l]",
                 f"                {far} = line{i}[((back - 1) & {size - 1}) * {LANES} + l]"]  # fmt: skip
        written += [f"            for l in range({LANES}):",
                    f"                line{i}[(k & {size - 1}) * {LANES} + l] = {newest}"]  # fmt: skip
    parts = {"lines": made, "filled": filled, "read": read, "written": written}
    return {name: "\n".join(part) for name, part in parts.items()}
