"""The constants of a planetary train: teeth, dimensions, material, friction, condition.

Backlash and run-out are lengths along the line of action. Without condition parameters the gearbox is healthy. Sources
and equations: ``plant/planetary``.
"""

from math import inf

from .constant import Constant

DAMAGED_WHEELS = {"sun": "sun", "planet": "first planet", "ring": "fixed ring", "output_ring": "output ring"}
RUNOUT_WHEELS = {
    "sun": "sun",
    "planet": "first planet's first toothing, against its second",
    "output_ring": "output ring",
}
_MESHES = {"sun": "sun-planet", "ring": "planet-ring", "output": "planet-output ring"}


def _row(name: str, unit: str, lower: float, upper: float, description: str, usual: float | None = None) -> Constant:
    return Constant("transmission", name, unit, lower, upper, description, kind="planetary", usual=usual)


PLANETARY_CONSTANTS = (
    _row("sun_teeth", "1", 12.0, 500.0, "teeth of the sun"),
    _row("planet_teeth", "1", 12.0, 500.0, "teeth of the planets on sun and fixed ring"),
    _row("ring_teeth", "1", 12.0, 1000.0, "teeth of the fixed ring"),
    _row("second_planet_teeth", "1", 12.0, 500.0, "teeth of the planets on the output ring"),
    _row("output_ring_teeth", "1", 12.0, 1000.0, "teeth of the output ring"),
    _row("sun_base_radius", "m", 1e-4, 10.0, "base radius of the sun; all others follow the teeth"),
    _row("tip_radius", "m", 1e-4, 10.0, "tip radius of the sun; all wheels have its addendum"),
    _row("pressure_angle", "rad", 0.1, 0.7, "operating pressure angle"),
    _row("profile_shift", "1", -0.9, 2.0, "profile shift in modules, in the stiffness of the teeth", 0.0),
    _row("face_width", "m", 1e-4, 10.0, "face width of all wheels"),
    _row("youngs_modulus_ratio", "1", 1e-5, 2.0, "Young's modulus of the teeth over that of steel"),
    _row("mesh_damping_ratio", "1", 0.0, 1.0, "damping of each mesh over its critical one"),
    _row("sun_inertia", "kg m^2", 0.0, inf, "inertia of the sun; 0 by its share of the gearbox's", 0.0),
    _row("planet_inertia", "kg m^2", 0.0, inf, "inertia of one planet about its axis; 0 by its share", 0.0),
    _row("carrier_inertia", "kg m^2", 0.0, inf, "inertia of the carrier with its planets' masses; 0 by its share", 0.0),
    _row("shaft_stiffness", "N m/rad", 0.0, inf, "torsion of the shaft from motor to sun; 0 rigid", usual=0.0),
    _row("shaft_damping_ratio", "1", 0.0, 1.0, "damping of that shaft over its critical one", usual=0.05),
    *(_row(f"{key}_mesh_play", "m", 0.0, 1e-2, f"play of the {name} meshes", 0.0) for key, name in _MESHES.items()),
    _row("friction_coefficient", "1", 0.0, 1.0, "sliding friction of the teeth, where it is constant", usual=0.0),
    _row("roughness", "m", 1e-9, 1e-3, "mean roughness Ra of the flanks", usual=1e-6),
    _row("lubricant_temperature", "K", 200.0, 500.0, "temperature of the lubricant", usual=293.15),
    _row("lubricant_density", "kg/m^3", 100.0, 3000.0, "density of the lubricant at 288 K", usual=869.0),
    _row("walther_slope", "1", -10.0, 0.0, "slope of the lubricant's viscosity over temperature (Walther)", -1.890758),
    _row("walther_intercept", "1", 0.0, 50.0, "intercept of the same", usual=10.5253),
    *(
        row
        for key, name in DAMAGED_WHEELS.items()
        for row in (
            _row(
                f"{key}_tooth_damage",
                "1",
                0.0,
                1.0,
                f"share of its stiffness that one tooth of the {name} has lost",
                0.0,
            ),
            _row(f"{key}_damaged_tooth", "1", 0.0, 1000.0, f"which tooth of the {name} that is, from 0", 0.0),
        )
    ),
    *(
        row
        for key, name in RUNOUT_WHEELS.items()
        for row in (
            _row(f"{key}_runout", "m", 0.0, 1e-2, f"amplitude of the run-out of the {name}", 0.0),
            _row(f"{key}_runout_phase", "rad", -6.284, 6.284, f"phase of the run-out of the {name}", 0.0),
        )
    ),
)

PLANETARY_CHOICES: dict[str, tuple[str, ...]] = {
    "transmission.mesh_stiffness": ("alternating", "fourier", "constant"),
    "transmission.mesh_friction": ("constant", "iso_tr_14179_2", "iso_ts_6336_4"),
}
