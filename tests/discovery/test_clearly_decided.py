"""Which of several commands is asked for, where all of them decide."""

import numpy as np
import pytest

from ema_twin_sim.criteria import DECIDED
from ema_twin_sim.discovery.experiment.bench_limits import Limits
from ema_twin_sim.discovery.experiment.command_grid import Planned
from ema_twin_sim.discovery.experiment.detection import Showing
from ema_twin_sim.discovery.experiment.next_command import _ranked
from ema_twin_sim.discovery.experiment.rival_field import Evaluated

ALLOWED = Limits(1.0, 1.0, -1.0, 1.0, 1.0)
HIDDEN = ("one", "two")


def command(name, separation, *standing_out, effort=0.5):
    """A command within limits, by how much it separates the one pair in doubt, and what it shows besides."""
    done = Limits(effort, 0.0, 0.0, 0.0, 0.0)
    showing = Showing(HIDDEN, np.diag(standing_out), np.eye(len(HIDDEN), dtype=bool))
    return Evaluated(Planned(name, 10.0, 8, name, 10.0), done, {("a", "b"): separation}, showing=showing)


def best(*commands):
    so_far = Showing(HIDDEN, np.zeros((2, 2)), np.eye(2, dtype=bool))
    return _ranked(commands, ALLOWED, so_far)[0].trial.command


def test_what_a_command_shows_a_little_better_does_not_outweigh_a_doubt_it_hardly_decides():
    """Both show the same effects; one shows them slightly better, the other decides for sure."""
    hardly, surely = command("sine:1:1", DECIDED, 6.0, 6.5), command("ramp:1", 50.0 * DECIDED, 6.0, 6.0)
    assert best(hardly, surely) == best(surely, hardly) == "ramp:1"


def test_what_decides_surely_either_way_is_chosen_by_what_it_shows():
    more, less = command("sine:1:1", 10.0 * DECIDED, 30.0, 30.0), command("ramp:1", 50.0 * DECIDED, 6.0, 3.0)
    assert best(more, less) == best(less, more) == "sine:1:1"


@pytest.mark.parametrize("separation", [0.0, 0.9 * DECIDED])
def test_a_command_that_decides_comes_before_one_that_shows_more(separation):
    shows, decides = command("sine:1:1", separation, 30.0, 30.0), command("ramp:1", DECIDED, 0.0, 0.0)
    assert best(shows, decides) == "ramp:1"
