"""What tells two models apart: effects with their sizes, and numbers that changed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ema_bench_replay.errors import InputError

from ..model import Model
from ..quantities import estimate
from ..words.findings import Findings, Held
from ..words.fit_findings import FitFindings
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


@dataclass(frozen=True)
class TwoValues:
    """One number in two models, with its standard errors if they are known."""

    part: str  # of the machine, or an effect's instance
    name: str
    before: Held
    after: Held

    @property
    def path(self) -> str:
        """``machine.motor_inertia``."""
        return f"{self.part}.{self.name}"

    @property
    def differ(self) -> bool:
        """Whether they differ by more than the larger of their standard errors."""
        return apart(self.before, self.after)


def apart(first: Held, second: Held) -> bool:
    """Whether two values of one number differ by more than the larger of their standard errors."""
    return bool(abs(second["value"] - first["value"]) > max(first["std"] or 0.0, second["std"] or 0.0))


def two_values(
    before: Model,
    after: Model,
    of_before: Findings | FitFindings | None = None,
    of_after: Findings | FitFindings | None = None,
) -> list[TwoValues]:
    """The numbers that both models have with different values; with standard errors if findings hold these values."""
    numbers = [
        (after.shown_path(path), before.value(path), held.value, after.unit(path))
        for path, held in after.constants.items()
        if path in before.constants
    ]
    for name, instance in after.effects.items():
        old = before.effects.get(name)
        if old is not None and old.effect == instance.effect:
            for parameter in (one for one in instance.parameters if one in old.parameters):  # not those of another law
                unit = after.parameter_unit(instance.effect, parameter)
                was, value = old.parameters[parameter], instance.parameters[parameter]
                numbers.append((f"{name}.{parameter}", was, value, unit))
    found = []
    for path, was, value, unit in numbers:
        if not math.isclose(was, value, rel_tol=SAME):
            part, _, name = path.partition(".")
            sides = ((was, of_before), (value, of_after))
            held: list[Held] = [
                {"value": number, "std": std_of(_known(findings, part, name), number), "unit": unit}
                for number, findings in sides
            ]
            found.append(TwoValues(part, name, *held))
    return found


def _known(findings: Findings | FitFindings | None, part: str, name: str) -> Held | None:
    """The entry of a number in findings, among those of effects or of constants."""
    if findings is None:
        return None
    of_effect = (findings.parameters or {}).get(part, {}).get(name)
    return of_effect or (findings.constants or {}).get(part, {}).get(name)


def std_of(held: Held | None, value: float) -> float | None:
    """The standard error, if ``held`` is of this value; else None."""
    return held["std"] if held is not None and math.isclose(held["value"], value, rel_tol=SAME) else None


def check_same_effects(found: Model, fitted: Model, names: tuple[str, str]) -> None:
    """Raise InputError unless the second model is the first with other numbers; ``names`` are their names."""
    first, second = (
        {name: (held.effect, tuple(sorted(held.options.items()))) for name, held in model.active.items()}
        for model in (found, fitted)
    )
    if first != second or set(found.constants) != set(fitted.constants):
        others = sorted(name for name in {*first, *second} if first.get(name) != second.get(name))
        what = f" ({', '.join(others)})" if others else ""
        raise InputError(
            f"{names[1]}: the third model must be the second one after fit, but its effects or constants{what} differ "
            f"from those of {names[0]}; give what fit wrote from {names[0]}, or two models"
        )
