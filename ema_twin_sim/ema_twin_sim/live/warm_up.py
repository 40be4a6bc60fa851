"""Compiled code is loaded, and the first time compiled, before a node promises to be in time. No ROS."""

from __future__ import annotations

from ..model import Model
from ..simulation.sensor_noise import noise_floors
from ..simulation.twin import Twin


def warm_up_twin(model: Model, source: str) -> None:
    """Let another twin take one step: the first one in a process can take seconds."""
    twin = Twin(model, source)
    twin.start({})
    twin.advance(1_000_000, {})


def warm_up_comparison(model: Model) -> None:
    """Work out the sensors' noise floors once: a comparison does so when it is first asked."""
    noise_floors(model)
