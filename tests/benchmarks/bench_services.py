"""How long the monitor's diagnosis takes beside a recording that plays in real time, and what the stream notices."""

import time

import numpy as np
import pytest

from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import Health, Residual
from ema_twin_msgs.srv import Diagnose
from tests.conftest import RECORDINGS, outside
from tests.ros_graph import Graph, start_process

LATE = (0.01, 0.02, 0.05)
"""s that a residual may come later than its stamp says, counted from the earliest of its run."""


def recording(name):
    if name == "own":
        return next(RECORDINGS.glob("*sine_0.05*"))
    return next((outside("bench_cases") / name / "train").glob("*sine*"))


def on_time(arrivals):
    """In words, how late the residuals came, of (time, run, stamp)."""
    when, run, stamp = np.array(arrivals).T
    late = np.concatenate([(when - stamp)[run == r] - (when - stamp)[run == r].min() for r in np.unique(run)])
    shares = ", ".join(f"{100.0 * np.mean(late < limit):.1f} % within {1e3 * limit:.0f} ms" for limit in LATE)
    return f"{shares} (the latest {1e3 * late.max():.0f} ms)"


@pytest.mark.parametrize("name", ["own", "dev10"])
def test_a_diagnosis_beside_a_live_run(name, say):
    modules = ("ema_twin_sim.nodes.twin", "ema_twin_sim.nodes.monitor")
    processes = [start_process(module) for module in modules]
    given = (f"recording:={recording(name)}", "loop:=true", "subscribers:=2")
    processes.append(start_process("ema_bench_replay.nodes.replay", *given))
    graph = Graph()
    try:
        node, health, arrivals = graph.plain_node(), [], []

        def arrived(residual):
            stamp = residual.header.stamp
            arrivals.append((time.monotonic(), residual.run, stamp.sec + 1e-9 * stamp.nanosec))

        node.create_subscription(Health, "/monitor/health", health.append, qos.LATEST)
        node.create_subscription(Residual, "/monitor/residual", arrived, qos.RESIDUAL)
        client = node.create_client(Diagnose, "/monitor/diagnose")
        graph.spin_until(lambda: health and health[-1].compared > 6000)
        begun, first = time.monotonic(), len(arrivals)
        future = client.call_async(Diagnose.Request())
        graph.spin_until(future.done)
        lasted = time.monotonic() - begun
        answer = future.result()
        assert answer.success, answer.message
        say(
            f"\n{name}: {answer.diagnosis.verdict} from {answer.diagnosis.window:.0f} s in {lasted:.1f} s\n"
            f"  before the call: {on_time(arrivals[:first])}\n  while it lasts:  {on_time(arrivals[first:])}; "
            f"{(len(arrivals) - first) / lasted:.0f} residuals a second, {health[-1].missing} samples missing"
        )
    finally:
        graph.close()
        for process in processes:
            process.terminate()
        for process in processes:
            process.communicate(timeout=20.0)
