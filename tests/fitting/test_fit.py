"""Fit: numbers that are known are found again, with standard errors that are true."""

import math
from functools import cache

import numpy as np
import pytest

from ema_bench_replay.load import load
from ema_twin_sim.effects import catalogue
from ema_twin_sim.fitting.equation_misfit import EquationMisfit
from ema_twin_sim.fitting.fit import METHODS, fit_model
from ema_twin_sim.fitting.free_parameters import choose_numbers
from ema_twin_sim.fitting.simulation_misfit import SimulationMisfit
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.hypothesis import INERTIAS
from ema_twin_sim.measured.observe import observe_all
from ema_twin_sim.model import load_model
from tests.fitted_bench import FAST, SLOW, bench, check_recovered, estimates, true_value, with_effects
from tests.recorded import changed, with_signals

RIGID = {
    "stribeck_friction": {"torque": 0.08, "speed": 2.0},
    "sun_runout": {"torque": 0.03, "phase": 1.2},
    "constant_load": {"torque": 0.02},
}
SENSORS = {
    "encoder_delay": {"delay": 0.004},
    "encoder_eccentricity": {"amplitude": 0.001, "phase": 0.5},
    "thermal_friction": {"fraction": 0.3, "time_constant": 3.0},
}
LOADS = {
    "asymmetric_friction": {"fraction": -0.2},
    "quadratic_drag": {"coefficient": 3e-4},
    "spring_load": {"stiffness": 0.1},
    "tooth_fault": {"torque": 0.05, "position": 2.0},
}
HIDDEN = {"rigid": (RIGID, SLOW), "sensors": (SENSORS, FAST), "loads": (LOADS, FAST)}


@pytest.fixture(scope="module")
def fitted(stock):
    """What a method finds of effects that are hidden together, as ``found_again`` tells it."""
    return cache(lambda hidden, method: found_again(stock, *HIDDEN[hidden], method=method))


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("hidden", HIDDEN)
def test_several_effects_at_once_from_typical_values(fitted, hidden, method):
    result, true = fitted(hidden, method)
    check_recovered(result, true)
    assert not result.warnings


def found_again(stock, hidden, commands=SLOW, **how):
    """What a fit finds of effects that are hidden, from typical values, and the true model."""
    true = with_effects(stock, hidden)
    return fit_model(bench(true, commands), with_effects(stock, hidden, typical=True), **how), true


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_play_and_what_ripples_behind_it(stock, method):
    hidden = {"backlash": {"width": 0.004}, "cogging": {"torque": 0.02, "phase": -2.0}}
    check_recovered(*found_again(stock, hidden, method=method))


def test_a_spring_from_a_start_that_is_far_off(stock):
    true = with_effects(stock, {"shaft_compliance": {"stiffness": 25.0, "damping": 0.02}})
    commands = ("ramp:0.03", "sine:0.05:0.5", "triangle:0.04:1")
    result = fit_model(bench(true, commands, 8.0), with_effects(stock, {"shaft_compliance": {"stiffness": 100.0}}))
    check_recovered(result, true, share=0.1)


def test_a_bristle(stock):
    hidden = {"presliding_friction": {"stiffness": 3.0, "damping": 0.02}}
    check_recovered(*found_again(stock, hidden), share=0.1)


@pytest.mark.slow
def test_both_methods_agree(fitted):
    first, second = (fitted("rigid", method)[0] for method in METHODS)
    for (path, a, a_std), (_, b, b_std) in zip(estimates(first), estimates(second), strict=True):
        assert abs(a - b) < 3.0 * math.hypot(a_std, b_std), path


@pytest.mark.slow
def test_the_recordings_of_the_project(traces):
    """Of another program's bench, with backlash of 4 mrad and Stribeck friction of 0.08 N m at 2 rad/s."""
    start = load_model("polito_bench").with_effect("backlash").with_effect("stribeck_friction")
    result = fit_model([load(path).between(0.0, 6.0) for path in traces], start)
    assert result.parameters["backlash"]["width"]["value"] == pytest.approx(0.004, rel=0.01)
    assert result.parameters["stribeck_friction"]["torque"]["value"] == pytest.approx(0.08, rel=0.05)
    assert result.parameters["stribeck_friction"]["speed"]["value"] == pytest.approx(2.0, rel=0.15)
    for signal in ("current", "output_position"):
        assert result.after[signal]["rmse"] < 0.3 * result.before[signal]["rmse"]


@pytest.mark.parametrize("method", METHODS)
def test_a_recording_that_stands_still_does_no_harm(stock, method):
    true = stock.with_effect("constant_load", {"torque": 0.02})
    recordings = [*bench(true, SLOW[1:]), *bench(true, ("ramp:0",), 2.0)]
    result = fit_model(recordings, stock.with_effect("constant_load"), method=method)
    assert result.parameters["constant_load"]["torque"]["value"] == pytest.approx(0.02, rel=0.05)


def test_samples_without_a_value_and_spikes_do_no_harm(stock):
    true = stock.with_effect("constant_load", {"torque": 0.02})
    recordings = []
    for recording in bench(true, SLOW[1:]):
        current, output = (recording.signals[name].copy() for name in ("current", "output_position"))
        current[500:510] = np.nan
        output[1000] += 1.0
        recordings.append(changed(recording, current=current, output_position=output))
    for method in METHODS:
        result = fit_model(recordings, stock.with_effect("constant_load"), method=method)
        assert result.parameters["constant_load"]["torque"]["value"] == pytest.approx(0.02, rel=0.05)


def test_under_the_current_the_equation_is_the_method(stock):
    hidden = {"gravity_load": {"torque": 0.05, "angle": 0.7}}
    true = with_effects(stock, hidden)
    measured = ("current", "motor_position", "output_position")
    runs = bench(true, ("triangle:0.3:2", "ramp:0.2"))
    recordings = [with_signals(r, {name: r.signals[name] for name in measured}) for r in runs]
    result = fit_model(recordings, with_effects(stock, hidden, typical=True))
    assert (result.method, result.input) == ("equation", "current")
    check_recovered(result, true, share=0.1)
    assert result.after["unexplained_torque"]["rmse"] < 0.5 * result.before["unexplained_torque"]["rmse"]


@pytest.mark.slow
def test_a_simulation_under_the_current(stock):
    hidden = {"sun_runout": {"torque": 0.03, "phase": 1.0}}
    result, _ = found_again(stock, hidden, method="simulation", source="current")
    assert result.parameters["sun_runout"]["torque"]["value"] == pytest.approx(0.03, rel=0.03)
    assert result.before["current"]["driven"]


def test_constants_by_name(stock):
    true = stock.with_value("sensors.speed_smoothing", 4.3e-3).with_value("machine.torque_constant", 1.87)
    result = fit_model(bench(true, SLOW), stock, free=["sensors.speed_smoothing", "machine.torque_constant"])
    check_recovered(result, true)
    assert result.constants["sensors"]["speed_smoothing"]["value"] == pytest.approx(4.3e-3, rel=0.01)
    assert result.constants["machine"]["torque_constant"]["nominal"] == 1.91


@pytest.mark.slow
def test_every_parameter_of_the_catalogue_moves_both_methods(stock):
    """One that is silently not applied would look like a perfect fit of nothing."""
    # a load that varies, fast and slow, over a large part of a turn
    loaded = stock.with_effect("spring_load", {"stiffness": 0.1})
    recordings = bench(loaded, ("sine:1:0.3", "triangle:0.1:1", "triangle:0.02:1"), 4.0)
    observations = observe_all(recordings, loaded)
    laws = [
        (id, {effect.law: law}) for id, effect in catalogue().items() for law in {p.choice for p in effect.parameters}
    ]
    for id, options in laws:
        model = loaded.with_effect(id, options={law: choice for law, choice in options.items() if choice})
        *others, added = (f"effects.{name}" for name in model.effects)
        freedom = choose_numbers(model, [added], [*others, *INERTIAS])
        misfits = (
            EquationMisfit(EquationErrorProblem(observations), freedom),
            SimulationMisfit(recordings, observations, freedom, ["setpoint"] * len(recordings)),
        )
        for misfit in misfits:
            start = misfit.freedom.start
            slopes = misfit.slopes(start, misfit.weights(misfit.residual(start)))
            for parameter in catalogue()[id].parameters_with(model.effects[added.removeprefix("effects.")].options):
                if parameter.at_rest:
                    continue
                place = misfit.freedom.index(f"{added}.{parameter.name}")
                number = misfit.freedom.numbers[place]
                shown = np.linalg.norm(slopes[:, place]) * number.slope(start[place])
                assert shown * (1.0 if number.log else number.scale) > 2.0, (id, parameter.name, type(misfit))


def test_a_start_on_a_bound_is_moved_off_it_and_said(stock):
    true = stock.with_effect("stribeck_friction")
    start = stock.with_effect("stribeck_friction", {"torque": 0.0})
    result = fit_model(bench(true, SLOW), start, method="equation")
    assert any("stribeck_friction.torque stood on its bound" in note for note in result.notes)
    check_recovered(result, true, share=0.15)


def test_a_wave_that_starts_upside_down(stock):
    true = stock.with_effect("cogging", {"torque": 0.02, "phase": 2.0})
    start = stock.with_effect("cogging", {"torque": 0.02, "phase": 2.0 - math.pi})
    check_recovered(fit_model(bench(true, SLOW), start, method="equation"), true)


def test_what_is_fixed_stays_and_has_no_standard_error(stock):
    start = stock.with_effect("stribeck_friction", {"torque": 0.03})
    recordings = bench(stock.with_effect("stribeck_friction"), SLOW[1:])
    fix = ["effects.stribeck_friction.torque", "machine.output_inertia"]
    result = fit_model(recordings, start, method="equation", fix=fix)
    assert result.parameters["stribeck_friction"]["torque"] == {"value": 0.03, "std": None, "unit": "N m"}
    assert result.parameters["stribeck_friction"]["speed"]["std"] > 0.0
    assert "output_inertia" not in result.constants["machine"]
    whole = fit_model(recordings, start, method="equation", fix=["effects.stribeck_friction"])
    assert whole.parameters["stribeck_friction"]["speed"]["std"] is None


def test_effects_that_are_switched_off_stay_out(stock):
    start = stock.with_effect("stribeck_friction").with_enabled("stribeck_friction", False)
    result = fit_model(bench(stock, SLOW[1:]), start, method="equation")
    assert "stribeck_friction" not in result.parameters
    assert not result.model.effects["stribeck_friction"].enabled


def test_friction_of_both_sides_is_scaled_together_where_only_its_sum_shows(stock):
    true = stock.with_value("effects.coulomb_friction.torque", 0.08)
    result = fit_model(bench(true, SLOW), stock, method="equation")
    motor, output = (result.parameters[f"coulomb_friction{n}"]["torque"]["value"] for n in ("", "_2"))
    assert motor + output == pytest.approx(0.08 + 0.045, rel=0.02)
    assert motor / output == pytest.approx(0.0676 / 0.045)
    assert any("only the sum shows" in note for note in result.notes)


def test_what_no_recording_shows_stays_within_its_tolerance(stock):
    steady = [r.between(2.0, None) for r in bench(stock, ("speed-step:0.05:100", "speed-step:0.1:100"))]
    held = fit_model(steady, stock, method="equation").constants["machine"]["output_inertia"]
    assert held["value"] == pytest.approx(held["nominal"], rel=0.1)
    assert held["std"] == pytest.approx(0.05 * held["nominal"], rel=0.3)


def test_a_nominal_value_that_the_recordings_contradict_is_let_go(stock):
    true = stock.with_value("effects.viscous_friction.coefficient", 0.04)
    result = fit_model(bench(true, SLOW), stock, method="equation")
    assert result.parameters["viscous_friction"]["coefficient"]["value"] == pytest.approx(0.04, rel=0.01)


@pytest.mark.slow
def test_standard_errors_are_the_scatter_over_the_noise(stock):
    true = with_effects(stock, SENSORS)
    start = with_effects(stock, SENSORS, typical=True)
    commands = (*FAST, "ramp:0.1", "sine:0.2:0.5", "triangle:0.2:1")
    found = [list(estimates(fit_model(bench(true, commands, 5.0, s), start, method="equation"))) for s in range(8)]
    values = np.array([[value for _, value, _ in one] for one in found])
    reported = np.median([[std for _, _, std in one] for one in found], axis=0)
    ratios = values.std(axis=0, ddof=1) / reported
    assert 0.5 < np.median(ratios) < 1.5, ratios
    assert (ratios > 0.2).all() and (ratios < 2.0).all(), ratios
    right = np.array([true_value(true, path) for path, _, _ in found[0]])
    assert np.abs((values - right) / reported).max() < 4.0


def test_what_was_not_fitted_to_judges(stock):
    hidden = {"sun_runout": {"torque": 0.03, "phase": 1.0}}
    recordings = bench(with_effects(stock, hidden), SLOW)
    start = with_effects(stock, hidden, typical=True)
    several, one = (fit_model(given, start, method="equation") for given in (recordings, recordings[2:]))
    assert several.judged_on == "each recording with numbers fitted to the others"
    assert one.judged_on == "the last third with numbers fitted to the rest"
    for result in (several, one):
        assert result.after["current"]["rmse"] < 0.5 * result.before["current"]["rmse"]
        assert result.after["current"]["rmse"] < 1.5 * result.before["current"]["noise_floor"]


def test_numbers_that_one_recording_alone_knows_may_go_anywhere_without_it(stock):
    """Play and a soft shaft fitted to a bench that has neither: straight lines lead out of every range."""
    recordings = bench(stock.with_effect("presliding_friction", {"stiffness": 0.7, "damping": 0.0}), SLOW[1:], 4.0)
    fitted = fit_model(recordings, stock.with_effect("backlash", {}).with_effect("shaft_compliance", {}))
    assert all(math.isfinite(value) for _, value, _ in estimates(fitted))


def test_a_start_that_no_twin_can_be_made_of_is_not_taken(stock):
    bare = []
    for recording in bench(stock, SLOW):
        signals = {name: values for name, values in recording.signals.items() if name != "output_position"}
        bare.append(with_signals(recording, signals))
    fitted = fit_model(bare, stock.with_effect("backlash", {"width": 0.004}), method="simulation")
    assert fitted.method == "simulation" and "width" in fitted.parameters["backlash"]
