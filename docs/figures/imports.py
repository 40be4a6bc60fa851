"""What each file of the twin's package imports, read from its text: who needs whom, without running any of it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "ema_twin_sim" / "ema_twin_sim"
NODES = "ema_bench_replay.nodes"
"""Of the other package, the part that is ROS; it counts as a library of its own."""

Module = tuple[str, ...]


def files() -> list[Path]:
    """Every module of the package."""
    return sorted(PACKAGE.rglob("*.py"))


def place(file: Path) -> Module:
    """A module by its parts within the package."""
    return file.relative_to(PACKAGE).with_suffix("").parts


def exists(parts: Module) -> bool:
    """Whether the package has a module or a folder of these parts."""
    path = PACKAGE.joinpath(*parts)
    return path.with_suffix(".py").exists() or (path / "__init__.py").exists()


@cache
def imports(file: Path, *, typing: bool = True) -> tuple[Module, ...]:
    """The parts of each module imported, a library by its name; without ``typing`` not what a type checker needs."""
    return tuple(_imports(file, typing))


def _imports(file: Path, typing: bool) -> Iterator[Module]:
    here = place(file)
    waiting: list[ast.AST] = list(ast.parse(file.read_text()).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and not typing and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import):
            yield from ((alias.name.split(".")[0],) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            name = node.module or ""
            yield (NODES if name.startswith(NODES) else name.split(".")[0],)
        elif isinstance(node, ast.ImportFrom):
            above = (*here[: len(here) - node.level], *filter(None, (node.module or "").split(".")))
            for alias in node.names:
                inner = (*above, alias.name)
                yield inner if exists(inner) else above
        waiting += ast.iter_child_nodes(node)


def arrows(*, typing: bool = True) -> Iterator[tuple[Module, Module]]:
    """(file, what it imports) of every import within the package, but for those of the package's own names."""
    for file in files():
        if place(file) != ("__init__",):
            yield from ((place(file), wanted) for wanted in imports(file, typing=typing) if wanted and exists(wanted))
