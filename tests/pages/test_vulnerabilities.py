"""What is said of known vulnerabilities is what was learnt: of a library that nobody could be asked about, nothing."""

import subprocess
import sys

import pytest

from tests.vulnerabilities import LOCK, judge

SAFE = {"name": "numpy", "version": "2.0", "vulns": []}
KNOWN = {"name": "jinja2", "version": "2.10", "vulns": [{"id": "PYSEC-2019-217", "fix_versions": ["2.10.1", "2.11"]}]}
SILENT = {"name": "ros-rclpy", "skip_reason": "not found"}


@pytest.mark.parametrize(
    ("libraries", "status", "words"),
    [
        ([SAFE], 0, ["1 of 1 libraries were asked about; nothing is known of them"]),
        ([SAFE, KNOWN], 1, ["jinja2 2.10: PYSEC-2019-217, mended in 2.10.1, 2.11", "2 of 2 libraries were asked"]),
        ([SAFE, SILENT], 2, ["1 of 2 libraries", "1 could not be asked about", "nothing of ros-rclpy"]),
        ([KNOWN, SILENT], 1, ["PYSEC-2019-217", "1 of 2 libraries", "1 could not be asked about"]),
        ([SILENT] * 7, 2, ["0 of 7 libraries", "7 could not be asked about", "ros-rclpy, …"]),
        ([], 2, ["0 of 0"]),
    ],
)
def test_it_says_what_was_learnt(libraries, status, words):
    lines, told = judge({"dependencies": libraries})
    assert told == status
    assert all(word in "\n".join(lines) for word in words), lines
    assert ("nothing is known" in "\n".join(lines)) == (SAFE in libraries and KNOWN not in libraries)


@pytest.mark.parametrize("answer", ["echo cannot resolve >&2; exit 1", "exit 1"])
def test_a_tool_that_fails_is_no_clean_bill(answer, tmp_path):
    tool = tmp_path / "pip-audit"
    tool.write_text(f"#!/bin/sh\n{answer}\n")
    tool.chmod(0o700)
    for given in (tool, tmp_path / "none"):
        ended = subprocess.run(
            [sys.executable, LOCK.parent / "tests" / "vulnerabilities.py", given], capture_output=True, text=True
        )
        assert (ended.returncode, ended.stderr) == (2, "") and ended.stdout.startswith("could not be asked: ")
