"""A large robot's axis without gearbox, of which nothing is known, and its motion by formulas."""

import math
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.model import load_model
from tests.opened import with_open_effects

INERTIA, VISCOUS, COULOMB, WEIGHT, ANGLE = 40.0, 30.0, 20.0, 300.0, 2.5


def open_arm(inertia=10.0):
    """A model of it that is open altogether: the friction far too low, and the arm hanging the other way."""
    model = load_model("kuka_axis1")
    constants = dict(model.constants)
    constants["machine.gear_ratio"] = replace(constants["machine.gear_ratio"], value=1.0)
    constants["machine.motor_inertia"] = replace(constants["machine.motor_inertia"], value=inertia)
    model = replace(model, constants=constants)
    model = model.with_value("effects.viscous_friction.coefficient", 1.0)
    model = model.with_value("effects.coulomb_friction.torque", 1.0)
    return with_open_effects(model.with_effect("gravity_load", {"torque": 10.0, "angle": 0.0}))


def swings_of(model):
    """Two runs of it, over half a turn."""
    rng = np.random.default_rng(4)
    found = []
    for rate, phase in ((0.8, 0.0), (1.3, 1.0)):
        time = np.arange(10_000) * 2e-3
        angle, speed, acceleration = (1.5 * rate**k * np.sin(rate * time + phase + k * math.pi / 2) for k in range(3))
        torque = INERTIA * acceleration + VISCOUS * speed + COULOMB * np.sign(speed) + WEIGHT * np.sin(angle + ANGLE)
        current = (torque + 0.5 * rng.standard_normal(len(time))) / model.value("machine.torque_constant")
        signals = {"current": current, "speed": speed, "motor_position": angle}
        stamps = np.arange(len(time)) * 2_000_000
        found.append(Recording(f"swing_{rate:g}", stamps, signals, motor_angle_origin=0.0, output_angle_origin=0.0))
    return found
