"""The motion that shows an effect, in words."""

SHOWN_BY = {
    "viscous_friction": "motion at several speeds",
    "coulomb_friction": "slow motion in both directions",
    "stribeck_friction": "slow ramps, down to a tenth of the speeds of these",
    "asymmetric_friction": "motion in both directions",
    "presliding_friction": "many slow reversals, such as a triangle of small travel",
    "quadratic_drag": "fast motion",
    "shear_thinning": "ramps from slow to fast",
    "thermal_friction": "a cold start, and several time constants of fast motion",
    "mesh_friction": "motion under load: a spring, a weight, hard acceleration",
    "sun_runout": "slow motion over several motor turns, in both directions",
    "mesh_ripple": "slow motion over several motor turns",
    "tooth_fault": "slow motion over several passes of the tooth",
    "cogging": "slow motion over a motor turn",
    "torque_ripple": "slow motion under load",
    "current_offset": "slow motion over several motor turns",
    "phase_short": "slow motion under load, over several motor turns",
    "rotor_eccentricity": "slow motion under load, over several motor turns",
    "torque_constant_error": "hard acceleration of a known inertia",
    "added_inertia": "hard acceleration: steps, fast sines",
    "constant_load": "motion in both directions",
    "gravity_load": "travel over a large part of an output turn",
    "output_ripple": "travel over a large part of an output turn",
    "spring_load": "travel as large as the machine allows, in both directions",
    "backlash": "reversals, with the output encoder recorded",
    "shaft_compliance": "steps or fast sines, with the output encoder recorded",
    "encoder_delay": "fast motion, with the output encoder recorded",
    "encoder_eccentricity": "travel over a large part of an output turn, with the output encoder recorded",
}
"""The motion that shows each effect."""
ANY = "motion over all speeds, positions and directions that it may depend on"
INERTIA_SHOWN_BY = "hard acceleration: steps, fast sines"
