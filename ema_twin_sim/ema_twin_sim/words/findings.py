"""What a search found, from the search itself or from the JSON that ``discover`` and ``diagnose`` write."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from ema_bench_replay.errors import InputError

from ..discovery.diagnose import Diagnosis, Ranked
from ..discovery.discover import Discovery
from ..discovery.evidence import evidence_json
from ..discovery.steps import Step
from .origin import Origin, read_origin, texts

Result = TypeVar("Result")
CURVES = ("before", "after", "runner_up")
"""Names of the curves in the evidence: the model before a step, after it, and with the runner-up in its place."""
Held = Mapping[str, Any]
"""``{value, std, unit}``, and ``nominal`` for a constant; ``std`` is None if it was not fitted."""


@dataclass(frozen=True)
class UnseenErrors:
    """RMSE on recordings that were not fitted to: at the start, and after each round; pooled and per recording.

    The start is the given model with its own constants fitted, if that reduces the error. ``settled`` is the pooled
    RMSE in motion, without what filters carry on from standstill.
    """

    signal: str
    unit: str
    noise_floor: float
    rmse: tuple[float, ...]
    recordings: tuple[tuple[str, tuple[float, ...]], ...]
    given: float | None = None  # of the unchanged model; None if the file does not say
    given_recordings: tuple[float, ...] = ()
    settled: tuple[float, ...] = ()  # empty if the file does not say


@dataclass(frozen=True)
class Signature:
    """What one step changed, against the quantity that shows it best: medians and quartiles per bin, by model."""

    title: str
    taken: bool
    runner_up: str
    left_over: str  # torque or encoder_difference
    unit: str
    against: str
    against_unit: str
    order: float | None
    curves: tuple[Held, ...]


@dataclass(frozen=True)
class Findings:
    """The parts of a discovery and of a diagnosis that a report shows; empty parts were not given."""

    verdict: str  # explained, none or unknown
    added: tuple[str, ...]
    ranking: tuple[Ranked, ...] = ()
    none: float | None = None
    unknown: float | None = None
    steps: tuple[Step, ...] = ()
    parameters: Mapping[str, Mapping[str, Any]] | None = None
    constants: Mapping[str, Mapping[str, Held]] | None = None
    groups: tuple[tuple[str, ...], ...] = ()
    depends_on: tuple[str, ...] = ()
    next_recording: str = ""
    stopped: str = ""
    unseen: UnseenErrors | None = None
    signatures: tuple[Signature, ...] = ()
    warnings: tuple[str, ...] = ()
    left_over: str = ""  # how large the error left is, and where along the first of ``depends_on``
    beyond_noise: Mapping[str, float] = field(default_factory=dict)  # by signal, the error left in times its noise
    origin: Origin | None = None  # None if the file does not tell it
    misread: tuple[str, ...] = ()  # the warnings that put all findings in doubt


def findings_of(found: Discovery, diagnosis: Diagnosis) -> Findings:
    """Findings of a search, with the probabilities of its diagnosis."""
    told = _read({**found.as_json(), "evidence": evidence_json(found)})
    return replace(told, ranking=diagnosis.ranking, none=diagnosis.none, unknown=diagnosis.unknown)


def read_findings(path: Path) -> Findings:
    """Read findings from a file. Raises InputError if ``discover`` or ``diagnose`` did not write it."""
    return read_result(path, _read, "discover", "diagnose")


def read_result(path: Path, read: Callable[[Any], Result], *verbs: str) -> Result:
    """What ``read`` makes of the JSON in a file. Raises InputError if none of the ``verbs`` wrote it."""
    remedy = f"give the file that {verbs[0]} --json wrote"
    try:
        return read(json.loads(path.read_bytes()))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); {remedy}") from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not JSON ({error}); {remedy}") from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        wrote = " or ".join(f"{verb} --json" for verb in verbs)
        raise InputError(f"{path}: is not what {wrote} writes ({type(error).__name__}: {error})") from None


def _read(content: Mapping[str, Any]) -> Findings:
    ranking = tuple(_ranked(entry) for entry in content.get("ranking", ()))
    verdict = str(content["verdict"])
    added = content["added"] if "added" in content else [entry.effect for entry in ranking if entry.found]
    if "added" not in content and verdict not in ("none", "unknown"):  # the verdict of a diagnosis is the effect's id
        verdict = "explained"
    return Findings(
        verdict,
        texts(added),
        ranking,
        number(content["none"]) if ranking else None,
        number(content["unknown"]) if ranking else None,
        tuple(_step(step) for step in content.get("steps", ())),
        {str(name): checked_entry(entry) for name, entry in content.get("parameters", {}).items()},
        {str(part): checked_numbers(entries) for part, entries in content.get("constants", {}).items()},
        tuple(texts(group) for group in content["groups"]),
        texts(content["depends_on"]),
        str(content["next_recording"]),
        str(content.get("stopped", "")),
        _unseen(content["unseen"]) if "unseen" in content else None,
        tuple(_signature(step) for step in content.get("evidence", {}).get("steps", ()) if step["views"]),
        texts(content.get("warnings", ())),
        str(content.get("left_over", "")),
        # beside a noise of zero any error is infinite, which JSON holds as null
        {str(name): math.inf if x is None else number(x) for name, x in content.get("beyond_noise", {}).items()},
        read_origin(content),
        texts(content.get("misread", ())),
    )


def number(value: Any) -> float:
    """A finite number from a file. Raises ValueError if it is not one."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return float(value)


def _perhaps(value: Any) -> float | None:
    return None if value is None else number(value)


def _numbers(values: Sequence[Any]) -> tuple[float, ...]:
    return tuple(number(value) for value in values)


def checked_numbers(numbers: Mapping[str, Held]) -> dict[str, Any]:
    """``{value, std, unit}`` by name from a file. Raises KeyError or ValueError if it is not that."""
    return {str(name): _checked(held) for name, held in numbers.items()}


def _checked(held: Held) -> dict[str, Any]:
    numbers = {"value": number(held["value"]), "std": _perhaps(held["std"])}
    nominal = {"nominal": number(held["nominal"])} if "nominal" in held else {}
    return {**numbers, "unit": str(held["unit"]), **nominal}


def checked_entry(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An effect from a file: its id, its options, and its numbers."""
    head = {"effect": str(entry["effect"]), "options": _options(entry["options"])}
    return head | checked_numbers({name: held for name, held in entry.items() if name not in head})


def _options(options: Mapping[str, Any]) -> dict[str, str]:
    return {str(name): str(choice) for name, choice in options.items()}


def _ranked(entry: Mapping[str, Any]) -> Ranked:
    return Ranked(
        str(entry["effect"]),
        _options(entry["options"]),
        number(entry["probability"]),
        _perhaps(entry["error_removed"]),
        checked_numbers(entry["parameters"]),
        bool(entry["found"]),
    )


def _step(step: Mapping[str, Any]) -> Step:
    return Step(
        effect=str(step["effect"]),
        instance=str(step["instance"]),
        action=str(step["action"]),
        rmse_before=number(step["rmse_before"]),
        rmse_after=number(step["rmse_after"]),
        unit=str(step["unit"]),
        output_before=_perhaps(step["output_before"]),
        output_after=_perhaps(step["output_after"]),
        error_removed=_perhaps(step["error_removed"]),
        reason=str(step["reason"]),
        tried=tuple({"names": list(texts(t["names"])), "gain": number(t["gain"])} for t in step["tried"]),
    )


def _unseen(unseen: Mapping[str, Any]) -> UnseenErrors:
    if not unseen["rmse"]:
        raise ValueError("unseen.rmse is empty")
    given = unseen.get("as_given", {"rmse": None, "recordings": []})
    return UnseenErrors(
        str(unseen["signal"]),
        str(unseen["unit"]),
        number(unseen["noise_floor"]),
        _numbers(unseen["rmse"]),
        tuple((str(entry["name"]), _numbers(entry["rmse"])) for entry in unseen["recordings"]),
        _perhaps(given["rmse"]),
        tuple(number(entry["rmse"]) for entry in given["recordings"]),
        _numbers(unseen.get("settled", [])),
    )


def _curve_name(name: str) -> str:
    if name not in CURVES:
        raise ValueError(f"{name!r} is no curve; these are: {', '.join(CURVES)}")
    return name


def _signature(step: Mapping[str, Any]) -> Signature:
    best = step["views"][0]
    curves = tuple(
        {
            "name": _curve_name(curve["name"]),
            "direction": str(curve["direction"]),
            **{field: _numbers(curve[field]) for field in ("x", "median", "lower", "upper")},
        }
        for curve in best["curves"]
    )
    return Signature(
        str(step["title"]),
        bool(step["taken"]),
        str(step["runner_up"]),
        str(best["left_over"]),
        str(best["unit"]),
        str(best["against"]),
        str(best["against_unit"]),
        _perhaps(best["order"]),
        curves,
    )
