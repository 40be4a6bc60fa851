"""Restarts: searches begun again with wandering friction as part of the noise."""

from __future__ import annotations

from collections.abc import Callable

from ...identification.fit import Fit
from ...identification.wander import Wander
from .trace import Round


class Restarts:
    """Ends of a search restarted with wandering friction: with the same friction, it would only be repeated."""

    def __init__(self) -> None:
        self._ends: list[tuple[Wander, bool, tuple[Fit, list[Round]]]] = []

    def __call__(
        self, wander: Wander, use_encoder: bool, restart: Callable[[], tuple[Fit, list[Round]]]
    ) -> tuple[Fit, list[Round]]:
        """End and rounds of the search with ``wander`` and with or without encoder rows, restarted if it is new."""
        for other, with_encoder, end in self._ends:
            if other.equals(wander) and with_encoder == use_encoder:
                return end
        end = restart()
        self._ends.append((wander, use_encoder, end))
        return end
