"""What tests of measured signals share."""

import pytest

from ema_twin_sim.model import load_model


@pytest.fixture(scope="module")
def motor():
    """A motor of which nothing but its encoder is known, and no noise of its current."""
    return load_model("laas_motor").with_value("sensors.current_noise", 0.0)
