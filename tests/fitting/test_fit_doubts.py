"""Doubts about a fit: notes on errors that grew."""

import pytest

from ema_twin_sim.fitting.doubts import no_nearer, tells


def errors(current, speed, *, driven=False):
    return {
        "current": {"rmse": current, "noise_floor": 1e-3, "unit": "A", "driven": driven, "relative": None},
        "speed": {"rmse": speed, "noise_floor": 1e-3, "unit": "rad/s", "driven": False, "relative": None},
    }


FARTHER = errors(0.016, 0.5), errors(0.018, 0.4), errors(1.0, 1.0), errors(0.5, 0.5)
"""Before and after: of the recordings that were fitted to, whose current grows, and of others."""


def test_a_fit_that_is_farther_from_its_own_recordings_says_by_how_much_and_what_to_do():
    (note,) = no_nearer(*FARTHER, by_equation=False, hit=False)
    assert "the error of the current grows from 16.0 mA to 18.0 mA; an effect may be missing" in note
    (note,) = no_nearer(*FARTHER, by_equation=False, hit=True)
    assert "grows from 16.0 mA to 18.0 mA; teeth that meet" in note and "missing" not in note
    assert "Keep the model as it was" in note and "speed" not in note


def test_a_fit_that_is_nearer_in_what_compare_judges_by_is_not_advised_against():
    own = errors(0.0052, 0.13), errors(0.0041, 0.16)
    (note,) = no_nearer(*own, *own, by_equation=False, hit=False)
    assert note.startswith("the error of the current falls from 5.20 mA to 4.10 mA, but that of the speed grows from ")
    assert "discover tells, if it has not looked yet" in note and "Keep" not in note


def test_the_equation_leaves_out_standstill_which_the_errors_count():
    (note,) = no_nearer(*FARTHER, by_equation=True, hit=False)
    assert "standstill" in note


def test_a_fit_that_holds_on_its_own_recordings_only_says_so():
    own = errors(0.016, 0.5), errors(0.010, 0.4)
    (note,) = no_nearer(*own, errors(0.016, 0.5), errors(0.020, 0.6), by_equation=False, hit=False)
    assert note.startswith("on what was not fitted to") and "current" in note and "that of the speed" in note


def test_what_counts_there_is_by_how_much_the_errors_grew_and_shrank():
    own = errors(0.016, 0.5), errors(0.010, 0.4)
    assert no_nearer(*own, errors(0.016, 0.5), errors(0.020, 0.2), by_equation=False, hit=False) == []
    (note,) = no_nearer(*own, errors(0.016, 0.5), errors(0.024, 0.45), by_equation=False, hit=False)
    assert note.endswith("the error of the current grows from 16.0 mA to 24.0 mA")


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (errors(0.016, 0.5), errors(0.016, 0.505)),  # as much as two right models differ
        (errors(0.0010, 0.0010), errors(0.0014, 0.0014)),  # noise
        (errors(0.016, 0.5, driven=True), errors(0.018, 0.9, driven=True)),  # an input, and what drifts with it
    ],
)
def test_what_is_no_worse_needs_no_note(before, after):
    assert no_nearer(before, after, before, after, by_equation=False, hit=False) == []


def test_driven_by_the_current_a_model_is_judged_by_torque_and_encoder_difference():
    """Its speed drifts; the encoder difference does not, since the motor moves there as measured."""
    given = errors(0.0, 0.5, driven=True)
    counted = ("unexplained_torque", "encoder_difference")
    judged = {**given, **{name: {**given["speed"], "rmse": 1e-3} for name in counted}}
    assert [name for name in judged if tells(name, judged[name], judged)] == [*counted]
