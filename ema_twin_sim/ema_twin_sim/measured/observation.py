"""What was observed in a recording, ready to be explained: the measured motion, the drive's torque, the encoders'
difference, and the rows (instants) at which they are judged.

Measured and predicted values go through the same Gaussian kernel, so nothing is lost by it; the drive's own smoothing
of the speed is undone. A row is not judged near standstill (dry friction has no sign there), near a gap, or at an end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import (
    CHAOTIC,
    CORRELATION,
    COUNTED,
    HARD,
    LEAST_ROWS,
    NEARLY_ALL,
    NEGLIGIBLE,
    SHAKEN,
    STANDSTILL,
    THROWN,
)
from ..model import Model
from ..model.own_units import shown
from ..plant.measured_motion import ACCELERATION, MOTOR_CURRENT, OUTPUT_ANGLE, SPEED, TIME
from ..reading_noise import reading_noise
from ..simulation.angle_origins import origins_of
from ..simulation.behind_motor import of_encoders_alone
from ..simulation.operating_points import FEWEST as FEWEST_POINTS
from ..simulation.operating_points import doubled, motion_at_points
from ..simulation.sensor_noise import counter_noise
from ..simulation.simulate import LONGEST_GAP
from .bandwidth import narrowest
from .sliding import moving_maximum
from .smoothed_motion import COUNTER_WIDTH, FEWEST, LEAST_PERIODS, NEEDED, WIDTH, even, smoothed_motion
from .smoothing import gaussian, smooth, smooth_at
from .spoilt_samples import counter_jumps

START = 0.03  # own s at the ends that are not judged
JITTER = 2e-4  # own s by which the two counters' samples, or an impact, may be apart
LEAST_NOISE = 1e-6  # of the torque limit: simulated recordings may have no noise at all
LARGEST = 100.0  # times the largest torque: the limit of a drive whose own is not known


@dataclass(frozen=True, eq=False)
class Observation:
    """One recording as a diagnosis sees it: n samples at full rate, m rows of torque, k rows of the encoders.

    Torques are in N m at the fast shaft, noises are standard deviations.
    """

    name: str
    period: float  # s
    geared: bool  # whether something stands behind teeth or a spring
    motion: np.ndarray  # (n, 7) with the columns MOTION
    motor_origin: float  # rad, the motor counter's own angle where its position is zero
    output_origin: float  # rad, the same of the output encoder
    kernel: np.ndarray
    rows: np.ndarray  # int64 (m,), the samples at which the torque is judged
    torque: np.ndarray  # (m,) nominal torque constant times current, smoothed
    torque_rate: np.ndarray  # (m,) its slope, N m/s
    acceleration: np.ndarray  # (m,) rad/s2, smoothed by the same kernel
    torque_noise: np.ndarray  # (m,)
    torque_step: float  # N m, between two readings of the current next to each other
    coarse: bool  # whether the current's steps are wide beside its noise: neighbouring rows are rounded alike
    hit: np.ndarray  # (n,) rad/s2, the hardest acceleration shortly before; zero where nothing can be shaken
    after_impact: np.ndarray  # bool (n,), a harder one before: an output with play rests anywhere
    encoder_rows: np.ndarray  # int64 (k,), the samples at which the encoders' difference is judged
    encoder: np.ndarray  # (k,) rad of the slow shaft: output encoder minus motor counter over ratio, smoothed
    encoder_noise: np.ndarray  # (k,)
    encoder_piece: np.ndarray  # int64 (k,), rises by one where the difference jumps: a piece has its own offset

    @property
    def below_shock_limit(self) -> np.ndarray:
        """Whether (m,) no hard acceleration was shortly before a row of torque."""
        return self.hit[self.rows] < HARD

    @property
    def shaken(self) -> np.ndarray:
        """By how many times (n,) the noise is larger for what has been hit."""
        return _shaken(self.hit)

    @property
    def of_points(self) -> bool:
        """Whether rows are operating points, each by itself."""
        return len(self.kernel) == 1

    def without_encoders(self) -> Observation:
        """The torque alone."""
        none = np.zeros(0)
        return replace(
            self,
            encoder_rows=self.encoder_rows[:0],
            encoder=none,
            encoder_noise=none,
            encoder_piece=self.encoder_piece[:0],
        )

    def window(self, first: int, last: int) -> Observation:
        """The samples from ``first`` to before ``last``; times stay as they are."""
        reach = len(self.kernel) // 2  # a row looks so far to both sides
        rows = (self.rows >= first + reach) & (self.rows < last - reach)
        encoder = (self.encoder_rows >= first + reach) & (self.encoder_rows < last - reach)
        return replace(
            self,
            motion=np.ascontiguousarray(self.motion[first:last]),
            rows=self.rows[rows] - first,
            torque=self.torque[rows],
            torque_rate=self.torque_rate[rows],
            acceleration=self.acceleration[rows],
            torque_noise=self.torque_noise[rows],
            hit=self.hit[first:last],
            after_impact=self.after_impact[first:last],
            encoder_rows=self.encoder_rows[encoder] - first,
            encoder=self.encoder[encoder],
            encoder_noise=self.encoder_noise[encoder],
            encoder_piece=self.encoder_piece[encoder],
        )


def observe(recording: Recording, model: Model, widest: float = math.inf, *, bridging: bool = False) -> Observation:
    """Take from a recording what a diagnosis needs, through a kernel of a width of ``widest`` [own s] at most.

    Where ``bridging``, the kernel is wide enough for the steps of a log without an even clock, which are gaps else.

    Raises InputError where it lacks a signal that all stands on.
    """
    if recording.of_points:
        return _observe_points(recording, model)
    missing = _missing(recording)
    if missing:
        raise InputError(
            f"{recording.name}: has no {' and no '.join(missing)}; without it no missing effect can be told "
            f"(it holds {', '.join(recording.signals)})"
        )
    if len(recording) < FEWEST:
        raise InputError(f"{recording.name}: {len(recording)} samples are too few to tell anything")
    second, _ = shown(model, 1.0, "s")
    longest = max(recording.gaps, key=lambda gap: gap.duration, default=None)
    if longest is not None and second * longest.duration > LONGEST_GAP:
        raise InputError(
            f"{recording.name}: {second * longest.duration:.4g} s are missing at {second * longest.time:.4g} s; "
            "cut it there (--to, --from)"
        )
    period, time, signals, apart = even(recording)
    by_torque = "current" in signals
    if not by_torque:
        if np.ptp(signals["output_position"]) == 0.0:
            raise InputError(
                f"{recording.name}: its output_position never changes while the motor turns; is the encoder connected, "
                "and is that the right column of the trace?"
            )
        signals["current"] = np.zeros(len(time))
    elif np.ptp(signals["current"]) == 0.0:
        raise InputError(
            f"{recording.name}: its current is {shown(model, signals['current'][0], 'A')[0]:g} A all along; is that "
            "the right column of the trace? Name it in the import map"
        )
    width = max(min(WIDTH if "speed" in signals else COUNTER_WIDTH, widest), LEAST_PERIODS * period)
    # where nothing stands behind teeth or a spring, nothing is shaken, and reversals are as good as anything else
    geared = model.value("machine.output_inertia") > 0.0
    reading = max(counter_noise(model, "motor"), 0.0 if geared else reading_noise(signals["motor_position"]))
    if not geared and "speed" not in signals:
        width = narrowest(signals["motor_position"], period, reading, width, LEAST_PERIODS * period)
    if bridging:
        width = max(width, min(2.0 * _usual_step(recording), widest))
    kernel = gaussian(width, period)
    whole = apart <= max(1.0, 0.5 * width / period)  # a kernel bridges what is much shorter than itself
    if len(time) < 4 * len(kernel):
        raise InputError(f"{recording.name}: lasts {second * recording.duration:.3g} s; a diagnosis needs longer ones")
    ratio = model.value("machine.gear_ratio")
    motion, motion_noise = smoothed_motion(signals, time, period, width, model, reading, geared)
    acceleration = motion[:, ACCELERATION]
    drive = model.value("machine.torque_constant") * signals["current"]
    hit, thrown = (geared * _hardest(acceleration, before, 2.0 * width, period) for before in (SHAKEN, THROWN))
    after_impact = thrown > CHAOTIC
    centres = np.arange(len(kernel) // 2, len(time) - len(kernel) // 2, max(1, round(2.0 * width / period)))
    judged = _judged(time, period, whole, kernel)
    slow = np.abs(motion[:, SPEED]) < STANDSTILL
    # a machine without gearbox that passes quickly through standstill within a kernel's inner half does not stick there
    still = _spread(slow, len(kernel) // 2)
    moving = still == 0.0 if geared else still < _spread(~slow, len(kernel) // 2)
    driven = np.abs(signals["current"]) < (1.0 - NEGLIGIBLE) * min(
        model.value("drive.current_limit"), model.value("drive.torque_limit") / model.value("machine.torque_constant")
    )
    rows = centres[(judged & moving & driven & by_torque)[centres]]
    white = _torque_noise(signals["current"], recording.signals["current"], kernel, model) if by_torque else 0.0
    if "load_torque" in signals:
        white = math.hypot(white, reading_noise(signals["load_torque"]) * float(np.linalg.norm(kernel)))
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    noise = math.hypot(white, inertia * motion_noise) * _shaken(hit)
    largest = min(model.value("drive.torque_limit"), LARGEST * float(np.abs(drive).max()))
    noise = np.maximum(noise, LEAST_NOISE * largest)
    output = signals.get("output_position")
    difference = np.zeros(len(time)) if output is None else output - signals["motor_position"] / ratio
    count = sum(  # rad of the slow shaft, of both counters
        model.turn / model.value(f"sensors.{side}_encoder_counts") / turns
        for side, turns in (("output", 1.0), ("motor", ratio))
    )
    jumps = counter_jumps(difference, motion[:, SPEED] * period / ratio, COUNTED * count)
    breaks = jumps != 0.0
    motion[:, OUTPUT_ANGLE] -= np.cumsum(jumps)
    difference = difference - np.cumsum(jumps)
    whole_encoder = judged & (_spread(breaks, len(kernel) // 2) == 0.0)
    encoder_rows = centres[whole_encoder[centres]] if output is not None else centres[:0]
    if not after_impact[encoder_rows].all():
        encoder_rows = encoder_rows[~after_impact[encoder_rows]]
    parting = np.hypot(
        _encoder_noise(model) * float(np.linalg.norm(kernel)) * _shaken(hit),
        JITTER * smooth(difference, gaussian(width, period, 1)),
    )
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
        acceleration=acceleration[rows],
        torque_noise=noise[rows],
        torque_step=model.value("machine.torque_constant") * _step(recording.signals["current"]) if by_torque else 0.0,
        coarse=by_torque and _resolution(recording.signals["current"], model, reading_noise(signals["current"])) > 0.0,
        hit=hit,
        after_impact=after_impact,
        encoder_rows=encoder_rows,
        encoder=_at(difference, kernel, encoder_rows),
        encoder_noise=parting[encoder_rows],
        encoder_piece=np.cumsum(breaks)[encoder_rows],
    )


def _usual_step(recording: Recording) -> float:
    """The step [s] that nearly all steps between samples keep to, in whole sample periods.

    A computer that logs beside other work keeps no even rate: its longer steps are no gaps, and a kernel that spans two
    of them bridges each. Where a clock gives the samples and a few are missing, it is the sample period.
    """
    steps = np.diff(recording.stamps) * 1e-9
    return float(np.rint(np.quantile(steps, NEARLY_ALL) / recording.sample_period)) * recording.sample_period


def _observe_points(recording: Recording, model: Model) -> Observation:
    """Operating points: rows that are judged as they are, each by itself."""
    motion = motion_at_points(recording, model)
    motion = motion[np.isfinite(motion).all(axis=1)]
    if len(motion) < FEWEST_POINTS:
        raise InputError(f"{recording.name}: {len(motion)} operating points are too few to tell anything")
    count = len(motion)
    constant = model.value("machine.torque_constant")
    torque = constant * motion[:, MOTOR_CURRENT]
    noise = model.value("sensors.current_noise") or reading_noise(motion[:, MOTOR_CURRENT])
    nowhere = np.zeros(0)
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
        torque_noise=np.full(count, max(constant * noise, LEAST_NOISE * float(np.abs(torque).max()))),
        torque_step=0.0,
        coarse=False,
        hit=np.zeros(2 * count),
        after_impact=np.zeros(2 * count, bool),
        encoder_rows=np.zeros(0, np.int64),
        encoder=nowhere,
        encoder_noise=nowhere,
        encoder_piece=np.zeros(0, np.int64),
    )


def _judged_rows(found: Sequence[Observation], recordings: Sequence[Recording]) -> list[np.ndarray]:
    """The rows that are judged: where no torque was measured, those of the encoders' difference."""
    return [o.rows if r.has("current") else o.encoder_rows for o, r in zip(found, recordings, strict=True)]


def _missing(recording: Recording) -> list[str]:
    """The signals without which a recording of a motion tells nothing: a torque, or the output beside the motor."""
    missing = [name for name in NEEDED if not recording.has(name)]
    return missing if recording.has("current") or of_encoders_alone(recording) else ["current", *missing]


def observe_all(recordings: list[Recording], model: Model) -> list[Observation]:
    """All recordings. Raises InputError where together they hold too little motion to judge anything."""
    if not recordings:
        raise InputError("no recording is given; a diagnosis needs at least one")
    # of a machine that creeps, whose own second is long, a usual kernel would leave a few rows of a long recording; two
    # widths make a row, and some rows count as one
    widest = sum(recording.duration for recording in recordings) / (2.0 * CORRELATION * LEAST_ROWS)
    found = [observe(recording, model, widest) for recording in recordings]
    if any(recording.of_points for recording in recordings):
        return found
    judged = _judged_rows(found, recordings)
    if sum(map(len, judged)) < LEAST_ROWS:
        with suppress(InputError):  # too short for so wide a kernel: it is told of what it holds without one
            bridged = [observe(recording, model, widest, bridging=True) for recording in recordings]
            if sum(map(len, _judged_rows(bridged, recordings))) > sum(map(len, judged)):
                found, judged = bridged, _judged_rows(bridged, recordings)
    moving = sum(
        len(rows) * o.period * float(np.diff(rows).min(initial=len(o.motion)))
        for o, rows in zip(found, judged, strict=True)
    )
    standstill, unit = shown(model, STANDSTILL, "rad/s")
    if sum(map(len, judged)) < LEAST_ROWS:
        raise InputError(
            f"{', '.join(o.name for o in found)}: {shown(model, moving, 's')[0]:.2g} s of motion faster than "
            f"{standstill:.2g} {unit} at the motor; a diagnosis needs more of it: record longer, or move faster"
            f"{_without_clock(recordings, model)}"
        )
    return found


def _without_clock(recordings: list[Recording], model: Model) -> str:
    """What an uneven rate of samples costs, and the remedy; empty where all have a clock."""
    uneven = next((r for r in recordings if not r.of_points and _usual_step(r) > r.sample_period), None)
    if uneven is None:
        return ""
    usual, long = (1e3 * shown(model, step, "s")[0] for step in (uneven.sample_period, _usual_step(uneven)))
    return (
        f", or log at an even rate: {uneven.name}'s samples come {usual:.3g} ms apart, and often {long:.3g} ms or more"
    )


def _judged(time: np.ndarray, period: float, whole: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Samples (n,) that are neither near an end nor near a gap."""
    margin = len(kernel) // 2 + round(START / period)
    judged = _spread(~whole, len(kernel) // 2) == 0.0
    judged[:margin] = judged[len(time) - margin :] = False
    return judged


def _spread(where: np.ndarray, reach: int) -> np.ndarray:
    """Above zero within ``reach`` / 2 samples of where it is true: the kernel's outer half weighs next to nothing."""
    return np.rint(np.convolve(where, np.ones(2 * round(0.5 * reach) + 1), "same"))


def _shaken(hit: np.ndarray) -> np.ndarray:
    """By how many times (n,) the noise is larger after the hardest acceleration (n,) [rad/s²] shortly before."""
    return np.sqrt(1.0 + (hit / HARD) ** 2)


def _hardest(acceleration: np.ndarray, before: float, after: float, period: float) -> np.ndarray:
    """The largest acceleration (n,) from ``before`` [s] before each sample to ``after`` [s] after it."""
    return moving_maximum(np.abs(acceleration), round(before / period), round(after / period))


def _torque_noise(current: np.ndarray, raw: np.ndarray, kernel: np.ndarray, model: Model) -> float:
    """Standard deviation [N m] of a smoothed current's torque: its white noise and its resolution.

    Steps that are wide beside the noise are not white: smoothing takes nothing of them away. They are those of the
    ``raw`` values, as they stand in the recording: between samples that were filled in, there are no steps.
    """
    smoothed = float(np.linalg.norm(kernel))
    resolution = _resolution(raw, model)
    white = max(reading_noise(current), model.value("sensors.current_noise") if resolution else 0.0)
    return model.value("machine.torque_constant") * math.hypot(white * smoothed, resolution)


def _resolution(raw: np.ndarray, model: Model, read: float = 0.0) -> float:
    """Standard deviation [A] of what a current's steps round off; zero where they are no wider than its noise.

    That is the model's, or what was ``read`` off the recording where the model tells of none.
    """
    step = _step(raw)
    return step / math.sqrt(12.0) if step > 2.0 * max(model.value("sensors.current_noise"), read) else 0.0


def _step(raw: np.ndarray) -> float:
    """The least difference of two readings."""
    levels = np.unique(raw[np.isfinite(raw)])
    return float(np.diff(levels).min()) if len(levels) > 1 else 0.0


def _encoder_noise(model: Model) -> float:
    """Standard deviation [rad, slow shaft] of the difference of both encoders."""
    return math.hypot(counter_noise(model, "output"), counter_noise(model, "motor") / model.value("machine.gear_ratio"))


def _at(values: np.ndarray, kernel: np.ndarray, rows: np.ndarray) -> np.ndarray:
    smoothed = np.empty(len(rows))
    smooth_at(np.ascontiguousarray(values), kernel, rows, smoothed)
    return smoothed
