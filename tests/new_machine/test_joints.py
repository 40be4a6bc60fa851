"""Traces that hold several joints, a torque transducer, or a filtered copy: which columns init takes."""

import numpy as np
import pytest

from tests.taken_columns import guessed, taken

TIME = np.arange(3000) * 2e-3


def robot(names, far=2):
    """Three joints that move each to its own beat; joint ``far`` goes farthest."""
    numbers = {"time [s]": TIME}
    for joint in (1, 2, 3):
        beat = 0.7 + 0.4 * joint
        size = 2.0 if joint == far else 0.3
        motions = (size * np.sin(beat * TIME), size * beat * np.cos(beat * TIME), np.cos(beat * TIME))
        numbers |= dict(zip((name.format(joint) for name in names), motions, strict=True))
    return numbers


@pytest.mark.parametrize(
    "names",
    [
        ("q{} [rad]", "dq{} [rad/s]", "tau{} [Nm]"),
        ("pos ({})", "speed ({})", "current ({})"),
        ("J{}_q", "J{}_qd", "J{}_i"),
    ],
)
@pytest.mark.parametrize("far", [1, 2, 3])
def test_one_joint_of_a_robots_trace_is_taken_whole(names, far):
    numbers = robot(names, far)
    position, speed, drive = (name.format(far) for name in names)
    found = taken(numbers)
    assert (found["motor_position"], found["speed"]) == (position, speed)
    assert found.get("motor_torque", found.get("current")) == drive
    assert "output_position" not in found and "load_torque" not in found
    other = 1 + far % 3
    assert taken(numbers, joint=str(other))["motor_position"] == names[0].format(other)


def test_a_missing_value_chooses_no_joint():
    numbers = robot(("q{} [rad]", "dq{} [rad/s]", "tau{} [Nm]"), far=1)
    numbers["q1 [rad]"][70] = numbers["q2 [rad]"][500] = np.nan
    backwards = dict(reversed(numbers.items()))
    assert taken(backwards)["motor_position"] == "q1 [rad]"


def test_two_numbered_shafts_of_one_train_stay_motor_and_output():
    angle = 30.0 * np.sin(TIME)
    numbers = {
        "time [s]": TIME,
        "position 1 [rad]": angle,
        "torque 1 [Nm]": np.cos(TIME),
        "position 2 [rad]": angle / 6.0 + 1e-3 * np.sign(np.cos(TIME)),
        "torque 2 [Nm]": 5.0 * np.cos(TIME),
    }
    found = taken(numbers)
    assert (found["motor_position"], found["output_position"]) == ("position 1 [rad]", "position 2 [rad]")
    assert (found["motor_torque"], found["load_torque"]) == ("torque 1 [Nm]", "torque 2 [Nm]")


def test_init_says_that_a_joint_which_moves_beside_it_may_act_on_it(drafted):
    names = ("q{} [rad]", "dq{} [rad/s]", "tau{} [Nm]")
    nearly_at_rest = robot(names, 2)
    assert " move too" not in drafted(nearly_at_rest).said
    moving = {
        name: values * (5.0 if name in ("q1 [rad]", "q3 [rad]") else 1.0) for name, values in nearly_at_rest.items()
    }
    assert "1, 3 move too" in drafted(moving).said


def test_init_tells_which_joint_it_took_and_reads_further_traces_of_it(drafted):
    names = ("q{} [rad]", "dq{} [rad/s]", "tau{} [Nm]")
    draft = drafted(robot(names, 2), robot(names, 3))  # in the second, another joint goes farther
    assert "the columns numbered 2, of the joint with the largest motion; those of 1, 3" in draft.said
    assert "q2 " in draft.map


def test_a_transducers_torque_beside_a_current_is_the_load():
    numbers = {
        "time [s]": TIME,
        "motor position [rad]": np.sin(TIME),
        "current [A]": np.cos(TIME),
        "torque sensor [Nm]": np.cos(TIME) ** 2,
    }
    assert taken(numbers)["load_torque"] == "torque sensor [Nm]"
    assert "motor_torque" not in taken(numbers)
    del numbers["current [A]"]  # then it is all that tells of a torque
    assert taken(numbers)["motor_torque"] == "torque sensor [Nm]"


def test_a_filtered_copy_of_a_position_is_no_output():
    position = np.sin(TIME)
    numbers = {"time": TIME, "pos_filt": 0.999 * position, "pos_meas": position, "tau_meas": np.cos(TIME)}
    found = taken(numbers)
    assert found["motor_position"] == "pos_meas" and "output_position" not in found
    del numbers["pos_meas"]
    assert taken(numbers)["motor_position"] == "pos_filt"


@pytest.mark.parametrize("idle", [np.zeros(len(TIME)), np.full(len(TIME), 0.5)])
@pytest.mark.parametrize(
    "names", [("q{} [rad]", "dq{} [rad/s]", "iq{} [A]"), ("pos ({})", "speed ({})", "torque ({})")]
)
def test_a_joint_whose_drive_never_changes_comes_after_those_whose_does(names, idle):
    """Of two coupled actuators the one without a current was taken, and discover refused it."""
    numbers = robot(names, far=2)
    numbers[names[2].format(2)] = idle
    guesses = guessed(numbers)
    assert guesses.joint.name != "2"
    assert guesses.joint.undriven == ("2",)
    assert "of those whose current or torque changes (that of 2 never does)" in guesses.joint.sentence
    for joint in (1, 3):
        numbers[names[2].format(joint)] = idle
    guesses = guessed(numbers)  # no drive changes: the largest motion decides
    assert guesses.joint.name == "2" and guesses.joint.undriven == ()


def test_a_torque_that_changes_does_not_stand_for_a_current_that_does_not():
    numbers = robot(("q{} [rad]", "iq{} [A]", "torque {} [Nm]"), far=2)
    numbers["iq2 [A]"] = np.zeros(len(TIME))
    numbers["iq1 [A]"][5] = np.nan
    assert guessed(numbers).joint.name in ("1", "3")


@pytest.mark.parametrize(("names", "joints"), [(("q{}", "qd{}", "i{}"), 2), (("q{}", "qd{}", "tau{}"), 3)])
def test_joints_that_move_in_step_but_have_motors_of_their_own_are_no_train(names, joints):
    """A robot first moved all joints to a pose, then one: two of the others were read as motor and output."""
    together, alone = np.sin(TIME) * (TIME < 3.0), np.sin(3.0 * TIME) * (TIME >= 3.0)
    numbers = {"t": TIME}
    for joint in range(1, joints + 1):
        angle = (0.2 + 0.1 * joint) * together + (3.0 * alone if joint == joints else 0.0)
        motions = (angle, np.gradient(angle, TIME), np.cos((joint + 1.0) * TIME))
        numbers |= dict(zip((name.format(joint) for name in names), motions, strict=True))
    found = taken(numbers)
    assert found["motor_position"] == f"q{joints}" and "output_position" not in found


def robot_with_a_tool(joints=3):
    """What a robot's interface logs: joints numbered from 0, then pose, speed and force of the tool in six numbers.

    The tool's orientation jumps by whole turns, so that it goes farthest.
    """
    numbers = {"timestamp": TIME}
    for joint in range(joints):
        beat = 1.1 + 0.4 * joint
        motions = (np.sin(beat * TIME), beat * np.cos(beat * TIME), np.cos(beat * TIME))
        names = ("actual_q_{}", "actual_qd_{}", "actual_current_{}")
        numbers |= dict(zip((name.format(joint) for name in names), motions, strict=True))
    for part in range(6):
        way = np.sign(np.sin(5.0 * TIME + part)) * np.pi
        motions = (way, np.cos(3.0 * TIME + part), np.sin(7.0 * TIME + part))
        names = ("actual_TCP_pose_{}", "actual_TCP_speed_{}", "actual_TCP_force_{}")
        numbers |= dict(zip((name.format(part) for name in names), motions, strict=True))
    return numbers


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_the_tool_of_a_robot_is_no_joint(joints):
    found = taken(robot_with_a_tool(joints))
    number = found["motor_position"][-1]
    assert found == {
        "motor_position": f"actual_q_{number}",
        "speed": f"actual_qd_{number}",
        "current": f"actual_current_{number}",
    }


def test_what_belongs_to_the_robot_stands_back_behind_a_joints_own():
    numbers = {"timestamp": TIME, "robot_current": np.cos(9.0 * TIME), **robot_with_a_tool()}
    assert taken(numbers)["current"].startswith("actual_current_")


@pytest.mark.parametrize("flange", ["flange load torque [N m]", "flange load torque 1 [N m]"])
def test_a_torque_flange_behind_a_single_shaft_stays_its_load(flange):
    shaft = {"motor 1 position [rad]": np.sin(TIME), "motor 1 current [A]": np.cos(TIME)}
    numbers = {"time [s]": TIME, **shaft, flange: np.cos(TIME) ** 2}
    assert taken(numbers)["load_torque"] == flange


@pytest.mark.parametrize("name", ["actual_momentum", "Momentum [kg m/s]"])
def test_a_momentum_is_no_torque(name):
    numbers = {"time [s]": TIME, "position [rad]": np.sin(TIME), name: np.cos(TIME)}
    assert "motor_torque" not in taken(numbers)


def dynamometer(ratio=1.0):
    """Two drives on one shaft with a sensor between: a1 drives, a2 brakes, and c1 and c2 tell the motors of both."""
    speed = 20.0 * np.sin(0.9 * TIME) + 5.0 * np.sin(2.3 * TIME)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(TIME))])
    torque = 0.3 * np.cos(0.9 * TIME) + 0.2 * np.sign(speed)
    brake = -0.1 * speed / 20.0
    noise = np.random.default_rng(1).normal(size=(2, len(TIME)))
    columns = {"time [s]": TIME}
    for drive, trq, read in ((1, torque + 1e-3 * noise[0], way), (2, brake, 0.98 * way + 2e-3 * noise[1])):
        columns |= {
            f"a{drive} position [rad]": read / ratio,
            f"a{drive} velocity [rad/s]": np.gradient(read, TIME) / ratio,
            f"a{drive} torque [Nm]": trq * ratio,
            f"a{drive} q-axis [A]": trq / 0.1,
            f"c{drive} position [rev]": read / (2.0 * np.pi),
            f"c{drive} vel [Hz]": np.gradient(read, TIME) / (2.0 * np.pi),
            f"c{drive} torque [Nm]": trq,
        }
    return {**columns, "trs605-5 torque [Nm]": 0.95 * torque * ratio}


@pytest.mark.parametrize("ratio", [1.0, 6.0])
def test_what_tells_the_same_drive_again_is_no_joint_beside_it(ratio):
    """A log has each motor twice: the second was said to hang on the first, and was taken without its current."""
    numbers = dynamometer(ratio)
    joint = guessed(numbers).joint
    assert joint.name == "a1" and joint.same == ("c1",) and joint.moving == ("a2", "c2")
    assert "; c1 tells the same drive again, in other units or at another shaft; a2, c2 move too" in joint.sentence
    assert taken(numbers)["current"] == "a1 q-axis [A]"


def test_the_type_of_a_sensor_is_no_joints_number():
    """The only sensor of the torque between two drives was dropped without a word."""
    assert taken(dynamometer())["load_torque"] == "trs605-5 torque [Nm]"
