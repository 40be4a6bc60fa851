"""Motor and output share an inertia and a friction: the sum is told surely, its division no surer than it is."""

import re

import pytest

from ema_twin_sim.discovery.discover import discover
from tests.by_draft import by_draft
from tests.servo_csv import TORQUE_CONSTANT, write_servo

INERTIA, DRY, BEHIND = 2e-5, 0.02, 0.3  # kg m2 and N m of the servo, and the share of both behind its gear


def found_in(folder, hidden, **how):
    return discover(*by_draft(folder, write_servo(folder, hidden, **how), torque_constant=TORQUE_CONSTANT))


@pytest.mark.slow
def test_beside_play_each_side_is_within_what_is_told_of_it(tmp_path):
    """The contact's softness moves 2 % of the sum over, alike in all recordings: a jackknife told 15 times less."""
    found = found_in(tmp_path, {"backlash": {"width": 0.01}})
    assert found.added == ("backlash",)
    sides = [
        (found.constants["machine"]["inertia"], INERTIA * (1.0 - BEHIND)),
        (found.constants["machine"]["output_inertia"], INERTIA * BEHIND),
        (found.constants["coulomb_friction"]["torque"], DRY * (1.0 - BEHIND)),
        (found.constants["coulomb_friction_2"]["torque"], DRY * BEHIND),
    ]
    for held, true in sides:
        assert abs(held["value"] - true) < 2.0 * held["std"] < 0.3 * true
    (said,) = (warning for warning in found.warnings if "less certain than the sums" in warning)
    inertia, dry = re.findall(r"(?:inertia \(|friction )([\d.]+) ± ([\d.]+)", said)
    assert float(inertia[0]) == pytest.approx(2.0, abs=3.0 * float(inertia[1]))
    assert float(dry[0]) == pytest.approx(20.0, abs=3.0 * float(dry[1]))


@pytest.mark.slow
def test_without_play_it_is_said_that_only_the_sum_is_told(tmp_path):
    found = found_in(tmp_path, None)
    assert any("determine only sums: inertia and dry friction of motor and output" in text for text in found.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("top_speed", [15.0, 60.0])
def test_slow_motion_beside_play_is_not_told_as_another_machine(tmp_path, top_speed):
    """Little of what is left of such a recording goes with an inertia or a friction of its own."""
    found = found_in(tmp_path, {"backlash": {"width": 0.003 if top_speed < 20.0 else 0.006}}, top_speed=top_speed)
    assert not [warning for warning in found.warnings if "than the other recordings do" in warning]
