"""Draft of a model: what recordings can determine is open, the rest comes from what they show and what was given."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import yaml

from ema_bench_replay.long_columns import divided, times
from ema_bench_replay.recording import AT, AT_EITHER_SHAFT, Recording
from ema_bench_replay.units import signal_unit, unit_in, units_of

from ..measured.ratio_of_positions import ALIKE, ratio_of_positions
from ..measured.ratio_of_recordings import ShownRatio, ratio_of_recordings
from ..measured.speed_lag import speed_lag
from ..model.check_comment import ASSUMED, CHECK, REMEDIES, START_VALUE, check_comment
from ..model.constants import CONSTANTS
from ..model.roles import DRY_FRICTION, VISCOUS_FRICTION
from ..reading_noise import beside_fast_signal, drowns, noise_of_points, polled_noise, reading_noise
from ..simulation.behind_motor import of_encoders_alone
from .drive_gains import DriveGains, drive_gains
from .given import Given
from .load_beside_motor import shown_gear
from .shaft import EXACT, SAME_RATIO, Shaft, fastest_motion, is_possible, positions_part, whole_ratio
from .steps import common_step, is_decimal
from .torque_constant import TorqueConstant, question_about, told_at_joint, torque_constant
from .travel_per_turn import (
    doubt_of_travel,
    force_constant,
    question_about_force,
    question_about_turning,
    refuse_what_does_not_fit,
)
from .usual_counts import usual_counts

SMALLEST_STEP = "smallest step of the recording"
LAST_DIGIT = "last digit of the recording"  # begins the source of a step that shows the text and no encoder
ONE_AMPERE_IS = "one ampere means one"  # ends the source of a noise that is the torque's, followed by its unit
AS_FINE_AS_NOISE = "as fine as the noise of the recording"
_FEWEST = 10
_BEHIND = 0.2  # share of inertia and friction that is behind the gearbox, as a start value
_HOW_TO_GIVE_GAINS = "To simulate commands, fill in the lines of `drive:`, which the model holds as comments."


class ModelDraft(NamedTuple):
    """The text of a model, what was assumed in it from usual sizes and what it lacks (each with the remedy), and
    questions about it.
    """

    text: str
    assumed: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    lacked: tuple[str, ...] = ()


def draft_model(recordings: Sequence[Recording], given: Given, shaft: Shaft) -> ModelDraft:
    """YAML of a first model, in which everything is open that recordings can determine.

    Their motor position is that of its column, which is of that ``shaft``. Raises InputError if the given torque
    constant is one that no motor has, or what was given does not fit a machine of that motion.
    """
    recording = farthest(recordings)
    refuse_what_does_not_fit(given, recording)
    motion = recording.motion
    inertia, viscous, dry = (1e-3, 0.01, 0.1) if motion == "rotary" else (1.0, 10.0, 1.0)
    ratio = _ratio(recordings, given, shaft)
    gear = shown_gear(recordings) if ratio is not None and ratio.source == ASSUMED else None
    if ratio is not None and gear is not None:
        ratio = replace(ratio, doubt="; ".join(filter(None, (gear.comment, ratio.doubt))))
    two_sided = (
        ratio is not None
        and recording.has("motor_position", "output_position")
        and (abs(ratio.value - 1.0) > ALIKE or positions_part(recording, ratio.value))
    )
    two_sided |= of_encoders_alone(recording)  # which show only what is between them
    turns = 1.0 if ratio is None else ratio.value
    at_motor = [_at_motor(each, turns, shaft) for each in recordings]
    fastest = max(map(fastest_motion, at_motor)) if recording.has("current") else 0.0
    too_small = question_about_force(given, fastest, at_motor) if motion == "linear" else ""
    if motion == "linear" and given.torque_constant:
        constant = force_constant(given.torque_constant, given.travel_per_turn, likely=not too_small)
    else:
        constant = torque_constant(given.torque_constant, at_motor)
    told = motion == "rotary" and constant.source != ASSUMED
    at_joint = told_at_joint(constant.value, turns, fastest) if told else ""
    of_motor = constant.value / (turns if at_joint else 1.0)
    gains = next(filter(None, (drive_gains(each, of_motor) for each in at_motor)), None)
    without_gains = _without_gains(at_motor) if gains is None else ""
    sensors = _sensor_lines(at_motor, turns if shaft.name == "output" else 1.0)
    lines = [
        f"# First model of {given.name}. Inertia and friction are open: fit finds them, discover goes on from there.",
        f"# Look at every line that says {CHECK}.",
        "version: 1",
        "machine:",
        f"  name: {given.name}",
        *([f"  motion: {motion}"] if motion != "rotary" else []),
        *_inertia_lines(motion, inertia, two_sided),
        *([] if ratio is None else [ratio.line()]),
        *_torque_lines(recording, constant, at_joint),
        *([] if gains is None else _drive_lines(gains, motion)),
        *([f"# {line}" for line in (without_gains, *_drive_lines(None, motion))] if without_gains else []),
        "transmission: {kind: rigid}",
        *(["sensors:", *sensors] if sensors else ["sensors: {}"]),
        "effects:",
        f"  {VISCOUS_FRICTION}: {{effect: {VISCOUS_FRICTION}, options: {{side: motor}}, "
        f"parameters: {{coefficient: {viscous}}}, open: true}}",
        _friction_line(DRY_FRICTION, "motor", dry),
        *([_friction_line(f"{DRY_FRICTION}_2", "output", dry * _BEHIND)] if two_sided else []),
    ]
    remedy = "if it is the motor's, remove `shaft: output` from its line of the model"
    if given.torque_constant:
        remedy += f"; if it is in mN m/A, give {given.torque_constant / 1000.0:g}"
    assumed = (f"torque constant read as that of the joint, gear included: {at_joint} ({remedy})",) if at_joint else ()
    if given.travel_per_turn is None:
        question = question_about(given.torque_constant, turns, fastest, at_joint=bool(at_joint), motion=motion)
        question = question or too_small
    else:
        question = question_about_turning(given, fastest)
    questions = (question, _question_about_ratio(recording, given.gear_ratio, shaft), gear.question if gear else "")
    lacked = (f"{without_gains} {_HOW_TO_GIVE_GAINS}",) if without_gains else ()
    return ModelDraft("\n".join(lines) + "\n", assumed, tuple(filter(None, questions)), lacked)


def farthest(recordings: Sequence[Recording]) -> Recording:
    """The recording in which the motor goes farthest, which shows most about a ratio and about counts."""

    def travel(recording: Recording) -> float:
        name = next((name for name in ("motor_position", "output_position") if recording.has(name)), None)
        return 0.0 if name is None else float(np.ptp(_finite(recording.signals[name])))

    return max(recordings, key=travel)


def _inertia_lines(motion: str, inertia: float, two_sided: bool) -> list[str]:
    """The lines of the inertia; separate lines for that behind the gearbox if an encoder there may show its motion."""

    def line(name: str, value: float, comment: str) -> str:
        unit = unit_in("kg m^2", motion)
        return f"{_line(name, f'{value:g}', unit, tolerance='open', source=START_VALUE)}  # {comment}"

    if not two_sided:
        whole = "of all that moves" if motion == "linear" else "total inertia, at the motor"
        return [line("inertia", inertia, whole)]
    return [
        line("inertia", inertia * (1.0 - _BEHIND), "of what turns with the motor"),
        line(
            "output_inertia",
            inertia * _BEHIND,
            "of the rest, at the motor; distinguishable only with play or a compliant shaft",
        ),
    ]


def _friction_line(name: str, side: str, torque: float) -> str:
    return (
        f"  {name}: {{effect: {DRY_FRICTION}, options: {{side: {side}}}, "
        f"parameters: {{torque: {torque:g}, static_ratio: 1.0}}, open: true}}"
    )


@dataclass(frozen=True)
class _Ratio:
    """A gear ratio, its source, and what is doubtful about it."""

    value: float
    source: str
    doubt: str = ""

    def line(self) -> str:
        line = _line("gear_ratio", f"{self.value:.6g}", '"1"', tolerance="0.0", source=self.source)
        return f"{line}{check_comment(self.doubt)}"


def _ratio(recordings: Sequence[Recording], told: Given, shaft: Shaft) -> _Ratio | None:
    """The gear ratio: as given, else as position and speed or both positions show it, else 1 for a rotary machine."""
    recording = farthest(recordings)
    if given := told.gear_ratio:
        other = _other_ratio(recording, given, shaft)
        return _Ratio(given, "given", "" if other is None else f"both positions give {other:.4g}")
    if shaft.ratio is not None:
        return _Ratio(shaft.ratio, "speed over position", "of the motor's speed to its position")
    shown = ratio_of_positions(recording)
    if shown is not None and not is_possible(shown):
        return _Ratio(1.0, ASSUMED, f"both positions give {abs(shown):.4g}, which no gear has: are their units right?")
    if shown is not None:
        doubt = shaft.doubt_of_ratio
        if shown < 0.0:
            doubt = "the shafts turn in opposite directions: give the output's position `factor: -1` in the map"
        elif told.travel_per_turn is not None:
            doubt = doubt_of_travel(told.travel_per_turn, shown)
        elif abs(shown - 1.0) < ALIKE:
            doubt = "is the motor's position given as the output's? Then say `shaft: output` in the map"
        sure = ratio_of_recordings(recordings, shown)
        shown, doubt = _rounded(sure, recording, doubt) if recording.motion == "rotary" else (sure.value, doubt)
        return _Ratio(abs(shown), "slope of both positions", doubt)
    if recording.motion == "rotary":
        return _Ratio(1.0, ASSUMED, REMEDIES["machine.gear_ratio"])
    return None


def _rounded(shown: ShownRatio, recording: Recording, doubt: str) -> tuple[float, str]:
    """The whole number that both positions may show, or else what they show; and what is doubtful about it."""
    nearest = whole_ratio(shown.value, recording, shown.uncertainty)
    if nearest is not None and abs(shown.value / nearest - 1.0) > EXACT:
        return nearest, doubt or (
            f"the slope is {abs(shown.value):.6g}: rounded to a whole number, since play, a load that winds the gear "
            "up or an encoder's angle error would distort it"
        )
    if nearest is None and shown.uncertainty > EXACT * abs(shown.value):
        return shown.value, doubt or (
            f"to within {shown.uncertainty:.2g}, since play, a load that winds the gear up or an encoder's angle error "
            "would distort it; if it is known, give --gear-ratio"
        )
    return nearest or shown.value, doubt


def _other_ratio(recording: Recording, given: float, shaft: Shaft) -> float | None:
    """The gear ratio that both positions show, if it is not the given one."""
    shown = ratio_of_positions(recording) if shaft.name == "motor" else None
    return None if shown is None or abs(abs(shown) / given - 1.0) <= SAME_RATIO else abs(shown)


def _question_about_ratio(recording: Recording, given: float | None, shaft: Shaft) -> str:
    """A question about the given gear ratio if both positions show another one; empty if there is no doubt."""
    other = _other_ratio(recording, given, shaft) if given else None
    if other is None:
        return ""
    return (
        f"{recording.name}: the gear ratio was given as {given:g}, but both positions give {other:.4g}; leave "
        "--gear-ratio out to use that, or correct the unit or the counts of the position that is wrong"
    )


def _at_motor(recording: Recording, ratio: float, shaft: Shaft) -> Recording:
    """The recording with all of its motor's signals at the motor's shaft, where a model's constants are.

    Its motor position is of that ``shaft``, whatever the map says of it.
    """
    given = {name for name in AT_EITHER_SHAFT if recording.metadata.get(f"{name}{AT}") == "output"}
    given = given - {"motor_position"} | ({"motor_position"} if shaft.name == "output" else set())
    signals = {
        name: values
        if name not in given
        else divided(values, ratio)
        if name.endswith("torque")
        else times(values, ratio)
        for name, values in recording.signals.items()
    }
    metadata = {key: value for key, value in recording.metadata.items() if key not in {f"{name}{AT}" for name in given}}
    return replace(recording, signals=signals, metadata=metadata)


def _torque_lines(recording: Recording, constant: TorqueConstant, at_joint: str) -> list[str]:
    """The torque constant's line if there is a current; ``at_joint`` says why it must be the joint's, or is empty."""
    if not recording.has("current"):
        return []
    unit = unit_in("N m/A", recording.motion)
    value, source, doubt = f"{constant.value:.6g}", constant.source, constant.doubt
    if not at_joint:
        return [_line("torque_constant", value, unit, source=source) + check_comment(doubt)]
    source = f"{source} as {constant.value:g} {unit}" if source == "given" else source
    line = _line("torque_constant", value, unit, shaft="output", source=f"{source}; {ASSUMED} to be the joint's")
    return [line + check_comment(f"{at_joint}: assumed to be the joint's, gear included")]


def _without_gains(recordings: Sequence[Recording]) -> str:
    """That no recording shows a speed controller's gains, and what follows; empty if none has a setpoint."""
    with_setpoint = [each for each in recordings if each.drive is not None and each.has("speed_setpoint")]
    if not with_setpoint:
        return ""
    drive = "current" if with_setpoint[0].has("current") else "torque"
    return (
        f"No speed controller found: no recording shows that the {drive} follows the speed setpoint as that of a PI "
        f"controller, so the recorded {drive} drives the twin."
    )


def _drive_lines(found: DriveGains | None, motion: str) -> list[str]:
    """The lines of the speed controller; with dots to fill in if its gains were not found."""
    gain, time = ("…", "…") if found is None else (f"{found.speed_gain:.4g}", f"{found.integral_time:.4g}")
    source = "given" if found is None else "'fitted: torque over speed error'"
    return [
        "drive:",
        _line("speed_gain", gain, unit_in("N m s/rad", motion), tolerance="0.2", source=source),
        _line("integral_time", time, "s", tolerance="0.2", source=source),
        _line("integral_limit", "1e6", unit_in("N m", motion), tolerance="0.0", source="assumed"),
    ]


def _sensor_lines(recordings: Sequence[Recording], ratio: float) -> list[str]:
    """What recordings show of their sensors; empty if they have too few samples, as before the first recording.

    Their signals are at the motor's shaft, which turns ``ratio`` times as far as its position's encoder.
    """
    recording = farthest(recordings)
    if len(recording) <= _FEWEST:
        return []
    motion = recording.motion
    turn = 2.0 * math.pi if motion == "rotary" else 1.0
    lines = []
    for side in ("motor", "output"):
        name = f"{side}_position"
        if not recording.has(name):
            continue
        position = _finite(recording.signals[name])
        geared = ratio if side == "motor" else 1.0
        step, source = common_step([_finite(r.signals[name]) for r in recordings if r.has(name)]), SMALLEST_STEP
        column = _column_of_the_map(recording, name)
        if counts := column.get("counts_per_revolution"):
            step, source = turn / float(counts) * geared, "counts of the import map"
        elif step is not None and (digit := _last_digit(step / geared, str(column.get("unit")), motion)):
            source = f"{LAST_DIGIT} ({digit})"
        if step is None:  # a counter whose steps would make as much noise
            step, source = math.sqrt(12.0) * reading_noise(position), AS_FINE_AS_NOISE
        bounds = CONSTANTS[f"sensors.{side}_encoder_counts"]
        if step > 0.0 and bounds.lower <= turn / step <= bounds.upper:  # the position of a simulation may be finer
            counted = geared * turn / step  # per turn of the shaft that the encoder is on
            usual = usual_counts(counted) if motion == "rotary" and source == SMALLEST_STEP else None
            counts, unit = f"{(usual or counted) / geared:.9g}", unit_in("1/rev", motion)
            lines.append(_line(f"{side}_encoder_counts", counts, unit, tolerance="0.0", source=source))
    for name in ("current", "speed"):
        if recording.has(name) and not (recording.of_points and name == "speed"):  # each point has its own speed
            noise = _usual_noise(recordings, name)
            line = _line(f"{name}_noise", f"{noise.value:.3g}", signal_unit(name, motion), source=noise.source)
            lines.append(line + check_comment(noise.doubt))
    lag = speed_lag(recording)
    if lag is not None:
        lines.append(_line("speed_smoothing", f"{lag:.3g}", "s", source="lag of the speed behind the position"))
    if recording.has("motor_torque") and not recording.has("current"):
        noise = _usual_noise(recordings, "motor_torque")
        source = f"{noise.source}; {ONE_AMPERE_IS} {signal_unit('motor_torque', motion)}"
        lines.append(_line("current_noise", f"{noise.value:.3g}", "A", source=source) + check_comment(noise.doubt))
    if not recording.of_points:
        lines.append(_line("sample_period", f"{recording.sample_period:g}", "s", tolerance="0.0"))
    return lines


def _line(name: str, value: str, unit: str, **more: str) -> str:
    """A constant's line in the file of a model."""
    keys = ", ".join(f"{key}: {text}" for key, text in {"value": value, "unit": unit, **more}.items())
    return f"  {name}: {{{keys}}}"


def _column_of_the_map(recording: Recording, signal: str) -> Mapping[str, float | str]:
    """What the import map with which a recording was read says of a signal's column; empty if it says nothing."""
    content = yaml.safe_load(recording.metadata.get("map_text", "")) or {}
    column: Mapping[str, float | str] = content.get("signals", {}).get(signal, {})
    return column


def _last_digit(step: float, unit: str, motion: str) -> str:
    """A position's step (in SI) as ``0.001 deg``, in its column's ``unit``, if it is the text's last digit; else empty.

    Encoders have round numbers of counts per turn, so a step that is round in degrees or radians shows the text.
    """
    size = units_of("motor_position", motion).get(unit)
    if size is None or not is_decimal(step / size, (1.0,)):
        return ""
    if unit == "rev" and usual_counts(1.0 / (step / size)) is not None:
        return ""
    return f"{10.0 ** round(math.log10(step / size)):g} {unit}"


class _Noise(NamedTuple):
    """The noise of a signal's readings in its own unit, its source, and what is doubtful about it."""

    value: float
    source: str = "third differences of the recording"
    doubt: str = ""


def _usual_noise(recordings: Sequence[Recording], signal: str) -> _Noise:
    """The median noise of a signal over the recordings that show one; none if no recording does."""
    each = [_noise(recording, signal) for recording in recordings if recording.has(signal)]
    shown = sorted((noise for noise in each if noise.value > 0.0), key=lambda noise: noise.value)
    return shown[(len(shown) - 1) // 2] if shown else _Noise(0.0, source="the recordings show none")


def _noise(recording: Recording, signal: str) -> _Noise:
    """The noise of a signal's readings."""
    if recording.of_points:
        return _Noise(noise_of_points(recording, signal))
    values = _finite(recording.signals[signal])
    noise = polled_noise(values)
    beside = beside_fast_signal(noise, values)
    if beside < noise:
        doubt = "at most: the signal changes as fast as noise"
        return _Noise(beside, "quietest part of the recording's spectrum", doubt)
    return _Noise(noise, doubt="as large as the whole signal, which it may be" if drowns(noise, values) else "")


def _finite(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]
