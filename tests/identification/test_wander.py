"""Friction that wanders: told by what a fit leaves over, taken as noise, and no excuse for anything else."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.discovery.criteria.worth import penalised_gain
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.search import adding
from ema_twin_sim.discovery.search.adding import prune, settle
from ema_twin_sim.discovery.search.trace import Search
from ema_twin_sim.discovery.search.wandering_end import less_what_wandering_explains
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.uncertainty import covariance
from ema_twin_sim.identification.wander import Wander
from ema_twin_sim.identification.wandering import wandering
from ema_twin_sim.plant.motion import SPEED
from tests.problems import fit_of, problem_of
from tests.recorded import changed, record

RUNS = ("ramp:0.05", "triangle:0.06:2", "sine:0.05:0.4", "speed-sine:0.08:0.3")


def worn(recordings, share, stock, seed=5, asymmetry=0.0):
    """The recordings of a machine whose friction is by ``share`` (root mean square) more or less, a while each.

    By a share ``asymmetry`` that friction is larger one way than the other.
    """
    random = np.random.default_rng(seed)
    kt = stock.value("machine.torque_constant")
    dry, viscous = (
        sum(next(iter(held.parameters.values())) for held in stock.active.values() if held.effect == id)
        for id in ("coulomb_friction", "viscous_friction")
    )
    found = []
    for recording in recordings:
        knots = np.linspace(0.0, recording.duration, 4)
        drift = np.interp(recording.time, knots, random.normal(0.0, share, len(knots)))
        speed = recording.signals["speed"]
        friction = (dry + viscous * np.abs(speed)) * (np.tanh(speed / 0.05) + asymmetry)
        found.append(changed(recording, current=recording.signals["current"] + drift * friction / kt))
    return found


def ended_beside_play(recordings, stock):
    """What is left, once wandering is asked for, of play and a Stribeck friction that were fitted to recordings."""
    h = null_hypothesis(stock).with_effect("backlash", {}, {"width": 0.003})
    h = h.with_effect("stribeck_friction", {"law": "exponential"}, {"torque": 0.05, "speed": 2.0})
    f = settle(fit(problem_of(recordings, stock), h, 20))
    found = less_what_wandering_explains(Search(f, ()), lambda text: None)
    return set(found.fit.hypothesis.effects)


def test_an_effect_that_gains_clearly_stays_however_small_it_became(stock, monkeypatch):
    """A part of what it explains may be taken for wandering, and the rest is less than a size that is worth a name."""
    load = {"torque": 2.5e-4}
    f = fit_of(record(stock.with_effect("constant_load", load), RUNS, 10.0), stock, 20, constant_load=load)
    problem = f.problem
    gain = penalised_gain(fit(problem, f.hypothesis.without("constant_load")), f)
    monkeypatch.setattr(adding, "DEPENDS", 0.5 * gain)
    assert gain > 0.0
    assert "constant_load" not in prune(f).hypothesis.added
    nothing_wanders = Wander(0.0, (), 99.0)
    beside = fit(problem.under(replace(problem.weighting, wander=nothing_wanders)), f.hypothesis)
    assert "constant_load" in prune(beside).hypothesis.added
    monkeypatch.setattr(adding, "DEPENDS", 2.0 * gain)
    assert "constant_load" not in prune(beside).hypothesis.added


def settled(recordings, model):
    f = settle(fit_of(recordings, model))
    return f.problem, f


def told(recordings, model):
    return wandering(*settled(recordings, model))


@pytest.fixture
def wander():
    random = np.random.default_rng(1)
    first, _ = np.linalg.qr(random.normal(size=(40, 3)))
    second, _ = np.linalg.qr(random.normal(size=(25, 2)))
    of_first = slice(0, 40), first, np.array([9.0, 4.0, 0.5])
    of_second = slice(45, 70), second, np.array([6.0, 1.0])
    return Wander(0.3, (of_first, of_second), 99.0)


class TestWhitening:
    def test_it_makes_the_covariance_one(self, wander):
        covariance = np.eye(70)
        for part, directions, spreads in wander.parts:
            covariance[part, part] += (directions * (wander.share * spreads) ** 2) @ directions.T
        root = wander.whitened(np.eye(70))
        assert np.allclose(root @ covariance @ root.T, np.eye(70))
        assert wander.complexity_penalty == pytest.approx(np.linalg.slogdet(covariance)[1])

    def test_it_can_be_undone(self, wander):
        rows = np.random.default_rng(2).normal(size=(70, 4))
        assert np.allclose(wander.as_measured(wander.whitened(rows)), rows)

    def test_a_problem_beside_it_leaves_less_of_the_same_measured(self, stock):
        problem, f = settled(worn(record(stock, RUNS), 0.05, stock), stock)
        beside = problem.under(replace(problem.weighting, wander=wandering(problem, f)))
        assert not np.allclose(beside.measured, problem.measured)
        predicted = beside.predict(f.hypothesis)
        # what was measured is not whitened
        assert np.allclose(beside.left_over(predicted)[: problem.size], f.raw[: problem.size])
        assert beside.misfit(beside.residual(predicted)) < f.misfit


class TestShare:
    @pytest.mark.parametrize("share", [0.02, 0.06])
    def test_it_is_recovered(self, share, stock):
        found = told(worn(record(stock, RUNS, 10.0), share, stock), stock)
        assert found is not None
        assert 0.5 * share < found.share < 2.0 * share

    def test_it_is_recovered_from_runs_of_different_lengths(self, stock):
        runs = [*record(stock, RUNS[:2]), *record(stock, RUNS[2:], seconds=18.0), *record(stock, RUNS[:1], seconds=7.0)]
        found = told(worn(runs, 0.05, stock), stock)
        assert found is not None
        assert 0.025 < found.share < 0.1

    def test_nothing_wanders_on_a_steady_bench(self, stock):
        assert told(record(stock, RUNS), stock) is None

    def test_a_load_is_no_wandering(self, stock):
        """What depends on the position comes again, and drives as much as it brakes."""
        found = told(record(stock.with_effect("gravity_load", {"torque": 0.02, "angle": 0.3}), RUNS), stock)
        assert found is None or found.share < 0.05

    def test_what_is_larger_one_way_wanders_as_a_whole(self, stock):
        """A part of it then drives one way and brakes the other: the noise knows that as well as the rest."""
        true = stock.with_effect("asymmetric_friction", {"fraction": 0.3})
        worn_runs = worn(record(true, RUNS), 0.05, stock, asymmetry=0.3)
        f = settle(fit_of(worn_runs, stock, asymmetric_friction={"fraction": 0.3}))
        problem = f.problem
        wander = wandering(f.problem, f)
        sense = np.concatenate([np.sign(o.motion[o.rows, SPEED]) for o in problem.observations])
        braking = 0.1 * sense / problem.noise  # of 0.1 N m, all the time
        whole, odd = wander.whitened(braking * (1.0 + 0.3 * sense)), wander.whitened(braking * (1.0 - 0.3 * sense))
        assert np.sum(whole**2) < 0.2 * np.sum(odd**2)


class TestBesideIt:
    @pytest.mark.slow
    def test_what_it_explains_as_well_is_not_named_beside_play(self, stock):
        """Beside play it is asked for last, once all was found that might be its likeness."""
        play = stock.with_effect("backlash", {"width": 0.003})
        assert ended_beside_play(worn(record(play, RUNS), 0.05, stock), stock) == {"backlash"}
        both = play.with_effect("stribeck_friction", {"torque": 0.06, "speed": 2.0})
        assert ended_beside_play(worn(record(both, RUNS), 0.05, stock), stock) == {"backlash", "stribeck_friction"}

    @pytest.mark.slow
    def test_what_is_hidden_is_named_and_the_rest_is_told(self, stock):
        """The constants stay near the file's: without wandering in the noise, friction drags viscous far away."""
        true = stock.with_effect("constant_load", {"torque": 0.03})
        found = discover(worn(record(true, RUNS, 10.0), 0.05, stock), stock)
        assert found.added == ("constant_load",)
        assert found.verdict == "unknown" and "time" in found.depends_on
        assert found.model.effects["constant_load"].parameters["torque"] == pytest.approx(0.03, rel=0.1)

    @pytest.mark.slow
    def test_nothing_hidden_is_nothing_named(self, stock):
        assert discover(worn(record(stock, RUNS), 0.05, stock), stock).added == ()


def test_a_dependence_on_one_stretch_makes_no_number_uncertain(stock):
    """Its columns stand on a block of rows alone: without the block, they are free to be anything."""
    problem, f = settled(record(stock, RUNS), stock)
    before = np.sqrt(np.diag(covariance(problem, f)))
    columns = np.zeros((problem.rows, 1))
    columns[100:130] = 1.0
    problem = problem.with_generic_bases({"time#0": columns})
    after = np.sqrt(np.diag(covariance(problem, fit(problem, f.hypothesis.with_generic_basis("time#0", 1)))))
    assert np.allclose(after[: len(before)], before, rtol=0.5)
