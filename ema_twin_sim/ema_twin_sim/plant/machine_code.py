"""Machine code that Numba keeps: in which folder, and how it is loaded at a start.

Numba keys its cache by the date of one source file, but compiled loops consist of several, some outside the plant. The
cache folder is therefore named after the content of all of them, so that no edit or update ever runs stale code.
"""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path
from typing import Any

# Numba imports coverage wherever it is installed: 40 modules, of use only to a run that measures coverage.
_measures_coverage = "coverage" in sys.modules
if not _measures_coverage:
    sys.modules["coverage"] = None  # type: ignore[assignment]

import numba  # noqa: E402
from numba.core import caching  # noqa: E402

from ema_bench_replay.units import SIGNALS  # noqa: E402

if not _measures_coverage:
    del sys.modules["coverage"]

COMPILED_OUTSIDE = ("identification/encoder_offsets.py", "identification/required_rows.py", "measured/smoothing.py")
"""Other sources with compiled loops that are kept, from the package's folder on."""


def keep_by_content() -> None:
    """Let Numba keep its code in a folder named after all sources with compiled loops, unless the user names one."""
    if not os.environ.get("NUMBA_CACHE_DIR"):
        setattr(numba.config, "CACHE_DIR", str(folder()))  # noqa: B010 (set while it runs; its type has no such name)


_KNOWN_STEPS = ("refresh", "_guard_against_spurious_io_errors", "_load_overload")
"""What Numba's loading of kept code consists of (0.61 to 0.68)."""


def load_without_compiler() -> None:
    """Let Numba load this package's kept code without first importing all that its compiler knows of Python and NumPy.

    That takes a quarter of a second of each start. Loaded loops need the runtime alone; the first function that must be
    compiled imports the rest, as ever. Other packages' code is loaded as before: a ufunc, for one, is wrapped by the
    compiler after it is loaded. If Numba's own way has other steps than the known ones, it stays.
    """
    original = caching.Cache.load_overload
    if original.__code__.co_names != _KNOWN_STEPS:
        return
    package = __name__.partition(".")[0]

    def load_overload(cache: Any, sig: object, target_context: Any) -> object:
        if cache._py_func.__module__.partition(".")[0] != package:
            return original(cache, sig, target_context)
        from numba.core.runtime import rtsys

        rtsys.initialize(target_context)
        with cache._guard_against_spurious_io_errors():
            return cache._load_overload(sig, target_context)
        return None  # what could not be read is compiled

    setattr(caching.Cache, "load_overload", load_overload)  # noqa: B010 (mypy forbids to assign to a method)


def folder() -> Path:
    """The folder for kept code, named after the content of all sources with compiled loops."""
    content = hashlib.sha256(numba.__version__.encode())
    here = Path(__file__).parent
    for source in sorted([*here.rglob("*.py"), *(here.parent / name for name in COMPILED_OUTSIDE)]):
        content.update(source.read_bytes())
    content.update(" ".join(SIGNALS).encode())  # the columns of a twin sample
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "ema-twin" / content.hexdigest()[:16]
