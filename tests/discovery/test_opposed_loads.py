"""Gravity and a constant load that cancel each other are a bend over the place: no two loads beside an unknown rest."""

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from tests.discovery.test_open_joints import joint, moved  # noqa: F401 - the fixture


@pytest.mark.parametrize(("rest", "named"), [(15.0, {"constant_load"}), (0.0, {"gravity_load", "constant_load"})])
def test_loads_that_cancel_are_named_only_if_they_explain_the_place(rest, named, joint):  # noqa: F811
    """An arm with a counterweight has both; a bump beside them tells that the bend may be of anything."""

    def bent(time, angle, speed):
        return 20.0 * (0.12 - angle**2) + rest * np.exp(-(((angle - 0.4) / 0.08) ** 2))

    found = discover([moved(bent)], joint)
    assert {*found.added} == named
    assert found.verdict == ("unknown" if rest else "explained")
