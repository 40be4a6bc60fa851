"""Rows of several recordings: built once and never changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..criteria import CORRELATION, MISSHAPEN, NEARLY_ALL, OUTLIER
from ..measured.observation import Observation
from ..plant.motion import SPEED
from .joined_motions import JoinedMotions
from .search_limits import Reached, reached
from .stops import Stops


@dataclass(frozen=True, eq=False, init=False)
class RecordedRows:
    """Rows of several recordings: torque rows of all (s,), then encoder rows of all (e,), together (m,)."""

    observations: tuple[Observation, ...]
    joined: JoinedMotions
    torque: np.ndarray  # (s,) N m
    noise: np.ndarray  # (s,) N m, of the torque
    acceleration: np.ndarray  # (s,) rad/s^2
    acceleration_rest: np.ndarray  # (s,) rad/s^2
    rest_torque: np.ndarray  # (s,) N m, that the model's inertia needs for this rest
    rate: np.ndarray  # (s,) N m/s, of the torque
    encoder: np.ndarray  # (e,) rad, by how much the encoders differ
    encoder_noise: np.ndarray  # (e,) rad
    in_noise: np.ndarray  # (m,) all that was measured, in units of the sensors' noise, less what stops add
    stops: Stops
    samples: int
    size: int  # rows of torque
    rows: int  # of all
    torque_parts: list[slice]  # by recording
    encoder_parts: list[slice]  # by recording
    encoder_pieces: np.ndarray  # int64 (p, 2), first row and end of each piece of a recording between counter jumps
    parts: list[tuple[int, slice]]  # (recording, rows) of all that is measured
    fastest: float  # rad/s, of the motor
    outlier: float  # times the bulk of a residual, where outliers begin
    reached: Reached
    correlation: float  # rows that count as one: neighbours share half their smoothing window; points share nothing

    def __init__(self, observations: Sequence[Observation]) -> None:
        joined = JoinedMotions.of(observations)
        observations = [replace(o, motion=joined.motion[joined.part(k)]) for k, o in enumerate(observations)]
        torque = np.concatenate([o.torque for o in observations])
        noise = np.concatenate([o.torque_noise for o in observations])
        encoder = np.concatenate([o.encoder for o in observations])
        encoder_noise = np.concatenate([o.encoder_noise for o in observations])
        edges = np.cumsum([0, *(len(o.rows) for o in observations)])
        torque_parts = [slice(a, b) for a, b in pairwise(edges)]
        size = int(edges[-1])
        edges = size + np.cumsum([0, *(len(o.encoder_rows) for o in observations)])
        encoder_parts = [slice(a, b) for a, b in pairwise(edges)]
        stops = Stops.of(observations, torque_parts)
        in_noise = stops.taken_out(np.concatenate([torque / noise, encoder / encoder_noise]))
        speeds = np.concatenate([np.abs(o.motion[o.rows, SPEED]) for o in observations])
        vars(self).update(
            observations=tuple(observations),
            joined=joined,
            torque=torque,
            noise=noise,
            acceleration=np.concatenate([o.acceleration for o in observations]),
            acceleration_rest=np.concatenate([o.acceleration_rest for o in observations]),
            rest_torque=np.concatenate([o.inertia * o.acceleration_rest for o in observations]),
            rate=np.concatenate([o.torque_rate for o in observations]),
            encoder=encoder,
            encoder_noise=encoder_noise,
            in_noise=in_noise,
            stops=stops,
            correlation=1.0 if all(o.of_points for o in observations) else CORRELATION,
            samples=len(joined.motion),
            size=size,
            rows=len(in_noise),
            torque_parts=torque_parts,
            encoder_parts=encoder_parts,
            encoder_pieces=_pieces(observations, encoder_parts),
            parts=[
                *enumerate(torque_parts),
                *((k, part) for k, part in enumerate(encoder_parts) if part.stop > part.start),
            ],
            fastest=float(np.quantile(speeds, NEARLY_ALL)) if len(speeds) else 0.0,
            outlier=OUTLIER if any(o.geared for o in observations) else MISSHAPEN,
            reached=reached(observations),
        )

    def noise_of_encoders(self, part: slice) -> np.ndarray:
        """Noise [rad] of some of the encoders' rows; ``part`` counts from the first of all rows."""
        return self.encoder_noise[part.start - self.size : part.stop - self.size]


def _pieces(observations: Sequence[Observation], encoder_parts: Sequence[slice]) -> np.ndarray:
    """First row and end (p, 2) of each piece of the encoders' rows: a recording, or a part of it between jumps."""
    pieces = [
        (part.start + int(a), part.start + int(b))
        for o, part in zip(observations, encoder_parts, strict=True)
        for a, b in pairwise((0, *(np.flatnonzero(np.diff(o.encoder_piece)) + 1), len(o.encoder_piece)))
        if b > a
    ]
    return np.array(pieces, np.int64).reshape(-1, 2)
