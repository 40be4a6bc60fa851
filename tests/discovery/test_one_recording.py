"""One recording: what it does not tell from chance or from wandering friction is not named; what it does tell, is."""

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from tests.accuracy.cases import drawn_case
from tests.accuracy.commands import Drive
from tests.accuracy.folders import readable_train
from tests.accuracy.sizes import middling_cause
from tests.accuracy.unkind import Unkind

ALONE = (Drive("triangle", 0.04, 2.5),)


def found_in(hidden, seed):
    """What is found in recordings of a bench whose friction wanders."""
    causes = [middling_cause(id, np.random.default_rng(seed), 1.0) for id in hidden]
    case = drawn_case("one", "plain", (), (seed, 7000), company=causes, train=ALONE, unkind=Unkind(wander=0.08))
    return discover(readable_train(case), case.start_model)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_friction_that_wanders_is_no_load_and_does_not_warm_up(seed):
    found = found_in((), seed)
    assert found.added == ()


@pytest.mark.parametrize("effect", ["constant_load", "cogging"])
def test_what_wandering_does_not_explain_is_named(effect):
    assert effect in found_in([effect], 1).added
