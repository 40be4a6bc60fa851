"""The commands that a plan chooses from: every kind that the virtual bench has, over sizes and paces."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .bench_limits import Limits

LONGEST = 20.0
"""Own s: duration of a recording, if travel and what has been recorded so far allow."""
_SHORTEST = 0.2  # of that duration: shortest ramp worth recording
_NICE = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_FEW_SPEEDS = (1.0, 0.3)
_SPEEDS = (1.0, 0.5, 0.25, 0.1)
_FEW_HALVES = (0.5, 2.5, 5.0)  # own s
_HALVES = (0.5, 1.0, 2.5, 5.0, 10.0)  # own s
_TIME_OF_SIZE = {"ramp": -1, "triangle": -1, "sine": 0, "step": 0, "speed-triangle": -2, "speed-sine": -1}
"""By kind of command: the power of time in the unit of its size (rad, rad/s or rad/s²)."""


@dataclass(frozen=True)
class Planned:
    """A command and how long to record it: in own units, and in SI as ``simulate`` takes it."""

    command: str
    seconds: float
    turns: int  # half periods completed
    asked: str  # the command in SI
    lasts: float  # s

    @property
    def kind(self) -> str:
        """``ramp``, ``sine``…"""
        return self.command.partition(":")[0]


def command_grid(
    limits: Limits,
    slowest: float,
    position_gain: float,
    *,
    few: bool = False,
    longest: float = LONGEST,
    second: float = 1.0,
    radian: float = 1.0,
) -> tuple[Planned, ...]:
    """Commands of at most ``longest`` whose speed and travel stay within limits; ``few`` returns a handful of them.

    ``slowest`` [rad/s] is the speed of the slow shaft below which nothing can be judged. ``position_gain`` [1/s of the
    slow shaft] gives how fast the position loop answers a step. Both are in own units; ``second`` and ``radian`` are
    the size of one own unit in SI, in which the commands have round numbers.
    """
    velocity = radian / second

    def nice(value: float, unit: float) -> float:
        return round_number(value * unit) / unit

    found: dict[str, Planned] = {}

    def offer(
        kind: str, size: float, pace: float | None, half: float, top: float, seconds: float | None = None
    ) -> None:
        seconds = longest if seconds is None else seconds
        if top >= slowest:
            size_unit = radian * second ** _TIME_OF_SIZE[kind]
            pace_unit = 1.0 / second if kind.endswith("sine") else second
            own = f"{kind}:{size:.12g}" + ("" if pace is None else f":{pace:.12g}")
            asked = f"{kind}:{size * size_unit:g}" + ("" if pace is None else f":{pace * pace_unit:.3g}")
            lasts = float(f"{seconds * second:g}")
            found.setdefault(asked, Planned(own, seconds, math.floor(seconds / half + 1e-9), asked, lasts))

    whole = [half for half in (_FEW_HALVES if few else _HALVES) if 2.0 * half <= longest]
    halves = [nice(half, second) for half in whole or (0.25 * longest,)]
    shortest, longest = _SHORTEST * longest, nice(longest, second)
    for share in _FEW_SPEEDS if few else _SPEEDS:
        speed = nice(share * limits.speed, velocity)
        for sign, room in ((1.0, limits.upper), (-1.0, -limits.lower)):
            lasts = room / speed * second if speed > 0.0 else 0.0
            seconds = min(longest, (math.floor(lasts) if lasts >= 1.0 else round_number(lasts)) / second)
            if seconds >= shortest:
                offer("ramp", sign * speed, None, math.inf, speed, seconds)
            for half in halves:
                slow = min(speed, nice(room / half, velocity))  # if that speed needs too much travel, a lower one
                if sign > 0.0 or limits.upper < slow * half:
                    offer("triangle", sign * slow, half, half, slow)
        for half in halves:
            swing = nice(min(share * limits.speed * half / math.pi, limits.upper, -limits.lower), radian)
            offer("sine", swing, 0.5 / half, half, math.pi * swing / half)
    for half in () if few else (nice(2.0, second), nice(5.0, second)):
        for share in (1.0, 0.4):
            if position_gain > 0.0:
                step = nice(share * min(limits.speed / position_gain, limits.upper), radian)
                offer("step", step, half, half, step * position_gain)
            # speed that rises and falls in one direction, and a sine of speed that reverses
            top = nice(share * min(limits.speed, 2.0 * limits.upper / longest) / half, velocity / second) * half
            offer("speed-triangle", top / half, half, half, top)
            top = nice(share * min(limits.speed, 0.5 * math.pi * limits.upper / half), velocity)
            offer("speed-sine", top, 0.5 / half, half, top)
    return tuple(found.values())


def round_number(value: float) -> float:
    """The largest round number at or below a value; 0 if the value is not above zero."""
    if not value > 0.0:
        return 0.0
    decade = 10.0 ** math.floor(math.log10(value))
    fitting = [step for step in _NICE if step * decade <= value * (1.0 + 1e-9)]
    return float(f"{max(fitting) * decade:.3g}")
