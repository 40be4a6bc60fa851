"""Whether the encoders' difference calls for play or a spring, beside what the encoders' own errors make of it."""

import pytest

from ema_twin_sim.identification.sensors import gearbox_shows
from tests.problems import fit_of
from tests.recorded import record


@pytest.mark.parametrize(
    ("effect", "parameters", "shows"),
    [
        ("encoder_eccentricity", {"amplitude": 2e-3, "phase": 0.4}, False),
        ("encoder_delay", {"delay": 2e-4}, False),
        ("backlash", {"width": 4e-3}, True),
        ("shaft_compliance", {"stiffness": 400.0, "damping": 0.1}, True),
    ],
)
def test_a_gearbox_shows_where_it_gives_way_and_not_where_an_encoder_errs(effect, parameters, shows, stock):
    f = fit_of(record(stock.with_effect(effect, parameters)), stock)
    assert gearbox_shows(f.problem, f) == shows
