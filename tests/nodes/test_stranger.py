"""Somebody on another machine of the network sees nothing of a node, and sets nothing, unless it was opened to him."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ALONE = ["unshare", "--map-root-user", "--net"]


def apart(command):
    return subprocess.run(
        [*ALONE, *command], capture_output=True, text=True, cwd=Path(__file__).parents[2], timeout=300
    )


def has_namespaces():
    tools = all(map(shutil.which, ("unshare", "nsenter", "ip")))
    return tools and apart(["ip", "tuntap", "add", "cable", "mode", "tap"]).returncode == 0


pytestmark = [
    pytest.mark.slow,  # the stranger looks for seconds
    pytest.mark.skipif(
        not has_namespaces(), reason="needs unshare, nsenter and ip, and a kernel that lets users make networks"
    ),
]


def seen(*variables):
    ended = apart([sys.executable, "-m", "tests.two_machines", *variables])
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout.splitlines()[-1])


def test_a_node_is_not_there_for_another_machine():
    assert seen() == {"left": 0, "nodes": [], "topics": [], "was_set": False}


def test_one_that_was_opened_is():
    """The same stranger sees it, and changes the twin: the test before this one would notice."""
    open_to_all = seen("ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET")
    assert open_to_all["left"] > 0 and open_to_all["nodes"] == ["twin"]
    assert "/twin/state" in open_to_all["topics"] and open_to_all["was_set"]
