"""What a bench may be asked to do: by default no more than its recordings have done already."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.units import unit_in

from ...criteria import LARGEST_EFFECT, MOSTLY, SMALL
from ...measured.observation import Observation
from ...model import Model
from ...model.own_units import shown
from ...plant.measured_motion import ACCELERATION, MOTOR_CURRENT, OUTPUT_ANGLE, SPEED

_SLACK = {"speed": 1.05, "acceleration": 1.15, "current": 1.1}  # a simulation differs slightly from the bench
_SLACK_TRAVEL = 0.02  # of the range
_LONG = 20.0  # own s for which a shaft without end stops may turn one way
_NONE = 1e-12  # in place of a limit of zero


@dataclass(frozen=True)
class Limits:
    """Limits of a command: rad/s, rad/s² and rad (from the start) of the slow shaft, A of the motor."""

    speed: float
    acceleration: float
    lower: float
    upper: float
    current: float
    motion: str = "rotary"  # or linear: m instead of rad

    def shown(self, model: Model) -> Limits:
        """Convert limits in a model's own units to SI."""
        return self._times(model, 1)

    def told(self, model: Model) -> Limits:
        """Convert limits in SI to a model's own units."""
        return self._times(model, -1)

    def _times(self, model: Model, sign: int) -> Limits:
        units = {"speed": "rad/s", "acceleration": "rad/s^2", "lower": "rad", "upper": "rad", "current": "A"}
        factors = {name: shown(model, 1.0, unit)[0] ** sign for name, unit in units.items()}
        linear = sign > 0 and model.units is not None and model.units.radius is not None
        values = {name: getattr(self, name) * factor for name, factor in factors.items()}
        return Limits(**values, motion="linear" if linear else "rotary")

    def as_json(self) -> dict[str, object]:
        """SI units."""
        return {
            "speed": {"value": self.speed, "unit": unit_in("rad/s", self.motion)},
            "acceleration": {"value": self.acceleration, "unit": unit_in("rad/s^2", self.motion)},
            "travel": {"lower": self.lower, "upper": self.upper, "unit": unit_in("rad", self.motion)},
            "current": {"value": self.current, "unit": "A"},
        }

    def effort(self, done: Limits) -> float:
        """Largest share of these limits that a motion which reached ``done`` has used."""
        span = max(self.upper - self.lower, _NONE)
        outside = max(self.lower - done.lower, done.upper - self.upper, 0.0) / span
        return max(
            done.speed / max(_SLACK["speed"] * self.speed, _NONE),
            done.acceleration / max(_SLACK["acceleration"] * self.acceleration, _NONE),
            done.current / max(_SLACK["current"] * self.current, _NONE),
            (done.upper - done.lower) / span / (1.0 + _SLACK_TRAVEL),
            1.0 + outside if outside > _SLACK_TRAVEL else 0.0,
        )

    def exceeded(self, done: Limits) -> tuple[str, ...]:
        """The limits (SI) that ``done`` exceeds, with the value reached and the limit."""
        found = [
            f"{name} {reached:.2g} {unit_in(unit, self.motion).replace('^2', '²')} (so far {limit:.2g})"
            for name, reached, limit, unit in (
                ("speed", done.speed, self.speed, "rad/s"),
                ("acceleration", done.acceleration, self.acceleration, "rad/s^2"),
                ("current", done.current, self.current, "A"),
            )
            if reached > _SLACK[name] * limit
        ]
        slack = _SLACK_TRAVEL * (self.upper - self.lower)
        if done.upper > self.upper + slack or done.lower < self.lower - slack:
            way = unit_in("rad", self.motion)
            found.append(
                f"travel from {done.lower:.2g} to {done.upper:.2g} {way} (so far {self.lower:.2g} to {self.upper:.2g}"
                f"{self._further(done)})"
            )
        return tuple(found)

    def _further(self, done: Limits) -> str:
        """How many times longer the travel was; empty if it was not longer."""
        times = (done.upper - done.lower) / max(self.upper - self.lower, _NONE)
        return f", {times:.2g} times as far" if times > 1.0 + _SLACK_TRAVEL else ""


def reached(o: Observation, ratio: float) -> Limits:
    """What a recording reached."""
    motion = o.motion
    output = motion[:, OUTPUT_ANGLE]
    speed, acceleration, current = (
        float(np.abs(motion[:, column]).max()) for column in (SPEED, ACCELERATION, MOTOR_CURRENT)
    )
    return Limits(speed / ratio, acceleration / ratio, float(output.min()), float(output.max()), current)


def driven_limits(observations: Sequence[Observation], ratio: float) -> Limits:
    """What recordings of a machine with this gear ratio have reached, each counted from its own start."""
    every = [reached(o, ratio) for o in observations]
    return Limits(
        max(r.speed for r in every),
        max(r.acceleration for r in every),
        min(r.lower for r in every),
        max(r.upper for r in every),
        max(r.current for r in every),
    )


def widened(limits: Limits, model: Model, origin: float, faster: float = LARGEST_EFFECT) -> Limits:
    """Limits for a bench that can do more than it has done: up to twice the current.

    The current is what loads drive, motor and gears. A slow recording says nothing about how fast a bench may turn: the
    speed is limited by the current that friction then takes, and to ``faster`` times the driven speed. Speed and
    current stay well below the drive's own limits, and travel ends before the model's end stops. A bench may have stops
    that its model lacks. So without stops in the model, travel either way is at most the larger of two: the total
    travel so far, and the distance that up to twice the speed so far covers in the usual time.

    ``origin`` [rad] is the output's angle at the start, relative to which the model's end stops are placed.
    """
    ratio = model.value("machine.gear_ratio")
    torque = model.value("drive.torque_limit") / model.value("machine.torque_constant")
    stops = [model.constants.get(f"transmission.end_stop_{side}") for side in ("lower", "upper")]
    lower, upper = (
        infinite if stop is None else stop.value - origin
        for stop, infinite in zip(stops, (-math.inf, math.inf), strict=True)
    )
    speed = min(faster * limits.speed, MOSTLY * model.value("drive.speed_limit") / ratio)
    unknown = max(limits.upper - limits.lower, min(LARGEST_EFFECT * limits.speed, speed) * _LONG)
    below, above = (unknown if stop is None else speed * _LONG for stop in stops)
    return Limits(
        speed,
        faster * limits.acceleration,
        min(limits.lower, max(-below, (1.0 - SMALL) * lower)),
        max(limits.upper, min(above, (1.0 - SMALL) * upper)),
        min(LARGEST_EFFECT * limits.current, MOSTLY * min(torque, model.value("drive.current_limit"))),
    )
