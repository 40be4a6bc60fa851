"""The unexplained torque near standstill: the same for exactly similar machines."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.model.own_units import OwnUnits, model_in, recording_in
from ema_twin_sim.simulation.simulate import simulate

BEYOND = 0.02  # N m that the drive gives beyond what the model needs


def turning(stock, speed):
    """The stock bench at a constant motor speed [rad/s] with a torque that its model does not explain."""
    time = np.arange(1000) * 2e-3
    friction = sum(i.parameters["torque"] for i in stock.active.values() if i.effect == "coulomb_friction")
    viscous = sum(i.parameters["coefficient"] for i in stock.active.values() if i.effect == "viscous_friction")
    current = (friction + viscous * speed + BEYOND) / stock.value("machine.torque_constant")
    signals = {
        "motor_position": speed * time,
        "speed": np.full_like(time, speed),
        "current": np.full_like(time, current),
    }
    return Recording("turning", np.rint(time * 1e9).astype(np.int64), signals)


@pytest.mark.parametrize("slower", [0.1, 1.0, 10.0, 100.0])
def test_a_machine_that_turns_slowly_does_not_rest(stock, slower):
    """At 0.4 rad/s the bench slides. So does a machine that is the same but a hundred times as slow."""
    units = OwnUnits(time=1.0 / slower)
    alike, twin = recording_in(turning(stock, 0.4), units), model_in(stock, units)
    left = simulate(twin, alike, "current").signals["unexplained_torque"]
    assert left[-1] == pytest.approx(BEYOND, rel=1e-3)


def test_the_inertia_of_a_draft_hides_nothing(stock):
    """A millionth of the inertia, as a guess may be, does not make a shaft of 0.4 rad/s rest."""
    draft = stock
    for part in ("motor", "gearbox", "output"):
        path = f"machine.{part}_inertia"
        draft = draft.with_value(path, 1e-6 * stock.value(path))
    left = simulate(draft, turning(stock, 0.4), "current").signals["unexplained_torque"]
    assert left[-1] == pytest.approx(BEYOND, rel=1e-3)


def test_a_shaft_that_hardly_moves_is_held(stock):
    left = simulate(stock, turning(stock, 0.01), "current").signals["unexplained_torque"]
    assert left[-1] == pytest.approx(0.0, abs=1e-12)
