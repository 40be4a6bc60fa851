"""The drive's torque beside what inertia and loads need: a factor or a sign is told, piece by piece."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.measured import drive_regression
from ema_twin_sim.measured.consistency import inconsistencies, refuse_inconsistent
from ema_twin_sim.measured.drive_regression import agreed_sign, sign_of_drive
from ema_twin_sim.measured.scales import to_own_units
from tests.recorded import benched, sampled, scaled, with_signals


def test_a_disturbance_is_no_wrong_unit(stock):
    """Cogging accelerates the motor, and the current follows it late: its slope to the acceleration is anything."""
    cogging = stock.with_effect("cogging", {"torque": 0.1})
    slow = benched(cogging, "ramp:0.01", 10.0, name="slow", seed=2)
    assert not list(inconsistencies(slow, stock))


@pytest.mark.parametrize("load", ["spring_load", "gravity_load"])
def test_a_load_that_the_model_knows_is_no_inertia(stock, load):
    """A spring moves a sine against its acceleration: only beside it does the current's sign tell."""
    size = {"spring_load": {"stiffness": 20.0}, "gravity_load": {"torque": 2.0, "angle": 0.0}}[load]
    loaded = stock.with_effect(load, size)
    swung = benched(loaded, "sine:0.05:1", 5.0, name="swung", seed=4, origins=(0.0, 0.0))
    assert not list(inconsistencies(swung, loaded))
    turned = scaled(swung, current=-1.0, current_setpoint=-1.0)
    turned = replace(turned, output_angle_origin=swung.output_angle_origin)
    assert "sign were turned round" in str(next(inconsistencies(turned, loaded)))


@pytest.fixture
def minutes(stock, monkeypatch):
    """A recording in three pieces, the first of them at rest, a sample of each unknown at its beginning."""
    monkeypatch.setattr(drive_regression, "PIECE", 4.0)
    loaded = stock.with_effect("gravity_load", {"torque": 2.0, "angle": 0.0})
    swung = benched(loaded, "sine:0.05:1", 12.0, name="swung", seed=4, origins=(0.0, math.pi))
    signals = {name: np.where(swung.time < 4.0, values[0], values) for name, values in swung.signals.items()}
    for values in signals.values():
        values[::2000] = np.nan
    return loaded, with_signals(swung, signals)


def test_a_later_piece_tells_what_the_first_cannot(minutes):
    loaded, swung = minutes
    turned = scaled(swung, current=-1.0, current_setpoint=-1.0)
    for origin in (math.pi, math.nan):  # an unknown one counts as zero
        bench = loaded.with_value("effects.gravity_load.angle", 0.0 if origin == math.pi else math.pi)
        assert not list(inconsistencies(replace(swung, output_angle_origin=origin), bench))
        (found,) = inconsistencies(replace(turned, output_angle_origin=origin), bench)
        assert "sign were turned round" in str(found)


def test_a_clock_that_jumps_costs_nothing(stock, monkeypatch):
    driven = benched(stock, "sine:0.02:2", 5.0, name="driven", seed=1)
    stamps = driven.stamps.copy()
    stamps[len(stamps) // 2 :] += 1_700_000_000 * 10**9
    looked = []

    def look(*piece):
        looked.append(piece)
        assert len(looked) <= 2, "empty pieces are looked at"
        raise InputError("nothing is seen in it")

    monkeypatch.setattr(drive_regression, "observe", look)
    assert not list(inconsistencies(replace(driven, stamps=stamps), stock))
    assert looked


def turning(name, torque, speed):
    """A motor's torque (n,) at a speed (n,) in one direction."""
    time = np.arange(len(speed)) * 1e-3
    signals = {"motor_torque": torque, "speed": speed, "motor_position": np.cumsum(speed) * 1e-3}
    return sampled(name, time, signals)


def shaken(droop):
    """A load shakes a motor that turns steadily, and whose torque falls by ``droop`` where its speed rises as much."""
    share = 0.2 * np.sin(40.0 * np.arange(4000) * 1e-3)
    return turning("shaken", 0.25 * (1.0 - droop * share), 28.0 * (1.0 + share))


def driven(sign):
    """A motor accelerates and brakes its inertia against its friction."""
    time = np.arange(4000) * 1e-3
    speed = 28.0 * (1.0 + 0.5 * np.sin(20.0 * time))
    return turning("driven", sign * (0.1 + 5e-3 * speed + 5e-4 * 280.0 * np.cos(20.0 * time)), speed)


def signs(recordings, model):
    own, its_model = to_own_units(recordings, model)
    return [sign_of_drive(recording, its_model) for recording in own]


@pytest.mark.parametrize("droop", [0.02, 0.2, 1.0, 3.0])
def test_a_torque_that_drives_the_motion_is_not_taken_for_reversed(motor, droop):
    """Slopes of what is left beside the loads say it pushes; it brings energy in all along, as no friction does."""
    assert signs([shaken(droop)], motor) == [0]


def test_a_torque_that_takes_energy_out_of_a_machine_with_friction_is_reversed(motor):
    assert signs([driven(1.0), driven(-1.0)], motor) == [1, -1]


def test_one_recording_does_not_turn_what_others_tell(motor):
    """One map reads them all: opposite signs are a question that names both, and a sign that all have is refused."""

    def told(recordings):
        own, its_model = to_own_units(recordings, motor)
        return refuse_inconsistent(own, its_model)

    [asked] = told([replace(driven(1.0), name="forward"), replace(driven(-1.0), name="reversed")])
    assert asked.startswith("reversed: ") and "sign were turned round, but not in forward" in asked
    for reversed_ones in ([driven(-1.0), driven(-1.0)], [driven(-1.0), shaken(0.02)]):
        with pytest.raises(InputError, match="sign were turned round; check"):
            told(reversed_ones)


def test_discover_fit_and_compare_ask_about_a_sign_that_differs(motor):
    recordings = [replace(driven(1.0), name="forward"), replace(driven(-1.0), name="reversed")]
    assert "but not in forward" in discover(recordings, motor).misread[0]
    assert "but not in forward" in compare(recordings, motor).misread[0]
    assert any("but not in forward" in found.message for found in fit_model(recordings, motor).warnings)


def test_signs_that_disagree_tell_nothing():
    assert [agreed_sign(told) for told in ([0, 1, 0, 1], [-1], [1, 0, -1], [0], [])] == [1, -1, 0, 0, 0]
