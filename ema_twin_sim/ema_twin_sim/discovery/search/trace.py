"""The trace of a search: what was tried in every round, what it gained, and the result."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit


def new_names(before: Fit, after: Fit) -> tuple[str, ...]:
    """The effects and generic bases that ``after`` has and ``before`` has not."""
    held = {*before.hypothesis.added, *before.hypothesis.generic_bases}
    return tuple(n for n in (*after.hypothesis.added, *after.hypothesis.generic_bases) if n not in held)


NEEDLESS = "no longer needed after the effect that was added"
BEATEN = "another effect explains more in its place"
SURER = "another effect explains as much in its place and is certain"
SIMPLER = "a simpler effect explains as much in its place, beside what is unknown"
SWAPS = frozenset({BEATEN, SURER, SIMPLER})
"""Reasons for which an effect gave its place to another."""
WANDERS_OVER_TIME = "friction that varies slowly over the recording explains as much"
WANDERS = "friction that varies slowly explains as much"
BY_CHANCE = "one recording alone does not tell it from chance"
WANDERS_IN_ONE = "in one recording, friction that varies slowly explains as much: a second recording would tell"
UNSUPPORTED = "the simulation of held-out recordings does not support it"
UNSUPPORTED_IN_ONE = "the simulation of the recording does not support it"
UNCERTAIN = "its numbers are too uncertain, or those of no machine"


@dataclass(frozen=True, eq=False)
class Trial:
    """One candidate of a round: what would be added, and what it would gain."""

    names: tuple[str, ...]
    fit: Fit
    gain: float  # net of penalty, in units of the better fit's noise; worth it above zero
    unique: float  # largest rms, in noise standard deviations, removed from any one recording


@dataclass(frozen=True, eq=False)
class Round:
    """One round of the search: its start, what was tried (best first), and the result."""

    before: Fit
    tried: tuple[Trial, ...]
    after: Fit
    added: tuple[str, ...] = ()  # empty: nothing was worth its penalty
    removed: tuple[str, ...] = ()  # what became needless; may be what was added
    reason: str = NEEDLESS  # why it was removed

    def effect_of(self, name: str) -> str:
        """The effect, or generic basis, behind a name that was tried."""
        held = next((t.fit.hypothesis.added[name] for t in self.tried if name in t.fit.hypothesis.added), None)
        return held.effect if held else name


@dataclass(frozen=True, eq=False)
class Search:
    """The end of a search and its rounds."""

    fit: Fit
    rounds: tuple[Round, ...]
    loosest: Fit | None = None  # the end before constants were put back or refitted

    @property
    def problem(self) -> EquationErrorProblem:
        """The problem that the end was fitted to, with its weighting."""
        return self.fit.problem

    @property
    def changes(self) -> tuple[Round, ...]:
        """The rounds in which something was added or removed, generic bases included."""
        return tuple(turn for turn in self.rounds if turn.after is not turn.before)

    @cached_property
    def taken(self) -> tuple[Round, ...]:
        """The rounds in which an effect was added or removed, but not one that was removed and at once added again."""
        taken: list[Round] = []
        for turn in self.rounds:
            before, after = turn.before.hypothesis.added.keys(), turn.after.hypothesis.added.keys()
            if len(taken) > 1 and len(after) > len(before) and taken[-1].before.hypothesis.added.keys() == after:
                taken.pop()
                taken[-1] = replace(taken[-1], after=turn.after)
            elif after != before:
                taken.append(turn)
        return tuple(taken)

    @property
    def stopped(self) -> Round | None:
        """The last round that added nothing to what the end holds; None if there is none."""
        held = {*self.fit.hypothesis.added, *self.fit.hypothesis.generic_bases}
        refused = (turn for turn in reversed(self.rounds) if turn.after is turn.before)
        last = next(refused, None)
        same = last is not None and {*last.after.hypothesis.added, *last.after.hypothesis.generic_bases} == held
        return last if same else None

    def refitted(self, fit: Fit) -> Search:
        """The search with another fit of the same effects at its end."""
        last = self.changes[-1]
        rounds = tuple(replace(turn, after=fit) if turn is last else turn for turn in self.rounds)
        return replace(self, fit=fit, rounds=rounds, loosest=None)

    def with_numbers(self, fit: Fit) -> Search:
        """The search with other numbers for the same effects at its end, which the data do not ask for."""
        return replace(self.refitted(fit), loosest=self.free_fit)

    @property
    def free_fit(self) -> Fit:
        """The end with all numbers as fitted to the equation error: the reference for comparisons."""
        return self.loosest or self.fit

    def further(self, after: Fit, rounds: Iterable[Round]) -> Search:
        """The search with more rounds that end at ``after``."""
        return replace(self, fit=after, rounds=(*self.rounds, *rounds))

    def ended(self, after: Fit, reason: str) -> Search:
        """The search with one more round that ends at a fit with fewer effects."""
        turn = Round(self.fit, (), after, new_names(self.fit, after), new_names(after, self.fit), reason)
        return replace(self, fit=after, rounds=(*self.rounds, turn), loosest=None)
