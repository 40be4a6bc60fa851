"""Angles count from the encoder's own zero, of the output too: what is found on one recording holds on the next."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording, moved_origin
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.diagnose import diagnose
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.live.follower import Follower
from ema_twin_sim.simulation.angle_origins import angle_origins, without_common_zero
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.twin import Twin
from tests.trace_text import write_columns

PERIOD, COUNT = 2_000_000, 5000
RATIO = 12.0
MAP = """version: 1
time: {column: time, unit: s}
signals:
  current: {columns: [current], unit: A}
  speed: {columns: [speed], unit: rad/s}
  speed_setpoint: {columns: [setpoint], unit: rad/s}
  motor_position: {columns: [position], unit: rad}
"""


@pytest.fixture(scope="module")
def geared(stock):
    """The stock machine with another gearbox, that swings an arm through half a turn; no encoder on its output."""
    return stock.with_value("machine.gear_ratio", RATIO)


def swung(model, start, rate, seed):
    """A run that begins where the output stands at ``start`` [rad], as a drive without an output encoder records it."""
    rng = np.random.default_rng(seed)
    time = np.arange(COUNT) * PERIOD * 1e-9
    asked = {"speed_setpoint": 9.0 * np.sin(2.0 * math.pi * rate * time)}
    origin = RATIO * start
    own = simulate(model, Recording(f"from_{start:g}", np.arange(COUNT) * PERIOD, asked, motor_angle_origin=origin))
    signals = {**asked, **{name: own.signals[name].copy() for name in ("current", "speed", "motor_position")}}
    signals["current"] += model.value("sensors.current_noise") * rng.standard_normal(COUNT)
    signals["speed"] += model.value("sensors.speed_noise") * rng.standard_normal(COUNT)
    return replace(own, signals=signals)


def read_again(recording, folder):
    """The recording through a CSV that holds positions as its encoder shows them."""
    names = {"current": "current", "speed": "speed", "setpoint": "speed_setpoint", "position": "motor_position"}
    columns = {"time": recording.time, **{word: recording.signals[name] for word, name in names.items()}}
    columns["position"] = columns["position"] + recording.motor_angle_origin
    (folder / "map.yaml").write_text(MAP)
    return load(write_columns(folder / f"{recording.name}.csv", columns), import_map=folder / "map.yaml")


@pytest.fixture(scope="module")
def heavy(geared):
    return geared.with_effect("gravity_load", {"torque": 0.3, "angle": 0.4})


@pytest.fixture(scope="module")
def runs(heavy, tmp_path_factory):
    """Three runs from three places, read from traces."""
    folder = tmp_path_factory.mktemp("traces")
    places = ((0.0, 0.12, 1), (1.3, 0.17, 2), (-2.0, 0.2, 3))
    return [read_again(swung(heavy, *place), folder) for place in places]


def unknown(recordings):
    return [replace(run, motor_angle_origin=math.nan) for run in recordings]


def test_the_motors_counter_tells_where_the_output_stands():
    assert angle_origins(24.0, math.nan, 12.0) == (24.0, 2.0)
    assert angle_origins(24.0, 0.5, 12.0) == (24.0, 0.5)
    assert angle_origins(math.nan, math.nan, 12.0) == (0.0, 0.0)
    assert angle_origins(math.nan, 0.5, 12.0) == (0.0, 0.5)


def test_a_position_that_does_not_begin_at_zero_is_an_angle():
    assert moved_origin(1.0, 0.5) == 1.5
    assert moved_origin(math.nan, 0.5) == 0.5
    assert math.isnan(moved_origin(math.nan, 0.0))


def test_what_is_found_on_two_recordings_holds_on_the_third(geared, runs):
    found = discover(runs[:2], geared)
    assert found.verdict == "explained" and set(found.added) == {"gravity_load"}
    gravity = found.parameters["gravity_load"]
    assert gravity["torque"]["value"] == pytest.approx(0.3, rel=0.02)
    assert gravity["angle"]["value"] == pytest.approx(0.4, abs=0.02)
    assert not any("zero" in text or "own angle" in text for text in found.warnings)
    for source in ("setpoint", "current"):
        signal = "current" if source == "setpoint" else "unexplained_torque"
        error = compare(runs[2:], found.model, source).overall[signal]
        assert error["rmse"] < 3.0 * error["noise_floor"]
        lost = compare(unknown(runs[2:]), found.model, source).overall[signal]
        assert lost["rmse"] > 10.0 * error["rmse"]


def test_a_live_twin_counts_from_there_too(heavy, runs):
    run = runs[1]
    whole = simulate(heavy, run, "setpoint").signals["current"]
    twin = Twin(heavy, "setpoint")
    follower = Follower(heavy, "setpoint")
    absolute = {**run.signals, "motor_position": run.signals["motor_position"] + run.motor_angle_origin}
    for k in range(50):
        sample = {name: float(values[k]) for name, values in run.signals.items()}
        row = twin.advance(PERIOD, sample) if k else twin.start(sample, run.motor_angle_origin)
        assert row["current"] == whole[k]
        raw = {name: float(values[k]) for name, values in absolute.items()}
        raw |= dict.fromkeys(
            ("output_position", "output_command", "motor_angle_origin", "output_angle_origin"), math.nan
        )
        answer = follower.answer(1, k, 1 + k * PERIOD, raw)
        assert answer["current"] == pytest.approx(whole[k], abs=1e-6)


def test_where_no_zero_is_known_every_verb_says_so_in_one_sentence(heavy, geared, runs):
    blind = unknown(runs[:1])
    told = [text for text in compare(blind, heavy).warnings if "own angle is not known" in text]
    assert len(told) == 1 and "gravity_load" in told[0] and runs[0].name in told[0] and "\n" not in told[0]
    assert told[0] in [warning.message for warning in fit_model(blind, heavy, method="equation").warnings]
    found = discover(blind, geared)
    assert set(found.added) == {"gravity_load"} and told[0] in found.warnings
    assert told[0] in diagnose(blind, geared).warnings
    assert not [text for text in compare(blind, geared).warnings if "own angle" in text]
    assert not [text for text in compare(runs, heavy).warnings if "own angle" in text]


def test_only_what_acts_at_an_angle_is_told_of(stock, runs):
    blind = unknown(runs)
    for id, tells in (("tooth_fault", True), ("cogging", True), ("spring_load", False), ("backlash", False)):
        instances = [stock.with_effect(id).effects[id]]
        assert bool(without_common_zero(blind, instances)) == tells
        assert not without_common_zero(runs, instances)
    placed = stock.with_effect("spring_load", {"angle": -2.0}, {"relaxed": "angle"}).effects["spring_load"]
    assert without_common_zero(blind, [placed]) and not without_common_zero(runs, [placed])
    known = [replace(run, output_angle_origin=0.2) for run in blind]
    assert not without_common_zero(known, [stock.with_effect("output_ripple").effects["output_ripple"]])
