"""A model that holds what repeats along the motor's angle tells where the zero of each further recording is."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import AT
from ema_twin_sim.commands.judged import with_one_zero
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery import zeros_by_model as zeros
from ema_twin_sim.discovery.zeros_by_model import with_the_models_zeros, zeros_by_model
from tests.discovery.test_differing_zeros import DRY, INERTIA, NOISE, PERIOD, VISCOUS, WAVES, ZEROS, anew, turning
from tests.open_motor import open_motor
from tests.recorded import changed


@pytest.fixture(scope="module")
def plain():
    """The motor of these recordings, as one knows it that has just been drafted."""
    return open_motor(1.0, NOISE, PERIOD, speed_noise=1e-3)


@pytest.fixture(scope="module")
def cogging(plain):
    """All of its numbers known."""
    motor = plain.without_effect("viscous_friction").with_effect("viscous_friction", {"coefficient": VISCOUS})
    motor = motor.with_value("machine.motor_inertia", INERTIA).with_value("effects.coulomb_friction.torque", DRY)
    for order, torque, phase in WAVES:
        motor = motor.with_effect("cogging", {"torque": torque, "phase": phase}, {"order": str(order)})
    return motor


def test_each_zero_is_found_by_the_models_waves(cogging):
    by = zeros_by_model(anew(), cogging)
    assert by == pytest.approx({name: zero for name, zero in ZEROS.items() if zero}, abs=0.01)


def test_one_recording_alone_has_a_zero_as_well(cogging):
    assert zeros_by_model([turning("c", 0.9, 0.1)], cogging) == pytest.approx({"c": 0.9}, abs=0.01)


def test_the_error_of_a_comparison_falls_to_the_noise(cogging):
    moved, (told,) = with_the_models_zeros(anew(), cogging)
    assert "mrad for c" in told and "rad for d" in told and moved[2].warnings == (told,)
    before, after = (compare(given, cogging).overall["unexplained_torque"] for given in (anew(), moved))
    assert after["rmse"] < 2.0 * after["noise_floor"] < 0.2 * before["rmse"]
    assert with_the_models_zeros(moved, cogging)[1] == ()


def test_what_the_comparison_does_is_told(plain, cogging, capsys):
    """The first model in which something repeats tells the zeros for all of them."""
    moved = with_one_zero(anew(), [plain, cogging])
    assert [r.motor_angle_origin for r in moved] == pytest.approx([0.0, 0.0, 0.9, -1.7], abs=0.01)
    assert "they are moved by" in " ".join(capsys.readouterr().err.split())


def test_the_first_model_that_repeats_decides_though_it_moves_nothing(cogging, capsys):
    """Another one, of a wrong phase, would move all of them away from it."""
    together = anew(zeros=dict.fromkeys(ZEROS, 0.0))
    off = cogging.with_value("effects.cogging.phase", WAVES[0][2] + 0.5)
    assert zeros_by_model(together, off)
    assert with_one_zero(together, [cogging, off]) == together and not capsys.readouterr().err


def test_a_fit_keeps_what_all_recordings_have_in_common(cogging):
    """It is the model's phase, which is to be fitted; an encoder may be absolute."""
    off = cogging.with_value("effects.cogging.phase", WAVES[0][2] + 0.5)
    together = anew(zeros=dict.fromkeys(ZEROS, 0.0))
    assert with_the_models_zeros(together, off, between_them=True) == (together, ())
    moved, _ = with_the_models_zeros(anew(), cogging, between_them=True)
    assert [r.motor_angle_origin for r in moved] == pytest.approx([0.0, 0.0, 0.9, -1.7], abs=0.02)
    assert with_the_models_zeros([turning("c", 0.9, 0.1)], cogging, between_them=True)[1] == ()


def test_a_position_of_the_output_is_moved_by_the_outputs_angle(cogging):
    geared = cogging.with_value("machine.gear_ratio", 20.0)
    seen = turning("c", 0.9, 0.1)
    turned = changed(seen, motor_position=seen.signals["motor_position"] / 20.0)
    at_output = replace(turned, metadata={f"motor_position{AT}": "output"})
    assert zeros_by_model([at_output], geared) == pytest.approx({"c": 0.9 / 20.0}, abs=1e-3)


def test_a_long_recording_is_read_where_it_moves(cogging, monkeypatch):
    """Its first part may be at rest, which tells neither a zero nor the sizes of its motion."""
    monkeypatch.setattr(zeros, "SAMPLES", 3000)
    moving = turning("c", 0.9, 0.1)
    rest = {name: np.concatenate([np.full(6000, values[0]), values]) for name, values in moving.signals.items()}
    stamps = np.arange(6000 + len(moving)) * round(PERIOD * 1e9)
    long = replace(moving, stamps=stamps, signals=rest)
    assert zeros_by_model([long], cogging) == pytest.approx({"c": 0.9}, abs=0.02)


def blind(seen):
    """The recording without its position."""
    return replace(seen, signals={name: seen.signals[name] for name in ("current", "speed")})


def test_a_recording_that_has_no_position_keeps_nothing_from_the_others(cogging):
    runs = [turning("c", 0.9, 0.1), blind(turning("b", 0.0, 0.12))]
    assert zeros_by_model(runs, cogging) == pytest.approx({"c": 0.9}, abs=0.01)


def test_nothing_is_moved_where_nothing_tells_a_zero(plain, cogging):
    together = dict.fromkeys(ZEROS, 0.0)
    assert zeros_by_model(anew(), plain) == {}
    assert zeros_by_model(anew(zeros=together), cogging) == {}
    assert zeros_by_model(anew(waves=()), cogging) == {}  # the waves of another motor tell nothing of this one
    assert zeros_by_model([turning("c", 0.9, 0.5, way=0.1)], cogging) == {}  # less than a cycle
    assert zeros_by_model([blind(turning("c", 0.9, 0.1))], cogging) == {}


def test_a_weight_over_a_part_of_a_turn_moves_no_zero(plain, cogging):
    """Its curve is no wave: another zero and another constant load, or friction, look alike there."""
    heavy = plain.with_effect("gravity_load", {"torque": 0.05, "angle": 0.4})
    swing = turning("c", 0.9, 0.3, waves=((1, 0.05, -0.4 + 0.3),), way=0.8)
    same, (told,) = with_the_models_zeros([swing], heavy)
    assert same == [swing] and "at another angle: by 400 mrad of the positions" in told
    both = cogging.with_effect("gravity_load", {"torque": 0.05, "angle": 0.4})
    moved = zeros_by_model([turning("c", 0.0, 0.3, waves=(*WAVES, (1, 0.05, -0.1)), way=3.0)], both)
    assert abs(moved.get("c", 0.0)) < 0.01
