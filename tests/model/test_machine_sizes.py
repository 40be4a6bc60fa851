"""Machines of all sizes: whatever is possible of one is written, read back and simulated, and never refused."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.effects import catalogue
from ema_twin_sim.effects.effect import POSITIVE
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.simulation.simulate import simulate
from tests.large_arm import open_arm, swings_of

SIZES = (1e-6, 1e3)  # kg m2, at the motor
STOCK = 1.8e-3  # the stock machine's
POWERS = {"N m": 1, "N m s/rad": 1, "N m/rad": 1, "N m s^2/rad^2": 1, "kg m^2": 1, "N m/A": 1, "V s/rad": 1}


def of_size(stock, inertia):
    """The stock machine with every torque, inertia and stiffness as many times its own."""
    factor = inertia / STOCK
    by_path = {p: held.value * factor for p, held in stock.constants.items() if stock.unit(p) in POWERS}
    constants = {p: replace(held, value=by_path.get(p, held.value)) for p, held in stock.constants.items()}
    effects = {name: instance.at(scaled(instance, factor)) for name, instance in stock.effects.items()}
    return replace(stock, constants=constants, effects=effects)


def scaled(instance, factor):
    units = {p.name: p.unit for p in catalogue()[instance.effect].parameters}
    return {name: value * (factor if units[name] in POWERS else 1.0) for name, value in instance.parameters.items()}


def extremes(effect, options, factor):
    """Each parameter at its bounds, and at a hundredth and ten times what is usual where it has none."""
    table = effect.parameters_with(options)
    usual = {p.name: p.default * (factor if p.unit in POWERS else 1.0) for p in table}
    for p in table:
        ends = [end for end in (p.lower, p.upper) if math.isfinite(end) and end != POSITIVE]
        if math.isinf(p.upper):
            ends += [max(p.lower, usual[p.name] * share) for share in (0.01, 10.0)]
        for value in ends:
            yield {**usual, p.name: value}


def choices():
    for id, effect in sorted(catalogue().items()):
        for choice in itertools.product(*effect.options.values()):
            yield id, dict(zip(effect.options, choice, strict=True))


@pytest.mark.parametrize("inertia", SIZES)
@pytest.mark.parametrize(("id", "options"), list(choices()))
def test_every_possible_number_is_written_read_and_simulated(stock, tmp_path, inertia, id, options):
    machine = of_size(stock, inertia)
    bench = Recording(
        "run",
        np.arange(60) * 2_000_000,
        {"current": 0.2 * np.sin(np.arange(60) / 10.0), "speed": np.zeros(60), "motor_position": np.zeros(60)},
    )
    base = machine if catalogue()[id].repeatable else machine.without_effect(id) if id in machine.effects else machine
    for parameters in extremes(catalogue()[id], options, inertia / STOCK):
        model = base.with_effect(id, parameters, options)
        read = load_model(save_model(model, tmp_path / "model.yaml", force=True))
        assert dict(read.effects) == dict(model.effects)
        assert dict(read.constants) == dict(model.constants)
        own = simulate(read, bench, "current")
        assert all(np.isfinite(own.signals[name]).all() for name in ("speed", "motor_position", "output_position"))


def test_a_model_that_would_not_load_again_is_no_result(stock, tmp_path):
    instance = stock.with_effect("gravity_load").effects["gravity_load"]
    wrong = instance.at({**instance.parameters, "torque": -1.0})
    with pytest.raises(RuntimeError, match=r"would not load again.*gravity_load\.torque"):
        save_model(replace(stock, effects={**stock.effects, "gravity_load": wrong}), tmp_path / "model.yaml")
    assert not (tmp_path / "model.yaml").exists()


@pytest.mark.parametrize("verb", ["discover", "fit"])
def test_an_open_arm_is_found_with_its_angle_and_loads_again(verb, tmp_path):
    arm = open_arm()
    swings = swings_of(arm)
    found = discover(swings, arm) if verb == "discover" else fit_model(swings, arm, method="equation")
    read = load_model(save_model(found.model, tmp_path / "model.yaml"))
    gravity = read.effects["gravity_load"].parameters
    assert gravity["torque"] == pytest.approx(300.0, rel=0.01)
    assert gravity["angle"] == pytest.approx(2.5, abs=0.01)
    assert read.effects["viscous_friction"].parameters["coefficient"] == pytest.approx(30.0, rel=0.02)
    assert read.value("machine.motor_inertia") == pytest.approx(40.0, rel=0.02)
    if verb == "discover":
        assert not found.added
        told = found.constants["gravity_load"]
        assert abs(told["angle"]["value"] - 2.5) < 4.0 * told["angle"]["std"] + 1e-3
