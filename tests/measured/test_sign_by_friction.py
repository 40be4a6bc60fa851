"""A hoist's load hides its friction from what the whole torque tells; over the same way back it does not."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.measured.drive_regression import sign_of_drive
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.measured.sign_by_friction import sign_by_friction
from ema_twin_sim.model import load_model
from tests.recorded import sampled

PERIOD = 0.02
TIME = np.arange(2000) * PERIOD
UP_AND_DOWN = 6.0 * np.clip(2.0 * np.sin(2.0 * np.pi * TIME / TIME[-1]), -1.0, 1.0)
UP = 6.0 * np.clip(4.0 * np.sin(np.pi * TIME / TIME[-1]), 0.0, 1.0)
LOAD, FRICTION = 0.36, 0.03


@pytest.fixture(scope="module")
def hoist(tmp_path_factory):
    place = tmp_path_factory.mktemp("models") / "hoist.yaml"
    place.write_text(
        "version: 1\nmachine:\n  name: hoist\n  inertia: {value: 0.001, unit: kg m^2, tolerance: open}\n"
        "transmission: {kind: rigid}\nsensors: {}\neffects:\n  coulomb_friction: {effect: coulomb_friction, "
        "options: {side: motor}, parameters: {torque: 0.1, static_ratio: 1.0}, open: true}\n"
    )
    return load_model(place)


def lifted(speed, *, sign=1.0, friction=FRICTION, load=LOAD, slack=0.0):
    """A recording of a hoist; its rope is slack in a first share of the time."""
    random = np.random.default_rng(4)
    torque = load + friction * np.sign(speed) + 1e-3 * np.gradient(speed, TIME)
    torque[: int(slack * len(TIME))] -= 0.3 * LOAD
    torque += 0.2 * FRICTION * random.standard_normal(len(TIME))
    signals = {"motor_torque": sign * torque, "speed": speed, "motor_position": np.cumsum(speed) * PERIOD}
    return sampled("r", TIME, signals)


def told(recording, model):
    (own,), its_model = to_own_units([recording], model)
    return sign_of_drive(own, its_model), sign_by_friction(own, its_model)


@pytest.mark.parametrize("slack", [0.0, 0.04])
@pytest.mark.parametrize("load", [LOAD, -LOAD, 0.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_tells_the_sign_beside_a_load_that_stays(hoist, sign, load, slack):
    by_all, by_friction = told(lifted(UP_AND_DOWN, sign=sign, load=load, slack=slack), hoist)
    assert by_friction == sign and by_all in ((0,) if load else (0, sign))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_motion_one_way_tells_none(hoist, sign):
    """Another load in another recording would look like friction, of either sign."""
    assert told(lifted(UP, sign=sign), hoist)[1] == 0 and told(lifted(-UP, sign=sign), hoist)[1] == 0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_ways_that_never_meet_tell_none(hoist, sign):
    """Down in another part of the way: the place may be what the load depends on."""
    back = lifted(UP_AND_DOWN, sign=sign)
    place, half = back.signals["motor_position"].copy(), len(TIME) // 2
    place[half:] -= 2.0 * place[half]
    apart = Recording("r", back.stamps, {**back.signals, "motor_position": place})
    assert told(apart, hoist)[1] == 0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_without_friction_nothing_tells_it(hoist, sign):
    assert told(lifted(UP_AND_DOWN, sign=sign, friction=0.0), hoist)[1] == 0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_load_that_drifts_is_no_friction(hoist, sign, way):
    """Forwards first and then back, a drift is another load on the way back."""
    held = lifted(UP_AND_DOWN, friction=0.0)
    drifted = held.signals["motor_torque"] + way * FRICTION * (2.0 * TIME / TIME[-1] - 1.0)
    drifting = Recording("r", held.stamps, {**held.signals, "motor_torque": sign * drifted})
    assert told(drifting, hoist)[1] == 0
