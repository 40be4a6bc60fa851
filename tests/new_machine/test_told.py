"""What init prints of a draft: numbers that its files mark are assumed, and each has the unit of what it is."""

import math

import numpy as np
import pytest

from ema_twin_sim.commands.init import run as init
from ema_twin_sim.model import load_model
from ema_twin_sim.new_machine.told import assumed, doubts_of, estimated, shown
from ema_twin_sim.reading_noise import reading_noise

SECONDS = [k * 1e-3 for k in range(2000)]


def told(tmp_path, header, row, **arguments):
    """(known or estimated, assumed) of the model that init drafts from a trace; ``row`` gives a time's cells."""
    trace = tmp_path / "trace.csv"
    trace.write_text("\n".join([header, *(",".join(f"{cell:.9g}" for cell in (t, *row(t))) for t in SECONDS), ""]))
    init(str(tmp_path / "own"), [trace], **arguments)
    text, map_text = ((tmp_path / name).read_text() for name in ("own.yaml", "own_map.yaml"))
    model = load_model(tmp_path / "own.yaml")
    doubts = doubts_of(model, text, map_text)
    return [*shown(model, doubts), *estimated(model, doubts)], assumed(model, doubts)


def test_counts_that_nobody_told_are_assumed_and_not_known(tmp_path):
    known, guessed = told(
        tmp_path,
        "time [s],motor position [inc],current [A]",
        lambda t: (int(20000 * math.sin(3 * t)), 2.0 * math.cos(3 * t)),
    )
    assert not [one for one in known if "encoder" in one]
    (counts,) = [one for one in guessed if "encoder" in one]
    assert counts.startswith("motor encoder 4096 counts per turn (give the counts per turn, all edges counted")
    assert "`counts_per_revolution` in the map" in counts and "init --map" in counts


def test_a_given_gear_ratio_that_both_positions_contradict_is_marked(tmp_path):
    def row(t):
        return 30.0 * math.sin(3.0 * t), 0.3 * math.sin(3.0 * t), math.cos(3.0 * t)

    known, _ = told(tmp_path, "time [s],motor position [rad],output position [rad],current [A]", row, gear_ratio=50.0)
    assert "gear ratio 50" in known
    assert "# CHECK: both positions give 100" in (tmp_path / "own.yaml").read_text()


def test_a_carriages_counts_are_per_metre(tmp_path):
    known, _ = told(
        tmp_path, "time [s],position [m],force [N]", lambda t: (2e-5 * round(500.0 * math.sin(t)), math.cos(t))
    )
    assert "motor encoder 50000 counts per metre" in known


def test_the_noise_of_a_torque_is_a_torque(tmp_path):
    def row(t):
        return 50.0 * math.sin(t), math.cos(t) + 1e-3 * (-1.0) ** round(1e3 * t)

    known, _ = told(tmp_path, "time [s],motor position [rad],torque [Nm]", row)
    (noise,) = (one for one in known if "noise" in one)
    assert noise.startswith("noise of the torque ") and noise.endswith("N m")


def test_an_exact_command_is_said_to_show_no_noise(tmp_path):
    """Its numbers' rounding in memory was told as a noise of 0.000000000108 nN m."""
    known, _ = told(
        tmp_path, "time [s],motor position [rad],torque [Nm]", lambda t: (50.0 * math.sin(t), 0.1 * round(t) + 0.3 * t)
    )
    assert "noise of the torque none (the signal shows no noise)" in known
    assert load_model(tmp_path / "own.yaml").value("sensors.current_noise") == 0.0


def test_what_was_computed_from_a_recording_is_an_estimate_and_not_known(tmp_path):
    """The gain of the speed controller was said to be known; fit moved it by 2 %, and the integral time by 9 %."""

    def row(t):
        return 100.0 * math.sin(3.0 * t), math.sin(3.0 * t), math.cos(3.0 * t) + 1e-3 * (-1.0) ** round(1e3 * t)

    header = "time [s],motor position [rad],output position [rad],current [A]"
    told(tmp_path, header, row, torque_constant=0.4)
    model = load_model(tmp_path / "own.yaml")
    assert [one.rpartition(" ")[0] for one in shown(model, {}) if "encoder" not in one] == ["torque constant 400 mN"]
    assert [one.split(" ")[0] for one in estimated(model, {})] == ["gear", "noise"]


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_rounding_in_memory_is_no_noise_and_any_sensors_is(size):
    ramp = size * (1.0 + np.arange(2000) / 3000.0)
    assert reading_noise(ramp) == 0.0
    noise = 1e-9 * size * np.random.default_rng(2).standard_normal(2000)
    assert reading_noise(ramp + noise) == pytest.approx(1e-9 * size, rel=0.1)


def test_the_decimals_of_a_text_are_no_encoder(tmp_path):
    known, _ = told(
        tmp_path,
        "time [s],motor position [deg],output position [rad],current [A]",
        lambda t: (round(2.0 * math.sin(5.0 * t), 3), round(1e-3 * math.sin(5.0 * t), 6), math.cos(t)),
    )
    assert "motor position in steps of 0.001 deg (the last digit of its column)" in known
    assert "output position in steps of 1e-06 rad (the last digit of its column)" in known
    assert not [one for one in known if "counts" in one]


def test_a_noise_that_may_be_the_signal_is_not_said_to_be_known(tmp_path):
    """A current that swings as fast as its samples, and one that is nothing but noise."""
    noise = np.random.default_rng(2).standard_normal(2000)
    slow = [math.sin(3.0 * t) for t in SECONDS]

    def drafted(current):
        by_time = dict(zip(SECONDS, zip(slow, current, strict=True), strict=True))
        return told(tmp_path, "time [s],motor position [rad],current [A]", lambda t: by_time[t], force=True)

    fast = np.sin(2.0 * np.pi * 420.0 * np.array(SECONDS))
    known, guessed = drafted(fast + 0.01 * noise)
    assert not [one for one in known if "noise" in one]
    (said,) = (one for one in guessed if "noise of the current" in one)
    assert said.endswith("(at most: the signal changes as fast as noise)")
    assert load_model(tmp_path / "own.yaml").value("sensors.current_noise") == pytest.approx(0.01, rel=0.15)
    _, guessed = drafted(0.01 * noise)
    assert [one for one in guessed if one.endswith("(as large as the whole signal, which it may be)")]
    known, _ = drafted(np.cos(3.0 * np.array(SECONDS)) + 0.01 * noise)
    assert [one for one in known if "noise of the current" in one]


def test_the_noise_is_that_of_all_recordings_and_steps_of_a_command_are_none(drafted):
    """It was the first file's alone: 1.3 A of an exact staircase, in whichever order the next was given."""
    time = np.array(SECONDS)
    noise = 0.01 * np.random.default_rng(4).standard_normal((2, len(time)))

    def run(current, reach):
        speed = reach * np.sin(3.0 * time)
        return {"time [s]": time, "current [A]": current, "motor speed [rad/s]": speed + noise[1]}

    steps = run(np.repeat([0.5, 1.0, -1.5, 2.0], 500), reach=9.0)
    alone = drafted(steps)
    assert "noise of the current none (the signal shows no noise)" in alone.said
    assert "whole signal" not in alone.told
    read = run(np.cos(3.0 * time) + noise[0], reach=5.0)
    assert drafted(steps, read).line("current_noise") == drafted(read, steps).line("current_noise")
    assert "noise of the current 10" in drafted(steps, read).said
