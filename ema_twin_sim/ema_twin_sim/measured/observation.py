"""Observation: the measured motion of a recording, the drive torque, the encoder difference, and the rows to judge.

Rows are the instants at which torque and encoder difference are judged. Measured and predicted values go through the
same Gaussian kernel, so nothing is lost by it; the drive's own smoothing of the speed is undone. A row is not judged
near standstill (dry friction has no sign there), near a gap, or at an end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.lacked_columns import lacked_columns

from ..criteria import (
    CHAOTIC,
    CORRELATION,
    COUNTED,
    FAR_OUT,
    HARD,
    LEAST_ROWS,
    NEARLY_ALL,
    NEGLIGIBLE,
    SHAKEN,
    SMALL,
    STANDSTILL,
    THROWN,
)
from ..listing import first_of
from ..model import Model
from ..model.own_units import shown
from ..plant.measured_motion import ACCELERATION, MOTOR_CURRENT, OUTPUT_ANGLE, SPEED, TIME
from ..quantities import quantity
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

START = 0.03  # own s at each end that are not judged
JITTER = 2e-4  # own s of possible offset between the two counters' samples, or of an impact
LEAST_NOISE = 1e-6  # of the torque limit: simulated recordings may have no noise at all
LARGEST = 100.0  # times the largest torque: limit of a drive whose own is not known
HELD = (
    "; a test of stiffness, held at each load, is read as operating points: `operating_points: true` in its map, or "
    "init --operating-points"
)


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
    acceleration: np.ndarray  # (m,) rad/s2, smoothed by the same kernel
    torque_noise: np.ndarray  # (m,)
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
        return _shaken(self.hit)

    @property
    def of_points(self) -> bool:
        """Whether rows are operating points, each judged separately."""
        return len(self.kernel) == 1

    def without_encoders(self) -> Observation:
        """The observation with torque rows only."""
        none = np.zeros(0)
        return replace(
            self,
            encoder_rows=self.encoder_rows[:0],
            encoder=none,
            encoder_noise=none,
            encoder_piece=self.encoder_piece[:0],
        )

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
            torque_noise=self.torque_noise[rows],
            hit=self.hit[first:last],
            after_impact=self.after_impact[first:last],
            encoder_rows=self.encoder_rows[encoder] - first,
            encoder=self.encoder[encoder],
            encoder_noise=self.encoder_noise[encoder],
            encoder_piece=self.encoder_piece[encoder],
        )


def observe(recording: Recording, model: Model, widest: float = math.inf, *, bridging: bool = False) -> Observation:
    """Prepare a recording for a diagnosis, with a kernel of at most ``widest`` [own s].

    With ``bridging``, the kernel is wide enough for the steps of a log without an even clock; otherwise these are gaps.

    Raises InputError if a required signal is missing.
    """
    if recording.of_points:
        return _observe_points(recording, model)
    missing = _missing(recording)
    if missing:
        lacked = lacked_columns(recording, [*missing, *(["motor_torque"] if "current" in missing else [])])
        raise InputError(
            f"{recording.name}: has no {' and no '.join(missing)}; without it no missing effect can be told"
            + (f"; {lacked}" if lacked else f" (it holds {', '.join(recording.signals)})")
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
    # without teeth or compliance nothing is shaken, and reversals are as good as any other rows
    geared = model.value("machine.output_inertia") > 0.0
    reading = max(counter_noise(model, "motor"), 0.0 if geared else reading_noise(signals["motor_position"]))
    if not geared and "speed" not in signals:
        width = narrowest(signals["motor_position"], period, reading, width, LEAST_PERIODS * period)
    if bridging:
        width = max(width, min(_usual_step(recording), widest))
    kernel = gaussian(width, period)
    whole = apart <= max(1.0, (1.0 if bridging else 0.5) * width / period)  # a kernel bridges gaps shorter than itself
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
    # without a gearbox, a machine that crosses standstill quickly (within a kernel's inner half) does not stick there
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
    """Step [s] that nearly all steps between samples stay within, in whole sample periods.

    A computer that logs while doing other work has no even rate. Its longer steps are not gaps, and a kernel as wide as
    one of them bridges it. If the samples have a clock and a few are missing, this is the sample period.
    """
    steps = np.diff(recording.stamps) * 1e-9
    return float(np.rint(np.quantile(steps, NEARLY_ALL) / recording.sample_period)) * recording.sample_period


def _observe_points(recording: Recording, model: Model) -> Observation:
    """Observation of operating points: rows that are judged as recorded, each separately."""
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
    """The rows that are judged; without torque data, the encoder rows."""
    return [o.rows if r.has("current") else o.encoder_rows for o, r in zip(found, recordings, strict=True)]


def _missing(recording: Recording) -> list[str]:
    """Signals missing for a diagnosis: motor position, and a torque or an output position."""
    missing = [name for name in NEEDED if not recording.has(name)]
    return missing if recording.has("current") or of_encoders_alone(recording) else ["current", *missing]


def observe_all(recordings: list[Recording], model: Model) -> list[Observation]:
    """Observe all recordings. Raises InputError if together they hold too little motion to judge."""
    if not recordings:
        raise InputError("no recording is given; a diagnosis needs at least one")
    # For a slow machine, whose own second is long, the usual kernel would leave few rows of a long recording. Two
    # widths make a row, and CORRELATION rows count as one.
    widest = sum(recording.duration for recording in recordings) / (4.0 * CORRELATION * LEAST_ROWS)
    found = [observe(recording, model, widest) for recording in recordings]
    if any(recording.of_points for recording in recordings):
        return found
    judged = _judged_rows(found, recordings)
    if sum(map(len, judged)) < LEAST_ROWS:
        with suppress(InputError):  # too short for so wide a kernel: reported as without it
            bridged = [observe(recording, model, widest, bridging=True) for recording in recordings]
            if sum(map(len, _judged_rows(bridged, recordings))) > sum(map(len, judged)):
                found, judged = bridged, _judged_rows(bridged, recordings)
    moving = sum(
        len(rows) * o.period * float(np.diff(rows).min(initial=len(o.motion)))
        for o, rows in zip(found, judged, strict=True)
    )
    if sum(map(len, judged)) < LEAST_ROWS:
        names = first_of([o.name for o in found])
        loaded = _loads_change(recordings)
        if unresolved := _unresolved(recordings, model):
            held = "; or read loads that are held as operating points (init --operating-points)" if loaded else ""
            raise InputError(f"{names}: {unresolved}{held}")
        standstill, unit = shown(model, STANDSTILL, "rad/s")
        raise InputError(
            f"{names}: {shown(model, moving, 's')[0]:.2g} s of motion faster than {standstill:.2g} {unit} at the "
            f"motor; a diagnosis needs more of it: {'record longer, or ' if moving > 0.0 else ''}move faster"
            f"{HELD if loaded and _hardly_moves(found) else _without_clock(recordings, model)}"
        )
    return found


def _unresolved(recordings: Sequence[Recording], model: Model) -> str:
    """Why no speed is known, and the remedy, if all move by less than an encoder's step a sample; else empty.

    Friction that only gives way, below its break-away level, lets a shaft move so.
    """
    if any(recording.has("speed") for recording in recordings):
        return ""
    known = [recording.signals["motor_position"] for recording in recordings if recording.has("motor_position")]
    known = [*map(_known, known)]
    if not known or not all(np.mean(np.abs(np.diff(position))) < _step(position) for position in known):
        return ""
    travel = quantity(*shown(model, max(float(np.ptp(position)) for position in known), "rad"))
    step = quantity(*shown(model, max(map(_step, known)), "rad"))
    return (
        f"the motor moves by {travel} in all, less than an encoder's step ({step}) a sample: it rests, or its friction "
        "only gives way, and no direction is known; record it sliding, over a far longer way"
    )


def _loads_change(recordings: Sequence[Recording]) -> bool:
    """Whether the drive's torque changes far beyond its noise: beside rest, a spring may be wound up step by step."""
    currents = [_known(recording.signals["current"]) for recording in recordings if recording.has("current")]
    return any(float(np.ptp(current)) > FAR_OUT * reading_noise(current) for current in currents)


def _hardly_moves(found: Sequence[Observation]) -> bool:
    return bool(np.mean(np.abs(np.concatenate([o.motion[:, SPEED] for o in found])) > STANDSTILL) < SMALL)


def _known(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _without_clock(recordings: list[Recording], model: Model) -> str:
    """What an uneven sample rate costs, and the remedy; empty if all recordings have a clock."""
    uneven = next((r for r in recordings if not r.of_points and _usual_step(r) > r.sample_period), None)
    if uneven is None:
        return ""
    usual, long = (1e3 * shown(model, step, "s")[0] for step in (uneven.sample_period, _usual_step(uneven)))
    return (
        f", or log at an even rate: {uneven.name}'s samples come {usual:.3g} ms apart, and often {long:.3g} ms or more"
    )


def _judged(time: np.ndarray, period: float, whole: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Mask (n,) of samples that are neither near an end nor near a gap."""
    margin = len(kernel) // 2 + round(START / period)
    judged = _spread(~whole, len(kernel) // 2) == 0.0
    judged[:margin] = judged[len(time) - margin :] = False
    return judged


def _spread(where: np.ndarray, reach: int) -> np.ndarray:
    """Positive within ``reach`` / 2 samples of true ones: a kernel's outer half has almost no weight."""
    return np.rint(np.convolve(where, np.ones(2 * round(0.5 * reach) + 1), "same"))


def _shaken(hit: np.ndarray) -> np.ndarray:
    """Factor (n,) on the noise after the largest acceleration (n,) [rad/s²] shortly before."""
    return np.sqrt(1.0 + (hit / HARD) ** 2)


def _hardest(acceleration: np.ndarray, before: float, after: float, period: float) -> np.ndarray:
    """Largest acceleration (n,) from ``before`` [s] before each sample to ``after`` [s] after it."""
    return moving_maximum(np.abs(acceleration), round(before / period), round(after / period))


def _torque_noise(current: np.ndarray, raw: np.ndarray, kernel: np.ndarray, model: Model) -> float:
    """Standard deviation [N m] of a smoothed current's torque, from its white noise and its resolution.

    Steps that are wide relative to the noise are not white: smoothing does not reduce them. They are taken from the
    ``raw`` values as recorded, since interpolated samples have no steps.
    """
    smoothed = float(np.linalg.norm(kernel))
    resolution = _resolution(raw, model)
    white = max(reading_noise(current), model.value("sensors.current_noise") if resolution else 0.0)
    return model.value("machine.torque_constant") * math.hypot(white * smoothed, resolution)


def _resolution(raw: np.ndarray, model: Model, read: float = 0.0) -> float:
    """Standard deviation [A] of the rounding of a current; zero if its steps are no wider than its noise.

    The noise is the model's, or what was ``read`` off the recording if the model gives none.
    """
    step = _step(raw)
    return step / math.sqrt(12.0) if step > 2.0 * max(model.value("sensors.current_noise"), read) else 0.0


def _step(raw: np.ndarray) -> float:
    """The smallest difference between two readings."""
    levels = np.unique(_known(raw))
    return float(np.diff(levels).min()) if len(levels) > 1 else 0.0


def _encoder_noise(model: Model) -> float:
    """Standard deviation [rad, slow shaft] of the encoder difference."""
    return math.hypot(counter_noise(model, "output"), counter_noise(model, "motor") / model.value("machine.gear_ratio"))


def _at(values: np.ndarray, kernel: np.ndarray, rows: np.ndarray) -> np.ndarray:
    smoothed = np.empty(len(rows))
    smooth_at(np.ascontiguousarray(values), kernel, rows, smoothed)
    return smoothed
