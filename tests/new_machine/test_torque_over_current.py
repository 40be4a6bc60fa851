"""A torque that the drive computed from its current tells the torque constant."""

import numpy as np
import pytest

from ema_twin_sim.model import load_model
from ema_twin_sim.model.check_comment import ASSUMED
from ema_twin_sim.model.model_file import TORQUE_CONSTANT
from ema_twin_sim.new_machine.torque_constant import TORQUE_OVER_CURRENT

TIME = np.arange(4000) * 2e-3
SPEED = 20.0 * np.sin(3.1 * TIME) + 8.0 * np.sin(7.2 * TIME)
CONSTANT = 2.5


def shown(torque, *, name="torque [N m]", slower=1.0):
    """Columns of a current and a ``torque`` (n,) at a shaft that turns ``slower``."""
    columns = {"time [s]": TIME, "position [rad]": np.cumsum(SPEED) * 2e-3 / slower, "speed [rad/s]": SPEED / slower}
    return columns | {"q current [A]": CURRENT, name: torque}


def driving():
    """The current (n,) that inertia, friction and a load need."""
    load = 3.0 * np.sin(0.9 * TIME) + 1.0
    return np.round((0.02 * np.gradient(SPEED, TIME) + 0.05 * SPEED + 0.5 * np.sign(SPEED) + load) / CONSTANT, 5)


CURRENT = driving()


@pytest.fixture
def constant(tmp_path):
    """The torque constant that was drafted."""
    return lambda: load_model(tmp_path / "m.yaml").constants[TORQUE_CONSTANT]


def test_the_constant_is_torque_over_current(drafted, constant):
    """A constant of 1 N m/A was assumed, and the torque ignored."""
    said = drafted(shown(CONSTANT * CURRENT)).said
    assert constant().value == pytest.approx(CONSTANT, rel=1e-6) and constant().source == TORQUE_OVER_CURRENT
    assert f"torque constant 2.50 N m/A ({TORQUE_OVER_CURRENT})" in said
    assert "Assumed: torque constant" not in said


def test_readings_that_are_not_of_one_moment_leave_it_to_be_checked(drafted, constant):
    torque = CONSTANT * (CURRENT + 0.03 * np.std(CURRENT) * np.random.default_rng(3).standard_normal(len(TIME)))
    draft = drafted(shown(torque))
    assert constant().value == pytest.approx(CONSTANT, rel=0.01) and constant().source == TORQUE_OVER_CURRENT
    left = "but 3 % of the torque's changes is left: compare with the motor's data sheet"
    assert draft.line("torque_constant").endswith(left)
    assert "torque constant 2.5" in draft.said.partition("Assumed:")[2]


def test_opposite_signs_leave_it_to_be_checked_too(drafted, constant):
    model = drafted(shown(-CONSTANT * CURRENT)).model
    assert constant().value == pytest.approx(CONSTANT, rel=1e-6)
    assert "# CHECK: torque over current of the recording, but both have opposite" in model


def test_a_data_sheets_constant_comes_first(drafted, constant):
    drafted(shown(CONSTANT * CURRENT), torque_constant=0.4)
    assert (constant().value, constant().source) == (0.4, "given")


def test_behind_a_gear_the_motors_constant_is_smaller_by_its_ratio(drafted, constant):
    """All columns are of the output, which nothing but their slowness says; the torque is that of the output too."""
    said = drafted(shown(CONSTANT * CURRENT, slower=50.0), gear_ratio=50.0).said
    assert constant().value == pytest.approx(CONSTANT / 50.0, rel=1e-6) and constant().source == TORQUE_OVER_CURRENT
    assert "Assumed: torque [N m], speed [rad/s], position [rad]: read as values of the output shaft" in said


@pytest.mark.parametrize("name", ["torque [N m]", "motor torque [N m]"])
def test_behind_a_gear_whose_shafts_are_not_told_the_torque_is_asked_about(drafted, constant, name):
    said = drafted(shown(CONSTANT * CURRENT, name=name), gear_ratio=6.0).said
    assert constant().value == pytest.approx(CONSTANT, rel=1e-6)
    columns = [] if name.startswith("motor") else [name]
    columns += ["speed [rad/s]", "position [rad]"]
    assert f"Assumed: {', '.join(columns)}: read as the motor's" in said


@pytest.mark.parametrize(
    "torque",
    [
        CONSTANT * CURRENT + 0.4 * np.sign(SPEED) * np.abs(CURRENT) + 0.5 * np.sin(1.7 * TIME),  # of another sensor
        0.3 + 0.001 * np.random.default_rng(5).standard_normal(len(TIME)),  # an offset
    ],
    ids=["another", "none"],
)
def test_a_torque_that_does_not_rise_with_the_current_alone_tells_none(drafted, constant, torque):
    drafted(shown(torque, name="motor torque [N m]"))
    assert constant().value == 1.0 and constant().source == ASSUMED
