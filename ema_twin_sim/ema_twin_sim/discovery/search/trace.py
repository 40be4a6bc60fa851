"""The trace of a search: what was tried in every round, what it gained, and what came of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit


def new_names(before: Fit, after: Fit) -> tuple[str, ...]:
    """The effects and generic bases that one fit has and another has not."""
    held = {*before.hypothesis.added, *before.hypothesis.generic_bases}
    return tuple(n for n in (*after.hypothesis.added, *after.hypothesis.generic_bases) if n not in held)


NEEDLESS = "needless beside what was added"
BEATEN = "others explain more in its place"
SURER = "another explains as much in its place, and is sure"
WANDERS_OVER_TIME = "friction that wanders over the recording explains as much"
WANDERS = "friction that wanders explains as much"
UNCERTAIN = "too uncertain to be named"


@dataclass(frozen=True, eq=False)
class Trial:
    """One thing that was tried in a round: what would be added, and what it would gain."""

    names: tuple[str, ...]
    fit: Fit
    gain: float  # price paid, in units of the noise that the better fit leaves; above zero it is worth it
    unique: float  # largest rms, in noise standard deviations, that it takes from some recording


@dataclass(frozen=True, eq=False)
class Round:
    """One round of the search: where it began, what was tried (best first), what came of it."""

    before: Fit
    tried: tuple[Trial, ...]
    after: Fit
    added: tuple[str, ...] = ()  # empty: nothing was worth its price
    removed: tuple[str, ...] = ()  # what was needless beside it, which may be itself
    reason: str = NEEDLESS  # why that was removed

    def effect_of(self, name: str) -> str:
        """The effect, or the generic basis, behind a name that was tried."""
        held = next((t.fit.hypothesis.added[name] for t in self.tried if name in t.fit.hypothesis.added), None)
        return held.effect if held else name


@dataclass(frozen=True, eq=False)
class Search:
    """The end of a search and the way there."""

    fit: Fit
    rounds: tuple[Round, ...]
    loosest: Fit | None = None  # the end before numbers of it were put back, where they were

    @property
    def problem(self) -> EquationErrorProblem:
        """What the end was fitted to, under its weighting."""
        return self.fit.problem

    @property
    def changes(self) -> tuple[Round, ...]:
        """The rounds in which something came or went, generic bases included."""
        return tuple(turn for turn in self.rounds if turn.after is not turn.before)

    @property
    def taken(self) -> tuple[Round, ...]:
        """The rounds in which an effect came or went."""
        return tuple(t for t in self.rounds if t.after.hypothesis.added.keys() != t.before.hypothesis.added.keys())

    @property
    def stopped(self) -> Round | None:
        """The last round in which nothing was worth its price beside what the end holds; None where there is none."""
        held = {*self.fit.hypothesis.added, *self.fit.hypothesis.generic_bases}
        refused = (turn for turn in reversed(self.rounds) if turn.after is turn.before)
        last = next(refused, None)
        same = last is not None and {*last.after.hypothesis.added, *last.after.hypothesis.generic_bases} == held
        return last if same else None

    def with_numbers(self, fit: Fit) -> Search:
        """The search with other numbers of what it ended with."""
        last = self.changes[-1]
        rounds = tuple(replace(turn, after=fit) if turn is last else turn for turn in self.rounds)
        return replace(self, fit=fit, rounds=rounds, loosest=self.free_fit)

    @property
    def free_fit(self) -> Fit:
        """The end with all its numbers where the equation error has them: what others may be held against."""
        return self.loosest or self.fit

    def further(self, after: Fit, rounds: Iterable[Round]) -> Search:
        """The search with more rounds, which end at a fit."""
        return replace(self, fit=after, rounds=(*self.rounds, *rounds))

    def ended(self, after: Fit, reason: str) -> Search:
        """The search with one more round, which ends at a fit that holds less."""
        turn = Round(self.fit, (), after, new_names(self.fit, after), new_names(after, self.fit), reason)
        return replace(self, fit=after, rounds=(*self.rounds, turn), loosest=None)
