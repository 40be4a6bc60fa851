"""Constants of a step derived from a winding's constants, computed once for all steps of one length."""

from typing import NamedTuple

from ..compiled import compiled
from ..drive import lag_gain
from .current_reference import phase_amplitude


class StepConstants(NamedTuple):
    """Constants for steps of one length, separate for phases u, v, w if they may differ."""

    pole_pairs: float
    half_link: float  # V
    hysteresis: float  # A
    trapezoidal: float
    torque_limit: float  # N m
    amplitude: float  # A of phase current per A of quadrature current
    emf_u: float  # V s/rad
    emf_v: float
    emf_w: float
    resistance_u: float  # ohm, switch and winding
    resistance_v: float
    resistance_w: float
    response_uu: float  # A per V across phases u and w: change of u's current in a step
    response_uv: float  # A per V across v and w: change of u's current; symmetric
    response_vv: float
    eccentricity: float
    eccentricity_phase: float
    resolver_offset: float
    resolver_amplitude: float
    resolver_order: float
    resolver_phase: float
    current_scale: float  # A of quadrature current per A of the phases' sum
    voltage_scale: float  # V of quadrature voltage per V of the phases' sum
    filter_gain: float


@compiled
def step_constants(winding, step):
    """The constants of steps of ``step`` [s] for a record of ``layout.WINDING``.

    A phase with a share N of its turns has N of the back-EMF and the resistance and N^2 of the inductance (see
    ``windings.py``, which derives the responses too).
    """
    emf = winding.back_emf_constant * winding.magnet_strength
    resistance_u = winding.phase_resistance * winding.active_turns_u + winding.switch_resistance
    resistance_v = winding.phase_resistance * winding.active_turns_v + winding.switch_resistance
    resistance_w = winding.phase_resistance * winding.active_turns_w + winding.switch_resistance
    inductance = winding.phase_inductance / step
    gain_u = 1.0 / (inductance * winding.active_turns_u**2 + 0.5 * resistance_u)
    gain_v = 1.0 / (inductance * winding.active_turns_v**2 + 0.5 * resistance_v)
    gain_w = 1.0 / (inductance * winding.active_turns_w**2 + 0.5 * resistance_w)
    gains = gain_u + gain_v + gain_w
    amplitude = phase_amplitude(winding)
    trapezoidal = winding.trapezoidal != 0.0
    return StepConstants(
        winding.pole_pairs,
        0.5 * winding.dc_link_voltage,
        winding.hysteresis,
        winding.trapezoidal,
        winding.torque_limit,
        amplitude,
        emf * winding.active_turns_u,
        emf * winding.active_turns_v,
        emf * winding.active_turns_w,
        resistance_u,
        resistance_v,
        resistance_w,
        gain_u * (gain_v + gain_w) / gains,
        -gain_u * gain_v / gains,
        gain_v * (gain_u + gain_w) / gains,
        winding.eccentricity,
        winding.eccentricity_phase,
        winding.resolver_offset,
        winding.resolver_amplitude,
        winding.resolver_order,
        winding.resolver_phase,
        winding.back_emf_constant / winding.torque_constant,
        1.0 / 2.0 if trapezoidal else 2.0 / 3.0,
        lag_gain(step, winding.current_filter),
    )
