"""Mesh friction: a dry level coefficient * |T_t| [N m], friction of the teeth proportional to their load.

T_t [N m at the fast shaft] is the torque transmitted to the output. Thesis, chapter 3.4 (sliding of the teeth).
"""

from .effect import DRY_LEVEL, Effect, Implausible, Parameter, Trait


def act(at, p):
    """Dry level [N m] under the transmitted torque."""
    return p[0] * abs(at.transmitted_torque)


EFFECT = Effect(
    id="mesh_friction",
    summary="friction of the gear teeth, in proportion to the load they carry",
    equation="L = coefficient · |T_t|",
    depends_on="load",
    signature="current error against the motion that grows with load and acceleration",
    shown_by="motion under load: a spring, a weight, hard acceleration",
    source="thesis, section 3.4; ISO/TR 14179-2",
    parameters=(Parameter("coefficient", "1", 0.1, 0.0, 1.5, "dry level per transmitted torque, both at fast shaft"),),
    act=act,
    place=DRY_LEVEL,
    traits=(Trait.FRICTION_UNDER_LOAD, Trait.LIKE_PLAY_OR_SPRING),
    told_by="friction that follows the load shows when the load on the output is changed",
    implausible=(
        Implausible(
            "coefficient",
            lambda v, c: v["coefficient"] > 0.6,
            "more than half of what teeth carry does not go into their friction",
            never=True,
        ),
    ),
)
