"""Whose shaft a motion without a name is behind a gear: by how many turns it goes, at any speed."""

import numpy as np
import pytest

TIME = np.arange(1200) * 8e-3


def robot(turns, pace, joints=1, speed_only=False):
    """Columns of joints whose second one goes so many ``turns`` from end to end."""
    columns = {"t": TIME}
    for joint in range(1, joints + 1):
        size = np.pi * turns * (1.0 if joint == min(2, joints) else 0.3)
        angle, speed = size * np.sin(pace * TIME), size * pace * np.cos(pace * TIME)
        columns |= {} if speed_only else {f"q{joint} [rad]": angle}
        columns |= {f"qd{joint} [rad/s]": speed, f"i{joint} [A]": np.cos(angle) + np.sign(speed) + 0.1 * joint}
    if joints == 1:
        columns = {name.replace("1", ""): values for name, values in columns.items()}
    return columns


@pytest.mark.parametrize("pace", [0.8, 1.5, 4.0])
@pytest.mark.parametrize("speed_only", [False, True])
def test_recordings_of_one_robot_tell_the_same_shaft_at_any_speed(pace, speed_only, drafted):
    """At 1.6 rad/s a joint's angle was read as the motor's, and at 0.98 rad/s as the output's."""
    draft = drafted(robot(0.7, pace, speed_only=speed_only), gear_ratio=101.0, torque_constant=0.125)
    for signal in ("speed",) if speed_only else ("motor_position", "speed"):
        assert "shaft: output}  # CHECK" in draft.line(signal)
    assert "turns in all, which as the motor's would turn the output by 2." in draft.said


@pytest.mark.parametrize(
    ("turns", "joints", "shaft", "asked"),
    [(1.8, 3, "output", True), (1.8, 1, "motor", True), (40.0, 1, "motor", False), (40.0, 3, "motor", False)],
)
def test_beyond_a_turn_a_robots_joint_is_the_output_and_a_lone_shaft_is_asked_about(
    turns, joints, shaft, asked, drafted
):
    draft = drafted(robot(turns, 0.9, joints), gear_ratio=101.0, torque_constant=0.125)
    line = draft.line("motor_position")
    assert (", shaft: output}" in line, "CHECK" in line) == (shaft == "output", asked)


def test_what_no_motor_reaches_behind_the_gear_is_the_motors(drafted):
    """Shaken quickly within a turn: as the output's, the motor would turn at 6000 rad/s."""
    draft = drafted(robot(0.9, 21.0), gear_ratio=101.0, torque_constant=0.125)
    assert ", shaft: output}" not in draft.line("motor_position")
