"""The file of a user's own effect: Python that ends in ``EFFECT = Effect(...)``, like the catalogue's files.

Such a file is code. It runs only if it is named on the command line (``--with FILE.py``) or in a node's parameter
(``effect_files``), never because a model names its effect. It is read from source and compiled again in every process
(a twentieth of a second), so that no machine code of an earlier version can run.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from ema_bench_replay.errors import InputError

from ..effects.catalogue import include
from ..effects.effect import Effect
from .refusal import line_of, words
from .table import checked_table
from .trial import try_out

_HINTS = {
    "relative import": "write: from ema_twin_sim.effects.effect import Effect, Parameter",
    "'Parameter' has no len": "a table of one parameter ends in a comma: (Parameter(...),)",
}
"""Remedies for common mistakes, by Python's error message."""


def load_effects(files: Iterable[str | os.PathLike[str]]) -> list[Effect]:
    """Load users' effects and add them to this process's catalogue (a worker process calls it itself)."""
    return [load_effect(file) for file in files]


def load_effect(file: str | os.PathLike[str]) -> Effect:
    """Load the effect of a user's file and add it to this process's catalogue.

    The file is executed. Raises InputError, with file, line and remedy, if it holds no working effect: its table and
    its function are tried out here, not while a twin runs.
    """
    path = Path(file)
    effect = checked_table(path, _read(path))
    try_out(path, effect)
    include(effect, path)
    return effect


def _read(path: Path) -> Effect:
    if path.suffix != ".py":
        raise InputError(f"{path}: is no Python file; name the .py file of an effect of your own")
    try:
        source = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; name the .py file of an effect of your own") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); name a file that you may read") from None
    module = ModuleType("own_effect")
    module.__file__ = str(path)
    try:
        exec(compile(source, str(path), "exec"), vars(module))
    except (Exception, SystemExit) as error:
        said = words(error)
        remedy = next((hint for part, hint in _HINTS.items() if part in said), "correct the file")
        raise InputError(f"{path}: {line_of(error, path)}{said}; {remedy}") from None
    effect = vars(module).get("EFFECT")
    if not isinstance(effect, Effect):
        raise InputError(
            f"{path}: holds no EFFECT; end it with EFFECT = Effect(id=..., …), as the catalogue's files do"
        )
    return effect
