"""From a law to machine code: the only file that knows CasADi and numba.

A step function written with NumPy ufuncs is called once with CasADi symbols;
the graph that comes out is written down as straight-line Python over a small
vector of lanes, which numba compiles to SIMD code and caches on disk.
"""

import hashlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from plants import tree
from plants.delay import LONGEST, DelayLine, SampledDelay
from plants.files import write_atomically

LANES = 16
"""Rollouts that advance together in one loop; batches are padded to a multiple of it."""

_BINARY = {
    "OP_ADD": "{} + {}", "OP_SUB": "{} - {}", "OP_MUL": "{} * {}", "OP_DIV": "{} / {}",
    "OP_FMIN": "{0} if {0} < {1} else {1}", "OP_FMAX": "{0} if {0} > {1} else {1}",
    "OP_LT": "{} < {}", "OP_LE": "{} <= {}", "OP_EQ": "{} == {}", "OP_NE": "{} != {}",
    "OP_IF_ELSE_ZERO": "{1} if {0} else 0.0", "OP_CONSTPOW": "{} ** {}", "OP_POW": "{} ** {}",
}  # fmt: skip
_UNARY = {
    "OP_NEG": "-{}", "OP_NOT": "not {}", "OP_SQ": "{0} * {0}", "OP_TWICE": "2.0 * {}",
    "OP_INV": "1.0 / {}", "OP_FABS": "abs({})", "OP_EXP": "math.exp({})", "OP_TANH": "math.tanh({})",
    "OP_SQRT": "math.sqrt({})", "OP_SIN": "math.sin({})", "OP_COS": "math.cos({})",
    "OP_LOG": "math.log({})", "OP_FLOOR": "np.floor({})", "OP_ASSIGN": "{}",
}  # fmt: skip

_TEMPLATE = '''"""Emitted code: {name}. Do not edit; it is made anew when the law changes."""
import math
import numpy as np
from numba import njit

@njit(nogil=True, cache=True, error_model="numpy", fastmath={{"contract", "nsz", "arcp"}})
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
'''


def graph(step: Callable[..., Any], *arguments: Any) -> Any:
    """CasADi function of a step: leaves of each argument in, leaves of the result out."""
    import casadi

    casadi.GlobalOptions.setNumpyMode(1)  # ufuncs on symbols stay symbolic, without a warning
    symbols = [[casadi.SX.sym(n) for n in tree.names(a)] for a in arguments]
    result = step(*(tree.like(a, s) for a, s in zip(arguments, symbols, strict=True)))
    inputs = [casadi.vertcat(*s) for s in symbols]
    return casadi.Function("step", inputs, [casadi.vertcat(*tree.leaves(result))])


def baked(name: str, function: Any, *constants: Any) -> Any:
    """A function of `graph` under another name, its last arguments set to constants (trees of floats)."""
    import casadi

    free = [casadi.SX.sym("x", function.size1_in(i)) for i in range(function.n_in() - len(constants))]
    return casadi.Function(name, free, [function(*free, *(casadi.DM(tree.leaves(c)) for c in constants))])


def used(function: Any, argument: int) -> list[bool]:
    """Which leaves of an argument of a function the result depends on."""
    columns = set(function.jac_sparsity(0, argument).get_col())
    return [i in columns for i in range(function.size1_in(argument))]


def c_source(name: str, *functions: Any) -> str:
    """C99 of functions, ``int f(const double **arg, double **res, int *iw, double *w, int mem)`` each.

    `name` begins the names of what they share.  The code allocates nothing and has no state; laws of
    scalars use neither `iw` nor `w`.
    """
    import casadi

    generator = casadi.CodeGenerator(f"{name}.c", {"with_export": False, "casadi_int": "int"})
    for function in functions:
        generator.add(function)
    return str(generator.dump())


def jacobians(step: Callable[..., Any], *arguments: Any) -> list[np.ndarray]:
    """Derivatives of the leaves of ``step(*arguments)`` by those of each argument, at that point."""
    import casadi

    function = graph(step, *arguments)
    x = [casadi.SX.sym("x", function.size1_in(i)) for i in range(function.n_in())]
    wrt = casadi.Function("jacobians", x, [casadi.jacobian(function(*x), xi) for xi in x])
    values = wrt(*(np.array(tree.leaves(a), float) for a in arguments))
    return [np.array(v) for v in (values if isinstance(values, tuple) else (values,))]


def statements(function: Any, sources: list[list[str]], targets: list[str]) -> list[str]:
    """Straight-line Python of a CasADi function; reads every input before it writes an output.

    Raises ValueError for an operation that has no code here.
    """
    import casadi

    codes = {v: k for k, v in vars(casadi).items() if k.startswith("OP_") and isinstance(v, int)}
    held: dict[int, str] = {}  # work slot -> the name that was last put there
    made: dict[str, tuple[str, list[str]]] = {}  # name -> how, to recognise a selection
    lines, writes = [], []
    for k in range(function.n_instructions()):
        code = codes[function.instruction_id(k)]
        given, into = function.instruction_input(k), function.instruction_output(k)
        if code == "OP_OUTPUT":
            writes.append(f"{targets[into[1]]} = {held[given[0]]}")
            continue
        if code == "OP_INPUT":
            held[into[0]] = sources[given[0]][given[1]]
            continue
        if code == "OP_CONST":
            held[into[0]] = _constant(float(function.instruction_constant(k)))
            continue
        operands = [held[i] for i in given]
        name = f"t{k}"
        made[name] = (code, operands)
        held[into[0]] = name
        selection = _selection(code, operands, made)
        if selection:
            lines.append(f"{name} = {selection}")
        elif code in _BINARY:
            lines.append(f"{name} = {_BINARY[code].format(*operands)}")
        elif code in _UNARY:
            lines.append(f"{name} = {_UNARY[code].format(operands[0])}")
        else:
            raise ValueError(f"no code for {code}; add it to plants/compiled.py")
    return lines + writes


def _constant(value: float) -> str:
    """A number as source; in parentheses, since a sign binds less than a power."""
    return f"({value!r})".replace("inf", "np.inf").replace("nan", "np.nan")


def _selection(code: str, operands: list[str], made: dict[str, tuple[str, list[str]]]) -> str | None:
    """``a if c else b`` where CasADi writes ``(c ? a : 0) + (!c ? b : 0)``, else None."""
    if code != "OP_ADD":
        return None
    parts = [made.get(o, ("", [])) for o in operands]
    if [p[0] for p in parts] != ["OP_IF_ELSE_ZERO"] * 2:
        return None
    (yes, a), (no, b) = parts[0][1], parts[1][1]
    return f"{a} if {yes} else {b}" if made.get(no) == ("OP_NOT", [yes]) else None


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
    n_c, n_s = len(tree.leaves(coefficients)), len(tree.leaves(state))
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
    return _TEMPLATE.format(
        name=name, lanes=LANES, total=n_c + n_s + len(held), n_coefficients=n_c, n_state=n_s,
        given=", held, hold, lane" if held else "",
        inputs="\n".join(" " * 12 + r for r in reads + _held_code(rows)),
        body="\n".join(" " * 16 + s for s in body),
        **_delay_code(delays),
    )  # fmt: skip


def _held_code(rows: dict[str, int]) -> list[str]:
    """What a template needs to renew, every `hold` steps, the signals of which each lane has its own."""
    renew = [f"        m[{row * LANES} + l] = held[{j}, k // hold, lane + first + l]"
             for j, row in enumerate(rows.values())]  # fmt: skip
    return ["if k % hold == 0:", f"    for l in range({LANES}):", *renew] if rows else []


def _delays(state: Any, coefficients: Any, offset: int) -> list[tuple[int, int]]:
    """Row of the first leaf of each delay line, and of the whole samples of its delay."""
    lines = [offset + row for row in tree.places(state, DelayLine)]
    return list(zip(lines, tree.places(coefficients, SampledDelay), strict=True))


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


def cache_folder() -> Path:
    """Where emitted code and machine code are kept between processes."""
    import platformdirs

    folder = Path(platformdirs.user_cache_dir("wrist")) / "kernels"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="wrist-kernels-"))


def load(source: str) -> Callable[..., None]:
    """The ``run`` of an emitted module, compiled at its first call in any process."""
    module = f"k{hashlib.sha256(source.encode()).hexdigest()[:24]}"
    path = cache_folder() / f"{module}.py"
    if not path.exists() or path.read_text() != source:  # missing, or damaged
        write_atomically(path, source)  # another process may be doing the same
    spec = importlib.util.spec_from_file_location(module, path)
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[module] = loaded  # numba looks there when it reads its cache
    spec.loader.exec_module(loaded)
    run: Callable[..., None] = loaded.run
    return run


_LOADING = Lock()


def kernel(
    step: Callable[..., Any],
    state: Any,
    inputs: tuple[str, ...],
    coefficients: Any,
    held: tuple[str, ...] = (),
) -> Callable[..., None]:
    """The compiled ``run`` of a step function; `state` and `coefficients` are trees of names.

    Threads may ask for the same one at once: it is made by one of them.
    """
    with _LOADING:
        # Trees that differ in their types alone are equal; their representations are not.
        return _kernel(step, state, inputs, coefficients, held, repr((state, coefficients)))


@cache
def _kernel(
    step: Callable[..., Any],
    state: Any,
    inputs: tuple[str, ...],
    coefficients: Any,
    held: tuple[str, ...],
    types: str,
) -> Callable[..., None]:
    return load(emit(f"{step.__module__}.{step.__name__}", step, state, inputs, coefficients, held))
