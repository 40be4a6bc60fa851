"""Drafts of an import map and of a model, with what could not be guessed marked ``CHECK``."""

from __future__ import annotations

import json
import math
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_bench_replay.load import load
from ema_bench_replay.recording import MOTION, Recording
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.units import signal_unit, unit_in

from ..model import load_model
from ..reading_noise import reading_noise
from .columns import Guess, Guesses

CHECK = "CHECK"
_MOVING = 0.3  # of the furthest way
_FEWEST = 10
_COUNTS = re.compile(r"count|cnt|increment|inkrement|tick|pulse", re.IGNORECASE)
_ALIKE = 0.02  # of a gear ratio of one: both shafts turn alike
_WINDOW = 0.1  # of a recording's samples: the way over which shafts are compared


@dataclass(frozen=True)
class Given:
    """What a person said of the machine; None where they did not."""

    name: str
    gear_ratio: float | None = None
    torque_constant: float | None = None  # N m/A, or N/A where the machine is linear


def checked_drafts(guesses: Guesses, given: Given, trace: Path | None) -> tuple[str, str]:
    """Texts of a map and of a model that can be read; ``trace`` is the recording, None where there is none yet.

    Raises InputError where the trace cannot be read so.
    """
    with tempfile.TemporaryDirectory() as folder:
        files = Path(folder) / "map.yaml", Path(folder) / "model.yaml"
        drafted = draft_map(guesses, f"{given.name}'s traces" if trace is None else trace.name)
        files[0].write_text(drafted)
        load_map(files[0])
        if trace is None:  # what a recording would tell of the sensors is left out
            empty = {guess.signal: np.zeros(2) for guess in guesses.signals}
            metadata = {MOTION: guesses.motion} if guesses.motion != "rotary" else {}
            recording = Recording(given.name, np.arange(2) * 1_000_000, empty, metadata=metadata)
        else:
            recording = load(trace, import_map=files[0])
        model = draft_model(recording, given)
        files[1].write_text(model)
        load_model(files[1])
    return drafted, model


def draft_map(guesses: Guesses, trace: str) -> str:
    """YAML of an import map that reads a trace with these columns."""
    lines = [
        f"# First import map of {trace}, guessed from its header. Look at every line that says {CHECK}.",
        "version: 1",
        f"description: {json.dumps(trace)}",
    ]
    if guesses.motion != "rotary":
        lines.append(f"motion: {guesses.motion}")
    if guesses.time is None:
        lines.append(f"operating_points: true  # {CHECK}: no column of time was found; each row is taken for a point")
    else:
        unit = guesses.time.unit or "s"
        doubt = "" if guesses.time.unit else f"  # {CHECK}: the header names no unit"
        lines.append(f"time: {{column: {_quoted(guesses.time.column)}, unit: {unit}}}{doubt}")
    lines.append("signals:")
    lines += [_signal_line(guess, guesses.motion) for guess in guesses.signals]
    if not {guess.signal for guess in guesses.signals} & {"current", "motor_torque"}:
        lines.append(
            f"# {CHECK}: no current and no torque was found, which all rests on. Where a voltage commands the drive's "
            "torque, map it so:"
        )
        unit = signal_unit("motor_torque", guesses.motion)
        lines.append(f"#  motor_torque: {{columns: ['…'], unit: V, gain: {{value: …, unit: {unit}/V}}}}")
    if guesses.left:
        lines.append(f"# {CHECK}: not used: {', '.join(guesses.left)}")
    return "\n".join(lines) + "\n"


def draft_model(recording: Recording, given: Given) -> str:
    """YAML of a first model: all inertia in one number, everything open that the recording may tell."""
    motion = recording.motion
    turn = 2.0 * math.pi if motion == "rotary" else 1.0
    inertia, constant, per_turn = (unit_in(unit, motion) for unit in ("kg m^2", "N m/A", "1/rev"))
    ratio, source = (given.gear_ratio, "given") if given.gear_ratio else _ratio(recording)
    lines = [
        f"# First model of {given.name}. Inertia and friction are open: fit finds them, discover goes on from there.",
        f"# Look at every line that says {CHECK}.",
        "version: 1",
        "machine:",
        f"  name: {given.name}",
        *([f"  motion: {motion}"] if motion != "rotary" else []),
        f"  inertia: {{value: {1e-3 if motion == 'rotary' else 1.0:g}, unit: {inertia}, tolerance: open, "
        "source: start value}  # at the motor",
    ]
    if ratio is not None or motion == "rotary":
        doubt = "" if ratio is not None else f"  # {CHECK}: turns of the motor per turn of the output"
        if ratio is not None and not given.gear_ratio and abs(ratio - 1.0) < _ALIKE:
            doubt = f"  # {CHECK}: is the motor's position given as the output's? Then say `shaft: output` in the map"
        value, where = (ratio, source) if ratio is not None else (1.0, "assumed")
        if "against" in where:
            doubt = f"  # {CHECK}: give the output's position `factor: -1` in the map"
        lines.append(f'  gear_ratio: {{value: {value:.6g}, unit: "1", tolerance: 0.0, source: {where}}}{doubt}')
    if recording.has("current"):
        value = given.torque_constant or 1.0
        doubt = "" if given.torque_constant else f"  # {CHECK}: take it from the motor's data sheet"
        where = "given" if given.torque_constant else "assumed"
        lines.append(f"  torque_constant: {{value: {value:g}, unit: {constant}, source: {where}}}{doubt}")
    lines.append("transmission: {kind: rigid}")
    lines.append("sensors:")
    for side in ("motor", "output"):
        position = recording.signals.get(f"{side}_position")
        if position is None or len(recording) <= _FEWEST:
            continue
        step, where = _smallest_step(position), "smallest step of the recording"
        if step is None:  # as fine as a counter whose steps would make as much noise
            step, where = math.sqrt(12.0) * reading_noise(_finite(position)), "as fine as the noise of the recording"
        if step > 0.0:
            lines.append(
                f"  {side}_encoder_counts: {{value: {turn / step:.6g}, unit: {per_turn}, tolerance: 0.0, "
                f"source: {where}}}"
            )
    for name, path in (("current", "current_noise"), ("speed", "speed_noise")):
        if recording.has(name) and len(recording) > _FEWEST:
            lines.append(
                f"  {path}: {{value: {reading_noise(_finite(recording.signals[name])):.3g}, "
                f"unit: {signal_unit(name, motion)}, source: third differences of the recording}}"
            )
    if not recording.of_points and len(recording) > _FEWEST:
        lines.append(f"  sample_period: {{value: {recording.sample_period:g}, unit: s, tolerance: 0.0}}")
    if lines[-1] == "sensors:":
        lines[-1] = "sensors: {}"
    viscous, dry = (0.01, 0.1) if motion == "rotary" else (10.0, 1.0)
    lines += [
        "effects:",
        "  viscous_friction: {effect: viscous_friction, options: {side: motor}, "
        f"parameters: {{coefficient: {viscous}}}, open: true}}",
        "  coulomb_friction: {effect: coulomb_friction, options: {side: motor}, "
        f"parameters: {{torque: {dry}, static_ratio: 1.0}}, open: true}}",
    ]
    return "\n".join(lines) + "\n"


def _signal_line(guess: Guess, motion: str) -> str:
    if guess.unit is None and guess.signal.endswith("position") and _COUNTS.search(guess.column):
        return (
            f"  {guess.signal}: {{columns: [{_quoted(guess.column)}], counts_per_revolution: 4096}}"
            f"  # {CHECK}: the counts of one turn, all edges counted"
        )
    unit = guess.unit or signal_unit(guess.signal, motion)
    doubt = "" if guess.unit else f"  # {CHECK}: the header names no unit of it"
    if guess.signal == "motor_position":
        doubt = doubt or "  # of the motor's shaft; `shaft: output` where it is given as the output's"
    return f"  {guess.signal}: {{columns: [{_quoted(guess.column)}], unit: {unit}}}{doubt}"


def _quoted(column: str) -> str:
    """A column's name as the regular expression that fits it alone, in single quotes."""
    special = set(r".^$*+?{}[]\|()")
    plain = "".join("\\" + mark if mark in special else mark for mark in column)
    return "'" + plain.replace("'", "''") + "'"


def _ratio(recording: Recording) -> tuple[float | None, str]:
    """The gear ratio that both positions show, and where it is from; None where they show none."""
    if not recording.has("motor_position", "output_position"):
        return None, ""
    lag = max(1, int(_WINDOW * len(recording)))
    motor, output = (
        recording.signals[name][lag:] - recording.signals[name][:-lag] for name in ("motor_position", "output_position")
    )
    both = np.isfinite(motor) & np.isfinite(output) & (output != 0.0)
    far = both & (np.abs(motor) > _MOVING * np.abs(motor[both]).max(initial=0.0))
    if far.sum() < _FEWEST:
        return None, ""
    found = float(np.median(motor[far] / output[far]))
    return abs(found), "slope of both positions" + (" that turn against each other" if found < 0.0 else "")


def _smallest_step(values: np.ndarray) -> float | None:
    """The step that all differences of a counter are made of; None where values come in no steps."""
    steps = np.diff(np.unique(_finite(values)))
    if not len(steps):
        return None
    smallest = float(np.median(steps[steps <= 1.5 * np.quantile(steps, 0.2)]))
    parts = steps / smallest
    return smallest if float(np.quantile(np.abs(parts - np.rint(parts)), 0.9)) < 0.1 else None


def _finite(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]
