"""A model that states no noise of its sensors gets that of the recordings, and says so."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.measured.unstated_noise import with_noise_of
from ema_twin_sim.model import load_model
from tests.command_line import done
from tests.trace_text import write_columns

NOISE, STEP = 50.0, 1e-4
RNG = np.random.default_rng(5)
TIME = np.arange(4000) * 1e-2
ANGLE = np.sin(0.4 * TIME) + 0.2 * np.sin(1.3 * TIME)
SPEED = np.gradient(ANGLE, TIME)
TORQUE = 42e3 * np.gradient(SPEED, TIME) + 6e3 * np.sign(SPEED)


def hoist(folder, sensors=""):
    place = folder / "hoist.yaml"
    place.write_text(
        "version: 1\nmachine:\n  name: hoist\n  inertia: {value: 42000, unit: kg m^2, tolerance: 0.05}\n"
        f'  gear_ratio: {{value: 1, unit: "1", tolerance: 0.0}}\ntransmission: {{kind: rigid}}\n{sensors}'
    )
    return place


def recorded(drive):
    signals = {
        "motor_position": ANGLE + RNG.normal(0.0, STEP, len(TIME)),
        "speed": SPEED + RNG.normal(0.0, 2e-4, len(TIME)),
        drive: TORQUE + RNG.normal(0.0, NOISE, len(TIME)),
    }
    return Recording("run", np.arange(len(TIME)) * 10_000_000, signals)


@pytest.mark.parametrize(("drive", "said"), [("motor_torque", "torque "), ("current", "current ")])
def test_the_noise_of_the_recordings_is_taken_where_none_is_stated(tmp_path, drive, said):
    run, model = recorded(drive), load_model(hoist(tmp_path))
    found, told = with_noise_of([run], model)
    assert found.value("sensors.current_noise") == pytest.approx(NOISE, rel=0.1)
    assert found.value("sensors.speed_noise") == pytest.approx(2e-4, rel=0.1)
    assert found.turn / found.value("sensors.motor_encoder_counts") == pytest.approx(np.sqrt(12.0) * STEP, rel=0.1)
    assert f"taken: {said}" in told and "`sensors:`" in told and " 0 " not in told
    assert compare([run], model).overall["unexplained_torque"]["noise_floor"] == 0.0
    assert compare([run], found).overall["unexplained_torque"]["noise_floor"] > 0.0


def test_a_stated_noise_is_kept(tmp_path):
    model = load_model(hoist(tmp_path, "sensors: {current_noise: {value: 3, unit: A}}\n"))
    assert with_noise_of([recorded("current")], model) == (model, "")


def test_signals_without_noise_change_nothing(tmp_path):
    run = recorded("current")
    smooth = replace(run, signals={name: np.zeros(len(TIME)) for name in run.signals})
    model = load_model(hoist(tmp_path))
    assert with_noise_of([smooth], model) == (model, "")


@pytest.mark.slow
def test_compare_prints_no_noise_of_zero(tmp_path):
    run = recorded("current")
    names = [f"{name} [{unit}]" for name, unit in zip(run.signals, ("rad", "rad/s", "A"), strict=True)]
    columns = dict(zip(names, run.signals.values(), strict=True))
    write_columns(tmp_path / "run.csv", {"time [s]": TIME, **columns})
    done("init", tmp_path / "run.csv", "-o", tmp_path / "m")
    found = done("compare", tmp_path / "run.csv", "--map", tmp_path / "m_map.yaml", "--model", hoist(tmp_path))
    assert "states no noise of its sensors" in found.stderr and "0 N m" not in found.stdout.replace(".0 N m", "")


def lagging(lag):
    """The speed after a drive's filter with this time constant [s]."""
    late, held = np.empty(len(TIME)), SPEED[0]
    for k, speed in enumerate(SPEED):
        late[k] = held = held + (1.0 - np.exp(-1e-2 / lag)) * (speed - held)
    return late


@pytest.mark.parametrize("lag", [0.02, 0.05])
def test_the_smoothing_of_the_speed_is_taken_where_none_is_stated(tmp_path, lag):
    """A drive's filter makes the acceleration late; the inertia's torque would be missing where it changes."""
    run, model = recorded("current"), load_model(hoist(tmp_path))
    smoothed = replace(run, signals={**run.signals, "speed": lagging(lag) + RNG.normal(0.0, 2e-4, len(TIME))})
    found, told = with_noise_of([smoothed], model)
    assert found.value("sensors.speed_smoothing") == pytest.approx(lag, abs=0.01)
    assert "smoothing of the speed" in told
    stated = load_model(hoist(tmp_path, "sensors: {speed_smoothing: {value: 0.001, unit: s}}\n"))
    assert with_noise_of([smoothed], stated)[0].value("sensors.speed_smoothing") == 0.001


@pytest.mark.parametrize("noise", [0.0, 1.5])
def test_what_an_output_encoder_adds_to_its_counts_is_taken(tmp_path, noise):
    """Its clock is uneven, which moves both encoders alike: that is no noise of theirs."""
    count = 2.0 * np.pi / 2**16
    sensors = "sensors: {output_encoder_counts: {value: 65536, unit: 1/rev}}\n"
    model = load_model(hoist(tmp_path, sensors))
    run = recorded("current")
    late = RNG.normal(0.0, 1e-3, len(TIME))
    angle = np.interp(TIME + late, TIME, ANGLE)
    output = count * np.rint(angle / count + noise * RNG.normal(size=len(TIME)))
    found, told = with_noise_of(
        [replace(run, signals={**run.signals, "motor_position": angle, "output_position": output})], model
    )
    assert found.value("sensors.output_encoder_noise") == pytest.approx(noise, rel=0.1)
    assert ("output position" in told) == (noise > 0.0)


@pytest.mark.parametrize(("motor_counts", "polled"), [(1000, 1), (1 << 20, 3)], ids=["a coarse motor", "read seldom"])
def test_what_is_no_noise_of_the_output_encoder_is_not_taken(tmp_path, motor_counts, polled):
    """The motor counter's own rounding, and what the motor turns between two readings of the output."""
    sensors = "sensors: {output_encoder_counts: {value: 65536, unit: 1/rev}}\n"
    model = load_model(hoist(tmp_path, sensors))
    count, fine = 2.0 * np.pi / 2**16, 2.0 * np.pi / motor_counts
    output = (count * np.rint(ANGLE / count))[::polled].repeat(polled)[: len(TIME)]
    signals = {**recorded("current").signals, "motor_position": fine * np.rint(ANGLE / fine), "output_position": output}
    found, told = with_noise_of([replace(recorded("current"), signals=signals)], model)
    assert found.value("sensors.output_encoder_noise") == 0.0
    assert "output position" not in told


@pytest.mark.parametrize(("lags", "common"), [((0.05, 0.05), True), ((0.05, 0.0, 0.0), False), ((0.05, 0.2), False)])
def test_a_smoothing_that_recordings_do_not_share_is_not_taken(tmp_path, lags, common):
    run = recorded("current")
    runs = [replace(run, signals={**run.signals, "speed": lagging(lag) if lag else SPEED}) for lag in lags]
    found, _ = with_noise_of(runs, load_model(hoist(tmp_path)))
    assert (found.value("sensors.speed_smoothing") == pytest.approx(0.05, rel=0.2)) == common
