"""The digital twin of an electromechanical actuator: physics, effects, comparison, nodes and command line.

The functions behind the commands, for notebooks::

    from ema_twin_sim import compare, load, load_model
    comparison = compare([load("run.CSV")], load_model("polito_bench"))
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ema_bench_replay.recording import load
    from ema_twin_sim.command import parse_command
    from ema_twin_sim.comparison import compare
    from ema_twin_sim.effects import catalogue
    from ema_twin_sim.model_file import load_model, save_model
    from ema_twin_sim.simulation import simulate, virtual_bench

_HOMES = {
    "catalogue": "ema_twin_sim.effects",
    "compare": "ema_twin_sim.comparison",
    "load": "ema_bench_replay.recording",
    "load_model": "ema_twin_sim.model_file",
    "parse_command": "ema_twin_sim.command",
    "save_model": "ema_twin_sim.model_file",
    "simulate": "ema_twin_sim.simulation",
    "virtual_bench": "ema_twin_sim.simulation",
}

__all__ = [
    "catalogue",
    "compare",
    "load",
    "load_model",
    "parse_command",
    "save_model",
    "simulate",
    "virtual_bench",
]


def __getattr__(name: str) -> object:
    # on first use: the compiled physics takes half a second to import, and a launch file or --help needs none of it
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
