"""What an effect is: a name, an equation, bounded parameters with units, and how it acts."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..plant.layout import DRY_LEVEL, OUTPUT_TORQUE, TORQUE, VISCOUS_COEFFICIENT
from .trait import Trait

__all__ = [
    "DRY_LEVEL",
    "OUTPUT_TORQUE",
    "POSITIVE",
    "TORQUE",
    "VISCOUS_COEFFICIENT",
    "Circumstances",
    "Effect",
    "Implausible",
    "Parameter",
    "Trait",
]

QUANTITIES = (
    "speed",
    "direction",
    "output_position",
    "order",  # of the motor's angle
    "load",
    "time",
    "acceleration",
    "current",
    "encoders",  # their difference
)
"""What an effect may show over."""

POSITIVE = sys.float_info.min
"""The lower bound of a number that is never zero."""

Values = Mapping[str, float]
Options = Mapping[str, str]


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    ``lower`` and ``upper`` are what is possible at all: a torque may be of any size, since machines are, and has an
    infinite bound (``math.inf``); a share or an angle is bounded. A search looks as far as the recordings reach.

    ``default`` is a typical value of this class of machine, used where an effect is added with none given. The search
    for missing effects begins at each of ``starts`` (none: spread between the bounds, or, of a user's own effect, over
    what the recordings cover); a ``periodic`` parameter is an angle. An effect's first parameter is its size;
    ``neutral`` is the size at which it does nothing and from which it grows in proportion (None: it has none, or does
    not grow in proportion, so that sizes too are tried from starts).
    What acts ``at_rest`` only does not show in motion, and is not fitted to it. A ``driven`` speed is one over which an
    effect fades: beyond the speeds that recordings drive it would be another effect, and is not looked for there.
    """

    name: str
    unit: str
    default: float
    lower: float
    upper: float
    description: str
    starts: tuple[float, ...] = ()
    periodic: bool = False
    neutral: float | None = 0.0
    at_rest: bool = False
    driven: bool = False


@dataclass(frozen=True)
class Circumstances:
    """What a value is judged by, SI at the fast shaft."""

    duration: float  # s, of the longest recording
    sample_period: float  # s, the longest
    top_speed: float  # rad/s
    travel: float  # rad, of the motor
    output_travel: float  # rad, of the slow shaft
    dry_level: float  # N m, all Coulomb friction
    viscous: float  # N m s/rad
    motor_inertia: float  # kg m2, gearbox included
    output_inertia: float  # kg m2
    torque_limit: float  # N m
    limit_in_words: str  # the same with the unit of the model's file


@dataclass(frozen=True)
class Implausible:
    """Values of a parameter that no machine has, and the question to ask instead: something else is missing."""

    parameter: str
    when: Callable[[Values, Circumstances], bool]
    reason: str


@dataclass(frozen=True, eq=False)
class Effect:
    """One physical cause that can be added to a model.

    It acts in one of two ways, or in both. ``act(at, p) -> float`` is compiled and called at every step: ``at`` is the
    :class:`~ema_twin_sim.plant.operating_point.OperatingPoint`, ``p`` the parameters in the order of the table (up to
    four, options that carry a number included last); the place where its value goes (``TORQUE`` on the motor,
    ``DRY_LEVEL``, ``OUTPUT_TORQUE``, ``VISCOUS_COEFFICIENT``) may depend on an option. ``settle(plant, parameters,
    options)`` changes the plant's own constants once, for what does not depend on the operating point or has a place of
    its own there.

    A fault of the motor's winding acts there where a switching drive is simulated: ``settle_winding(winding,
    parameters, options)`` changes the constants of ``plant.switching.layout.WINDING``, and ``act`` and ``settle`` stand
    for it where no winding is simulated, which is also where a torque is balanced with a measured current.

    ``depends_on`` is the one of QUANTITIES that it shows over most, or empty. ``free_option`` is an option that any
    positive number may be given for; its choices are those that are looked for on every machine, or, where not
    ``searched``, those that recordings show only. What ``every_machine`` has goes before what explains hardly more,
    where a model lacks it. ``shown_by`` is the motion to record so that it
    shows. An ``electrical`` effect needs to know the motor's pole pairs. One that ``delays`` shows what an encoder
    remembers. ``traits`` are what rules ask for; ``told_by`` says what else would tell its size where no motion does.
    """

    id: str
    summary: str
    equation: str
    signature: str
    source: str
    parameters: tuple[Parameter, ...]
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    act: Callable[..., float] | None = None
    place: Callable[[Options], int] | int = TORQUE
    option_value: Callable[[Options], float] | None = None
    depends_on: str = ""
    settle: Callable[[np.void, Values, Options], None] | None = None
    settle_winding: Callable[[np.void, Values, Options], None] | None = None
    shown_by: str = "motion over all speeds, positions and directions that it may depend on"
    electrical: bool = False
    repeatable: bool = True
    delays: bool = False
    free_option: str = ""
    searched: bool = True
    every_machine: bool = False
    implausible: tuple[Implausible, ...] = ()
    traits: tuple[Trait, ...] = ()
    told_by: str = ""

    def __post_init__(self) -> None:
        if self.act is None and self.settle is None:
            raise ValueError(f"effect {self.id}: give act or settle")
        if len(self.parameters) + (self.option_value is not None) > 4:
            raise ValueError(f"effect {self.id}: at most four parameters, a numeric option included")
        if self.depends_on not in ("", *QUANTITIES):
            raise ValueError(f"effect {self.id}: depends_on: one of {', '.join(QUANTITIES)}, not {self.depends_on!r}")
        for trait in self.traits:
            if not isinstance(trait, Trait):
                raise ValueError(f"effect {self.id}: traits: give members of Trait, not {trait!r}")

    def where(self, options: Options) -> int:
        """The place that ``act``'s value goes to under these options."""
        return self.place(options) if callable(self.place) else self.place

    @property
    def wave_angle(self) -> Parameter | None:
        """The angle of an effect that is a wave: one of a size from zero on, which an angle turns; None of others."""
        size, *others = self.parameters
        angles = [parameter for parameter in others if parameter.periodic]
        return angles[0] if size.neutral == 0.0 and size.lower == 0.0 and len(angles) == 1 else None

    def allows(self, option: str, choice: str) -> bool:
        """Whether an option may be chosen so."""
        return choice in self.options[option] or (option == self.free_option and _positive(choice))

    def default_options(self) -> dict[str, str]:
        """The first choice of every option."""
        return {name: choices[0] for name, choices in self.options.items()}

    def default_parameters(self) -> dict[str, float]:
        """Typical values of this class of machine."""
        return {parameter.name: parameter.default for parameter in self.parameters}


def range_words(lower: float, upper: float, unit: str = "") -> str:
    """The range of a number as people say it: ``0 to 1 rad``, ``0 N m or more``, ``more than 0``, ``any number``."""
    unit = f" {unit}" if unit not in ("", "1") else ""
    if math.isfinite(lower) and math.isfinite(upper):
        return f"{lower:g} to {upper:g}{unit}"
    if math.isfinite(lower):
        return f"more than 0{unit}" if lower == POSITIVE else f"{lower:g}{unit} or more"
    return f"{upper:g}{unit} or less" if math.isfinite(upper) else f"any finite number{unit and ' of'}{unit}"


def _positive(text: str) -> bool:
    try:
        return 0.0 < float(text) < float("inf")
    except ValueError:
        return False
