"""A ROS domain for this process of tests alone: others, of pytest -n or of another checkout, must not be heard.

Beyond that the tests' nodes find each other as everybody's do who has chosen nothing.
"""

import fcntl
import os
import tempfile
from pathlib import Path

from ema_bench_replay.nodes.loopback import PROFILES, RANGE, keep_to_this_machine


def _take():
    """The first domain that no other process of tests on this machine has, and what holds it while this one lives."""
    for domain in range(1, 101):
        try:
            held = (Path(tempfile.gettempdir()) / f"ema_twin_tests_ros_domain_{domain}").open("w")
        except PermissionError:  # another user's
            continue
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            held.close()
            continue
        return domain, held
    raise RuntimeError("all ROS domains are taken by other tests")


DOMAIN, _HELD = _take()
os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
for name in (RANGE, *PROFILES):
    os.environ.pop(name, None)
keep_to_this_machine()
