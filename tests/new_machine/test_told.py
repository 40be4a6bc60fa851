"""What init prints of a draft: numbers that its files mark are assumed, and each has the unit of what it is."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.told import assumed, doubts_of, estimated, shown
from ema_twin_sim.reading_noise import reading_noise

TIME = np.arange(2000) * 1e-3
DITHER = 1e-3 * (-1.0) ** np.arange(2000)


@pytest.fixture
def told(drafted, drawn):
    """(known or estimated, assumed) of the model that init drafts from columns beside the time."""

    def of(columns, **given):
        draft, model = drafted({"time [s]": TIME, **columns}, **given), drawn()
        doubts = doubts_of(model, draft.model, draft.map)
        return [*shown(model, doubts), *estimated(model, doubts)], assumed(model, doubts)

    return of


def test_counts_that_nobody_told_are_assumed_and_not_known(told):
    counter = np.trunc(20000.0 * np.sin(3.0 * TIME))
    known, guessed = told({"motor position [inc]": counter, "current [A]": 2.0 * np.cos(3.0 * TIME)})
    assert not [one for one in known if "encoder" in one]
    (counts,) = [one for one in guessed if "encoder" in one]
    assert counts.startswith("motor encoder 4096 counts per turn (give the counts per turn, all edges counted")
    assert "`counts_per_revolution` in the map" in counts and "init --map" in counts


def test_a_given_gear_ratio_that_both_positions_contradict_is_marked(told, tmp_path):
    swing = np.sin(3.0 * TIME)
    columns = {"motor position [rad]": 30.0 * swing, "output position [rad]": 0.3 * swing}
    known, _ = told({**columns, "current [A]": np.cos(3.0 * TIME)}, gear_ratio=50.0)
    assert "gear ratio 50" in known
    assert "# CHECK: both positions give 100" in (tmp_path / "m.yaml").read_text()


def test_a_carriages_counts_are_per_metre(told):
    known, _ = told({"position [m]": 2e-5 * np.rint(500.0 * np.sin(TIME)), "force [N]": np.cos(TIME)})
    assert "motor encoder 50000 counts per metre" in known


def test_the_noise_of_a_torque_is_a_torque(told):
    known, _ = told({"motor position [rad]": 50.0 * np.sin(TIME), "torque [Nm]": np.cos(TIME) + DITHER})
    (noise,) = (one for one in known if "noise" in one)
    assert noise.startswith("noise of the torque ") and noise.endswith("N m")


def test_an_exact_command_is_said_to_show_no_noise(told, drawn):
    """Its numbers' rounding in memory was told as a noise of 0.000000000108 nN m."""
    known, _ = told({"motor position [rad]": 50.0 * np.sin(TIME), "torque [Nm]": 0.1 * np.rint(TIME) + 0.3 * TIME})
    assert "noise of the torque none (the signal shows no noise)" in known
    assert drawn().value("sensors.current_noise") == 0.0


def test_what_was_computed_from_a_recording_is_an_estimate_and_not_known(told, drawn):
    """The gain of the speed controller was said to be known; fit moved it by 2 %, and the integral time by 9 %."""
    swing = np.sin(3.0 * TIME)
    columns = {"motor position [rad]": 100.0 * swing, "output position [rad]": swing}
    told({**columns, "current [A]": np.cos(3.0 * TIME) + DITHER}, torque_constant=0.4)
    model = drawn()
    assert [one.rpartition(" ")[0] for one in shown(model, {}) if "encoder" not in one] == ["torque constant 400 mN"]
    assert [one.split(" ")[0] for one in estimated(model, {})] == ["gear", "noise"]


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_rounding_in_memory_is_no_noise_and_any_sensors_is(size):
    ramp = size * (1.0 + np.arange(2000) / 3000.0)
    assert reading_noise(ramp) == 0.0
    noise = 1e-9 * size * np.random.default_rng(2).standard_normal(2000)
    assert reading_noise(ramp + noise) == pytest.approx(1e-9 * size, rel=0.1)


def test_the_decimals_of_a_text_are_no_encoder(told):
    swing = np.sin(5.0 * TIME)
    columns = {"motor position [deg]": np.round(2.0 * swing, 3), "output position [rad]": np.round(1e-3 * swing, 6)}
    known, _ = told({**columns, "current [A]": np.cos(TIME)})
    assert "motor position in steps of 0.001 deg (the last digit of its column)" in known
    assert "output position in steps of 1e-06 rad (the last digit of its column)" in known
    assert not [one for one in known if "counts" in one]


def test_a_noise_that_may_be_the_signal_is_not_said_to_be_known(told, drawn):
    """A current that swings as fast as its samples, and one that is nothing but noise."""
    noise = 0.01 * np.random.default_rng(2).standard_normal(2000)
    position = {"motor position [rad]": np.sin(3.0 * TIME)}
    known, guessed = told({**position, "current [A]": np.sin(2.0 * np.pi * 420.0 * TIME) + noise})
    assert not [one for one in known if "noise" in one]
    (said,) = (one for one in guessed if "noise of the current" in one)
    assert said.endswith("(at most: the signal changes as fast as noise)")
    assert drawn().value("sensors.current_noise") == pytest.approx(0.01, rel=0.15)
    _, guessed = told({**position, "current [A]": noise})
    assert [one for one in guessed if one.endswith("(as large as the whole signal, which it may be)")]
    known, _ = told({**position, "current [A]": np.cos(3.0 * TIME) + noise})
    assert [one for one in known if "noise of the current" in one]


def test_the_noise_is_that_of_all_recordings_and_steps_of_a_command_are_none(drafted):
    """It was the first file's alone: 1.3 A of an exact staircase, in whichever order the next was given."""
    noise = 0.01 * np.random.default_rng(4).standard_normal((2, len(TIME)))

    def run(current, reach):
        speed = reach * np.sin(3.0 * TIME)
        return {"time [s]": TIME, "current [A]": current, "motor speed [rad/s]": speed + noise[1]}

    steps = run(np.repeat([0.5, 1.0, -1.5, 2.0], 500), reach=9.0)
    alone = drafted(steps)
    assert "noise of the current none (the signal shows no noise)" in alone.said
    assert "whole signal" not in alone.told
    read = run(np.cos(3.0 * TIME) + noise[0], reach=5.0)
    assert drafted(steps, read).line("current_noise") == drafted(read, steps).line("current_noise")
    assert "noise of the current 10" in drafted(steps, read).said
