"""The averaged drive: position loop, filtered speed setpoint, PI speed controller, current lag.

Source of the structure and the values: the thesis's script "Main HF" (controller.*); cycle, setpoint filter and current
lag are assumed (see the model file).
"""

import math

from numba import njit

from .compiled import inlined
from .layout import SETPOINT, STANDALONE_SPEED
from .sensors import shown


@njit(error_model="numpy")
def limited(value, limit):
    """Value limited to +-limit."""
    return limit if value > limit else (-limit if value < -limit else value)


@njit(error_model="numpy")
def lag_gain(step, time_constant):
    """Exact gain 1 - exp(-h/T) of a first-order lag over a step; 1 for T = 0."""
    return 1.0 - math.exp(-step / time_constant) if time_constant > 0.0 else 1.0


@njit(error_model="numpy")
def speed_controller(plant, error, integral, integrate):
    """One control cycle: (current setpoint [A], integrator [N m]) from the speed error [rad/s].

    PI with back-calculation: the excess over the torque limit is removed from the integrator with ``anti_windup_time``.
    The current limit acts as a torque limit, too. ``integrate`` is false within the position loop's dead band.
    """
    ceiling = plant.current_limit * plant.nominal_torque_constant
    ceiling = plant.torque_limit if plant.torque_limit < ceiling else ceiling
    wanted = plant.speed_gain * error + integral
    torque = limited(wanted, ceiling)
    if integrate:
        rate = plant.speed_gain / plant.integral_time * error + (torque - wanted) / plant.anti_windup_time
        integral = limited(integral + plant.control_cycle * rate, plant.integral_limit)
    return torque / plant.nominal_torque_constant, integral


@inlined
def drive_step(plant, state, source, given, ahead, filter_gain, setpoint, integral, speed, output_angle, since_cycle):
    """A control cycle of the drive: (speed setpoint [rad/s], current setpoint [A], integrator [N m]).

    ``given`` is the input ``source`` at the start of the cycle, ``ahead`` the change of a recorded setpoint until the
    next cycle. The position loop sees the ``output_angle`` [rad, fast shaft] through its encoder.
    """
    integrate = True
    if source == SETPOINT:
        # a trace is sampled before its stamp's cycle runs: a setpoint appears in it one cycle later
        setpoint = given + ahead
    elif source == STANDALONE_SPEED:
        setpoint += filter_gain * (limited(given, plant.speed_limit) - setpoint)
    else:
        error = given - shown(plant, state, output_angle, since_cycle)
        integrate = math.fabs(error) * plant.gear_ratio > plant.integral_dead_band
        wanted = limited(plant.position_gain * error, plant.speed_limit)
        setpoint += filter_gain * (wanted - setpoint)
    current_setpoint, integral = speed_controller(plant, setpoint - speed, integral, integrate)
    return setpoint, current_setpoint, integral


@njit(error_model="numpy")
def quadrature_voltage(plant, speed, current, current_rate):
    """Quadrature voltage [V] that the winding needs: back-EMF, resistance and inductance of one phase.

    For two phases in series that carry the drive's ampere, consistent with Kt = 2 Ke. Sinusoidal phases with the same
    torque carry peaks of 4/3 of it; the switching drive's voltage contains that resistive voltage.
    """
    return plant.back_emf_constant * speed + plant.phase_resistance * current + plant.phase_inductance * current_rate
