"""What to say if no bench publishes: that nothing can be compared, and what to start."""

from __future__ import annotations

import sys
from pathlib import Path


def no_bench() -> str:
    """That no bench publishes, and what starts one."""
    installed = Path(sys.prefix) / "lib" / "ema_bench_replay" / "replay"
    replay = str(installed) if installed.exists() else "ros2 run ema_bench_replay replay"
    return (
        "No bench publishes /bench/state. Start the bench, or the replay of a recording, in another terminal with the "
        f"same ROS_DOMAIN_ID ({replay} --ros-args -p recording:=RUN), or let live itself replay one: ema-twin live RUN"
    )
