"""A unit of a fleet as `units` judges it, day after day, against what is true of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.histories import Outlook, outlooks

from .fleet import HEALTHY_DAYS, LIMITS, REPEATS, WornUnit, drawn_unit

ASKED_AT = (0.4, 0.6, 0.8)
"""Shares of the margin lost at which the remaining life is asked for."""
EARLY = 0.2
"""Of the margin: wear is to be named before so much is lost."""


@dataclass(frozen=True)
class Told:
    """What was told of one unit."""

    wears: str | None
    law: str
    recordings: int  # after the healthy ones, until a false alarm or the end
    false_alarm: bool  # an alarm before anything wears, or one of a number that does not
    lost_when_named: float  # share of the margin when wear was named; infinite where it never was
    first_named: str | None  # the first number that was called changed
    held: tuple[bool | None, ...]  # whether the interval of the remaining life holds it, by ASKED_AT; None: no trend
    widths: tuple[float, ...]  # of these intervals, in times of the truth


def judged(number: int, seed: int) -> Told:
    """A unit drawn and judged."""
    return judge_unit(drawn_unit(seed, number))


def judge_unit(unit: WornUnit) -> Told:
    """By the whole history (an alarm uses nothing of what comes after it), and by what was known at ASKED_AT."""
    looks = asked(unit, np.inf)
    alarms = {look.history.path: _alarm_day(look) for look in looks if look.change is not None}
    wrong = [day for path, day in alarms.items() if path != unit.wears or day < unit.onset]
    first = min(wrong, default=np.inf)
    end = min(first, _last_day(unit))
    recordings = REPEATS * int(np.sum((unit.days <= end)[HEALTHY_DAYS:]))
    named = alarms.get(unit.wears or "", np.inf)
    lost = float(np.interp(named, unit.days, unit.truth)) if unit.onset <= named < np.inf else np.inf
    held: list[bool | None] = []
    widths = []
    for share in ASKED_AT if np.isfinite(unit.life) else ():
        day = float(unit.days[np.flatnonzero(unit.truth >= share)[0]])
        assert unit.wears is not None  # what has a life wears
        (look,) = asked(unit, day, unit.wears)
        if look.life is None:
            held.append(None)
            continue
        left = unit.life - day
        held.append(look.life.earliest <= left <= look.life.latest)
        widths.append((look.life.latest - look.life.earliest) / left)
    return Told(
        wears=unit.wears,
        law=unit.law,
        recordings=recordings,
        false_alarm=np.isfinite(first),
        lost_when_named=lost,
        first_named=min(alarms, key=alarms.__getitem__, default=None),
        held=tuple(held),
        widths=tuple(widths),
    )


def asked(unit: WornUnit, day: float, path: str | None = None) -> list[Outlook]:
    """What `units --limits --healthy` tells on a day; of one number, or of all."""
    limits = {path: limit for path, (_, limit, _) in LIMITS.items()}
    return outlooks(unit.until(day, path), limits, Healthy(count=HEALTHY_DAYS * REPEATS))


def _alarm_day(look: Outlook) -> float:
    assert look.change is not None
    return float(look.history.times[look.change.alarm])


def _last_day(unit: WornUnit) -> float:
    return float(unit.days[np.flatnonzero(unit.truth <= 1.05)[-1]])
