"""What tests of campaigns share."""

import shutil
from pathlib import Path

import pytest

RECORDINGS = Path(__file__).parents[1] / "recordings"


@pytest.fixture
def folder(tmp_path):
    """Two units: one with two recordings, one with a copy of the first and a torn one."""
    first, second = sorted(RECORDINGS.glob("*.CSV"))[:2]
    for unit, file in (("A", first), ("A", second), ("B", first)):
        (tmp_path / "runs" / unit).mkdir(parents=True, exist_ok=True)
        shutil.copy(file, tmp_path / "runs" / unit)
    (tmp_path / "runs" / "B" / "torn.CSV").write_text("time;current\n")
    return tmp_path / "runs"
