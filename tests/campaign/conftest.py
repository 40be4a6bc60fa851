"""What tests of campaigns share."""

import shutil

import pytest

from ema_twin_sim.campaign.engine import cluster
from tests.conftest import RECORDINGS


@pytest.fixture(scope="module")
def client():
    with cluster(None, 2) as client:
        yield client


@pytest.fixture
def folder(tmp_path):
    """Two units: one with two recordings, one with a copy of the first and a torn one."""
    first, second = sorted(RECORDINGS.glob("*.CSV"))[:2]
    for unit, file in (("A", first), ("A", second), ("B", first)):
        (tmp_path / "runs" / unit).mkdir(parents=True, exist_ok=True)
        shutil.copy(file, tmp_path / "runs" / unit)
    (tmp_path / "runs" / "B" / "torn.CSV").write_text("time;current\n")
    return tmp_path / "runs"
