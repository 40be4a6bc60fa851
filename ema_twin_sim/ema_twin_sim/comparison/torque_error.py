"""Relative torque error: torque that the model needs for the measured motion, against the drive's, zero-phase filtered.

The unexplained torque of a twin is filtered sample by sample, as a live one must be. This is the offline figure used in
papers on identification (force error of Janot, Gautier, Brunot 2019): both sides with the same zero-phase low-pass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..measured.smoothed_motion import full_rate
from ..model import Model
from ..plant.motion import ACCELERATION, MOTOR_CURRENT
from ..simulation.assembly import Assembly, assemble
from ..simulation.required import required_torque

BAND = 50.0
"""Hz, in SI for every machine, because it is part of the definition that published figures use. For EMPS 4.08 % is
published, and ``docs/tutorial_emps.md`` gets 3.89 % (guarded by ``tests/discovery/test_real_machines.py``)."""
ENDS = 2.5  # periods of that band at each end, where the acceleration is unknown
ORDER = 4  # of the Butterworth filter, applied forward and backward


@dataclass(frozen=True)
class TorqueError:
    """Norm of measured minus needed torque over norm of the measured torque: below ``BAND``, and unfiltered."""

    filtered: float
    unfiltered: float
    band: float = BAND  # Hz

    @property
    def is_filtered(self) -> bool:
        """Whether the recording is quick enough for the filter."""
        return self.filtered != self.unfiltered

    def as_json(self) -> dict[str, float]:
        """Shares, not per cent."""
        return {"relative": self.filtered, "relative_unfiltered": self.unfiltered, "band": self.band}


def torque_error(recording: Recording, model: Model) -> TorqueError | None:
    """The relative torque error of a recording; None if signals are missing, or with backlash or compliance.

    None as well if the measured torque is zero all along.
    """
    assembly = assemble(model)
    if assembly.plant[0]["two_inertia"] != 0.0:
        return None
    parts = [norms for part in recording.parts() if (norms := _norms(part, model, assembly)) is not None]
    if not parts:
        return None
    left, measured = parts[0] if len(parts) == 1 else np.linalg.norm(parts, axis=0)
    if not measured.all():
        return None
    unfiltered, filtered = (float(share) for share in left / measured)
    return TorqueError(filtered, unfiltered)


def _norms(recording: Recording, model: Model, assembly: Assembly) -> np.ndarray | None:
    """Norms (2, 2) of measured minus needed torque, and of the measured torque; each unfiltered, and below ``BAND``.

    None if the recording, or piece of one, lacks the required signals.
    """
    plant = assembly.plant[0]
    try:
        motion, period = full_rate(recording, model)
    except InputError:
        return None
    inertia = float(plant["motor_inertia"] + plant["output_inertia"])
    ends = round(ENDS / (BAND * period))
    inside = slice(ends, len(motion) - ends)
    measured = plant["nominal_torque_constant"] * motion[inside, MOTOR_CURRENT]
    needed = required_torque(assembly, recording, motion)[inside] + inertia * motion[inside, ACCELERATION]
    if not len(measured):
        return None
    pairs = [(measured, needed)] * 2
    if 0.5 / period > BAND:
        low = butter(ORDER, BAND, fs=1.0 / period, output="sos")
        every = max(1, round(1.0 / (BAND * period)))  # below the band, samples in between add nothing
        pairs[1] = sosfiltfilt(low, measured)[::every], sosfiltfilt(low, needed)[::every]
    return np.array([[np.linalg.norm(m - n) for m, n in pairs], [np.linalg.norm(m) for m, _ in pairs]])
