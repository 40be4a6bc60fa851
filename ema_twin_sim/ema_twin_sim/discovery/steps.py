"""The steps of a discovery: what a search added and removed, and the error on data that was not fitted to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from .search.trace import Round, Search
from .unseen import Unseen


@dataclass(frozen=True)
class Step:
    """One step: an effect added (or removed again), with the error before and after on data that was not fitted to.

    The first step starts from the given model with its own constants fitted. ``error_removed`` (0 to 1) counts this
    step only.
    """

    effect: str
    instance: str
    action: str  # add or remove
    rmse_before: float
    rmse_after: float
    unit: str
    output_before: float | None  # rad, RMSE of the output (see ``Unseen``); None if not measured
    output_after: float | None
    error_removed: float | None
    reason: str
    tried: tuple[dict[str, object], ...]


def steps_of(found: Search, unseen: Unseen) -> tuple[Step, ...]:
    """The steps of a search, in their order, with the errors that were judged beside each."""
    steps = []
    for k, turn in enumerate(found.taken):
        tried = tuple(_tried(turn))
        new = [n for n in turn.after.hypothesis.added if n not in turn.before.hypothesis.added]
        gone = [n for n in turn.before.hypothesis.added if n not in turn.after.hypothesis.added]
        for action, names, owner in (("add", new, turn.after), ("remove", gone, turn.before)):
            for name in names:
                step = Step(
                    effect=owner.hypothesis.added[name].effect,
                    instance=name,
                    action=action,
                    rmse_before=unseen.rmse[k],
                    rmse_after=unseen.rmse[k + 1],
                    unit=unseen.unit,
                    output_before=unseen.output[k] if unseen.output else None,
                    output_after=unseen.output[k + 1] if unseen.output else None,
                    error_removed=unseen.credit(k),
                    reason="largest gain" if action == "add" else turn.reason,
                    tried=tried,
                )
                steps.append(step)
    return tuple(steps)


def most_telling_first(names: Iterable[str], steps: Sequence[Step]) -> tuple[str, ...]:
    """Names of effects, the one whose step removed most of the error power first."""
    power = {s.instance: s.rmse_before**2 - s.rmse_after**2 for s in steps if s.action == "add"}
    return tuple(sorted(names, key=lambda name: -power.get(name, 0.0)))


def _tried(turn: Round) -> list[dict[str, object]]:
    return [
        {"names": list(trial.names), "gain": trial.gain, "unique": trial.unique, "misfit": trial.fit.misfit}
        for trial in turn.tried[:6]
    ]
