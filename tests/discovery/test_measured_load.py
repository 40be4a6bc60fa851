"""A load that a sensor measures is no missing effect: it acts in every motion, as it does at operating points."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.comparison.torque_error import torque_error
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.simulate_many import simulate_many
from ema_twin_sim.simulation.twin import Twin
from tests.discovery.test_mesh_friction import rms, torque_missed
from tests.recorded import changed

COUNT, PERIOD = 4000, 2_000_000


def without_load(recording):
    return replace(recording, signals={n: v for n, v in recording.signals.items() if n != "load_torque"})


def braked(model, seed, *, rate=0.3, noise=True, load=0.6):
    """A run of a machine whose output a brake holds up: the torque wanders by itself, and is measured."""
    rng = np.random.default_rng(seed)
    time = np.arange(COUNT) * 2e-3
    wandering = load * np.interp(time, np.arange(0.0, 9.0, 0.4), rng.uniform(-1.0, 1.0, 23))
    setpoint = 6.0 * np.sin(2.0 * math.pi * rate * time)
    asked = {"speed_setpoint": setpoint, "load_torque": wandering}
    asked = Recording(f"brake_{seed}", np.arange(COUNT) * PERIOD, asked)
    own = simulate(model, asked, "setpoint")
    signals = {n: own.signals[n].copy() for n in ("current", "speed", "motor_position", "output_position")}
    if noise:
        signals["current"] += model.value("sensors.current_noise") * rng.standard_normal(COUNT)
        signals["speed"] += model.value("sensors.speed_noise") * rng.standard_normal(COUNT)
    return replace(asked, signals={**signals, **asked.signals})


@pytest.fixture(scope="module")
def runs(stock):
    return [braked(stock, 1), braked(stock, 2, rate=0.5)]


def test_a_measured_load_opposes_positive_motion(stock):
    """As at operating points: at constant speed the drive gives the friction and the load, whichever way."""
    for load in (0.4, -0.4):
        held = {"speed_setpoint": np.full(COUNT, 5.0), "load_torque": np.full(COUNT, load)}
        settled = simulate(stock, Recording("held", np.arange(COUNT) * PERIOD, held), "setpoint").signals["current"][-1]
        speed = np.full(20, 5.0)
        signals = {"speed": speed, "current": np.ones(20), "load_torque": np.full(20, load)}
        points = Recording("points", np.arange(20) * 10**9, signals, metadata={POINTS: "yes"})
        assert settled == pytest.approx(simulate(stock, points).signals["current"][0], rel=1e-3)


@pytest.mark.slow
def test_discover_takes_it_for_what_it_is(stock, runs):
    found = discover(runs, stock)
    assert found.verdict == "none" and not found.added
    blind = discover([without_load(run) for run in runs], stock)
    assert blind.verdict != "none"


@pytest.mark.parametrize("source", ["setpoint", "current"])
def test_compare_and_the_simulations_take_it(stock, runs, source):
    signal = "current" if source == "setpoint" else "unexplained_torque"
    seen = compare(runs, stock, source).overall[signal]
    blind = compare([without_load(run) for run in runs], stock, source).overall[signal]
    most = 1.3 if source == "setpoint" else 3.0  # at reversals the balance smears the step of dry friction
    assert seen["rmse"] < most * seen["noise_floor"]
    assert blind["rmse"] > 10.0 * seen["rmse"]


def test_fit_takes_it_by_both_methods(stock, runs):
    start = stock.with_value("effects.viscous_friction.coefficient", 0.03)
    for method in ("equation", "simulation"):
        told = fit_model(runs, start, method=method).parameters["viscous_friction"]["coefficient"]
        assert told["value"] == pytest.approx(0.0255, rel=0.03)


@pytest.mark.parametrize("spring", [False, True])
def test_all_forms_of_the_plant_agree(stock, spring):
    """Kernel, models side by side, balance, inverse dynamics and the live twin, sample by sample."""
    model = stock.with_effect("mesh_friction", {"coefficient": 0.2})
    if spring:
        model = model.with_effect("shaft_compliance", {"stiffness": 60.0, "damping": 0.2})
    run = braked(model, 3, noise=False)
    size = rms(model.value("machine.torque_constant") * run.signals["current"])
    left = simulate(model, run, "current").signals["unexplained_torque"]
    moving = np.convolve(np.abs(run.signals["speed"]) < 1.0, np.ones(101), "same") == 0
    moving[:250] = False
    assert rms(left[moving]) < 0.02 * size
    assert rms(torque_missed(run, model)) < 0.02 * size
    if not spring:
        assert torque_error(run, model).filtered < 0.1 < torque_error(without_load(run), model).filtered

    whole = simulate(model, run, "setpoint")
    twin = Twin(model, "setpoint")
    rows = []
    for k in range(300):
        sample = {name: float(values[k]) for name, values in run.signals.items()}
        rows.append(twin.advance(PERIOD, sample) if k else twin.start(sample))
    assert [row["current"] for row in rows] == list(whole.signals["current"][:300])


@pytest.mark.parametrize("transmission", ["rigid", "two_inertia"])
def test_models_side_by_side_carry_it(stock, transmission):
    model = replace(stock, kinds={**stock.kinds, "transmission": transmission})
    run = braked(model, 4, noise=False)
    models = [model.with_value("machine.motor_inertia", (1.0 + 0.01 * k) * 7.7e-4) for k in range(6)]
    for m, beside in zip(models, simulate_many(models, run), strict=True):
        own = simulate(m, run, "setpoint")
        for name in ("current", "speed", "output_position", "load_torque"):
            assert beside.signals[name] == pytest.approx(own.signals[name], rel=1e-9, abs=1e-9)


def test_where_it_has_no_value_the_one_before_holds(stock):
    run = braked(stock, 5, noise=False)
    holed, held = (run.signals["load_torque"].copy() for _ in range(2))
    holed[100:110] = math.nan
    held[100:110] = held[99]
    one, other = (changed(run, load_torque=values) for values in (holed, held))
    assert np.array_equal(simulate(stock, one).signals["current"], simulate(stock, other).signals["current"])
    assert np.array_equal(observe(one, stock).motion, observe(other, stock).motion)
