"""Backlash: a dead zone of width [rad, slow shaft] between motor and output, +-ratio * width / 2 at the fast shaft.

Added to a rigid transmission, it makes it a two-inertia one with the model's contact stiffness and damping. The output
starts in the middle of the gap, unless the motor moves at the start: then the driving flank touches. Nordin and Gutman,
"Controlling mechanical systems with backlash" (2002).
"""

from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Set the gap of the transmission."""
    plant["two_inertia"] = 1.0
    plant["gap"] += 0.5 * parameters["width"] * plant["gear_ratio"]


EFFECT = Effect(
    id="backlash",
    summary="play in the gearbox",
    equation="no torque passes while |θ − ratio·θ_o| < ratio · width / 2",
    depends_on="encoders",
    signature="output position error that jumps by the width at each reversal; current bursts as the teeth meet again",
    shown_by="reversals, with the output encoder recorded",
    source="Nordin and Gutman 2002; thesis, script Main HF, dynamics.BLK",
    parameters=(
        Parameter(
            "width",
            "rad",
            0.0023,
            0.0,
            1.0,
            "dead zone at the slow shaft",
            starts=(0.0002, 0.0007, 0.002, 0.005),
            neutral=None,
        ),
    ),
    settle=settle,
    repeatable=False,
    traits=(Trait.PLAY,),
    implausible=(
        Implausible(
            "width",
            lambda v, c: v["width"] > c.output_travel,
            "wider than the output ever moved: the gap was never crossed",
        ),
    ),
)
