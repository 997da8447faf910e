"""No module of the project imports itself in a round, not even within a function."""

import grimp
import pytest

PROJECT = ("plants", "design", "reports")


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Sets of modules of which each is imported, in some steps, by each (Kosaraju's two passes)."""

    def reached(start: str, edges: dict[str, set[str]], seen: set[str]) -> list[str]:
        order, stack = [], [(start, iter(edges[start]))]
        seen.add(start)
        while stack:
            at, following = stack[-1]
            for to in following:
                if to not in seen:
                    seen.add(to)
                    stack.append((to, iter(edges[to])))
                    break
            else:
                order.append(at)
                stack.pop()
        return order

    importers: dict[str, set[str]] = {m: set() for m in imports}
    for module, others in imports.items():
        for other in others:
            importers[other].add(module)
    seen: set[str] = set()
    order = [m for module in imports if module not in seen for m in reached(module, imports, seen)]
    seen, found = set(), []
    for module in reversed(order):
        if module not in seen:
            found.append(sorted(reached(module, importers, seen)))
    return [together for together in found if len(together) > 1]


@pytest.mark.parametrize(
    ("imports", "expected"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b"}, "b": {"c"}, "c": {"b"}}, [["b", "c"]]),
        ({"a": {"b", "d"}, "b": {"c"}, "c": {"a"}, "d": {"e"}, "e": {"d"}}, [["a", "b", "c"], ["d", "e"]]),
    ],
)
def test_a_circle_is_found(imports, expected):
    assert sorted(circles(imports)) == expected


def test_no_module_imports_itself_in_a_round():
    graph = grimp.build_graph(*PROJECT, exclude_type_checking_imports=True, cache_dir=None)
    imports = {m: set(graph.find_modules_directly_imported_by(m)) for m in graph.modules}
    assert len(imports) > 300
    assert circles(imports) == []
