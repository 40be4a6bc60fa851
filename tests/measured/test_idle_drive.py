"""A drive that is off while something else moves its machine: told as that, and nothing is looked for in its noise."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.consistency import inconsistencies
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model import load_model
from tests.recorded import sampled

NOISE = 0.02  # N m
TIME = np.arange(8000) * 1e-3


@pytest.fixture(scope="module")
def motor():
    """A motor of which nothing but its encoder is known."""
    return load_model("laas_motor").with_value("sensors.current_noise", NOISE)


def turned(torque, name="turned", seed=4, **more):
    """A machine that swings, and the reading of the torque (n,) of its own drive."""
    rng = np.random.default_rng(seed)
    signals = {
        "motor_torque": torque + NOISE * rng.standard_normal(len(TIME)),
        "speed": 20.0 * np.cos(5.0 * TIME) + 0.01 * rng.standard_normal(len(TIME)),
        "motor_position": 4.0 * np.sin(5.0 * TIME),
        **more,
    }
    return sampled(name, TIME, signals)


def needed(share):
    """The torque of inertia and friction, its rms ``share`` of the noise."""
    torque = np.sign(np.cos(5.0 * TIME)) - 0.5 * np.sin(5.0 * TIME)
    return share * NOISE * torque / np.sqrt(np.mean(torque**2))


def told(recordings, model):
    own, its_model = to_own_units(recordings, model)
    return [each.what for each in inconsistencies(own[0], its_model, own) if "does nothing" in each.what]


def test_a_drive_that_is_off_is_refused_as_that(motor):
    said = r"turned: the drive does nothing here.*19\.\d mN m \(rms\), its noise 20\.\d mN m.*record with the drive on"
    with pytest.raises(InputError, match=said):
        discover([turned(np.zeros(len(TIME)))], motor)


@pytest.mark.parametrize("offset", [0.3, -0.3])
def test_a_sensor_that_is_off_by_less_than_its_noise_shows_no_drive(motor, offset):
    assert told([turned(np.full(len(TIME), offset * NOISE))], motor)


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_a_drive_that_its_noise_hides_in_single_samples_is_on(motor, share):
    assert not told([turned(needed(share))], motor)


def test_a_fast_torque_that_moves_the_machine_is_no_noise(motor):
    """Third differences take it for noise; but the acceleration goes with it."""
    shaken = 0.5 * np.sin(2.0 * np.pi * 180.0 * TIME)
    inertia = 1e-3
    swing = -shaken / (inertia * (2.0 * np.pi * 180.0) ** 2)
    fast = turned(needed(0.5) + shaken)
    signals = {**fast.signals, "motor_position": fast.signals["motor_position"] + swing}
    assert not told([Recording("fast", fast.stamps, signals)], motor)


def test_another_machine_may_drive_it(motor):
    assert not told([turned(np.zeros(len(TIME)), load_torque=needed(10.0))], motor)


def test_a_run_with_the_drive_on_shows_what_one_beside_it_coasts_against(motor):
    off, on = turned(np.zeros(len(TIME))), turned(needed(10.0), "driven", 5)
    assert not told([off, on], motor)
    assert told([off, turned(np.zeros(len(TIME)), "again", 6)], motor)


def test_a_known_inertia_shows_the_friction_of_a_machine_that_coasts(motor):
    known = {path: replace(held, tolerance=0.05) for path, held in motor.constants.items()}
    assert not told([turned(np.zeros(len(TIME)))], replace(motor, constants=MappingProxyType(known)))
