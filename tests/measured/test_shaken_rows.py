"""What a hard acceleration makes of rows is told once, by the observation; both methods of a fit go by it."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.criteria import HARD
from ema_twin_sim.fitting.free_parameters import choose_numbers
from ema_twin_sim.fitting.simulation_misfit import SimulationMisfit
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.plant.motion import ACCELERATION
from tests.recorded import record


@pytest.fixture(scope="module")
def hard_run(stock):
    return record(stock, ("sine:0.1:2",), seconds=4.0)[0]


def trust_of(recording, seen, model):
    """What each row of the current counts in a fit to the simulated loop."""
    misfit = SimulationMisfit([recording], [seen], choose_numbers(model, (), ()), ["setpoint"])
    part = next(part for part in misfit._parts if part.signal == "current")
    return part.trust, part.samples


def test_both_methods_count_a_shaken_row_alike(hard_run, stock):
    seen = observe(hard_run, stock)
    trust, samples = trust_of(hard_run, seen, stock)
    moving = trust > 0.0
    assert trust[moving].min() < 0.5
    assert trust[moving] == pytest.approx(1.0 / seen.shaken[samples[moving]])


def test_where_nothing_stands_behind_teeth_nothing_is_shaken(hard_run, stock):
    """A motor alone reverses as hard as it likes: its rows count whole, in one method as in the other."""
    alone = stock.with_value("machine.output_inertia", 0.0)
    seen = observe(hard_run, alone)
    assert np.abs(seen.motion[:, ACCELERATION]).max() > HARD
    assert not seen.hit.any() and seen.below_shock_limit.all() and not seen.after_impact.any()
    trust, _ = trust_of(hard_run, seen, alone)
    assert set(trust) == {0.0, 1.0}  # at standstill, and elsewhere


def test_a_window_keeps_what_shook_it(hard_run, stock):
    whole = observe(hard_run, stock)
    part = whole.window(400, 1200)
    assert np.array_equal(part.hit, whole.hit[400:1200]) and len(part.after_impact) == 800
    assert np.array_equal(part.below_shock_limit, part.hit[part.rows] < HARD)
    assert np.array_equal(replace(part, rows=part.rows[:5]).below_shock_limit, part.below_shock_limit[:5])
