"""What the encoders' difference says of their own errors, as far as a search may go."""

import numpy as np
import pytest

from ema_twin_sim.identification import equation
from ema_twin_sim.identification.sensors import delay_of_gearbox, with_sensors
from tests.problems import fit_of
from tests.recorded import changed, record


@pytest.fixture(scope="module")
def late(stock):
    """A fit, nothing added, of a bench whose output encoder is 2 ms late."""
    f = fit_of(record(stock.with_effect("encoder_delay", {"delay": 0.002}), ("triangle:0.4839:2",)), stock)
    return f.problem, f


def test_a_lag_of_the_same_angle_at_any_speed_is_no_delay(late, stock):
    """An output that hangs behind by as much whether it turns fast or slowly: play, or a shaft wound up by friction."""
    assert not delay_of_gearbox(*late)
    runs = record(stock, ("sine:0.4:0.1", "sine:0.4:0.4"))
    f = fit_of([changed(r, output_position=r.signals["output_position"] - 2e-3 * way(r)) for r in runs], stock)
    assert delay_of_gearbox(f.problem, f)


def way(recording):
    """The direction of the motion (n,), smoothed over its reversals."""
    return np.tanh(recording.signals["speed"] / 0.5)


def test_a_late_encoder_is_told_by_a_regression(late):
    h = with_sensors(*late)
    assert h.by_path["effects.encoder_delay.delay"] == pytest.approx(0.002, rel=0.05)


def test_a_delay_begins_no_later_than_a_plant_remembers(late, monkeypatch):
    monkeypatch.setattr(equation, "longest_delay", lambda model: 0.0015)
    assert with_sensors(*late).by_path["effects.encoder_delay.delay"] == 0.0015
