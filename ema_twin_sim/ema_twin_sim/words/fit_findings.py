"""What a fit found, from the fit itself or from the JSON that ``fit`` writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .findings import Held, checked_entry, checked_numbers, number, read_result
from .origin import Origin, read_origin

if TYPE_CHECKING:
    from ..fitting.fit import FitResult


@dataclass(frozen=True)
class FitFindings:
    """Result of a fit: its numbers with standard errors, and the RMSE by signal on data that was not fitted to."""

    parameters: Mapping[str, Mapping[str, Any]]
    constants: Mapping[str, Mapping[str, Held]]
    before: Mapping[str, float]
    after: Mapping[str, float]
    judged_on: str
    origin: Origin | None = None  # None if the file does not tell it


def fit_findings_of(fit: FitResult) -> FitFindings:
    """Findings of a finished fit."""
    return _read(fit.as_json())


def read_fit_findings(path: Path) -> FitFindings:
    """Read findings from a file. Raises InputError if ``fit`` did not write it."""
    return read_result(path, _read, "fit")


def _read(content: Mapping[str, Any]) -> FitFindings:
    errors = content["rmse"]
    return FitFindings(
        {str(name): checked_entry(entry) for name, entry in content["parameters"].items()},
        {str(part): checked_numbers(entries) for part, entries in content["constants"].items()},
        {str(name): number(error["before"]) for name, error in errors.items()},
        {str(name): number(error["after"]) for name, error in errors.items()},
        str(content["judged_on"]),
        read_origin(content),
    )
