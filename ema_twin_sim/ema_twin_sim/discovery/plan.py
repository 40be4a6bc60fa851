"""Plan: the next recording, so that it tells the explanations apart that the recordings so far leave open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import DECIDED
from ..model import Model
from .discover import discover, excluded_effects
from .experiment.bench_limits import Limits, driven_limits
from .experiment.doubts import doubts
from .experiment.next_command import Choice, Pair, Proposal, best_command, signals_of
from .experiment.too_faint import too_faint

_ELSEWHERE = {
    "torque_constant_error": "an inertia that is known better, or the voltage, would tell the torque constant",
    "mesh_friction": "friction that follows the load shows when the load on the output is changed",
    "added_inertia": "an inertia that is known better would tell",
}
"""What would help where no command does, by effect."""


@dataclass(frozen=True)
class InDoubt:
    """Explanations of which the recordings do not tell which is right."""

    rivals: tuple[str, ...]  # the leading one first
    behind: tuple[float, ...]  # how much each loses by, prices paid, in units of noise; 16 are needed
    reason: str


@dataclass(frozen=True)
class Plan:
    """What is in doubt, and what to record next; ``as_json`` is what ``plan --json`` writes."""

    verdict: str  # of discover: explained, none or unknown
    added: tuple[str, ...]
    in_doubt: tuple[InDoubt, ...]
    proposal: Proposal | None
    runners_up: tuple[Proposal, ...]
    inseparable: tuple[Pair, ...]  # pairs that no command within the limits tells apart
    limits: Limits
    depends_on: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def next_recording(self) -> str:
        """The command in one line; empty where there is none to propose."""
        if self.proposal is None:
            return ""
        return f"{self.proposal.command} for {self.proposal.seconds:g} s: {self.proposal.why}"

    def elsewhere(self) -> tuple[str, ...]:
        """What would help with the pairs that no command tells apart."""
        named = dict.fromkeys(name for pair in self.inseparable for name in pair)
        return tuple(_ELSEWHERE[name] for name in named if name in _ELSEWHERE)

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
    """The recording that would best tell apart what these recordings of a model's machine leave in doubt.

    ``without`` takes effects out of the catalogue; ``limits`` are what the bench may be asked to do: by default what
    it has done in these recordings, and more only where nothing less decides. ``progress`` is called with what is being
    done. Raises InputError where the recordings cannot be judged.
    """
    pointwise = [recording.name for recording in recordings if recording.of_points]
    if pointwise:
        raise InputError(
            f"{', '.join(pointwise)}: operating points say nothing of how the machine moves, from which a command is "
            "planned; record a motion, slow and fast and both ways"
        )
    found = discover(recordings, model, without=without, progress=progress)
    progress("asking what is in doubt")
    problem = found.equation
    own = found.search.fit.hypothesis.base
    limits = None if limits is None else limits.told(own)
    allowed = limits or driven_limits(problem.observations, own.value("machine.gear_ratio"))
    held = doubts(problem, found.search, found.rivalries, frozenset(without))
    signals = signals_of(found.recordings)
    choice = Choice(None, (), ())
    if held:
        choice = best_command(problem, held, signals, limits=limits, progress=progress)
    elif found.verdict != "unknown":
        progress("asking what would not show")
        faint = too_faint(problem, found.search, excluded_effects(found.recordings, own, without))
        if faint is not None:
            wider = best_command(problem, [faint], signals, limits=limits, few=True, progress=progress)
            if wider.best is not None:  # what no command would show is in no doubt either
                held, choice = (faint,), wider
    return Plan(
        found.verdict,
        found.added,
        tuple(InDoubt(d.names, d.behind, d.reason) for d in held),
        choice.best,
        choice.runners_up,
        choice.inseparable,
        allowed.shown(own),
        found.depends_on,
        found.warnings,
    )
