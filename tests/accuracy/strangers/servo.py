"""A stranger's servo: inertia, friction, a current loop, and, where it has one, a speed loop that follows a setpoint.

Nothing of the twin is in it. Dry friction is an exact one (each step stops what it may stop), the integrator is
semi-implicit Euler, and what is hidden is a torque or a gap in a few lines each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

LONGEST_STEP = 1.0 / 100000.0  # s

HIDDEN = (
    "gravity_load",
    "stribeck_friction",
    "constant_load",
    "asymmetric_friction",
    "quadratic_drag",
    "cogging",
    "backlash",
    "encoder_eccentricity",
)
BEHIND_THE_GEAR = ("backlash", "encoder_eccentricity")
"""What only an encoder at the output shows."""

COGS = 24.0  # per turn of the motor


@dataclass(frozen=True)
class Servo:
    """One machine, SI, at the motor's shaft."""

    inertia: float
    viscous: float
    dry: float  # N m
    torque_constant: float
    top_speed: float  # rad/s
    top_current: float  # A
    ratio: float
    share_behind: float  # of inertia and dry friction, behind the gear
    hidden: dict[str, dict[str, float]] = field(default_factory=dict)  # effect: the catalogue's parameters
    bandwidth: float = 150.0  # rad/s, of the speed loop
    integral_time: float = 0.03  # s
    speed_filter: float = 1e-3  # s
    current_lag: float = 3e-4  # s
    contact: float = 150.0  # Hz, at which the motor rings on touching teeth
    contact_damping: float = 0.4  # times sqrt(stiffness * inertia)

    def of(self, effect: str, parameter: str, without: float = 0.0) -> float:
        """A parameter of what is hidden; ``without`` where that is not."""
        return self.hidden.get(effect, {}).get(parameter, without)


@dataclass(frozen=True)
class Run:
    """What is true at each sample (n,), SI."""

    time: np.ndarray
    setpoint: np.ndarray
    speed: np.ndarray  # as the drive filters it
    motor: np.ndarray
    output: np.ndarray  # rad of the output's shaft
    current: np.ndarray


def run(servo: Servo, setpoint: np.ndarray, period: float, origin: float) -> Run:
    """The servo following a setpoint (n,) [rad/s], one value a sample; the output begins at the angle ``origin``."""
    steps = max(1, math.ceil(period / LONGEST_STEP))
    numbers = np.array(
        [
            servo.inertia,
            servo.viscous,
            servo.dry,
            servo.torque_constant,
            servo.top_current,
            servo.ratio,
            servo.share_behind,
            servo.bandwidth * servo.inertia,
            servo.integral_time,
            servo.speed_filter,
            servo.current_lag,
            servo.of("gravity_load", "torque"),
            servo.of("gravity_load", "angle"),
            servo.of("stribeck_friction", "torque"),
            servo.of("stribeck_friction", "speed", 1.0),
            servo.of("constant_load", "torque"),
            servo.of("asymmetric_friction", "fraction"),
            servo.of("quadratic_drag", "coefficient"),
            servo.of("cogging", "torque"),
            servo.of("cogging", "phase"),
            0.5 * servo.of("backlash", "width") * servo.ratio,
            origin,
            servo.contact,
            servo.contact_damping,
        ]
    )
    shown = np.zeros((len(setpoint), 4))
    _run(numbers, np.ascontiguousarray(setpoint), period / steps, steps, shown)
    speed, motor, output, current = shown.T
    output = output / servo.ratio
    size, phase = servo.of("encoder_eccentricity", "amplitude"), servo.of("encoder_eccentricity", "phase")
    output = output + size * (np.sin(origin + output + phase) - math.sin(origin + phase))
    return Run(np.arange(len(setpoint)) * period, setpoint, speed, motor, output, current)


@njit(cache=True)
def _stopped(speed, by):
    """A speed after dry friction has taken ``by`` of it, at most all."""
    return math.copysign(max(abs(speed) - by, 0.0), speed)


@njit(cache=True)
def _run(numbers, setpoint, step, steps, shown):
    (inertia, viscous, dry, constant, limit, ratio, behind, gain, integral_time, filtering, lag) = numbers[:11]
    (gravity, angle, stribeck, slow, load, asymmetry, drag, cogs, phase, half_gap, origin) = numbers[11:22]
    (contact, damped) = numbers[22:]
    motor_inertia = inertia * (1.0 - behind)
    output_inertia = inertia * behind
    stiffness = motor_inertia * (2.0 * math.pi * contact) ** 2
    damping = damped * math.sqrt(stiffness * motor_inertia)
    speed = out_speed = motor = output = current = seen = summed = 0.0
    for sample in range(len(setpoint)):
        shown[sample] = seen, motor, output, current
        next_setpoint = setpoint[min(sample + 1, len(setpoint) - 1)]
        for k in range(steps):
            # the drive interpolates: a staircase would make the current swing between samples
            wished = setpoint[sample] + (next_setpoint - setpoint[sample]) * k / steps
            seen += step / (filtering + step) * (speed - seen)
            error = wished - seen
            wanted = (gain * (error + summed / integral_time)) / constant
            if abs(wanted) < limit:
                summed += step * error
            wanted = min(max(wanted, -limit), limit)
            current += step / (lag + step) * (wanted - current)

            side = 1.0 if speed > 0.0 else -1.0
            uneven = 1.0 + asymmetry * side
            level = (dry + stribeck * math.exp(-abs(speed) / slow)) * uneven
            push = constant * current - viscous * uneven * speed - drag * speed * abs(speed)
            push -= cogs * math.sin(COGS * motor + phase)
            pull = load + gravity * math.sin(origin + output / ratio + angle)
            if half_gap == 0.0:
                speed = _stopped(speed + step / inertia * (push - pull), step / inertia * level)
                motor += step * speed
                output = motor
                continue
            twist = motor - output
            passed = 0.0
            if twist > half_gap:
                passed = max(stiffness * (twist - half_gap) + damping * (speed - out_speed), 0.0)
            elif twist < -half_gap:
                passed = min(stiffness * (twist + half_gap) + damping * (speed - out_speed), 0.0)
            speed = _stopped(
                speed + step / motor_inertia * (push - passed), step / motor_inertia * level * (1.0 - behind)
            )
            out_speed = _stopped(
                out_speed + step / output_inertia * (passed - pull), step / output_inertia * level * behind
            )
            motor += step * speed
            output += step * out_speed
