"""Rotor eccentricity: T = Kt * i * amplitude / 2 * cos((2 P + 1) theta + phase) [N m], for P pole pairs.

A rotor off centre by a share of the air gap multiplies the flux of phase k (0, 1, 2 for u, v, w) by 1 + amplitude
cos(theta + phase - 2 pi k / 3). With imposed sinusoidal currents the torque keeps its mean: of all products with the
phase currents only those at the order 2 P + 1 add up (``plant/switching/windings.py``). In a switching drive the
winding itself is eccentric.
"""

import cmath
import math

from .effect import Effect, Implausible, Parameter, Trait


def act(at, p):
    """Torque [N m] at the motor counter's angle."""
    return 0.5 * p[0] * at.motor_torque * math.cos(2.0 * at.electrical_angle + at.motor_angle + p[1])


def settle_winding(winding, parameters, options):
    """Add the displacement to that of the winding."""
    has = cmath.rect(winding["eccentricity"], winding["eccentricity_phase"])
    off = has + cmath.rect(parameters["amplitude"], parameters["phase"])
    winding["eccentricity"], winding["eccentricity_phase"] = abs(off), cmath.phase(off)


EFFECT = Effect(
    id="rotor_eccentricity",
    summary="rotor off the centre of the stator",
    equation="T = Kt · i · amplitude/2 · cos((2P + 1)θ + phase), P pole pairs",
    depends_on="order",
    signature="current error of twice the electrical order and one (9), in proportion to the current",
    shown_by="slow motion under load, over several motor turns",
    source="Dalla Vedova, Germana, Berri and Maggiore, Aerospace 6, 2019, 94",
    parameters=(
        Parameter("amplitude", "1", 0.15, 0.0, 0.99, "displacement of the rotor's axis over the air gap"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "its direction at the motor counter's zero", periodic=True),
    ),
    act=act,
    settle_winding=settle_winding,
    electrical=True,
    repeatable=False,
    traits=(Trait.BY_CURRENT,),
    implausible=(
        Implausible(
            "amplitude",
            lambda v, c: v["amplitude"] > 0.6,
            "the magnets' pull would have closed the gap: is it torque ripple of that order?",
        ),
    ),
)
