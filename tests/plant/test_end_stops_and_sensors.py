"""End stops, the counters' own angles, and the sensors, each against a closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.plant.transmission import end_stop_torque
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.compared_signals import noise_floors
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.twin import Twin
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.recorded import driven

RATIO, TORQUE_CONSTANT, INERTIA = 124.0, 1.91, 7.7e-4 + 1.75e-6 + 1.0e-3


@pytest.fixture(scope="module")
def fine(stock):
    """Counters so fine that they show the angle itself."""
    return with_counts(stock, 1e12)


def with_counts(model, counts):
    for side in ("motor", "output"):
        model = model.with_value(f"sensors.{side}_encoder_counts", counts)
    return model


def with_stop(model, side, angle, stiffness, damping):
    model = model.with_value(f"transmission.end_stop_{side}", angle)
    model = model.with_value("transmission.contact_stiffness", stiffness)
    return model.with_value("transmission.contact_damping", damping)


def coasting(model, speed, count):
    """Rows of a twin without current or friction from a speed on: (time after the start, dict of arrays)."""
    _, rows = driven(model, "current", {"current": 0.0}, count, 25_000, {"current": 0.0, "speed": speed})
    return np.arange(count + 1) * 25e-6, rows


@pytest.mark.parametrize("origin", [0.0, 0.004, -0.004])
@pytest.mark.parametrize(("side", "sign"), [("upper", 1.0), ("lower", -1.0)])
def test_an_end_stop_gives_way_by_torque_over_stiffness(frictionless, side, sign, origin):
    """It stands at the encoder's own angle, so the origin takes from the way to it."""
    model = with_stop(frictionless, side, sign * 0.01, 50.0, 0.5)
    twin = Twin(model, "current")
    push = {"current": sign * 0.5}
    twin.start(push, 0.0, origin)
    for _ in range(1000):
        row = twin.advance(1_000_000, push)
    expected = (sign * 0.01 - origin) * RATIO + sign * 0.5 * TORQUE_CONSTANT / 50.0
    assert row["speed"] == pytest.approx(0.0, abs=1e-6)
    assert row["motor_position"] == pytest.approx(expected, abs=1e-6)
    assert row["load_torque"] == pytest.approx(sign * 0.5 * TORQUE_CONSTANT, rel=1e-4)


@pytest.mark.parametrize(("side", "sign"), [("upper", 1.0), ("lower", -1.0)])
def test_an_end_stop_without_damping_throws_back_at_the_same_speed(frictionless, side, sign):
    model = with_stop(frictionless, side, sign * 0.005, 500.0, 0.0)
    time, rows = coasting(model, sign * 10.0, 6000)
    assert np.allclose(rows["speed"][time < 0.06], sign * 10.0)
    assert rows["speed"][-1] == pytest.approx(sign * -10.0, rel=5e-3)
    deepest = np.abs(rows["motor_position"]).max() - 0.005 * RATIO
    assert deepest == pytest.approx(10.0 * math.sqrt(INERTIA / 500.0), rel=5e-3)


@pytest.mark.parametrize(
    ("angle", "speed", "torque"),
    [
        *((0.0, 9.0, 0.0), (1.2, 0.0, 10.0), (1.2, 3.0, 16.0), (1.2, -3.0, 4.0), (1.2, -9.0, 0.0)),
        *((0.0, -9.0, 0.0), (-2.2, 0.0, -10.0), (-2.2, -3.0, -16.0), (-2.2, 3.0, -4.0), (-2.2, 9.0, 0.0)),
    ],
)
def test_an_end_stop_pushes_and_never_pulls(angle, speed, torque):
    assert end_stop_torque(angle, speed, -2.0, 1.0, 50.0, 2.0) == pytest.approx(torque)


@pytest.mark.parametrize(("side", "sign"), [("upper", 1.0), ("lower", -1.0)])
def test_the_torque_of_an_end_stop_is_explained(fine, side, sign):
    model = with_stop(fine, side, sign * 0.05, 1e4, 1.0)
    recording = virtual_bench(model, parse_command(f"ramp:{sign * 0.1}"), 1.5, seed=None)
    assert abs(recording.signals["current"][-1]) * TORQUE_CONSTANT > 5.0
    assert abs(simulate(model, recording, "current").signals["unexplained_torque"][-1]) < 0.01


@pytest.mark.parametrize("origin", [math.pi, 0.5 * math.pi])
@pytest.mark.parametrize(
    ("side", "effect", "torque", "options", "command", "off"),
    [
        # the model's torque at the measured angle is just as wrong; the filters delay it by 14 ms at 6.2 rad/s
        ("motor", "sun_runout", 0.03, {"kind": "conservative"}, "ramp:0.05", 0.2),
        ("output", "gravity_load", 0.06, {}, "ramp:0.3", 0.02),
    ],
)
def test_what_follows_an_angle_stands_at_the_counters_own(fine, side, effect, torque, options, command, off, origin):
    model = fine.with_effect(effect, {"torque": torque}, options)
    recording = virtual_bench(model, parse_command(command), 4.0, seed=None)
    moved = simulate(model, replace(recording, **{f"{side}_angle_origin": origin}), "setpoint").signals
    angle = recording.signals[f"{side}_position"]
    more = torque * (np.sin(angle + origin) - np.sin(angle))
    settled = recording.time > 1.0
    found = (moved["current"] - recording.signals["current"]) * TORQUE_CONSTANT
    assert np.abs(found - more)[settled].max() < 0.02 * torque
    assert np.abs(moved["unexplained_torque"] + more)[settled].max() < off * torque


@pytest.mark.parametrize("delay", [0.00006, 0.000125, 0.00019, 0.00103])
def test_a_late_encoder_interpolates_between_control_cycles(frictionless, delay):
    """From rest under a constant torque it shows a (t - delay)^2 / 2, wherever in a control cycle the delay ends."""
    _, rows = driven(
        frictionless.with_effect("encoder_delay", {"delay": delay}), "current", {"current": 1.0}, 2000, 25_000
    )
    time = np.arange(2001) * 25e-6
    acceleration = TORQUE_CONSTANT / INERTIA / RATIO
    straight = acceleration * 125e-6**2 / 8.0  # what a straight line through two cycles misses of the parabola
    late = np.maximum(time - delay, 0.0)
    for name, shown, ratio in (("output_position", late, 1.0), ("motor_position", time, RATIO)):
        assert np.abs(rows[name] / ratio - 0.5 * acceleration * shown**2).max() < 1.01 * straight, name


@pytest.mark.parametrize("delay", [0.00006, 0.00019, 0.00103])
def test_a_late_encoder_counts_a_steady_motion_from_its_first_sample(frictionless, delay):
    time, rows = coasting(frictionless.with_effect("encoder_delay", {"delay": delay}), 62.0, 400)
    assert np.allclose(rows["output_position"], 62.0 / RATIO * time, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("speed", [10.0, -10.0])
def test_counters_show_the_nearest_whole_count(frictionless, speed):
    model = frictionless.with_value("sensors.motor_encoder_counts", 100.0)
    model = model.with_value("sensors.output_encoder_counts", 1500.0)
    time, rows = coasting(model, speed, 10_000)
    for side, counts, ratio in (("motor", 100.0, 1.0), ("output", 1500.0, RATIO)):
        count = 2.0 * math.pi / counts
        shown = rows[f"{side}_position"] / count
        assert np.allclose(shown, np.rint(shown), atol=1e-9)
        off = shown - speed * time / ratio / count
        assert -0.501 < off.min() < -0.49 and 0.49 < off.max() < 0.501


@pytest.mark.parametrize("smoothing", [0.004, 0.02])
def test_the_reported_speed_is_smoothed_by_a_first_order_lag(frictionless, smoothing):
    """Of a ramp a t a lag shows a (t - T (1 - exp(-t / T)))."""
    model = frictionless.with_value("sensors.speed_smoothing", smoothing)
    _, rows = driven(model, "current", {"current": 0.1}, 100, 1_000_000)
    time = np.arange(101) * 1e-3
    expected = 0.1 * TORQUE_CONSTANT / INERTIA * (time - smoothing * (1.0 - np.exp(-time / smoothing)))
    assert np.allclose(rows["speed"], expected, rtol=1e-3, atol=1e-4)


def test_without_noise_the_floor_of_positions_is_that_of_their_counts(stock):
    model = stock
    for noise in ("current_noise", "speed_noise", "motor_encoder_noise", "output_encoder_noise"):
        model = model.with_value(f"sensors.{noise}", 0.0)
    coarse, fine = (noise_floors(with_counts(model, counts), has_speed=False) for counts in (1e4, 4e4))
    count = 2.0 * math.pi / 1e4
    for name in ("motor_position", "output_position"):
        assert count / math.sqrt(12.0) * (1.0 - 1e-9) <= coarse[name] <= count
    for name in ("motor_position", "output_position", "unexplained_torque"):
        assert coarse[name] > 0.0
        assert coarse[name] == pytest.approx(4.0 * fine[name], rel=1e-9)
