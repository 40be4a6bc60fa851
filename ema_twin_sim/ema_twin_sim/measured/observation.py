"""Observation: the measured motion of a recording, the drive torque, the encoder difference, and the rows to judge.

Rows are the instants at which torque and encoder difference are judged. Measured and predicted values go through the
same Gaussian kernel, so nothing is lost by it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..criteria import HARD
from .row_noise import shaken


@dataclass(frozen=True, eq=False)
class Observation:
    """One recording as used in a diagnosis: n samples at full rate, m torque rows, k encoder rows.

    Torques are in N m at the fast shaft, noises are standard deviations.
    """

    name: str
    period: float  # s
    geared: bool  # whether an output inertia follows the gear teeth or a compliant shaft
    motion: np.ndarray  # (n, 7) with the columns MOTION
    motor_origin: float  # rad, angle of the motor counter where its position is zero
    output_origin: float  # rad, the same of the output encoder
    kernel: np.ndarray
    rows: np.ndarray  # int64 (m,), samples at which the torque is judged
    torque: np.ndarray  # (m,) nominal torque constant times current, smoothed
    torque_rate: np.ndarray  # (m,) its slope, N m/s
    acceleration: np.ndarray  # (m,) rad/s2, smoothed as widely as its noise allows: what an inertia is fitted to
    acceleration_rest: np.ndarray  # (m,) rad/s2, what a kernel as narrow as the torque's has beside it
    acceleration_noise: float  # rad/s2, what the sensor's noise leaves in both together
    inertia: float  # kg m2, of the model, which acts on that rest if nothing lies between motor and output
    torque_noise: np.ndarray  # (m,)
    torque_reading: float  # N m, the part of it that its sensors leave, no more than the model says
    torque_step: float  # N m, between adjacent readings of the current
    coarse: bool  # current steps are wide relative to its noise: neighbouring rows round alike
    hit: np.ndarray  # (n,) rad/s2, largest acceleration shortly before; zero without gearing
    after_impact: np.ndarray  # bool (n,), after an impact: an output with backlash may rest anywhere
    encoder_rows: np.ndarray  # int64 (k,), samples at which the encoder difference is judged
    encoder: np.ndarray  # (k,) rad of the slow shaft: output encoder minus motor counter over ratio, smoothed
    encoder_noise: np.ndarray  # (k,)
    encoder_piece: np.ndarray  # int64 (k,), +1 where the difference jumps: each piece has its own offset

    @property
    def below_shock_limit(self) -> np.ndarray:
        """Mask (m,) of the torque rows without hard acceleration shortly before."""
        return self.hit[self.rows] < HARD

    @property
    def shaken(self) -> np.ndarray:
        """Factor (n,) on the noise after hard acceleration."""
        return shaken(self.hit)

    @property
    def of_points(self) -> bool:
        """Whether rows are operating points, each judged separately."""
        return len(self.kernel) == 1

    def without_encoders(self) -> Observation:
        """The observation with torque rows only."""
        rows, none = self.encoder_rows[:0], np.zeros(0)
        return replace(self, encoder_rows=rows, encoder=none, encoder_noise=none, encoder_piece=rows)

    def window(self, first: int, last: int) -> Observation:
        """The samples from ``first`` up to ``last`` (exclusive); times are unchanged."""
        reach = len(self.kernel) // 2  # a row uses samples this far to both sides
        rows = (self.rows >= first + reach) & (self.rows < last - reach)
        encoder = (self.encoder_rows >= first + reach) & (self.encoder_rows < last - reach)
        return replace(
            self,
            motion=np.ascontiguousarray(self.motion[first:last]),
            rows=self.rows[rows] - first,
            torque=self.torque[rows],
            torque_rate=self.torque_rate[rows],
            acceleration=self.acceleration[rows],
            acceleration_rest=self.acceleration_rest[rows],
            torque_noise=self.torque_noise[rows],
            hit=self.hit[first:last],
            after_impact=self.after_impact[first:last],
            encoder_rows=self.encoder_rows[encoder] - first,
            encoder=self.encoder[encoder],
            encoder_noise=self.encoder_noise[encoder],
            encoder_piece=self.encoder_piece[encoder],
        )
