"""Contact of two wheels along the line of action of one mesh, external or internal (thesis, section 3.5).

The first wheel drives. A pair of teeth makes contact where the second wheel's tip crosses the line of action (s = 0),
passes the pitch point (s = approach) and separates where the first wheel's tip crosses it (s = contact length). On the
way, the contact moves along the first wheel's flank from root to tip. In back-driving or reversal the same points are
passed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Position = TypeVar("Position", float, NDArray[np.float64])


@dataclass(frozen=True)
class Mesh:
    """Two wheels in contact: teeth, radii and addendum [m], operating pressure angle [rad].

    In an internal mesh the second wheel is the ring, whose tips are inside its pitch circle.
    """

    name: str
    internal: bool
    first_teeth: int
    second_teeth: int
    first_base_radius: float
    second_base_radius: float
    addendum: float
    pressure_angle: float

    @property
    def side(self) -> float:
        """+1 for an external mesh, -1 for an internal one: the sign of the second wheel's radii."""
        return -1.0 if self.internal else 1.0

    @property
    def base_pitch(self) -> float:
        """Distance [m] of two neighbouring flanks along the line of action, equal for both wheels."""
        return 2.0 * math.pi * self.first_base_radius / self.first_teeth

    @property
    def first_pitch_radius(self) -> float:
        """Pitch radius of the first wheel [m]."""
        return self.first_base_radius / math.cos(self.pressure_angle)

    @property
    def second_pitch_radius(self) -> float:
        """Pitch radius of the second wheel [m]."""
        return self.second_base_radius / math.cos(self.pressure_angle)

    @property
    def first_tip_radius(self) -> float:
        """Tip radius of the first wheel [m]."""
        return self.first_pitch_radius + self.addendum

    @property
    def second_tip_radius(self) -> float:
        """Tip radius of the second wheel [m]: a ring's teeth point inwards."""
        return self.second_pitch_radius + self.side * self.addendum

    @property
    def centre_distance(self) -> float:
        """Distance of the two axes [m]."""
        return abs(self.first_pitch_radius + self.side * self.second_pitch_radius)

    @property
    def base_segment(self) -> float:
        """Distance [m] of the two points where the line of action touches the base circles (eq. 3.35).

        In an internal mesh both are on the same side of the contact, and the radii subtract.
        """
        return abs(self.first_base_radius + self.side * self.second_base_radius) * math.tan(self.pressure_angle)

    @property
    def approach(self) -> float:
        """Length [m] from first contact to the pitch point (eq. 3.33; for an internal mesh both terms change sign).

        The thesis's script has the ring's base radius (132 mm) above its tip radius (126.4 mm), which would give the
        root of a negative number; it swaps the two.
        """
        tip = math.sqrt(self.second_tip_radius**2 - self.second_base_radius**2)
        return self.side * (tip - self.second_pitch_radius * math.sin(self.pressure_angle))

    @property
    def recess(self) -> float:
        """Length [m] from the pitch point to last contact (eq. 3.34)."""
        tip = math.sqrt(self.first_tip_radius**2 - self.first_base_radius**2)
        return tip - self.first_pitch_radius * math.sin(self.pressure_angle)

    @property
    def contact_length(self) -> float:
        """Length [m] of contact of a pair of teeth, along the line of action."""
        return self.approach + self.recess

    @property
    def contact_ratio(self) -> float:
        """Mean number of pairs in contact."""
        return self.contact_length / self.base_pitch

    @property
    def contact_angles(self) -> tuple[float, float]:
        """Angles [rad] of first and last contact, seen from the first wheel's tangent point (eqs 3.36 and 3.37)."""
        ahead = self.first_base_radius * math.tan(self.pressure_angle)
        return (
            math.atan((ahead - self.approach) / self.first_base_radius),
            math.atan((ahead + self.recess) / self.first_base_radius),
        )

    def curvature_radii(self, position: Position) -> tuple[Position, Position]:
        """Distances [m] of the contact from both tangent points, at ``position`` [m] from first contact.

        Eqs 3.38 and 3.39: the radii of curvature of the flanks, and the arms of friction about the wheels' axes. In an
        internal mesh the second is the first plus the base segment, which the thesis's script marks "to be corrected".
        """
        first = self.first_base_radius * math.tan(self.pressure_angle) - self.approach + position
        return first, self.base_segment - self.side * first

    @property
    def equivalent_radius(self) -> float:
        """Radius of curvature [m] of both flanks together at the pitch point: 1/rho = 1/rho_1 +- 1/rho_2."""
        first, second = self.curvature_radii(self.approach)
        return first * second / (second + self.side * first)
