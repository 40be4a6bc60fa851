"""Health: name what changed in a run, or in several together, in a family and a sentence with its reason and advice."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..criteria import CONTRADICTED, LIKELY, PART, SIGNIFICANT, SMALL, SUREST
from .change import Change, growths
from .families import Family, Ranked, rank

WORDS = {
    "friction": "effort in steady motion",
    "load": "effort that does not reverse with the motion",
    "rest_effort": "effort at rest",
    "roughness": "roughness of steady motion",
    "fast_roughness": "fast roughness",
    "slow_roughness": "slow roughness",
    "rest_hunting": "hunting at rest",
    "wave_depth": "wave that repeats with the position",
    "bump": "largest local bump",
    "lag": "lag of the position while starting",
    "breakaway": "effort to break away",
    "settling": "effort while settling after a stroke",
    "lost_motion": "lost motion between the encoders",
    "encoder_reach": "reach of the encoders' difference over the run",
    "encoder_scatter": "scatter of the encoders' difference within a stroke",
    "encoder_drift": "drift of the encoders' difference from stroke to stroke",
}
_REASONS = {**WORDS, "wave_both_ways": "wave at the same place in both directions"}
"""Words for the features that speak for a family. ``wave_both_ways`` is a square, so its change is not printed."""
_PHRASES = {
    Family.ENCODER: "a fault of the output encoder",
    Family.LOAD: "a change of the load",
    Family.OFFSET: "an offset of the effort",
    Family.UNKNOWN: "none of them",
}
"""Families whose names do not end a sentence."""
_ADVICE = {
    Family.FRICTION_UP: "Look at lubricant, seals and bearings.",
    Family.PRELOAD_UP: "Look at what sets the preload: balls, nut, bearings and their alignment.",
    Family.FRICTION_DOWN: "Look at the preload of nut and bearings, and at the temperature.",
    Family.PLAY: "Measure the play by hand; look at nut, coupling and bearings.",
    Family.ENCODER: "Look at how the output's encoder is mounted and coupled.",
    Family.LOCAL_DAMAGE: "Look at tracks, balls and teeth for pits.",
    Family.LOAD: "Look at what hangs on the output.",
    Family.OFFSET: "Check the zero of the current sensor with the drive off.",
    Family.UNKNOWN: "Check what was changed on the unit and in its test.",
}
_SCATTERS = "noise of a sensor, the gain of the control loop or play"
_ENCODERS = "an encoder that is eccentric or slips, play or the stiffness of the train"
_PLACES = "damage at a place, the motor's detents or the wavelength"
_CAUSES = {
    "friction": "friction, the torque constant or the current sensor",
    "load": "a load or the zero of the current sensor",
    "roughness": _SCATTERS,
    "fast_roughness": _SCATTERS,
    "rest_hunting": _SCATTERS,
    "slow_roughness": "stick-slip, the motor's detents, the gain of the control loop or play",
    "lag": "the commanded motion, the gain of the control loop, play or the encoder",
    "breakaway": "static friction, inertia, a spring or the acceleration of the test",
    "settling": "static friction, a load that is held or the control loop",
    "lost_motion": _ENCODERS,
    "encoder_reach": _ENCODERS,
    "encoder_scatter": _ENCODERS,
    "encoder_drift": _ENCODERS,
    "bump": _PLACES,
    "wave_depth": _PLACES,
    "wave_both_ways": _PLACES,
}
"""What can change a feature. These have no probability: no direct measure tells them apart."""
_LEVELS = ("friction", "load", "settling")
_OF_LEVELS = frozenset({Family.FRICTION_UP, Family.PRELOAD_UP, Family.FRICTION_DOWN, Family.LOAD, Family.OFFSET})
"""Families whose direct measure is the level of the effort."""


@dataclass(frozen=True)
class Naming:
    """What a change is called."""

    ranked: tuple[Ranked, ...]
    sentence: str  # the family, the reason and the advice

    @property
    def family(self) -> Family:
        """The best of them, or the unknown."""
        best = self.ranked[0] if self.ranked else None
        return Family.UNKNOWN if best is None or best.explained <= 0.0 else best.family


def in_words(changes: Iterable[Change]) -> list[Change]:
    """Those of the changes that are told: not the parts of a wave, whose depth is."""
    return [change for change in changes if change.name in WORDS]


def name_change(
    changes: Mapping[str, Change], beside: Mapping[str, float], *, unsigned: bool, effort_usable: bool = True
) -> Naming:
    """Name the changes of a run, or the mean changes of several. ``beside`` is as in ``families.rank``."""
    if not effort_usable:
        return _not_named("No fault family is given, because the effort is not usable.")
    if (factor := one_factor(changes)) is not None:
        return _not_named(
            f"All efforts changed by one factor of {factor:.2f}: check the current sensor and the torque constant."
            if _shown_by_friction(changes)
            else f"The load changed, or all efforts by one factor of {factor:.2f}: the effort in steady motion "
            f"scatters too much to tell which. {_ADVICE[Family.LOAD]} Check the current sensor and the torque constant."
        )
    if unsigned and _apart(changes):
        return _not_named(
            "The effort rises in one direction and falls in the other; an unsigned effort does not show whether load "
            "or friction changed. Record a signed current."
        )
    held = unsigned and _held(changes)
    told = {name: one.standard_deviations for name, one in changes.items() if not (unsigned and name == "load")}
    without = set(_OF_LEVELS if held else ())
    if "load" in told and (shared := _shared_with_friction(changes)) > 0.0:
        told["load"] *= max(0.0, 1.0 - shared)
        without |= {Family.LOAD, Family.OFFSET} if shared > PART else set()
    ranked = rank(told, beside, growths(changes), without)
    naming = Naming(ranked, "")
    if naming.family is not Family.UNKNOWN:
        return Naming(ranked, _named(ranked))
    if held and max(abs(told.get(name, 0.0)) for name in _LEVELS) > CONTRADICTED:
        return Naming(
            ranked,
            "The effort changed; it is unsigned and as large at rest as in motion, so it does not show whether load or "
            "friction changed. Record a signed current.",
        )
    moved = {name: changes[name].standard_deviations for name in told}
    return Naming(ranked, f"{_unexplained(ranked, moved)} {_ADVICE[Family.UNKNOWN]}")


def agreed(motions: Sequence[tuple[Naming, int]]) -> Naming:
    """What several motions are called together, each with its number of runs: the one family that most runs show."""
    if not motions:
        return Naming((), "")
    largest = max(motions, key=lambda one: one[1])[0]
    known = [(naming, count) for naming, count in motions if naming.family is not Family.UNKNOWN]
    families = list(dict.fromkeys(naming.family for naming, _ in known))
    if len(motions) == 1 or not families:
        return largest
    if len(families) > 1:
        told = " and ".join(family.value for family in families)
        return _not_named(f"The motions of this test show different families: {told}. {_ADVICE[Family.UNKNOWN]}")
    if 2 * sum(count for _, count in known) < sum(count for _, count in motions):
        return next(naming for naming, _ in motions if naming.family is Family.UNKNOWN)
    return max(known, key=lambda one: one[1])[0]


def one_factor(changes: Mapping[str, Change]) -> float | None:
    """The factor by which all levels of the effort may have changed, if one explains them; None if not.

    Friction alone scales no load, and a load alone no friction. So both have to agree with the factor, the load beyond
    its scatter; whether friction tells it from a load is for ``_shown_by_friction``.
    """
    levels = {name: changes[name] for name in _LEVELS if name in changes}
    if not {"friction", "load"} <= set(levels):
        return None
    weight = sum(one.size**2 for one in levels.values())
    more = sum(one.size * one.standard_deviations for one in levels.values()) / weight
    shown = {name: more * one.size for name, one in levels.items()}
    fits = all(
        abs(one.standard_deviations - shown[name]) < max(CONTRADICTED, SMALL * abs(shown[name]))
        for name, one in levels.items()
    )
    started = changes.get("breakaway")
    refuted = started is not None and _falls_short(started.standard_deviations, more * started.size)
    return 1.0 + more if fits and abs(shown["load"]) > CONTRADICTED and not refuted else None


def _falls_short(moved: float, wanted: float) -> bool:
    """Whether a feature moved by less than it should beyond chance, or the other way, in standard deviations."""
    return abs(wanted) - math.copysign(1.0, wanted) * moved > CONTRADICTED


def _shown_by_friction(changes: Mapping[str, Change]) -> bool:
    """Whether friction, which no load scales, changed beyond chance."""
    return abs(changes["friction"].standard_deviations) > LIKELY


def _shared_with_friction(changes: Mapping[str, Change]) -> float:
    """Friction's change as a share of the load's, both as efforts; zero if friction is not known to have changed.

    A load adds as much in one direction as it takes in the other. Friction that grows with speed, in moves of two
    speeds, adds in both: half the difference is at most half the sum. So what friction's change reaches is no load.
    """
    if not {"friction", "load"} <= set(changes) or abs(changes["friction"].standard_deviations) <= CONTRADICTED:
        return 0.0
    friction, load = (abs(changes[name].value - changes[name].healthy) for name in ("friction", "load"))
    return friction / load if load else 0.0


def _apart(changes: Mapping[str, Change]) -> bool:
    """Whether the effort rises in one direction and falls in the other."""
    if not {"friction", "load"} <= set(changes):
        return False
    friction, load = (changes[name].value - changes[name].healthy for name in ("friction", "load"))
    return abs(changes["load"].standard_deviations) > SIGNIFICANT and abs(load) > abs(friction)


def _held(changes: Mapping[str, Change]) -> bool:
    """Whether the healthy effort at rest is as large as that in motion the easier way: it may hold a load."""
    if not {"friction", "load", "settling"} <= set(changes):
        return False
    easier = changes["friction"].healthy - abs(changes["load"].healthy)
    return changes["settling"].healthy > (1.0 - PART) * easier


def _not_named(sentence: str) -> Naming:
    return Naming((Ranked(Family.UNKNOWN, 0.0, SUREST, ()),), sentence)


def _named(ranked: tuple[Ranked, ...]) -> str:
    """The family, by what, its rivals, and what to look at."""
    best = ranked[0]
    reasons = " and ".join(_REASONS[name] for name in best.because[:2])
    sentence = (
        f"This is {_phrase(best.family)} (probability {best.probability:.0%} among the known families and none of "
        f"them), by {reasons}."
    )
    rivals = [other for other in ranked[1:] if other.probability > 1.0 - best.probability or other.probability > PART]
    advice = _ADVICE[best.family]
    if not rivals:
        return f"{sentence} {advice}"
    rival = rivals[0]
    other = _phrase(rival.family)
    if rival.family is Family.OFFSET:
        advice += f" {_ADVICE[Family.OFFSET]}"
    return f"{sentence} Alternatively {other} ({rival.probability:.0%}). {advice}"


def _phrase(family: Family) -> str:
    return _PHRASES.get(family, family.value)


def _unexplained(ranked: tuple[Ranked, ...], changes: Mapping[str, float]) -> str:
    """What changed that none of the families explains, and what can cause it."""
    left = [name for name in (ranked[0].because if ranked else ()) if name in changes]
    if not left:
        return "Something changed that none of the families of damage explains."
    by = " and ".join(f"{_REASONS[name]} by {changes[name]:+.1f}" for name in left[:2])
    return (
        f"Something changed that none of the families of damage explains: {by} standard deviations. "
        f"{_CAUSES[left[0]][0].upper()}{_CAUSES[left[0]][1:]} can cause it."
    )
