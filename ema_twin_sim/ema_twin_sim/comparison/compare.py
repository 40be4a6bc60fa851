"""Compare models with recordings: RMSE per signal relative to the sensors' noise floor, and where a model fails."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from ema_bench_replay.long_columns import divided, shifted, slopes, times
from ema_bench_replay.recording import Recording
from ema_bench_replay.units import signal_unit

from ..measured.consistency import Inconsistency, inconsistencies, told_once
from ..measured.noise import noise_of
from ..measured.scales import standstill, to_own_units, to_rotary_equivalent
from ..measured.usual_sizes import unusual_currents
from ..model import Model
from ..model.matching import by_torque
from ..model.own_units import shown
from ..parallel import simulations
from ..simulation.angle_origins import angle_origins, without_common_zero
from ..simulation.compared_signals import ALL_UNITS, ENCODER_DIFFERENCE, UNITS
from ..simulation.encoder_difference import with_encoder_difference
from ..simulation.simulate import BY_MOTOR, choose_input, simulate
from .at_rest import AtRest, at_rest
from .beyond_noise import beyond_noise, shown_signals
from .decisive_stretch import DecisiveStretch, decisive_stretch
from .running_comparison import RunningComparison, SignalError
from .setpoint_shift import SetpointShift, ShiftSums, setpoint_shift
from .unknown_start import unknown_start
from .where import Dependence, Stretch, find_dependences

if TYPE_CHECKING:
    from .torque_error import TorqueError

MIXED = "mixed"
"""Input of a comparison whose recordings are driven by different signals."""

Signals = dict[str, SignalError]

_Beside = tuple[RunningComparison, dict[str, Stretch], dict[str, DecisiveStretch], dict[str, ShiftSums]]
TRACED_UNITS = ALL_UNITS | {"motor_torque": signal_unit("motor_torque")}
"""Signals traced to a place, including the drive's torque if there is no current."""


@dataclass(frozen=True)
class RecordingComparison:
    """Comparison of one recording with the twin.

    ``signals`` has ``{rmse, relative, noise_floor, unit, driven}`` per signal in SI units, ``independent`` the
    effective number of independent values in its residual. ``stretches`` has the short part of the recording that
    decides the error of a signal, for signals that have one.
    """

    name: str
    samples: int
    duration: float
    signals: Signals
    independent: Mapping[str, float]
    torque_error: TorqueError | None = None
    stretches: Mapping[str, DecisiveStretch] = field(default_factory=dict)

    def as_json(self) -> dict[str, object]:
        """For ``compare --json``."""
        found: dict[str, object] = {
            "name": self.name,
            "samples": self.samples,
            "duration": self.duration,
            "signals": self.signals,
        }
        return found if self.torque_error is None else {**found, "torque_error": self.torque_error.as_json()}


@dataclass(frozen=True)
class Comparison:
    """A model compared with recordings; ``overall`` pools all samples, ``where`` is what the errors depend on.

    ``misread`` are the warnings that put every number in doubt, such as a wrong unit: to be told before the errors.
    ``at_rest`` says how much of the unexplained torque is at standstill, if that is most of it.
    """

    model: str
    input: str
    recordings: tuple[RecordingComparison, ...]
    overall: Signals
    independent: Mapping[str, float]
    where: tuple[Dependence, ...]
    warnings: tuple[str, ...]
    motion: str = "rotary"
    misread: tuple[str, ...] = ()
    shift: SetpointShift | None = None
    at_rest: AtRest | None = None

    def as_json(self) -> dict[str, object]:
        """For ``compare --json``.

        ``at_rest`` if most of the unexplained torque is at standstill, ``setpoint_shift`` [s] if the machine follows
        its setpoint earlier than the twin.
        """
        found: dict[str, object] = {
            "model": self.model,
            "input": self.input,
            "recordings": [recording.as_json() for recording in self.recordings],
            "overall": self.overall,
            "where": [dependence.as_json() for dependence in self.where],
            "warnings": list(self.warnings),
        }
        if self.at_rest is not None:
            found["at_rest"] = asdict(self.at_rest)
        return found if self.shift is None else {**found, "setpoint_shift": self.shift.seconds}


def compare(
    recordings: Sequence[Recording],
    model: Model,
    source: str | None = None,
    *,
    step: float | None = None,
    noise: Mapping[str, float] | None = None,
    progress: Callable[[str], None] = lambda name: None,
    within: Callable[[str, float], None] = lambda name, share: None,
) -> Comparison:
    """Simulate the model for each recording and compare; nothing is estimated.

    ``source`` is the input for all (``setpoint`` or ``current``; by default what each recording allows). ``noise`` is
    the noise floor, by default that of these recordings with this model; several models on the same recordings share
    one. ``progress`` is called with the name of each finished recording, ``within`` with the name of a long one and the
    share of it that was simulated. Raises InputError if a recording lacks the input's signal.
    """
    given, asked = recordings, model
    noise = noise_of(recordings, model) if noise is None else noise
    recordings, model = to_rotary_equivalent(recordings, model)
    inputs = [choose_input(recording, model, source) for recording in recordings]
    together = inputs[0] if len(set(inputs)) == 1 else MIXED
    pooled = RunningComparison(model, together, noise=noise)
    compared = []
    starts: list[str] = []
    slow = standstill(given, asked, together)
    stretches: dict[str, list[Stretch]] = {name: [] for name in ALL_UNITS}
    shifts: list[dict[str, ShiftSums]] = []

    def beside(recording: Recording, chosen: str) -> _Beside:
        return _beside(recording, model, chosen, step, noise, partial(within, recording.name))

    besides = simulations(beside, recordings, inputs)
    for recording, chosen, (running, parts, decisive, sums) in zip(recordings, inputs, besides, strict=True):
        shifts.append(sums)
        for name, part in parts.items():
            stretches[name].append(part)
        error = _torque_error(recording, model) if chosen == "current" else None
        result = shown_errors(model, of_the_drive(model, running.result(), recordings))
        rows = running.independent
        if "current" not in result and "current" in decisive:  # the errors are those of the drive's torque
            decisive["motor_torque"] = decisive.pop("current")
        compared.append(
            RecordingComparison(recording.name, len(recording), recording.duration, result, rows, error, decisive)
        )
        pooled.include(running)
        if "output_position" in parts:
            starts += unknown_start(recording.name, model, parts["output_position"], noise["output_position"], slow)
        progress(recording.name)
    constant = model.value("machine.torque_constant")
    torques = {"current": constant, "motor_torque": 1.0, "unexplained_torque": 1.0}
    if by_torque(recordings):
        stretches["motor_torque"] = [replace(s, residual=times(s.residual, constant)) for s in stretches.pop("current")]
    where = [
        dependence
        for name, parts in stretches.items()
        if parts
        for dependence in _dependences(model, name, parts, torques.get(name), slow)
    ]
    still = at_rest(stretches.get("unexplained_torque", ()), slow)
    misread = (*_inconsistent(given, asked), *unusual_currents(given, asked))
    return Comparison(
        model.name,
        together,
        tuple(compared),
        shown_errors(model, of_the_drive(model, pooled.result(), recordings)),
        pooled.independent,
        tuple(where),
        (
            *misread,
            *starts,
            *(warning for recording in recordings for warning in recording.warnings),
            *without_common_zero(recordings, model.active.values()),
        ),
        "rotary" if model.units is None else "linear",
        misread,
        setpoint_shift(shifts, recordings[0].sample_period, model.value("machine.gear_ratio"), together),
        still,
    )


def _inconsistent(recordings: Sequence[Recording], model: Model) -> list[str]:
    """Inconsistencies of the recordings, by the same rules as ``fit`` and ``discover``, one line for each kind."""
    parts = [recording.spread() for recording in recordings]
    own, its_model = to_own_units([part for group in parts for part in group], model)
    rest = iter(own)
    found: list[Inconsistency] = []
    for group in parts:
        its = islice(rest, len(group))
        told = [mistakes for part in its if (mistakes := [*inconsistencies(part, its_model, own)])]
        # other parts of a long recording would repeat what the first one reports
        sure = (mistakes for mistakes in told if any(one.certain for one in mistakes))
        found += next(sure, told[0] if told else [])
    return told_once(found, len(recordings))


def compare_all(
    recordings: Sequence[Recording],
    models: Sequence[Model],
    source: str | None = None,
    *,
    step: float | None = None,
    progress: Callable[[str, str], None] = lambda model, name: None,
    within: Callable[[str, str, float], None] = lambda model, name, share: None,
) -> list[Comparison]:
    """Compare several models with the same recordings, using one noise floor: that of the model with the least error.

    ``progress`` is called with the model's and the recording's name, ``within`` also with the share of a long recording
    that was simulated.
    """
    compared = [
        compare(
            recordings,
            model,
            source,
            step=step,
            progress=partial(progress, model.name),
            within=partial(within, model.name),
        )
        for model in models
    ]
    best = min(compared, key=_main_error)
    return [comparison if comparison is best else _with_noise_of(best, comparison) for comparison in compared]


def _main_error(comparison: Comparison) -> float:
    """RMSE of the signal by which models are judged first; infinite if it is not known."""
    name = next(iter(shown_signals(comparison.input, comparison.overall)), "")
    rmse = comparison.overall[name]["rmse"] if name else math.inf
    return rmse if math.isfinite(rmse) else math.inf


def _with_noise_of(best: Comparison, comparison: Comparison) -> Comparison:
    """The comparison with the noise floors of another one of the same recordings."""
    recordings = tuple(
        replace(own, signals=_floored(own.signals, other.signals))
        for own, other in zip(comparison.recordings, best.recordings, strict=True)
    )
    return replace(comparison, recordings=recordings, overall=_floored(comparison.overall, best.overall))


def _floored(signals: Signals, others: Signals) -> Signals:
    return {
        name: {**error, "noise_floor": others[name]["noise_floor"]} if name in others else error
        for name, error in signals.items()
    }


def overall_errors(recordings: Sequence[Recording], model: Model, noise: Mapping[str, float]) -> tuple[str, Signals]:
    """(input, errors pooled over all recordings), as ``compare`` reports them."""
    matched, twin = to_rotary_equivalent(recordings, model)
    inputs = [choose_input(recording, twin) for recording in matched]
    together = inputs[0] if len(set(inputs)) == 1 else MIXED
    pooled = RunningComparison(twin, together, noise=noise)

    def beside(recording: Recording, source: str) -> RunningComparison:
        running = RunningComparison(twin, source, period=recording.sample_period, noise=noise)
        simulated = simulate(twin, recording, source, wanted=UNITS)
        running.add_rows(*with_encoder_difference(twin, recording, source, simulated))
        return running

    for running in simulations(beside, matched, inputs):
        pooled.include(running)
    return together, shown_errors(twin, of_the_drive(twin, pooled.result(), matched))


def _beside(
    recording: Recording,
    model: Model,
    source: str,
    step: float | None,
    noise: Mapping[str, float],
    progress: Callable[[float], None],
) -> _Beside:
    """Errors of a twin for one recording, the residuals that are traced to a place, the stretches that decide them, and
    the sums that tell a shift between setpoint and motion.

    The twin itself is not kept.
    """
    twin = simulate(model, recording, source, step=step, wanted=UNITS, progress=progress)
    running = RunningComparison(model, source, period=recording.sample_period, noise=noise)
    residuals = running.add_rows(*with_encoder_difference(model, recording, source, twin))
    ratio = model.value("machine.gear_ratio")
    traced = [name for name in explained_signals(source) if name in residuals]
    own = {name: np.ascontiguousarray(residuals[name]) for name in traced}  # a view would keep all rows
    stretches = {name: stretch_of(recording, twin, values, ratio) for name, values in own.items()}
    over = () if recording.of_points else beyond_noise(source, running.result())
    sums: dict[str, ShiftSums] = {}
    if source == "setpoint" and stretches:
        speed = next(iter(stretches.values())).speed
        shafts = {"motor_position": 1.0, "output_position": ratio}
        sums = {
            name: ShiftSums.of(residuals[name], speed, shaft) for name, shaft in shafts.items() if name in residuals
        }
    return running, stretches, _decisive({name: residuals[name] for name in over}, recording), sums


def _decisive(residuals: Mapping[str, np.ndarray], recording: Recording) -> dict[str, DecisiveStretch]:
    """The stretches that decide the errors of these signals, for those that have one."""
    time = recording.time if residuals else np.empty(0)
    found = {name: decisive_stretch(residual, time) for name, residual in residuals.items()}
    return {name: stretch for name, stretch in found.items() if stretch is not None}


def _torque_error(recording: Recording, model: Model) -> TorqueError | None:
    from .torque_error import torque_error  # its filters take a second to import, and most comparisons need none

    return torque_error(recording, model)


def _dependences(
    model: Model, name: str, parts: Sequence[Stretch], torque: float | None, slow: float
) -> list[Dependence]:
    """What a signal's residual depends on, in the units of the machine's file.

    Below ``slow`` [rad/s] there is no direction.
    """
    if model.units is None:
        return find_dependences(name, TRACED_UNITS[name], parts, torque, standstill=slow, direct=model.is_direct)
    (_, unit), (way, _) = shown(model, 1.0, TRACED_UNITS[name]), shown(model, 1.0, "rad")
    native = [in_native_units(model, name, part) for part in parts]
    return find_dependences(name, unit, native, torque, motion="linear", standstill=slow * way)


def of_the_drive(model: Model, signals: Signals, recordings: Sequence[Recording]) -> Signals:
    """The errors, with the current's given as the drive's torque if no recording has a current."""
    if not by_torque(recordings):
        return signals
    constant = model.value("machine.torque_constant")
    found: Signals = {}
    for name, error in signals.items():
        if name == "current":
            rmse, floor = constant * error["rmse"], constant * error["noise_floor"]
            found["motor_torque"] = {**error, "rmse": rmse, "noise_floor": floor, "unit": "N m"}
        else:
            found[name] = error
    return found


def shown_errors(model: Model, signals: Signals) -> Signals:
    """The errors in the units of the machine's file."""
    found: Signals = {}
    for name, error in signals.items():
        (rmse, unit), (floor, _) = (shown(model, error[key], error["unit"]) for key in ("rmse", "noise_floor"))
        found[name] = {**error, "rmse": rmse, "noise_floor": floor, "unit": unit}
    return found


def in_native_units(model: Model, name: str, stretch: Stretch) -> Stretch:
    """Convert a stretch of a drum, with the residual of signal ``name``, to the units of its carriage."""
    residual, way = shown(model, 1.0, TRACED_UNITS[name])[0], shown(model, 1.0, "rad")[0]
    factors = {"residual": residual, "speed": way, "motor_angle": way, "output_position": way}
    scaled = {key: times(getattr(stretch, key), by) for key, by in factors.items()}
    return replace(stretch, **scaled)


def explained_signals(source: str) -> tuple[str, ...]:
    """Signals whose errors are traced to a place: the input's main signal, and the one that shows the gearbox."""
    if source == BY_MOTOR:
        return ("output_position",)
    return ("unexplained_torque", ENCODER_DIFFERENCE) if source == "current" else ("current", "output_position")


def stretch_of(recording: Recording, twin: Recording, residual: np.ndarray, ratio: float) -> Stretch:
    """A residual (n,) with the variables it may depend on; ``ratio`` is the gear ratio.

    Angles are those of the counters, as a search and an effect that acts at a place count them: recordings that begin
    elsewhere then show a place where it is.
    """
    position = recording.signals.get("motor_position", twin.signals["motor_position"])
    speed = twin.signals["speed"] if recording.of_points else recording.signals.get("speed")
    if speed is None:
        speed = slopes(position, recording.time)
    origin, output_origin = angle_origins(recording.motor_angle_origin, recording.output_angle_origin, ratio)
    output = recording.signals.get("output_position")
    if output is None and recording.has("motor_position"):
        output = divided(position, ratio)
    elif output is None:
        output = twin.signals["output_position"]
    time = np.zeros(len(recording)) if recording.of_points else recording.time  # points have an order, and no clock
    return Stretch(residual, speed, shifted(position, origin), shifted(output, output_origin), time)
