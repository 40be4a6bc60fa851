"""Text of a node's ``--help``: its parameters with default, range, unit and meaning, and an example. No ROS."""

from __future__ import annotations

from collections.abc import Sequence

from .parameters import Declaration


def parameter_help(node: str, parameters: Sequence[Declaration]) -> str:
    """Help lines of all ``parameters`` of a node of that name; the example sets the first of them."""
    lines = [f"Parameters of the node {node}, each given as --ros-args -p NAME:=VALUE:", ""]
    for p in parameters:
        default = ", ".join(p.default) if isinstance(p.default, tuple) else p.default
        shown = str(default).lower() if isinstance(default, bool) else str(default)
        told = f"default {shown}" if shown else "no default"
        within = f"; {p.range}" if p.range else ""
        lines.append(f"  {p.name}: {p.description} ({told}{within})")
    first = parameters[0]
    shown = first.default if isinstance(first.default, str) and first.default else "PATH"
    return "\n".join([*lines, "", f"Example: {node} --ros-args -p {first.name}:={shown}"])
