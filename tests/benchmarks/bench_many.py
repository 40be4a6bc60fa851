"""Many models at once beside one at a time: the equations side by side, and whole recordings.

Process time counts all threads; no lock keeps them from each other, so that each core adds its rate.
"""

import os

import numpy as np
import pytest

from ema_twin_sim import load_model, parse_command, simulate, simulate_many, virtual_bench
from ema_twin_sim.plant.kernel import kernel
from ema_twin_sim.plant.layout import BENCH, SETPOINT, TWIN
from ema_twin_sim.plant.many import LANE, advance_many
from ema_twin_sim.simulation.fidelity import DEFAULT_STEP, resting_state
from ema_twin_sim.simulation.twin import Twin
from tests.benchmarks.timing import fastest

SECONDS = 1.0
LONG = 20.0  # s of a whole recording
ROUNDS = 200
MODELS = 32
TRANSMISSIONS = {"rigid": None, "two inertias": "shaft_compliance", "two inertias with play": "backlash"}


def varied(model, count):
    """The model with another inertia each time."""
    path = "machine.motor_inertia"
    return [model.with_value(path, model.value(path) * (0.9 + 0.2 * k / count)) for k in range(count)]


def equations(model):
    """Calls that integrate one model, and LANE of them side by side, with no overhead around them."""
    count = round(SECONDS / 2e-3) + 1
    stamps = np.arange(count, dtype=np.int64) * 2_000_000
    bench = np.full((count, len(BENCH)), np.nan)
    bench[:, BENCH.index("load_torque")] = 0.0
    bench[:, BENCH.index("speed_setpoint")] = 5.0 * np.cos(np.pi * stamps * 1e-9)
    twins = [Twin(one, "setpoint") for one in varied(model, LANE)]
    for twin in twins:
        twin.start({"speed": 5.0, "speed_setpoint": 5.0})
    plants = np.concatenate([twin.assembly.plant for twin in twins])
    states = np.concatenate([twin.state for twin in twins])
    first = twins[0].assembly
    of_model = (first.acting, first.effects, (*resting_state(first.fine),))
    row, rows = np.zeros((count, len(TWIN))), np.zeros((LANE, count, len(TWIN)))
    advance = kernel(False, False)

    def one():
        advance(first.plant, states[:1].copy(), *of_model, SETPOINT, stamps, bench, row, DEFAULT_STEP, True)

    def many():
        advance_many(plants, states.copy(), SETPOINT, stamps, bench, rows, DEFAULT_STEP)

    return one, many


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_rate_of_many_models(transmission, say):
    effect = TRANSMISSIONS[transmission]
    model = load_model("polito_bench")
    model = model.with_effect(effect) if effect else model
    steps = SECONDS / DEFAULT_STEP
    single, together = fastest(ROUNDS, *equations(model))
    together /= LANE

    models = varied(model, MODELS)
    recording = virtual_bench(model, parse_command("sine:0.02:1"), LONG)
    by_one, by_many = fastest(20, lambda: simulate(model, recording), lambda: simulate_many(models, recording))
    by_one *= SECONDS / LONG
    by_many *= SECONDS / LONG / MODELS
    cores = os.cpu_count()
    rows = (
        ("kernel, one model", single, single),
        (f"{LANE} models side by side", together, single),
        ("simulate, a whole recording", by_one, by_one),
        (f"simulate_many, {MODELS} models", by_many, by_one),
        (f"simulate_many, {MODELS} models, {cores} cores", by_many / cores, by_one),
    )
    say(f"\n  {transmission + ', step 25 µs':<46}{'ns a step':>10}{'× real time':>13}{'× rate':>8}")
    for name, taken, alone in rows:
        say(f"  {name:<46}{1e9 * taken / steps:>10.2f}{SECONDS / taken:>13.0f}{alone / taken:>8.1f}")
    assert cores * single / together >= 5.0
    assert cores * by_one / by_many >= 5.0
