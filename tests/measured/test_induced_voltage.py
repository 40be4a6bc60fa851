"""A torque constant that would induce more volts than any drive has may be in a wrong unit, or of another shaft."""

import math
from dataclasses import replace

import numpy as np
import pytest
from open_motor import open_motor

from ema_bench_replay.recording import Recording
from ema_twin_sim.measured.consistency import refuse_inconsistent
from ema_twin_sim.measured.induced_voltage import impossible_voltage
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model.matching import BY_TORQUE
from ema_twin_sim.model.model_file import TORQUE_CONSTANT
from ema_twin_sim.model.own_units import OwnUnits, model_in, recording_in
from tests.recorded import benched

TIME = 1e-3 * np.arange(4000)
SPEED = 250.0 * np.sin(3.0 * TIME)
"""A motor of 0.07 N m/A induces 18 V here."""


def turning(*signals, **metadata):
    random = np.random.default_rng(7)
    torque = 0.05 * np.sign(SPEED) + 1e-3 * np.gradient(SPEED, 1e-3)
    every = {
        "speed": SPEED + random.normal(0.0, 0.05, len(TIME)),
        "motor_position": 1e-3 * np.cumsum(SPEED),
        "current": torque / 0.07 + random.normal(0.0, 0.01, len(TIME)),
    }
    return Recording("turning", 1_000_000 * np.arange(len(TIME)), {n: every[n] for n in signals}, metadata=metadata)


def with_source(model, source):
    return {**model.constants, TORQUE_CONSTANT: replace(model.constants[TORQUE_CONSTANT], source=source)}


def told(recording, torque_constant, source="data sheet"):
    model = open_motor(torque_constant, 0.01, 1e-3)
    return refuse_inconsistent(*to_own_units([recording], replace(model, constants=with_source(model, source))))


@pytest.mark.parametrize("motion", [("speed",), ("motor_position",), ("speed", "motor_position")])
def test_a_torque_constant_read_in_the_wrong_unit_is_asked_about(motion):
    recording = turning("current", *motion)
    assert told(recording, 0.07) == ()
    [asked] = told(recording, 70.0)
    assert asked.startswith("turning: a motor of 70.0 N m/A would induce 17.") and "a drive has 600 V" in asked


def test_a_motion_read_in_the_wrong_unit_is_asked_about():
    """The speed of a motor that induces 60 V at 1000 rad/s, read in degrees: 57 times as much."""
    fast = turning("current", "speed")
    wrong = Recording("fast", fast.stamps, {**fast.signals, "speed": fast.signals["speed"] * 57.3 * 4.0})
    [asked] = told(wrong, 0.06)
    assert "unit of the motion in the import map" in asked


def test_a_torque_constant_that_is_assumed_or_does_not_count_is_left_in_peace():
    assert told(turning("current", "speed", **{BY_TORQUE: "yes"}), 70.0) == ()
    assert told(turning("current", "speed"), 70.0, "assumed") == ()


def test_so_is_one_that_is_open():
    """A start value says nothing of the machine."""
    model = open_motor(70.0, 0.01, 1e-3)
    known = replace(model.constants[TORQUE_CONSTANT], source="start value", tolerance=math.inf)
    free = replace(model, constants={**model.constants, TORQUE_CONSTANT: known})
    assert refuse_inconsistent(*to_own_units([turning("current", "speed")], free)) == ()


def test_positions_in_any_order_tell_no_speed():
    points = 0.1 * np.random.default_rng(5).permutation(300)
    signals = {"motor_position": points, "current": 0.1 * np.sin(points) + 0.2}
    recording = Recording("points", 1_000_000 * np.arange(300), signals, metadata={"operating_points": "yes"})
    model = open_motor(70.0, 0.01, 1e-3)
    assert impossible_voltage(recording, replace(model, constants=with_source(model, "data sheet"))) is None


def test_so_is_a_machine_whose_inertia_is_known(stock):
    """It may be told in any units of time and torque, in which volts say nothing."""
    fast = benched(stock, "sine:0.05:2", 3.0, name="fast", seed=1)
    units = OwnUnits()
    own = recording_in(fast, units)
    model = model_in(stock, units)
    turned = replace(model, units=OwnUnits(time=1e-3))  # each of its seconds is a millisecond
    assert impossible_voltage(own, turned) is not None
    assert refuse_inconsistent([own], turned) == ()
