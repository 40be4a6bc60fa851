"""Removing: uncertain effects are removed, and what they had replaced may be added again."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...criteria import DEPENDS, MOSTLY, RIVAL_MARGIN, SMALL, TOO_MUCH
from ...effects import Trait, catalogue, effects_with
from ...identification.fit import Fit, fit
from ...model.roles import SPRING
from ..criteria.own_shape import is_play, only_teeth
from ..criteria.plausible import insignificant, uncertain
from ..criteria.worth import ENCODER_ONLY, penalised_gain, standing_on
from .adding import add_effects, less_each, prune, settle, without_effect
from .rivals import came_near, swapped
from .trace import BEATEN, NEEDLESS, SURER, SWAPS, UNCERTAIN, WANDERS, Round, Search


def significant(found: Search) -> Search:
    """Remove uncertain effects, and try again what was removed for their sake.

    An effect that explains much may be uncertain only in the presence of another whose removal costs little: friction
    that thins from standstill on takes the place of viscous friction. Then the other one is removed. What stands on an
    uncertain dry friction is removed before it. Or an effect is uncertain by its own shape: backlash of almost no
    width, whose teeth wind up like the shaft that it replaces.
    """
    found = _shaft_for_teeth(found)
    while name := insignificant(found.problem, found.fit):
        if above := standing_on(found.fit.hypothesis, name):
            found = with_what_made_room(less(found, above, UNCERTAIN))
            continue
        names = [*found.fit.hypothesis.added]
        less_one = dict(zip(names, less_each(found.fit, names), strict=True))
        lost = {n: -penalised_gain(found.fit, g) for n, g in less_one.items()}
        if lost[name] > DEPENDS:
            if (instead := _sure_instead(found, name)) is not None:
                return significant(instead)
            little = max(DEPENDS, SMALL * lost[name])
            others = [
                n
                for n in sorted(lost, key=lost.__getitem__)
                if lost[n] <= little and not standing_on(found.fit.hypothesis, n)
            ]
            name = next((n for n in others if name not in uncertain(found.problem, less_one[n])), name)
        found = with_what_made_room(less(found, [name], UNCERTAIN))
    return found


def _shaft_for_teeth(found: Search) -> Search:
    """The search with a compliant shaft in the place of backlash whose teeth do what a shaft does: they wind up.

    Of backlash that is hardly wider than the encoders' noise, if its teeth explain as much without that width and a
    shaft about as much. Of any other, if a shaft was close in its round and explains more beside what came since.
    """
    f, problem = found.fit, found.problem
    for name in f.hypothesis.added:
        if not is_play(f, name):
            continue
        instance, turn = f.hypothesis.instance(name), next((turn for turn in found.taken if name in turn.added), None)
        noise = [
            float(np.median(problem.noise_of_encoders(part)))
            for part in problem.encoder_parts
            if part.stop > part.start
        ]
        width = instance.parameters[catalogue()[instance.effect].parameters[0].name]
        narrow = bool(noise) and width <= TOO_MUCH * max(noise)
        near = None if turn is None or narrow else _shaft_close_to(turn)
        if turn is None or not noise or (near is None and not (narrow and only_teeth(problem, f, name))):
            continue
        tried = {id for turn in found.rounds for trial in turn.tried for id in trial.fit.hypothesis.effects}
        if SPRING not in tried:  # it may not be named
            continue
        start = near or {key: f.hypothesis.by_path[f"contact.{key}"] for key in ("stiffness", "damping")}
        shaft = fit(problem, f.hypothesis.without(name).with_effect(SPRING, {}, start))
        bare = fit(problem, f.hypothesis.without(name))
        if penalised_gain(bare, shaft) >= (MOSTLY if narrow else 1.0) * max(penalised_gain(bare, f), 0.0):
            instead = swapped(found, shaft, SURER if narrow else BEATEN)
            if SPRING in instead.fit.hypothesis.effects:
                return instead
    return found


def _shaft_close_to(turn: Round) -> Mapping[str, float] | None:
    """Stiffness and damping of the compliant shaft that gained most of what a round took; None if none did."""
    took = max((trial.gain for trial in turn.tried if trial.names == turn.added), default=math.inf)
    for trial in turn.tried:
        came = [trial.fit.hypothesis.added.get(name) for name in trial.names]
        if trial.gain >= MOSTLY * took and [held.effect for held in came if held] == [SPRING]:
            return trial.fit.hypothesis.instance(trial.names[0]).parameters
    return None


def _sure_instead(found: Search, name: str) -> Search | None:
    """The search with an uncertain effect replaced by one that was as good in its round and is certain; or None."""
    turn = next((turn for turn in found.taken if name in turn.added), None)
    alone = None if turn is None else next((trial for trial in turn.tried if trial.names == (name,)), None)
    if turn is None or alone is None:
        return None
    for other, h in came_near(found.fit.hypothesis, name, turn, alone.gain - RIVAL_MARGIN):
        instead = swapped(found, fit(found.problem, h), SURER)
        if other in instead.fit.hypothesis.effects and not insignificant(instead.problem, instead.fit):
            return instead
    return None


def with_what_made_room(found: Search) -> Search:
    """Try again what was needless in the presence of something that is no longer there.

    Also an encoder's own error, if the removed effect was added in its place; and if backlash or compliance is gone,
    what wandering friction explained there, and what resembles a gearbox in the torque and gained there: the search by
    torque alone left it out. What was removed for a reason of its own is not tried again.
    """
    reasons = {NEEDLESS} if found.fit.parted else {NEEDLESS, WANDERS}  # WANDERS is for backlash and compliance only
    once = {turn.effect_of(gone) for turn in found.rounds if turn.reason in reasons for gone in turn.removed}
    held = {*found.fit.hypothesis.added}
    for turn in found.taken:
        if held.isdisjoint(turn.added):
            once |= ENCODER_ONLY & _gained(turn)
    for turn in found.rounds:
        if turn.before.parted and not found.fit.parted:
            once |= effects_with(Trait.LIKE_PLAY_OR_SPRING) & _gained(turn)
    for turn in found.rounds:
        if turn.reason not in reasons:
            went = turn.before.hypothesis.added
            once -= {went[name].effect for name in turn.removed if name in went}
    back = (once & catalogue().keys()) - {*found.fit.hypothesis.effects}
    if not back:
        return found
    return found.further(*add_effects(found.fit, frozenset(catalogue()) - back, most=len(back)))


def _gained(turn: Round) -> set[str]:
    """Effects that were tried in a round and paid their complexity penalty."""
    return {effect for trial in turn.tried if trial.gain > 0.0 for effect in trial.fit.hypothesis.effects}


def less(found: Search, names: Sequence[str], reason: str) -> Search:
    """The search with one more round, in which effects and what is needless without them were removed.

    If they had replaced others as better or simpler rivals, the end is the one before that swap.
    """
    if not names:
        return found
    if (before := _before_swap(found, names)) is not None:
        return found.ended(before, reason)
    h = found.fit.hypothesis
    for gone in dict.fromkeys(each for name in names for each in (name, *standing_on(h, name))):
        h = without_effect(h, gone)
    return found.ended(prune(settle(fit(found.problem, h))), reason)


def _before_swap(found: Search, names: Sequence[str]) -> Fit | None:
    """The end before effects of these ``names`` replaced others; None if more has been removed since."""
    last = next((turn for turn in reversed(found.changes) if turn.reason != NEEDLESS), None)
    # what a surer effect replaced was too uncertain to come back
    if last is None or last.reason not in SWAPS - {SURER} or not {*names} <= {*last.added}:
        return None
    if last.before.problem.weighting.wander is found.problem.weighting.wander:
        return last.before
    return settle(fit(found.problem, last.before.hypothesis))  # wandering friction was found since
