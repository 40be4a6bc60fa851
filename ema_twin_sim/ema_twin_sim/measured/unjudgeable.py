"""What makes recordings unjudgeable, in words, and what to do: signals or samples are missing, or motion is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.lacked_columns import lacked_columns

from ..criteria import FAR_OUT, SMALL, STANDSTILL
from ..listing import first_of
from ..model import Model
from ..model.own_units import shown
from ..plant.measured_motion import SPEED
from ..quantities import quantity
from ..reading_noise import reading_noise, smallest_step
from ..simulation.behind_motor import of_encoders_alone
from ..simulation.long_gaps import refuse_long_gaps
from ..simulation.operating_points import FEWEST as FEWEST_POINTS
from .observation import Observation
from .smoothed_motion import FEWEST, NEEDED, usual_step
from .smoothing import smooth

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
    """Raise InputError if what would be judged, the current or without one the output's position, never changes."""
    if "current" not in signals:
        if np.ptp(signals["output_position"]) == 0.0:
            raise InputError(
                f"{recording.name}: its output_position never changes while the motor turns; is the encoder connected, "
                "and is that the right column of the trace?"
            )
    elif np.ptp(signals["current"]) == 0.0:
        raise InputError(
            f"{recording.name}: its current is {shown(model, signals['current'][0], 'A')[0]:g} A all along; is that "
            "the right column of the trace? Name it in the import map"
        )


def _missing(recording: Recording) -> list[str]:
    """Signals missing for a diagnosis: motor position, and a torque or an output position."""
    missing = [name for name in NEEDED if not recording.has(name)]
    return missing if recording.has("current") or of_encoders_alone(recording) else ["current", *missing]


def too_little_motion(
    found: Sequence[Observation], judged: Sequence[np.ndarray], recordings: Sequence[Recording], model: Model
) -> str:
    """Why the ``judged`` rows (m,) of each recording are too few, and the remedy."""
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
        f"{HELD if loaded and _hardly_moves(found) else _without_clock(recordings, model)}"
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


def _hardly_moves(found: Sequence[Observation]) -> bool:
    return bool(np.mean(np.abs(np.concatenate([o.motion[:, SPEED] for o in found])) > STANDSTILL) < SMALL)


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
