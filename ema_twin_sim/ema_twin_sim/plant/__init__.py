"""The compiled plant: drive, transmission, friction and sensors, advanced step by step, without ROS or files.

Numba keys its cache of machine code by the date of one source file, but the kernel consists of several. The cache
folder is therefore named after the content of all of them, so that no edit or update ever runs stale code.
"""

import hashlib
import os
from pathlib import Path

import numba


def _cache_folder() -> Path:
    content = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        content.update(source.read_bytes())
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "ema-twin" / content.hexdigest()[:16]


if not os.environ.get("NUMBA_CACHE_DIR"):
    setattr(numba.config, "CACHE_DIR", str(_cache_folder()))  # noqa: B010 (set while it runs; its type has no such name)
