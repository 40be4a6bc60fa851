"""Compare the found model with the same model after a fit: which numbers moved, and whether beyond their errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ema_bench_replay.errors import InputError

from ..model import Model
from ..words.findings import Findings, Held
from ..words.fit_findings import FitFindings
from .difference import SAME, std_of


@dataclass(frozen=True)
class TwoValues:
    """One number as it was found and as it was fitted, with its standard errors if they are known."""

    part: str  # of the machine, or an effect's instance
    name: str
    found: Held
    fitted: Held

    @property
    def differ(self) -> bool:
        """Whether they differ by more than the larger of their standard errors."""
        return apart(self.found, self.fitted)


def apart(first: Held, second: Held) -> bool:
    """Whether two values of one number differ by more than the larger of their standard errors."""
    return bool(abs(second["value"] - first["value"]) > max(first["std"] or 0.0, second["std"] or 0.0))


def two_values(
    found: Model, fitted: Model, findings: Findings | None = None, fit: FitFindings | None = None
) -> list[TwoValues]:
    """All numbers that fitting changed, those of effects first; with standard errors if findings hold these values."""
    numbers = []
    for name, held in fitted.active.items():
        for parameter, value in held.parameters.items():
            unit = fitted.parameter_unit(held.effect, parameter)
            numbers.append((name, parameter, found.effects[name].parameters[parameter], value, unit))
    for path, constant in fitted.constants.items():
        part, _, name = fitted.shown_path(path).partition(".")
        numbers.append((part, name, found.value(path), constant.value, fitted.unit(path)))
    return [
        TwoValues(
            part,
            name,
            {"value": before, "std": std_of(_known(findings, part, name), before), "unit": unit},
            {"value": after, "std": std_of(_known(fit, part, name), after), "unit": unit},
        )
        for part, name, before, after, unit in numbers
        if not math.isclose(before, after, rel_tol=SAME)
    ]


def _known(findings: Findings | FitFindings | None, part: str, name: str) -> Held | None:
    """The entry of a number in findings, among those of effects or of constants."""
    if findings is None:
        return None
    of_effect = (findings.parameters or {}).get(part, {}).get(name)
    return of_effect or (findings.constants or {}).get(part, {}).get(name)


def check_same_effects(found: Model, fitted: Model, names: tuple[str, str]) -> None:
    """Raise InputError unless the second model is the first with other numbers; ``names`` are their names."""
    first, second = (
        {name: (held.effect, tuple(sorted(held.options.items()))) for name, held in model.active.items()}
        for model in (found, fitted)
    )
    if first != second or set(found.constants) != set(fitted.constants):
        apart = sorted(name for name in {*first, *second} if first.get(name) != second.get(name))
        what = f" ({', '.join(apart)})" if apart else ""
        raise InputError(
            f"{names[1]}: the third model must be the second one after fit, but its effects or constants{what} differ "
            f"from those of {names[0]}; give what fit wrote from {names[0]}, or two models"
        )
