"""The commands of the slow shaft that the cases are driven by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Drive:
    """A command: its kind, size (rad/s of a ramp or triangle, rad of a sine or step) and Hz or half period in s."""

    kind: str
    size: float
    pace: float = 0.0

    @property
    def name(self) -> str:
        """As the bench names its files: ``ramp_0.05``, ``sine_0.02_1Hz``."""
        return f"{self.kind}_{self.size:g}" + (f"_{self.pace:g}Hz" if self.kind == "sine" else "")

    def __call__(self, time: np.ndarray) -> np.ndarray:
        """Angles [rad] (n,) at times [s] (n,), from zero on."""
        if self.kind == "ramp":
            return self.size * time
        if self.kind == "sine":
            return self.size * np.sin(2.0 * np.pi * self.pace * time)
        turn = np.mod(time / self.pace, 2.0)
        if self.kind == "step":
            return self.size * (turn >= 1.0)
        return self.size * self.pace * (1.0 - np.abs(1.0 - turn))


def drawn_drives(random: np.random.Generator) -> tuple[tuple[Drive, ...], tuple[Drive, ...]]:
    """Five or six commands for training and two for judging, of the kinds that the bench is run with."""
    sines = [
        Drive("sine", *list(zip((0.05, 0.03, 0.05), (0.25, 0.5, 0.3), strict=True))[random.integers(3)]),
        Drive("sine", *list(zip((0.02, 0.03, 0.02), (1.0, 0.7, 0.8), strict=True))[random.integers(3)]),
    ]
    if random.random() < 0.5:
        sines.reverse()
    fast = Drive("triangle", float(random.choice([0.03, 0.04, 0.06, 0.08])), float(random.choice([2.5, 3.3, 5.0])))
    train = [
        Drive("ramp", float(random.choice([0.01, 0.015, 0.02]))),
        Drive("ramp", float(random.choice([0.07, 0.08, 0.1]))),
        sines[0],
        Drive("triangle", float(random.choice([0.012, 0.015, 0.02])), 2.0),
        fast,
    ]
    if random.random() < 0.5:
        train.append(Drive("step", float(random.choice([0.01, 0.02])), 2.0))
    return tuple(train), (Drive("ramp", 0.05), sines[1])
