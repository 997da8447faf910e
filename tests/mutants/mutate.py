"""Small faults in Python: an operator, a comparison, a constant, a branch or a slice is another."""

import ast
import copy
import random
from collections.abc import Container, Iterator
from pathlib import Path
from typing import NamedTuple

ARITHMETIC: dict[type[ast.operator], tuple[type[ast.operator], ...]] = {
    ast.Add: (ast.Sub,), ast.Sub: (ast.Add,), ast.Mult: (ast.Div, ast.Add), ast.Div: (ast.Mult,),
    ast.FloorDiv: (ast.Div,), ast.Mod: (ast.Mult,), ast.Pow: (ast.Mult,), ast.MatMult: (ast.Mult,),
    ast.BitAnd: (ast.BitOr,), ast.BitOr: (ast.BitAnd,),
}  # fmt: skip
COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
}  # fmt: skip
CALLED = {
    "minimum": "maximum", "maximum": "minimum", "min": "max", "max": "min", "all": "any", "any": "all",
    "exp": "expm1", "sqrt": "abs", "zeros": "ones", "ones": "zeros", "floor": "ceil", "ceil": "floor",
    "argmax": "argmin", "argmin": "argmax", "cos": "sin", "sin": "cos", "sum": "max", "mean": "median",
}  # fmt: skip


class Mutant(NamedTuple):
    """A file with one fault: which line, before and after, and the whole text."""

    path: Path
    line: int
    before: str
    after: str
    text: str


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Faults of one node, each a node in its place."""
    new = copy.deepcopy(node)
    match new:
        case ast.BinOp(op=op) if type(op) in ARITHMETIC and not _is_text(new):
            for other in ARITHMETIC[type(op)]:
                found = copy.deepcopy(new)
                found.op = other()
                yield found
        case ast.Compare(ops=[op]) if type(op) in COMPARED:
            new.ops = [COMPARED[type(op)]()]
            yield new
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield operand
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield operand
        case ast.BoolOp():
            new.op = ast.Or() if isinstance(new.op, ast.And) else ast.And()
            yield new
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
            yield ast.Constant(value + 2)
        case ast.Constant(value=float(value)):
            yield ast.Constant(2.0 * value if value else 1.0)
        case ast.IfExp():
            new.body, new.orelse = new.orelse, new.body
            yield new
        case ast.Call(func=ast.Attribute(attr=name)) if name in CALLED:
            new.func.attr = CALLED[name]  # type: ignore[attr-defined]
            yield new
        case ast.Call(func=ast.Name(id=name)) if name in CALLED:
            new.func.id = CALLED[name]  # type: ignore[attr-defined]
            yield new


def _is_text(node: ast.BinOp) -> bool:
    sides = (node.left, node.right)
    return any(isinstance(s, ast.JoinedStr) or isinstance(getattr(s, "value", None), str) for s in sides)


def _passed_over(tree: ast.Module) -> set[int]:
    """Nodes whose faults nobody could see: of annotations, messages, seeds, defaults that name a thing."""
    found: set[int] = set()
    for node in ast.walk(tree):
        parts: list[ast.AST | None] = []
        if isinstance(node, ast.AnnAssign):
            parts = [node.annotation]
        elif isinstance(node, ast.FunctionDef):
            parts = [node.returns, *(a.annotation for a in (*node.args.args, *node.args.kwonlyargs))]
            late = zip(reversed(node.args.args), reversed(node.args.defaults), strict=False)
            parts += [default for argument, default in late if argument.arg == "seed"]
        elif isinstance(node, ast.Raise | ast.JoinedStr | ast.Assert):
            parts = [node]
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("default_rng"):
            parts = [*node.args]
        elif isinstance(node, ast.keyword) and node.arg == "strict":  # of zip: an assertion
            parts = [node.value]
        found |= {id(inner) for part in parts if part is not None for inner in ast.walk(part)}
    return found


def _changed(path: Path) -> Iterator[Mutant]:
    """All texts of a file with a node changed, some of which may be no program, or the same one."""
    text = path.read_text(encoding="utf-8")
    tree, lines = ast.parse(text), text.splitlines(keepends=True)
    passed = _passed_over(tree)
    for node in ast.walk(tree):
        if not isinstance(node, ast.expr) or id(node) in passed or node.lineno != node.end_lineno:
            continue
        line = lines[node.lineno - 1].encode()
        begin, end = node.col_offset, node.end_col_offset
        assert end is not None
        for change in changes(node):
            new = (line[:begin] + f"({ast.unparse(change)})".encode() + line[end:]).decode()
            whole = "".join([*lines[: node.lineno - 1], new, *lines[node.lineno :]])
            yield Mutant(path, node.lineno, line.decode().strip(), new.strip(), whole)


def _is_another(mutant: Mutant) -> bool:
    """Whether a text is a program, and not the one that it was made of."""
    try:
        changed = ast.dump(ast.parse(mutant.text))
    except SyntaxError:  # within a format of text
        return False
    return changed != ast.dump(ast.parse(mutant.path.read_text(encoding="utf-8")))


def mutants(path: Path, after: Container[str] | None = None) -> list[Mutant]:
    """All faults of a file, or those that leave one of some lines."""
    return [m for m in _changed(path) if (after is None or m.after in after) and _is_another(m)]


def drawn(files: list[Path], count: int, seed: int) -> list[Mutant]:
    """So many faults, each of another line where there are enough, files in proportion to their faults."""
    every = [m for path in files for m in _changed(path)]
    random.Random(seed).shuffle(every)
    found: dict[tuple[Path, int], Mutant] = {}
    for mutant in every:
        if len(found) == count:
            break
        place = (mutant.path, mutant.line)
        if place not in found and _is_another(mutant):
            found[place] = mutant
    return list(found.values())
