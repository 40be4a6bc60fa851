"""The catalogue: every module of this folder that holds an ``EFFECT``, by id. A new file is included automatically.

Effects from users' files are added in each process that has read these files (see ``own_effects``).
"""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from ema_bench_replay.errors import InputError

from .effect import Effect, Trait

Kind = tuple[str, tuple[tuple[str, str], ...]]
"""An effect's id, and its options except the law of its equation."""

_own: dict[Path, Effect] = {}
"""Users' effects, by file."""


@cache
def catalogue() -> dict[str, Effect]:
    """All effects by id: those of the package, and the users' effects that this process has read."""
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
    """The ids of all effects with a trait, including users' own."""
    return frozenset(id for id, effect in catalogue().items() if trait in effect.traits)


def kind_of(id: str, options: Mapping[str, str]) -> Kind:
    """What identifies a cause: an effect and its options, except the law of its equation."""
    effect = catalogue().get(id)
    return id, tuple(sorted(chosen for chosen in options.items() if effect is None or chosen[0] != effect.law))


def the_effect(trait: Trait) -> str:
    """The id of the package's only effect with a trait. Raises ValueError if there is not exactly one."""
    (id,) = (id for id, effect in _shipped().items() if trait in effect.traits)
    return id


def include(effect: Effect, file: Path) -> None:
    """Add the effect of a user's file to the catalogue; reading a file again replaces its effect.

    Raises InputError if another effect has that id.
    """
    holders = {held.id: f"in {place}" for place, held in _own.items() if place != file.resolve()}
    holders |= dict.fromkeys(_shipped(), "in the catalogue")
    if effect.id in holders:
        raise InputError(f"{file}: EFFECT.id: '{effect.id}' is there already, {holders[effect.id]}; choose another id")
    _own[file.resolve()] = effect
    catalogue.cache_clear()


def own_files() -> tuple[Path, ...]:
    """The users' files that this process has read; another process must read them with ``load_effects``."""
    return tuple(_own)


def is_own(effect: Effect) -> bool:
    """Whether an effect comes from a user's file."""
    return _shipped().get(effect.id) is not effect


def find_effect(id: str, place: str) -> Effect:
    """The effect with that id. Raises InputError, naming ``place`` and the nearest id, if there is none."""
    effects = catalogue()
    if id not in effects:
        near = difflib.get_close_matches(id, effects, n=1, cutoff=0.5)
        hint = f"did you mean '{near[0]}'? If" if near else "if"
        raise InputError(
            f"{place}: unknown effect '{id}'; {hint} it is your own, name its file: --with FILE.py (of a node: "
            "effect_files); ema-twin effects lists the others"
        )
    return effects[id]
