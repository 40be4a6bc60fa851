"""The commands that a plan chooses from: every kind that the virtual bench knows, over sizes and paces."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .bench_limits import Limits

LONGEST = 20.0
"""s: what a recording lasts, as long as travel allows."""
_SHORTEST = 4.0  # s of a ramp worth recording
_NICE = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_FEW_SPEEDS = (1.0, 0.3)
_SPEEDS = (1.0, 0.5, 0.25, 0.1)
_FEW_HALVES = (0.5, 2.5, 5.0)  # s
_HALVES = (0.5, 1.0, 2.5, 5.0, 10.0)  # s


@dataclass(frozen=True)
class Planned:
    """A command as ``simulate --command`` takes it, and for how long it is worth recording."""

    command: str
    seconds: float
    turns: int  # how often its half periods end

    @property
    def kind(self) -> str:
        """``ramp``, ``sine``…"""
        return self.command.partition(":")[0]


def command_grid(limits: Limits, slowest: float, position_gain: float, *, few: bool = False) -> tuple[Planned, ...]:
    """Commands whose speed and travel keep within limits; ``few`` takes a handful of them.

    ``slowest`` [rad/s] is the speed of the slow shaft below which nothing can be judged, ``position_gain`` [1/s of the
    slow shaft] tells how fast the position loop answers a step.
    """
    found: dict[str, Planned] = {}

    def offer(kind: str, size: float, pace: float | None, half: float, top: float, seconds: float = LONGEST) -> None:
        if top >= slowest:
            text = f"{kind}:{size:g}" + ("" if pace is None else f":{pace:g}")
            found.setdefault(text, Planned(text, seconds, math.floor(seconds / half)))

    halves = _FEW_HALVES if few else _HALVES
    for share in _FEW_SPEEDS if few else _SPEEDS:
        speed = nice(share * limits.speed)
        for sign, room in ((1.0, limits.upper), (-1.0, -limits.lower)):
            seconds = min(LONGEST, math.floor(room / speed))
            if seconds >= _SHORTEST:
                offer("ramp", sign * speed, None, math.inf, speed, seconds)
            for half in halves:
                slow = min(speed, nice(room / half))  # where there is no room for that speed, the one there is room for
                if sign > 0.0 or limits.upper < slow * half:
                    offer("triangle", sign * slow, half, half, slow)
        for half in halves:
            swing = nice(min(share * limits.speed * half / math.pi, limits.upper, -limits.lower))
            offer("sine", swing, 0.5 / half, half, math.pi * swing / half)
    for half in () if few else (2.0, 5.0):
        for share in (1.0, 0.4):
            if position_gain > 0.0:
                step = nice(share * min(limits.speed / position_gain, limits.upper))
                offer("step", step, half, half, step * position_gain)
            # speed that rises and falls in one direction, and a swing of speed that turns round
            top = nice(share * min(limits.speed, 2.0 * limits.upper / LONGEST) / half) * half
            offer("speed-triangle", top / half, half, half, top)
            top = nice(share * min(limits.speed, 0.5 * math.pi * limits.upper / half))
            offer("speed-sine", top, 0.5 / half, half, top)
    return tuple(found.values())


def nice(value: float) -> float:
    """The next round number at or below a value; 0 where it is not above zero."""
    if not value > 0.0:
        return 0.0
    decade = 10.0 ** math.floor(math.log10(value))
    fitting = [step for step in _NICE if step * decade <= value * (1.0 + 1e-9)]
    return float(f"{max(fitting) * decade:.3g}")
