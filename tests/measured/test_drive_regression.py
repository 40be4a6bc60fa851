"""The drive's torque beside what inertia and loads need: a factor or a sign is told, piece by piece."""

import math
from dataclasses import replace

import numpy as np
import pytest
from recorded import scaled, with_signals

from ema_bench_replay.errors import InputError
from ema_twin_sim.measured import drive_regression
from ema_twin_sim.measured.consistency import inconsistencies
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench


def test_a_disturbance_is_no_wrong_unit(stock):
    """Cogging accelerates the motor, and the current follows it late: its slope to the acceleration is anything."""
    cogging = stock.with_effect("cogging", {"torque": 0.1})
    slow = virtual_bench(cogging, parse_command("ramp:0.01"), 10.0, name="slow", seed=2)
    assert not list(inconsistencies(slow, stock))


@pytest.mark.parametrize("load", ["spring_load", "gravity_load"])
def test_a_load_that_the_model_knows_is_no_inertia(stock, load):
    """A spring moves a sine against its acceleration: only beside it does the current's sign tell."""
    size = {"spring_load": {"stiffness": 20.0}, "gravity_load": {"torque": 2.0, "angle": 0.0}}[load]
    loaded = stock.with_effect(load, size)
    swung = virtual_bench(loaded, parse_command("sine:0.05:1"), 5.0, name="swung", seed=4, origins=(0.0, 0.0))
    assert not list(inconsistencies(swung, loaded))
    turned = scaled(swung, current=-1.0, current_setpoint=-1.0)
    turned = replace(turned, output_angle_origin=swung.output_angle_origin)
    assert "sign were turned round" in str(next(inconsistencies(turned, loaded)))


@pytest.fixture
def minutes(stock, monkeypatch):
    """A recording in three pieces, the first of them at rest, a sample of each unknown at its beginning."""
    monkeypatch.setattr(drive_regression, "PIECE", 4.0)
    loaded = stock.with_effect("gravity_load", {"torque": 2.0, "angle": 0.0})
    swung = virtual_bench(loaded, parse_command("sine:0.05:1"), 12.0, name="swung", seed=4, origins=(0.0, math.pi))
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
    driven = virtual_bench(stock, parse_command("sine:0.02:2"), 5.0, name="driven", seed=1)
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
