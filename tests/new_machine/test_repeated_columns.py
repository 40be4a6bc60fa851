"""A column that holds another one's values, at once or some samples later, is a copy: no encoder, no measurement."""

import numpy as np
import pytest

from tests.taken_columns import taken

TIME = np.arange(2000) * 2e-3
NOISE = np.random.default_rng(1).normal(size=(3, len(TIME)))
ANGLE = np.round(np.sin(3.0 * TIME) + 0.4 * np.sin(7.0 * TIME) + 1e-4 * NOISE[0], 6)
TORQUE = np.round(np.cos(3.0 * TIME) + 0.01 * NOISE[1], 4)


def late(values, samples):
    """The values so many samples later; the first one stands until then."""
    return np.concatenate([np.full(samples, values[0]), values[: len(values) - samples]])


def logged(**more):
    """A joint's columns and ``more``."""
    return {"time [s]": TIME, **more, "position": ANGLE, "torque": TORQUE}


@pytest.mark.parametrize(
    "name", ["last_position", "position_prev", "position_t-1", "position_lag1", "position_raw", "last angle [rad]"]
)
def test_the_last_position_is_no_second_encoder(name, drafted):
    draft = drafted(logged(**{name: late(ANGLE, 1)}))
    assert f"{name}: not used, since it repeats position one sample later: it is no second encoder" in draft.said
    assert "output_position" not in draft.map and "position → motor_position" in draft.said


def test_the_positions_before_the_last_one_repeat_the_first_of_all(drafted):
    said = drafted(logged(position_last=late(ANGLE, 1), position_last_last=late(ANGLE, 2))).said
    assert "position_last_last: not used, since it repeats position 2 samples later" in said
    assert "position_last: not used, since it repeats position one sample later" in said


def test_a_position_in_another_unit_is_no_second_encoder(drafted):
    columns = {"time [s]": TIME, "angle [rad]": ANGLE, "angle in degrees [deg]": np.round(np.degrees(ANGLE), 4)}
    said = drafted({**columns, "torque": TORQUE}).said
    assert "angle in degrees [deg]: not used, since it holds the same values as angle [rad]" in said


def test_a_position_in_two_units_and_its_last_value_without_one_are_one_encoder(drafted):
    columns = {"time [s]": TIME, "position [deg]": np.degrees(ANGLE), "position [rad]": ANGLE, "torque": TORQUE}
    draft = drafted({**columns, "position_last": late(ANGLE, 1)})
    assert "position_last: not used, since it repeats position [deg] one sample later" in draft.said
    assert "output_position" not in draft.map


def test_a_copy_that_begins_again_with_each_run_is_one_all_the_same():
    copied = late(ANGLE, 1)
    copied[::200] = 0.0
    assert "output_position" not in taken(logged(position_last=copied))


def test_currents_that_differ_by_a_constant_are_no_copies():
    columns = {"time [s]": TIME, "position": ANGLE, "motor current [A]": TORQUE, "phase current [A]": TORQUE + 0.5}
    assert taken(columns)["current"] == "motor current [A]"


def test_of_equal_columns_that_whose_name_tells_more_is_read():
    found = taken({"time [s]": TIME, "position": ANGLE, "motor position [rad]": ANGLE, "torque": TORQUE})
    assert found["motor_position"] == "motor position [rad]" and "output_position" not in found


def test_the_last_command_of_the_force_is_none(drafted):
    columns = {"time [s]": TIME, "position": ANGLE, "force_last_desired": late(TORQUE, 1), "force_desired": TORQUE}
    draft = drafted(columns)
    assert "force_last_desired: not used, since it repeats force_desired one sample later" in draft.said
    assert "force_desired → motor_torque" in draft.said


def behind_play(angle, play):
    """An output that follows an angle (n,) at either side of the play."""
    followed, at = np.empty_like(angle), angle[0]
    for k, each in enumerate(angle):
        at = min(max(at, each - play), each + play)
        followed[k] = at
    return followed


@pytest.mark.parametrize(
    "output",
    [
        np.round(behind_play(ANGLE, 2e-3), 6),
        np.round(late(ANGLE, 1) + 1e-5 * NOISE[2], 6),
        np.round(ANGLE + 3e-4 * NOISE[2], 3),  # coarser digits
    ],
    ids=["play", "noise", "coarse"],
)
def test_a_second_encoder_with_play_or_noise_is_used(output):
    found = taken(logged(position_b=output))
    assert {found["motor_position"], found["output_position"]} == {"position", "position_b"}


def test_a_coarse_output_at_rest_behind_a_fine_motor_is_used():
    turned = np.where(TIME < 0.1, np.sin(60.0 * TIME), np.sin(6.0)) + 1e-4 * NOISE[0]
    output = np.round(behind_play(turned, 0.05), 1)
    found = taken({**logged(position_b=output), "position": np.round(turned, 6)})
    assert {found["motor_position"], found["output_position"]} == {"position", "position_b"}


@pytest.mark.parametrize(("way", "told"), [(1.0, "another zero"), (-1.0, "another zero and the other way round")])
def test_a_position_counted_anew_is_no_second_encoder(way, told, drafted):
    """A program had computed its angle from the sensor's: the output was said to turn against the motor."""
    draft = drafted({**logged(), "computed_position": 2.0 + way * ANGLE})
    assert f"computed_position: not used, since it holds the values of position, counted from {told}" in draft.said
    assert "output_position" not in draft.map


def test_a_second_encoder_on_the_same_shaft_is_no_copy():
    other = np.round(2.0 - ANGLE + 1e-5 * NOISE[2], 6)
    assert taken(logged(link_position=other))["output_position"] == "link_position"
