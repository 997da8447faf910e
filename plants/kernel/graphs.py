"""Laws as CasADi graphs: what is made of one call of a step function with symbols."""

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from plants.kernel import pytrees

NO_GRAPH = (TypeError, RuntimeError)
"""What `graph` raises of a law that takes no symbols: NumPy and CasADi each say so in their own way."""


def graph(step: Callable[..., Any], *arguments: Any) -> Any:
    """CasADi function of a step: leaves of each argument in, leaves of the result out."""
    import casadi

    casadi.GlobalOptions.setNumpyMode(1)  # ufuncs on symbols stay symbolic, without a warning
    symbols = [[casadi.SX.sym(n) for n in pytrees.names(a)] for a in arguments]
    result = step(*(pytrees.like(a, s) for a, s in zip(arguments, symbols, strict=True)))
    inputs = [casadi.vertcat(*s) for s in symbols]
    return casadi.Function("step", inputs, [casadi.vertcat(*pytrees.leaves(result))])


def baked(name: str, function: Any, *constants: Any) -> Any:
    """A function of `graph` under another name, its last arguments set to constants (trees of floats)."""
    import casadi

    free = [casadi.SX.sym("x", function.size1_in(i)) for i in range(function.n_in() - len(constants))]
    return casadi.Function(name, free, [function(*free, *(casadi.DM(pytrees.leaves(c)) for c in constants))])


def used(function: Any, argument: int) -> list[bool]:
    """Which leaves of an argument of a function the result depends on."""
    columns = set(function.jac_sparsity(0, argument).get_col())
    return [i in columns for i in range(function.size1_in(argument))]


def c_source(name: str, *functions: Any) -> str:
    """C99 of functions, ``int f(const double **arg, double **res, int *iw, double *w, int mem)`` each.

    `name` begins the names of what they share.  The code allocates nothing and has no state; laws of
    scalars use neither `iw` nor `w`.  What CasADi adds for loaders of libraries is left out, so that
    nothing is unused under ``-Wall -Wextra``.  So is the question, at each number, whether an argument or
    the result is NULL: callers pass all of them.  The larger of two numbers is compared for: the C library's
    fmax, which asks for NaN, is a call of dozens of instructions where no processor has it.
    """
    import casadi

    generator = casadi.CodeGenerator(f"{name}.c", {"with_export": False, "casadi_int": "int"})
    for function in functions:
        generator.add(function)
    blocks = str(generator.dump()).split("\n\n")
    kept = [b for b in blocks if not _FOR_LOADERS.search(b)]
    text = _FUNCTION.sub(_all_used, "\n\n".join(kept))
    text = _LARGER.sub(r"\1  return (\2) \3\n}", text)
    text = _STORED.sub(r"\1", _GIVEN.sub(r"\1", text))
    return "\n".join(line for line in text.split("\n") if not _SPARSITY.match(line)).rstrip("\n") + "\n"


_FOR_LOADERS = re.compile(
    r"\w+_(casadi_version|checkout|release|incref|decref|n_in|n_out|default_in|name_in|name_out|sparsity_in"
    r"|sparsity_out|work|work_bytes)\("
)
_FUNCTION = re.compile(r"^((?:static )?int \w+\(const casadi_real\*\* arg, .*int mem\) ?\{)$", re.MULTILINE)
_LARGER = re.compile(
    r"(casadi_real casadi_f(?:max|min)\(.*\) \{\n)/\* Pre-c99 .*\n#if .*\n\s*return (x[<>]y) (\? x : y;)\n"
    r"#else\n.*\n#endif\n\}"
)
_GIVEN = re.compile(r"arg\[\d+\]\? (arg\[\d+\]\[\d+\]) : 0")
_STORED = re.compile(r"if \(res\[\d+\]!=0\) (res\[\d+\]\[\d+\]=)")
_SPARSITY = re.compile(r"(static const casadi_int casadi_s\d+\[)|(#define casadi_s\d+ )")


def _all_used(begin: re.Match[str]) -> str:
    return f"{begin[1]}\n  (void)iw; (void)w; (void)mem;"


def derivatives(step: Callable[..., Any], *arguments: Any) -> Any:
    """CasADi function of the derivatives of a step's leaves by those of each argument, to be evaluated."""
    import casadi

    function = graph(step, *arguments)
    x = [casadi.SX.sym("x", function.size1_in(i)) for i in range(function.n_in())]
    return casadi.Function("jacobians", x, [casadi.jacobian(function(*x), xi) for xi in x])


def slopes(of: Sequence[Any], by: Sequence[Any]) -> Any:
    """Derivatives of symbols by others, (of, by), for a law that is itself made a graph of."""
    import casadi

    return casadi.jacobian(casadi.vertcat(*of), casadi.vertcat(*by))


def jacobians(step: Callable[..., Any], *arguments: Any) -> list[np.ndarray]:
    """Derivatives of the leaves of ``step(*arguments)`` by those of each argument, at that point."""
    return evaluated(derivatives(step, *arguments), *arguments)


def evaluated(function: Any, *arguments: Any) -> list[np.ndarray]:
    """The results of a function at trees of floats."""
    values = function(*(np.array(pytrees.leaves(a), float) for a in arguments))
    return [np.array(v) for v in (values if isinstance(values, tuple) else (values,))]
