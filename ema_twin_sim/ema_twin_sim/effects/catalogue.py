"""The catalogue: every module of this folder that holds an ``EFFECT``, by its id. A new effect is in it by existing.

Effects from users' files stand beside them in the process that was told to read these files (see ``own_effects``).
"""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from functools import cache
from pathlib import Path

from ema_bench_replay.errors import InputError

from .effect import Effect, Trait

_own: dict[Path, Effect] = {}
"""Users' effects, by the file that each is from."""


@cache
def catalogue() -> dict[str, Effect]:
    """All effects by id: those of the package, and the users' that this process has read."""
    return {**_shipped(), **{effect.id: effect for effect in _own.values()}}


@cache
def _shipped() -> dict[str, Effect]:
    package = importlib.import_module(__package__)
    found: dict[str, Effect] = {}
    for module in pkgutil.iter_modules(package.__path__):
        effect = getattr(importlib.import_module(f"{__package__}.{module.name}"), "EFFECT", None)
        if isinstance(effect, Effect):
            found[effect.id] = effect
    return dict(sorted(found.items()))


def effects_with(trait: Trait) -> frozenset[str]:
    """The ids of all effects of a trait, users' own included."""
    return frozenset(id for id, effect in catalogue().items() if trait in effect.traits)


def the_effect(trait: Trait) -> str:
    """The id of the package's only effect of a trait. Raises ValueError where there is not just one."""
    (id,) = (id for id, effect in _shipped().items() if trait in effect.traits)
    return id


def include(effect: Effect, file: Path) -> None:
    """Put the effect of a user's file beside the package's; a file that is read again replaces what it held.

    Raises InputError where another effect has that id.
    """
    holders = {held.id: f"in {place}" for place, held in _own.items() if place != file.resolve()}
    holders |= dict.fromkeys(_shipped(), "in the catalogue")
    if effect.id in holders:
        raise InputError(f"{file}: EFFECT.id: '{effect.id}' is there already, {holders[effect.id]}; choose another id")
    _own[file.resolve()] = effect
    catalogue.cache_clear()


def own_files() -> tuple[Path, ...]:
    """The users' files that this process has read; another process reads them with ``load_effects``."""
    return tuple(_own)


def is_own(effect: Effect) -> bool:
    """Whether an effect is from a user's file."""
    return _shipped().get(effect.id) is not effect


def find_effect(id: str, place: str) -> Effect:
    """The effect of that id. Raises InputError, naming ``place`` and the nearest id, where there is none."""
    effects = catalogue()
    if id not in effects:
        near = difflib.get_close_matches(id, effects, n=1, cutoff=0.5)
        hint = f"did you mean '{near[0]}'? " if near else ""
        raise InputError(
            f"{place}: unknown effect '{id}'; {hint}If it is your own, name its file: --with FILE.py (of a node: "
            "effect_files); the others: ema-twin effects"
        )
    return effects[id]
