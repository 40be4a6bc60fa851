"""The finer fidelities and the two inertias beside the same equations in C and in other simulators, in one run."""

import numpy as np
import pytest

from ema_twin_sim.model import load_model
from ema_twin_sim.plant.layout import TWIN
from ema_twin_sim.simulation.fidelity import DEFAULT_STEP, FINE_STEP
from tests.benchmarks.in_c import PERIOD, Run, c_loop
from tests.benchmarks.other_simulators import by_lsoda, in_mujoco
from tests.benchmarks.timing import fastest

ROUNDS = 300  # of short runs: the best of many is little moved by what else the machine does
SPEED = 5.0  # rad/s of the motor, where a run starts


def wave(seconds):
    """A setpoint (n,) [rad/s] that turns the motor back too."""
    time = np.arange(round(seconds * 1e9) // PERIOD + 1) * PERIOD * 1e-9
    return SPEED * np.cos(2.0 * np.pi * 0.5 * time)


def show(say, title, rows):
    """A table of (name, seconds taken, seconds simulated, step [s], seconds that C took or NaN)."""
    say(f"\n  {title:<46}{'ns a step':>10}{'× real time':>13}{'× C':>8}")
    for name, taken, simulated, step, c in rows:
        ratio = f"{taken / c:.2f}" if c == c else ""
        say(f"  {name:<46}{1e9 * taken * step / simulated:>10.1f}{simulated / taken:>13.1f}{ratio:>8}")


def test_speed_of_the_finest_fidelity(tmp_path, say):
    """Switching drive and planetary train; the same motion as C's until a switch falls a step apart."""
    function = c_loop("switching_planetary", tmp_path)
    run = Run(load_model("polito_hff"), wave(0.02), FINE_STEP)
    run.assert_same_in_c(function)
    ours, theirs = fastest(ROUNDS, run.by_kernel, lambda: run.by_c(function))
    rows = [("kernel", ours, theirs), ("C", theirs, theirs)]
    show(
        say,
        "switching and planetary, step 1 µs, one core",
        [(name, taken, run.seconds, FINE_STEP, c) for name, taken, c in rows],
    )
    assert ours <= 1.3 * theirs


def test_speed_of_two_inertias(tmp_path, say):
    """The averaged drive, with a shaft that gives way and with one that has play too, and what others take."""
    function = c_loop("two_inertia", tmp_path)
    stock = load_model("polito_bench")
    shaft, play = (Run(stock.with_effect(id), wave(1.0), DEFAULT_STEP) for id in ("shaft_compliance", "backlash"))
    for run in (shaft, play):
        run.assert_same_in_c(function)
    shaft_ours, shaft_c, play_ours, play_c = fastest(
        ROUNDS, shaft.by_kernel, lambda: shaft.by_c(function), play.by_kernel, lambda: play.by_c(function)
    )

    shaft.by_kernel(record=True)
    torque = shaft.rows[:, TWIN.index("motor_torque")].copy()
    plant = shaft.assembly.plant[0]
    mujoco = in_mujoco(plant, torque, PERIOD * 1e-9, DEFAULT_STEP)
    lsoda = by_lsoda(plant, torque, PERIOD * 1e-9)
    assert mujoco() == pytest.approx(lsoda(), rel=0.05), "not the same equations"
    by_mujoco, with_lsoda = fastest(5, mujoco, lsoda)
    show(
        say,
        "averaged and two inertias, step 25 µs, one core",
        [
            (name, taken, shaft.seconds, DEFAULT_STEP, c)
            for name, taken, c in (
                ("kernel, shaft", shaft_ours, shaft_c),
                ("C, shaft", shaft_c, shaft_c),
                ("kernel, shaft with play", play_ours, play_c),
                ("C, shaft with play", play_c, play_c),
                ("MuJoCo, shaft, mechanics alone", by_mujoco, shaft_c),
                ("SciPy's LSODA, shaft, mechanics alone", with_lsoda, shaft_c),
            )
        ],
    )
    assert shaft_ours <= 1.5 * shaft_c
    assert play_ours <= 1.5 * play_c
    assert shaft.seconds >= 1000.0 * shaft_ours
