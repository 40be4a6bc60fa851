"""What a fit found, from the fit itself or from the JSON that ``fit`` writes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ema_bench_replay.errors import InputError

from .findings import Held, checked_entry, checked_numbers, number
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
    try:
        return _read(json.loads(path.read_bytes()))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the file that fit --json wrote") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        what = f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: is not what fit --json writes ({what})") from None


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
