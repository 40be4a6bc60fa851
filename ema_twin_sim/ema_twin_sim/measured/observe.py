"""Observe recordings: smooth and differentiate the motion, and choose the rows to judge.

The drive's own smoothing of the speed is undone. A row is not judged near standstill (dry friction has no sign there),
near a gap, or at an end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import CHAOTIC, CORRELATION, COUNTED, LEAST_ROWS, NEGLIGIBLE, SHAKEN, SMALL, STANDSTILL, THROWN
from ..listing import number_of
from ..model import Model
from ..model.own_units import shown
from ..plant.motion import ACCELERATION, LOAD, MOTOR_ANGLE, MOTOR_CURRENT, OUTPUT_ANGLE, SPEED, TIME
from ..reading_noise import FEWEST_READINGS, noise_at_points, reading_noise, reading_step
from ..simulation.angle_origins import origins_of
from ..simulation.operating_points import doubled, motion_at_points
from ..simulation.sensor_noise import counter_noise
from .adaptive_acceleration import adaptive_acceleration
from .bandwidth import narrowest, narrowest_of_speed
from .held_readings import noise_of_held
from .observation import Observation
from .row_noise import encoder_noise, rounding_noise, shaken, torque_noise
from .sliding import moving_maximum
from .smoothed_motion import COUNTER_WIDTH, LEAST_PERIODS, WIDTH, differentiator, even, smoothed_motion, usual_step
from .smoothing import gaussian, smooth, smooth_at
from .spoilt_samples import counter_jumps
from .unjudgeable import refuse_few_points, refuse_incomplete, refuse_unchanging, refuse_undriven, too_little_motion

START = 0.03  # own s at each end that are not judged
JITTER = 2e-4  # own s of possible offset between the two counters' samples, or of an impact
LEAST_NOISE = 1e-6  # of the torque limit: simulated recordings may have no noise at all
WIDER = (2.0, 4.0, 8.0)  # times the usual width of the kernel: tried in turn where the acceleration is noisy
LARGEST = 100.0  # times the largest torque: limit of a drive whose own is not known


def observe(
    recording: Recording, model: Model, widest: float = math.inf, *, bridging: bool = False, wider: float = 1.0
) -> Observation:
    """Prepare a recording for a diagnosis, with a kernel of at most ``widest`` [own s].

    With ``bridging``, the kernel is wide enough for the steps of a log without an even clock; otherwise these are gaps.
    Without a gearbox it is ``wider`` (1 or more) times as wide as usual, or, at 1, as narrow as the sensors allow.

    Raises InputError if a required signal is missing.
    """
    if recording.of_points:
        return _observe_points(recording, model)
    refuse_incomplete(recording, model)
    period, time, signals, apart = even(recording)
    refuse_unchanging(recording, signals, model)
    by_torque = "current" in signals
    raw = recording.signals["current"] if by_torque else np.zeros(len(time))
    signals.setdefault("current", raw)
    width = max(min(WIDTH if "speed" in signals else COUNTER_WIDTH, widest), LEAST_PERIODS * period)
    # without teeth or compliance nothing is shaken, and reversals are as good as any other rows
    geared = model.value("machine.output_inertia") > 0.0
    reading = counter_noise(model, "motor")
    if not geared:
        position = signals["motor_position"]
        reading = max(noise_of_held(reading, position), reading_noise(position))
    if not geared and wider > 1.0:
        width = max(min(wider * width, widest), width)
    elif not geared and "speed" not in signals:
        width = narrowest(signals["motor_position"], period, reading, width, LEAST_PERIODS * period)
    elif not geared:
        smoothing = model.value("sensors.speed_smoothing")
        read = max(model.value("sensors.speed_noise"), reading_noise(signals["speed"]))
        width = narrowest_of_speed(signals["speed"], period, read, smoothing, width, LEAST_PERIODS * period)
    if bridging:
        width = max(width, min(usual_step(recording), widest))
    kernel = gaussian(width, period)
    whole = apart <= max(1.0, (1.0 if bridging else 0.5) * width / period)  # a kernel bridges gaps shorter than itself
    if len(time) < 4 * len(kernel):
        second, _ = shown(model, 1.0, "s")
        raise InputError(
            f"{recording.name}: lasts {second * recording.duration:.3g} s; a diagnosis needs longer ones, so record "
            "longer, or leave it out"
        )
    ratio = model.value("machine.gear_ratio")
    motion, motion_noise = smoothed_motion(signals, time, period, width, model, reading, geared)
    acceleration = motion[:, ACCELERATION]
    constant = model.value("machine.torque_constant")
    drive = constant * signals["current"]
    after = round(2.0 * width / period)
    hit, thrown = (  # the hardest acceleration from so many seconds before each sample
        moving_maximum(np.abs(acceleration), round(before / period), after) if geared else np.zeros(len(time))
        for before in (SHAKEN, THROWN)
    )
    after_impact = thrown > CHAOTIC
    centres = np.arange(len(kernel) // 2, len(time) - len(kernel) // 2, max(1, round(2.0 * width / period)))
    judged = _judged(time, period, whole, kernel)
    slow = np.abs(motion[:, SPEED]) < STANDSTILL
    # without a gearbox, a machine that crosses standstill quickly (within a kernel's inner half) does not stick there
    still = _spread(slow, len(kernel) // 2)
    moving = still == 0.0 if geared else still < _spread(~slow, len(kernel) // 2)
    driven = np.abs(signals["current"]) < (1.0 - NEGLIGIBLE) * min(
        model.value("drive.current_limit"), model.value("drive.torque_limit") / constant
    )
    rows = centres[(judged & moving & driven & by_torque)[centres]]
    white = torque_noise(signals["current"], raw, kernel, model)
    if "load_torque" in signals:
        white = math.hypot(white, reading_noise(signals["load_torque"]) * float(np.linalg.norm(kernel)))
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    noise = math.hypot(white, inertia * motion_noise) * shaken(hit)
    quiet = adaptive_acceleration(
        acceleration[rows],
        rows,
        motion_noise,
        width,
        lambda wide: differentiator(signals, period, wide, model, reading),
        slow | ~whole,
    )
    largest = min(model.value("drive.torque_limit"), LARGEST * float(np.abs(drive).max()))
    noise = np.maximum(noise, LEAST_NOISE * largest)
    parted = _Parted(centres[:0], np.zeros(0), np.zeros(0), centres[:0])
    if "output_position" in signals:
        difference = signals["output_position"] - signals["motor_position"] / ratio
        jumps = _counts_lost(difference, motion[:, SPEED] * period / ratio, model)
        motion[:, OUTPUT_ANGLE] -= np.cumsum(jumps)
        encoder_rows = centres[(judged & (_spread(jumps != 0.0, len(kernel) // 2) == 0.0))[centres]]
        if not after_impact[encoder_rows].all():
            encoder_rows = encoder_rows[~after_impact[encoder_rows]]
        parted = _parted(difference, jumps, encoder_rows, kernel, gaussian(width, period, 1), hit, model)
    motor_origin, output_origin = origins_of(recording, model)
    return Observation(
        name=recording.name,
        period=period,
        geared=geared,
        motion=motion,
        motor_origin=motor_origin,
        output_origin=output_origin,
        kernel=kernel,
        rows=rows,
        torque=_at(drive, kernel, rows),
        torque_rate=smooth(drive, gaussian(width, period, 1))[rows],
        acceleration=quiet,
        acceleration_rest=acceleration[rows] - quiet,
        acceleration_noise=motion_noise,
        inertia=inertia,
        torque_noise=noise[rows],
        torque_reading=min(white, constant * model.value("sensors.current_noise") * float(np.linalg.norm(kernel))),
        torque_step=constant * reading_step(raw),
        coarse=rounding_noise(raw, model, reading_noise(signals["current"])) > 0.0,
        hit=hit,
        after_impact=after_impact,
        encoder_rows=parted.rows,
        encoder=parted.encoder,
        encoder_noise=parted.noise,
        encoder_piece=parted.piece,
    )


class _Parted(NamedTuple):
    """The rows (m,) in which both encoders are judged, their difference and its noise [rad], and the piece between lost
    counts that each is in.
    """

    rows: np.ndarray
    encoder: np.ndarray
    noise: np.ndarray
    piece: np.ndarray


def _counts_lost(difference: np.ndarray, travel: np.ndarray, model: Model) -> np.ndarray:
    """Permanent jumps (n,) of the difference [rad, slow shaft] of both encoders, beyond what their counts explain."""
    count = sum(
        model.turn / model.value(f"sensors.{side}_encoder_counts") / turns
        for side, turns in (("output", 1.0), ("motor", model.value("machine.gear_ratio")))
    )
    return counter_jumps(difference, travel, COUNTED * count)


def _parted(
    difference: np.ndarray,
    jumps: np.ndarray,
    rows: np.ndarray,
    kernel: np.ndarray,
    rate: np.ndarray,
    hit: np.ndarray,
    model: Model,
) -> _Parted:
    """The encoders' ``difference`` (n,), without its ``jumps``, in ``rows`` (m,) that are not near one.

    Smoothed by a ``kernel``; a ``rate`` kernel differentiates it, since both encoders may not be read at one instant.
    """
    difference = difference - np.cumsum(jumps)
    read = encoder_noise(model) * float(np.linalg.norm(kernel)) * shaken(hit)
    noise = np.hypot(read, JITTER * smooth(difference, rate))
    return _Parted(rows, _at(difference, kernel, rows), noise[rows], np.cumsum(jumps != 0.0)[rows])


def _observe_points(recording: Recording, model: Model) -> Observation:
    """Observation of operating points: rows that are judged as recorded, each separately."""
    motion = motion_at_points(recording, model)
    motion = motion[np.isfinite(motion).all(axis=1)]
    if len(motion) < FEWEST_READINGS:
        raise InputError(
            f"{recording.name}: has {number_of(len(motion), 'operating point')}; at least {FEWEST_READINGS} are needed "
            "to see their noise: measure more, or leave the recording out"
        )
    count = len(motion)
    constant = model.value("machine.torque_constant")
    torque = constant * motion[:, MOTOR_CURRENT]
    if not motion[:, [MOTOR_CURRENT, LOAD]].any():  # a load sensor tells the torque of a motor without current
        refuse_unchanging(recording, {"current": motion[:, MOTOR_CURRENT]}, model)
    largest = max(float(np.abs(torque).max()), float(np.abs(motion[:, LOAD]).max()))
    depended_on = [motion[:, column] for column in (MOTOR_ANGLE, SPEED, LOAD)]
    noise = model.value("sensors.current_noise") or noise_at_points(motion[:, MOTOR_CURRENT], depended_on)
    read = constant * noise if torque.any() else noise_at_points(motion[:, LOAD], depended_on[:2])
    motor_origin, output_origin = origins_of(recording, model)
    return Observation(
        name=recording.name,
        period=float(np.median(np.diff(motion[:, TIME]))),
        geared=model.value("machine.output_inertia") > 0.0,
        motion=doubled(motion),
        motor_origin=motor_origin,
        output_origin=output_origin,
        kernel=np.ones(1),
        rows=np.arange(count) * 2 + 1,
        torque=torque,
        torque_rate=np.zeros(count),
        acceleration=np.zeros(count),
        acceleration_rest=np.zeros(count),
        acceleration_noise=0.0,
        inertia=0.0,
        torque_noise=np.full(count, max(read, LEAST_NOISE * largest)),
        torque_reading=constant * model.value("sensors.current_noise"),
        torque_step=0.0,
        coarse=False,
        hit=np.zeros(2 * count),
        after_impact=np.zeros(2 * count, bool),
        encoder_rows=np.zeros(0, np.int64),
        encoder=np.zeros(0),
        encoder_noise=np.zeros(0),
        encoder_piece=np.zeros(0, np.int64),
    )


def _judged_rows(found: Sequence[Observation], recordings: Sequence[Recording]) -> list[np.ndarray]:
    """The rows that are judged; without torque data, the encoder rows."""
    return [o.rows if r.has("current") else o.encoder_rows for o, r in zip(found, recordings, strict=True)]


def observe_all(recordings: list[Recording], model: Model) -> list[Observation]:
    """Observe all recordings. Raises InputError if together they hold too little motion to judge."""
    if not recordings:
        raise InputError("no recording is given; a diagnosis needs at least one")
    # For a slow machine, whose own second is long, the usual kernel would leave few rows of a long recording. Two
    # widths make a row, and CORRELATION rows count as one.
    widest = sum(recording.duration for recording in recordings) / (4.0 * CORRELATION * LEAST_ROWS)
    found = [observe(recording, model, widest) for recording in recordings]
    if any(recording.of_points for recording in recordings):
        refuse_few_points(found)
        return found
    refuse_undriven(found, recordings, model)
    if not found[0].geared and _too_noisy(found):
        found = _quieter(recordings, model, widest) or found
    judged = _judged_rows(found, recordings)
    if sum(map(len, judged)) < LEAST_ROWS:
        with suppress(InputError):  # too short for so wide a kernel: reported as without it
            bridged = [observe(recording, model, widest, bridging=True) for recording in recordings]
            if sum(map(len, _judged_rows(bridged, recordings))) > sum(map(len, judged)):
                found, judged = bridged, _judged_rows(bridged, recordings)
    if sum(map(len, judged)) < LEAST_ROWS:
        raise InputError(too_little_motion(found, judged, recordings, model))
    return found


def _quieter(recordings: Sequence[Recording], model: Model, widest: float) -> list[Observation] | None:
    """The recordings observed by the narrowest kernels that leave the acceleration quiet; None if none does."""
    for wider in WIDER:
        try:
            found = [observe(recording, model, widest, wider=wider) for recording in recordings]
        except InputError:  # one of them is too short for so wide a kernel
            return None
        if sum(len(o.rows) for o in found) < LEAST_ROWS:
            return None
        if not _too_noisy(found):
            return found
    return None


def _too_noisy(found: Sequence[Observation]) -> bool:
    """Whether the noise of the acceleration makes an inertia clearly too small.

    A regression finds it too small by the noise's share in the mean square of the acceleration (errors in variables).
    """
    whole = sum(float(np.sum((o.acceleration + o.acceleration_rest) ** 2)) for o in found)
    noise = sum(o.acceleration_noise**2 * len(o.rows) for o in found)
    return noise > SMALL**2 * (whole - noise)


def _judged(time: np.ndarray, period: float, whole: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Mask (n,) of samples that are neither near an end nor near a gap."""
    margin = len(kernel) // 2 + round(START / period)
    judged = _spread(~whole, len(kernel) // 2) == 0.0
    judged[:margin] = judged[len(time) - margin :] = False
    return judged


def _spread(where: np.ndarray, reach: int) -> np.ndarray:
    """Positive within ``reach`` / 2 samples of true ones: a kernel's outer half has almost no weight."""
    return np.rint(np.convolve(where, np.ones(2 * round(0.5 * reach) + 1), "same"))


def _at(values: np.ndarray, kernel: np.ndarray, rows: np.ndarray) -> np.ndarray:
    smoothed = np.empty(len(rows))
    smooth_at(np.ascontiguousarray(values), kernel, rows, smoothed)
    return smoothed
