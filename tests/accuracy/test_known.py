"""Cases that were once missed: seven of all kinds, which take little time (``make accuracy ARGS=--known``: all)."""

import pytest

from tests.accuracy.cases import drawn_case
from tests.accuracy.judge import broken
from tests.accuracy.known import REASONS, kept, known_case, known_cases
from tests.accuracy.work import solve

SAMPLE = {
    "70_47_quadratic_drag": "friction over the speed, beside what wanders",
    "70_37_shaft_compliance": "a gearbox, without play",
    "69_16_asymmetric_friction+torque_constant_error": "a direction, and a constant of the machine",
    "52_01_encoder_delay+constant_load": "an encoder, and a load",
    "73_31_sun_runout+thermal_friction": "the gears' own orders, and time",
    "84_02_gravity_load": "a gearbox that rings beside a load",
    "83_28_output_friction": "a cause of no catalogue",
}
"""What each of them stands for."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLE)
def test_what_was_once_missed_is_named_and_nothing_wrong(name):
    verdict = solve(known_case(name))
    assert kept(verdict), (verdict.line(), REASONS[name])


def test_every_known_case_hides_what_its_name_says():
    for case in known_cases():
        named = "+".join(cause.id for cause in case.causes)
        assert case.name.endswith(f"_{named}") and case.restless and REASONS[case.name]


def test_what_breaks_is_lost():
    assert not kept(broken(drawn_case("one", "plain", ["cogging"], (1, 2, 3)), ValueError("torn"), 1.0))
