"""Judge a job: what is still missing, and the settings that add it to the given model."""

from __future__ import annotations

import math
import traceback
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ema_bench_replay.errors import InputError

from ...discovery.diagnose import weigh
from ...discovery.discover import discover
from ...effects import Kind, kind_of
from ...effects.catalogue import own_files
from ...model import EffectInstance, Model, load_model
from ...model.model import ENABLED
from ...own_effects import load_effects
from .frames import Answer, Job

_DIGITS = 1e-6
"""Relative difference that `ema-twin diff` does not show."""


def judge(job: Job) -> Answer:
    """The answer to a job; a refusal if its recordings cannot be judged.

    Effects applied before are searched for again with free parameters: theirs came from a short window, and their
    errors would otherwise look like a missing effect.
    """
    try:
        load_effects(file for file in job.effect_files if Path(file) not in own_files())
        present, base = load_model(job.model), load_model(job.base)
        found = discover(job.recordings, base)
        diagnosis: dict[str, Any] = weigh(found).as_json()
    except InputError as error:
        return Answer(None, refusal=str(error))
    except Exception as error:  # our own fault: traceback to standard error, one line to the caller
        traceback.print_exc()
        return Answer(None, refusal=f"internal error (traceback on the monitor's standard error): {error!r}")
    new = {kind(held): name for name, held in found.model.active.items() if name not in base.active}
    for entry in diagnosis["ranking"]:
        entry["instance"] = new.get(_kind(entry)) or _next_name(present, entry["effect"])
    explanation = [entry for entry in diagnosis["ranking"] if entry["found"]]
    applied = [kind(held) for name, held in present.active.items() if name not in base.active]
    settings = settings_between(present, found.model) if explanation else {}
    return Answer(still_missing(diagnosis, applied), explanation, settings)


def kind(instance: EffectInstance) -> Kind:
    """What identifies an instance in a diagnosis; see ``kind_of``."""
    return kind_of(instance.effect, instance.options)


def _kind(entry: Mapping[str, Any]) -> Kind:
    return kind_of(entry["effect"], entry["options"])


def _next_name(model: Model, effect: str) -> str:
    """The name of one more instance of an effect."""
    name, number = effect, 2
    while name in model.active:
        name, number = f"{effect}_{number}", number + 1
    return name


def still_missing(diagnosis: Mapping[str, Any], applied: Collection[Kind]) -> dict[str, Any]:
    """The diagnosis of a model that has the effects `applied`, from one of the model without them (both as JSON).

    An applied effect is no longer missing. If effects were found, but not an applied one, a warning says so.
    """
    if not applied:
        return dict(diagnosis)
    found = [_kind(entry) for entry in diagnosis["ranking"] if entry["found"]]
    ranking = [entry for entry in diagnosis["ranking"] if _kind(entry) not in applied]
    more = [entry for entry in ranking if entry["found"]]
    unseen = [each for each in applied if each not in found]
    warnings = [
        *diagnosis["warnings"],
        *(f"{id} was applied before, but these samples do not show it" for id, _ in unseen if found),
    ]
    if diagnosis["verdict"] == "unknown":
        verdict, none = "unknown", 0.0
    elif more:
        verdict, none = more[0]["effect"], 0.0
    else:
        verdict, none = "none", 1.0 - diagnosis["unknown"]  # rivals of an applied effect are not missing
    return {**diagnosis, "verdict": verdict, "ranking": ranking, "none": none, "warnings": warnings}


def _same(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=_DIGITS)


def settings_between(before: Model, after: Model) -> dict[str, bool | float | str]:
    """The differences between two models, as parameters of a running twin (`Model.with_setting`).

    Effects that only `after` has are switched on with all their options and parameters. Of what both have, the numbers
    are set that differ by more than `_DIGITS`. No effect is switched off: a window that does not show it does not prove
    that it is absent.
    """
    settings: dict[str, bool | float | str] = {
        path: held.value
        for path, held in after.constants.items()
        if path in before.constants and not _same(held.value, before.value(path))
    }
    for name, instance in after.active.items():
        old = before.active.get(name)
        if old is not None and (old.effect, dict(old.options)) == (instance.effect, dict(instance.options)):
            settings |= {
                f"effects.{name}.{parameter}": value
                for parameter, value in instance.parameters.items()
                if not _same(value, old.parameters[parameter])
            }
        else:
            held: dict[str, bool | float | str] = {**instance.options, **instance.parameters, ENABLED: True}
            settings |= {f"effects.{name}.{word}": value for word, value in held.items()}
    return settings
