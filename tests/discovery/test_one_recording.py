"""One recording: what it does not tell from chance or from wandering friction is not named; what it does tell, is."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.search.one_recording import less_what_one_recording_leaves_open
from ema_twin_sim.discovery.search.trace import BY_CHANCE, Search
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.accuracy.cases import drawn_case
from tests.accuracy.commands import Drive
from tests.accuracy.folders import readable_train
from tests.accuracy.sizes import middling_cause
from tests.accuracy.unkind import Unkind
from tests.problems import problem_of
from tests.recorded import record

ALONE = (Drive("triangle", 0.04, 2.5),)


def found_in(hidden, seed):
    """What is found in recordings of a bench whose friction wanders."""
    causes = [middling_cause(id, np.random.default_rng(seed), 1.0) for id in hidden]
    case = drawn_case("one", "plain", (), (seed, 7000), company=causes, train=ALONE, unkind=Unkind(wander=0.08))
    return discover(readable_train(case), case.start_model)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_friction_that_wanders_is_no_load_and_does_not_warm_up(seed):
    assert found_in((), seed).added == ()


@pytest.mark.parametrize("effect", ["constant_load", "cogging"])
def test_what_wandering_does_not_explain_is_named(effect):
    assert effect in found_in([effect], 1).added


def searched(stock, hidden, commands):
    """The end of a search that named cogging, of recordings of a machine that has the ``hidden`` torque of it."""
    machine = stock.with_effect("cogging", {"torque": hidden, "phase": 0.4}, {"order": "24"}) if hidden else stock
    runs = record(machine, commands, seconds=10.0)
    h = null_hypothesis(stock).with_effect("cogging", {"order": "24"}, {"torque": 0.01, "phase": 0.0})
    return Search(fit(problem_of(runs, stock), h), ())


def left(found):
    """What is left of it."""
    return less_what_one_recording_leaves_open(found, lambda text: None)


def test_what_gains_no_more_than_chance_is_dropped_by_its_reason(stock):
    found = left(searched(stock, 0.0, ("ramp:0.03",)))
    assert not found.fit.hypothesis.added and found.rounds[-1].reason == BY_CHANCE


def test_what_is_there_stays(stock):
    found = searched(stock, 0.03, ("ramp:0.03",))
    assert left(found) is found


def test_several_recordings_are_not_judged_so(stock):
    found = searched(stock, 0.0, ("ramp:0.03", "ramp:0.05"))
    assert left(found) is found


@pytest.mark.parametrize(("of_points", "parted"), [(True, False), (False, True)])
def test_points_and_what_impacts_shake_are_not_judged_so(of_points, parted):
    """Points have no time in which friction could wander, and beside impacts no effect alone tells what it gains."""
    problem = SimpleNamespace(
        observations=[SimpleNamespace(rows=range(9), of_points=of_points)], weighting=SimpleNamespace(wander=None)
    )
    added = {"cogging": SimpleNamespace(effect="cogging")}
    f = SimpleNamespace(problem=problem, parted=parted, hypothesis=SimpleNamespace(added=added, count=lambda id: 0))
    found = Search(f, ())
    assert left(found) is found
