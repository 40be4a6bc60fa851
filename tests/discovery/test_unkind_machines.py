"""Unkind machines on which an effect was once lost: friction wanders, gears ring, encoders err between their lines."""

import pytest

from tests.accuracy.other_machines import other_machine_case
from tests.accuracy.work import solve

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("effects", "seed"),
    [
        # thrown at one step, which leaves more than lines do; beside all that it explains this is little
        (["backlash"], (51, 5001, 19)),
        # the gearbox rings, and a spring in its place was doubted together with what it had not drawn
        (["added_inertia"], (52, 5001, 19)),
        # the gearbox rings, and play came in with soft teeth: without their width these explain as much
        (["stribeck_friction"], (54, 5001, 17)),
        # gravity joined it later, and of two that are uncertain together the wrong one went
        (["encoder_delay", "constant_load"], (52, 5001, 1)),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, list) else "",
)
def test_what_is_hidden_is_named_and_nothing_else(effects, seed):
    verdict = solve(other_machine_case("unkind", "plain", effects, seed))
    assert {*verdict.added} == {*effects}
    assert not verdict.wrong
