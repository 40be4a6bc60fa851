"""Plan: the next recording, chosen to separate the explanations that the recordings so far leave open.

It should also show what the recordings so far could not: slow recordings say nothing about drag, and an output that
hardly turned says nothing about its encoder's eccentricity.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import COST_EFFECT, COST_PARAMETER, DECIDED
from ..effects import catalogue
from ..listing import listed
from ..model import Model
from .discover import discover, excluded_effects
from .experiment.bench_limits import Limits, driven_limits
from .experiment.detection import Detection, Showing
from .experiment.doubts import NOTHING, doubts
from .experiment.next_command import Proposal, best_command
from .experiment.rival_field import Pair


@dataclass(frozen=True)
class InDoubt:
    """Explanations between which the recordings do not decide."""

    rivals: tuple[str, ...]  # the leading one first
    behind: tuple[float, ...]  # how far each is behind, in noise units; SIGNIFICANT² decides
    reason: str


@dataclass(frozen=True)
class Plan:
    """What is in doubt, and what to record next; ``as_json`` is what ``plan --json`` writes."""

    verdict: str  # of discover: explained, none or unknown
    added: tuple[str, ...]
    in_doubt: tuple[InDoubt, ...]
    proposal: Proposal | None
    runners_up: tuple[Proposal, ...]
    inseparable: tuple[Pair, ...]  # pairs that no command within the limits separates
    limits: Limits
    depends_on: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def next_recording(self) -> str:
        """The command in one line; empty if there is none to propose."""
        if self.proposal is None:
            return ""
        return f"{self.proposal.command} for {self.proposal.seconds:g} s: {self.proposal.why}"

    def elsewhere(self) -> tuple[str, ...]:
        """What would help with the pairs that no command separates."""
        named = dict.fromkeys(name for pair in self.inseparable for name in pair)
        effects = catalogue()
        return tuple(effects[name].told_by for name in named if name in effects and effects[name].told_by)

    def as_json(self) -> dict[str, object]:
        """SI units."""
        return {
            "verdict": self.verdict,
            "added": list(self.added),
            "in_doubt": [
                {"rivals": list(d.rivals), "behind": list(d.behind), "reason": d.reason} for d in self.in_doubt
            ],
            "proposal": None if self.proposal is None else self.proposal.as_json(),
            "runners_up": [proposal.as_json() for proposal in self.runners_up],
            "decided_from": DECIDED,
            "inseparable": [list(pair) for pair in self.inseparable],
            "elsewhere": list(self.elsewhere()),
            "limits": self.limits.as_json(),
            "depends_on": list(self.depends_on),
            "next_recording": self.next_recording,
            "warnings": list(self.warnings),
        }


def plan(
    recordings: Sequence[Recording],
    model: Model,
    *,
    without: Sequence[str] = (),
    progress: Callable[[str], None] = lambda text: None,
    limits: Limits | None = None,
) -> Plan:
    """The recording that best separates what these recordings of a model's machine leave in doubt.

    Among equals it is the one that shows most of what the recordings so far could not show. ``without`` excludes
    effects of the catalogue. ``limits`` are what the bench may do: by default what it did in these recordings, and more
    only if nothing smaller decides or shows as much. ``progress`` is called with a description of each stage. Raises
    InputError if the recordings cannot be judged.
    """
    pointwise = [recording.name for recording in recordings if recording.of_points]
    if pointwise:
        raise InputError(
            f"{', '.join(pointwise)}: operating points say nothing of how the machine moves, from which a command is "
            "planned; record a motion, slow and fast and both ways"
        )
    found = discover(recordings, model, without=without, progress=progress)
    progress("checking what is in doubt")
    problem = found.equation
    own = found.search.fit.hypothesis.base
    limits = None if limits is None else limits.told(own)
    allowed = limits or driven_limits(problem.observations, own.value("machine.gear_ratio"))
    held = doubts(problem, found.search, found.rivalries, frozenset(without))
    progress("checking which effects would not show")
    detection = Detection(found.search.fit, excluded_effects(found.recordings, own, without))
    choice = best_command(
        problem,
        found.search.fit,
        held,
        found.recordings,
        detection=detection,
        limits=limits,
        few=found.search.fit.parted,  # a gearbox takes too long to try every command
        progress=progress,
    )
    return Plan(
        found.verdict,
        found.added,
        (*(InDoubt(d.names, d.behind, d.reason) for d in held), *_not_shown(choice.so_far)),
        choice.best,
        choice.runners_up,
        choice.inseparable,
        allowed.shown(own, found.recordings),
        found.depends_on,
        found.warnings,
    )


def _not_shown(so_far: Showing | None) -> tuple[InDoubt, ...]:
    """Effects that the recordings so far cannot show or separate, although another recording would."""
    if so_far is None:
        return ()
    doubts = []
    hidden = so_far.hidden()
    if hidden:
        losses = (_price(id) + so_far.of(id) ** 2 for id in hidden)
        reason = f"these recordings would not show {listed(hidden, 'or')} of a usual size"
        doubts.append(InDoubt((NOTHING, *hidden), (0.0, *losses), reason))
    for one, others in so_far.confused().items():
        behind = (min(so_far.of(one, other), so_far.of(other, one)) ** 2 for other in others)
        reason = f"these recordings would not tell {one} from {listed(others, 'or')}"
        doubts.append(InDoubt((one, *others), (0.0, *behind), reason))
    return tuple(doubts)


def _price(id: str) -> float:
    """Complexity penalty of naming an effect."""
    return COST_EFFECT + COST_PARAMETER * len(catalogue()[id].parameters)
