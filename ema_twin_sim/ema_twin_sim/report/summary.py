"""The head of a report: what was wrong, how sure that is, what is left, and a table of the errors."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..comparison.beyond_noise import is_noise, times_noise, times_words
from ..comparison.running_comparison import SignalError, excess_removed
from ..criteria import NOISY
from ..effects import catalogue
from ..listing import few_of, listed, number_of
from ..quantities import MOST_TIMES, limited_factor, quantity, signal_words
from ..words.findings import Findings, UnseenErrors
from ..words.sentences import (
    NO_RUNNER_UP,
    NOT_IN_CATALOGUE,
    effect_words,
    fit_sentences,
    groups_sentence,
    input_words,
    no_effect_words,
    refit_sentence,
    removed_words,
    verdict_of,
    why_step,
)
from ..words.setpoint_shift import shift_sentence
from .backwards import backwards, searched_model
from .content import Content, Shown, dates
from .difference import NewEffect
from .markup import Markup, capitalised, items, joined, table, tag

WITHIN = 0.5
"""Ratio of an error to the sensors' noise below which only the noise is told."""


def verdict(content: Content) -> str:
    """What the earlier model lacks, in one plain sentence."""
    if said := backwards(content):
        return said
    before, after = content.names[:2]
    if content.findings is not None and _agrees(content):
        return verdict_of(content.findings, before)
    if not content.new:
        return f"{after} has no effect that {before} lacks."
    return f"{before} lacks {listed(effect_words(effect.name) for effect in content.new)}, which {after} has."


def misread(content: Content) -> list[str]:
    """What is plainly wrong with the recordings or a model, such as a unit, by the comparisons and the search."""
    of_models = (text for each in content.given.comparisons for text in each.misread)
    return [*dict.fromkeys((*of_models, *(content.findings.misread if content.findings else ())))]


def head(content: Content) -> Markup:
    """The head of the page."""
    story = [tag("p", content.story)] if content.story else []
    cards = (
        _card("What was wrong", *_wrong(content)),
        _card("How sure that is", *_sure(content)),
        _card(
            "Remaining error" if len(content.models) == 2 else "Remaining error with the effects found", *_left(content)
        ),
    )
    lead = tag("p", _lead(content), class_="lead")
    errors = error_table(content.given, content.labels)
    told = (f"Check this before you trust the page: {text}." for text in misread(content))
    doubts = [tag("p", text, class_="warning doubt") for text in told]
    notes = [tag("p", note, class_="aside") for note in (_called(content), content.note) if note]
    return tag(
        "header",
        tag("h1", verdict(content)),
        *doubts,
        lead,
        *story,
        tag("div", *cards, class_="cards"),
        errors,
        *notes,
        _about(content),
    )


def _called(content: Content) -> str:
    """A sentence with the label of each model, if labels are not their names."""
    if content.labels == content.names:
        return ""
    pairs = zip(content.names, content.labels, strict=True)
    return f"Names of the models: {', '.join(f'{name} ({label})' for name, label in pairs)}."


def _agrees(content: Content) -> bool:
    """Whether the later model has the effects that the search found."""
    if content.findings is None or content.gone:
        return False
    return {effect.effect for effect in content.new} == set(content.findings.added)


def _lead(content: Content) -> str:
    """Sentences on how the errors of the main signals changed; leads with those on recordings not used for fitting."""
    first, second = content.given.comparisons[:2]
    if not content.given.headlines:
        return "No signal in these recordings distinguishes the models."
    parts, unseen = [], _unseen(content)
    for name in content.given.headlines:
        before, after = first.overall[name], second.overall[name]
        began, ended = (quantity(error["rmse"], error["unit"]) for error in (before, after))
        way = "falls" if after["rmse"] < before["rmse"] else "does not decrease: it goes"
        sizes = f"stays at {ended}" if began == ended else f"{way} from {began} to {ended}"
        if before["rmse"] > MOST_TIMES * after["rmse"] > 0.0:  # a draft, or nothing left
            sizes = f"falls to {ended}, from over {MOST_TIMES:.0f} times that"
        parts.append(f"that of the {content.given.words(name)} {sizes} ({_noises(after)})")
    said = listed(parts).removeprefix("that of")
    findings = content.findings
    refit = refit_sentence(findings.unseen, searched_model(content)) if findings and findings.unseen else ""
    alone = f" {refit}"
    if refit and findings and findings.unseen and findings.added:
        lower = findings.unseen.rmse[-1] < findings.unseen.rmse[0]
        does = "account for the rest" if lower else "do not lower it: the steps show what they explain"
        alone = f" {refit} The effects found {does}."
    of = f"From {content.names[0]} to {content.names[1]}" if len(content.models) == 2 else "With the effects found"
    if unseen is None:
        return f"{of}, the error (RMSE) of{said}.{alone} {_fitted(content)}".strip()
    given = unseen.rmse[0] if unseen.given is None else unseen.given
    began = f"{quantity(given, unseen.unit)} before"
    if given > MOST_TIMES * unseen.rmse[-1]:  # a draft: what its constants alone achieve is the reference
        began = f"{quantity(unseen.rmse[0], unseen.unit)} with the constants alone refitted"
    changes = f"{began}, {quantity(unseen.rmse[-1], unseen.unit)} with the effects found"
    words = signal_words(unseen.signal, unseen.unit)
    judged = f"On recordings not used for fitting, the error (RMSE) of the {words} is {changes}."
    of = f"{of[:1].lower()}{of[1:]}"
    fitted = f"On all recordings, with numbers fitted to all of them: {of}, the error of{said}."
    return f"{judged}{alone} {fitted} {_fitted(content)}".strip()


def _unseen(content: Content) -> UnseenErrors | None:
    """The errors on recordings not used for fitting, if the search found the later model with these recordings."""
    findings = content.findings
    unseen = findings.unseen if findings is not None else None
    if unseen is None or len(unseen.recordings) < 2 or unseen.signal not in content.given.headlines:
        return None
    searched = {name for name, _ in unseen.recordings} == {recording.name for recording in content.given.recordings}
    return unseen if searched and content.new and _agrees(content) and math.isfinite(unseen.rmse[-1]) else None


def _fitted(content: Content) -> str:
    """Sentences on what fitting the second model's numbers did; empty if there is no third model."""
    if len(content.models) == 2:
        return ""
    found, fitted = (comparison.overall for comparison in content.given.comparisons[1:])
    return fit_sentences(found, fitted, content.given.headlines, content.fit)


def _noises(error: SignalError) -> str:
    floor = quantity(error["noise_floor"], error["unit"])
    if is_noise(error):
        return f"that is the sensors' noise, {floor}"
    return f"the sensors' noise is {floor}"


def _card(title: str, *content: str) -> Markup:
    return tag("section", tag("h2", title), *content, class_="card")


def _wrong(content: Content) -> list[Markup]:
    new, gone = content.new, content.gone
    if not new and not gone:
        return [tag("p", "Both models have the same effects; only their numbers differ, as listed below.")]
    left_out = [tag("p", f"{content.names[1]} lacks:"), items(*map(_described, gone))] if gone else []
    if not new:
        return left_out
    told = any(held["std"] is not None for effect in new for held in effect.parameters.values())
    note = "± is one standard error."
    if not told:
        asked = content.findings is not None and content.findings.added
        note = "The model file holds no standard errors" + (": see what the search found." if asked else ".")
    return [items(*map(_described, new)), tag("p", note, class_="aside"), *left_out]


def _described(effect: NewEffect) -> Markup:
    """An effect's name, its numbers, and what it is."""
    summary = catalogue()[effect.effect].summary
    parts = (f": {effect.sizes or 'no numbers'}. ", tag("span", f"{capitalised(summary)}.", class_="aside"))
    return joined([tag("strong", effect_words(effect.name)), *parts])


def _sure(content: Content) -> list[Markup]:
    findings = content.findings
    if findings is None:
        return [tag("p", content.undiagnosed or "Not assessed: no search was made.")]
    lines = []
    if not _agrees(content):
        said = verdict_of(findings, searched_model(content))
        lines.append(f"A search on these recordings gives a different result from {content.names[1]}: {said}")
    if findings.ranking:
        lines.append(_probabilities(findings))
    runners: dict[str, str] = {}
    for step in findings.steps:
        if step.action == "add":
            runners[step.instance] = why_step(step)
        else:
            runners.pop(step.instance, None)  # dropped again: its rivals no longer matter
    lines += [f"Runner-up to {effect_words(name)}: {why}." for name, why in runners.items() if why != NO_RUNNER_UP]
    if unrivalled := [effect_words(name) for name, why in runners.items() if why == NO_RUNNER_UP]:
        lines.append(f"No other effect came close to {listed(unrivalled)}.")
    if findings.groups:
        lines.append(groups_sentence(findings.groups))
    elif findings.verdict == "explained":
        lines.append("No other effect of the catalogue explains these recordings as well.")
    if findings.unseen is not None and len(findings.unseen.recordings) > 1:
        lines.append("The effects were judged on recordings that were not used for fitting.")
    names = [recording.name for recording in content.given.recordings]
    for said, result in (("search", findings), ("fit", content.fit)):
        if result is not None and result.origin is not None and result.origin.differs(names):
            lines.append(f"{result.origin.sentence(said)} Those of this page are {few_of(names)}.")
    return [items(*lines)]


def _probabilities(findings: Findings) -> str:
    found = [entry for entry in findings.ranking if entry.found]
    none, unknown = (100.0 * (share or 0.0) for share in (findings.none, findings.unknown))
    rest = f"{no_effect_words(findings.beyond_noise)} missing: {none:.0f} %, {NOT_IN_CATALOGUE}: {unknown:.0f} %"
    if not found:
        return f"Probabilities: {rest}."
    each = listed(f"{effect_words(entry.effect)} {100.0 * entry.probability:.0f} %" for entry in found)
    return f"Probability of each: {each}; {rest}."


def _left(content: Content) -> list[Markup]:
    second, unseen = content.given.comparisons[1], _unseen(content)
    lines = []
    for name in content.given.headlines:
        error = second.overall[name]
        rmse = quantity(error["rmse"], error["unit"])
        where = next((found.sentence() for found in second.where if found.signal == name), "")
        if name == "output_position":
            where = f"{where} {shift_sentence(second)}".strip()
        noise = "the sensors' noise"
        if not is_noise(error):
            noise = f"{times_words(times_noise(error))} {noise}"
        if unseen is not None and name == unseen.signal:
            apart = quantity(unseen.rmse[-1], unseen.unit)
            if unseen.noise_floor > 0.0 and unseen.rmse[-1] > NOISY * unseen.noise_floor:
                apart += f", {times_words(unseen.rmse[-1] / unseen.noise_floor)} the sensors' noise"
            rmse = f"{apart} on recordings not used for fitting; with numbers fitted to all recordings {rmse}"
        said = f"{capitalised(content.given.words(name))}: {rmse}, {noise}."
        lines.append(said if is_noise(error) else f"{said} {where}".strip())
    findings = content.findings
    if findings is not None and findings.stopped:
        lines.append(f"The search ended: {findings.stopped}.")
    return [items(*lines)]


def error_table(
    given: Shown, names: Sequence[str], caption: str = "RMSE, measured minus twin, all recordings"
) -> Markup:
    """Table of all models' errors and the sensors' noise, one row per signal, with what each later model removes."""
    rows = []
    for name in given.signals:
        before, *others = (comparison.overall[name] for comparison in given.comparisons)
        shares = (_removed(before, after) for after in others)
        errors = map(_against_noise, (before, *others))
        rows.append((given.words(name), quantity(before["noise_floor"], before["unit"]), *errors, *shares))
    removed = "excess over noise removed"
    heads = [removed] if len(names) == 2 else [f"{removed}, {name}" for name in names[1:]]
    said = f"{caption}; in brackets, times the sensors' noise. Excess: the mean square above that of the noise."
    return table(("signal", "sensors' noise", *names, *heads), rows, caption=said)


def _removed(before: SignalError, after: SignalError) -> str:
    share = None if is_noise(before) and is_noise(after) else excess_removed(before, after)
    return removed_words(share, before["rmse"], after["rmse"])


def _against_noise(error: SignalError) -> Markup:
    """The RMSE, and its ratio to the noise; a ratio far below one says only that the noise covers the error."""
    ratio = times_noise(error)
    said = "within the noise" if ratio < WITHIN else f"{limited_factor(ratio, '.1f')}×"
    times = f" ({said})" if error["noise_floor"] else ""
    kind = "good" if is_noise(error) else "plain"
    return tag("span", f"{quantity(error['rmse'], error['unit'])}{times}", class_=kind)


def _about(content: Content) -> Markup:
    recordings = content.given.recordings
    seconds = sum(recording.duration for recording in recordings)
    count = number_of(len(recordings), "recording")
    long = f"{sum(map(len, recordings))} operating points" if recordings[0].of_points else f"{seconds:.1f} s"
    machine, first = content.models[0].machine, content.given.comparisons[0]
    source = input_words(first.input, first.overall, first.motion)
    told = f"{count}, {long}; recorded: {dates(recordings)}; machine: {machine}; input of the twins: {source}"
    return tag("p", f"{told}; ema-twin {content.version}.", class_="aside")
