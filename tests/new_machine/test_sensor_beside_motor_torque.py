"""`init` with a load's sensor beside the motor's own torque, or one that nearly goes with the current."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.new_machine.torque_beside_current import not_filtered
from tests.recorded import sampled

TIME = np.arange(3000) * 5e-3
SPEED = 20.0 * np.sin(3.1 * TIME) + 8.0 * np.sin(7.2 * TIME)
LOAD = 3.0 * np.sin(0.9 * TIME) + 1.0
FRICTION = 0.05 * SPEED + 0.5 * np.sign(SPEED)
DRIVE = 0.02 * np.gradient(SPEED, TIME) + FRICTION + LOAD
RANDOM = np.random.default_rng()


@pytest.fixture(autouse=True)
def same_noise():
    """Whichever tests ran before."""
    RANDOM.bit_generator.state = np.random.default_rng(8).bit_generator.state


def noisy(values, share=0.01):
    return values + share * np.std(values) * RANDOM.standard_normal(len(values))


@pytest.fixture
def mapped(drafted):
    """The lines of the map that `init` drafts, by signal, and what it prints; ``columns`` are (n,) by their names."""
    moving = {"time [s]": TIME, "position [rad]": np.cumsum(SPEED) * 5e-3, "speed [rad/s]": SPEED}

    def of(**columns):
        draft = drafted({**moving, **columns})
        lines = draft.map.splitlines()
        return {line.split(":")[0].strip(): line for line in lines if line.startswith("  ")}, draft.said

    return of


@pytest.mark.parametrize("of_motor", ["motor torque [Nm]", "torque [Nm]", "drive torque [Nm]"])
@pytest.mark.parametrize("name", ["trd605 torque sensor", "torque sensor", "sensor torque", "torque transducer"])
def test_a_transducer_beside_the_motors_torque_is_the_load(mapped, of_motor, name):
    """It was used only beside a current, and dropped without a word beside a torque."""
    drawn, told = mapped(**{of_motor: noisy(DRIVE), f"{name} [Nm]": noisy(LOAD)})
    assert of_motor.split(" [")[0] in drawn["motor_torque"] and name in drawn["load_torque"]
    assert f"{name} [Nm] → load_torque in N m" in told


def test_a_transducer_alone_is_all_that_tells_the_drive(mapped):
    drawn, _ = mapped(**{"torque sensor [Nm]": noisy(DRIVE)})
    assert "torque sensor" in drawn["motor_torque"] and "load_torque" not in drawn


def test_a_measured_torque_that_explains_the_motors_is_the_load(mapped):
    columns = {"motor torque [Nm]": noisy(DRIVE), "measured torque [Nm]": noisy(LOAD)}
    drawn, told = mapped(**columns)
    assert "motor torque" in drawn["motor_torque"] and "measured torque" in drawn["load_torque"]
    assert "# CHECK: taken for the load" in drawn["load_torque"]
    assert "it explains motor torque [Nm]" in told


def test_one_that_does_not_is_left_out_with_a_sentence(mapped):
    columns = {"motor torque [Nm]": noisy(DRIVE), "measured torque [Nm]": np.sin(0.41 * TIME + 1.0)}
    drawn, told = mapped(**columns)
    assert "load_torque" not in drawn
    assert "measured torque [Nm]: not used: motor torque [Nm] is the motor's by its name" in told


@pytest.mark.parametrize("name", ["trs605-5 torque [Nm]", "FUTEK torque [Nm]"])
def test_a_transducers_series_or_maker_tells_it_too(mapped, name):
    drawn, _ = mapped(**{"current [A]": noisy(DRIVE / 0.5), name: noisy(LOAD)})
    assert name.split(" [")[0] in drawn["load_torque"] and "motor_torque" not in drawn


def beside_current(torque, current, **kinds):
    signals = {"current": current, "motor_torque": torque}
    return not_filtered([sampled("r", TIME, signals, metadata=kinds)])


def delayed(values, samples):
    return np.concatenate([np.full(samples, values[0]), values[:-samples]])


def smoothed(values, width):
    return np.convolve(np.pad(values, (width - 1, 0), "edge"), np.full(width, 1.0 / width), "valid")


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(
    "estimate",
    [
        lambda current: 0.5 * current,
        lambda current: 0.5 * np.round(current, 1),
        lambda current: 0.5 * delayed(current, 2),
        lambda current: 0.5 * smoothed(current, 5),
        lambda current: noisy(0.5 * current, 0.3),
        lambda current: 0.5 * current - 3.0,
    ],
    ids=["exact", "rounded", "delayed", "filtered", "noisy", "offset"],
)
def test_what_a_drive_computes_follows_the_current_near_each_sample(estimate, size):
    current = noisy(DRIVE / 0.5, 0.02)
    assert beside_current(size * estimate(current), current) is None


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_what_a_sensor_measures_lacks_friction(size):
    current = noisy((3.0 * LOAD + FRICTION) / 0.5, 0.05)
    assert 0.1 < beside_current(size * noisy(3.0 * LOAD), current) < 0.4
    assert beside_current(size * noisy(3.0 * LOAD), current, **{POINTS: "yes"}) is None  # points have no neighbours


def test_few_rows_or_constants_tell_nothing():
    stamps = np.arange(15) * 5_000_000
    few = Recording("r", stamps, {"current": np.arange(15.0), "motor_torque": np.arange(15.0) ** 2})
    assert not_filtered([few]) is None and not_filtered([]) is None
    assert beside_current(np.full(3000, 0.3), DRIVE) is None and beside_current(DRIVE, np.zeros(3000)) is None


def test_if_nothing_decides_init_asks_and_gives_the_line_for_the_map(mapped):
    """A sensor that nearly goes with the current was read as the motor's torque without a word."""
    wavering = 0.4 * np.sin(1.7 * TIME)  # of the friction, so that the motion does not explain what is left
    current = noisy((LOAD + wavering + FRICTION) / 0.5, 0.2)
    drawn, told = mapped(**{"q-axis [A]": current, "torque [Nm]": noisy(LOAD)})
    line = drawn["motor_torque"]
    assert "# CHECK: " in line and "of it does not follow q-axis [A]: is it the motor's, or a sensor's behind" in line
    assert "`load_torque: {columns: ['torque \\[Nm\\]'], unit: N m, shaft: output}`" in told
    drawn, told = mapped(**{"q-axis [A]": current, "motor torque [Nm]": noisy(LOAD)})
    assert "CHECK" not in drawn["motor_torque"] and "replace its line" not in told
