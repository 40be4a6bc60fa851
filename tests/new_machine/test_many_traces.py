"""What is wrong in all traces of a machine is told once, not once a trace."""

import numpy as np


def test_a_current_that_is_too_small_in_every_trace_is_asked_about_once(drafted):
    """Eight traces whose column says mA and holds A: each reaches another size."""
    time = np.arange(0.0, 4.0, 0.01)
    runs = []
    for k in range(8):
        noise = 0.3 * np.random.default_rng(k).normal(size=len(time))
        current = (4.0 + 0.5 * k) * np.sign(np.sin(np.pi * time)) + noise
        runs.append({"time [s]": time, "angle [deg]": 180.0 * (1.0 - np.cos(np.pi * time)), "current [mA]": current})
    warned = drafted(*runs).warned
    assert warned.count("read as mA") == 1 and "run0: current reaches" in warned and "(and 7 more like it)" in warned
