"""Geometry of the 3K planetary gearbox, and checks that it meshes and can be assembled (thesis, section 3.5, app. A).

The sun drives three equal planets, which roll on a fixed ring; a second toothing of each planet drives the output ring.
The number of planets is fixed at three. Teeth are straight: the tooth formulas of the thesis are for spur wheels,
although its gearbox is described as helical.

Radii follow from the teeth. The thesis's ring of 132 mm base radius, its pitch radii of 39.5 and 127.5 mm (centre
distances of 79 and 88 mm) and its module (base radius over teeth) are inconsistent with each other and with the teeth.
"""

from __future__ import annotations

import math
from dataclasses import InitVar, dataclass
from functools import cached_property

from ema_bench_replay.errors import InputError

from .contact import Mesh

PLANETS = 3
SUN_MESH, RING_MESH, OUTPUT_MESH = range(3)
FEWEST_TEETH = 12  # lower limit of Kuang and Yang's tooth stiffness


@dataclass(frozen=True)
class Gearing:
    """Teeth and dimensions of the train; the defaults are those of the thesis's script "dinamica riduttore".

    ``sun_base_radius`` and ``tip_radius`` (of the sun) and ``face_width`` are in m, ``pressure_angle`` in rad: the
    operating one, of all meshes. All wheels have the sun's module and addendum. ``profile_shift`` (in modules, of every
    wheel) only enters the stiffness of the teeth, since the radii given are the operating ones.

    ``place`` names the model in errors. Raises InputError if such wheels do not mesh or cannot be assembled.
    """

    sun_teeth: int = 21
    planet_teeth: int = 21
    ring_teeth: int = 63
    second_planet_teeth: int = 20
    output_ring_teeth: int = 62
    sun_base_radius: float = 0.035
    pressure_angle: float = math.radians(22.5)
    tip_radius: float = 0.0406
    face_width: float = 0.018
    profile_shift: float = 0.0
    place: InitVar[str] = ""

    def __post_init__(self, place: str) -> None:
        fault = _fault_of_numbers(self) or _fault_of_assembly(self) or _fault_of_contact(self)
        if fault:
            raise InputError(f"{place}: {fault}" if place else fault)

    def base_radius(self, teeth: int) -> float:
        """Base radius [m] of a wheel of this many teeth."""
        return self.sun_base_radius * teeth / self.sun_teeth

    @property
    def sun_radius(self) -> float:
        """Base radius of the sun [m]."""
        return self.sun_base_radius

    @property
    def planet_radius(self) -> float:
        """Base radius of the planets' first toothing [m]."""
        return self.base_radius(self.planet_teeth)

    @property
    def ring_radius(self) -> float:
        """Base radius of the fixed ring [m]."""
        return self.base_radius(self.ring_teeth)

    @property
    def second_planet_radius(self) -> float:
        """Base radius of the planets' second toothing [m]."""
        return self.base_radius(self.second_planet_teeth)

    @property
    def output_ring_radius(self) -> float:
        """Base radius of the output ring [m]."""
        return self.base_radius(self.output_ring_teeth)

    @property
    def module(self) -> float:
        """Pitch diameter over teeth [m]; the thesis's script divides the base radius by the teeth."""
        return 2.0 * self.sun_base_radius / (self.sun_teeth * math.cos(self.pressure_angle))

    @property
    def base_pitch(self) -> float:
        """Distance of neighbouring flanks along the line of action [m]."""
        return 2.0 * math.pi * self.sun_base_radius / self.sun_teeth

    @property
    def addendum(self) -> float:
        """Height of the teeth above the pitch circle [m]."""
        return self.tip_radius - self.sun_base_radius / math.cos(self.pressure_angle)

    @property
    def centre_distance(self) -> float:
        """Distance of the planets' axes from the main axis [m]."""
        return self.meshes[SUN_MESH].centre_distance

    @cached_property
    def meshes(self) -> tuple[Mesh, Mesh, Mesh]:
        """The three kinds of mesh: sun and planet, planet and fixed ring, second planet and output ring."""
        return (
            self._mesh("sun and planet", False, self.sun_teeth, self.planet_teeth),
            self._mesh("planet and fixed ring", True, self.planet_teeth, self.ring_teeth),
            self._mesh("second planet and output ring", True, self.second_planet_teeth, self.output_ring_teeth),
        )

    def _mesh(self, name: str, internal: bool, first: int, second: int) -> Mesh:
        radii = self.base_radius(first), self.base_radius(second)
        return Mesh(name, internal, first, second, *radii, self.addendum, self.pressure_angle)

    @property
    def ratio(self) -> float:
        """Turns of the sun per turn of the output ring (appendix A: 124), negative if the output turns backwards."""
        output, fixed = self.output_ring_teeth * self.planet_teeth, self.ring_teeth * self.second_planet_teeth
        return (self.sun_teeth + self.ring_teeth) * output / (self.sun_teeth * (output - fixed))

    @property
    def carrier_ratio(self) -> float:
        """Turns of the carrier per turn of the sun, when rigid."""
        return self.sun_teeth / (self.sun_teeth + self.ring_teeth)

    @property
    def planet_ratio(self) -> float:
        """Turns of a planet relative to the carrier per sun turn, when rigid; positive against the sun's direction."""
        return self.carrier_ratio * self.ring_teeth / self.planet_teeth


def _fault_of_numbers(gearing: Gearing) -> str:
    """A fault of individual values; empty if there is none."""
    for name in ("sun_teeth", "planet_teeth", "ring_teeth", "second_planet_teeth", "output_ring_teeth"):
        teeth = getattr(gearing, name)
        if isinstance(teeth, bool) or not isinstance(teeth, int) or teeth < FEWEST_TEETH:
            return f"{name} is {teeth!r}: give a whole number of at least {FEWEST_TEETH}"
    for name in ("sun_base_radius", "tip_radius", "face_width"):
        if not 0.0 < getattr(gearing, name) < math.inf:
            return f"{name} is {getattr(gearing, name)!r} m: give a positive number"
    if not 0.0 < gearing.pressure_angle < 0.25 * math.pi:
        return f"pressure_angle is {gearing.pressure_angle!r} rad: give one between 0 and 0.785 (45 degrees)"
    if not -0.9 < gearing.profile_shift < 2.0:  # eq. 3.48 divides by 1 + shift
        return f"profile_shift is {gearing.profile_shift!r} modules: give one between -0.9 and 2"
    if not gearing.addendum > 0.0:
        pitch = 1e3 * (gearing.tip_radius - gearing.addendum)
        return f"tip_radius of {1e3 * gearing.tip_radius:g} mm is not above the sun's pitch radius of {pitch:.3f} mm"
    return ""


def _fault_of_assembly(gearing: Gearing) -> str:
    """Why the wheels cannot be assembled; empty if they can."""
    g = gearing
    if g.ring_teeth * g.second_planet_teeth == g.output_ring_teeth * g.planet_teeth:
        return (
            f"the ratio is infinite: {g.ring_teeth} x {g.second_planet_teeth} equals {g.output_ring_teeth} x "
            f"{g.planet_teeth} teeth, and the output ring stands still; change the second planet and output ring"
        )
    sun, ring, output = g.meshes
    for mesh, wheel, fitting in (
        (ring, "ring_teeth", g.sun_teeth + 2 * g.planet_teeth),
        (output, "output_ring_teeth", g.sun_teeth + g.planet_teeth + g.second_planet_teeth),
    ):
        wide = mesh.second_teeth - mesh.first_teeth - (g.sun_teeth + g.planet_teeth)
        if wide:
            difference = f"{500.0 * abs(wide) * g.module:.3f} mm {'more' if wide > 0 else 'less'}"
            return (
                f"the centre distance of {mesh.name} is {1e3 * mesh.centre_distance:.3f} mm, "
                f"{difference} than that of {sun.name} ({1e3 * sun.centre_distance:.3f} mm); "
                f"{wheel}: {fitting} would fit"
            )
    if (g.sun_teeth + g.ring_teeth) % PLANETS:
        return (
            f"sun and fixed ring have {g.sun_teeth + g.ring_teeth} teeth together, which {PLANETS} does not divide: "
            f"{PLANETS} equally spaced planets cannot be put in; change the number of teeth"
        )
    # Equal planets then also mesh with the output ring, turned by whole teeth. At the next planet the rings' teeth are
    # z_r/3 and z_o/3 farther on, so (z_o z_p - z_r z_p2)/3 must be a multiple of gcd(z_p, z_p2); with equal centre
    # distances it equals (z_s + z_p)/3 (z_p - z_p2).
    largest = max(sun.second_tip_radius, output.first_tip_radius)
    gap = math.sqrt(3.0) * g.centre_distance - 2.0 * largest
    if gap <= 0.0:
        return (
            f"neighbouring planets overlap by {-1e3 * gap:.3f} mm at their tips ({1e3 * largest:.3f} mm radius); "
            "give planets fewer teeth, or a smaller tip_radius"
        )
    return ""


def _fault_of_contact(gearing: Gearing) -> str:
    """Why a pair of wheels does not roll on each other; empty if all do."""
    for mesh in gearing.meshes:
        if mesh.internal and mesh.second_tip_radius <= mesh.second_base_radius:
            return f"{mesh.name}: the ring's teeth reach inside its base circle; give a smaller tip_radius"
        ends = mesh.curvature_radii(0.0)[0], mesh.curvature_radii(mesh.contact_length)[1]
        if min(ends) < 0.0:
            return (
                f"{mesh.name} interfere: contact would go {-1e3 * min(ends):.3f} mm beyond a base circle's tangent "
                "point; give a smaller tip_radius or a larger pressure_angle"
            )
        if not 1.0 <= mesh.contact_ratio < 2.0:
            low = mesh.contact_ratio < 1.0
            return (
                f"{mesh.name} have a contact ratio of {mesh.contact_ratio:.3f}, "
                + ("so that contact is lost between teeth" if low else "and no more than two pairs are modelled")
                + f"; give a {'larger' if low else 'smaller'} tip_radius"
            )
    return ""
