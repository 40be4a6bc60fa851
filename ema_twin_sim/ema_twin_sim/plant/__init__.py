"""The compiled plant: drive, transmission, friction and sensors, advanced step by step, without ROS or files.

Numba keys its cache of machine code by the date of one source file, but compiled loops consist of several, some outside
the plant. The cache folder is therefore named after the content of all of them, so that no edit or update ever runs
stale code.
"""

import hashlib
import os
from pathlib import Path

import numba

COMPILED_OUTSIDE = ("identification/encoder_offsets.py", "identification/required_rows.py", "measured/smoothing.py")
"""Other sources with compiled loops that are kept, from the package's folder on."""


def _cache_folder() -> Path:
    content = hashlib.sha256(numba.__version__.encode())
    here = Path(__file__).parent
    for source in sorted([*here.rglob("*.py"), *(here.parent / name for name in COMPILED_OUTSIDE)]):
        content.update(source.read_bytes())
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "ema-twin" / content.hexdigest()[:16]


if not os.environ.get("NUMBA_CACHE_DIR"):
    setattr(numba.config, "CACHE_DIR", str(_cache_folder()))  # noqa: B010 (set while it runs; its type has no such name)
