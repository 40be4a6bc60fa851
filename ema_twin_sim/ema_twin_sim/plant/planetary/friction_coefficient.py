"""Coefficient of friction of teeth: a constant, ISO/TR 14179-2 or ISO/TS 6336-4 (thesis, section 3.4.2).

Both standards give the mean over a mesh cycle for lubricated steel wheels at some metres per second. A dry printed
gearbox is far from that: the constant is the natural choice there.
"""

from __future__ import annotations

import math

from numba import njit

CONSTANT, ISO_TR_14179_2, ISO_TS_6336_4 = range(3)
FRICTION_LAWS = ("constant", "iso_tr_14179_2", "iso_ts_6336_4")
"""The names of the laws, in the order of their numbers."""

BOUNDARY_LUBRICATION = 0.2
"""Upper limit of a standard's coefficient.

Both grow without bound as the speed falls, since their lubricant film thins without limit. Without a film, boundary
lubrication remains: about 0.1 to 0.2 for oiled surfaces, at any speed. In the bench's ring mesh (0.3 N m, roughness
5 um, the script's thin oil) ISO/TR 14179-2 reaches the limit below 1.3 mm/s of rolling, slower than any ramp of the
thesis; ISO/TS 6336-4 below 111 mm/s, which includes the slower ramps. ``docs/physics.md`` measures both.
"""

KELVIN = 273.15  # of 0 degrees Celsius
WALTHER_SLOPE, WALTHER_LEVEL = -1.890758, 10.5253  # the script's c1 and c2
DENSITY = 869.0  # kg/m^3 at 15 degrees Celsius; the script's pho_lub, 0.869 kg/dm^3
DENSITY_PER_KELVIN = -0.001  # the script's psi


@njit(error_model="numpy")
def friction_coefficient(law, constant, line_load, sum_speed, curvature_radius, viscosity, roughness):
    """Coefficient of friction (1) of a mesh by ``law``: ``constant`` itself, or a standard's.

    ``line_load`` [N/m] is the mesh force over the face width, ``sum_speed`` [m/s] the sum of both flanks' rolling
    speeds and ``curvature_radius`` [m] their equivalent radius of curvature, both at the pitch point, ``viscosity``
    [Pa s] the lubricant's dynamic one and ``roughness`` [m] the mean of both flanks' R_a.

    The standards' formulas use N/mm, m/s, mm, mPa s and micrometres; this function converts:

        ISO/TR 14179-2 (eq. 3.31): 0.048 (F/b / (v rho))^0.2 eta^-0.05 R_a^0.25, with lubricant factor X_L = 1;
        ISO/TS 6336-4 (eq. 3.32): 0.143 (R_a F/b / (v rho eta))^0.25.

    The thesis's script omits F and rho in both, which gives about 0.005 instead of 0.04, and uses metres for the
    micrometres. Without load the coefficient is 0, at rest under load ``BOUNDARY_LUBRICATION``.
    """
    if law == CONSTANT:
        return constant
    if line_load <= 0.0:
        return 0.0
    contact = sum_speed * (1e3 * curvature_radius)
    load = 1e-3 * line_load
    eta = 1e3 * viscosity
    rough = 1e6 * roughness
    if law == ISO_TR_14179_2:
        coefficient = 0.048 * (load / contact) ** 0.2 * eta**-0.05 * math.sqrt(math.sqrt(rough))
    else:
        coefficient = 0.143 * math.sqrt(math.sqrt(rough * load / (contact * eta)))
    return coefficient if coefficient < BOUNDARY_LUBRICATION else BOUNDARY_LUBRICATION


def dynamic_viscosity(
    temperature: float, slope: float = WALTHER_SLOPE, level: float = WALTHER_LEVEL, density: float = DENSITY
) -> float:
    """Dynamic viscosity [Pa s] of the lubricant at a ``temperature`` [K], after Walther, as in the thesis's script.

    Kinematic viscosity 10^10^(slope ln T + level) in mm^2/s, without Walther's 0.7, times the ``density``, which is
    given in kg/m^3 at 15 degrees Celsius and falls by exp(-0.001 dT). The script's constants describe a very thin oil,
    3.5 mPa s at 20 degrees. Those in its comment (-2.999, 7.852) are for the decimal logarithm: with it they describe
    an oil of 214 mm^2/s at 40 degrees.
    """
    kinematic = 10.0 ** (10.0 ** (slope * math.log(temperature) + level))
    return 1e-6 * kinematic * density * math.exp(DENSITY_PER_KELVIN * (temperature - KELVIN - 15.0))
