"""A late and eccentric encoder of a machine of unknown constants: each error is judged by what the other leaves."""

import pytest

from ema_twin_sim.discovery.criteria.worth import has_effect_size
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe_all
from tests.opened import all_open
from tests.recorded import record

FAR = ("sine:0.9:0.08", "triangle:0.3:5")
"""Motions over a large part of a turn. At their speeds, 10 ms are as large an error as 3 to 4.5 mrad."""
DELAY, WAVE = "encoder_delay", "encoder_eccentricity"
STARTS = {DELAY: ({}, {"delay": 0.01}), WAVE: ({"order": "1"}, {"amplitude": 1e-4})}
SIZES = {
    DELAY: ({"delay": 0.012}, {"amplitude": 3e-4, "phase": 0.7}),  # the delay hides the wave
    WAVE: ({"delay": 0.0005}, {"amplitude": 8e-3, "phase": 0.7}),  # the wave hides the delay
}
"""Delay and wave, by the one of them that is so large that the other is less than 1 % of the power of both."""


def recorded(stock, larger):
    delay, wave = SIZES[larger]
    return record(stock.with_effect(DELAY, delay).with_effect(WAVE, wave), FAR, 15.0)


@pytest.mark.parametrize("in_the_file", [False, True])
@pytest.mark.parametrize(("larger", "smaller"), [(DELAY, WAVE), (WAVE, DELAY)])
def test_a_large_error_of_one_kind_hides_none_of_the_other(larger, smaller, in_the_file, stock):
    """Whether the large one was found, or is in the model already."""
    model = all_open(stock)
    if in_the_file:
        model = model.with_effect(larger, SIZES[larger][larger == WAVE])
    problem = EquationErrorProblem(observe_all(recorded(stock, larger), model))
    h = null_hypothesis(model)
    before = fit(problem, h if in_the_file else h.with_effect(larger, *STARTS[larger]))
    assert has_effect_size(problem, before, fit(problem, before.hypothesis.with_effect(smaller, *STARTS[smaller])))


@pytest.mark.parametrize(("amplitude", "named"), [(5e-4, False), (4e-3, True)])
def test_a_wave_beside_another_is_judged_by_all_that_waves_do(amplitude, named, stock):
    """What a wave of a slightly other shape leaves is a small wave; a delay is known beside both."""
    late, once = {"delay": 0.012}, {"amplitude": 8e-3, "phase": 0.7}
    twice = {"order": "2"}, {"amplitude": amplitude, "phase": 0.2}
    machine = stock.with_effect(DELAY, late).with_effect(WAVE, once).with_effect(WAVE, *reversed(twice))
    model = all_open(stock)
    problem = EquationErrorProblem(observe_all(record(machine, ("triangle:0.4:10",), 20.0), model))
    h = null_hypothesis(model).with_effect(DELAY, {}, late).with_effect(WAVE, {"order": "1"}, once)
    before = fit(problem, h)
    after = fit(problem, before.hypothesis.with_effect(WAVE, *twice))
    assert has_effect_size(problem, before, after) == named


@pytest.mark.slow
@pytest.mark.parametrize("larger", [DELAY, WAVE])
def test_both_are_named_with_their_sizes(larger, stock):
    found = discover(recorded(stock, larger), all_open(stock))
    delay, wave = SIZES[larger]
    assert found.verdict == "explained" and {*found.added} == {DELAY, WAVE}
    assert found.parameters[DELAY]["delay"]["value"] == pytest.approx(delay["delay"], rel=0.01)
    assert found.parameters[WAVE]["amplitude"]["value"] == pytest.approx(wave["amplitude"], rel=0.01)
