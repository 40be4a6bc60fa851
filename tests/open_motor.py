"""A motor of which neither inertia nor friction is known, as a first draft of a machine is."""

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.model import load_model
from tests.opened import with_open_effects


def open_motor(torque_constant, current_noise, period, coulomb=0.1, viscous=0.01, **sensors):
    """Its frictions start from ``coulomb`` [N m] and ``viscous`` [N m s/rad]; ``sensors`` are more of their numbers."""
    model = load_model("laas_motor").with_value("machine.torque_constant", torque_constant)
    told = {"current_noise": current_noise, "sample_period": period, **sensors}
    for name, value in told.items():
        model = model.with_value(f"sensors.{name}", value)
    model = model.with_effect("coulomb_friction", {"torque": coulomb})
    model = model.with_effect("viscous_friction", {"coefficient": viscous})
    return with_open_effects(model)


def recorded_motion(name, time, torque, speed, angle, random, origin=0.0):
    """A recording of a motor of 1 N m/A by its torque, speed and angle (n,), the first two with noise (``random``)."""
    signals = {
        "current": torque + 2e-3 * random.standard_normal(len(time)),
        "speed": speed + 1e-3 * random.standard_normal(len(time)),
        "motor_position": angle,
    }
    return Recording(name, (time * 1e9).astype(np.int64), signals, motor_angle_origin=origin)
