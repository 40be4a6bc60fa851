"""How each cause is put into the other plant: one function an id, with the catalogue's signs and parameters.

``put(plant, harmonics, bursts, values, options, random, seconds)`` writes into the plant's record and its two tables.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .layout import ON_MOTOR, ON_MOTOR_LEVEL, ON_MOTOR_TORQUE, ON_OUTPUT, ON_OUTPUT_LEVEL, SMOOTH_LAWS, STRIBECK_LAWS

MESH_ORDER = 15.75


def _adds(law: str = "", laws: Sequence[str] = (), **fields: str) -> Callable[..., None]:
    """Values that go to fields of the plant: field=parameter; and the number of the ``law`` among ``laws``."""

    def put(plant, harmonics, bursts, values, options, random, seconds):
        for name, parameter in fields.items():
            plant[name] = values[parameter]
        if law:
            plant[law] = laws.index(options.get("law", laws[0]))

    return put


def _swings(action: float, size: str, order: float | None = None, phase: str = "phase") -> Callable[..., None]:
    """A sine of an angle; its order may be an option."""

    def put(plant, harmonics, bursts, values, options, random, seconds):
        harmonics.append((values[size], float(options.get("order", order)), values[phase], action))

    return put


def _inertia(plant, harmonics, bursts, values, options, random, seconds):
    plant["output_inertia"] += values["inertia"]


def _presliding(plant, harmonics, bursts, values, options, random, seconds):
    plant["bristle_stiffness"] = values["stiffness"]
    plant["bristle_damping"] = values["damping"]
    plant["elastic_share"] = -1.0


def _mesh_ripple(plant, harmonics, bursts, values, options, random, seconds):
    order = float(options.get("order", MESH_ORDER))
    for k in (1, 3, 5):
        harmonics.append((values["torque"] / k, k * order, k * values["phase"], ON_MOTOR))


def _run_out(plant, harmonics, bursts, values, options, random, seconds):
    action = ON_MOTOR_LEVEL if options.get("kind", "dissipative") == "dissipative" else ON_MOTOR
    harmonics.append((values["torque"], 1.0, values["phase"], action))


def _tooth(plant, harmonics, bursts, values, options, random, seconds):
    order = float(options.get("order", "1"))
    plant["pulse"] = values["torque"]
    plant["pulse_order"] = order
    plant["pulse_position"] = values["position"]
    plant["pulse_width"] = 2.0 * math.pi * order / MESH_ORDER
    plant["pulse_is_level"] = options.get("kind", "dissipative") == "dissipative"


def _torque_constant(plant, harmonics, bursts, values, options, random, seconds):
    """Weaker magnets: less torque per ampere, and less back-EMF."""
    plant["torque_constant"] = values["scale"] * plant["believed_torque_constant"]
    plant["back_emf"] *= values["scale"]


def _phase_short(plant, harmonics, bursts, values, options, random, seconds):
    """A third of the torque is a phase's own, and swings between none and twice that; the shorted share is lost."""
    third = values["fraction"] / 3.0
    plant["torque_constant"] *= 1.0 - third
    plant["back_emf"] *= 1.0 - third
    lag = 4.0 * math.pi / 3.0 * "uvw".index(options["phase"])
    harmonics.append((third / (1.0 - third), 8.0, 0.5 * math.pi - lag, ON_MOTOR_TORQUE))


def _rotor_eccentricity(plant, harmonics, bursts, values, options, random, seconds):
    """What is left of flux that follows the gap, and of four pole pairs' currents, is their ninth order."""
    harmonics.append((0.5 * values["amplitude"], 9.0, values["phase"] - 0.5 * math.pi, ON_MOTOR_TORQUE))


def _backlash(plant, harmonics, bursts, values, options, random, seconds):
    plant["half_gap"] = 0.5 * values["width"] * plant["ratio"]


def _bursts(plant, harmonics, bursts, values, options, random, seconds):
    """Short bursts of extra friction at irregular times."""
    time = random.uniform(0.3, values["spacing"])
    while time < seconds:
        end = time + random.uniform(0.1, 0.5)
        bursts.append((time, end, values["torque"] * random.uniform(0.6, 1.4)))
        time = end + random.exponential(values["spacing"])


def _moods(plant, harmonics, bursts, values, options, random, seconds):
    """Friction that wanders within seconds, each recording in its own way."""
    plant["wander"] = values["fraction"]
    for name in ("", "_2"):
        plant[f"wander_period{name}"] = random.uniform(3.0, 9.0)
        plant[f"wander_phase{name}"] = random.uniform(0.0, 2.0 * math.pi)


UNKNOWN: dict[str, Callable[..., None]] = {
    "bursts": _bursts,
    "output_friction": _swings(ON_OUTPUT_LEVEL, "torque"),
    "odd_order": _swings(ON_MOTOR, "torque"),
    "friction_resonance": _adds(bump_level="torque", bump_speed="speed", bump_width="width"),
    "moods": _moods,
}
"""Causes that are in no catalogue."""

HIDE: dict[str, Callable[..., None]] = {
    # of the stock friction nothing: what is hidden is that the stock model lacks it
    "viscous_friction": _adds(),
    "coulomb_friction": _adds(),
    "stribeck_friction": _adds("stribeck_law", STRIBECK_LAWS, stribeck_level="torque", stribeck_speed="speed"),
    "smooth_friction": _adds("smooth_law", SMOOTH_LAWS, smooth_speed="speed"),
    "asymmetric_friction": _adds(asymmetry="fraction"),
    "presliding_friction": _presliding,
    "quadratic_drag": _adds(drag="coefficient"),
    "shear_thinning": _adds(thinning="fraction", thinning_speed="speed"),
    "thermal_friction": _adds(warming="fraction", warming_time="time_constant"),
    "mesh_friction": _adds(mesh_coefficient="coefficient"),
    "sun_runout": _run_out,
    "mesh_ripple": _mesh_ripple,
    "tooth_fault": _tooth,
    "cogging": _swings(ON_MOTOR, "torque", 24.0),
    "torque_ripple": _swings(ON_MOTOR_TORQUE, "fraction", 24.0),
    "current_offset": _swings(ON_MOTOR, "torque", 4.0),
    "phase_short": _phase_short,
    "rotor_eccentricity": _rotor_eccentricity,
    "torque_constant_error": _torque_constant,
    "added_inertia": _inertia,
    "constant_load": _adds(constant_load="torque"),
    "gravity_load": _swings(ON_OUTPUT, "torque", 1.0, "angle"),
    "spring_load": _adds(spring="stiffness"),
    "backlash": _backlash,
    "shaft_compliance": _adds(stiffness="stiffness", damping="damping"),
    "encoder_delay": _adds(delay="delay"),
    "encoder_eccentricity": _adds(eccentricity="amplitude", eccentricity_phase="phase"),
    **UNKNOWN,
}
"""All that can be hidden, by id."""

CATALOGUE = tuple(name for name in HIDE if name not in UNKNOWN)
"""The ids of the twin's catalogue that can be hidden."""
