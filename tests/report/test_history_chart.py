"""The drawing of a number over time."""

import numpy as np

from ema_twin_sim.campaign.histories import History, outlook
from ema_twin_sim.report.history_chart import history_chart


def test_large_plain_numbers_beside_the_axis_are_written_out():
    values = np.array([0.3, -0.2, 0.1, -0.4, 4400.0, 8837.0])
    healthy = np.arange(6) < 4
    of = History(
        "health", "lost_motion", "1", np.arange(6.0), values, np.ones(6), True, healthy,
        as_asked=True, shared=0.0, names=tuple("abcdef"),
    )  # fmt: skip
    drawn = str(history_chart(outlook(of)))
    assert ">8840<" in drawn and "e+" not in drawn
