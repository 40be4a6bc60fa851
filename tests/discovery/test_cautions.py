"""Warnings that accompany a finding."""

from ema_twin_sim.discovery.cautions import of_wrong_constants

OFF = {"inertia": -0.29, "coulomb friction": 0.4}


def test_a_wrong_constant_is_told_before_something_that_is_missing():
    (said,) = of_wrong_constants(OFF, 0.999, "drill")
    assert "explain 99.9 % of the error" in said and "inertia -29 % and coulomb friction +40 %. If the file" in said


def test_constants_that_leave_much_are_not_all_that_is_wrong():
    assert not of_wrong_constants(OFF, 0.9, "drill")
    assert not of_wrong_constants(OFF, None, "drill")
    assert not of_wrong_constants({}, 0.999, "drill")
