"""The definition of an effect: a name, an equation, bounded parameters with units, and how it acts."""

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
"""Quantities on which an effect may depend."""

POSITIVE = sys.float_info.min
"""The lower bound of a parameter that is never zero."""

Values = Mapping[str, float]
Options = Mapping[str, str]


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    ``lower`` and ``upper`` are physical bounds: a torque scales with the machine and has an infinite bound
    (``math.inf``); a share or an angle is bounded. A search covers the range of the recordings.

    ``default`` is a typical value for this class of machine, used if an effect is added without a value. The search for
    missing effects starts at each of ``starts`` (if empty: spread between the bounds, or, for a user's own effect, over
    the recorded range). A ``periodic`` parameter is an angle. An effect's first parameter is its size; ``neutral`` is
    the size at which it does nothing and from which its action grows proportionally (None: there is no such size, or
    the action is not proportional, so that sizes are tried from ``starts``, too).

    A parameter that acts ``at_rest`` only is not visible in motion, and is not fitted to it. A ``driven`` speed is one
    over which an effect fades. It is searched up to that share of the fastest recorded speed: beyond, it would be
    another effect. A parameter with a ``choice`` belongs to that choice of its effect's ``law`` only.
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
    driven: float = 0.0
    choice: str = ""

    @property
    def is_place(self) -> bool:
        """Whether it is where something is, at any angle of a shaft, and no width and no phase."""
        return self.unit == "rad" and not self.periodic and math.isinf(self.lower) and math.isinf(self.upper)


@dataclass(frozen=True)
class Circumstances:
    """Quantities by which the plausibility of a value is judged, SI at the fast shaft."""

    duration: float  # s, of the longest recording
    sample_period: float  # s, the longest
    top_speed: float  # rad/s
    travel: float  # rad, of the motor
    output_travel: float  # rad, of the slow shaft
    dry_level: float  # N m, all Coulomb friction
    viscous: float  # N m s/rad
    motor_inertia: float  # kg m2, including the gearbox
    output_inertia: float  # kg m2
    torque_limit: float  # N m
    limit_in_words: str  # the torque limit as text, in the unit of the model file


_NAN = math.nan
NOTHING_KNOWN = Circumstances(_NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, _NAN, "")
"""No circumstances: only rules on the values alone can apply."""


@dataclass(frozen=True)
class Implausible:
    """A rule for values of a parameter that no machine has, and the question to ask: something else may be missing.

    If it is ``never`` possible, whatever the other constants are, ``discover`` names no such effect of a machine whose
    constants are open.
    """

    parameter: str
    when: Callable[[Values, Circumstances], bool]
    reason: str
    never: bool = False


@dataclass(frozen=True, eq=False)
class Effect:
    """One physical cause that can be added to a model.

    It acts in one of two ways, or in both. ``act(at, p) -> float`` is compiled and called at every step: ``at`` is the
    :class:`~ema_twin_sim.plant.operating_point.OperatingPoint`, ``p`` the parameters in the order of the table (up to
    four, numeric options last). A positive value opposes positive motion, at every target: a spring that returns the
    output to zero is ``+k * angle``. Its target (``TORQUE`` on the motor, ``DRY_LEVEL``, ``OUTPUT_TORQUE``,
    ``VISCOUS_COEFFICIENT``) may depend on an option. ``settle(plant, parameters, options)`` changes the plant's
    constants once, for actions that do not depend on the operating point or have a constant of their own.

    For a fault of the motor's winding, ``settle_winding(winding, parameters, options)`` changes the constants of
    ``plant.switching.layout.WINDING`` if a switching drive is simulated. ``act`` and ``settle`` replace it if no
    winding is simulated, and if a torque is balanced with a measured current.

    ``depends_on`` is the one of QUANTITIES over which it is most visible, or empty. ``free_option`` is an option that
    accepts any positive number; its choices are searched on every machine, or, if not ``searched``, only if the
    recordings show them. ``law`` is an option that chooses the form of the equation, of which a machine follows one. An
    effect that ``every_machine`` has is preferred, if the model lacks it, to one that explains hardly more.
    ``shown_by`` is the motion to record to make it visible. An ``electrical`` effect needs the motor's pole pairs. One
    that ``delays`` uses the encoder's memory. Rules ask for ``traits``; ``told_by`` says what else would determine its
    size if no motion does.
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
    law: str = ""
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
        """The target of ``act``'s value with these options."""
        return self.place(options) if callable(self.place) else self.place

    @property
    def wave_angle(self) -> Parameter | None:
        """The phase parameter if the effect is a wave (a size from zero on and a phase angle); otherwise None."""
        size, *others = self.parameters
        angles = [parameter for parameter in others if parameter.periodic]
        return angles[0] if size.neutral == 0.0 and size.lower == 0.0 and len(angles) == 1 else None

    def allows(self, option: str, choice: str) -> bool:
        """Whether an option accepts this choice."""
        return choice in self.options[option] or (option == self.free_option and _positive(choice))

    def choices_in_words(self, option: str) -> str:
        """What an option accepts: ``24, 12, or another positive number``."""
        other = ", or another positive number" if option == self.free_option else ""
        return f"{', '.join(self.options[option])}{other}"

    def parameters_with(self, options: Options) -> tuple[Parameter, ...]:
        """The parameters of an instance with these options: all but those of another law."""
        return tuple(p for p in self.parameters if not p.choice or p.choice == options[self.law])

    def default_options(self) -> dict[str, str]:
        """The first choice of every option."""
        return {name: choices[0] for name, choices in self.options.items()}

    def default_parameters(self) -> dict[str, float]:
        """Typical values for this class of machine."""
        return {parameter.name: parameter.default for parameter in self.parameters}


def range_words(lower: float, upper: float, unit: str = "") -> str:
    """The range of a number in words: ``0 to 1 rad``, ``0 N m or more``, ``more than 0``, ``any number``."""
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
