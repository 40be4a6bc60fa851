"""How late an encoder may be: a few of its samples, however quick or slow the mechanics."""

from dataclasses import replace

import pytest

from ema_twin_sim.effects import catalogue
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.problems import problem_of
from tests.recorded import record


@pytest.fixture(scope="module")
def run(stock):
    (recording,) = record(stock, ("sine:0.1:0.4",), 20.0)
    return recording


@pytest.mark.parametrize("quicker", [1, 3, 5])
def test_an_encoder_may_be_some_samples_late(stock, run, quicker):
    """In its own units, a machine ``quicker`` than the bench behind the same logger has so many times fewer samples."""
    signals = {name: values[::quicker] for name, values in run.signals.items()}
    thinned = replace(run, stamps=run.stamps[::quicker], signals=signals)
    problem = problem_of([thinned], stock)
    (late,) = (id for id, effect in catalogue().items() if effect.delays)
    slow_drive = stock.with_value("drive.control_cycle", 1e-3)  # the plant keeps the readings of so many cycles
    h = null_hypothesis(slow_drive, by_torque=True).with_effect(late, {}, {"delay": thinned.sample_period})
    _, upper = problem.bounds(h)
    most = dict(zip((free.path for free in h.free), upper, strict=True))[f"effects.{late}.delay"]
    assert most >= 8.0 * thinned.sample_period
