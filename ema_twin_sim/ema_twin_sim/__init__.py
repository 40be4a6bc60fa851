"""The digital twin of an electromechanical actuator: physics, effects, comparison, nodes and command line.

The functions behind the commands, for notebooks::

    from ema_twin_sim import compare, load, load_model
    comparison = compare([load("run.CSV")], load_model("polito_bench"))
"""

import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ema_bench_replay.load import load
    from ema_twin_sim.comparison.compare import compare
    from ema_twin_sim.discovery.diagnose import diagnose
    from ema_twin_sim.discovery.discover import discover
    from ema_twin_sim.discovery.plan import plan
    from ema_twin_sim.effects import catalogue
    from ema_twin_sim.fitting.fit import fit_model as fit
    from ema_twin_sim.model import load_model, save_model
    from ema_twin_sim.own_effects import load_effect
    from ema_twin_sim.simulation.command import parse_command
    from ema_twin_sim.simulation.simulate import simulate
    from ema_twin_sim.simulation.simulate_many import simulate_many
    from ema_twin_sim.simulation.virtual_bench import virtual_bench

if "numpy" not in sys.modules:
    # the matrices of a search are tall and slim: threads of BLAS cost more than they give, and quarrel with our own
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_HOMES = {
    "catalogue": "ema_twin_sim.effects",
    "compare": "ema_twin_sim.comparison.compare",
    "diagnose": "ema_twin_sim.discovery.diagnose",
    "discover": "ema_twin_sim.discovery.discover",
    "fit": "ema_twin_sim.fitting.fit:fit_model",
    "load": "ema_bench_replay.load",
    "load_effect": "ema_twin_sim.own_effects",
    "load_model": "ema_twin_sim.model",
    "parse_command": "ema_twin_sim.simulation.command",
    "plan": "ema_twin_sim.discovery.plan",
    "save_model": "ema_twin_sim.model",
    "simulate": "ema_twin_sim.simulation.simulate",
    "simulate_many": "ema_twin_sim.simulation.simulate_many",
    "virtual_bench": "ema_twin_sim.simulation.virtual_bench",
}

__all__ = [
    "catalogue",
    "compare",
    "diagnose",
    "discover",
    "fit",
    "load",
    "load_effect",
    "load_model",
    "parse_command",
    "plan",
    "save_model",
    "simulate",
    "simulate_many",
    "virtual_bench",
]


def __getattr__(name: str) -> object:
    # on first use: the compiled physics takes half a second to import, and a launch file or --help needs none of it
    if name in _HOMES:
        home, _, function = _HOMES[name].partition(":")
        return getattr(import_module(home), function or name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
