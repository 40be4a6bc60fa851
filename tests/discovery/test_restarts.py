"""Restarts of a search with wandering friction: once for each."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.discovery.search.restarts import Restarts
from ema_twin_sim.identification.wander import Wander

ALONG = np.linalg.qr(np.random.default_rng(5).normal(size=(20, 2)))[0]
WANDER = Wander(0.03, ((slice(0, 20), ALONG, np.array([9.0, 4.0])),), 50.0)
ENDS = [("first end", []), ("second end", [])]


def ends_of(*asked):
    """The ends of searches asked for one after another, (wander, with encoder rows) each."""
    restarts, remaining = Restarts(), iter(ENDS)
    return [restarts(wander, with_encoders, lambda: next(remaining)) for wander, with_encoders in asked]


def test_the_same_friction_is_searched_with_once_however_much_it_gains():
    alike = replace(WANDER, parts=tuple((part, c.copy(), s.copy()) for part, c, s in WANDER.parts), gain=70.0)
    assert ends_of((WANDER, True), (alike, True)) == [ENDS[0], ENDS[0]]


@pytest.mark.parametrize(
    ("other", "with_encoders"),
    [
        (replace(WANDER, share=0.04), True),
        (replace(WANDER, parts=((slice(0, 20), ALONG[:, ::-1], np.array([9.0, 4.0])),)), True),
        (replace(WANDER, parts=((slice(0, 20), ALONG, np.array([9.0, 5.0])),)), True),
        (replace(WANDER, parts=((slice(1, 21), ALONG, np.array([9.0, 4.0])),)), True),
        (WANDER, False),
    ],
    ids=["share", "directions", "spreads", "rows", "encoders"],
)
def test_other_friction_or_other_rows_are_searched_with_anew(other, with_encoders):
    assert ends_of((WANDER, True), (other, with_encoders)) == ENDS
