"""Where the command ``ema-twin`` begins, before anything slow is imported."""

from __future__ import annotations

import atexit
import gc

from .interrupts import watch

_RARE_COLLECTION = 100_000
"""New objects between two looks for garbage, of Python's 700 by default: libraries' objects, which stay, come in such
numbers that a tenth of a short command's time went into looking through them."""


def main() -> None:
    """Run the command line."""
    watch()
    gc.set_threshold(_RARE_COLLECTION)
    atexit.register(gc.freeze)  # a last look through all objects of a process that ends frees nothing, and takes 0.2 s
    from .commands.main import main as run

    run()
