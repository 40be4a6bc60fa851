"""One running twin: its state is carried from sample to sample. Parameters and effects may change in between."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.errors import InputError

from ..effects import catalogue
from ..model import EffectInstance, Model
from ..model.constants import CONSTANTS
from ..model.model import parameter_range
from ..plant.kernel import kernel
from ..plant.layout import (
    BENCH,
    COMMAND_IN,
    CURRENT,
    CURRENT_IN,
    ENCODER_MEMORY,
    INPUTS,
    LOAD_IN,
    MOTOR_POSITION_IN,
    OUT,
    SETPOINT,
    SETPOINT_IN,
    SPEED_IN,
    STANDALONE,
    STANDALONE_SPEED,
    STATE,
    TWIN,
    Fine,
)
from ..plant.row import Moment, write_signals
from ..plant.sensors import shown
from .angle_origins import angle_origins
from .assembly import Assembly, assemble
from .divergence import States, looks_lost, refuse_divergence, states_of
from .driving_flank import begin_behind_measured_motion, lead
from .fidelity import kept, own_step, resting_state, restored, set_in_motion, usual_step, with_parts
from .inside import Energies, Wheels, energies, wheels
from .longest_step import SAFE, longest_step, refuse_long_step
from .switchable import switchable as with_all_effects
from .unknown_controller import control_cycle, without_controller

ROWS_AT_A_TIME = 500
"""Samples after which a simulation that diverges is stopped."""

JUMPED = 0.5  # share of a setpoint that the shaft has not reached yet if the recording begins at a step


@dataclass(frozen=True)
class ParameterDescription:
    """A model value that can be set on a running twin."""

    path: str
    value: float
    unit: str
    lower: float
    upper: float
    description: str


class Twin:
    """A twin that answers each bench sample with its own.

    ``source`` is the input that drives it: ``setpoint`` (the recorded speed setpoint), ``current`` (the measured
    current) or ``standalone`` (its own position command; ``standalone_speed`` for a speed command). All effects of the
    catalogue can be switched: those that the model lacks are present with default parameters, switched off (unless
    ``switchable`` is false, which is faster). ``step`` [s] is the integration step, by default that of the model's
    fidelity. ``accounting`` also records all energies (``energies``); it needs a finer fidelity than averaged and
    lumped.
    """

    def __init__(
        self,
        model: Model,
        source: str = "setpoint",
        *,
        step: float | None = None,
        accounting: bool = False,
        switchable: bool = True,
    ) -> None:
        if source not in INPUTS:
            raise InputError(f"input '{source}' is not known; give one of {', '.join(INPUTS)}")
        longest = max(1e-3, control_cycle(model))
        if step is not None and not 1e-8 <= step <= longest:
            raise InputError(f"step {step} s is out of range; give 1e-8 to {longest:g} s")
        if switchable:
            model = with_all_effects(model)
        self.source = INPUTS.index(source)
        self._asked_step = step
        self._accounting = accounting
        self._fine: Fine | None = None
        self._state = np.zeros(1, STATE)
        self._stamps = np.zeros(2, np.int64)
        self._bench = np.full((2, len(BENCH)), math.nan)
        self._row = np.full((2, len(TWIN)), math.nan)
        self._take(model)

    @property
    def model(self) -> Model:
        """The present model, including switched-off effects."""
        return self._model

    @property
    def effects(self) -> Mapping[str, EffectInstance]:
        """The effects by instance name, including switched-off ones."""
        return self._model.effects

    @property
    def assembly(self) -> Assembly:
        """The model's arguments for a kernel."""
        return self._assembly

    @property
    def state(self) -> np.ndarray:
        """The state (1,) of ``plant.layout.STATE``."""
        return self._state

    @property
    def last_row(self) -> np.ndarray:
        """The last sample (signals,), columns ``layout.TWIN``."""
        return self._row[1]

    def parameters(self) -> list[ParameterDescription]:
        """Every value that can be set: the machine's constants and each effect's parameters."""
        found = [
            ParameterDescription(path, held.value, self._model.unit(path), c.lower, c.upper, c.description)
            for path, held in self._model.constants.items()
            for c in (CONSTANTS[path],)
        ]
        for name, instance in self._model.effects.items():
            effect = catalogue()[instance.effect]
            for p in effect.parameters:
                value = instance.parameters.get(p.name, p.default)  # of another law: it may be chosen in a run
                path = f"effects.{name}.{p.name}"
                lower, upper, unit = parameter_range(effect, p, self._model.motion)
                found.append(ParameterDescription(path, value, unit, lower, upper, p.description))
        return found

    def change(self, settings: Mapping[str, bool | float | str]) -> None:
        """Make several changes at once from the next sample on (see ``Model.with_settings``); none if one is refused.

        Raises InputError with the reason.
        """
        self._take(self._model.with_settings(settings))

    def start(
        self, sample: Mapping[str, float], motor_angle_origin: float = math.nan, output_angle_origin: float = math.nan
    ) -> dict[str, float]:
        """Start from a run's first sample and return the twin's signals there.

        The speed is the measured one; the drive's integrator holds the measured current, reduced by the demand of a
        setpoint that has just jumped; other states are zero. The output is in the middle of a backlash gap, unless the
        motor moves: then it is driven on one flank. ``*_angle_origin`` [rad] are the counters' readings at position
        zero.
        """
        speed = _known(sample.get("speed"))
        current = _known(sample.get("current"))
        state = self._state[0]
        self._state[:] = 0
        state["motor_speed"] = state["output_speed"] = state["smoothed_speed"] = speed
        state["current"] = state["current_setpoint"] = current
        state["integral"] = self._held_by_integrator(current, speed, sample.get("speed_setpoint", math.nan))
        state["speed_setpoint"] = _known(sample.get("speed_setpoint")) if self.source != STANDALONE else speed
        state["control_phase"] = self._assembly.plant["control_cycle"][0]  # a control cycle starts at the first stamp
        ratio = float(self._assembly.plant["gear_ratio"][0])
        origins = angle_origins(motor_angle_origin, output_angle_origin, ratio)
        output = -lead(self._assembly.plant[0], speed)
        state["output_angle"] = state["output_start"] = output
        state["twist"] = -output
        state["motor_angle_origin"], state["output_angle_origin"] = origins[0], origins[1] - output / ratio
        # assumes steady motion before the first sample, for a delayed encoder
        ages = np.arange(ENCODER_MEMORY) * self._assembly.plant["control_cycle"][0]
        state["encoder_memory"] = output - speed * (ages[::-1] + ages[1])  # the first cycle adds the present angle
        state["encoder_newest"] = ENCODER_MEMORY - 1
        begin_behind_measured_motion(state, self._assembly.plant[0], speed, _known(sample.get("motor_position")))
        self._fine = resting_state(self._parts)
        angle = float(state["motor_angle_origin"])
        set_in_motion(self._fine, self._parts, speed, current, angle)
        # plain Python: called once per run, so compiling would cost more than it saves
        plant, moving = (array.view(np.recarray)[0] for array in (self._assembly.plant, self._state))
        state["encoder_zero"] = shown.py_func(plant, moving, output, ages[1])
        self._stamps[:] = 0
        self._bench[1] = [sample.get(name, math.nan) for name in BENCH]
        winding = self._fine.winding_states if self._parts.switching and self.source != CURRENT else None
        self._row[1] = first_row(self._state, self._bench[1], self.source, self._assembly.plant, winding)
        return self._signals()

    def _held_by_integrator(self, current: float, speed: float, setpoint: float) -> float:
        """The torque [N m] in the speed controller's integrator at the first sample.

        It is the measured torque. If the setpoint has jumped and the shaft has not followed half of the way, part of
        that torque comes from the controller's gain, unless the drive has not responded yet.
        """
        plant = self._assembly.plant[0]
        torque = float(plant["nominal_torque_constant"]) * current
        error = setpoint - speed
        if not abs(error) > JUMPED * abs(setpoint) > 0.0:
            return torque
        rest = torque - float(plant["speed_gain"]) * error
        return min(torque, rest, key=abs)

    def advance(self, nanoseconds: int, sample: Mapping[str, float]) -> dict[str, float]:
        """Integrate over ``nanoseconds`` since the previous sample with interpolated input; returns the signals."""
        if nanoseconds <= 0:
            raise InputError(f"the next sample is {nanoseconds} ns after the last; stamps must move forward")
        self._stamps[1] = nanoseconds
        self._bench[0] = self._bench[1]
        self._bench[1] = [sample.get(name, math.nan) for name in BENCH]
        self._integrate(self._stamps, self._bench, self._row)
        return self._signals()

    def follow(self, stamps: np.ndarray, bench: np.ndarray) -> np.ndarray:
        """Start from the first row and integrate over all: the same arithmetic as sample by sample, in one call.

        ``stamps`` int64 (n,) in ns, ``bench`` float64 (n, 6) with the columns ``layout.BENCH``; returns float64
        (n, signals) with the columns ``layout.TWIN``. Call ``start`` first. Missing values of the driving signal, or of
        a measured load, are replaced in ``bench`` by the previous value.
        """
        rows = np.full((len(stamps), len(TWIN)), math.nan)
        rows[0] = self._row[1]
        self._integrate(np.ascontiguousarray(stamps), np.ascontiguousarray(bench, np.float64), rows)
        return rows

    def wheels(self) -> Wheels | None:
        """The present state of a planetary train's wheels; None for a lumped transmission, or before the start."""
        if self._fine is None or not self._parts.planetary:
            return None
        return wheels(self._fine, self._state, float(self._assembly.plant["gear_ratio"][0]))

    def energies(self) -> Energies:
        """Energies since the start; only for a twin with ``accounting``."""
        if self._fine is None or not self._accounting:
            raise ValueError("energies are booked by a started twin with accounting=True")
        return energies(self._parts, self._fine, self._assembly.plant, self._state, self.step)

    def _integrate(self, stamps: np.ndarray, bench: np.ndarray, rows: np.ndarray) -> None:
        """Integrate over all rows in blocks. Raises InputError if the simulation diverges."""
        hold_input(bench, self.source)
        fine = self._fine
        assert fine is not None  # start is called first
        for first in range(0, len(stamps) - 1, ROWS_AT_A_TIME):
            some = slice(first, first + ROWS_AT_A_TIME + 1)
            before = kept(self._state, fine)
            self._run(self._state, fine, stamps[some], bench[some], rows[some])
            if looks_lost(rows[some][-1]) and not self._brought_back(bench[some][-1]):
                self._refuse_divergence(before, stamps[some], bench[some])

    def _brought_back(self, now: np.ndarray) -> bool:
        """Whether a motion that the current alone drives was set to the measured one, in the bench's sample ``now``.

        Without friction in the model it runs away, which says nothing about the constants, and the unexplained torque
        is that of the measured motion. Values that are no numbers, and fine transmissions, are left to be refused.
        """
        state = self._state[0]
        moving = ("motor_angle", "motor_speed", "output_angle", "output_speed")
        if self.source != CURRENT or self._parts.planetary or not np.isfinite([state[name] for name in moving]).all():
            return False
        state["motor_speed"] = state["output_speed"] = state["smoothed_speed"] = _known(now[SPEED_IN])
        off = _known(now[MOTOR_POSITION_IN]) - state["motor_angle"]
        for angle in ("motor_angle", "output_angle", "encoder_memory"):
            state[angle] += off
        return True

    def _run(self, state: np.ndarray, fine: Fine, stamps: np.ndarray, bench: np.ndarray, rows: np.ndarray) -> None:
        assembly = self._assembly
        of_model = (assembly.plant, state, assembly.acting, assembly.effects, (*fine,))
        self._advance(*of_model, self.source, stamps, bench, rows, self.step, True)

    def _refuse_divergence(self, before: tuple[bytes, ...], stamps: np.ndarray, bench: np.ndarray) -> None:
        """Find, from a valid state on, when the simulation diverges."""
        fine = self._fine
        assert fine is not None

        def states_after(intervals: int, share: float) -> States:
            state, parts = restored(before, self._state, fine)
            rows = np.empty((len(stamps), len(TWIN)))
            whole = slice(0, intervals + 1)
            self._run(state, parts, stamps[whole], bench[whole], rows[whole])
            if share:
                last = slice(intervals, intervals + 2)
                times, inputs = stamps[last].copy(), bench[last].copy()
                times[1] = times[0] + round(share * float(times[1] - times[0]))
                inputs[1] = inputs[0] + share * (inputs[1] - inputs[0])
                self._run(state, parts, times, inputs, rows[:2])
            return states_of(state, parts, self._parts)

        start, _ = restored(before, self._state, fine)
        refuse_divergence(states_after, stamps, float(start[0]["time"]), f"model {self._model.name}: its simulation")

    def _signals(self) -> dict[str, float]:
        return dict(zip(TWIN, self._row[1].tolist(), strict=True))

    def _take(self, model: Model) -> None:
        assembly = assemble(model, by_current=self.source == CURRENT)
        parts = assembly.fine
        chosen = model.units is None and (self._asked_step is not None or not without_controller(model))
        if chosen or parts.switching or parts.planetary:
            step = self._asked_step or usual_step(parts)
            refuse_long_step(model, assembly, step)
        else:  # no user chose the step, so it is shortened instead of refused
            step = min(own_step(model, self._asked_step), SAFE * longest_step(assembly)[0])
        self.step = step
        self._model = model
        self._assembly = assembly
        self._parts = parts
        self._advance = kernel(parts.switching, parts.planetary, self._accounting)
        if self._fine is not None:
            self._fine = with_parts(self._fine, parts)


def first_row(
    state: np.ndarray, bench: np.ndarray, source: int, plant: np.ndarray, winding: np.ndarray | None
) -> np.ndarray:
    """The twin's sample at the first stamp (signals,): its initial state as the sensors show it.

    ``winding`` is the state (1,) of the winding if one is simulated.
    """
    held, constants = state[0], plant[0]
    of_motion = constants["back_emf_constant"] * held["motor_speed"]
    at = Moment(
        phase=held["control_phase"],
        angle=held["motor_angle"],
        speed=held["motor_speed"],
        acceleration=held["acceleration"],
        output_angle=held["output_angle"],
        smoothed_speed=held["smoothed_speed"],
        speed_setpoint=held["speed_setpoint"],
        current=held["current"],
        current_setpoint=held["current_setpoint"],
        voltage=of_motion + constants["phase_resistance"] * held["current"],
        torque=constants["torque_constant"] * held["current"],
        transmitted=0.0,
    )
    row = np.full(len(TWIN), math.nan)
    write_signals.py_func(row, bench, source == CURRENT, at, 0.0, 0.0)
    if winding is not None:
        row[OUT.voltage] = winding["quadrature_voltage"][0]
        row[OUT.direct_current] = winding["direct_current"][0]
        for phase in "uvw":
            row[getattr(OUT, f"phase_current_{phase}")] = winding[f"phase_current_{phase}"][0]
    return row


def hold_input(bench: np.ndarray, source: int) -> None:
    """Hold the previous value where the driving signal, or a measured load, is missing: a twin must not stay NaN."""
    column = {CURRENT: CURRENT_IN, SETPOINT: SETPOINT_IN, STANDALONE_SPEED: SETPOINT_IN, STANDALONE: COMMAND_IN}[source]
    for values in (bench[:, column], bench[:, LOAD_IN]):
        hold(values)


def hold(values: np.ndarray) -> None:
    """Replace each NaN by the previous value; zero before the first."""
    unknown = np.flatnonzero(np.isnan(values))
    if len(unknown) == len(values):
        values[:] = 0.0
        return
    for row in unknown:
        values[row] = values[row - 1] if row else 0.0


def _known(value: float | None) -> float:
    return 0.0 if value is None or math.isnan(value) else float(value)
