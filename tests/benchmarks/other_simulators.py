"""Two inertias under a given torque in MuJoCo and by SciPy's LSODA: what others take for the same mechanics."""

import math
from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

Run = Callable[[], float]
"""Runs all rows and returns how far the motor has turned [rad]."""

SOFT = 0.01  # rad/s about standstill over which LSODA's dry friction changes its sign: it cannot take a jump


def in_mujoco(plant: np.void, torque: np.ndarray, period: float, step: float) -> Run:
    """Two hinges with a spring and a damper between them; ``torque`` [N m] (rows,) is held from row to row."""
    import mujoco

    hinge = '<inertial pos="0 0 0" mass="1" diaginertia="{0} {0} {0}"/>' + (
        '<joint name="{1}" type="hinge" axis="0 0 1" damping="{2}" frictionloss="{3}"/>'
    )
    motor = hinge.format(plant["motor_inertia"], "motor", plant["motor_viscous"], plant["motor_dry"])
    output = hinge.format(plant["output_inertia"], "output", plant["output_viscous"], plant["output_dry"])
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/>
          <worldbody><body>{motor}</body><body>{output}</body></worldbody>
          <tendon>
            <fixed name="shaft" stiffness="{plant["contact_stiffness"]}" damping="{plant["contact_damping"]}">
              <joint joint="motor" coef="1"/><joint joint="output" coef="-1"/>
            </fixed>
          </tendon>
          <actuator><motor joint="motor"/></actuator>
        </mujoco>""")
    data = mujoco.MjData(model)
    steps = round(period / step)

    def run() -> float:
        mujoco.mj_resetData(model, data)
        for held in torque[:-1]:
            data.ctrl[0] = held
            mujoco.mj_step(model, data, steps)
        return float(data.qpos[0])

    return run


@njit(error_model="numpy")
def _slopes(time, state, numbers, torque, period):
    motor_inertia, motor_viscous, motor_dry, output_inertia, output_viscous, output_dry, stiffness, damping = numbers
    passed = stiffness * (state[0] - state[2]) + damping * (state[1] - state[3])
    held = torque[min(int(time / period), len(torque) - 1)]
    slopes = np.empty(4)
    slopes[0] = state[1]
    slopes[1] = (held - motor_viscous * state[1] - motor_dry * math.tanh(state[1] / SOFT) - passed) / motor_inertia
    slopes[2] = state[3]
    slopes[3] = (passed - output_viscous * state[3] - output_dry * math.tanh(state[3] / SOFT)) / output_inertia
    return slopes


def by_lsoda(plant: np.void, torque: np.ndarray, period: float) -> Run:
    """The same equations in compiled Python, no step longer than a row, since the torque jumps there."""
    numbers = tuple(
        float(plant[name])
        for name in (
            "motor_inertia", "motor_viscous", "motor_dry", "output_inertia", "output_viscous", "output_dry",
            "contact_stiffness", "contact_damping",
        )
    )  # fmt: skip

    def run() -> float:
        end = (len(torque) - 1) * period
        solution = solve_ivp(
            _slopes, (0.0, end), np.zeros(4), "LSODA", (end,), args=(numbers, torque, period), rtol=1e-6, atol=1e-9,
            max_step=period,
        )  # fmt: skip
        return float(solution.y[0, -1])

    return run
