"""Offline simulation: the twin of a recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import Column, is_long, pieces
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.lacked_columns import lacked_columns

from ..model import Model
from ..model.matching import WITHOUT_SIGN
from ..model.own_units import shown
from ..plant.layout import BENCH, TWIN
from .behind_motor import of_encoders_alone, twin_behind_motor
from .dc_link_check import refuse_recording_beyond_link
from .long_gaps import refuse_long_gaps
from .operating_points import twin_at_points
from .required import twin_of
from .twin import Twin

DRIVING = {"setpoint": "speed_setpoint", "current": "current", "command": "output_command"}
"""The recorded signal that drives the twin for each input."""

POINTWISE = "motion"
"""The input for operating points: nothing is integrated, and the twin gives the current."""

BY_MOTOR = "motor"
"""The input for a recording of two encoders only: the motor's measured motion drives the twin's output."""


def choose_input(recording: Recording, model: Model, wanted: str | None = None) -> str:
    """The input that drives the twin: ``wanted`` if given, otherwise ``setpoint`` if recorded, otherwise ``current``.

    A model without a speed controller cannot follow a setpoint: its default is the current. ``wanted`` may also be
    ``command``, the recorded position command, which the model's own position loop then follows.

    Operating points drive it by their positions and speeds (``motion``); a recording of both encoders without torque by
    the motor's position (``motor``). Raises InputError if the recording lacks the signal, or the model the controller.
    """
    if recording.of_points:
        if wanted not in (None, POINTWISE):
            raise InputError(
                f"{recording.name}: operating points cannot drive a twin, since each stands by itself; leave out "
                f"--input {wanted}"
            )
        return POINTWISE
    if wanted in (None, BY_MOTOR) and of_encoders_alone(recording):
        return BY_MOTOR
    chosen = wanted or input_by_signals(recording.has("speed_setpoint"), recording.has("current"), model)
    if chosen not in DRIVING:
        raise InputError(f"input '{chosen}' is not known; give setpoint, current or command")
    if wanted is None and not recording.has(DRIVING[chosen]):  # neither a speed setpoint nor a current
        lacked = lacked_columns(recording, ("current", "motor_torque"))
        unsigned = recording.metadata.get(WITHOUT_SIGN)
        if unsigned is not None and not lacked:
            raise InputError(
                f"{recording.name}: has no current and no torque of the drive with a sign, which a twin needs; its "
                f"import map reads {unsigned} as a magnitude. Record the motor's current with its sign; if a load that "
                "always pulls one way keeps it positive, take `magnitude: true` out of the map"
            )
        remedy = lacked or (
            f"it holds {', '.join(recording.signals)}. Map a column as current or motor_torque; a voltage that "
            "commands the torque is mapped as motor_torque with a `gain`"
        )
        raise InputError(f"{recording.name}: has no current and no torque of the drive, which a twin needs; {remedy}")
    if not recording.has(DRIVING[chosen]):
        raise InputError(
            f"{recording.name}: has no {DRIVING[chosen]}, which drives the twin under --input {chosen}; "
            f"it holds {', '.join(recording.signals)}"
        )
    if chosen == "setpoint":
        refuse_without_speed_controller(model)
    return chosen


def input_by_signals(setpoint: bool, current: bool, model: Model) -> str:
    """The default input for a bench that has a setpoint, a current, or both."""
    return "setpoint" if setpoint and (has_speed_controller(model) or not current) else "current"


def has_speed_controller(model: Model) -> bool:
    """Whether a model's drive can follow a setpoint."""
    return model.value("drive.speed_gain") > 0.0


def refuse_without_speed_controller(model: Model) -> None:
    """Raise InputError if a model's drive has no speed controller, so that its twin would stand still."""
    if not has_speed_controller(model):
        raise InputError(
            f"model {model.name}: has no speed controller, so that its twin would stand still; give "
            "it drive.speed_gain and drive.integral_time, or drive it by the measured current where there is one"
        )


def simulate(
    model: Model,
    recording: Recording,
    source: str | None = None,
    *,
    step: float | None = None,
    wanted: Collection[str] = TWIN,
    progress: Callable[[float], None] = lambda share: None,
) -> Recording:
    """Simulate a recording: returns the twin's recording with the same stamps and the twin's signals.

    ``source`` is the input (see ``choose_input``), ``step`` [s] the integration step. For a long recording, only the
    ``wanted`` signals are kept. ``progress`` is called with the share done.
    """
    chosen = choose_input(recording, model, source)
    if chosen == POINTWISE:
        return twin_at_points(model, recording)
    second = shown(model, 1.0, "s")[0]
    if chosen == BY_MOTOR:
        refuse_long_gaps(recording, second)
        return twin_behind_motor(model, recording)
    if not is_long(len(recording)):
        bench = bench_of(recording, second)
        return seen(model, recording, followed(started(model, recording, bench, chosen, step), recording, bench))
    refuse_long_gaps(recording, second)
    signals = _Signals(wanted)
    for rows in _by_pieces(model, recording, chosen, step):
        signals.add(rows)
        progress(signals.size / len(recording))
    return twin_of(recording, model, signals.finish())


def bench_of(recording: Recording, second: float = 1.0) -> np.ndarray:
    """The rows (n, 6) of a recording that a twin follows (``layout.BENCH``). Raises InputError if a gap is too long.

    ``second`` is the time unit of the recording in s, if it is in own units.
    """
    refuse_long_gaps(recording, second)
    return _bench_rows(recording, slice(0, len(recording)))


def _bench_rows(recording: Recording, rows: slice) -> np.ndarray:
    absent = np.full(rows.stop - rows.start, math.nan)
    return np.column_stack([recording.signals[name][rows] if recording.has(name) else absent for name in BENCH])


def _by_pieces(model: Model, recording: Recording, chosen: str, step: float | None) -> Iterator[np.ndarray]:
    """The rows (m, signals) of the twin of a long recording, piece by piece; its state carries over."""
    twin = None
    bench = np.zeros((0, len(BENCH)))
    held = [recording.has(name) for name in BENCH]
    for rows in pieces(len(recording)):
        before = bench[-1:, held]
        rows = slice(max(rows.start - 1, 0), rows.stop)  # begins with the last row of the previous piece
        bench = _bench_rows(recording, rows)
        bench[: len(before), held] = before  # keep values that were held over missing samples
        twin = twin or started(model, recording, bench, chosen, step)
        yield followed(twin, recording, bench, rows)[len(before) :]


class _Signals:
    """Collects a twin's signals from its rows; a signal that is never known takes no memory."""

    def __init__(self, wanted: Collection[str]) -> None:
        self.size = 0
        self._wanted = [(k, name) for k, name in enumerate(TWIN) if name in wanted]
        self._columns: dict[str, Column] = {}

    def add(self, rows: np.ndarray) -> None:
        """Append rows (m, signals)."""
        for k, name in self._wanted:
            if name not in self._columns:
                # the very first row is the initial state
                if np.isnan(rows[0 if self.size else 1 :, k]).all():
                    continue
                self._columns[name] = Column(np.float64)
                self._columns[name].add_same(math.nan, self.size)
            self._columns[name].add(rows[:, k])
        self.size += len(rows)

    def finish(self) -> dict[str, np.ndarray]:
        """The signals (n,) by name."""
        return {name: column.finish() for name, column in self._columns.items()}


def started(model: Model, recording: Recording, bench: np.ndarray, chosen: str, step: float | None) -> Twin:
    """A twin started at a recording's first sample; ``chosen`` is an input from ``choose_input``.

    Raises InputError if it cannot follow the recording.
    """
    if chosen == "command" and not (model.value("drive.position_gain") and model.value("drive.speed_gain")):
        raise InputError(
            f"model {model.name}: has no drive.position_gain and drive.speed_gain to follow a command with; give them, "
            "or choose --input current"
        )
    refuse_recording_beyond_link(model, recording, chosen)
    twin = Twin(model, "standalone" if chosen == "command" else chosen, step=step, switchable=False)
    first = dict(zip(BENCH, bench[0], strict=True))
    twin.start(first, recording.motor_angle_origin, recording.output_angle_origin)
    return twin


def followed(twin: Twin, recording: Recording, bench: np.ndarray, rows: slice = slice(None)) -> np.ndarray:
    """Rows (n, signals) of a started twin over a recording, or over consecutive ``rows`` of it.

    Raises InputError if it diverges.
    """
    try:
        return twin.follow(recording.stamps[rows], bench)
    except InputError as error:
        raise InputError(f"{recording.name}: {error}") from None


def seen(model: Model, recording: Recording, rows: np.ndarray) -> Recording:
    """A twin's rows (n, signals, ``layout.TWIN``) as a recording of its own."""
    signals = {name: rows[:, k] for k, name in enumerate(TWIN) if not np.isnan(rows[1:, k]).all()}
    return twin_of(recording, model, signals)
