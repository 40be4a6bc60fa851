"""What a search found, in plain words."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..comparison.beyond_noise import is_noise, times_words, told_share
from ..criteria import CLEARLY_MORE, MOSTLY, NOISY, SUREST
from ..effects import catalogue
from ..effects.effect import OUTPUT_TORQUE
from ..listing import listed
from ..model import Model
from ..model.model import ORDER_ERROR
from ..model.own_units import is_linear
from ..quantities import MOST_TIMES, limited_factor, quantity, signal_words

if TYPE_CHECKING:
    from ..comparison.running_comparison import SignalError
    from ..discovery.discover import Discovery
    from ..discovery.steps import Step
    from ..discovery.unseen import Unseen
    from .findings import Findings, UnseenErrors
    from .fit_findings import FitFindings

LARGER = "larger error"
NO_RUNNER_UP = "no close runner-up"
YOURS = "Your model"
REFIT = "constants refitted"
REFIT_IS = "the constants of the given model refitted, no effect added"
FAR_OFF = "its start values are far off"
"""Said in place of an error that is only that of a draft."""
_NOTHING = 0.0005  # relative change; a smaller one is not shown
_MANY_TIMES = 3.0  # from which on a change is told as a factor
_WHOLE = 0.02  # cycles per turn; an order this near to a whole number counts as whole
_NAMES = {"stribeck": "Stribeck", "coulomb": "Coulomb"}
_DEPENDENCES = {
    "speed": "the speed",
    "direction": "the direction of motion",
    "output_position": "the output's position",
    "motor_position": "the motor's position",
    "time": "time",
    "order": "the motor's angle, repeating with its turns",
    "load": "the load",
    "acceleration": "the acceleration",
    "encoders": "the difference between the encoders",
}


def effect_words(id: str) -> str:
    """An effect's id, or an instance's name, in words: ``stribeck_friction`` becomes ``Stribeck friction``.

    A generic dependence on a quantity, which is no effect, has an id such as ``speed#3``.
    """
    dependence, basis, _ = id.partition("#")
    if basis:
        return f"any dependence on {_DEPENDENCES.get(dependence, dependence)}"
    return " ".join(_NAMES.get(word, word) for word in id.split("_"))


def by_number(name: str) -> list[tuple[str, float]]:
    """A key that sorts names as people count: ``ramp_2`` before ``ramp_10``, ``ramp_0.09`` before ``ramp_0.1``."""
    return [(text, float(number or 0.0)) for text, number in re.findall(r"(\D*)(\d+(?:\.\d+)?)?", name)]


def dependence_words(depends_on: Iterable[str]) -> str:
    """``the speed and time``."""
    return listed(_DEPENDENCES.get(quantity, quantity) for quantity in depends_on)


def removed_words(share: float | None, before: float = 0.0, after: float = 0.0) -> str:
    """The share of an error that was removed: ``99.9 %``; 100 % only if all of it was. A dash if there was no error.

    ``LARGER`` if the RMSE grew from ``before`` to ``after``.
    """
    if share is None:
        return "–"
    if after > (1.0 + _NOTHING) * before:
        return LARGER
    told = told_share(share)
    return "over 99.9 %" if 1.0 - _NOTHING <= told < 1.0 else f"{100.0 * told:.1f} %"


def larger_sentence(steps: Iterable[Step], unseen: Unseen | UnseenErrors | None = None) -> str:
    """A sentence on why an effect was added although the simulated error grew in its step; empty if none was."""
    if not any(s.action == "add" and s.rmse_after > (1.0 + _NOTHING) * s.rmse_before for s in steps):
        return ""
    settled = () if unseen is None or unseen.settled == unseen.rmse else unseen.settled
    if unseen is not None and settled and CLEARLY_MORE * settled[-1] < settled[0]:
        before, after = (quantity(value, unseen.unit) for value in (settled[0], settled[-1]))
        return (
            f"{LARGER.capitalize()}: over all samples, standstill included. In motion the steps together brought the "
            f"error from {before} to {after}."
        )
    return (
        f"{LARGER.capitalize()}: a step takes the effect that best explains the torque (or the encoders' difference) "
        "of the measured motion, not the one that most reduces this simulated error, which may fall only after a later "
        "step."
    )


def left_sentence(unseen: Unseen | UnseenErrors) -> str:
    """A sentence on the error after the last step, in times the sensors' noise; empty if it is within the noise."""
    floor = unseen.noise_floor
    if not floor > 0.0 or unseen.rmse[-1] <= NOISY * floor:
        return ""
    error = f"the error of the {signal_words(unseen.signal, unseen.unit)}"
    if not math.isfinite(unseen.rmse[-1]):
        return f"After the last step {error} is not known: the simulation of a recording ends with these numbers."
    left = f"After the last step {error} is still {times_words(unseen.rmse[-1] / floor)} the sensors' noise"
    if not unseen.settled or unseen.settled[-1] ** 2 > (1.0 - MOSTLY) * unseen.rmse[-1] ** 2:
        return f"{left}."
    within = unseen.settled[-1] <= NOISY * floor
    moving = "within the noise" if within else f"{times_words(unseen.settled[-1] / floor)} the noise"
    return f"{left}; in motion it is {moving}. At standstill, friction holds any torque below its level."


def surest_sentence() -> str:
    """A sentence that says why no probability is given above ``SUREST``."""
    return (
        f"Probabilities are capped at {100.0 * SUREST:.0f} %: in tests with a known missing effect, that share of such "
        "answers was right."
    )


def refit_sentence(unseen: Unseen | UnseenErrors, model: str = YOURS) -> str:
    """A sentence on what fitting the model's own constants, without any effect, did to its error; empty if nothing."""
    if unseen.given is None or unseen.given == unseen.rmse[0]:
        return ""
    before, after = quantity(unseen.given, unseen.unit), quantity(unseen.rmse[0], unseen.unit)
    whose = f"{model[:1].lower()}{model[1:]}" if model == YOURS else model
    error = f"the error of the {signal_words(unseen.signal, unseen.unit)}"
    if unseen.given > MOST_TIMES * unseen.rmse[0]:
        return f"Fitting the constants of {whose} alone brings {error} to {after}; {FAR_OFF} (over 1000 times that)."
    does = f"leaves {error} at {after}" if before == after else f"changes {error} from {before} to {after}"
    return f"Fitting the constants of {whose} alone {does}."


def draft_words(given: float, refitted: float, unit: str) -> str:
    """The error of a model as it was given; if that is over 1000 times the refitted one, only that it is a draft's."""
    return "of start values" if given > MOST_TIMES * refitted else quantity(given, unit)


def fit_sentences(
    found: Mapping[str, SignalError],
    fitted: Mapping[str, SignalError],
    signals: Sequence[str],
    fit: FitFindings | None = None,
) -> str:
    """Sentences on what fitting the found model's numbers did to its errors, and whether that holds on other data.

    ``signals`` are those by which models are judged; ``fit`` has the errors on data that was not fitted to.
    """
    telling = [name for name in signals if not (is_noise(found[name]) and is_noise(fitted[name]))]
    if not telling:
        return "Fitting the found model's numbers to the simulated loop leaves it at the sensors' noise."
    moved, left = [], []
    for name in telling:
        before, after = (quantity(errors[name]["rmse"], errors[name]["unit"]) for errors in (found, fitted))
        whose = f"that of the {signal_words(name, found[name]['unit'])}"
        if before == after:
            left.append(f"{whose} at {after}")
        else:
            moved.append(f"{whose} from {before} to {after}")
    does = listed(f"{verb} {listed(each)}" for verb, each in (("takes", moved), ("leaves", left)) if each)
    said = f"Fitting the found model's numbers to the simulated loop {does.replace('that', 'the error', 1)}."
    worst = max(telling, key=lambda name: fitted[name]["rmse"] / max(fitted[name]["noise_floor"], 1e-300))
    if fit is None or worst not in fit.after:
        return said
    before, after = (quantity(values[worst], fitted[worst]["unit"]) for values in (fit.before, fit.after))
    gain = ""
    if fit.after[worst] >= fit.before[worst]:
        gain = "; fitting brings no gain there: keep the found model"
    which = "that error" if len(telling) == 1 else f"the error of the {signal_words(worst, fitted[worst]['unit'])}"
    beside = f"the found model, which was fitted to all recordings, has {before} there"
    return f"{said} On data not used for the fit ({fit.judged_on}), {which} is {after}; {beside}{gain}."


def beyond_words(beyond: Mapping[str, float], unit: str = "") -> str:
    """``the speed's error is 6.0 times the sensors' noise and the current's 1.3 times``; empty without signals.

    Of a signal whose noise is zero, that it is unknown. ``unit`` is that of the torque: a carriage has a force.
    """
    each = [(f"the {signal_words(name, unit)}'s", times_words(t)) for name, t in beyond.items() if math.isfinite(t)]
    said = [
        f"{whose} {times}" if k else f"{whose} error is {times} the sensors' noise"
        for k, (whose, times) in enumerate(each)
    ]
    unknown = [signal_words(name, unit) for name, times in beyond.items() if math.isinf(times)]
    if unknown:
        said.append(f"the noise of the {listed(unknown)} is not known, so nothing says how large an error may be")
    return listed(said)


def verdict_of(found: Discovery | Findings, model: str = YOURS, without: Sequence[str] = ()) -> str:
    """A sentence on what the recordings say about a model; ``without`` are effects that were not looked for."""
    named = listed(_or_its_likes(effect, found) for effect in found.added) if found.added else ""
    lacks = f"{model} lacks {named}" if named else ""
    if found.verdict == "none":
        of = "" if model == YOURS else f" in {model}"
        if found.beyond_noise:
            unit = found.unseen.unit if found.unseen is not None else ""
            return f"These recordings show no missing effect{of}, but {beyond_words(found.beyond_noise, unit)}."
        return f"These recordings show nothing missing{of}."
    if found.verdict == "explained":
        return f"{lacks}."
    along = f": {found.left_over}" if found.left_over else ""
    start, error = (
        (f"{lacks}. A further error remains", "it") if lacks else ("Something is missing", "the remaining error")
    )
    left = f"; {error} depends on {dependence_words(found.depends_on)}{along}" if found.depends_on else ""
    explains = "no effect of the catalogue explains"
    if without:
        explains = f"no effect explains, except possibly {listed(map(effect_words, without), 'or')} (excluded)"
    return f"{start} that {explains}{left}."


def no_effect_words(beyond: Mapping[str, float]) -> str:
    """Label of the probability that no effect is missing: ``nothing``, or ``no effect`` if some error is left."""
    return "no effect" if beyond else "nothing"


NOT_IN_CATALOGUE = "an effect not in the catalogue"
"""Label of the rest of the probability."""


def _or_its_likes(effect: str, found: Discovery | Findings) -> str:
    """``Stribeck friction (or quadratic drag)`` if the recordings cannot tell which of them it is."""
    likes = dict.fromkeys(
        other for group in found.groups if effect in group for other in group if other not in found.added
    )
    named = _with_side(effect, found.parameters or {})
    return f"{named} (or {listed(map(effect_words, likes), 'or')})" if likes else named


def _with_side(effect: str, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """An added effect in words, with the sides on which it was added if the model has it elsewhere, or may.

    ``parameters`` are those of the added effects by their instances' names: ``viscous_friction_2`` is a second one. The
    output's side is always told, since a model's first friction is the motor's.
    """
    added = {
        name: entry["options"]["side"]
        for name, entry in parameters.items()
        if entry["effect"] == effect and "side" in entry["options"]
    }
    sides = [f"the {side}'s" for side in dict.fromkeys(added.values())]
    told = any(name != effect or side == "output" for name, side in added.items())
    if not told:
        return effect_words(effect)
    return f"{effect_words(effect)} on {listed(sides)} side"


def options_words(options: Mapping[str, str]) -> str:
    """``order 24, kind dissipative``."""
    return ", ".join(f"{name} {choice}" for name, choice in options.items())


def order_sentences(model: Model, names: Iterable[str]) -> list[str]:
    """Sentences on the machine parts that repeat at the effects' orders; if the model names none, what they may be."""
    told = []
    unnamed: dict[tuple[str, str], list[str]] = {}
    for name in names:
        order = model.effects[name].options.get("order") if name in model.effects else None
        if order is None or catalogue()[model.effects[name].effect].depends_on == "encoders":
            continue  # an encoder's own error does not come from the drive train
        if is_linear(model):
            told.append(f"{effect_words(name)}: repeats every {quantity(1.0 / float(order), 'm')} of the way.")
            continue
        cycles = model.motor_order(name)
        shaft = "motor" if float(order) == cycles else "output"
        within = ORDER_ERROR * cycles / float(order)  # the tolerance is in orders of the effect's own shaft
        if parts := model.order_names(cycles, within):
            told.append(f"{effect_words(name)}: order {order} of the {shaft} matches {', or '.join(parts)}.")
        else:
            unnamed.setdefault((shaft, _what_repeats(shaft, cycles)), []).append(order)
    said = "names no part with this order" if model.orders else "names no orders (`orders:` in its file)"
    for (shaft, what), orders in unnamed.items():
        both = ", and so of the output" if shaft == "motor" and model.is_direct else ""
        times = listed(orders)
        told.append(f"Repeats {times} times per turn of the {shaft}{both}, possibly from {what}; the model {said}.")
    return told


def _what_repeats(shaft: str, cycles: float) -> str:
    """What may repeat at this order: parts fixed to the shaft, or parts that turn at another speed."""
    if shaft == "output":
        return "the teeth of the last gear, a bearing or a joint of the output"
    if abs(cycles - round(cycles)) < _WHOLE:
        return "its teeth, magnets or windings"
    return "gears, belts or bearings"


def output_sentence(model: Model, names: Iterable[str]) -> str:
    """A sentence on the effects behind a gear whose torques are given at the motor's shaft; empty if there are none.

    ``names`` are instances of a model, or others, which do not count.
    """
    there = [name for name in names if name in model.effects and _has_output_torque(model, name)]
    if not there or model.is_direct:
        return ""
    what = "force" if model.motion == "linear" else "torque"
    named = listed(map(effect_words, there))
    return (
        f"Values of effects that act on the output ({named}) are given at the motor; a {what} at the output is "
        f"{model.value('machine.gear_ratio'):.4g} times as large."
    )


def _has_output_torque(model: Model, name: str) -> bool:
    """Whether an instance acts on the output with a parameter that is a torque."""
    instance = model.effects[name]
    effect = catalogue()[instance.effect]
    on_output = effect.where(instance.options) == OUTPUT_TORQUE or instance.options.get("side") == "output"
    return on_output and any(parameter.unit == "N m" for parameter in effect.parameters)


def groups_sentence(groups: Sequence[Sequence[str]]) -> str:
    """A sentence on the effects that cannot be told apart; empty if there are none."""
    if not groups:
        return ""
    apart = "; ".join(listed(map(effect_words, group), "or") for group in groups)
    return f"These recordings cannot tell apart: {apart}."


def input_words(source: str, signals: Iterable[str], motion: str = "rotary") -> str:
    """What drives a twin: of a machine whose torque or force was recorded (one of the ``signals``), that.

    Inside, it is a current of one ampere per newton metre, and the input is called ``current``.
    """
    if source != "current" or "motor_torque" not in signals:
        return source
    return "force" if motion == "linear" else "torque"


def why_step(step: Step) -> str:
    """The runner-up of an effect that was added, or the reason why one was dropped."""
    return _runner_up(step) if step.action == "add" else step.reason


def _runner_up(step: Step) -> str:
    """The best of the others tried in this step, and its gain as a share of the step's."""
    tried: Sequence[Mapping[str, Any]] = step.tried
    took = next((trial for trial in tried if step.instance in trial["names"]), None)
    other = next((trial for trial in tried if step.instance not in trial["names"]), None)
    if took is None or other is None:
        return NO_RUNNER_UP
    name = listed(map(effect_words, other["names"]))
    share = other["gain"] / took["gain"]
    if share <= 0.0:
        return f"{name}, too small a gain for its parameters"
    if share >= 0.995:
        return f"{name}, as much gain as the step's"
    return f"{name}, {f'{100.0 * share:.0f} %' if share >= 0.01 else 'less than 1 %'} of the step's gain"


def change_words(held: Mapping[str, Any]) -> str:
    """By how much a refitted constant moved: ``+0.4 %``; from a start value ``× 131`` or ``× over 1000``.

    Empty if it was zero.
    """
    if not held["nominal"]:
        return ""
    ratio = held["value"] / held["nominal"]
    if _MANY_TIMES >= ratio >= 1.0 / _MANY_TIMES or ratio <= 0.0:
        return f"{100.0 * (ratio - 1.0):+.1f} %"
    return f"× {limited_factor(ratio, '.0f' if ratio >= 100.0 else '.3g')}"


def has_moved(held: Mapping[str, Any]) -> bool:
    """Whether a refitted constant moved visibly, and by more than its standard error."""
    distance = abs(held["value"] - held["nominal"])
    return bool(distance > (held["std"] or 0.0)) and is_visible(held["nominal"], held["value"])


def is_visible(before: float, after: float) -> bool:
    """Whether a change is one that is not printed as 0.0 %."""
    return abs(after - before) > _NOTHING * abs(before)
