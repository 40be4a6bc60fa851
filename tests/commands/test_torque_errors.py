"""The relative torque error in words."""

from ema_twin_sim.commands.shown_comparison import show_comparison
from ema_twin_sim.commands.torque_errors import show_torque_errors
from ema_twin_sim.comparison.compare import Comparison, RecordingComparison
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


def test_an_unfiltered_error_that_is_the_accelerations_noise_is_not_told(capsys):
    assert told(capsys, TorqueError(31.8, 31.8, 50.0), "rotary") == ""


def test_errors_within_the_noise_are_no_good_model_where_much_of_the_torque_remains(capsys):
    within = {"rmse": 0.1, "noise_floor": 0.1, "relative": 0.05, "driven": False, "unit": "N m"}
    signals, many = {"motor_torque": within}, {"motor_torque": 1000.0}
    for error, said in (
        (TorqueError(0.17, 0.3), "up to 17 % of the torque remains"),
        (TorqueError(0.02, 0.3), "; run"),
    ):
        run = RecordingComparison("run", 1000, 1.0, signals, many, error)
        show_comparison([Comparison("servo", "motion", (run,), signals, many, (), ())])
        assert said in capsys.readouterr().out.replace("\n", " ")
