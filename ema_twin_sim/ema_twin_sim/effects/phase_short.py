"""Turn-to-turn short: a share of one phase's turns makes no torque, while the drive still imposes its current.

With imposed sinusoidal currents, phase k (0, 1, 2 for u, v, w) of a motor with P pole pairs makes the torque
Kt i (1 - cos(2 P theta - 4 pi k / 3)) / 3. The shorted share of it is lost:

    T = fraction / 3 * Kt * i * (1 - cos(2 P theta - 4 pi k / 3)) [N m]

In the averaged drive the mean reduces the torque per ampere, like a torque constant error, and the rest is ripple
proportional to the remaining torque. In a switching drive the winding itself has fewer turns (``windings.py``).
Phase u's flux is at the motor counter's zero. The current and the heat in the shorted loop are not modelled.
"""

import math

from .effect import Effect, Implausible, Parameter, Trait

_PHASES = ("u", "v", "w")
_APART = 4.0 * math.pi / 3.0  # rad of the ripple between two phases


def settle(plant, parameters, options):
    """Reduce torque per ampere and back-EMF by the mean loss."""
    plant["torque_constant"] *= 1.0 - parameters["fraction"] / 3.0
    plant["back_emf_constant"] *= 1.0 - parameters["fraction"] / 3.0


def act(at, p):
    """Torque [N m] that oscillates about that mean; p: fraction, phase number."""
    return -at.motor_torque * p[0] / (3.0 - p[0]) * math.cos(2.0 * at.electrical_angle - _APART * p[1])


def settle_winding(winding, parameters, options):
    """Reduce the active turns of the phase."""
    winding[f"active_turns_{options['phase']}"] *= 1.0 - parameters["fraction"]


EFFECT = Effect(
    id="phase_short",
    summary="turn-to-turn short: a share of one phase's turns makes no torque",
    equation="T = fraction/3 · Kt · i · (1 − cos(2·P·θ − 4πk/3)), P pole pairs, k = 0, 1, 2 for phase u, v, w",
    depends_on="order",
    signature="current error of twice the electrical order (8), in proportion to the current; less torque per ampere",
    shown_by="slow motion under load, over several motor turns",
    source="Dalla Vedova, Germana, Berri and Maggiore, Aerospace 6, 2019, 94",
    parameters=(Parameter("fraction", "1", 0.2, 0.0, 0.99, "share of the phase's turns that is shorted"),),
    options={"phase": _PHASES},
    option_value=lambda options: float(_PHASES.index(options["phase"])),
    act=act,
    settle=settle,
    settle_winding=settle_winding,
    electrical=True,
    repeatable=False,
    traits=(Trait.BY_CURRENT,),
    implausible=(
        Implausible(
            "fraction",
            lambda v, c: v["fraction"] > 0.6,
            "with most turns of a phase shorted the drive would have tripped: is it the torque constant?",
        ),
    ),
)
