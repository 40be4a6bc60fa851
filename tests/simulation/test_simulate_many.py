"""Many models at once are each the twin that they are alone."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim import parse_command, simulate, simulate_many, virtual_bench

SECONDS = 1.0
VARIED = ("machine.motor_inertia", "drive.speed_gain", "machine.torque_constant", "sensors.speed_smoothing")
TRANSMISSIONS = {
    "rigid": {},
    "shaft": {"shaft_compliance": {}},
    "play": {"backlash": {}},
    "bristle": {"presliding_friction": {}},
    "play and bristle": {"backlash": {}, "presliding_friction": {}},
    "late encoder": {"encoder_delay": {"delay": 7e-4}, "encoder_eccentricity": {}},
}


@pytest.fixture(scope="module")
def recording(stock):
    return virtual_bench(stock, parse_command("sine:0.02:1"), SECONDS)


def varied(model, count):
    """The model with its numbers off by up to some per cent, ``count`` times."""
    random = np.random.default_rng(0)
    models = []
    for _ in range(count):
        other = model
        for path in VARIED:
            other = other.with_value(path, model.value(path) * random.uniform(0.95, 1.05))
        models.append(other)
    return models


def check(models, recording, source=None, **options):
    together = simulate_many(models, recording, source, **options)
    for model, found in zip(models, together, strict=True):
        alone = simulate(model, recording, source, **options)
        assert found.metadata == alone.metadata
        assert set(found.signals) == set(alone.signals) - {"unexplained_torque"}
        for name, values in found.signals.items():
            np.testing.assert_allclose(values, alone.signals[name], rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("source", ["setpoint", "current"])
@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_each_model_is_the_twin_that_it_is_alone(transmission, source, stock, recording):
    model = stock
    for id, parameters in TRANSMISSIONS[transmission].items():
        model = model.with_effect(id, parameters)
    check(varied(model, 11), recording, source)


def test_models_of_all_kinds_may_come_together(stock, recording):
    models = varied(stock, 19) + varied(stock.with_effect("backlash"), 7)
    models += [
        stock.with_effect("stribeck_friction"),
        stock.with_effect("asymmetric_friction"),
        stock.with_effect("presliding_friction"),
        stock.with_value("drive.control_cycle", 2.5e-4),
    ]
    order = np.random.default_rng(1).permutation(len(models))
    check([models[k] for k in order], recording)


def test_a_step_of_its_own(stock, recording):
    check(varied(stock, 7), recording, step=5e-5)


def test_a_command_is_followed_too(stock, recording):
    check(varied(stock, 4), recording, "command")


def test_no_model_gives_no_recording(recording):
    assert simulate_many([], recording) == []


@pytest.fixture(scope="module")
def away(stock):
    """A model that nothing brakes, with hardly any inertia: a steady current drives it ever faster."""
    for name in stock.effects:
        stock = stock.with_enabled(name, False)
    for part in ("motor", "gearbox", "output"):
        stock = stock.with_value(f"machine.{part}_inertia", 0.0 if part == "gearbox" else 1e-9)
    return stock


def test_one_that_diverges_is_told_as_if_it_ran_alone(stock, away, monkeypatch):
    ramp = virtual_bench(stock, parse_command("ramp:0.05"), 3.0)
    monkeypatch.setattr("ema_twin_sim.simulation.twin.Twin._brought_back", lambda *_: False)
    messages = []
    for run in (
        lambda: simulate(away, ramp, "current"),
        lambda: simulate_many([*varied(stock, 6), away], ramp, "current"),
    ):
        with pytest.raises(InputError, match="diverges") as refused:
            run()
        messages.append(str(refused.value))
    assert messages[0] == messages[1]


@pytest.mark.parametrize("beside", [0, 6])
def test_one_that_runs_away_is_brought_back_as_if_it_ran_alone(stock, away, beside):
    ramp = virtual_bench(stock, parse_command("ramp:0.05"), 3.0)
    alone = simulate(away, ramp, "current").signals
    together = simulate_many([*varied(stock, beside), away], ramp, "current")[-1].signals
    assert np.abs(alone["speed"]).max() > 1e7
    for name in ("speed", "motor_position", "output_position"):
        np.testing.assert_array_equal(together[name], alone[name])
