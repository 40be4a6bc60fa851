"""The stretch of a recording on which play and springs are tried first holds what they do after a reversal."""

import numpy as np
import pytest

from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.excerpt import excerpt
from tests.problems import problem_of
from tests.recorded import record

WIDTH = 4e-3  # rad


@pytest.mark.parametrize("run", ["sine:0.3:0.06", "sine:0.3:0.1", "triangle:0.03:2"])
def test_an_excerpt_goes_on_until_the_play_is_crossed(run, stock):
    """A slow motion turns round once in many seconds, and its play is crossed some time afterwards."""
    recordings = record(stock.with_effect("backlash", {"width": WIDTH}), (run,))
    part = excerpt(problem_of(recordings, stock))
    assert np.ptp(part.encoder) > 0.9 * WIDTH


def test_an_excerpt_of_what_never_turns_round_is_whole(stock):
    (o,) = problem_of(record(stock, ("ramp:0.02",), seconds=20.0), stock).observations
    onwards = EquationErrorProblem([o.window(0, len(o.motion) // 2)])
    (part,) = excerpt(onwards).observations
    assert len(part.motion) >= len(onwards.observations[0].motion) - 1
