"""The model that was found beside the same one with its numbers fitted: what fitting moved, and what it is worth."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ema_bench_replay.errors import InputError

from ..model import Model
from .difference import SAME, std_of
from .findings import Findings, Held, checked, checked_entry, number

if TYPE_CHECKING:
    from ..fitting.fit import FitResult


@dataclass(frozen=True)
class FitFindings:
    """What a fit tells: its numbers with their standard errors, and the RMSE by signal on what it was not fitted to."""

    parameters: Mapping[str, Mapping[str, Any]]
    constants: Mapping[str, Mapping[str, Held]]
    before: Mapping[str, float]
    after: Mapping[str, float]
    judged_on: str


@dataclass(frozen=True)
class TwoValues:
    """One number as it was found and as it was fitted, with its standard errors where they are known."""

    part: str  # of the machine, or an effect's instance
    name: str
    found: Held
    fitted: Held

    @property
    def differ(self) -> bool:
        """Whether they are apart by more than the larger of their standard errors."""
        return apart(self.found, self.fitted)


def apart(first: Held, second: Held) -> bool:
    """Whether two values of one number are apart by more than the larger of their standard errors."""
    return bool(abs(second["value"] - first["value"]) > max(first["std"] or 0.0, second["std"] or 0.0))


def two_values(
    found: Model, fitted: Model, findings: Findings | None = None, fit: FitFindings | None = None
) -> list[TwoValues]:
    """All numbers that fitting changed, those of effects first; standard errors where findings hold these values."""
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
    """What findings hold of a number, among those of effects or of constants."""
    if findings is None:
        return None
    of_effect = (findings.parameters or {}).get(part, {}).get(name)
    return of_effect or (findings.constants or {}).get(part, {}).get(name)


def check_same_effects(found: Model, fitted: Model, names: tuple[str, str]) -> None:
    """Raise InputError where the second model is not the first with other numbers; ``names`` are theirs."""
    first, second = (
        {name: (held.effect, tuple(sorted(held.options.items()))) for name, held in model.active.items()}
        for model in (found, fitted)
    )
    if first != second or set(found.constants) != set(fitted.constants):
        apart = sorted(name for name in {*first, *second} if first.get(name) != second.get(name))
        what = f" ({', '.join(apart)})" if apart else ""
        raise InputError(
            f"{names[1]}: a third model is the second with its numbers fitted, but its effects or constants{what} are "
            f"not those of {names[0]}; give what fit wrote of {names[0]}, or two models"
        )


def fit_findings_of(fit: FitResult) -> FitFindings:
    """The findings of a fit that was made."""
    return _read(fit.as_json())


def read_fit_findings(path: Path) -> FitFindings:
    """The findings in a file. Raises InputError where it is none that ``fit`` wrote."""
    try:
        return _read(json.loads(path.read_bytes()))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); name what fit --json wrote") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        what = f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: is not what fit --json writes ({what})") from None


def _read(content: Mapping[str, Any]) -> FitFindings:
    errors = content["rmse"]
    return FitFindings(
        {str(name): checked_entry(entry) for name, entry in content["parameters"].items()},
        {
            str(part): {str(name): checked(held) for name, held in entries.items()}
            for part, entries in content["constants"].items()
        },
        {str(name): number(error["before"]) for name, error in errors.items()},
        {str(name): number(error["after"]) for name, error in errors.items()},
        str(content["judged_on"]),
    )
