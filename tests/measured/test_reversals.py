"""Rows near a reversal: kernels that differentiate as they smooth, and friction whose direction no speed tells."""

import math

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim import discover, load_model
from ema_twin_sim.measured.smoothing import gaussian

INERTIA, DRY, VISCOUS = 2e-4, 0.05, 1e-4
PERIOD = 2e-3


@pytest.mark.parametrize("widths", [0.1, 0.5, 1.0], ids=lambda widths: f"{widths} widths")
@pytest.mark.parametrize("samples", [2.5, 10.0, 40.0], ids=lambda samples: f"{samples} samples wide")
def test_what_swings_is_differentiated_as_it_is_smoothed(samples, widths):
    """Of a swing whose radian takes so many standard deviations, within 1e-3 whatever its quickness."""
    turn = widths / samples  # rad a sample

    def passed(order):
        kernel = gaussian(samples, 1.0, order)
        half = len(kernel) // 2
        # time reversed: np.convolve turns the kernel round
        return complex(np.exp(-1j * turn * np.arange(-half, half + 1)) @ kernel)

    assert passed(1) / passed(0) == pytest.approx(1j * turn, rel=1.5e-3)
    assert passed(2) / passed(0) == pytest.approx(-(turn**2), rel=1.5e-3)


def sticking_servo(seconds=6.0):
    """A servo without gear under a current that swings: friction holds it at each reversal."""
    fine = PERIOD / 40.0
    time = np.arange(round(seconds / fine)) * fine
    torque = DRY * (1.3 + 1.2 * np.sin(2.0 * math.pi * 0.4 * time)) * np.sin(2.0 * math.pi * 2.2 * time)
    speed, speeds = 0.0, np.empty(len(time))
    for k, driven in enumerate(torque):
        speeds[k] = speed
        free = speed + fine / INERTIA * (driven - VISCOUS * speed)
        speed = math.copysign(max(abs(free) - fine / INERTIA * DRY, 0.0), free)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * fine)])
    random = np.random.default_rng(5)
    signals = {"motor_position": way, "speed": speeds, "current": torque}
    noises = {"motor_position": 1e-5, "speed": 0.02, "current": 1e-4}
    seen = {
        name: values[::40] + random.normal(0.0, noises[name], len(values[::40])) for name, values in signals.items()
    }
    return Recording("sticking", np.rint(time[::40] * 1e9).astype(np.int64), seen)


def test_an_inertia_does_not_take_what_friction_does_while_it_sticks(tmp_path):
    """Both come out within 0.3 %, though it sticks at every reversal."""
    file = tmp_path / "servo.yaml"
    file.write_text(
        "version: 1\n"
        "machine:\n"
        "  name: servo\n"
        "  inertia: {value: 1.0e-3, unit: kg m^2, tolerance: open, source: start value}\n"
        "  torque_constant: {value: 1.0, unit: N m/A}\n"
        "transmission: {kind: rigid}\n"
        "sensors: {speed_noise: {value: 0.02, unit: rad/s}, current_noise: {value: 1.0e-4, unit: A}}\n"
        "effects:\n"
        "  viscous_friction: {effect: viscous_friction, options: {side: motor}, parameters: {coefficient: 1.0e-3}, "
        "open: true}\n"
        "  coulomb_friction: {effect: coulomb_friction, options: {side: motor}, parameters: {torque: 0.1, "
        "static_ratio: 1.0}, open: true}\n"
    )
    found = discover([sticking_servo()], load_model(file))
    assert found.added == ()
    assert found.model.value("machine.motor_inertia") == pytest.approx(INERTIA, rel=3e-3)
    assert found.model.active["coulomb_friction"].parameters["torque"] == pytest.approx(DRY, rel=3e-3)
