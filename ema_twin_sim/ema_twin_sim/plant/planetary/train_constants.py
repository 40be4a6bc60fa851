"""Constants of a step derived from a train's constants, computed once for all steps of one length."""

from typing import NamedTuple

from ..compiled import compiled
from .layout import TURN


class TrainConstants(NamedTuple):
    """Constants for steps of one length; the arms of the carrier follow from the coordinates (``train.py``)."""

    step: float  # s
    # base radii, and the carrier's arm at each mesh [m]
    sun_radius: float
    planet_radius: float
    second_planet_radius: float
    output_ring_radius: float
    carrier_arm_sun: float
    carrier_arm_ring: float
    carrier_arm_output: float
    half_play_sun: float  # m
    half_play_ring: float
    half_play_output: float
    across_sun: float  # N s/m, tooth friction built up in a step per sliding speed
    across_ring: float
    across_output: float
    planet_gain: float  # s/(kg m2), change of a planet's speed per torque in a step
    carrier_gain: float
    # mesh cycles per rad, and of the first planet at zero travel
    sun_cycles: float
    ring_cycles: float
    output_cycles: float
    sun_cycle_origin: float
    ring_cycle_origin: float
    output_cycle_origin: float


@compiled
def train_constants(train, origin, step):
    """The constants of steps of ``step`` [s] for a record of ``layout.TRAIN``, with the sun at ``origin`` [rad].

    The counters do not show which teeth of planets and rings were in contact at the start, so it is assumed: the wheels
    start at the angles of a rigid train with the sun at its origin.
    """
    sun_cycles = train.sun_teeth / TURN
    ring_cycles = train.ring_teeth / TURN
    output_cycles = train.output_ring_teeth / TURN
    carrier, output = rigid_angles(train, origin)
    return TrainConstants(
        step,
        train.sun_radius,
        train.planet_radius,
        train.second_planet_radius,
        train.output_ring_radius,
        train.sun_radius + train.planet_radius,
        train.planet_radius - train.ring_radius,
        train.second_planet_radius - train.output_ring_radius,
        train.half_play[0],
        train.half_play[1],
        train.half_play[2],
        step * train.tangential_stiffness[0],
        step * train.tangential_stiffness[1],
        step * train.tangential_stiffness[2],
        step / train.planet_inertia,
        step / train.carrier_inertia,
        sun_cycles,
        ring_cycles,
        output_cycles,
        sun_cycles * (origin - carrier) + train.mesh_phase[0],
        ring_cycles * carrier + train.mesh_phase[1],
        output_cycles * (carrier - output) + train.mesh_phase[2],
    )


@compiled
def rigid_angles(train, sun):
    """Angles [rad] of carrier and output ring of a rigid train with the sun at ``sun``."""
    carrier = sun * (train.sun_radius / (train.sun_radius + train.ring_radius))
    to_output = 1.0 - train.ring_radius * train.second_planet_radius / (train.planet_radius * train.output_ring_radius)
    return carrier, carrier * to_output
