"""Two fits that the torque hardly tells apart may still differ between the encoders."""

import pytest

from ema_twin_sim.criteria import RIVAL_MARGIN
from ema_twin_sim.identification.separation import encoders_tell_apart
from tests.fits_by_hand import a_fit

INFLATION = 3.0


@pytest.mark.parametrize(("lost", "told"), [(0.9, False), (1.1, True), (-0.9, False), (-1.1, True)])
def test_the_encoders_tell_fits_apart_beyond_the_margin_of_a_rival(lost, told):
    """In units of what is left of the encoder difference, whatever the torque misses."""
    one, other = (
        a_fit(None, [1.0], misfits=misfits, inflations=(9.0, INFLATION))
        for misfits in ((100.0, 500.0), (5000.0, 500.0 + lost * RIVAL_MARGIN * INFLATION))
    )
    assert encoders_tell_apart(one, other) is told


def test_a_fit_that_leaves_more_does_not_hide_what_the_other_explains():
    one = a_fit(None, [1.0], misfits=(100.0, 500.0), inflations=(9.0, 2.0))
    other = a_fit(None, [1.0], misfits=(100.0, 500.0 + 3.0 * RIVAL_MARGIN), inflations=(9.0, 20.0))
    assert encoders_tell_apart(one, other) and encoders_tell_apart(other, one)
