"""What recordings would show of effects that nobody found: how sure of their sizes, and what is asked for then."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.criteria import DECIDED, SIGNIFICANT
from ema_twin_sim.discovery.experiment.bench_limits import Limits
from ema_twin_sim.discovery.experiment.detection import Detection, Showing, marginal
from ema_twin_sim.discovery.plan import plan
from ema_twin_sim.effects import catalogue
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit, prior_rows
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.problems import hypothesis_of
from tests.recorded import record

SLOW = ("triangle:0.015:2", 12.0)


def observed(model, command, seconds, seed=None):
    return observe(virtual_bench(model, parse_command(command), seconds, seed=seed), model)


def found_by(model, recording, effect="", **parameters):
    """The fit of the constants, or of one effect beside them."""
    return fit(EquationErrorProblem([recording]), hypothesis_of(model, **({effect: parameters} if effect else {})))


def shown(detection, planned, effect):
    """Standard errors by which an effect would stand out from none, with a planned recording as well."""
    apart = detection.apart(detection.so_far + detection.of(EquationErrorProblem([planned])))
    return Showing(detection.effects, apart, np.ones(apart.shape, bool)).of(effect)


@pytest.mark.parametrize(
    ("effect", "command"),
    [
        ("quadratic_drag", "sine:0.12:0.0833"),
        ("constant_load", "triangle:0.05:5"),
        ("thermal_friction", "triangle:0.05:5"),
        ("spring_load", "ramp:0.05"),
    ],
)
def test_a_refit_is_as_sure_as_was_predicted(stock, effect, command):
    """Of a size that stands out by n standard errors, a fit to what is then recorded tells it to one n-th."""
    slow = observed(stock, *SLOW, seed=1)
    found = found_by(stock, slow)
    predicted = shown(Detection(found, frozenset()), observed(stock, command, 20.0, seed=2), effect)
    there = stock.with_effect(effect)
    both = EquationErrorProblem([observed(there, *SLOW, seed=3), observed(there, command, 20.0, seed=4)])
    size = catalogue()[effect].parameters[0]
    refit = fit(both, hypothesis_of(stock, **{effect: catalogue()[effect].default_parameters()}))
    paths = [free.path for free in refit.hypothesis.free]
    shape = [k for k, path in enumerate(paths) if path.startswith("effects.") and not path.endswith(f".{size.name}")]
    _, priors = prior_rows(refit.hypothesis)
    information = refit.jacobian.T @ refit.jacobian / refit.variance_inflation + priors.T @ priors
    keep = np.array([k not in shape for k in range(len(paths))])  # its shape was taken as known
    information = information[np.ix_(keep, keep)]
    of_size = np.array([path.endswith(f".{size.name}") and path.startswith("effects.") for path in paths])[keep]
    sure = abs(size.default - size.neutral) * float(np.sqrt(marginal(information, of_size)[0, 0]))
    assert predicted == pytest.approx(sure, rel=0.25)
    value = refit.hypothesis.values[paths.index(f"effects.{effect}.{size.name}")]
    assert abs(value - size.default) < SIGNIFICANT * abs(size.default - size.neutral) / sure


def test_what_a_recording_tells_adds_up(stock):
    """The information of two recordings is that of both together, found at once."""
    first, second = observed(stock, *SLOW, seed=1), observed(stock, "sine:0.05:0.25", 12.0, seed=2)
    found = found_by(stock, first)
    one = Detection(found, frozenset())
    both = EquationErrorProblem([first, second])
    even = fit(both, found.hypothesis, 0)
    scale = even.problem.size / found.problem.size
    at_once = Detection(replace(even, misfits=(found.misfits[0] * scale, even.misfits[1])), frozenset())
    apart = one.apart(one.so_far + one.of(EquationErrorProblem([second])))
    assert at_once.effects == one.effects
    assert apart == pytest.approx(at_once.apart(at_once.so_far), rel=0.05, abs=0.1)
    assert (apart >= one.apart(one.so_far) - 1e-6).all()  # and no recording makes anything less sure


def test_friction_that_follows_a_load_asks_for_a_long_way_to_and_fro(stock):
    """Beside a spring it shows by what the way back lacks of the way out, where the spring is wound far."""
    sprung = stock.with_effect("spring_load", {"stiffness": 0.08})
    found = found_by(stock, observed(sprung, *SLOW, seed=1), "spring_load", stiffness=0.08)
    detection = Detection(found, frozenset())
    long, one_way, short = (
        shown(detection, observed(sprung, command, 20.0), "mesh_friction")
        for command in ("triangle:0.1:10", "ramp:0.1", "triangle:0.1:2.5")
    )
    assert long > DECIDED > 2.0 * one_way
    assert long > 2.0 * short


@pytest.mark.slow
def test_an_output_that_hardly_turned_is_asked_to_turn(stock):
    """Neither gravity nor an encoder off its centre shows within a small part of a turn."""
    asked = plan(record(stock, ("triangle:0.04:1",), 12.0), stock)
    hidden = {name for doubt in asked.in_doubt for name in doubt.rivals}
    assert {"gravity_load", "encoder_eccentricity"} <= hidden
    bench = virtual_bench(stock, parse_command(asked.proposal.command), asked.proposal.seconds, seed=None)
    assert np.ptp(bench.signals["output_position"]) > 10.0 * 0.04  # rad, what was turned so far
    assert any(text.startswith("travel") and "times as far" in text for text in asked.proposal.beyond)
    assert np.ptp(bench.signals["output_position"]) < 2.1 * 2.0 * 0.04 * 20.0  # stops may be where nothing has been
    assert {"gravity_load", "encoder_eccentricity"} <= {*asked.proposal.shows}


@pytest.mark.slow
def test_the_second_recording_asked_for_shows_what_the_first_did_not(stock):
    recordings = record(stock, SLOW[:1], SLOW[1])
    first = plan(recordings, stock).proposal
    recordings.append(virtual_bench(stock, parse_command(first.command), first.seconds, seed=2))
    second = plan(recordings, stock)
    still = {name for doubt in second.in_doubt if "would not show" in doubt.reason for name in doubt.rivals}
    # what the first shows is asked for again only where the way that it opened tells it from something else
    doubted = {name for doubt in second.in_doubt for name in doubt.rivals}
    assert second.proposal is None or {*second.proposal.shows} & {*first.shows} <= doubted
    assert {*first.hides} <= still and {*first.hides}.isdisjoint(first.shows)
    assert all(id not in still for id, (_, then) in first.shows.items() if then > 2.0 * DECIDED)


def test_a_limit_that_is_given_holds(stock):
    slow = record(stock, SLOW[:1], SLOW[1])
    limits = Limits(speed=0.04, acceleration=2.0, lower=0.0, upper=0.1, current=1.0)
    asked = plan(slow, stock, limits=limits).proposal
    done = virtual_bench(stock, parse_command(asked.command), asked.seconds, seed=None).signals
    assert done["output_position"].max() < 0.104 and done["output_position"].min() > -0.004
    assert np.abs(done["speed"]).max() < 1.06 * 0.04 * stock.value("machine.gear_ratio")


def test_effects_that_no_recording_would_tell_apart_do_not_count():
    apart = np.array([[20.0, 1.0, 20.0], [1.0, 20.0, 6.0], [20.0, 6.0, 2.0]])
    matters = np.array([[True, False, True], [False, True, True], [True, True, True]])
    showing = Showing(("one", "two", "three"), apart, matters)
    assert showing.standing_out.tolist() == [20.0, 6.0, 2.0]
    assert showing.hidden() == ("three",) and showing.confused() == {}
    assert showing.named == pytest.approx(400 / 425 + 36 / 61 + 4 / 29)
    assert Showing(("one", "two", "three"), apart, matters | True).confused() == {"one": ("two",)}
    one_way = matters | np.eye(3, k=-1, dtype=bool)  # a recording would tell the second from the first, at least
    assert Showing(("one", "two", "three"), apart, one_way).confused() == {"one": ("two",)}


def test_the_information_about_some_numbers_is_that_of_their_errors():
    random = np.random.default_rng(0)
    rows = random.normal(size=(40, 5)) * [1.0, 1e-6, 1e4, 1.0, 1e-3]
    information = rows.T @ rows
    keep = np.array([True, False, True, False, True])
    size = np.sqrt(np.diag(information))
    errors = np.linalg.inv(information / np.outer(size, size))
    told = marginal(information, keep) / np.outer(size[keep], size[keep])
    assert told == pytest.approx(np.linalg.inv(errors[np.ix_(keep, keep)]), rel=1e-6)
