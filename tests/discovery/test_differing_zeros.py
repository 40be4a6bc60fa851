"""Recordings of a counter that starts anew: the zeros are moved to one, and what repeats is found in all of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import AT
from ema_twin_sim.discovery.differing_zeros import as_recorded, differing_zeros, of_differing_zeros, with_zeros_moved
from ema_twin_sim.discovery.discover import discover
from tests.open_motor import open_motor, recorded_motion
from tests.problems import fit_of

PERIOD, SECONDS = 2e-3, 12.0
INERTIA, VISCOUS, DRY = 2e-4, 4e-4, 0.02
WAVES = ((7, 0.025, 0.3), (12, 0.006, 1.0))  # order, N m, rad
NOISE = 2e-3  # A, at 1 N m/A, of ``recorded_motion``


def turning(name, zero, rate, waves=WAVES, seconds=SECONDS, way=12.0):
    """A motor that turns to and fro; its counter reads 0 where its angle is ``zero`` [rad]."""
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    fast = 2.0 * math.pi * rate
    angle = way * np.sin(fast * time) + zero
    speed, acceleration = way * fast * np.cos(fast * time), -way * fast**2 * np.sin(fast * time)
    torque = INERTIA * acceleration + VISCOUS * speed + DRY * np.sign(speed)
    torque += sum(size * np.sin(order * angle + phase) for order, size, phase in waves)
    return recorded_motion(name, time, torque, speed, angle - zero, np.random.default_rng(ord(name)))


@pytest.fixture(scope="module")
def motor():
    return open_motor(1.0, NOISE, PERIOD, speed_noise=1e-3)


ZEROS = {"a": 0.0, "b": 0.0, "c": 0.9, "d": -1.7}


def anew(waves=WAVES, zeros=ZEROS):
    return [turning(name, zero, 0.1 + 0.02 * k, waves) for k, (name, zero) in enumerate(zeros.items())]


def test_the_angles_between_the_zeros_are_found(motor):
    """Twelve waves a turn tell by how many cycles of the seven it was."""
    by = differing_zeros(fit_of(anew(), motor))
    apart = {name: by.get(name, 0.0) - by.get("a", 0.0) for name in ZEROS}
    assert apart == pytest.approx(ZEROS, abs=0.02)
    moved = with_zeros_moved(anew(), as_recorded(anew(), by, motor))
    assert not differing_zeros(fit_of(moved, motor))
    cogs = motor.with_effect("cogging", {"torque": 0.025, "phase": 0.3}, {"order": "7"})
    for end, then in (
        (cogs, "move them to that of the new model"),
        (motor, "before you compare, add to the positions"),
    ):
        (warning,) = of_differing_zeros(by, motor, end)
        assert then in warning and all((f"rad for {name}" in warning) is (end is motor) for name in by)


def test_nothing_is_moved_where_the_zeros_agree_or_nothing_repeats(motor):
    together = dict.fromkeys(ZEROS, 0.4)
    assert not differing_zeros(fit_of(anew(zeros=together), motor))
    assert not differing_zeros(fit_of(anew(waves=()), motor))
    assert not differing_zeros(fit_of(anew()[:1], motor))
    assert not of_differing_zeros({}, motor, motor)


@pytest.mark.parametrize("way", [0.1, 0.15, 0.25])
def test_a_recording_in_which_nothing_repeats_tells_no_zero(way, motor):
    """Over a part of a wave its amplitude is noise, many times the others'."""
    given = [*anew(zeros={"a": 0.0, "b": 0.0}), turning("c", 0.0, 0.5, way=way)]
    assert not differing_zeros(fit_of(given, motor))


def test_a_wave_that_one_recording_alone_shows_tells_no_zero(motor):
    """A slight one at its order is moved along in the others, to gain a little: a machine's waves have one size."""
    slight = [turning(name, 0.0, 0.12, ((7, 0.003, phase),)) for name, phase in (("b", 1.3), ("c", -0.5))]
    assert not differing_zeros(fit_of([turning("a", 0.0, 0.1, ((7, 0.025, 0.3),)), *slight], motor))


def test_a_model_that_cogs_already_says_where_the_zero_is(motor):
    """What is left of a known wave in a turned recording is another wave, which says nothing of the zero."""
    cogs = motor.with_effect("cogging", {"torque": 0.025, "phase": 0.3}, {"order": "7"})
    assert not differing_zeros(fit_of(anew(), cogs))


def test_positions_of_the_output_are_moved_by_the_outputs_angle(motor):
    geared = motor.with_value("machine.gear_ratio", 50.0)
    at_output = replace(anew()[0], metadata={f"motor_position{AT}": "output"})
    by = as_recorded([at_output], {"a": 0.5}, geared)
    assert by == pytest.approx({"a": 0.01})
    (moved,) = with_zeros_moved([at_output], by)
    assert moved.motor_angle_origin == pytest.approx(0.01)


@pytest.mark.slow
def test_what_repeats_is_found_in_all_recordings(motor):
    """Only a slighter wave was found, or none, and more recordings made it worse."""
    found = discover(anew(), motor)
    assert found.added == ("cogging",)
    sizes = {
        model.options["order"]: model.parameters["torque"]
        for model in found.model.active.values()
        if "order" in model.options
    }
    assert sizes == pytest.approx({str(order): size for order, size, _ in WAVES}, rel=0.1)
    assert any("the zero of the position differs" in warning for warning in found.warnings)
    assert found.unseen.rmse[-1] < 0.2 * found.unseen.rmse[0]
