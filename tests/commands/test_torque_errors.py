"""The relative torque error in words."""

from ema_twin_sim.commands.torque_errors import show_torque_errors
from ema_twin_sim.comparison.torque_error import TorqueError


def told(capsys, error, motion):
    show_torque_errors({"run": error}, motion)
    return " ".join(capsys.readouterr().out.split())


def test_both_bands_are_told_if_there_are_two(capsys):
    said = told(capsys, TorqueError(0.0352, 0.0383, 50.0), "linear")
    assert said == "Relative force error of run, standstill included: 3.52 % below 50 Hz, 3.83 % unfiltered"


def test_a_large_error_has_three_digits(capsys):
    assert "7340 % below 50 Hz, 102 % unfiltered" in told(capsys, TorqueError(73.377, 1.0249, 50.0), "rotary")


def test_a_band_that_the_samples_do_not_reach_is_not_told(capsys):
    said = told(capsys, TorqueError(0.753, 0.753, 50.0), "rotary")
    assert said.startswith("Relative torque error of run, standstill included: sampled too slowly")
    assert said.endswith("75.30 % unfiltered") and said.count("%") == 1
