"""Drafts of an import map and a model that can read the traces they are made from, and questions about the traces."""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ema_bench_replay.errors import InputError, TimeGoesBackError
from ema_bench_replay.load import load
from ema_bench_replay.recording import AT_EITHER_SHAFT, MOTION, Recording
from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.units import unit_in

from ..criteria import SMALL
from ..listing import first_of
from ..measured.drive_regression import agreed_sign, signs_of_drive
from ..measured.load_sensor import falls_with_load, follows_load, times_current
from ..measured.magnitude import any_in_a_row
from ..measured.ratio_of_positions import ratio_of_positions
from ..measured.scales import to_own_units
from ..measured.sign_by_friction import sign_by_friction
from ..measured.way_by_speed import standing_position
from ..model import Model, load_model
from ..model.constants import CONSTANTS
from ..quantities import quantity
from .bare_letters import contradicted_letter
from .columns import Guess, Guesses
from .given import Given
from .load_by_numbers import doubted_motors_torque, load_by_numbers
from .map_draft import draft_map, wrapped_after
from .model_draft import ModelDraft, draft_model, farthest
from .never_changing import never_changing
from .position_beside_speed import not_summed, share_beside_speed, unlike_speed
from .rows import may_be_points
from .shaft import Shaft, is_geared, is_possible, position_shaft, shaft_by_travel
from .signal_columns import is_quadrature
from .torque_beside_current import not_proportional
from .two_joints import two_joints
from .unit_questions import questions_about_clock, questions_about_units
from .unnamed_positions import HOW_TO_NAME, unnamed_beside_speed, unnamed_pair
from .unsigned_drive import unsigned_signals

_STILL = "not used, since it never changes, as of a sensor that is not connected, or of a shaft that is held"
_ZERO = "not used, since it never changes from zero, as of a signal that nobody fills in"
_OUTPUTS = ("output_position", "output_command")
_DRIVE = ("current", "current_setpoint", "motor_torque")


class Drafts(NamedTuple):
    """Texts of a map and a model; questions about the recording's units; what was assumed from usual sizes; the columns
    of guesses that the map leaves out, and why; what is wrong with the recordings, as they are read with this map; what
    they show besides the numbers of the model; and what the model lacks.
    """

    map: str
    model: str
    questions: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    left_out: Mapping[str, str] = MappingProxyType({})
    warnings: tuple[str, ...] = ()
    known: tuple[str, ...] = ()
    magnitudes: frozenset[str] = frozenset()  # signals that the map reads as magnitudes without sign
    load: Guess | None = None  # the column that is taken for the load, with the reason, if its name did not say so
    lacked: tuple[str, ...] = ()


def checked_drafts(guesses: Guesses, given: Given, traces: Sequence[Path]) -> Drafts:
    """The drafts for a machine; ``traces`` are its recordings, empty if there are none yet.

    Raises InputError if a trace cannot be read with the drafts.
    """
    as_guessed = guesses
    of = traces[0].name if traces else f"{given.name}'s traces"
    shaft = Shaft(given.shaft or "motor")

    def read(tried: Guesses) -> list[Recording]:
        """The traces as a map of these columns reads them; the shaft of the position is the one known by then."""
        return _read(draft_map(tried, of, shaft), traces)

    drafted = draft_map(guesses, of, shaft)
    recordings = _read(drafted, traces)
    source = str(traces[0]) if traces else given.name
    if not traces:  # without a recording, nothing is known of the sensors
        empty = {guess.signal: np.zeros(2) for guess in guesses.signals}
        metadata = {MOTION: guesses.motion} if guesses.motion != "rotary" else {}
        recording = Recording(given.name, np.arange(2) * 1_000_000, empty, metadata=metadata)
        return Drafts(drafted, checked_model((recording,), given, shaft, source).text)
    for recording in recordings:
        _refuse_slow_samples(recording, guesses)
    idle = never_changing(recordings)
    still = {g.column: _ZERO if g.signal in _DRIVE else _STILL for g in guesses.signals if g.signal in idle}
    if still:
        guesses = guesses.without(tuple(still))
        if not guesses.signals:
            raise InputError(
                f"{source}: {', '.join(still)}: never changes, and nothing else is left to read; record a motion, and "
                "the motor's current or torque"
            )
        recordings = read(guesses)
    magnitudes = frozenset(guess.signal for guess in guesses.signals if guess.magnitude)
    if new := unsigned_signals(recordings) - magnitudes:
        return checked_drafts(as_guessed.changed(new, magnitude=True), given, traces)
    behind, unknown = load_by_numbers(recordings, guesses, read)
    if behind is not None:
        return checked_drafts(as_guessed.with_load(behind), given, traces)
    reason = _no_load(recordings, guesses.motion)
    not_load = f"not used as the load: {reason}" if reason else ""
    of_signal = {
        "load_torque": not_load,
        "current": _not_the_motors(recordings, guesses, given),
        "motor_position": not_summed(recordings) or _standing(recordings) or unlike_speed(recordings),
        "output_position": _of_no_gear(recordings, guesses) or two_joints(recordings, guesses),
    }
    letter, contradicted = contradicted_letter(recordings, guesses)
    of_signal |= {letter: contradicted} if letter and not of_signal.get("motor_position") else {}
    left_out = {guess.column: why for guess in guesses.signals if (why := of_signal.get(guess.signal, ""))}
    if left_out:
        if of_signal["current"]:
            doubt = "used in place of the current, to which it is not proportional"
            guesses = guesses.changed(("motor_torque",), shaft_doubt=doubt)
        guesses = guesses.without(tuple(left_out))
        recordings = read(guesses)
    assumed, shown = [_followed(guess) for guess in guesses.signals if guess.command], []
    if (clock := guesses.time) is not None and clock.doubt and header_words(clock.column).unit is not None:
        assumed.append(f"{clock.column}: {clock.doubt} (if each row is an operating point, give --operating-points)")
    assumed += [
        f"{guess.column}: starts again after {wrapped_after(guess)}, as its jumps show, and is counted on there (if "
        "they are true, remove `wraps_after` from its line of the map)"
        for guess in guesses.signals
        if guess.wraps_after
    ]
    if (share := share_beside_speed(recordings)) > SMALL:
        told = f"{100.0 * share:.0f} % of its way is not the speed's"
        guesses = guesses.changed(("motor_position",), origin_doubt=f"{told}: are both of the same shaft?")
        position, speed = (guesses.named(signal) for signal in ("motor_position", "speed"))
        assumed.append(
            f"{position}: of the same shaft as {speed}, though {told} (if it is not, remove one of them and run init "
            "again)"
        )
    if (lone := unnamed_beside_speed(guesses)) is not None:
        guesses = guesses.changed((lone.signal,), origin_doubt="no word of its name tells a position: is it one?")
        assumed.append(f"{lone.column}: a position, though no word of its name tells one ({HOW_TO_NAME})")
    unsure, remedy = ("", "") if left_out else doubted_motors_torque(recordings, guesses)
    if unsure:
        guesses = guesses.changed(("motor_torque",), shaft_doubt=unsure)
        doubt = unsure.partition(":")[0]
        assumed.append(f"{guesses.named('motor_torque')}: the motor's torque, though {doubt} ({remedy})")
    load = next((guess for guess in guesses.signals if guess.signal == "load_torque" and guess.shaft_doubt), None)
    if load is not None:
        assumed.append(
            f"{load.column}: {load.shaft_doubt} (if it is the motor's torque, say so in its name, as in 'motor torque "
            "[N m]', and run init again)"
        )
    drives = ", ".join(g.column for g in guesses.signals if g.signal in _DRIVE and not g.magnitude and guesses.drives)
    drive = [guess for guess in guesses.signals if guess.signal in _DRIVE]
    turned_drive = any(guess.turned_round for guess in drive)
    has_factor = any(guess.factor != 1.0 for guess in drive)  # as that of a servo's step
    if falls_with_load(recordings):
        guesses = guesses.changed(("load_torque",), turned_round=True)
        recordings = read(guesses)
        assumed.append(f"{guesses.named('load_torque')}: sign reversed, because the drive's torque falls when it rises")
    if _turns_back(recordings):
        guesses = guesses.changed(_OUTPUTS, turned_round=True)
        recordings = read(guesses)
        columns = guesses.named(*_OUTPUTS)
        shown.append(f"{columns} turned round (`factor: -1` in the map), since the output turns against the motor")
    units = {guess.signal: guess.unit for guess in guesses.signals}
    foreign = {guess.signal for guess in guesses.signals if guess.foreign_unit}
    questions = tuple(told for recording in recordings for told in questions_about_units(recording, units, foreign))
    known = None not in (units.get("motor_position"), units.get("speed"))
    if any(guess.signal == "speed" and guess.of_output for guess in guesses.signals):
        known = False  # a speed of the output does not show whose turns the position counts
    shaft = position_shaft(farthest(recordings), given.gear_ratio, units_known=known)
    if shaft.name == "motor" and _told_at_the_output(guesses):
        shaft = Shaft("output", given.gear_ratio)
    unnamed = not any(guess.of_motor for guess in guesses.signals if guess.signal in ("motor_position", "speed"))
    asked_shaft = shaft == Shaft() and unnamed
    by_travel = shaft_by_travel(recordings, given.gear_ratio, of_a_robot=bool(guesses.joint.name))
    if asked_shaft and by_travel.name == "output":
        few = by_travel.doubt
        shaft = replace(by_travel, doubt=f"{few}: assumed to be the output's angle")
        placed = any(guess.signal == "motor_position" for guess in guesses.signals)
        why = "assumed to be the output's, like the position" if placed else f"{few}: assumed to be the output's"
        guesses = replace(guesses, signals=tuple(_of_the_output(guess, why) for guess in guesses.signals))
        recordings = read(guesses)
        columns = ", ".join(g.column for g in guesses.signals if g.of_output and g.signal in AT_EITHER_SHAFT)
        assumed.append(
            f"{columns}: read as values of the output shaft: {few} (if one is the motor's, say so in its name, as in "
            "'motor position [rad]', and run init again)"
        )
    elif is_geared(given.gear_ratio):
        moving = ("motor_position", "speed") if asked_shaft else ()
        if asked_shaft and by_travel.doubt:
            shaft = by_travel
            guesses = guesses.changed(("speed",), shaft_doubt=by_travel.doubt)
        signals = [*moving, *(["motor_torque"] if _tells_the_constant(guesses, given) else [])]
        motors = guesses.named(*signals)
        if motors:
            assumed.append(
                f"{motors}: read as the motor's, which turns {given.gear_ratio:g} times as fast as the output "
                "(if of the output, say so in its name, as in 'output position [rad]', and run init again)"
            )
    if (pair := unnamed_pair(guesses)) is not None and not given.gear_ratio:
        names = f"{pair[0].column} and {pair[1].column}"
        told = f"{names} go together, but no word of their names tells a motor or an output ({HOW_TO_NAME})"
        shaft = replace(shaft, doubt_of_ratio=told)
        doubt = f"taken for one as it goes with {pair[0].column}"
        guesses = guesses.changed(("output_position",), origin_doubt=doubt)
    model = checked_model([_without(recording, magnitudes) for recording in recordings], given, shaft, source)
    if drives and not turned_drive:
        signs = _signs_of_drive(recordings, model)
        turned = [recording.name for recording, sign in zip(recordings, signs, strict=True) if sign < 0]
        if turned and 1 not in signs:  # all else is judged again with it
            return checked_drafts(as_guessed.changed(_DRIVE, turned_round=True), given, traces)
        if turned:
            assumed.append(
                f"{drives}: positive drives forwards, though it acts against the motion in {first_of(turned)} "
                f"({len(turned)} of {sum(sign != 0 for sign in signs)} recordings that show a sign; if these were "
                "recorded with the opposite sign, read them by a map of their own, with `factor: -1` in its line)"
            )
        elif 1 in signs:
            shown.append(f"sign of {drives} (positive drives forwards)")
        else:
            assumed.append(
                f"{drives}: positive drives forwards, which the recordings do not show clearly (otherwise "
                f"{'change the sign of `factor` in' if has_factor else 'add `factor: -1` to'} its line of the map)"
            )
    asked = (
        *(_no_sign(guess, recordings) for guess in guesses.signals if guess.magnitude),
        *questions_about_clock(recordings, guesses.time),
        *questions,
        *model.questions,
    )
    if turned_drive:
        told = f"{drives}: as recorded, it acts against the motion, so its sign is reversed"
        otherwise = "if the motion has the wrong sign, reverse the position and the speed instead"
        how = "a negative `factor`" if has_factor else "`factor: -1`"
        asked = (f"{told} ({how} in the map); {otherwise}", *asked)
    warnings = tuple(warning for recording in recordings for warning in recording.warnings)
    return Drafts(
        draft_map(guesses, of, shaft),
        model.text,
        asked,
        (*assumed, *model.assumed),
        {**still, **left_out, **unknown},
        warnings,
        tuple(shown),
        magnitudes,
        next((guess for guess in as_guessed.signals if guess.signal == "load_torque" and guess.shaft_doubt), None),
        model.lacked,
    )


def _without(recording: Recording, signals: Collection[str]) -> Recording:
    """The recording without these signals; itself if it has none of them."""
    kept = {name: values for name, values in recording.signals.items() if name not in signals}
    return recording if len(kept) == len(recording.signals) else replace(recording, signals=kept)


def _no_sign(guess: Guess, recordings: Sequence[Recording]) -> str:
    """That a column is read as a magnitude, and what to do about it."""
    read = [recording.signals[guess.signal] for recording in recordings if recording.has(guess.signal)]
    negative = [values < 0.0 for values in read]
    but = " but for single samples" if any(rows.any() for rows in negative) else ""
    if any(map(any_in_a_row, negative)):
        but = " but for its noise"
    return (
        f"{guess.column}: never negative{but}, so it looks like a magnitude without sign (`magnitude: true` in the "
        "map), which serves to judge health and drives no twin; record the motor's current with its sign, or take the "
        "mark away if a load that always pulls one way keeps it positive"
    )


def _followed(guess: Guess) -> str:
    """That a command stands in place of a measurement."""
    measured = "torque" if guess.signal == "motor_torque" else "current"
    return (
        f"{guess.column}: a command, which the drive is assumed to follow, since no measured torque or current was "
        f"found (if the drive measures its {measured}, record that too)"
    )


def _no_load(recordings: Sequence[Recording], motion: str) -> str:
    """Why a column that is named like a load is none; empty if it may be one, or if there is none."""
    factor = times_current(recordings)
    if factor is not None:
        constant = f"{factor:.4g} {unit_in('N m/A', motion)}"
        return (
            f"it is {constant} times the current, so the drive computed it (give --torque-constant to use that factor)"
        )
    return "" if follows_load(recordings) else "the drive's torque does not follow it"


def _not_the_motors(recordings: Sequence[Recording], guesses: Guesses, given: Given) -> str:
    """Why a current is not used: a torque in a known unit is beside it and does not go with it; else empty.

    It is used nevertheless if its name says that it is the motor's, or a torque constant was given.
    """
    current, torque = (guesses.by_signal.get(name) for name in ("current", "motor_torque"))
    if current is None or torque is None or torque.unit is None or torque.magnitude:
        return ""
    if given.torque_constant is not None or current.of_motor or is_quadrature(header_words(current.column).words):
        return ""
    share = not_proportional(recordings)
    if share is None:
        return ""
    return (
        f"not used: {torque.column} is not proportional to it ({100.0 * share:.0f} % is left), so that is used as the "
        "motor's torque (if this is the motor's current, or the torque is a load sensor's behind the machine, say so "
        "in its name, as in 'motor current [A]' or 'load torque [N m]', and run init again)"
    )


def _standing(recordings: Sequence[Recording]) -> str:
    """Why a position is of no use: it stands still in all recordings, though the speed says that the motor moves."""
    moved = [way for way in map(standing_position, recordings) if way is not None]
    if len(moved) < len(recordings):
        return ""
    unit = unit_in("rad", recordings[0].motion)
    return f"not used: it stands still, while by the speed the motor moves by {quantity(max(moved), unit)}"


def _of_no_gear(recordings: Sequence[Recording], guesses: Guesses) -> str:
    """Why a position is not the output's: the motor would turn by a ratio that no model may have; else empty."""
    ratio = ratio_of_positions(farthest(recordings))
    if ratio is None or is_possible(ratio):
        return ""
    motor = guesses.named("motor_position")
    return f"not used as the output's position: beside {motor} the gear ratio would be {abs(ratio):.3g}, as of no gear"


def _turns_back(recordings: Sequence[Recording]) -> bool:
    """Whether the output turns against the motor in each recording that shows their ratio; False if none shows it."""
    shown = [ratio for ratio in map(ratio_of_positions, recordings) if ratio is not None]
    return bool(shown) and max(shown) < 0.0


def _tells_the_constant(guesses: Guesses, given: Given) -> bool:
    """Whether a torque beside a current, of unnamed shaft, may tell the torque constant."""
    current, torque = (guesses.by_signal.get(name) for name in ("current", "motor_torque"))
    if given.torque_constant is not None or current is None or torque is None:
        return False
    return not (torque.of_motor or torque.of_output)


def _signs_of_drive(recordings: Sequence[Recording], model: ModelDraft) -> list[int]:
    """Whether current or torque drives each recording's motion as read (1) or reversed (-1); 0: undecided."""
    try:
        own, its_model = to_own_units(recordings, _loaded(model.text, "the draft"))
        return [_sign(each, its_model) for each in own]
    except InputError:  # whatever needs the motion will report this
        return [0] * len(recordings)


def _sign(recording: Recording, model: Model) -> int:
    """The sign by what the drive moves; where nothing tells that, by friction alone."""
    if recording.of_points:
        return 0
    told = [sign for sign in signs_of_drive(recording, model) if sign]
    return agreed_sign(told) if told else sign_by_friction(recording, model)


def _of_the_output(guess: Guess, why: str) -> Guess:
    """A column whose name gives no shaft, taken for the output's, and ``why``; other columns unchanged."""
    if guess.of_motor or guess.of_output or guess.signal not in AT_EITHER_SHAFT:
        return guess
    return replace(guess, of_output=True, shaft_doubt=why)


def _read(map_text: str, traces: Sequence[Path]) -> list[Recording]:
    """Read the traces with an import map that is not written yet. Raises InputError if the map cannot read them."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "map.yaml"
        place.write_text(map_text)
        try:
            load_map(place)
            return [load(trace, import_map=place) for trace in traces]
        except InputError as error:  # without the path of a file that the user never sees
            of = f"{traces[0]}: the map drafted from it" if traces else "the drafted map"
            said = str(error).replace(str(place), of)
            if isinstance(error, TimeGoesBackError) and may_be_points(error.rows):
                said += "; if each row is an operating point, at rest or at a constant speed, give --operating-points"
            raise InputError(said) from None


def checked_model(recordings: Sequence[Recording], given: Given, shaft: Shaft, source: str = "") -> ModelDraft:
    """YAML of a first model that can be read. The motor's position is as in its column, which is of that ``shaft``.

    Raises InputError, which names the ``source`` of the recordings, or the first one, if they give no model.
    """
    draft = draft_model(recordings, given, shaft)
    try:
        _loaded(draft.text, f"{source or recordings[0].name}: the model drafted from it")
    except InputError as error:
        raise InputError(f"{error}; rename the columns it comes from, or remove them, and run init again") from None
    return draft


def _loaded(text: str, called: str) -> Model:
    """The model of a file that is not written yet. Raises InputError in which it is ``called`` so."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "model.yaml"
        place.write_text(text)
        try:
            return load_model(place)
        except InputError as error:
            raise InputError(str(error).replace(str(place), called)) from None


def _refuse_slow_samples(recording: Recording, guesses: Guesses) -> None:
    """Raise InputError if the sample period is longer than any drive's, for example because ms are read as s."""
    longest = CONSTANTS["sensors.sample_period"].upper
    if guesses.time is not None and not recording.of_points and recording.sample_period > longest:
        raise InputError(
            f"{recording.name}: samples come every {recording.sample_period:g} s by column {guesses.time.column!r}; is "
            "it in ms? Then say so in its name, as in 'time [ms]'; if each row is an operating point, at rest or at a "
            "constant speed, give --operating-points"
        )


def _told_at_the_output(guesses: Guesses) -> bool:
    """Whether the names of the position and of the speed, if there is one, say that they are the output's."""
    shafts = {guess.shaft for guess in guesses.signals if guess.signal in ("motor_position", "speed")}
    return shafts == {"output"}
