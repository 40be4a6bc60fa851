"""Fit: warnings that are deserved, and only those."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import MOTION, POINTS, Recording
from ema_twin_sim.effects import catalogue
from ema_twin_sim.fitting.fit import METHODS, fit_model
from ema_twin_sim.fitting.plausibility import circumstances, implausible
from ema_twin_sim.model import load_model
from tests.fitted_bench import FAST, SLOW, bench, warned, with_effects


def test_on_bound(stock):
    """Friction that bends down with speed is no drag: the coefficient would be negative."""
    start = stock.with_effect("quadratic_drag")
    result = fit_model(bench(stock.with_effect("shear_thinning"), FAST), start, method="equation")
    assert ("quadratic_drag", "coefficient") in warned(result, "on_bound")
    assert result.model.effects["quadratic_drag"].parameters["coefficient"] == pytest.approx(0.0, abs=1e-9)


def test_no_effect_where_the_signal_is_missing(stock):
    recordings = [
        replace(r, signals={n: v for n, v in r.signals.items() if n != "output_position"}) for r in bench(stock, SLOW)
    ]
    result = fit_model(recordings, stock.with_effect("encoder_delay"), method="equation")
    assert warned(result, "no_effect") == {("encoder_delay", "delay")}
    message = next(w.message for w in result.warnings if w.kind == "no_effect")
    assert "with the output encoder recorded" in message


@pytest.mark.slow
def test_no_effect_of_what_is_not_there(stock):
    result = fit_model(bench(stock, SLOW), stock.with_effect("sun_runout"))
    assert ("sun_runout", "torque") in warned(result, "no_effect")


def test_no_effect_of_what_a_method_does_not_contain(stock):
    free = ["effects.coulomb_friction.static_ratio", "drive.current_lag"]
    result = fit_model(bench(stock, SLOW[1:]), stock, method="equation", free=free)
    assert warned(result, "no_effect") == {("coulomb_friction", "static_ratio"), ("drive", "current_lag")}
    assert result.constants["drive"]["current_lag"]["value"] == pytest.approx(5e-4)


@pytest.mark.parametrize("method", METHODS)
def test_inseparable_in_one_direction(stock, method):
    true = stock.with_effect("constant_load")
    start = true.with_effect("asymmetric_friction", {"fraction": 0.05})
    result = fit_model(bench(true, ("ramp:0.03", "ramp:0.1")), start, method=method)
    assert {("constant_load", "torque"), ("asymmetric_friction", "fraction")} <= warned(result, "inseparable")
    message = next(w.message for w in result.warnings if w.kind == "inseparable")
    assert "constant_load.torque" in message and "asymmetric_friction.fraction" in message


def test_inseparable_twins(stock):
    start = stock.with_effect("coulomb_friction", {"torque": 0.02})
    result = fit_model(bench(stock, SLOW), start, method="equation")
    assert warned(result, "inseparable") == {("coulomb_friction", "torque"), ("coulomb_friction_3", "torque")}
    one, other = (result.paths.index(f"effects.{name}.torque") for name in ("coulomb_friction", "coulomb_friction_3"))
    assert result.correlations[one][other] < -0.95


def test_absurd_where_an_encoder_that_is_late_is_taken_for_a_shaft_that_gives_way(stock):
    true = stock.with_effect("encoder_delay", {"delay": 0.004})
    recordings = bench(true, ("sine:0.05:1", "triangle:0.1:1"))
    result = fit_model(recordings, stock.with_effect("shaft_compliance"), method="equation")
    assert ("shaft_compliance", "damping") in warned(result, "absurd")


def test_absurd_constants(stock):
    true = stock.with_value("machine.output_inertia", 2e-3)
    result = fit_model(bench(true, ("sine:0.02:1", "triangle:0.1:1")), stock, method="equation")
    assert ("machine", "motor_inertia") in warned(result, "absurd")
    total = sum(held["value"] for held in result.constants["machine"].values())
    assert total == pytest.approx(2e-3 + 7.7e-4 + 1.75e-6, rel=0.03)


def test_inertias_scaled_together_may_be_off_by_what_the_least_known_is(stock):
    """A motor's inertia is on its data sheet, what hangs on the output is guessed: only the sum of both shows."""
    true = stock.with_value("machine.output_inertia", 1.5 * stock.value("machine.output_inertia"))
    known = {"machine.motor_inertia": 0.01, "machine.output_inertia": 0.5}
    constants = {path: replace(stock.constants[path], tolerance=by) for path, by in known.items()}
    start = replace(stock, constants={**stock.constants, **constants})
    result = fit_model(bench(true, ("sine:0.02:1", "triangle:0.1:1")), start, method="equation")
    found, nominal = (sum(held[key] for held in result.constants["machine"].values()) for key in ("value", "nominal"))
    assert 1.1 < found / nominal < 1.5
    assert not warned(result, "absurd")


@pytest.mark.slow
def test_absurd_where_the_recordings_are_too_short(stock):
    true = stock.with_effect("thermal_friction", {"fraction": 0.9, "time_constant": 100.0})
    result = fit_model(bench(true, ("ramp:0.2", "triangle:0.1:1")), stock.with_effect("thermal_friction"))
    assert ("thermal_friction", "time_constant") in warned(result, "absurd")


def test_typical_values_are_not_absurd_and_rules_name_what_exists(stock):
    recordings = bench(stock, FAST[1:], 5.0)
    for id, effect in catalogue().items():
        model = stock.with_effect(id)
        assert implausible(id, effect.default_parameters(), circumstances(recordings, model)) == [], id
        assert {rule.parameter for rule in effect.implausible} <= {*effect.default_parameters()}


@pytest.mark.slow
@pytest.mark.parametrize("method", ["equation", "simulation"])
def test_a_fit_that_leaves_much_says_so(method, stock):
    """Whatever its rows are weighed by, what is left is held against the sensors' noise."""
    true = with_effects(stock, {"gravity_load": {"torque": 0.05, "angle": 0.3}, "cogging": {"torque": 0.05}})
    fitted = fit_model(bench(true, SLOW), stock, method=method)
    assert any(
        "times the sensors' noise: compare tells what it depends on, diagnose whether" in note for note in fitted.notes
    )
    play = with_effects(stock, {"backlash": {"width": 0.004}})
    fitted = fit_model(bench(with_effects(play, {"cogging": {"torque": 0.05}}), SLOW), play, method=method)
    assert any(
        "impact timing off by 1 ms" in note and "diagnose whether an effect is missing" in note for note in fitted.notes
    )
    right = fit_model(bench(stock, SLOW), stock, method=method)
    assert not any("times the sensors' noise" in note or "the model as it was" in note for note in right.notes)


def test_what_rest_does_not_give_is_no_number_of_the_fit():
    """At points of rest nothing tells an inertia or viscous friction: they stay, and are said not to be shown."""
    rng = np.random.default_rng(1)
    angle = np.r_[np.linspace(0.0, 6.0, 400), np.linspace(6.0, 0.0, 400)]
    current = 0.05 * np.repeat([1.0, -1.0], 400) + 0.005 * rng.standard_normal(800)
    signals = {"motor_position": angle, "current": current}
    held = Recording("held", np.arange(800) * 10**9, signals, metadata={POINTS: "yes"})
    motor = load_model("laas_motor")
    result = fit_model([held], motor.with_effect("coulomb_friction", {"torque": 1e-3}))
    inertia = result.constants["machine"]["inertia"]
    assert inertia["std"] is None and inertia["value"] == inertia["nominal"]
    assert result.model.constants["machine.motor_inertia"] == motor.constants["machine.motor_inertia"]
    assert warned(result, "no_effect") == {("machine", "inertia"), ("viscous_friction", "")}
    assert result.parameters["coulomb_friction"]["torque"]["std"] > 0.0


def test_numbers_of_a_linear_machine_are_told_in_its_units():
    rng = np.random.default_rng(2)
    speed = np.concatenate([s * np.geomspace(2e-3, 0.2, 40) for s in (1.0, -1.0)])
    force = 203.0 * speed + 20.0 * np.sign(speed) + 0.5 * rng.standard_normal(80)
    signals = {"speed": speed, "motor_torque": force}
    curve = Recording("rail", np.arange(80) * 10**9, signals, metadata={POINTS: "yes", MOTION: "linear"})
    result = fit_model([curve], load_model("emps"))
    message = next(w.message for w in result.warnings if w.instance == "constant_load")
    said, held = message.split()[2], result.parameters["constant_load"]["torque"]
    assert float(said) == pytest.approx(held["value"], rel=1e-3) and held["unit"] == "N" and " N ±" in message
