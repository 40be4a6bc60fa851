"""A shaft that friction holds, and that only gives way: refused with what is true, and with what would help."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.observation import observe_all
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model import load_model
from ema_twin_sim.model.own_units import OwnUnits, recording_in

STEP = 5e-6  # rad, of the encoder


@pytest.fixture(scope="module")
def motor():
    return load_model("laas_motor").with_value("sensors.current_noise", 0.0)


def pushed(way):
    """A shaft that a slow torque of ±20 mN m pushes to and fro by a ``way`` [rad], late, as a bristle; by a counter."""
    time = np.arange(2000) * 5e-3
    signals = {
        "motor_torque": 0.02 * np.sin(1.2 * time),
        "motor_position": STEP * np.floor(0.5 * way * np.sin(1.2 * time - 0.3) / STEP),
    }
    return Recording("pushed", np.rint(time * 1e9).astype(np.int64), signals)


@pytest.mark.parametrize("way", [3.5e-4, 2.0 * STEP])
@pytest.mark.parametrize("units", [OwnUnits(), OwnUnits(time=30.0, torque=0.2)])
def test_a_shaft_that_only_gives_way_is_refused_with_a_remedy_that_applies(motor, way, units):
    """On fast and on slow machines: it was to be recorded longer, which shows no more."""
    with pytest.raises(
        InputError, match=r"less than an encoder's step \(5.00 µrad\) a sample.*record it sliding"
    ) as said:
        discover([recording_in(pushed(way), units)], motor)
    assert "longer, or" not in str(said.value)


def test_one_that_slides_far_is_judged(motor):
    assert len(observe_all(*to_own_units([pushed(3.0)], motor))[0].rows) > 100
