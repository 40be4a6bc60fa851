"""Two positions that go almost in step: of two joints, or of motor and output of one drive."""

import numpy as np
import pytest

TIME = np.arange(4000) * 2e-3
NAMES = (("q1", "q2"), ("position 1 [rad]", "position 2 [rad]"), ("beta", "gamma"))


def arm(names, lead=0.0, share=0.4, grows=0.0, beat=3.0):
    """Two angles: the second goes a ``share`` of the first, ahead by ``lead``; it ``grows`` while it is recorded."""
    second = share * np.sin(beat * TIME + lead) * (1.0 + grows * TIME / TIME[-1])
    return {"time [s]": TIME, **dict(zip(names, (np.sin(beat * TIME), second), strict=True))}


@pytest.mark.parametrize("names", NAMES)
def test_a_ratio_that_changes_while_it_is_recorded_is_of_two_joints(names, drafted):
    draft = drafted(arm(names, grows=1.0))
    assert "  output_position:" not in draft.map and ": not used as the output's position" in draft.said
    assert "two joints" in draft.said and "say so in their names, as in 'motor position'" in draft.said


def test_two_recordings_with_two_ratios_are_of_two_joints(drafted):
    assert "two joints" not in drafted(arm(NAMES[0])).said
    draft = drafted(arm(NAMES[0], share=0.4), arm(NAMES[0], share=-2.0))
    assert "their ratio is -0.5 in one part of the recordings and 2.5 in another" in draft.said


def test_ways_that_part_by_more_than_a_little_are_of_two_joints(drafted):
    draft = drafted(arm(NAMES[0], lead=0.3, beat=4.0 * np.pi))  # whole turns in each part: the ratio holds
    assert "30 % of the one's way is not the other's" in draft.said


@pytest.mark.parametrize("names", [*NAMES, ("motor angle [rad]", "link angle [rad]")])
def test_the_shafts_of_one_drive_stay_motor_and_output_though_they_play(names, drafted):
    """With backlash of some per cent of the way; the drive rests in one part of the recording."""
    columns = arm(names)
    rest = np.where(TIME < 6.0, 1.0, 0.0)
    motor = 5.0 * np.sin(3.0 * TIME) * rest
    output = motor.copy()
    for k in range(1, len(output)):
        output[k] = np.clip(output[k - 1], motor[k] - 0.1, motor[k] + 0.1)
    draft = drafted({**columns, names[0]: motor, names[1]: output / 5.0})
    assert "  output_position:" in draft.map and "two joints" not in draft.said


def test_a_ratio_that_names_vouch_for_is_not_doubted(drafted):
    draft = drafted(arm(("motor angle [rad]", "output angle [rad]"), lead=0.3))
    assert "two joints" not in draft.said


def test_a_recording_at_rest_tells_no_ratio(drafted):
    """Beside a motion whose ratio holds, the noise of a second recording at rest is that of no joint."""
    noise = 1e-4 * np.random.default_rng(2).standard_normal((2, len(TIME)))
    rest = {"time [s]": TIME, **dict(zip(NAMES[1], noise, strict=True))}
    assert "two joints" not in drafted(arm(NAMES[1]), rest).said
