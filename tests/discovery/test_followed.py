"""The simulated loop tells how friction and inertia are shared where sides part, which the equation error blurs."""

import numpy as np
import pytest

from ema_twin_sim import load_model
from ema_twin_sim.discovery.followed import with_followed_numbers
from ema_twin_sim.discovery.search.trace import Round, Search
from ema_twin_sim.discovery.split import ClosedLoop
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.scales import to_own_units
from tests.problems import problem_of
from tests.recorded import record

COMMANDS = ("sine:0.03:0.8", "triangle:0.04:0.7", "ramp:0.05")
MORE_FRICTION = 1.04  # times the friction of the output that the model has
WIDTH = 2e-3  # rad


@pytest.fixture(scope="module")
def machine():
    return load_model("polito_bench").with_effect("backlash", {"width": WIDTH})


def searched(machine, width, **told):
    """(loop, search) that ended with play of ``width`` [rad] and the stock model's constants and teeth.

    ``told`` are values of its sensors that the model's file has instead.
    """
    model = load_model("polito_bench")
    for name, value in told.items():
        model = model.with_value(f"sensors.{name}", value)
    recordings, model = to_own_units(record(machine, COMMANDS, 5.0, seed=0), model)
    problem = problem_of(list(recordings), model)
    null = null_hypothesis(model)
    bare = fit(problem, null, 0)
    play = fit(problem, null.with_effect("backlash", {}, {"width": width}), 0)
    play = fit(problem, play.hypothesis.holding(play.hypothesis.teeth_of_the_file()), 0)
    return ClosedLoop(recordings, model), Search(play, (Round(bare, (), play),))


def test_the_loop_finds_the_output_s_own_friction(machine):
    torque = machine.effects["coulomb_friction_2"].parameters["torque"]
    more = machine.with_value("effects.coulomb_friction_2.torque", MORE_FRICTION * torque)
    loop, found = searched(more, 0.99 * WIDTH)
    followed = with_followed_numbers(loop, found)
    values = followed.fit.hypothesis.by_path
    share = values["scale.output_coulomb"] / values["scale.output_inertia"]
    assert share == pytest.approx(MORE_FRICTION, rel=3e-3)
    assert values["effects.backlash.width"] == pytest.approx(WIDTH, rel=1e-3)
    before, after = np.sqrt(loop.errors([found.fit.hypothesis, followed.fit.hypothesis]))
    assert after < 0.5 * before


def test_noise_that_the_model_does_not_tell_is_read_off_the_recordings(machine):
    loop, found = searched(machine, 0.9 * WIDTH, current_noise=0.0)
    followed = with_followed_numbers(loop, found)
    assert followed.fit.hypothesis.by_path["effects.backlash.width"] == pytest.approx(WIDTH, rel=1e-3)


def test_what_follows_already_stays(machine):
    loop, found = searched(machine, WIDTH)
    assert with_followed_numbers(loop, found) is found
