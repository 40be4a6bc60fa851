"""Recordings whose first sample does not tell where in its play the output stands."""

from ema_twin_sim.comparison.compare import compare
from tests.recorded import benched


def warnings_of(model, bench, first):
    recording = benched(bench, "sine:0.05:0.25", first + 4.5).between(first)
    return compare([recording], model).warnings


def test_a_cut_just_after_a_reversal_is_told_with_the_constant_that_it_costs(stock):
    model = stock.with_effect("backlash", {"width": 0.004})
    (told,) = warnings_of(model, model, 3.11)  # the gap, 4 mrad wide, is open: the output still rests on the old flank
    assert "3.87 mrad of its output position's error are the same both ways" in told


def test_cuts_that_the_first_sample_tells_and_wrong_widths_are_not(stock):
    model = stock.with_effect("backlash", {"width": 0.004})
    for first in (0.0, 0.5, 4.5):
        assert not warnings_of(model, model, first)
    assert not warnings_of(model.with_value("effects.backlash.width", 0.003), model, 4.5)
    assert not warnings_of(stock, model, 4.5)
