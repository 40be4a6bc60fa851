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


@cache
def exists(parts: Module) -> bool:
    """Whether the package has a module or a folder of these parts."""
    path = PACKAGE.joinpath(*parts)
    return path.with_suffix(".py").exists() or (path / "__init__.py").exists()


def imports(file: Path, *, typing: bool = True) -> tuple[Module, ...]:
    """The parts of each module imported, a library by its name; without ``typing`` not what a type checker needs."""
    return tuple(wanted for wanted, types_only in _imports(file) if typing or not types_only)


@cache
def _imports(file: Path) -> tuple[tuple[Module, bool], ...]:
    """Each module imported, and whether a type checker alone needs it; a file is read once."""
    return tuple(_read(file))


def _read(file: Path) -> Iterator[tuple[Module, bool]]:
    here = place(file)
    waiting: list[tuple[ast.AST, bool]] = [(node, False) for node in ast.parse(file.read_text()).body]
    while waiting:
        node, types_only = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            types_only = True
        if isinstance(node, ast.Import):
            yield from (((alias.name.split(".")[0],), types_only) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            name = node.module or ""
            yield (NODES if name.startswith(NODES) else name.split(".")[0],), types_only
        elif isinstance(node, ast.ImportFrom):
            above = (*here[: len(here) - node.level], *filter(None, (node.module or "").split(".")))
            for alias in node.names:
                inner = (*above, alias.name)
                yield inner if exists(inner) else above, types_only
        waiting += ((child, types_only) for child in ast.iter_child_nodes(node))


def arrows(*, typing: bool = True) -> Iterator[tuple[Module, Module]]:
    """(file, what it imports) of every import within the package, but for those of the package's own names."""
    for file in files():
        if place(file) != ("__init__",):
            yield from ((place(file), wanted) for wanted in imports(file, typing=typing) if wanted and exists(wanted))
