"""What a bench may be asked to do: by default no more than its recordings have done already."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.recording import Recording
from ema_bench_replay.units import unit_in

from ...criteria import LARGEST_EFFECT, MOSTLY, SMALL
from ...measured.observation import Observation
from ...measured.observe import observe_all
from ...measured.scales import to_own_units
from ...model import Model
from ...model.matching import by_torque
from ...model.model_file import ABSENT
from ...model.own_units import shown, shown_motion
from ...plant.motion import ACCELERATION, MOTOR_CURRENT, OUTPUT_ANGLE, SPEED

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
    torque_constant: float | None = None  # N m/A (N/A), if the drive is told by its torque instead of a current

    def shown(self, model: Model, recordings: Sequence[Recording]) -> Limits:
        """Convert limits in a model's own units to SI; matched ``recordings`` say whether a torque is told."""
        constant = shown(model, model.value("machine.torque_constant"), "N m/A")[0]
        told_constant = constant if by_torque(recordings) else None
        return replace(self._times(model, 1), motion=shown_motion(model), torque_constant=told_constant)

    def told(self, model: Model) -> Limits:
        """Convert limits in SI to a model's own units."""
        return replace(self._times(model, -1), motion="rotary", torque_constant=None)

    def _times(self, model: Model, sign: int) -> Limits:
        units = {"speed": "rad/s", "acceleration": "rad/s^2", "lower": "rad", "upper": "rad", "current": "A"}
        factors = {name: shown(model, 1.0, unit)[0] ** sign for name, unit in units.items()}
        return replace(self, **{name: getattr(self, name) * factor for name, factor in factors.items()})

    @property
    def load(self) -> tuple[str, float, str]:
        """Name, size and unit of what loads the drive: its current, or its torque (force) if that is recorded."""
        if self.torque_constant is None:
            return "current", self.current, "A"
        unit = unit_in("N m", self.motion)
        return "force" if unit == "N" else "torque", self.torque_constant * self.current, unit

    def as_json(self) -> dict[str, object]:
        """SI units."""
        load, size, unit = self.load
        return {
            "speed": {"value": self.speed, "unit": unit_in("rad/s", self.motion)},
            "acceleration": {"value": self.acceleration, "unit": unit_in("rad/s^2", self.motion)},
            "travel": {"lower": self.lower, "upper": self.upper, "unit": unit_in("rad", self.motion)},
            load: {"value": size, "unit": unit},
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
        load, limit_of_load, unit_of_load = self.load
        found = [
            f"{name} {_brief(reached)} {unit_in(unit, self.motion).replace('^2', '²')} (so far {_brief(limit)})"
            for name, slack, reached, limit, unit in (
                ("speed", _SLACK["speed"], done.speed, self.speed, "rad/s"),
                ("acceleration", _SLACK["acceleration"], done.acceleration, self.acceleration, "rad/s^2"),
                (load, _SLACK["current"], done.load[1], limit_of_load, unit_of_load),
            )
            if reached > slack * limit
        ]
        slack = _SLACK_TRAVEL * (self.upper - self.lower)
        if done.upper > self.upper + slack or done.lower < self.lower - slack:
            way = unit_in("rad", self.motion)
            found.append(f"travel from {_from_to(done)} {way} (so far {_from_to(self)}{self._further(done)})")
        return tuple(found)

    def _further(self, done: Limits) -> str:
        """How many times longer the travel was; empty if it was not longer."""
        times = (done.upper - done.lower) / max(self.upper - self.lower, _NONE)
        return f", {times:.2g} times as far" if times > 1.0 + _SLACK_TRAVEL else ""


def _brief(value: float) -> str:
    """Two digits, without an exponent unless the number is tiny or huge."""
    return f"{float(f'{value:.2g}'):g}"


def _from_to(limits: Limits) -> str:
    """``-0.2 to 3``; an end as close to the start as a simulation is to the bench is the start."""
    slack = _SLACK_TRAVEL * (limits.upper - limits.lower)
    return " to ".join("0" if abs(end) < slack else _brief(end) for end in (limits.lower, limits.upper))


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


def recorded_limits(recordings: Sequence[Recording], model: Model) -> Limits:
    """What recordings of a model's machine have reached, in SI, as its file tells it.

    Raises InputError if they cannot be judged.
    """
    matched, own = to_own_units(recordings, model)
    return driven_limits(observe_all(matched, own), own.value("machine.gear_ratio")).shown(own, matched)


def widened(limits: Limits, model: Model, origin: float, faster: float = LARGEST_EFFECT) -> Limits:
    """Limits for a bench that can do more than it has done: up to twice the current.

    The current is what loads drive, motor and gears. A slow recording says nothing about how fast a bench may turn: the
    speed is limited by the current that friction then takes, and to ``faster`` times the driven speed; to twice that if
    the model does not state the drive's own limit. Speed and current stay well below the drive's own limits, and travel
    ends before the model's end stops.

    A bench may have stops that its model lacks, and a carriage always has: without stops in the model it keeps to the
    way that it went. A shaft may turn either way as far as the total travel so far. If the model states the drive's own
    limit, it may also turn as far as up to twice the speed so far leads in the usual time.

    ``origin`` [rad] is the output's angle at the start, relative to which the model's end stops are placed.
    """
    ratio = model.value("machine.gear_ratio")
    torque = model.value("drive.torque_limit") / model.value("machine.torque_constant")
    stops = [model.constants.get(f"transmission.end_stop_{side}") for side in ("lower", "upper")]
    lower, upper = (
        infinite if stop is None else stop.value - origin
        for stop, infinite in zip(stops, (-math.inf, math.inf), strict=True)
    )
    stated = model.constants["drive.speed_limit"].source != ABSENT
    faster = faster if stated else min(faster, LARGEST_EFFECT)
    speed = min(faster * limits.speed, MOSTLY * model.value("drive.speed_limit") / ratio)
    unknown = limits.upper - limits.lower
    if shown_motion(model) == "linear":
        unknown = 0.0
    elif stated:
        unknown = max(unknown, min(LARGEST_EFFECT * limits.speed, speed) * _LONG)
    below, above = (unknown if stop is None else speed * _LONG for stop in stops)
    return Limits(
        speed,
        faster * limits.acceleration,
        min(limits.lower, max(-below, (1.0 - SMALL) * lower)),
        max(limits.upper, min(above, (1.0 - SMALL) * upper)),
        min(LARGEST_EFFECT * limits.current, MOSTLY * min(torque, model.value("drive.current_limit"))),
    )
