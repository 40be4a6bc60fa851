"""What is wrong in all traces of a machine is told once, not once a trace."""

import numpy as np

from ema_twin_sim.commands import init


def test_a_current_that_is_too_small_in_every_trace_is_asked_about_once(tmp_path, capsys):
    """Eight traces whose column says mA and holds A: each reaches another size."""
    time = np.arange(0.0, 4.0, 0.01)
    angle = 180.0 * (1.0 - np.cos(np.pi * time))
    files = []
    for k in range(8):
        noise = np.random.default_rng(k).normal(size=len(time))
        current = (4.0 + 0.5 * k) * np.sign(np.sin(np.pi * time)) + 0.3 * noise
        rows = [f"{t:.2f},{a:.4f},{i:.5f}" for t, a, i in zip(time, angle, current, strict=True)]
        files.append(tmp_path / f"{k}.csv")
        files[-1].write_text("\n".join(["time [s],angle [deg],current [mA]", *rows]) + "\n")
    init.run(str(tmp_path / "axis"), files)
    told = [line for line in capsys.readouterr().err.splitlines() if "read as mA" in line]
    assert len(told) == 1 and "0: current reaches" in told[0] and told[0].endswith("(and 7 more like it)")
