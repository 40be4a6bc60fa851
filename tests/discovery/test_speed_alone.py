"""Recordings of a speed and a torque, without any position: the way that the speed makes stands in."""

import math

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.model.matching import BY_SPEED, matched
from tests.discovery.test_bent_friction import moved, open_joint
from tests.recorded import changed, record, with_signals


def of_speed_alone(recording):
    return with_signals(recording, {n: recording.signals[n] for n in ("current", "speed")}, recording.stamps)


def friction(speed):
    return 12.0 * np.tanh(speed / 1e-3) + 30.0 * speed * (1.0 - 0.8 * np.abs(speed) / (np.abs(speed) + 0.5))


def test_friction_is_found_and_sized_as_with_a_position():
    whole = [moved(friction, seed) for seed in (1, 2)]
    found = discover([of_speed_alone(r) for r in whole], open_joint())
    assert (found.verdict, found.added) == ("explained", ("shear_thinning",))
    assert any("has no position" in warning for warning in found.warnings)
    beside = discover(whole, open_joint())
    told = [f.constants["machine"]["inertia"]["value"] for f in (found, beside)]
    assert told[0] == pytest.approx(told[1], rel=0.01)


def test_a_bench_without_its_encoders_gives_its_constants(stock):
    """By the drive's own speed alone."""
    stiff = stock.with_effect("quadratic_drag", {"coefficient": 6e-4})
    found = discover([of_speed_alone(r) for r in record(stiff)], stock)
    assert found.added == ("quadratic_drag",)
    assert found.parameters["quadratic_drag"]["coefficient"]["value"] == pytest.approx(6e-4, rel=0.05)


def test_the_way_is_that_of_the_speed_where_samples_are_missing_too(stock):
    recording = of_speed_alone(moved(friction, 3))
    speed = recording.signals["speed"].copy()
    speed[100:110] = math.nan
    found = matched(changed(recording, speed=speed), open_joint())
    way = moved(friction, 3).signals["motor_position"]
    assert np.abs(found.signals["motor_position"] - (way - way[0])).max() < 0.01
    assert found.metadata[BY_SPEED] == "speed"


def test_a_measured_position_stays(stock):
    recording = record(stock, ("ramp:0.05",))[0]
    assert BY_SPEED not in matched(recording, stock).metadata


def test_a_current_alone_is_refused():
    recording = moved(friction, 4)
    alone = with_signals(recording, {"current": recording.signals["current"]}, recording.stamps)
    with pytest.raises(InputError, match="no motor_position"):
        discover([alone], open_joint())
    with pytest.raises(InputError, match="no motor_position"):
        fit_model([alone], open_joint())
