"""What tests of nodes share."""

import pytest

from ema_bench_replay.nodes.loopback import PROFILES, RANGE
from tests.ros_graph import starter


@pytest.fixture
def start():
    """Starts nodes in processes of their own, which end with the test."""
    with starter() as start:
        yield start


@pytest.fixture
def nothing_chosen(monkeypatch, tmp_path):
    """As somebody would start nodes who has chosen neither who hears them nor by which transports."""
    for name in (RANGE, *PROFILES):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
