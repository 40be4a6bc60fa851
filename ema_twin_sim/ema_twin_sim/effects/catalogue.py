"""The catalogue: every module of this folder that holds an ``EFFECT``, by its id. A new effect is in it by existing."""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from functools import cache

from ema_bench_replay.errors import InputError

from .effect import Effect


@cache
def catalogue() -> dict[str, Effect]:
    """All effects of the package, by id."""
    package = importlib.import_module(__package__)
    found: dict[str, Effect] = {}
    for module in pkgutil.iter_modules(package.__path__):
        effect = getattr(importlib.import_module(f"{__package__}.{module.name}"), "EFFECT", None)
        if isinstance(effect, Effect):
            found[effect.id] = effect
    return dict(sorted(found.items()))


def find_effect(id: str, place: str) -> Effect:
    """The effect of that id. Raises InputError, naming ``place`` and the nearest id, where there is none."""
    effects = catalogue()
    if id not in effects:
        near = difflib.get_close_matches(id, effects, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"the catalogue holds {', '.join(effects)}"
        raise InputError(f"{place}: unknown effect '{id}'; {hint} (list them with: ema-twin effects)")
    return effects[id]
