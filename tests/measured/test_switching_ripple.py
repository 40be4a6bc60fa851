"""A switching drive's own ripple is neither a missing effect nor hides one."""

import numpy as np
import pytest

from ema_twin_sim import diagnose
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.measured.switching_ripple import with_switching_ripple
from ema_twin_sim.model import load_model
from ema_twin_sim.plant.motion import SPEED
from tests.fidelities import LONGEST
from tests.recorded import benched

pytestmark = pytest.mark.timeout(LONGEST)


@pytest.fixture(scope="module")
def switching():
    return load_model("polito_hf")


@pytest.fixture(scope="module")
def healthy(switching):
    """Slow motion, where the ripple folds down to slow swings over the motor's angle."""
    return benched(switching, "triangle:0.015:2", 12.0)


@pytest.mark.slow
def test_a_healthy_switching_bench_lacks_nothing_beside_its_own_model(healthy, switching):
    assert diagnose([healthy], switching).verdict == "none"


@pytest.mark.slow
def test_what_a_switching_bench_hides_is_named_beside_its_ripple(switching):
    bench = switching.with_effect("sun_runout", {"torque": 0.03, "phase": 0.5}, {"kind": "conservative"})
    found = diagnose([benched(bench, "triangle:0.015:2", 12.0)], switching)
    assert found.verdict == "sun_runout"


def test_the_torques_noise_is_what_its_balance_leaves(healthy, switching):
    """Without any fit: the current's torque less inertia and the friction of the model that made it."""
    o = observe(healthy, switching)
    counted = with_switching_ripple(o, switching)
    inertia = sum(switching.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    speed = o.motion[o.rows, SPEED]
    friction = {name: sum(effect.parameters.get(name, 0.0) for effect in switching.effects.values()) for name in
                ("coefficient", "torque")}  # fmt: skip
    left = o.torque - inertia * o.acceleration - friction["coefficient"] * speed - friction["torque"] * np.sign(speed)
    left = left[np.abs(speed) > 1.0]  # a reversal takes a moment
    assert np.median(counted.torque_noise) == pytest.approx(left.std(), rel=0.25)
    assert np.median(o.torque_noise) < 0.6 * left.std()


def test_an_averaged_drive_has_no_ripple(healthy, stock):
    o = observe(healthy, stock)
    assert with_switching_ripple(o, stock) is o
