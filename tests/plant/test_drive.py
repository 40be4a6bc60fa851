"""The averaged drive: its limits, its integrator, its lags and its voltage, each against a closed form."""

import math

import numpy as np
import pytest

from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.twin import Twin
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.recorded import driven

CYCLE = 125_000  # ns, of the stock model's speed controller
TORQUE_CONSTANT, SPEED_GAIN = 1.91, 0.2368


@pytest.fixture(scope="module")
def locked(frictionless):
    """Friction that no torque of the drive overcomes: the speed error is the setpoint."""
    return frictionless.with_effect("coulomb_friction", {"torque": 100.0, "static_ratio": 1.0})


def changed(model, **values):
    for name, value in values.items():
        model = model.with_value(f"drive.{name}", value)
    return model


@pytest.mark.parametrize("wanted", [20.0, -20.0])
def test_a_speed_command_is_held_at_the_speed_limit(stock, wanted):
    _, rows = driven(changed(stock, speed_limit=5.0), "standalone_speed", {"speed_setpoint": wanted}, 8000)
    assert rows["speed_setpoint"][-1] == pytest.approx(math.copysign(5.0, wanted), rel=1e-9)
    assert rows["speed"][-1] == pytest.approx(math.copysign(5.0, wanted), rel=1e-3)


@pytest.mark.parametrize("size", [1.0, -1.0])
def test_the_position_loop_moves_no_faster_than_the_speed_limit(stock, size):
    bench = virtual_bench(changed(stock, speed_limit=5.0), parse_command(f"step:{size}:100"), 2.0, seed=None)
    position = bench.signals["output_position"]
    assert np.abs(bench.signals["speed_setpoint"]).max() == pytest.approx(5.0, rel=1e-9)
    assert position[-1] - position[-501] == pytest.approx(math.copysign(5.0 / 124.0, size), rel=1e-3)


@pytest.mark.parametrize("wanted", [200.0, -200.0])
@pytest.mark.parametrize(
    ("current_limit", "torque_limit", "reached"),
    [(2.0, 11.842, 2.0), (22.5, 11.842, 11.842 / TORQUE_CONSTANT), (7.0, 5.0, 5.0 / TORQUE_CONSTANT)],
)
def test_the_lower_of_current_limit_and_torque_limit_holds(locked, wanted, current_limit, torque_limit, reached):
    model = changed(locked, current_limit=current_limit, torque_limit=torque_limit)
    _, rows = driven(model, "setpoint", {"speed_setpoint": wanted}, 400)
    for name in ("current_setpoint", "current"):
        assert rows[name][-1] == pytest.approx(math.copysign(reached, wanted), rel=1e-9)
        assert np.abs(rows[name]).max() <= reached * (1 + 1e-12)


def test_the_integrator_grows_by_gain_over_integral_time(locked):
    """A PI controller at a constant error e demands gain * e * (1 + t / integral_time)."""
    _, rows = driven(changed(locked, integral_time=0.02), "setpoint", {"speed_setpoint": 2.0}, 200)
    time = np.arange(200) * 125e-6  # of the cycles; a row shows the setpoint of the cycle one period before it
    expected = SPEED_GAIN * 2.0 * (1.0 + time / 0.02) / TORQUE_CONSTANT
    assert np.allclose(rows["current_setpoint"][1:], expected, rtol=1e-9)


@pytest.mark.parametrize("error", [2.0, -2.0])
def test_the_integrator_stops_at_its_limit(locked, error):
    _, rows = driven(changed(locked, integral_limit=0.5), "setpoint", {"speed_setpoint": error}, 4000)
    expected = (SPEED_GAIN * error + math.copysign(0.5, error)) / TORQUE_CONSTANT
    assert rows["current_setpoint"][-1] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("anti_windup_time", [0.004, 0.008])
def test_a_saturated_integrator_settles_where_back_calculation_balances_the_error(locked, anti_windup_time):
    """0 = gain / integral_time * e + (limit - gain * e - integral) / anti_windup_time, seen once e is zero."""
    model = changed(locked, torque_limit=4.0, integral_time=0.01, anti_windup_time=anti_windup_time)
    twin, rows = driven(model, "setpoint", {"speed_setpoint": 10.0}, 2000)
    assert rows["current_setpoint"][-1] * TORQUE_CONSTANT == pytest.approx(4.0)
    released = twin.advance(CYCLE, {"speed_setpoint": 0.0})["current_setpoint"] * TORQUE_CONSTANT
    assert released == pytest.approx(4.0 - SPEED_GAIN * 10.0 * (1.0 - anti_windup_time / 0.01), rel=1e-6)


@pytest.mark.parametrize("share", [0.99, -0.99, 1.01, -1.01])
def test_the_integrator_holds_within_the_dead_band_of_the_position_error(locked, share):
    """The band is of the fast shaft: a position error of band / ratio on the slow one is its edge."""
    error = share * 0.002 / 124.0
    model = changed(locked, integral_dead_band=0.002)
    _, rows = driven(model, "standalone", {"output_command": error}, 1000, 1_000_000)
    speed = model.value("drive.position_gain") * error
    integrated = 0.0 if abs(share) < 1.0 else SPEED_GAIN / 0.01 * speed * (1.0 - 1e-3)  # less the setpoint's filter
    expected = (SPEED_GAIN * speed + integrated) / TORQUE_CONSTANT
    assert rows["current_setpoint"][-1] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("lag", [0.0, 0.001, 0.005])
def test_the_speed_setpoint_goes_through_its_filter(stock, lag):
    model = changed(stock, speed_setpoint_filter=lag)
    _, rows = driven(model, "standalone_speed", {"speed_setpoint": 3.0}, 200, first={"speed_setpoint": 0.0})
    # the first cycle still sees the zero of the first sample
    time = np.arange(200) * 125e-6
    expected = 3.0 * (1.0 - np.exp(-time / lag)) if lag else np.where(time > 0.0, 3.0, 0.0)
    assert np.allclose(rows["speed_setpoint"][1:], expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("lag", [0.0, 0.0005, 0.005])
def test_the_current_follows_its_setpoint_with_a_lag(locked, lag):
    model = changed(locked, current_lag=lag, integral_time=1e3)
    _, rows = driven(model, "setpoint", {"speed_setpoint": 5.0}, 200)
    time = np.arange(1, 201) * 125e-6
    setpoint = SPEED_GAIN * 5.0 / TORQUE_CONSTANT
    expected = setpoint * (1.0 - np.exp(-time / lag)) if lag else np.full(200, setpoint)
    assert np.allclose(rows["current"][1:], expected, rtol=1e-4)


def test_the_voltage_of_a_steady_run_is_back_emf_and_resistance(frictionless):
    model = frictionless.with_effect("viscous_friction", {"coefficient": 0.05})
    _, rows = driven(model, "current", {"current": 0.4}, 1000, 1_000_000)
    speed = TORQUE_CONSTANT * 0.4 / 0.05
    assert rows["speed"][-1] == pytest.approx(speed, rel=1e-6)
    assert rows["voltage"][-1] == pytest.approx(0.955 * speed + 1.375 * 0.4, rel=1e-6)


def test_a_changing_current_takes_the_voltage_of_the_inductance(locked):
    twin = Twin(locked, "current")
    twin.start({"current": 0.0})
    for n in range(1, 101):
        row = twin.advance(1_000_000, {"current": 0.02 * n})
    assert row["voltage"] == pytest.approx(1.375 * 2.0 + 15.25e-3 * 20.0, abs=1e-3)

    _, rows = driven(changed(locked, current_lag=0.005, integral_time=1e3), "setpoint", {"speed_setpoint": 5.0}, 100)
    rate = (SPEED_GAIN * 5.0 / TORQUE_CONSTANT - rows["current"][1:]) / 0.005
    assert np.allclose(rows["voltage"][1:], 1.375 * rows["current"][1:] + 15.25e-3 * rate, rtol=5e-3)


@pytest.mark.parametrize(("share", "moves"), [(0.99, False), (1.01, True), (-0.99, False), (-1.01, True)])
@pytest.mark.parametrize(
    ("effects", "origin", "level"),
    [
        ([], 0.0, 0.2),
        ([("stribeck_friction", {"torque": 0.05, "speed": 2.0})], 0.0, 0.25),
        ([("sun_runout", {"torque": 0.05})], 0.5 * math.pi, 0.25),
        ([("sun_runout", {"torque": 0.05})], -0.5 * math.pi, 0.15),
        # within the play the motor is held by its own friction alone
        ([("stribeck_friction", {"torque": 0.05, "speed": 2.0}), ("backlash", {"width": 0.01})], 0.0, 0.25),
    ],
)
def test_a_shaft_breaks_away_at_its_static_level_and_what_effects_add(
    frictionless, effects, origin, level, share, moves
):
    model = frictionless.with_effect("coulomb_friction", {"torque": 0.1, "static_ratio": 2.0})
    if any(id == "backlash" for id, _ in effects):
        model = model.with_effect("coulomb_friction", {"torque": 0.07, "static_ratio": 2.0}, {"side": "output"})
    for id, parameters in effects:
        model = model.with_effect(id, parameters)
    twin = Twin(model, "current")
    current = {"current": share * level / TORQUE_CONSTANT}
    twin.start(current, origin)
    speeds = [twin.advance(100_000, current)["speed"] for _ in range(100)]
    assert any(speeds) is moves
