"""What no machine does: values that tell of a missing effect, and not of the one that carries them.

A missing structural effect shows as another's parameters that run to absurd values. Each rule stands on its reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..model.own_units import shown

Values = Mapping[str, float]


@dataclass(frozen=True)
class Circumstances:
    """What a value is judged by, SI at the fast shaft."""

    duration: float  # s, of the longest recording
    top_speed: float  # rad/s
    travel: float  # rad, of the motor
    output_travel: float  # rad, of the slow shaft
    dry_level: float  # N m, all Coulomb friction
    viscous: float  # N m s/rad
    motor_inertia: float  # kg m2, gearbox included
    output_inertia: float  # kg m2
    torque_limit: float  # N m
    limit_in_words: str  # the same with the unit of the model's file


@dataclass(frozen=True)
class Rule:
    """A parameter of an effect, when its value is absurd, and why."""

    effect: str
    parameter: str
    absurd: Callable[[Values, Circumstances], bool]
    reason: str


def circumstances(recordings: Sequence[Recording], model: Model) -> Circumstances:
    """Of these recordings and a fitted model."""
    positions = [r.signals["motor_position"] for r in recordings if r.has("motor_position")]
    travel = max((float(np.nanmax(position) - np.nanmin(position)) for position in positions), default=0.0)
    held = [instance for instance in model.effects.values() if instance.enabled]
    return Circumstances(
        duration=max(recording.duration for recording in recordings),
        top_speed=max(float(np.nanmax(np.abs(_speed(recording)))) for recording in recordings),
        travel=travel,
        output_travel=travel / model.value("machine.gear_ratio"),
        dry_level=sum(i.parameters["torque"] for i in held if i.effect == "coulomb_friction"),
        viscous=sum(i.parameters["coefficient"] for i in held if i.effect == "viscous_friction"),
        motor_inertia=model.value("machine.motor_inertia") + model.value("machine.gearbox_inertia"),
        output_inertia=model.value("machine.output_inertia"),
        torque_limit=model.value("drive.torque_limit"),
        limit_in_words="{:g} {}".format(*shown(model, model.value("drive.torque_limit"), "N m")),
    )


def _speed(recording: Recording) -> np.ndarray:
    """Speed (n,) [rad/s]: measured, or of the motor's position."""
    if recording.has("speed"):
        return recording.signals["speed"]
    return np.gradient(recording.signals["motor_position"], recording.time)


def damping_ratio(v: Values, c: Circumstances) -> float:
    """Of two inertias on a spring: damping / 2 * sqrt((1 / J_m + 1 / J_o) / stiffness)."""
    softness = 1.0 / c.motor_inertia + 1.0 / max(c.output_inertia, 1e-12)
    return 0.5 * v["damping"] * math.sqrt(softness / v["stiffness"])


RULES = (
    Rule(
        "shaft_compliance", "damping", lambda v, c: damping_ratio(v, c) > 1.0,
        "a shaft damped beyond its own ringing is no spring: is it a delay of the encoder?",
    ),
    Rule(
        "shaft_compliance", "damping", lambda v, c: damping_ratio(v, c) < 1e-4,
        "no shaft rings forever: is it play that makes it ring?",
    ),
    Rule(
        "shaft_compliance", "stiffness", lambda v, c: c.dry_level / v["stiffness"] > 0.5 * c.travel,
        "friction alone would wind the shaft up over half of all that moved",
    ),
    Rule(
        "encoder_delay", "delay", lambda v, c: v["delay"] > 8e-3,
        "an encoder answers within a few control cycles: is it compliance or play?",
    ),
    Rule(
        "encoder_eccentricity", "amplitude", lambda v, c: v["amplitude"] > 0.02,
        "an encoder that far off its centre would be seen to wobble: is it gravity on a soft shaft?",
    ),
    Rule(
        "torque_constant_error", "scale", lambda v, c: not 0.7 < v["scale"] < 1.3,
        "magnets lose some per cent, not a third: are inertia and friction of the model right?",
    ),
    Rule(
        "thermal_friction", "time_constant", lambda v, c: v["time_constant"] > 3.0 * c.duration,
        "far longer than the recordings: they show a slow drift and not its end; is it a spring or a load?",
    ),
    Rule(
        "thermal_friction", "fraction", lambda v, c: v["fraction"] > 0.9,
        "a warm lubricant does not lose nearly all its friction",
    ),
    Rule(
        "shear_thinning", "fraction", lambda v, c: v["fraction"] > 0.95,
        "a lubricant does not lose nearly all its friction: is the viscous coefficient too large?",
    ),
    Rule(
        "stribeck_friction", "speed", lambda v, c: v["speed"] > c.top_speed,
        "faster than anything recorded: it acts as plain Coulomb friction here",
    ),
    Rule(
        "stribeck_friction", "torque", lambda v, c: c.dry_level > 0.0 and v["torque"] > 5.0 * c.dry_level,
        "more than five times the sliding level: is the Coulomb friction taken too small?",
    ),
    Rule(
        "coulomb_friction", "static_ratio", lambda v, c: v["static_ratio"] > 5.0,
        "break-away is some times the sliding level, not that many",
    ),
    Rule(
        "asymmetric_friction", "fraction", lambda v, c: abs(v["fraction"]) > 0.6,
        "friction four times as large one way as the other: is it a constant load?",
    ),
    Rule(
        "sun_runout", "torque", lambda v, c: c.dry_level > 0.0 and v["torque"] > c.dry_level,
        "more than the Coulomb friction that it modulates: friction would be negative",
    ),
    Rule(
        "mesh_friction", "coefficient", lambda v, c: v["coefficient"] > 0.6,
        "more than half of what teeth carry does not go into their friction",
    ),
    Rule(
        "presliding_friction", "stiffness", lambda v, c: c.dry_level / v["stiffness"] > min(3.0, 0.5 * c.travel),
        "the contact would give way over half of all that moved: is it a spring load?",
    ),
    Rule(
        "presliding_friction", "damping", lambda v, c: v["damping"] > 10.0 * c.viscous > 0.0,
        "the bristle would damp more than all lubricant",
    ),
    Rule(
        "backlash", "width", lambda v, c: v["width"] > c.output_travel,
        "wider than the output ever moved: the gap was never crossed",
    ),
    Rule(
        "added_inertia", "inertia", lambda v, c: v["inertia"] > 3.0 * (c.motor_inertia + c.output_inertia),
        "more than three times the machine's own: is the model that of this machine?",
    ),
    Rule(
        "torque_ripple", "fraction", lambda v, c: v["fraction"] > 0.3,
        "a motor whose torque ripples by a third is broken: is it cogging?",
    ),
    Rule(
        "phase_short", "fraction", lambda v, c: v["fraction"] > 0.6,
        "with most turns of a phase shorted the drive would have tripped: is it the torque constant?",
    ),
    Rule(
        "rotor_eccentricity", "amplitude", lambda v, c: v["amplitude"] > 0.6,
        "the magnets' pull would have closed the gap: is it torque ripple of that order?",
    ),
    Rule(
        "quadratic_drag", "coefficient",
        lambda v, c: v["coefficient"] * c.top_speed**2 > 3.0 * (c.dry_level + c.viscous * c.top_speed) > 0.0,
        "more than three times all other friction at top speed: is the viscous friction taken too small?",
    ),
)  # fmt: skip
"""Every rule; a parameter may have several."""


def absurdities(effect: str, values: Values, units: Mapping[str, str], c: Circumstances) -> list[tuple[str, str]]:
    """(parameter, reason) of what is absurd in an effect's parameters."""
    found = [(r.parameter, r.reason) for r in RULES if r.effect == effect and r.absurd(values, c)]
    for name, value in values.items():
        if units[name] == "N m" and abs(value) > c.torque_limit:
            found.append((name, f"more than the drive's limit of {c.limit_in_words}: it could not move"))
    return found
