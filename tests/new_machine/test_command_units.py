"""Commands without a unit have that of what follows them, and none of them is dropped without a word."""

import numpy as np
import pytest

TIME = np.arange(1500) * 4e-3
ANGLE = np.round(40.0 * np.sin(2.0 * TIME), 2)
SPEED = 80.0 * np.cos(2.0 * TIME)
CURRENT = np.sign(SPEED) - 0.02 * ANGLE
TARGET = np.round(40.0 * np.sin(2.0 * TIME + 0.05), 2)


def logged(units, **more):
    """A drive's columns; ``units`` are behind the names of position and speed."""
    columns = {f"actual-position{units[0]}": ANGLE, f"actual-speed{units[1]}": SPEED, "current [A]": CURRENT}
    return {"time [s]": TIME, **columns, **more}


@pytest.mark.parametrize("units", [(" [deg]", " [deg/s]"), ("", "")])
def test_a_command_has_the_unit_of_the_position_that_follows_it(units, drafted):
    draft = drafted(logged(units, **{"target-position": TARGET}))
    own = draft.line("motor_position").partition("unit: ")[2].partition("}")[0]
    assert f"unit: {own}}}" in draft.line("output_command") and "target-position: not used" not in draft.said


def test_commands_that_are_not_used_are_named(drafted):
    columns = logged((" [deg]", " [deg/s]"), **{"target-position": TARGET, "position-demand": ANGLE})
    assert "other columns are read in their place: position-demand (if" in drafted(columns).said
    strange = drafted(logged((" [deg]", " [deg/s]"), **{"target-position": 7.3 * ANGLE}))
    assert "target-position: not used, since neither its name nor its numbers tell its unit (if it" in strange.said
    assert "output_command" not in strange.map


def test_a_command_of_a_family_of_names_shares_its_unit_though_it_goes_otherwise(drafted):
    limit = 180.0 + np.sign(np.sin(2.0 * TIME))
    draft = drafted(logged((" [deg]", " [deg/s]"), **{"target-speed": limit}))
    assert "unit: deg/s" in draft.line("speed_setpoint")


def test_names_of_joints_are_as_in_the_header(drafted):
    columns = {"time [s]": TIME}
    for k, joint in enumerate(("EccA-1", "EccA-2", "LinA")):
        columns |= {
            f"actual-position-{joint} [deg]": ANGLE * (3 - k) + k * np.cos(9.0 * k * TIME),
            f"position-demand-{joint} [deg]": TARGET * (3 - k),
            f"target-position-{joint} [deg]": ANGLE * (3 - k),
            f"current-{joint} [A]": CURRENT + k * np.cos(7.0 * k * TIME),
        }
    said = drafted(columns).said
    assert "the columns of EccA-1, the joint with the largest motion; those of EccA-2, LinA are not used" in said
    assert "read in their place: target-position-EccA-1 [deg] (if" in said
