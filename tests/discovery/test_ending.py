"""What is said at the end of a search: errors beyond the noise are named, whatever a search has left to try."""

from types import SimpleNamespace

import pytest

from ema_twin_sim.discovery.ending import why_ended


def ended(beyond, tried=(1,), parted=False):
    """The sentence after a search whose last round tried something and added nothing."""
    fit = SimpleNamespace(hypothesis=SimpleNamespace(base=None), parted=parted)
    found = SimpleNamespace(fit=fit, stopped=SimpleNamespace(tried=tried), rounds=())
    unseen = SimpleNamespace(rmse=(1.0,), noise_floor=1.0)
    return why_ended(SimpleNamespace(size=1), "explained", found, (), unseen, beyond)


def test_errors_beyond_the_noise_are_named_with_their_size():
    said = ended({"encoder_difference": 12.85, "unexplained_torque": 1.71})
    assert said.endswith("beyond the sensors' noise: encoder difference (13 times) and unexplained torque (1.7 times)")
    assert "chance" not in said


@pytest.mark.parametrize(("tried", "said"), [((1,), "than chance would"), ((), "nothing is left to try")])
def test_within_the_noise_nothing_more_is_said(tried, said):
    assert ended({}, tried).endswith(said)
