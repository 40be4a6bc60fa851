"""Load the compiled code (compile it the first time) before a node has to be in time. No ROS."""

from __future__ import annotations

from ..model import Model
from ..simulation.twin import Twin


def warm_up_twin(model: Model, source: str) -> None:
    """Run one step of a separate twin: the first step in a process can take seconds."""
    twin = Twin(model, source)
    twin.start({})
    twin.advance(1_000_000, {})
