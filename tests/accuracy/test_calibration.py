"""How probabilities and intervals are judged (make accuracy ARGS=--calibration), and the machines of other sizes."""

import numpy as np
import pytest

from tests.accuracy.calibration import (
    Judged,
    Statement,
    brier,
    calibration_cases,
    calibration_error,
    judged,
    reliability,
    summed_up,
    table,
)
from tests.accuracy.cases import drawn_case
from tests.accuracy.folders import readable_train
from tests.accuracy.other_machines import other_machine_cases


def said(probability, true, count=1):
    return [Statement("case", "viscous_friction", probability, true)] * count


def test_what_is_true_as_often_as_said_has_no_calibration_error():
    statements = said(0.8, True, 8) + said(0.8, False, 2)
    assert calibration_error(reliability(statements)) == pytest.approx(0.0)
    assert brier(statements) == pytest.approx(0.16)


def test_what_is_always_true_but_said_with_a_third_is_off_by_the_rest():
    assert calibration_error(reliability(said(0.3, True, 5))) == pytest.approx(0.7)


def test_each_bin_counts_as_often_as_it_was_used():
    statements = said(1.0, True, 30) + said(0.6, False, 10)
    assert calibration_error(reliability(statements)) == pytest.approx(0.15)


def test_the_table_tells_every_bin_and_what_broke():
    found = [
        Judged("first", tuple(said(0.95, True)), {"viscous_friction.coefficient": True}),
        Judged("second", tuple(said(0.95, False)), {"viscous_friction.coefficient": False}, ""),
        Judged("third", (), {}, "InputError: torn"),
    ]
    sums = summed_up(found)
    assert sums["covered"] == 0.5
    assert sums["off"] == [["case", "viscous_friction", 0.95, False]]
    text = table(sums)
    assert "3 cases, 2 statements, 1 cases broken" in text
    assert "90 % intervals that hold the truth: 50.0% of 2" in text
    assert "third: InputError: torn" in text


def test_an_interval_holds_the_truth_or_not():
    case = drawn_case("coulomb", "plain", ["cogging"], (1, 2, 3))
    true = case.parameters["cogging"]["torque"]
    for away, holds in ((1.6, True), (1.7, False)):
        entry = {"effect": "cogging", "torque": {"value": true + away * 1e-4, "std": 1e-4, "unit": "N m"}}
        diagnosis = {"ranking": [{"effect": "cogging", "probability": 0.9}], "groups": [], "none": 0.0, "unknown": 0.1}
        found = judged(case, diagnosis, {"added": ["cogging"], "parameters": {"cogging": entry}})
        assert found.covered == {"cogging.torque": holds}
        assert {s.what: s.true for s in found.statements} == {"cogging": True, "none": False, "unknown": False}


def test_calibration_cases_are_of_all_kinds_and_bar_what_is_left_out():
    cases, without = calibration_cases(1, 40)
    assert len(cases) == len(without) == 40
    excluded = [(case, ids) for case, ids in zip(cases, without, strict=True) if ids]
    assert len(excluded) == 4
    assert all(set(ids) <= set(case.hidden) for case, ids in excluded)
    assert sum(not case.hidden for case in cases) >= 4


def test_a_machine_of_other_size_is_another_machine_told_in_units_of_its_own():
    case = other_machine_cases(3, 1)[0]
    again = other_machine_cases(3, 1)[0]
    recording, same = (each.train[0] for each in (case, again))
    np.testing.assert_array_equal(recording.signals["current"], same.signals["current"])
    told, model = readable_train(case)[0], case.start_model
    factor = case.told_in.factor("s")
    assert factor != pytest.approx(1.0, rel=0.01)
    assert told.duration * factor == pytest.approx(case.seconds, rel=1e-3)
    assert model.value("machine.gear_ratio") == case.nominal.gear_ratio
    # the drive gives torques of the size of the model's friction, in the units that both are told in
    torque = model.value("machine.torque_constant") * np.abs(told.signals["current"]).max()
    friction = sum(held.parameters["torque"] for held in model.active.values() if held.effect == "coulomb_friction")
    assert 0.3 * friction < torque < 30.0 * friction
