"""A machine with one encoder: no output is looked for, and its torque is judged in the same rows as with two."""

import numpy as np
import pytest
from recorded import record, with_signals

from ema_twin_sim.measured import observe as observing
from ema_twin_sim.measured.observe import observe


@pytest.fixture(scope="module")
def run(stock):
    return record(stock, ["sine:0.05:0.4"], 4.0)[0]


def without_output(run):
    return with_signals(run, {name: values for name, values in run.signals.items() if name != "output_position"})


def test_torque_rows_need_no_output(run, stock):
    both, one = observe(run, stock), observe(without_output(run), stock)
    assert len(both.encoder_rows) and not len(one.encoder_rows)
    assert len(one.encoder) == len(one.encoder_noise) == len(one.encoder_piece) == 0
    for name in ("rows", "torque", "torque_noise", "acceleration", "hit"):
        assert np.array_equal(getattr(one, name), getattr(both, name)), name


def test_lost_counts_are_not_looked_for_without_an_output(run, stock, monkeypatch):
    def look(*_):
        raise AssertionError("an encoder that is not there is searched for lost counts")

    monkeypatch.setattr(observing, "counter_jumps", look)
    assert len(observe(without_output(run), stock).rows)
    with pytest.raises(AssertionError, match="searched for lost counts"):
        observe(run, stock)


def test_nothing_is_shaken_without_a_gearbox(run, stock, monkeypatch):
    def look(*_):
        raise AssertionError("impacts of a gearbox that is not there are looked for")

    alone = stock.with_value("machine.output_inertia", 0.0)
    monkeypatch.setattr(observing, "moving_maximum", look)
    seen = observe(without_output(run), alone)
    assert not seen.hit.any() and not seen.after_impact.any()
