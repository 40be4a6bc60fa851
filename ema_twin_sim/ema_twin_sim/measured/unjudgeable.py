"""What makes recordings unjudgeable, in words, and what to do: signals or samples are missing, or motion is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.lacked_columns import lacked_columns

from ..criteria import FAR_OUT, PART, SMALL, STANDSTILL
from ..listing import first_of
from ..model import Model
from ..model.own_units import shown
from ..plant.motion import SPEED
from ..quantities import quantity
from ..reading_noise import reading_noise, smallest_step
from ..simulation.behind_motor import of_encoders_alone
from ..simulation.long_gaps import refuse_long_gaps
from ..simulation.operating_points import FEWEST as FEWEST_POINTS
from .drive_in_words import drive_in_words
from .observation import Observation
from .smoothed_motion import FEWEST, NEEDED, usual_step
from .smoothing import smooth
from .unknown_inertia import of_unknown_inertia

RIGHT_COLUMN = "is that the right column of the trace? Name it in the import map"
HELD = (
    "; a test of stiffness, held at each load, is read as operating points: `operating_points: true` in its map, or "
    "init --operating-points"
)


def refuse_few_points(observations: Sequence[Observation]) -> None:
    """Raise InputError if all recordings together hold too few operating points to judge."""
    count = sum(len(o.rows) for o in observations)
    if count < FEWEST_POINTS:
        names = some_of(o.name for o in observations)
        raise InputError(
            f"{names}: {count} operating points are too few: at least {FEWEST_POINTS} are needed; measure more"
        )


def refuse_incomplete(recording: Recording, model: Model) -> None:
    """Raise InputError if a required signal is missing, or too many samples in a row."""
    missing = _missing(recording)
    if missing:
        lacked = lacked_columns(recording, [*missing, *(["motor_torque"] if "current" in missing else [])])
        raise InputError(
            f"{recording.name}: has no {' and no '.join(missing)}; without it no missing effect can be told"
            + (f"; {lacked}" if lacked else f" (it holds {', '.join(recording.signals)})")
        )
    if len(recording) < FEWEST:
        raise InputError(f"{recording.name}: {len(recording)} samples are too few: at least {FEWEST} are needed")
    second, _ = shown(model, 1.0, "s")
    refuse_long_gaps(recording, second)


def refuse_unchanging(recording: Recording, signals: Mapping[str, np.ndarray], model: Model) -> None:
    """Raise InputError if there is nothing to judge: no current at all, or without one an output that never moves."""
    if "current" not in signals:
        if np.ptp(signals["output_position"]) == 0.0:
            raise InputError(
                f"{recording.name}: its output_position never changes while the motor turns; is the encoder connected, "
                "and is that the right column of the trace?"
            )
    elif not signals["current"].any():
        name, zero = drive_in_words(recording, model, 0.0)
        raise InputError(f"{recording.name}: its {name} is {zero} all along; {RIGHT_COLUMN}")


def refuse_undriven(found: Sequence[Observation], recordings: Sequence[Recording], model: Model) -> None:
    """Raise InputError if a current that never changes while it moves cannot drive the motion, or tells too little.

    A step test holds one: its levels tell the friction, and then its acceleration the inertia. At a single level, dry
    friction alone explains the torque, unless the inertia is known. A constant torque turns a motion round once at
    most. A measured load may drive the machine instead.
    """
    levels = [_level(o, recording, model) for o, recording in zip(found, recordings, strict=True)]
    for o, recording, level in zip(found, recordings, levels, strict=True):
        if level is not None and (turns := _turns(o)) > 1:
            name, held = drive_in_words(recording, model, level)
            raise InputError(
                f"{recording.name}: its {name} is {held} all along, while the motion reverses {turns} times; "
                f"{RIGHT_COLUMN}"
            )
    if levels[0] is None or not np.allclose(np.array(levels, float), levels[0]):
        return
    steady = not any(map(_speed_changes, found))
    if steady or (of_unknown_inertia(model) and not any(map(_turns, found))):
        name, held = drive_in_words(recordings[0], model, levels[0])
        raise InputError(
            f"{first_of([o.name for o in found])}: {name} is {held} all along, which dry friction alone explains, "
            "whatever the inertia; record several levels, or a motion that changes"
            + ("" if steady else ", or give the model its inertia")
            + f"; or {RIGHT_COLUMN}"
        )


def _level(o: Observation, recording: Recording, model: Model) -> float | None:
    """The current [own A] that a recording holds while it moves; None if it changes, or if a measured load may drive.

    Smoothing rounds what is constant.
    """
    if not len(o.rows) or not recording.has("current") or recording.has("load_torque"):
        return None
    level = float(np.median(o.torque))
    return level / model.value("machine.torque_constant") if np.allclose(o.torque, level) else None


def _turns(o: Observation) -> int:
    """How often a motion reverses in its judged rows, of what is faster than a part of its fastest."""
    speed = smooth(o.motion[:, SPEED], o.kernel)[o.rows]
    return int(np.count_nonzero(np.diff(np.sign(speed[np.abs(speed) > PART * np.abs(speed).max()]))))


def _speed_changes(o: Observation) -> bool:
    """Whether a motion is at some time far slower than at another."""
    speed = np.abs(smooth(o.motion[:, SPEED], o.kernel)[o.rows])
    return bool(np.ptp(speed) > PART * speed.max())


def _missing(recording: Recording) -> list[str]:
    """Signals missing for a diagnosis: motor position, and a torque or an output position."""
    missing = [name for name in NEEDED if not recording.has(name)]
    return missing if recording.has("current") or of_encoders_alone(recording) else ["current", *missing]


def too_little_motion(
    found: Sequence[Observation], judged: Sequence[np.ndarray], recordings: Sequence[Recording], model: Model
) -> str:
    """Why the ``judged`` rows (m,) of each recording are too few, and the remedy."""
    hardly_moves = np.mean(np.abs(np.concatenate([o.motion[:, SPEED] for o in found])) > STANDSTILL) < SMALL
    moving = sum(
        len(rows) * o.period * float(np.diff(rows).min(initial=len(o.motion)))
        for o, rows in zip(found, judged, strict=True)
    )
    names = first_of([o.name for o in found])
    loaded = _loads_change(recordings)
    if unresolved := "" if moving > 0.0 else _unresolved(found, recordings, model):
        held = "; or read loads that are held as operating points (init --operating-points)" if loaded else ""
        return f"{names}: {unresolved}{held}"
    standstill, unit = shown(model, STANDSTILL, "rad/s")
    return (
        f"{names}: {shown(model, moving, 's')[0]:.2g} s of motion faster than {standstill:.2g} {unit} at the "
        f"motor; a diagnosis needs more of it: {'record longer, or ' if moving > 0.0 else ''}move faster"
        f"{HELD if loaded and hardly_moves else _without_clock(recordings, model)}"
    )


def _unresolved(found: Sequence[Observation], recordings: Sequence[Recording], model: Model) -> str:
    """Why no speed is known, and the remedy, if all move by less than an encoder's step a sample; else empty.

    Friction that only gives way, below its break-away level, lets a shaft move so. A motion that is slow beside its
    samples does too, but smoothed it is faster than standstill at times, and some rows of it are judged.
    """
    if any(recording.has("speed") for recording in recordings):
        return ""
    known = [_known(recording.signals["motor_position"]) for recording in recordings if recording.has("motor_position")]
    if not known or not all(np.mean(np.abs(np.diff(position))) < smallest_step(position) for position in known):
        return ""
    way = max(float(np.sum(np.abs(smooth(o.motion[:, SPEED], o.kernel)))) * o.period for o in found)
    travel = quantity(*shown(model, way, "rad"))
    step = quantity(*shown(model, max(map(smallest_step, known)), "rad"))
    return (
        f"the motor moves by {travel} to and fro, less than an encoder's step ({step}) a sample: it rests, or its "
        "friction only gives way, and no direction is known; record it sliding, over a far longer way"
    )


def _loads_change(recordings: Sequence[Recording]) -> bool:
    """Whether the drive's torque changes far beyond its noise: beside rest, a spring may be wound up step by step."""
    currents = [_known(recording.signals["current"]) for recording in recordings if recording.has("current")]
    return any(float(np.ptp(current)) > FAR_OUT * reading_noise(current) for current in currents)


def _known(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _without_clock(recordings: Sequence[Recording], model: Model) -> str:
    """What an uneven sample rate costs, and the remedy; empty if all recordings have a clock."""
    uneven = next((r for r in recordings if not r.of_points and usual_step(r) > r.sample_period), None)
    if uneven is None:
        return ""
    usual, long = (1e3 * shown(model, step, "s")[0] for step in (uneven.sample_period, usual_step(uneven)))
    return (
        f", or log at an even rate: {uneven.name}'s samples come {usual:.3g} ms apart, and often {long:.3g} ms or more"
    )
