"""What a step of each fidelity costs, on one core: it depends on the machine, so it is measured only when asked for."""

from __future__ import annotations

import time
from dataclasses import replace

from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.twin import Twin

from .bench import follow, planetary
from .number import Number

ROUNDS = 20
STEPS = 200_000
SPEED = 6.2  # rad/s of the motor


def models() -> dict[str, tuple[object, bool]]:
    """(model, whether energies are booked) by name."""
    stock, high, highest = (load_model(name) for name in ("polito_bench", "polito_hf", "polito_hff"))
    two = replace(stock, kinds={**stock.kinds, "transmission": "two_inertia"})
    return {
        "averaged_rigid": (stock, False),
        "averaged_two": (two, False),
        "switching_rigid": (high, False),
        "averaged_planetary": (planetary(), False),
        "switching_planetary": (highest, False),
        "accounting": (highest, True),
    }


def timings() -> dict[str, Number]:
    """Nanoseconds a step and times real time of each fidelity, the fastest of many rounds in turn."""
    twins = {name: Twin(model, "setpoint", accounting=booked) for name, (model, booked) in models().items()}  # type: ignore[arg-type]
    best = dict.fromkeys(twins, float("inf"))
    for _ in range(ROUNDS):
        for name, twin in twins.items():
            twin.start({"speed": SPEED, "speed_setpoint": SPEED, "current": 0.15})
            begin = time.process_time()
            follow(twin, STEPS * twin.step, 2e-3, speed_setpoint=SPEED)
            best[name] = min(best[name], time.process_time() - begin)
    found: dict[str, Number] = {}
    for name, seconds in best.items():
        found[f"ns_{name}"] = Number(1e9 * seconds / STEPS)
        found[f"times_{name}"] = Number(STEPS * twins[name].step / seconds)
    return found
