"""Shafts that turn against each other, as those of one spur gear stage: init reads the output's sign reversed."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.measured.consistency import inconsistencies
from ema_twin_sim.measured.ratio_of_positions import ratio_of_positions
from ema_twin_sim.measured.scales import to_own_units

TIME = np.arange(2000) * 2e-3
ANGLE = 30.0 * (1.0 - np.cos(2.0 * TIME))
SPEED = 60.0 * np.sin(2.0 * TIME)
CURRENT = 0.5 * np.sign(SPEED) + 0.2 * np.cos(2.0 * TIME)
TURN = 2.0 * np.pi


def geared(output, column, command=(), current=CURRENT):
    """Columns of a motor whose output goes along ``output`` (n,) in ``column``, and perhaps follows a ``command``."""
    columns = {"time [s]": TIME, "current [A]": current, "motor position [rad]": ANGLE, column: output}
    return columns | ({"output position setpoint [rad]": command} if len(command) else {})


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("column", "size"), [("output position [rad]", 1.0), ("output position [deg]", 360.0 / TURN)])
@pytest.mark.parametrize("gear_ratio", [None, 4.0])
def test_an_output_that_turns_against_the_motor_is_turned_round(drawn, drafted, read, way, column, size, gear_ratio):
    """It was only said, beside 'no line to check', and discover refused what init had written."""
    draft = drafted(geared(way * size * ANGLE / 4.0, column), gear_ratio=gear_ratio)
    assert ("factor: -1}  # sign reversed: the output turns against the motor" in draft.map) == (way < 0.0)
    assert (f"{column} turned round" in draft.said) == (way < 0.0)
    recording, model = read(), drawn()
    assert model.value("machine.gear_ratio") == pytest.approx(4.0, rel=1e-3)
    assert recording.signals["output_position"][-1] == pytest.approx(ANGLE[-1] / 4.0, rel=1e-6)
    assert not [*inconsistencies(recording, model)]
    assert "opposite directions" not in draft.model + draft.said


def test_a_counter_is_turned_round_too(drafted, read):
    columns = geared(-np.rint(ANGLE / 4.0 / TURN * 4096.0), "output position [counts]")
    assert "counts_per_revolution: 4096, factor: -1}" in drafted(columns, gear_ratio=4.0).map
    assert read().signals["output_position"][-1] == pytest.approx(ANGLE[-1] / 4.0, abs=TURN / 4096.0)


def test_its_command_goes_with_it(drafted):
    assert drafted(geared(-ANGLE / 4.0, "output position [rad]", -ANGLE / 4.0)).map.count("factor: -1") == 2


def test_a_motion_that_comes_back_after_a_tenth_of_the_recording_tells_the_ratio():
    """Over a whole period the shafts go nowhere, and what the teeth leave between them would be all."""
    periods = 2.0 * np.pi * 10.0 * TIME / (TIME[-1] + TIME[1])
    motor = 5.0 * np.sin(periods)
    output = motor / 4.0 - 0.02 * np.tanh(8.0 * np.cos(periods))
    recording = Recording(
        "swing", np.arange(len(TIME)) * 2_000_000, {"motor_position": motor, "output_position": output}
    )
    assert ratio_of_positions(recording) == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize(
    ("current", "told", "factor"),
    [
        (CURRENT, "sign of current [A] (positive drives forwards)", 1.0),
        (
            -CURRENT,
            "current [A]: as recorded, it acts against the motion, so its sign is reversed (`factor: -1` in",
            -1.0,
        ),
        (0.1 * np.sin(40.0 * TIME), "Assumed: current [A]: positive drives forwards, which the recordings", 1.0),
    ],
    ids=["as recorded", "turned", "undecided"],
)
def test_the_sign_of_the_current_is_found_or_assumed(drawn, drafted, read, current, told, factor):
    """Nothing was said of it, and discover refused a map that init had just written."""
    draft = drafted(geared(ANGLE / 4.0, "output position [rad]", current=current))
    assert told in draft.told
    assert read().signals["current"][100:200] == pytest.approx(factor * current[100:200], abs=1e-6)
    (own,), model = to_own_units([read()], drawn())
    assert not [*inconsistencies(own, model)]


HOIST = 5.0 + 0.4 * np.sign(SPEED) + 0.02 * np.sin(900.0 * TIME)


@pytest.mark.parametrize(
    ("current", "told", "factor"),
    [
        (HOIST, "sign of current [A] (positive drives forwards)", 1.0),
        (-HOIST, "current [A]: as recorded, it acts against the motion, so its sign is reversed", -1.0),
        (5.0 + 0.02 * np.sin(900.0 * TIME), "current [A]: positive drives forwards, which the recordings do not", 1.0),
    ],
    ids=["as recorded", "turned", "without friction"],
)
def test_a_hoists_friction_tells_the_sign_though_its_load_is_twelve_times_as_large(drafted, current, told, factor):
    draft = drafted(geared(ANGLE / 4.0, "output position [rad]", current=current))
    assert told in draft.told and ("factor: -1" in draft.map) == (factor < 0.0)


UNTOLD = 0.1 * np.sin(40.0 * TIME)


@pytest.mark.parametrize(
    ("currents", "told", "factor"),
    [
        ((UNTOLD, CURRENT, UNTOLD), "sign of current [A] (positive drives forwards)", 1.0),
        ((UNTOLD, -CURRENT), "current [A]: as recorded, it acts against the motion, so its sign is reversed", -1.0),
        (
            (CURRENT, -CURRENT, UNTOLD),
            "current [A]: positive drives forwards, though it acts against the motion in run1 (1 of 2 recordings",
            1.0,
        ),
    ],
    ids=["as recorded", "turned", "contradictory"],
)
def test_all_recordings_are_asked_for_the_sign_of_the_current(drafted, currents, told, factor):
    """Only the one with the longest motion was asked, here the first, and discover refused the others."""
    draft = drafted(*(geared(ANGLE / 4.0, "output position [rad]", current=current) for current in currents))
    assert told in draft.told and ("factor: -1" in draft.map) == (factor < 0.0)
