"""The finer fidelities and the two inertias beside the same equations in C and in other simulators, in one run."""

import ctypes

import numpy as np
import pytest

from ema_twin_sim.model import load_model
from ema_twin_sim.plant.kernel import kernel
from ema_twin_sim.plant.layout import BENCH, SETPOINT, STATE, TWIN
from ema_twin_sim.plant.planetary.layout import LANE, ROW
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.fidelity import DEFAULT_STEP, FINE_STEP, resting_state, set_in_motion
from tests.benchmarks.in_c import c_loop, pointer
from tests.benchmarks.other_simulators import by_lsoda, in_mujoco
from tests.benchmarks.timing import fastest

PERIOD = 2_000_000  # ns, of the drive's trace
ROUNDS = 300  # of short runs: the best of many is little moved by what else the machine does
SPEED = 5.0  # rad/s of the motor, where a run starts
MOTION = ("motor_angle", "motor_speed", "output_angle", "output_speed", "integral", "current", "smoothed_speed")


class Run:
    """A model under the speed setpoint, by the kernel or by a C loop, from the same state.

    The setpoint is a slow wave about ``SPEED``, which turns the motor back too.
    """

    def __init__(self, model, seconds, step):
        self.assembly = assemble(model)
        self.seconds, self.step = seconds, step
        self.stamps = np.arange(round(seconds * 1e9) // PERIOD + 1, dtype=np.int64) * PERIOD
        self.setpoint = SPEED * np.cos(2.0 * np.pi * 0.5 * self.stamps * 1e-9)
        self.rows = np.zeros((len(self.stamps), len(TWIN)))
        self._bench = np.full((len(self.stamps), len(BENCH)), np.nan)
        self._bench[:, BENCH.index("load_torque")] = 0.0
        self._bench[:, BENCH.index("speed_setpoint")] = self.setpoint
        self._advance = kernel(self.assembly.fine.switching, self.assembly.fine.planetary)

    def begin(self):
        parts = self.assembly.fine
        self.state = np.zeros(1, STATE)
        for speed in ("motor_speed", "output_speed", "smoothed_speed", "speed_setpoint"):
            self.state[speed] = SPEED
        self.state["control_phase"] = self.assembly.plant["control_cycle"]
        self.fine = resting_state(parts)
        set_in_motion(self.fine, parts, SPEED, 0.0, 0.0)

    def by_kernel(self, record=False):
        self.begin()
        self._advance(
            self.assembly.plant, self.state, self.assembly.acting, self.assembly.effects, (*self.fine,), SETPOINT,
            self.stamps, self._bench, self.rows, self.step, record,
        )  # fmt: skip
        return self.motion()

    def by_c(self, function):
        self.begin()
        winding, winding_state, train, train_state, lanes, table = self.fine[:6]
        if self.assembly.fine.planetary:
            parts = [pointer(part) for part in (winding, winding_state, train, train_state, table)]
            parts += [ctypes.c_long(table.shape[1] - 1), pointer(lanes[ROW["SPIN"] : ROW["SPIN_SPEED"] + LANE])]
        else:
            parts = []
        function(
            pointer(self.assembly.plant), pointer(self.state), *parts, pointer(self.setpoint),
            ctypes.c_long(len(self.setpoint)), ctypes.c_double(PERIOD * 1e-9), ctypes.c_double(self.step),
        )  # fmt: skip
        return self.motion()

    def motion(self):
        return [float(self.state[name][0]) for name in MOTION]


def show(capsys, title, rows):
    """A table of (name, seconds taken, seconds simulated, step [s], seconds that C took or NaN)."""
    with capsys.disabled():
        print(f"\n  {title:<46}{'ns a step':>10}{'× real time':>13}{'× C':>8}")
        for name, taken, simulated, step, c in rows:
            ratio = f"{taken / c:.2f}" if c == c else ""
            print(f"  {name:<46}{1e9 * taken * step / simulated:>10.1f}{simulated / taken:>13.1f}{ratio:>8}")


def test_speed_of_the_finest_fidelity(tmp_path, capsys):
    """Switching drive and planetary train; the same motion as C's until a switch falls a step apart."""
    function = c_loop("switching_planetary", tmp_path)
    run = Run(load_model("polito_hff"), 0.02, FINE_STEP)
    np.testing.assert_allclose(run.by_c(function), run.by_kernel(), rtol=1e-9, atol=1e-9)
    ours, theirs = fastest(ROUNDS, run.by_kernel, lambda: run.by_c(function))
    rows = [("kernel", ours, theirs), ("C", theirs, theirs)]
    show(
        capsys,
        "switching and planetary, step 1 µs, one core",
        [(name, taken, run.seconds, FINE_STEP, c) for name, taken, c in rows],
    )
    assert ours <= 1.3 * theirs


def test_speed_of_two_inertias(tmp_path, capsys):
    """The averaged drive, with a shaft that gives way and with one that has play too, and what others take."""
    function = c_loop("two_inertia", tmp_path)
    stock = load_model("polito_bench")
    shaft, play = (Run(stock.with_effect(id), 1.0, DEFAULT_STEP) for id in ("shaft_compliance", "backlash"))
    for run in (shaft, play):
        np.testing.assert_allclose(run.by_c(function), run.by_kernel(), rtol=1e-9, atol=1e-9)
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
        capsys,
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
