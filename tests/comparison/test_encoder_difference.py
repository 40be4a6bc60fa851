"""Driven by the measured current, a model is judged by the difference between the encoders, too."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.comparison.closeness import closer
from ema_twin_sim.comparison.compare import compare, overall_errors
from ema_twin_sim.measured.noise import noise_of
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.encoder_difference import holds_both_encoders
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.recorded import record, with_signals

POSITIONS = ("motor_position", "output_position")
SHOWN_BY_ENCODERS = {
    "backlash": {"width": 0.002},
    "encoder_delay": {"delay": 0.006},
    "encoder_eccentricity": {},
    "shaft_compliance": {},
}


def error(recordings, model):
    return compare(recordings, model, "current").overall["encoder_difference"]


@pytest.mark.parametrize("effect", SHOWN_BY_ENCODERS)
def test_what_parts_the_encoders_shows_until_it_is_added(effect, stock):
    right = stock.with_effect(effect, SHOWN_BY_ENCODERS[effect])
    recordings = record(right)
    before, after = (error(recordings, model) for model in (stock, right))
    assert before["rmse"] > 5.0 * before["noise_floor"]
    assert after["rmse"] < 1.6 * after["noise_floor"]


def test_without_anything_between_the_encoders_it_is_their_noise(stock):
    found = error(record(stock), stock)
    assert found["rmse"] == pytest.approx(found["noise_floor"], rel=0.03)
    assert found["unit"] == "rad" and not found["driven"]


def test_a_measured_load_winds_the_shaft_up(stock):
    """A soft shaft under 0.5 N m from the middle of the recording on: without the load it would be straight."""
    soft = stock.with_effect("shaft_compliance")
    (bench,) = record(soft, ("sine:0.05:0.4",))
    load = np.where(bench.time > 3.0, 0.5, 0.0)
    pulled = simulate(soft, with_signals(bench, {**bench.signals, "load_torque": load}), "setpoint")
    unloaded = with_signals(bench, {name: pulled.signals[name] for name in ("current", *POSITIONS)})
    loaded = with_signals(bench, {**unloaded.signals, "load_torque": load})
    assert error([loaded], soft)["rmse"] < 0.1 * error([unloaded], soft)["rmse"]


def test_it_is_that_of_whole_recordings_with_both_encoders(stock):
    (recording,) = record(stock, ("sine:0.05:0.4",))
    assert "encoder_difference" not in compare([recording], stock, "setpoint").overall  # its loop shows the output
    for name in POSITIONS:
        others = {other: values for other, values in recording.signals.items() if other != name}
        assert "encoder_difference" not in compare([replace(recording, signals=others)], stock, "current").overall


def test_a_slide_shows_it_in_its_own_unit():
    model = load_model("emps")
    recording = virtual_bench(model, parse_command("sine:0.05:0.5"), 6.0, seed=1)
    found = error([recording], model)
    assert found["unit"] == "m"
    assert found["rmse"] == pytest.approx(found["noise_floor"], rel=0.2)


def test_all_that_compares_judges_by_it(stock):
    right = stock.with_effect("backlash", SHOWN_BY_ENCODERS["backlash"])
    recordings = [with_signals(r, {n: v for n, v in r.signals.items() if n != "speed_setpoint"}) for r in record(right)]
    given, found = (compare(recordings, model) for model in (stock, right))
    _, pooled = overall_errors(recordings, right, noise_of(recordings, right))
    assert pooled["encoder_difference"]["rmse"] == pytest.approx(found.overall["encoder_difference"]["rmse"])
    assert closer(given, found).overall["encoder_difference"].times > 10.0
    (best, *_) = (d for d in given.where if d.signal == "encoder_difference")
    assert best.variable in ("speed", "direction")


def test_a_motor_that_hardly_moves_is_compared(stock):
    """Its own unit of time is hours: stamps in whole nanoseconds of it would fall together."""
    noise = np.random.default_rng(1).normal(size=3001)
    time = np.arange(3001) * 2e-3
    creeping = {"current": 0.1 + 3e-3 * noise, "motor_position": 1e-5 * time / 6.0, "output_position": np.zeros(3001)}
    assert error([Recording("creep", np.arange(3001) * 2_000_000, creeping)], stock)["rmse"] < 1e-5


def test_uneven_stamps_are_no_error_of_an_encoder(stock):
    right = stock.with_effect("backlash", SHOWN_BY_ENCODERS["backlash"])
    (run,) = record(right, ("sine:0.05:0.4",))
    jitter = np.random.default_rng(1).uniform(-4e5, 4e5, len(run)).astype(np.int64)
    jitter[0] = 0
    uneven = run.time + jitter * 1e-9
    moved = {name: np.interp(uneven, run.time, values) for name, values in run.signals.items()}
    before, after = (error([runs], right)["rmse"] for runs in (run, with_signals(run, moved, run.stamps + jitter)))
    assert after < 1.1 * before


def test_a_load_with_gaps_leaves_the_rest_known(stock):
    soft = stock.with_effect("shaft_compliance")
    (run,) = record(soft, ("sine:0.05:0.4",))
    load = np.zeros(len(run))
    whole = error([with_signals(run, {**run.signals, "load_torque": load.copy()})], soft)
    load[[0, 1000]] = np.nan
    found = error([with_signals(run, {**run.signals, "load_torque": load})], soft)
    assert found["rmse"] == pytest.approx(whole["rmse"], rel=0.01)


def test_a_simulated_gear_train_is_judged_without_it():
    model = load_model("polito_hf")
    toothed = load_model("polito_hff")
    (recording,) = record(load_model("polito_bench"), ("ramp:0.05",), 1.0)
    assert "encoder_difference" in compare([recording], model, "current").overall
    assert "encoder_difference" not in compare([recording], toothed, "current").overall


@pytest.mark.parametrize(
    ("motor", "output", "held"),
    [(slice(0, 30), slice(30, 60), False), (slice(0, 31), slice(30, 60), True)],
)
def test_some_sample_holds_both_positions(motor, output, held):
    positions = np.full((2, 60), np.nan)
    positions[0, motor] = positions[1, output] = 1.0
    signals = dict(zip(POSITIONS, positions, strict=True))
    assert holds_both_encoders(Recording("run", np.arange(60) * 2_000_000, signals)) == held
