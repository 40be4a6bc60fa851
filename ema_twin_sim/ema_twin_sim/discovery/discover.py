"""Discover: which effects a model lacks, how certain that is, and the model that has them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.beyond_noise import beyond_noise
from ..comparison.compare import Signals, overall_errors
from ..criteria import DEPENDS, MOST_EFFECTS, SMALL
from ..effects import Trait, catalogue, effects_with
from ..identification.equation import EquationErrorProblem
from ..identification.estimates import constants, far_off, far_off_in_words, off_by_one_factor, parameters
from ..identification.fit import Fit, fit
from ..identification.hypothesis import Hypothesis
from ..identification.on_bound import on_bounds, own_on_bounds, torque_sign_reversed
from ..measured.noise import NoiseFloor
from ..measured.observability import not_shown, own_not_shown, restored
from ..measured.scales import rms_torque, with_hidden_as_given
from ..measured.usual_sizes import unusual_currents
from ..model import Model
from ..model.own_units import in_si, is_linear, native_as_given
from ..simulation.angle_origins import without_common_zero
from .assumed_torque import of_assumed_torque
from .cautions import ALONE, ONE_DIRECTION, WITHOUT_TORQUE, of_open_constants, of_wrong_constants
from .criteria.contradictions import contradictions
from .criteria.explained import explained
from .differing_zeros import of_differing_zeros
from .ending import why_ended
from .errors_beside_curves import errors_beside_curves
from .experiment.doubts import moves_one_way
from .experiment.suggestion import suggest
from .flanks_under_load import of_unseen_load, with_play_between_flanks
from .followed import with_followed_numbers
from .idle_effects import idle_effects, idle_encoder_errors, shows_over
from .late_output import longer_delay
from .left_over import left_over_words
from .reading import read_with_one_zero
from .search.adding import settle
from .search.one_recording import less_what_one_recording_leaves_open
from .search.removing import less, significant
from .search.rivals import Rivalry, judged_against_rivals, undecided
from .search.search import search
from .search.search_order import in_another_order
from .search.trace import UNSUPPORTED, UNSUPPORTED_IN_ONE, Search
from .search.unknown import beside_the_unknown, doubted
from .search.wandering_end import (
    less_what_wandering_explains,
    wandering_after_all,
    without_warming_that_wandering_explains,
)
from .shares import of_sums, with_division
from .slight_laws import without_slight_laws
from .split import ClosedLoop, with_best_split
from .steps import Step, most_telling_first, steps_of
from .straight_waves import of_straight_waves
from .torque_constant import with_factor_as_constant, with_factor_in_the_constant
from .unmoved import beside_constants_as_filed, freed, with_unmoved_constants
from .unseen import Judge, Unseen, gain_where_unseen


@dataclass(frozen=True, eq=False)
class Discovery:
    """What a discovery found; ``as_json`` is what ``discover --json`` writes.

    ``misread`` are the warnings that put every finding in doubt, such as a wrong unit: to be told before the findings.
    """

    verdict: str  # explained, none or unknown
    added: tuple[str, ...]
    model: Model
    steps: tuple[Step, ...]
    parameters: MappingProxyType[str, dict[str, Any]]
    constants: MappingProxyType[str, dict[str, dict[str, object]]]
    groups: tuple[tuple[str, ...], ...]
    depends_on: tuple[str, ...]
    suggestion: Callable[[], str]  # of the next recording: computed when it is asked for, since it takes a while
    stopped: str
    warnings: tuple[str, ...]
    unseen: Unseen
    search: Search
    equation: EquationErrorProblem
    rivalries: tuple[Rivalry, ...]
    recordings: tuple[Recording, ...]  # as judged on unseen data: resampled, in SI
    given: tuple[Recording, ...]  # as they were given, with the zeros of their positions moved to one
    noise: NoiseFloor  # of the recordings, SI; the reference for every statement about them
    input: str  # input of the twins
    left: Signals  # errors of the model that was found, as ``compare`` reports them
    left_over: str = ""  # how large, and where along the first of ``depends_on``
    misread: tuple[str, ...] = ()

    @cached_property
    def next_recording(self) -> str:
        """What to record next, in a line that begins with the command; empty if nothing is in doubt."""
        return self.suggestion()

    @property
    def beyond_noise(self) -> dict[str, float]:
        """Ratio of error to sensor noise for each signal that still exceeds it, worst first."""
        return beyond_noise(self.input, self.left)

    @property
    def origin(self) -> dict[str, object]:
        """What it was computed from, for JSON: names of the model, its machine and the recordings."""
        names = [recording.name for recording in self.given]
        return {"model": self.model.name, "machine": self.model.machine, "recordings": names}

    def as_json(self) -> dict[str, object]:
        """SI units; missing numbers are null."""
        return {
            **self.origin,
            "added": list(self.added),
            "verdict": self.verdict,
            "steps": [{**vars(step), "tried": list(step.tried)} for step in self.steps],
            "parameters": dict(self.parameters),
            "constants": dict(self.constants),
            "groups": [list(group) for group in self.groups],
            "depends_on": list(self.depends_on),
            "left_over": self.left_over,
            "next_recording": self.next_recording,
            "stopped": self.stopped,
            "unseen": self.unseen.as_json(),
            "left": {name: dict(error) for name, error in self.left.items()},
            "beyond_noise": self.beyond_noise,
            "warnings": list(self.warnings),
            "misread": list(self.misread),
        }


def discover(
    recordings: Sequence[Recording],
    model: Model,
    *,
    without: Sequence[str] = (),
    progress: Callable[[str], None] = lambda text: None,
) -> Discovery:
    """Find the effects that a model lacks, given recordings of its machine.

    ``without`` excludes effects of the catalogue; ``progress`` is called with a description of each stage. Raises
    InputError if the recordings cannot be judged.
    """
    progress("reading the motion")
    given, read = model, read_with_one_zero(recordings, model)
    recordings, model, problem, null, noise = read.recordings, read.model, read.problem, read.null, read.noise
    excluded = excluded_effects(recordings, model, without)
    found, known = _searched(problem, null, excluded, progress)
    if not known and (longest := longer_delay(problem, found.rounds[0].before, excluded)):
        progress("an encoder seems to be late: trying longer delays")
        again, known = _searched(problem.with_encoders_late_by(longest), null, excluded, progress)
        found = again if known else found
    found = with_factor_as_constant(found, recordings)
    searched = found.fit
    start = found.rounds[0].before
    depends_on: tuple[str, ...] = ()
    if not known and found.problem.weighting.wander is not None and explained(found.problem, found.fit, start):
        depends_on = ("time",)  # wandering friction is all that is left
        found = doubted(found)
    elif not known:
        progress("an error remains: looking for what it depends on")
        found, depends_on = beside_the_unknown(found, progress)
    progress("looking for rivals")
    found, rivals = judged_against_rivals(found, excluded, beside_unknown=not known)
    found = with_factor_as_constant(significant(found), recordings)
    known = known and (found.fit is searched or explained(found.problem, found.fit, start))
    loop = ClosedLoop(recordings, found.fit.hypothesis.base)
    found = with_best_split(loop, found)
    found = with_unmoved_constants(loop, found) if known else found
    found, uncertain = with_play_between_flanks(found, recordings)
    progress("judging by simulation")
    began = read.began if model.is_open else in_si(model)
    judge = Judge(read.rotary, began, noise)
    unseen = judge(found)
    kept: set[frozenset[str]] = set()
    judged = found
    idle, gearbox = (
        idle_effects(found, unseen, kept) if known or model.is_open else (idle_encoder_errors(found, unseen), False)
    )
    while idle:
        before = {*found.fit.hypothesis.added}
        shown_over = tuple(dict.fromkeys(shows_over(found, name) for name in idle))
        fewer = less(found, idle, UNSUPPORTED if len(recordings) > 1 else UNSUPPORTED_IN_ONE)
        beside = judge(fewer)
        error_without = beside.moving[-1]
        if not fewer.fit.hypothesis.added:  # the given constants may do better than those fitted without effects
            error_without = min(error_without, beside.moving[0])
        if model.is_open and not gearbox and not error_without < unseen.moving[-1]:
            kept.add(frozenset(idle))  # the other effects need it, whatever its own step did
            idle, gearbox = idle_effects(found, unseen, kept)
            continue
        found, unseen = fewer, beside
        back = not before.issuperset(found.fit.hypothesis.added)  # it had replaced something
        # with open constants, the rest may explain the recordings as well as anything does
        known = (model.is_open or back) and explained(found.problem, found.fit, start)
        depends_on = () if known else depends_on or shown_over
        idle, gearbox = idle_effects(found, unseen, kept) if (known and back) or model.is_open else ((), False)
    if found is not judged and (sure := significant(found)) is not found:  # less certain without what was removed
        found, unseen = sure, judge(sure)
        known = (model.is_open or known) and explained(found.problem, found.fit, start)
        depends_on = () if known else depends_on
    if model.is_open:
        found, unseen = without_slight_laws(found, unseen, judge, rms_torque(read.rotary, began))
    if known and model.is_open and _leaves_torque(unseen, rms_torque(read.rotary, began)):
        known, depends_on = False, ()  # what is left is too fast for the rows to tell on what it depends
    turned = torque_sign_reversed(found.problem, found.fit)  # then nothing that fits is a load of this machine
    known = known and not turned
    stands = (unseen.betters or (model.is_open and unseen.clearly_less(0, -1))) and not turned
    if not known and found.fit.hypothesis.added and not stands and not model.is_open:
        progress("judging with the constants of the model file")
        held = beside_constants_as_filed(found)
        beside = judge(held)
        stands = beside.betters or (not beside.worsens and _told_by_rows(found.fit))
        if stands and beside.moving[-1] < unseen.moving[-1]:
            found, unseen = freed(held, found), beside
    constants_alone = known and not found.fit.hypothesis.added and not model.is_open
    as_given = (not known and not stands) or (constants_alone and unseen.worsens)
    if as_given:  # An unknown cause, or errors at impacts, may pull every fitted number away from its true value.
        # constants that were unknown are better fitted than left at their guesses
        bare = settle(fit(found.problem, null)) if model.is_open else fit(found.problem, null, 0)
        found = found.ended(bare, "it does not improve the model given what remains unexplained")
        unseen = judge(found, as_given=not model.is_open)
    elif known:  # only after all is judged: these numbers are fitted to all recordings together
        found = with_followed_numbers(loop, found)
    as_given = as_given and not model.is_open
    best, problem = found.fit, found.problem
    unseen = unseen.shown(in_si(model))
    verdict = "unknown" if not known else "explained" if best.hypothesis.added else "none"
    rivals = tuple(rivalry.beside(best) for rivalry in rivals if rivalry.effect in best.hypothesis.effects)
    left = unseen.rmse[-1] / unseen.noise_floor if unseen.noise_floor > 0.0 else 1.0
    errors = with_division(errors_beside_curves(problem, best), best, left)
    errors |= {path: max(off, errors[path]) for path, off in uncertain.items() if path in errors}
    steps = steps_of(found, unseen)
    order = most_telling_first(best.hypothesis.added, steps)
    added = tuple(dict.fromkeys(best.hypothesis.added[name].effect for name in order))
    told = parameters(best, errors)
    better = native_as_given(restored(best.hypothesis.model(), read.awake), given)
    better = with_factor_in_the_constant(better, best.hypothesis.base, given).fitted_from(given)
    end = given if as_given else with_hidden_as_given(better, given, recordings)
    refitted = {} if as_given or not problem.size else constants(best, errors, given)
    compared = _left(read.given, end, noise)
    off = far_off(best)
    alone = of_wrong_constants(off, unseen.refit_removed, given.name) if verdict == "unknown" and not added else ()
    misread = (
        *read.doubts,
        *alone,
        *unusual_currents(read.given, given),
        *(off_by_one_factor(refitted, given) if model.is_open else ()),
    )
    return Discovery(
        verdict,
        added,
        end,
        steps,
        MappingProxyType({name: told[name] for name in order}),
        MappingProxyType(refitted),
        undecided(rivals),
        depends_on,
        partial(suggest, problem, found, rivals, recordings, excluded),
        why_ended(problem, verdict, found, depends_on, unseen, beyond_noise(*compared)),
        (
            *misread,
            *(warning for recording in recordings for warning in recording.warnings),
            *of_differing_zeros(read.zeros, model, end),
            *of_assumed_torque(read.given, given),
            *contradictions(problem, best),
            *(() if alone else far_off_in_words(off)),
            *of_straight_waves(problem, best),
            *(of_sums(problem, best, left) if refitted else ()),
            *(on_bounds(problem, best, errors) if problem.size else ()),
            *without_common_zero(recordings, best.hypothesis.model().active.values()),
            *((of_open_constants(),) if problem.size and model.is_open and known and best.hypothesis.added else ()),
            *(ONE_DIRECTION if problem.size and moves_one_way(problem) else ()),
            *(ALONE if len(recordings) == 1 else ()),
            *(() if problem.size else WITHOUT_TORQUE),
            *of_unseen_load(best, uncertain),
            *own_not_shown(recordings, model, without),
            *(own_on_bounds(_gaining(found), added) if not known else ()),
        ),
        unseen,
        found,
        problem,
        rivals,
        tuple(read.rotary),
        tuple(read.given),
        noise,
        *compared,
        "" if known else left_over_words(problem, found, depends_on),
        misread,
    )


def _gaining(found: Search) -> list[Fit]:
    """The fits that a search tried and that gained something, the best of each round first."""
    return [trial.fit for turn in found.rounds for trial in turn.tried if trial.gain > 0.0]


def excluded_effects(recordings: Sequence[Recording], model: Model, without: Sequence[str]) -> frozenset[str]:
    """Effects not searched for: those in ``without``, and those that the recordings or the machine cannot show."""
    return frozenset(without) | _impossible(model) | not_shown(recordings, model)


def _impossible(model: Model) -> frozenset[str]:
    """Effects that a machine of this kind cannot have: a carriage has no revolutions and no eccentric encoder.

    Magnets and screws repeat along its way all the same. With a gear ratio of 1 there are no teeth with an order of
    their own.
    """
    if not is_linear(model):
        return effects_with(Trait.OF_TEETH) if model.value("machine.gear_ratio") == 1.0 else frozenset()
    turning = {id for id, effect in catalogue().items() if effect.depends_on == "order"}
    return effects_with(Trait.OF_OUTPUT_TURNS) | (turning - effects_with(Trait.MOTOR_WAVE))


def _searched(
    problem: EquationErrorProblem, null: Hypothesis, excluded: frozenset[str], progress: Callable[[str], None]
) -> tuple[Search, bool]:
    """Best explanation by effects of the catalogue, refined where needed, and whether it explains the recordings."""
    found = search(problem, null, excluded, progress)
    if null.base.is_open:
        found = without_warming_that_wandering_explains(found)
        return found, explained(found.problem, found.fit, found.rounds[0].before)
    if len(found.fit.hypothesis.added) >= MOST_EFFECTS:  # if it takes that many effects, the cause is something else
        return found, False
    found = less_what_wandering_explains(in_another_order(found, excluded, progress), progress)
    found = less_what_one_recording_leaves_open(found, progress)
    start, wander = found.rounds[0].before, found.problem.weighting.wander
    if explained(found.problem, found.fit, start):
        return found, wander is None or _explained_without_wander(found.fit, start)
    if wander is not None:
        return found, False
    return wandering_after_all(found, excluded, start, progress) or found, False


def _explained_without_wander(f: Fit, start: Fit) -> bool:
    """Whether the end of a search also explains the recordings without wandering friction, by sensor noise alone."""
    plain = f.problem.under(replace(f.problem.weighting, wander=None))
    f = settle(fit(plain, f.hypothesis))
    return explained(f.problem, f, start)


def _told_by_rows(f: Fit) -> bool:
    """Whether rows that the effects were not fitted to confirm them; False with backlash or compliance in the model."""
    return not f.parted and len(f.problem.observations) > 1 and gain_where_unseen(f) > DEPENDS


def _leaves_torque(unseen: Unseen, torque: float) -> bool:
    """Whether more than a small share of the power of the drive's rms ``torque`` [N m] is unexplained, beyond noise.

    With open constants a search explains rows that average many samples, and may leave everything that is faster. Real
    machines with right models leave up to 3 %.
    """
    left = unseen.rmse[-1] ** 2 - unseen.noise_floor**2
    return unseen.signal == "unexplained_torque" and left > SMALL * torque**2


def _left(recordings: Sequence[Recording], model: Model, noise: NoiseFloor) -> tuple[str, Signals]:
    """(input, errors) of a twin compared with recordings; empty if its motion cannot be followed."""
    try:
        return overall_errors(recordings, model, noise)
    except InputError:
        return "", {}
