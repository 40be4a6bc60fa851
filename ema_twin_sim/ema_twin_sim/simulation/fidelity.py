"""Turn a model into the inputs of the finer fidelities: the switching drive's winding, the planetary train's meshes."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from ema_bench_replay.errors import InputError

from ..effects import catalogue
from ..model import Model
from ..model.constants import CONSTANTS
from ..model.planetary_constants import DAMAGED_WHEELS, PLANETARY_CONSTANTS, RUNOUT_WHEELS
from ..model.roles import SPRING
from ..plant.energy import ENERGIES
from ..plant.layout import Fine
from ..plant.planetary.friction_coefficient import FRICTION_LAWS, dynamic_viscosity
from ..plant.planetary.geometry import Gearing
from ..plant.planetary.inertia import (
    TrainInertia,
    default_inertia,
    equivalent_masses,
    natural_frequencies,
    shaft_damping,
)
from ..plant.planetary.layout import LANE, LANES, MESHES, PLANETS, ROW, TRAIN, TRAIN_STATE, TURN
from ..plant.planetary.mesh_table import mean_stiffness, mesh_table
from ..plant.planetary.phases import mesh_phases, opposite_flank
from ..plant.switching.current_reference import phase_amplitude
from ..plant.switching.layout import WINDING, resting
from .unknown_controller import stepped_cycle

TANGENTIAL_RATIO = 0.8
"""Tangential over normal stiffness of a contact: 2 (1 - nu) / (2 - nu) with Poisson's ratio nu (Mindlin 1949)."""
STIFFER_ACROSS = 1.1
"""Factor by which that raises a train's highest frequency at most: friction's arms are at most half a mesh's radii."""
FINE_STEP = 1e-6
"""s, of the thesis (simulation.DT): one or two orders below the time constants of the electronics."""
DEFAULT_STEP = 25e-6
"""s, unless drive or train needs less. The tests show that it is converged: halving or doubling it changes no RMSE by
1 %."""
CYCLE_SHARE = 0.2
"""DEFAULT_STEP as a share of the usual control cycle, for models in own units."""
REFRESH = 1.0 / 2048.0
"""Mesh cycles after which stiffness and arms are updated: an eighth of the table's grid."""


@dataclass(frozen=True)
class FineParts:
    """The constant parts: ``winding`` (1,), ``train`` (1,), ``table`` (3, points + 1, 4), ``damping`` lanes."""

    switching: bool
    planetary: bool
    winding: np.ndarray
    train: np.ndarray
    table: np.ndarray
    frequency: float  # rad/s, the train's highest; 0 without one


def is_fine(model: Model) -> bool:
    """Whether a model has a part that takes steps of about 1 us."""
    return model.kinds["drive"] == "switching" or model.kinds["transmission"] == "planetary"


def fine_parts(model: Model, plant: np.void) -> FineParts:
    """The constant parts of a model's fidelities; a missing part is a placeholder.

    ``plant`` is its record of ``plant.layout.PLANT``, after all effects were applied.
    Raises InputError if teeth do not mesh or cannot be assembled.
    """
    if not is_fine(model):
        return LUMPED
    switching = model.kinds["drive"] == "switching"
    planetary = model.kinds["transmission"] == "planetary"
    train, table, frequency = _train(model, plant) if planetary else (LUMPED.train, LUMPED.table, 0.0)
    return FineParts(switching, planetary, _winding(model) if switching else LUMPED.winding, train, table, frequency)


def own_step(model: Model, asked: float | None) -> float:
    """The step of a model in own units, or of one without a drive: a fifth of a control cycle instead of 25 µs.

    ``asked`` is another one than these 25 µs.
    """
    return (asked or DEFAULT_STEP) / DEFAULT_STEP * CYCLE_SHARE * stepped_cycle(model)


def usual_step(parts: FineParts) -> float:
    """The default step [s]: 1 us for a switching drive, 0.3 of the longest allowed step for a train."""
    step = FINE_STEP if parts.switching else DEFAULT_STEP
    return min(step, 0.6 / parts.frequency) if parts.planetary else step


def resting_state(parts: FineParts) -> Fine:
    """All kernel inputs, at rest and without current."""
    state = np.zeros(1, TRAIN_STATE)
    state["friction_coefficient"] = parts.train["friction_coefficient"][0]
    lanes, energies = np.zeros(LANES), np.zeros(len(ENERGIES))
    return with_parts(Fine(parts.winding, resting(), parts.train, state, lanes, parts.table, energies), parts)


def with_parts(fine: Fine, parts: FineParts) -> Fine:
    """The same state with other constants, after a running twin's parameters have changed."""
    for mesh in range(len(MESHES)):
        fine.lanes[ROW["DAMPING_SUN"] + LANE * mesh :][:PLANETS] = parts.train["damping"][0, mesh]
    fine.train_states["mesh_read"] = np.inf  # forces an update
    return fine._replace(windings=parts.winding, trains=parts.train, mesh_table=parts.table)


def kept(state: np.ndarray, fine: Fine) -> tuple[bytes, ...]:
    """The variable state of a twin, for ``restored``; as bytes, since this copies records ten times as fast."""
    return tuple(array.tobytes() for array in _changing(state, fine))


def restored(before: tuple[bytes, ...], state: np.ndarray, fine: Fine) -> tuple[np.ndarray, Fine]:
    """State and parts restored from ``kept``, with the dtypes of these."""
    own, winding_state, train_state, lanes, energies = (
        np.frombuffer(held, array.dtype).copy() for held, array in zip(before, _changing(state, fine), strict=True)
    )
    return own, fine._replace(winding_states=winding_state, train_states=train_state, lanes=lanes, energies=energies)


def _changing(state: np.ndarray, fine: Fine) -> tuple[np.ndarray, ...]:
    return state, fine.winding_states, fine.train_states, fine.lanes, fine.energies


def set_in_motion(fine: Fine, parts: FineParts, speed: float, current: float, angle: float) -> None:
    """Let a resting train turn with the motor at ``speed`` [rad/s].

    Set the phase currents for a quadrature ``current`` [A] at the motor's ``angle`` [rad].
    """
    if parts.planetary:
        of = fine.trains[0]
        carrier = speed * of["sun_radius"] / (of["sun_radius"] + of["ring_radius"])
        fine.train_states["sun_speed"] = speed
        fine.train_states["carrier_speed"] = carrier
        fine.lanes[ROW["SPIN_SPEED"] :][:PLANETS] = carrier * (1.0 - of["ring_radius"] / of["planet_radius"])
    if parts.switching:
        winding, state = fine.windings.view(np.recarray)[0], fine.winding_states
        shift = winding["pole_pairs"] * angle
        peak = current * phase_amplitude.py_func(winding)
        for k, phase in enumerate("uvw"):
            state[f"phase_current_{phase}"] = peak * math.sin(shift - k * TURN / 3.0)
        state["quadrature_current"] = current
        state["quadrature_voltage"] = winding["back_emf_constant"] * speed + winding["phase_resistance"] * peak


def _ones(kind: np.dtype) -> np.ndarray:
    """A placeholder record for a missing part: divided by, but never used."""
    record = np.zeros(1, kind)
    for name in kind.names or ():
        record[name] = 1
    return record


LUMPED = FineParts(False, False, _ones(WINDING), _ones(TRAIN), np.zeros((3, 2, 4)), 0.0)
"""Parts of a model with neither a winding nor a train."""


def _winding(model: Model) -> np.ndarray:
    for name in ("phase_inductance", "back_emf_constant"):
        if not model.value(f"machine.{name}") > 0.0:
            raise InputError(f"model {model.name}: machine.{name} is 0; a switching drive needs it")
    winding = np.zeros(1, WINDING)
    record = winding[0]
    for path, constant in CONSTANTS.items():
        if constant.name in (WINDING.names or ()) and path in model.constants:
            record[constant.name] = model.value(path)
    record["trapezoidal"] = model.choices["machine.back_emf_shape"] == "trapezoidal"
    record["magnet_strength"] = 1.0
    for instance in model.active.values():
        settle = catalogue()[instance.effect].settle_winding
        if settle is not None:
            settle(record, instance.parameters, instance.options)
    return winding


def gearing_of(model: Model) -> Gearing:
    """The wheels of a planetary model. Raises InputError if they do not mesh or cannot be assembled."""
    numbers = {}
    for field in fields(Gearing):
        value = model.value(f"transmission.{field.name}")
        whole = field.name.endswith("_teeth") and value == round(value)
        numbers[field.name] = round(value) if whole else value
    return _gearing(f"model {model.name}: transmission", tuple(numbers.items()))


@lru_cache(maxsize=32)
def _gearing(place: str, numbers: tuple[tuple[str, float], ...]) -> Gearing:
    return Gearing(**dict(numbers), place=place)  # type: ignore[arg-type]


_table = lru_cache(maxsize=32)(mesh_table)


def inertia_of(model: Model, gearing: Gearing) -> TrainInertia:
    """The wheels' inertias: as given, otherwise their shares of the gearbox inertia."""
    by_share = default_inertia(gearing, model.value("machine.gearbox_inertia"))
    sun, planet, carrier = (model.value(f"transmission.{wheel}_inertia") for wheel in ("sun", "planet", "carrier"))
    return TrainInertia(
        sun or by_share.sun,
        planet or by_share.planet,
        0.0 if carrier else by_share.planet_mass,  # a given carrier inertia includes its planets' masses
        carrier or by_share.carrier,
    )


def _train(model: Model, plant: np.void) -> tuple[np.ndarray, np.ndarray, float]:
    """(record (1,), mesh table, highest frequency [rad/s]) of a model's planetary train.

    Effects on the plant apply to the train, too: backlash (``gap``) is that of its output meshes, compliance
    (``two_inertia`` without a gap) that of the shaft before its sun.
    """
    gearing = gearing_of(model)
    value = {c.name: model.value(c.path) for c in PLANETARY_CONSTANTS}
    table = _table(gearing, model.choices["transmission.mesh_stiffness"], value["youngs_modulus_ratio"])
    inertia = inertia_of(model, gearing)
    if not min(inertia.sun, inertia.planet) > 0.0:
        raise InputError(
            f"model {model.name}: machine.gearbox_inertia is 0, so that the train's wheels have none; give it, or "
            "transmission.sun_inertia, planet_inertia and carrier_inertia"
        )
    motor = float(plant["motor_inertia"]) - model.value("machine.gearbox_inertia")
    output = float(plant["output_inertia"])
    if not output > 0.0:
        raise InputError(f"model {model.name}: machine.output_inertia is 0; a planetary train needs it")
    train = np.zeros(1, TRAIN)
    record = train[0]
    for name in TRAIN.names or ():
        if name in value:
            record[name] = value[name]
    for name in ("sun_radius", "planet_radius", "ring_radius", "second_planet_radius", "output_ring_radius"):
        record[name] = getattr(gearing, name)
    shaft = value["shaft_stiffness"]
    if SPRING in model.active:
        shaft = plant["contact_stiffness"] if shaft == 0.0 else 1.0 / (1.0 / shaft + 1.0 / plant["contact_stiffness"])
        record["shaft_stiffness"] = shaft
    flexible = shaft > 0.0
    record["input_inertia"] = motor + (0.0 if flexible else inertia.sun)
    record["sun_inertia"] = inertia.sun
    record["planet_inertia"] = inertia.planet
    record["carrier_inertia"] = inertia.carrier + 3.0 * inertia.planet_mass * gearing.centre_distance**2
    if flexible:
        record["shaft_damping"] = (
            plant["contact_damping"]
            if SPRING in model.active
            else shaft_damping(shaft, inertia.sun, value["shaft_damping_ratio"])
        )
    masses = equivalent_masses(gearing, inertia, 0.0 if flexible else motor)
    record["damping"] = 2.0 * value["mesh_damping_ratio"] * np.sqrt(mean_stiffness(table) * masses)
    record["half_play"] = [0.5 * value[f"{mesh}_mesh_play"] for mesh in MESHES]
    record["half_play"][2] += gearing.output_ring_radius * plant["gap"] / plant["gear_ratio"]
    record["mesh_phase"] = mesh_phases(gearing)[:, 0]
    record["opposite_flank"] = opposite_flank(gearing)
    record["friction_law"] = FRICTION_LAWS.index(model.choices["transmission.mesh_friction"])
    record["viscosity"] = dynamic_viscosity(
        value["lubricant_temperature"], value["walther_slope"], value["walther_intercept"], value["lubricant_density"]
    )
    record["pitch_curvature"] = [mesh.equivalent_radius for mesh in gearing.meshes]
    record["tangential_stiffness"] = TANGENTIAL_RATIO * mean_stiffness(table)
    record["tooth_damage"] = [value[f"{wheel}_tooth_damage"] for wheel in DAMAGED_WHEELS]
    record["damaged_tooth"] = [value[f"{wheel}_damaged_tooth"] for wheel in DAMAGED_WHEELS]
    record["runout"] = [value[f"{wheel}_runout"] for wheel in RUNOUT_WHEELS]
    record["runout_phase"] = [value[f"{wheel}_runout_phase"] for wheel in RUNOUT_WHEELS]
    record["refresh"] = REFRESH
    frequency = STIFFER_ACROSS * float(natural_frequencies(gearing, table, inertia, motor, output)[-1])
    if flexible:
        frequency = math.hypot(frequency, math.sqrt(shaft / inertia.sun))
    return train, table, frequency
