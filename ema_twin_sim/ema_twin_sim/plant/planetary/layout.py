"""The planetary train's constants and state as records and lanes, so that compiled code reads them by name.

The nine meshes are in lanes of four, one entry per planet (the fourth is empty, so that a lane is as wide as a
processor's registers): ``*_SUN``, ``*_RING``, ``*_OUT`` are start indices in one flat array, with one value per planet.
"""

from __future__ import annotations

import math

import numpy as np

PLANETS = 3
LANE = 4
MESHES = ("sun", "ring", "output")
"""Mesh types, in the order of their lanes: sun-planet, planet-fixed ring, second planet-output ring."""

TRAIN = np.dtype(
    [
        # base radii [m]
        ("sun_radius", "f8"),
        ("planet_radius", "f8"),
        ("ring_radius", "f8"),
        ("second_planet_radius", "f8"),
        ("output_ring_radius", "f8"),
        # teeth
        ("sun_teeth", "f8"),
        ("planet_teeth", "f8"),
        ("ring_teeth", "f8"),
        ("second_planet_teeth", "f8"),
        ("output_ring_teeth", "f8"),
        ("mesh_phase", "f8", (3,)),  # mesh cycles, of the first planet in each type at zero angles
        ("opposite_flank", "f8", (3,)),  # mesh cycles c: a mesh at x is at c - x on its opposite flanks
        # inertias [kg m2] about the wheels' own axes
        ("input_inertia", "f8"),  # of everything that turns with the motor, including the sun if the shaft is rigid
        ("sun_inertia", "f8"),  # of the sun alone
        ("planet_inertia", "f8"),
        ("carrier_inertia", "f8"),  # including the planets' orbiting masses
        ("shaft_stiffness", "f8"),  # N m/rad between motor and sun; 0 rigid
        ("shaft_damping", "f8"),  # N m s/rad
        ("damping", "f8", (3,)),  # N s/m of each mesh
        ("half_play", "f8", (3,)),  # m on the line of action
        # friction of the teeth
        ("friction_law", "i8"),
        ("friction_coefficient", "f8"),
        ("roughness", "f8"),  # m
        ("viscosity", "f8"),  # Pa s
        ("face_width", "f8"),  # m
        ("pressure_angle", "f8"),  # rad
        ("pitch_curvature", "f8", (3,)),  # m, equivalent radius of curvature at the pitch point
        ("tangential_stiffness", "f8", (3,)),  # N/m of the contact perpendicular to the line of action, until it slides
        # condition
        ("tooth_damage", "f8", (4,)),  # share of stiffness lost: a tooth of sun, first planet, ring, output ring
        ("damaged_tooth", "f8", (4,)),
        ("runout", "f8", (3,)),  # m: sun, first planet, output ring
        ("runout_phase", "f8", (3,)),  # rad
        ("refresh", "f8"),  # mesh cycles after which stiffness and arms are updated
    ],
    align=True,
)

TRAIN_STATE = np.dtype(
    [
        ("sun_angle", "f8"),  # rad since the first sample
        ("sun_speed", "f8"),
        ("carrier_angle", "f8"),
        ("carrier_speed", "f8"),
        ("speed_before", "f8"),  # stored for energy accounting
        ("mesh_read", "f8", (3,)),  # mesh cycles at the last update of stiffness and arms
        ("friction_coefficient", "f8", (3,)),
    ],
    align=True,
)

_ROWS = (
    "SPIN",  # rad, a planet's absolute angle
    "SPIN_SPEED",  # rad/s
    *(
        f"{what}_{mesh}"
        for what in (
            "STIFFNESS",  # N/m
            "DAMPING",  # N s/m
            "ARM_1",  # m, friction's arm on the first-named wheel
            "ARM_2",  # m, on the second
            "RUNOUT",  # m
            "FORCE",  # N, along the line of action
            "FRICTION",  # N, perpendicular to it
            "DAMPED",  # N, the damper's part of the force
        )
        for mesh in ("SUN", "RING", "OUT")
    ),
    "ON_SUN",  # N m, torques of each planet's meshes
    "ON_CARRIER",
    "ON_OUTPUT",
    "SPEED_BEFORE",  # rad/s, of the planets, stored for energy accounting
)
ROW = {name: LANE * k for k, name in enumerate(_ROWS)}
LANES = LANE * len(_ROWS)
"""Length of the flat array of lanes."""

TURN = 2.0 * math.pi
