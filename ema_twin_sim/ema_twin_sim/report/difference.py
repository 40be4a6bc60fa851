"""What one model has and another lacks: effects with their sizes, and constants that changed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..model import Model
from ..quantities import estimate
from ..words.findings import Findings, Held
from ..words.sentences import effect_words, options_words

SAME = 1e-6  # relative tolerance of numbers that were written to a file and read back


@dataclass(frozen=True)
class NewEffect:
    """An effect that only the later model has; ``parameters`` are ``{value, std, unit}`` by name."""

    name: str
    effect: str
    options: Mapping[str, str]
    parameters: Mapping[str, Held]

    @property
    def sizes(self) -> str:
        """``torque 78.3 ± 1.1 mN m, speed 2.06 ± 0.05 rad/s``."""
        return ", ".join(f"{name} {estimate(h['value'], h['std'], h['unit'])}" for name, h in self.parameters.items())

    @property
    def words(self) -> str:
        """``Stribeck friction (torque 78.3 ± 1.1 mN m, …)``."""
        said = "; ".join(part for part in (options_words(self.options), self.sizes) if part)
        return f"{effect_words(self.name)} ({said})" if said else effect_words(self.name)


def new_effects(before: Model, after: Model, findings: Findings | None = None) -> list[NewEffect]:
    """The active effects that ``before`` lacks, with standard errors if the findings have them for these very values.

    They are in the order of the findings.
    """
    found = []
    for name, instance in after.active.items():
        if name in before.active and before.active[name].effect == instance.effect:
            continue
        known = (findings.parameters or {}).get(name, {}) if findings else {}
        parameters = {}
        for parameter, value in instance.parameters.items():
            unit = after.parameter_unit(instance.effect, parameter)
            parameters[parameter] = {"value": value, "std": std_of(known.get(parameter), value), "unit": unit}
        found.append(NewEffect(name, instance.effect, dict(instance.options), parameters))
    told = list(findings.parameters or {}) if findings else []
    return sorted(found, key=lambda effect: told.index(effect.name) if effect.name in told else len(told))


def moved_numbers(before: Model, after: Model, findings: Findings | None = None) -> list[tuple[str, Held]]:
    """The numbers that both models have with different values: a name, and ``{value, std, unit, nominal}``."""
    known = (findings.constants or {}) if findings else {}
    pairs = []
    for path, held in after.constants.items():
        if path in before.constants:
            shown = after.shown_path(path)
            pairs.append((shown, before.value(path), held.value, after.unit(path)))
    for name, instance in after.effects.items():
        old = before.effects.get(name)
        if old is not None and old.effect == instance.effect:
            for parameter in (one for one in instance.parameters if one in old.parameters):  # not those of another law
                unit = after.parameter_unit(instance.effect, parameter)
                was, value = old.parameters[parameter], instance.parameters[parameter]
                pairs.append((f"{name}.{parameter}", was, value, unit))
    moved: list[tuple[str, Held]] = []
    for path, nominal, value, unit in pairs:
        if not math.isclose(value, nominal, rel_tol=SAME):
            part, _, name = path.partition(".")
            std = std_of(known.get(part, {}).get(name), value)
            moved.append((path, {"value": value, "std": std, "unit": unit, "nominal": nominal}))
    return moved


def std_of(held: Held | None, value: float) -> float | None:
    """The standard error, if ``held`` is of this value; else None."""
    return held["std"] if held is not None and math.isclose(held["value"], value, rel_tol=SAME) else None
