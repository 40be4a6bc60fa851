"""Other people's machines, with the numbers that they published (shared/real; the tests skip where it is absent)."""

import numpy as np
import pytest

from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_csv import read_trace
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.model import load_model

PUBLISHED = {"mass": 95.1089, "viscous": 203.5034, "coulomb": 20.3935, "offset": -3.1648}
"""EMPS, least squares: Janot, Gautier, Brunot 2019."""
FRICTION = (("viscous_friction", "coefficient"), ("coulomb_friction", "torque"))


@pytest.fixture(scope="module")
def emps(real):
    """Training record and pulses."""
    return [read_trace(real / f"emps_{name}.csv", load_map("emps")) for name in ("train", "test_pulses")]


@pytest.fixture(scope="module")
def emps_found(emps):
    """What is found in the training record, of a model that is a mass alone."""
    return discover(emps[:1], load_model("emps_mass"))


def force_errors(recordings, model):
    return [r.torque_error.filtered for r in compare(recordings, model).recordings]


def test_emps_gives_the_published_numbers(emps):
    train, pulses = emps
    fitted = fit_model([train], load_model("emps"), method="equation")
    assert fitted.constants["machine"]["inertia"]["value"] == pytest.approx(PUBLISHED["mass"], rel=0.01)
    assert fitted.constants["machine"]["inertia"]["unit"] == "kg"
    viscous, coulomb, load = (
        fitted.parameters[effect][parameter]["value"] for effect, parameter in (*FRICTION, ("constant_load", "torque"))
    )
    assert (viscous, coulomb) == pytest.approx((PUBLISHED["viscous"], PUBLISHED["coulomb"]), rel=0.01)
    assert load == pytest.approx(PUBLISHED["offset"], rel=0.05)
    on_train, on_pulses = force_errors([train, pulses], fitted.model)
    assert on_train <= 0.0409 and on_pulses <= 0.060


@pytest.mark.slow
def test_emps_lacks_friction_that_depends_on_the_direction(emps, emps_found):
    (train, pulses), found = emps, emps_found
    assert found.verdict == "explained"
    assert found.added == ("coulomb_friction", "viscous_friction", "asymmetric_friction", "constant_load")
    on_train, on_pulses = force_errors([train, pulses], found.model)
    symmetric = fit_model([train], load_model("emps"), method="equation").model
    assert on_train <= 0.0315 and on_pulses < force_errors([pulses], symmetric)[0]


@pytest.mark.slow
def test_emps_is_followed_by_its_published_controller(emps, emps_found):
    """The model's own position loop on the recorded command: nothing of the motion is given."""
    (train,) = compare(emps[:1], emps_found.model, "command").recordings
    assert train.signals["motor_position"]["relative"] <= 2e-4
    assert train.signals["motor_torque"]["unit"] == "N"
    assert train.signals["motor_torque"]["relative"] <= 0.065


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "delay"), [("axis1", 3.08e-3), ("axis3", 2.98e-3)])
def test_kukas_encoders_part_by_a_delay_and_by_no_play(real, axis, delay):
    """Two standard errors of the published 2.8 to 3.0 ms; plain least squares of each record give 2.94 to 3.13 ms."""
    records = [read_trace(path, load_map("kuka")) for path in sorted(real.glob(f"kuka_{axis}_*.csv"))]
    found = discover(records, load_model(f"kuka_{axis}"))
    assert "encoder_delay" in found.added
    assert not {"backlash", "shaft_compliance"} & {*found.added}
    told = found.parameters["encoder_delay"]["delay"]
    assert told["value"] == pytest.approx(delay, abs=0.03e-3)
    assert told["value"] - 2.0 * told["std"] < 3.0e-3
    assert found.unseen.encoders and found.unseen.output[-1] <= np.radians(5e-3)
    delayed = next(step for step in found.steps if step.effect in ("encoder_delay", "backlash", "encoder_eccentricity"))
    assert delayed.effect == "encoder_delay"


@pytest.mark.slow
def test_laas_motor_cogs_at_orders_that_nobody_told(real):
    record = read_trace(real / "laas_holding_current.csv", load_map("laas"))
    found = discover([record], load_model("laas_motor"))
    first, second = found.steps[:2]
    assert (first.effect, found.model.effects[first.instance].options["order"]) == ("cogging", "72")
    assert first.rmse_before == pytest.approx(0.145, abs=0.001)
    assert second.effect == "coulomb_friction"
    assert second.rmse_after <= 0.05  # on the half of the angles that was not fitted to
    orders = {i.options["order"] for i in found.model.effects.values() if i.effect == "cogging"}
    assert orders == {"72", "18", "12", "144", "24", "36"}
    assert found.unseen.rmse[-1] <= 0.027


@pytest.mark.slow
def test_laas_motor_in_motion_rubs_and_cogs(real):
    """0.019 A are left with Coulomb friction, as published; the cogging that rest shows, motion shows too."""
    record = read_trace(real / "laas_sine_current.csv", load_map("laas_sine"))
    model = load_model("laas_motor")
    found = discover([record], model)
    assert found.added == ("coulomb_friction", "cogging")
    assert found.model.effects["cogging"].options["order"] == "72"
    assert found.unseen.rmse[1] / model.value("machine.torque_constant") <= 0.019


def test_a_second_encoder_does_not_drown_what_the_torque_tells(real):
    """KUKA's model is rigid: its encoders' difference is no number's, and the torque gives all of them."""
    record = read_trace(real / "kuka_axis1_A.csv", load_map("kuka"))
    fitted = fit_model([record], load_model("kuka_axis1"))
    for name, parameter in FRICTION:
        told = fitted.parameters[name][parameter]
        assert told["std"] < 0.3 * told["value"]
    assert fitted.torque_errors["kuka_axis1_A"].filtered < 0.2


def test_a_start_far_off_is_no_obstacle(emps):
    """A hundredth of the mass, a twentieth of the friction: open values may begin anywhere."""
    model = load_model("emps").with_value("machine.motor_inertia", 1.0)
    model = model.with_value("effects.viscous_friction.coefficient", 10.0)
    fitted = fit_model(emps[:1], model, method="equation")
    assert fitted.constants["machine"]["inertia"]["value"] == pytest.approx(PUBLISHED["mass"], rel=0.01)
