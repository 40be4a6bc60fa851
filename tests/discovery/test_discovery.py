"""Discovery: what is hidden in a virtual bench is named, nothing is named where nothing is hidden."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.criteria import CLEARLY_MORE
from ema_twin_sim.discovery.criteria.contradictions import contradictions
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.measured.observe import observe, observe_all
from ema_twin_sim.measured.smoothing import gaussian, smooth
from ema_twin_sim.measured.spoilt_samples import despiked
from tests.opened import with_open_effects
from tests.problems import fit_of, hypothesis_of, problem_of
from tests.recorded import COMMANDS, changed, record, with_signals


@pytest.fixture(scope="module")
def plain(stock):
    """Recordings of the stock machine."""
    return record(stock)


def test_a_kernel_and_its_derivatives_are_exact_on_a_parabola():
    time = np.arange(200) * 0.002
    values = 3.0 - 2.0 * time + 5.0 * time**2
    inner = slice(20, -20)
    # a symmetric kernel shifts a parabola by its curvature times half its second moment
    level = smooth(values, gaussian(0.005, 0.002))[inner] - values[inner]
    assert np.ptp(level) < 1e-12 and level[0] == pytest.approx(5.0 * 0.005**2, rel=0.01)
    assert smooth(values, gaussian(0.005, 0.002, 1))[inner] == pytest.approx((-2.0 + 10.0 * time)[inner], abs=1e-9)
    assert smooth(values, gaussian(0.005, 0.002, 2))[inner] == pytest.approx(10.0, abs=1e-6)


def test_a_spike_goes_and_a_corner_stays():
    corner = np.abs(np.arange(400) - 200.0) + np.random.default_rng(0).normal(0.0, 0.01, 400)
    spiked = corner.copy()
    spiked[77] += 5.0
    assert despiked(spiked)[77] == pytest.approx(corner[77], abs=0.1)
    assert despiked(corner) == pytest.approx(corner, abs=0.1)


def test_the_right_model_leaves_the_sensors_noise(plain, stock):
    problem = problem_of(plain, stock)
    residual = problem.residual(problem.predict(hypothesis_of(stock)))
    for parts in (problem.torque_parts, problem.encoder_parts):
        for part in parts:
            assert 0.8 < np.std(residual[part]) < 1.25


def test_constants_are_found_again(stock):
    true = stock.with_value("machine.motor_inertia", 1.04 * stock.value("machine.motor_inertia"))
    true = true.with_value("effects.viscous_friction.coefficient", 0.97 * 0.0255)
    found = fit_of(record(true), stock).hypothesis.model()
    inertia, expected = (sum(m.value(f"machine.{side}_inertia") for side in ("motor", "output")) for m in (found, true))
    assert inertia == pytest.approx(expected, rel=0.01)
    assert found.effects["viscous_friction"].parameters["coefficient"] == pytest.approx(0.97 * 0.0255, rel=0.01)


def test_nothing_is_named_where_nothing_is_hidden(plain, stock):
    found = discover(plain, stock)
    assert (found.verdict, found.added) == ("none", ())
    assert found.model.effects.keys() == stock.effects.keys()


@pytest.mark.parametrize(
    ("id", "parameters", "options"),
    [
        ("stribeck_friction", {"torque": 0.06, "speed": 1.5}, {"law": "exponential"}),
        ("stribeck_friction", {"torque": 0.06, "speed": 1.5}, {"law": "gaussian"}),
        ("gravity_load", {"torque": 0.05, "angle": 0.7}, {}),
        ("thermal_friction", {"fraction": 0.3, "time_constant": 4.0}, {}),
        ("sun_runout", {"torque": 0.02, "phase": 1.0}, {"kind": "dissipative"}),
        ("torque_ripple", {"fraction": 0.05, "phase": -1.0}, {}),
        ("asymmetric_friction", {"fraction": -0.1}, {}),
        ("encoder_delay", {"delay": 0.003}, {}),
        ("presliding_friction", {"stiffness": 2.0, "damping": 0.01}, {}),
    ],
)
def test_a_hidden_effect_is_named_with_its_parameters(id, parameters, options, stock):
    found = discover(record(stock.with_effect(id, parameters, options)), stock)
    assert (found.verdict, found.added) == ("explained", (id,))
    entry = found.parameters[id]
    assert entry["options"] == options
    for name, true in parameters.items():
        if name == "damping":
            continue  # what a bristle's damping does is over before a shaft turns
        assert entry[name]["value"] == pytest.approx(true, rel=0.05, abs=0.03)
        assert abs(entry[name]["value"] - true) < 4.0 * entry[name]["std"]
    assert found.unseen.removed(0, len(found.unseen.rmse) - 1) > 0.7 or id == "encoder_delay"


def test_the_same_answer_at_every_run(stock):
    runs = record(stock.with_effect("cogging", {"torque": 0.02, "phase": 0.4}))
    assert discover(runs, stock).as_json() == discover(runs, stock).as_json()


@pytest.mark.slow
def test_an_effect_that_may_not_be_named_leaves_an_unknown(stock):
    runs = record(stock.with_effect("cogging", {"torque": 0.03, "phase": 0.4}, {"order": "24"}))
    found = discover(runs, stock, without=("cogging",))
    assert found.verdict == "unknown" and not found.added
    assert "order" in found.depends_on


def with_frictions_times(model, dry, viscous):
    """The model with dry and viscous friction times these factors."""
    for name, parameter, times in (("coulomb_friction", "torque", dry), ("viscous_friction", "coefficient", viscous)):
        model = model.with_value(f"effects.{name}.{parameter}", times * model.effects[name].parameters[parameter])
    return model


def with_an_odd_one(stock, dry, viscous):
    """A problem of recordings of which the last is one of a machine with other frictions."""
    (odd,) = record(with_frictions_times(stock, dry, viscous), COMMANDS[2:])
    return problem_of([*record(stock, COMMANDS[:2]), replace(odd, name="odd")], stock)


def test_recordings_of_two_machines_are_noticed(plain, stock):
    problem = with_an_odd_one(stock, 2.0, 1.0)
    told = contradictions(problem, fit(problem, hypothesis_of(stock)))
    assert told and all(sentence.startswith("odd: needs ") for sentence in told)
    same = fit_of(plain, stock)
    assert contradictions(same.problem, same) == ()


@pytest.mark.parametrize("times", [1.05, 2.0])
def test_shares_of_friction_are_of_what_was_fitted_and_not_of_a_guess(stock, times):
    guess = with_open_effects(with_frictions_times(stock, 0.1, 0.1))
    problem = with_an_odd_one(stock, times, times)
    for model in (stock, guess):
        told = contradictions(problem, fit(problem, hypothesis_of(model), 20))
        assert any("odd: needs" in said and "friction" in said for said in told) == (times == 2.0)


def test_recordings_that_cannot_be_judged_are_refused(plain, stock):
    bare = Recording("bare", plain[0].stamps, {"speed": plain[0].signals["speed"]})
    with pytest.raises(InputError, match="bare: has no current and no motor_position"):
        observe(bare, stock)
    with pytest.raises(InputError, match="a diagnosis needs longer ones"):
        observe(plain[0].between(0.0, 0.05), stock)
    still = record(stock, ["ramp:0.0001"], 5.0)
    with pytest.raises(InputError, match="needs more of it: move faster"):
        observe_all(still, stock)


@pytest.fixture(scope="module")
def loaded(stock):
    """Recordings of it with a load."""
    return record(stock.with_effect("constant_load", {"torque": 0.02}))


def test_counters_and_current_alone_are_enough(stock, loaded):
    told = ("current", "motor_position", "output_position")
    found = discover([with_signals(r, {name: r.signals[name] for name in told}) for r in loaded], stock)
    assert (found.verdict, found.added) == ("explained", ("constant_load",))
    assert found.unseen.unit == "N m"


def test_a_gap_and_a_nan_do_not_matter(stock, loaded):
    current = loaded[0].signals["current"].copy()
    current[1000:1040] = np.nan
    assert discover([changed(loaded[0], current=current), *loaded[1:]], stock).added == ("constant_load",)


@pytest.mark.slow
def test_constants_that_a_search_would_draw_away_are_kept(stock, traces):
    """What is left beside play lies at impacts, which torques tell less of than the simulated loop."""
    true = stock.with_effect("backlash", {"width": 0.004})
    true = true.with_effect("stribeck_friction", {"torque": 0.08, "speed": 2.0})
    recordings = [load(trace) for trace in traces]
    found = discover(recordings, true)
    assert (found.verdict, found.added) == ("none", ()) and not found.unseen.worsens
    before, after = (compare(recordings, model).overall["current"]["rmse"] for model in (true, found.model))
    assert after <= CLEARLY_MORE * before
