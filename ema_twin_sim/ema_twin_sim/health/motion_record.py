"""What the health judgement needs of one run: the measured position, the effort, and the commanded position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import KIND, MAGNITUDE, MAY_BE_MAGNITUDES, Recording
from ema_bench_replay.traces.lacked_columns import lacked_columns
from ema_bench_replay.units import signal_unit

from ..model.matching import way_of
from ..reading_noise import smallest_step

POSITIONS = ("output_position", "motor_position")
SPEED = "speed"
"""Integrated if there is no position."""
_ROUNDING = 1e-9  # of its range: what counting a position from the encoder's zero makes differ


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """One run of a unit, in SI units: positions in m (rad on rotary machines), the effort in A or N m.

    A test is what was set up once: a day, a mounting, a series of repeats. Recordings of one test have more in common
    than recordings of two. An unsigned effort is a magnitude: its size, without its direction.
    """

    name: str
    test: str
    time: np.ndarray  # s (n,), from the first sample on
    position: np.ndarray  # m or rad (n,)
    effort: np.ndarray  # A or N m (n,)
    command: np.ndarray | None = None  # m or rad (n,), as position
    motor_position: np.ndarray | None = None  # rad (n,), if the position is that of another encoder
    position_unit: str = "m"
    effort_unit: str = "A"
    unsigned: bool | None = None  # None: unknown; then the effort itself shows it (``sign_of_effort``)
    place: str = "output_position"  # the signal that the position is, or is integrated from

    def __post_init__(self) -> None:
        for name in ("time", "position", "effort", "command", "motor_position"):
            values = getattr(self, name)
            if values is None:
                continue
            values = np.asarray(values, dtype=np.float64)
            if values.shape != np.shape(self.time) or values.ndim != 1:
                raise ValueError(f"{self.name}: {name} has shape {values.shape}, time has {np.shape(self.time)}")
            object.__setattr__(self, name, values)

    @classmethod
    def from_recording(cls, recording: Recording, test: str) -> MotionRecord:
        """Take the position nearest the load, the current or else the torque, and the commanded position if known.

        Without a position, the speed is integrated; that does not say where a turn begins. Raises InputError if a speed
        is missing too, or an effort.
        """
        places = POSITIONS if recording.of_points else (*POSITIONS, SPEED)
        place = next((name for name in places if recording.has(name)), None)
        effort = recording.drive
        if place is None or effort is None:
            lacks = "position and no speed" if place is None else "current and no motor_torque"
            lacked = lacked_columns(recording, places if place is None else MAY_BE_MAGNITUDES)
            raise InputError(f"{recording.name}: holds no {lacks}, by which health is judged; {lacked or 'record it'}")
        signals = recording.signals
        both = place == "output_position" and recording.has("motor_position")
        origins = {"output_position": recording.output_angle_origin, "motor_position": recording.motor_angle_origin}
        origin = origins.get(place, np.nan)
        shift = 0.0 if np.isnan(origin) else origin  # waves are counted from the encoder's zero
        position = way_of(signals[SPEED], recording.time) if place == SPEED else signals[place] + shift
        kind = recording.metadata.get(f"{effort}{KIND}")
        command = None if place == SPEED else signals.get("output_command")
        return cls(
            name=recording.name,
            test=test,
            time=recording.time,
            position=position,
            effort=signals[effort],
            command=None if command is None else command + shift,
            motor_position=signals["motor_position"] if both else None,
            position_unit=signal_unit(place, recording.motion).removesuffix("/s"),
            effort_unit=signal_unit(effort, recording.motion),
            place=place,
            unsigned=None if kind is None else kind == MAGNITUDE,
        )


def sensor_step(values: np.ndarray) -> float:
    """The smallest step of a sensor's readings (n,), in their unit."""
    return smallest_step(values, _ROUNDING)


def rounding_scatter(values: np.ndarray) -> float:
    """The scatter of rounding a sensor's readings (n,) to its smallest step."""
    return sensor_step(values) / float(np.sqrt(12.0))
