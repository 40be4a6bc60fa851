"""A torque sensor in an unloaded joint tells its own offset: init takes it for a load only if the drive follows it."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.measured.consistency import inconsistencies

CONSTANT = 7.6  # N m/A at the joint
SENSOR = "joint torque sensor [Nm]"


def trace(load, shown, torque_constant=CONSTANT):
    """A joint that swings, its friction and a ``load`` (n,) on it; its sensor has ``shown`` (n,)."""
    rng = np.random.default_rng(6)
    time = np.arange(8000) * 2e-3
    angle = 1.2 * np.sin(0.9 * time)
    speed, acceleration = np.gradient(angle, 2e-3), np.gradient(np.gradient(angle, 2e-3), 2e-3)
    torque = 0.15 * acceleration + 0.7 * speed + 1.3 * np.sign(speed) + load(time)
    current = torque / torque_constant + 0.01 * rng.standard_normal(len(time))
    sensor = shown(time) + 0.02 * rng.standard_normal(len(time))
    motion = {"time [s]": time, "position [rad]": angle, "speed [rad/s]": speed}
    return {**motion, "current [A]": current, SENSOR: sensor}


def wandering(time):
    return 0.8 * np.sin(0.37 * time + 1.0) + 0.5 * np.sin(2.3 * time)


def drifting(time):
    return -0.25 + 0.1 * np.sin(0.37 * time + 1.0) + 0.05 * np.sin(2.3 * time)


@pytest.mark.parametrize(
    ("load", "shown", "used"),
    [
        (wandering, wandering, True),
        (wandering, lambda t: -wandering(t), True),  # which way it counts is another question
        (wandering, lambda t: wandering(t) - 0.4, True),
        (lambda t: 0.0 * t, drifting, False),
        (lambda t: 0.0 * t + 1.0, lambda t: 0.0 * t + 0.1, True),  # what never changes cannot be followed
        (wandering, lambda t: np.where(np.arange(len(t)) % 900 == 50, -478.0, wandering(t)), True),  # a bad contact
    ],
)
def test_a_load_is_what_the_drive_follows(load, shown, used, drafted):
    draft = drafted(trace(load, shown), torque_constant=CONSTANT)
    assert ("load_torque" in draft.map) == used
    assert ("joint torque sensor [Nm] → load_torque" in draft.said) == used
    assert ("the drive's torque does not follow it" in draft.said) != used


@pytest.mark.parametrize(("noise", "used"), [(0.0, False), (0.02, True)])
def test_a_torque_that_is_the_current_times_a_factor_is_no_load(noise, used, drafted):
    """A drive's estimate looks like a sensor that it follows to the last digit; a sensor has noise of its own."""
    columns = trace(wandering, wandering)
    current = columns["current [A]"]
    columns[SENSOR] = 1.314 * current * (1.0 + noise * np.random.default_rng(7).standard_normal(len(current)))
    told = drafted(columns, torque_constant=CONSTANT).said
    assert ("joint torque sensor [Nm] → load_torque" in told) == used
    assert ("it is 1.314 N m/A times the current" in told) != used


@pytest.mark.parametrize("constant", [0.076, 760.0])
def test_no_torque_constant_need_be_known(constant, drafted):
    assert "load_torque" in drafted(trace(wandering, wandering, constant)).map
    assert "load_torque" not in drafted(trace(lambda t: 0.0 * t, drifting, constant)).map


@pytest.mark.parametrize(("shown", "turned"), [(wandering, False), (lambda t: -wandering(t), True)])
def test_a_sensor_that_counts_against_the_drive_is_read_with_its_sign_turned(shown, turned, drafted, read, drawn):
    """Where it were read as it stands, the load would push where it brakes, and no effect would explain that."""
    draft = drafted(trace(wandering, shown), torque_constant=CONSTANT)
    assert ("unit: N m, factor: -1" in draft.map) == turned
    assert ("sign reversed, because the drive's torque falls" in draft.said) == turned
    recording, model = read(), drawn()
    assert not [*inconsistencies(recording, model)]
    load_turned = replace(recording, signals={**recording.signals, "load_torque": -recording.signals["load_torque"]})
    assert ["load's sign" in str(found) for found in inconsistencies(load_turned, model)] == [True]
