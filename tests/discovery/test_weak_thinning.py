"""Shear thinning so weak that its speed is hardly known: its share and its speed trade off, and it is named all the
same.
"""

import pytest

from ema_twin_sim.discovery.discover import discover
from tests.recorded import record

FRACTION, SPEED = 0.16, 8.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_weak_thinning_is_named_though_its_speed_is_uncertain(stock, seed):
    thinned = stock.with_effect("shear_thinning", {"fraction": FRACTION, "speed": SPEED})
    found = discover(record(thinned, ("speed-sine:0.1:0.5",), 8.0, seed), stock)
    assert (found.verdict, found.added) == ("explained", ("shear_thinning",))
    speed, share = (found.parameters["shear_thinning"][name] for name in ("speed", "fraction"))
    assert speed["value"] < 2.0 * speed["std"]  # else this test shows nothing
    assert abs(share["value"] - FRACTION) < 3.0 * share["std"]
