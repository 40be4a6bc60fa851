"""The ending: why a search added no more effects, in a sentence or two."""

from __future__ import annotations

from collections.abc import Mapping

from ..comparison.beyond_noise import times_words
from ..criteria import NOISY
from ..identification.equation import EquationErrorProblem
from ..listing import listed
from ..model.own_units import shown
from ..quantities import quantity
from .criteria.episodes import episodes, listed_episodes
from .criteria.explained import lagging
from .search.trace import Search
from .unseen import Unseen


def why_ended(
    problem: EquationErrorProblem,
    verdict: str,
    found: Search,
    depends_on: tuple[str, ...],
    unseen: Unseen,
    beyond: Mapping[str, float],
) -> str:
    """What kind of error is left; if none, a sentence that no further effect is worth its complexity penalty.

    ``beyond`` are the signals whose errors exceed the sensors' noise at the end, and how many times.
    """
    base = found.fit.hypothesis.base
    if lags := lagging(problem, found.fit) if "encoders" in depends_on else {}:
        run = max(lags, key=lambda name: abs(lags[name]))
        away = quantity(*shown(base, abs(lags[run]), "rad"))
        return (
            f"the output of {run} lies {away} off the motor almost since its start; play, "
            "or a shaft that winds up, would do that, and recordings with reversals would tell which"
        )
    if passing := episodes(problem, found.fit) if "time" in depends_on else ():
        longest = max(passing, key=lambda episode: episode.end - episode.start)
        second, _ = shown(base, 1.0, "s")
        torque = quantity(*shown(base, abs(longest.against), "N m"))
        how = f"{torque} {'more' if longest.against > 0.0 else 'less'} against the motion"
        return (
            f"the remaining error comes and goes: {listed_episodes(passing, second=second)}; on average {how} in the "
            "longest of them. No effect of the catalogue does that"
        )
    if verdict == "unknown":
        on = ", ".join(depends_on).replace("_", " ")
        return (
            f"the remaining error depends on {on}; no effect of the catalogue does"
            if on
            else "the remaining error fits no effect"
        )
    last = found.stopped
    if last is None:
        end = found.rounds[-1]
        return (
            "the search has added as many effects as it may"
            if end.tried
            else f"the effect added last was dropped: {end.reason}"
        )
    if not last.tried:
        return "nothing is left to try"
    if unseen.rmse[-1] > NOISY * unseen.noise_floor and found.fit.parted and problem.size:
        return (
            "no effect explains more; what the simulated current still misses is at impacts, whose timing needs "
            "parameters known to 0.1 %"
        )
    if beyond:
        signals = listed([f"{name.replace('_', ' ')} ({times_words(times)})" for name, times in beyond.items()])
        return f"no effect explains enough more to be named; errors still beyond the sensors' noise: {signals}"
    return "no effect explains more of the remaining error than chance would"
