"""A recording: the named signals of one run of a machine, immutable."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import (
    is_long,
    median,
    overlapping,
    pieces,
    shifted,
    spread_pieces,
    steps_where,
    times,
)
from ema_bench_replay.units import MOTIONS, SIGNALS

#: Signals that may refer to the output shaft. Then the recording's metadata hold "output" under the signal's name + AT.
AT_EITHER_SHAFT = ("motor_position", "speed", "speed_setpoint", "motor_torque", "load_torque")
AT = "_at"

#: Signals that may be a magnitude without sign. If the import map says whether they are, the recording's metadata hold
#: "magnitude" or "signed" under the signal's name + KIND.
MAY_BE_MAGNITUDES = ("current", "motor_torque")
KIND = "_kind"
MAGNITUDE, SIGNED = "magnitude", "signed"

#: If a file has none of the columns from which its import map reads a position, the speed, the current or the torque,
#: the recording's metadata hold their names under the signal's name + LACKED.
LACKED = "_lacked"

#: Key of a recording's metadata: the test (a day, a mounting) that the run belongs to.
TEST = "test"

#: Fields of a recording: reading of each encoder at its position's zero, rad.
ANGLE_ORIGINS = ("motor_angle_origin", "output_angle_origin")

#: Keys of a recording's metadata: the kind of motion ("linear"; rotary if absent), and "yes" if its samples are
#: operating points.
MOTION = "motion"
POINTS = "operating_points"

#: Stamp of the first sample if a recording has no date; ROS reads time 0 as "not set".
NO_DATE = 1_000_000_000

# A step longer than this many sample periods means lost samples.
_GAP_FACTOR = 1.5


class Gap(NamedTuple):
    """Samples that are missing in the middle of a recording."""

    time: float  # s, last sample before the gap
    duration: float  # s, from that sample to the next one
    missing: int  # number of missing samples


@dataclass(frozen=True, eq=False)
class Recording:
    """One run of a machine (or of its twin). Signals are read-only and in SI units (m, m/s, N on linear machines).

    Raises ValueError if the parts are inconsistent: that is a programming error, not a user error.
    """

    name: str  # stem of the file it came from
    stamps: np.ndarray  # int64 (n,): ns since the first sample, strictly increasing from 0
    signals: Mapping[str, np.ndarray]  # float64 (n,) each; a signal that the machine lacks is absent
    start: int = NO_DATE  # ns of the first sample since the epoch
    motor_angle_origin: float = np.nan  # rad: reading of the motor counter at motor_position zero
    output_angle_origin: float = np.nan  # rad: the same for the output encoder
    metadata: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        stamps = _frozen(self.stamps, np.int64)
        if stamps.ndim != 1 or not stamps.size or stamps[0] != 0 or not _rise(stamps):
            raise ValueError(f"{self.name}: stamps must be one-dimensional and rise strictly from 0")
        signals = {name: _frozen(values, np.float64) for name, values in self.signals.items()}
        for name, values in signals.items():
            if name not in SIGNALS:
                raise ValueError(f"{self.name}: no signal is called {name!r}")
            if values.shape != stamps.shape:
                raise ValueError(f"{self.name}: {name} has shape {values.shape}, stamps have {stamps.shape}")
        object.__setattr__(self, "stamps", stamps)
        in_order = {name: signals[name] for name in SIGNALS if name in signals}
        object.__setattr__(self, "signals", MappingProxyType(in_order))
        object.__setattr__(self, "metadata", MappingProxyType(dict(self.metadata)))
        object.__setattr__(self, "warnings", tuple(self.warnings))

    def __len__(self) -> int:
        return self.stamps.size

    def __reduce__(self) -> tuple[object, ...]:
        # mapping proxies cannot be pickled, and recordings are sent to worker processes
        values = (self.name, self.stamps, dict(self.signals), self.start, self.motor_angle_origin)
        return Recording, (*values, self.output_angle_origin, dict(self.metadata), self.warnings)

    @cached_property
    def time(self) -> np.ndarray:
        """Seconds since the first sample, float64 (n,)."""
        return _frozen(times(self.stamps, 1e-9), np.float64)

    @property
    def motion(self) -> str:
        """Kind of motion, rotary or linear: positions in rad or m."""
        return self.metadata.get(MOTION, MOTIONS[0])

    @property
    def of_points(self) -> bool:
        """Whether each sample is a separate operating point: at rest, or at constant speed."""
        return POINTS in self.metadata

    @property
    def duration(self) -> float:
        """Seconds from the first sample to the last."""
        return float(self.stamps[-1]) * 1e-9

    @cached_property
    def sample_period(self) -> float:
        """The median step between two samples, s; NaN if there is only one sample."""
        return median(lambda: map(np.diff, overlapping(self.stamps))) * 1e-9

    @cached_property
    def gaps(self) -> tuple[Gap, ...]:
        """Where samples are missing: steps longer than one and a half sample periods. Operating points have no gaps."""
        if self.of_points:
            return ()
        period = self.sample_period
        places = steps_where(lambda steps: steps * 1e-9 > _GAP_FACTOR * period, self.stamps)
        times, steps = (
            values * 1e-9 for values in (self.stamps[places], self.stamps[places + 1] - self.stamps[places])
        )
        return tuple(
            Gap(float(time), float(step), round(step / period) - 1) for time, step in zip(times, steps, strict=True)
        )

    @property
    def origins(self) -> dict[str, float]:
        """Both angle origins by their names."""
        return {name: float(getattr(self, name)) for name in ANGLE_ORIGINS}

    @property
    def drive(self) -> str | None:
        """The signal that tells what the motor gives: the current, or else its torque; None if there is neither."""
        return next((name for name in MAY_BE_MAGNITUDES if self.has(name)), None)

    def has(self, *names: str) -> bool:
        """Whether all these signals are there."""
        return all(name in self.signals for name in names)

    def between(self, start: float | None = None, end: float | None = None) -> Recording:
        """The samples from `start` to `end` (s since the first sample, both included; None: no limit on that side).

        Stamps begin at 0 again, and so do both positions (see `from_zero`).
        """
        first = 0 if start is None else np.searchsorted(self.stamps, self._stamp(start))
        last = len(self) if end is None else np.searchsorted(self.stamps, self._stamp(end), side="right")
        if first >= last:
            span = f"{start or 0.0:g} s to {self.duration if end is None else end:g} s"
            raise InputError(f"{self.name}: no sample from {span}; it lasts from 0 s to {self.duration:g} s")
        return self if last - first == len(self) else self._part(int(first), int(last))

    def parts(self) -> Iterator[Recording]:
        """A long recording piece by piece, each cut as by `between`; a short one as a single part."""
        for rows in pieces(len(self)):
            yield self._part(rows.start, rows.stop) if rows.stop - rows.start < len(self) else self

    def spread(self) -> list[Recording]:
        """Some evenly spaced pieces of a long recording, small enough for memory; a short recording unchanged.

        For questions that a part answers as well as the whole: a scale, a mistaken unit.
        """
        if not is_long(len(self)):
            return [self]
        return [self._part(rows.start, rows.stop) for rows in spread_pieces(len(self))]

    def _part(self, first: int, last: int) -> Recording:
        """Samples from index `first` up to, not including, `last`; stamps and positions begin at 0."""
        part = replace(
            self,
            stamps=shifted(self.stamps[first:last], -self.stamps[first]),
            signals={name: values[first:last] for name, values in self.signals.items()},
            start=self.start + int(self.stamps[first]),
        )
        return part.from_zero()

    def from_zero(self) -> Recording:
        """The same with both positions beginning at 0; the offset is added to their angle origins.

        output_command is shifted like output_position, since both have the same zero.
        """
        signals = dict(self.signals)
        shift = {name: _first(signals[name]) for name in ("motor_position", "output_position") if name in signals}
        if not any(shift.values()):
            return self
        for name, origin in (("motor_position",) * 2, ("output_position",) * 2, ("output_command", "output_position")):
            if name in signals and origin in shift:
                signals[name] = shifted(signals[name], -shift[origin])
        return replace(
            self,
            signals=signals,
            motor_angle_origin=moved_origin(self.motor_angle_origin, shift.get("motor_position", 0.0)),
            output_angle_origin=moved_origin(self.output_angle_origin, shift.get("output_position", 0.0)),
        )

    def _stamp(self, time: float) -> int:
        """The stamp, ns, of a time in s, or one just outside the recording."""
        if not math.isfinite(time):
            raise InputError(f"{self.name}: {time} s is no time to cut at; it lasts from 0 s to {self.duration:g} s")
        return round(min(max(time, -1.0), self.duration + 1.0) * 1e9)


def moved_origin(origin: float, shift: float) -> float:
    """An angle origin, rad, after its position was reduced by `shift`.

    If the origin was unknown, a position that did not begin at zero is taken as the encoder's reading.
    """
    return shift if math.isnan(origin) and shift else origin + shift


def _rise(stamps: np.ndarray) -> bool:
    return not any((part[1:] <= part[:-1]).any() for part in overlapping(stamps))


def _first(values: np.ndarray) -> float:
    """The first finite value; 0 if there is none."""
    for rows in pieces(len(values)):
        known = values[rows][np.isfinite(values[rows])]
        if known.size:
            return float(known[0])
    return 0.0


def spread(recordings: Iterable[Recording]) -> list[Recording]:
    """The recordings, long ones replaced by some of their pieces (see `Recording.spread`)."""
    return [part for recording in recordings for part in recording.spread()]


def refuse_points(recording: Recording) -> None:
    """Raise InputError if a recording holds operating points, which have no time order."""
    if recording.of_points:
        raise InputError(
            f"{recording.name}: holds operating points, no run to be played; compare, fit and discover take them"
        )


def _frozen(values: np.ndarray, kind: type) -> np.ndarray:
    """The values as a read-only array of that dtype; a writable array becomes a read-only view."""
    array: np.ndarray = np.asarray(values, dtype=kind)
    if array.flags.writeable:
        array = array.view()
        array.flags.writeable = False
    return array
