"""Traces of several joints that words or letters distinguish: init takes one joint whole, and mixes none."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.columns import guess_columns

TIME = np.arange(3000) * 2e-3
NAMES = {"position": "motor_position", "speed": "speed", "torque": "motor_torque"}


def joint(size, beat, lead=0.0):
    """Position, speed and torque of a joint that swings: its speed is the slope of its position."""
    angle = beat * TIME + lead
    return {"position": size * np.sin(angle), "speed": size * beat * np.cos(angle), "torque": np.cos(angle + 0.1)}


def trace(pattern, joints):
    """Columns of several joints, named by a ``pattern`` of the joint and the quantity."""
    columns = {"time [s]": TIME}
    for name, motion in joints.items():
        columns |= {pattern.format(joint=name, quantity=quantity): values for quantity, values in motion.items()}
    return columns


def taken(columns, **more):
    guesses = guess_columns(list(columns), numbers=columns, **more)
    return guesses, {guess.signal: guess.column for guess in guesses.signals}


def apart(names, far):
    """Joints that swing each to its own beat; ``far`` goes farthest."""
    return {name: joint(2.0 if name == far else 0.3, 1.1 + 0.4 * place) for place, name in enumerate(names)}


@pytest.mark.parametrize(
    "names",
    [
        ("FL_hip", "FL_calf", "RR_hip"),
        ("left", "right"),
        ("L", "R"),
        ("X", "Y", "S"),
        ("leg1_hip", "leg1_knee", "leg2_hip"),
    ],
)
@pytest.mark.parametrize("pattern", ["{joint}_{quantity}", "{quantity}/{joint}_joint", "{joint}_Actual{quantity}"])
def test_one_named_joint_is_taken_whole(names, pattern):
    for far in names:
        columns = trace(pattern, apart(names, far))
        guesses, found = taken(columns)
        assert found == {signal: pattern.format(joint=far, quantity=said) for said, signal in NAMES.items()}
        assert guesses.joint.name == far.replace("leg", "leg ").replace("_", " ")
        assert len(guesses.joint.others) == len(names) - 1
        assert all(
            column in guesses.left for column in columns if column != "time [s]" and column not in found.values()
        )


@pytest.mark.parametrize("symbols", [("q", "dq", "tau"), ("phi", "w", "i"), ("q", "qd", "M")])
def test_symbols_beside_a_joints_name_are_read(symbols):
    columns = {"time [s]": TIME}
    for name, motion in apart(("knee", "ankle"), "ankle").items():
        columns |= {f"{symbol}_{name}": values for symbol, values in zip(symbols, motion.values(), strict=True)}
    guesses, found = taken(columns)
    assert guesses.joint.name == "ankle" and {*found.values()} == {f"{symbol}_ankle" for symbol in symbols}


def test_joints_almost_in_step_are_no_motor_and_output():
    """As the hips of a trotting robot, or hip and knee of one that squats."""
    for other in (joint(0.56, 1.3, 0.03), joint(0.65, 1.3, 0.03), joint(0.56, 1.3)):
        columns = trace("{joint}_{quantity}", {"left": joint(0.55, 1.3), "right": other})
        guesses, found = taken(columns)
        assert guesses.joint.others and "output_position" not in found and "load_torque" not in found
        assert len({column.split("_")[0] for column in found.values()}) == 1


@pytest.mark.parametrize(
    "sides", [("motor", "output"), ("motor", "load"), ("drive", "joint"), ("input", "output"), ("encoder1", "encoder2")]
)
def test_sides_of_one_joint_are_no_joints(sides):
    motor = joint(9.0, 1.3)
    output = {quantity: values / (9.0 if quantity != "torque" else 1 / 9.0) for quantity, values in motor.items()}
    guesses, found = taken(trace("{joint} {quantity}", dict(zip(sides, (motor, output), strict=True))))
    assert guesses.joint.name == ""
    assert found["motor_position"] == f"{sides[0]} position" and found["output_position"] == f"{sides[1]} position"


def test_shafts_of_a_gear_are_one_train_whatever_their_names():
    motor = joint(9.0, 1.3)
    columns = trace("{joint} {quantity}", {"pinion": motor, "rack": {name: 0.1 * way for name, way in motor.items()}})
    guesses, found = taken(columns)
    assert guesses.joint.name == ""
    assert (found["motor_position"], found["output_position"]) == ("pinion position", "rack position")


@pytest.mark.parametrize("pattern", ["{joint}_{quantity}", "{joint}.{quantity}"])
def test_what_was_asked_for_is_no_joint(pattern):
    measured, wanted = joint(1.0, 1.3), joint(1.1, 1.3, 0.2)
    for names in (("actual", "desired"), ("meas", "ref"), ("feedback", "command"), ("raw", "filtered")):
        guesses, _ = taken(trace(pattern, dict(zip(names, (measured, wanted), strict=True))))
        assert guesses.joint.name == ""


def test_what_belongs_to_all_joints_stays_and_what_is_elsewhere_goes():
    columns = trace("{joint}_{quantity}", apart(("FL_hip", "FL_knee"), "FL_knee"))
    columns |= {"winding temperature [degC]": 20.0 + TIME, "FL_foot_force": np.sin(3.0 * TIME)}
    columns |= {"base_position": 5.0 * np.sin(0.2 * TIME)}
    guesses, found = taken(columns)
    assert found["temperature"] == "winding temperature [degC]"
    assert {"FL_foot_force", "base_position"} <= {*guesses.left} and "load_torque" not in found


def test_one_joint_beside_a_part_that_only_moves_is_no_choice():
    columns = trace("{joint}_{quantity}", {"hip": joint(1.0, 1.3)})
    guesses, _ = taken(columns | {"base_position": 5.0 * np.sin(0.2 * TIME)})
    assert guesses.joint.name == ""


def test_the_same_joint_is_taken_from_another_trace():
    columns = trace("{joint}_{quantity}", apart(("FL_hip", "FL_calf"), "FL_calf"))
    assert taken(columns, joint="FL hip")[1]["motor_position"] == "FL_hip_position"


def test_init_says_which_joint_it_took_and_marks_it(drafted):
    columns = trace("{joint}_{quantity}", apart(("left", "right"), "right"))
    draft = drafted(columns)
    said = "the columns of right, the joint with the largest motion; those of left are not used (to use another joint,"
    assert f"Assumed: {said}" in draft.said and "no line to check" not in draft.said.split("m.yaml")[0]
    assert f"# CHECK: {said}" in draft.map


@pytest.mark.parametrize("lead", [0.0, 0.15])
def test_a_position_that_only_goes_almost_with_the_speed_is_to_be_checked(lead, drafted):
    """As that of another joint in step; of one joint, the slope of the position is the speed."""
    columns = {"time [s]": TIME, "speed [rad/s]": joint(0.5, 4.0)["speed"], "torque [Nm]": joint(0.5, 4.0)["torque"]}
    columns["position [rad]"] = joint(0.5, 4.0, lead)["position"]
    draft = drafted(columns)
    said = "15 % of its way is not the speed's"
    assert (f"position [rad]: of the same shaft as speed [rad/s], though {said}" in draft.said) is (lead > 0.0)
    assert (f"CHECK: {said}: are both of the same shaft?" in draft.map) is (lead > 0.0)


def test_a_bracket_within_a_name_is_no_unit(drafted):
    columns = trace("knee[ActPack]:motor_{quantity}", {"": joint(3.0, 1.3)})
    draft = drafted(columns)
    assert "is not a" not in draft.told + draft.map


def test_a_bracket_may_name_a_joint():
    columns = trace("actuator[{joint}].{quantity}", apart(("hip", "knee"), "knee"))
    guesses, found = taken(columns)
    assert guesses.joint.name == "actuator knee" and found["speed"] == "actuator[knee].speed"
