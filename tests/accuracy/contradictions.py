"""Contradictions: all that is said of one case, by discover, diagnose, compare, fit and the report, told alike.

What is said is gathered as a reader has it: the terminal's lines, the page's words, and the JSON. ``contradictions``
names each statement that another one contradicts; there must be none.
"""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ema_bench_replay.recording import Recording
from ema_twin_sim.commands.output import console
from ema_twin_sim.commands.shown_comparison import show_comparison
from ema_twin_sim.commands.shown_diagnosis import show_diagnosis
from ema_twin_sim.commands.shown_fit import show_fit
from ema_twin_sim.commands.shown_search import show_search
from ema_twin_sim.comparison.beyond_noise import beyond_noise
from ema_twin_sim.comparison.compare import Comparison, compare, compare_all
from ema_twin_sim.discovery.diagnose import weigh
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.model import Model
from ema_twin_sim.report.content import Content, shown
from ema_twin_sim.report.page import page
from ema_twin_sim.words.findings import Findings, findings_of
from ema_twin_sim.words.sentences import effect_words, verdict_of

from .cases import Case
from .folders import readable_train

SAME = 1e-9  # relative: two tellings of one number
_UNFITTED: Mapping[str, Any] = {"rmse": {}}
_NOTHING = re.compile(
    r"nothing is missing(?! 0 %)|nothing missing: [1-9]|show nothing missing|nothing is left|nothing left"
    r"|all errors are within|at the sensors' noise floor",
    re.IGNORECASE,
)
_BEYOND = re.compile(r"(\d[\d.]*) times the (?:sensors' )?noise")
_SHARE = re.compile(r"(-?\d[\d.]*) %")
_NAMES = ("Before", "After")


@dataclass(frozen=True)
class Told:
    """What is said of one case: texts by who says them, JSON by verb, and the errors that ``compare`` shows."""

    texts: Mapping[str, str]
    content: Mapping[str, Any]
    comparisons: Sequence[Comparison]
    findings: Findings


def told_of(recordings: Sequence[Recording], model: Model, *, fitted: bool = False) -> Told:
    """All that is said of recordings beside a model; ``fitted``: with what ``fit`` says of the model that was found."""
    found = discover(recordings, model)
    diagnosis = weigh(found)
    texts = {
        "discover": _printed(lambda: show_search(found)),
        "diagnose": _printed(lambda: show_diagnosis(diagnosis)),
    }
    models = (model, found.model)
    comparisons = compare_all(recordings, models)
    alone = [compare(recordings, model), compare(recordings, found.model)]
    findings = findings_of(found, diagnosis)
    both = shown(recordings, models, comparisons=comparisons)
    written = page(Content(models, _NAMES, both, None, findings, ""))
    texts["compare"] = _printed(lambda: show_comparison(comparisons, _NAMES))
    for name, one in zip(_NAMES, alone, strict=True):
        texts[f"compare {name}"] = _printed(lambda one=one: show_comparison([one]))
    texts["report"] = _words(written)
    content = {"discover": _read(found.as_json()), "diagnose": _read(diagnosis.as_json())}
    if fitted and found.verdict != "unknown":
        fit = fit_model(recordings, found.model)
        texts["fit"] = _printed(lambda: show_fit(fit, found.model))
        content["fit"] = _read(fit.as_json())
    return Told(texts, content, [*comparisons, *alone], findings)


def contradictions(told: Told) -> list[str]:
    """What contradicts something else that is said, in a line each."""
    return [*_nothing_beside_something(told), *_no_shares(told), *_floors(told), *_orders(told), *_credits(told)]


def _nothing_beside_something(told: Told) -> Iterator[str]:
    """That nothing is missing, beside a signal over its floor in the same model."""
    after = told.comparisons[1]
    over = beyond_noise(after.input, after.overall)
    verdict = verdict_of(told.findings)
    said = {"verdict": verdict, **{name: told.texts[name] for name in ("diagnose", "fit") if name in told.texts}}
    if told.findings.verdict == "none":
        said["report"] = told.texts["report"]
    for who, text in said.items():
        if over and (words := _NOTHING.search(text)):
            yield f"{who} says {words[0]!r}, compare that {over} is over its noise"
    if told.findings.verdict == "none" and not _NOTHING.search(verdict) and not over:
        yield f"the verdict tells of something beyond the noise, compare does not: {verdict}"
    if told.findings.verdict == "unknown":
        for who in ("discover", "diagnose", "report"):
            if words := _NOTHING.search(told.texts[who]):
                yield f"{who} says {words[0]!r}, the verdict is unknown"
    told_times = {text for who, text in said.items() for text in _BEYOND.findall(text) if who == "verdict"}
    if told_times and not over:
        yield f"the verdict tells {told_times} times the noise, compare tells of none"
    for name, text in told.texts.items():
        if name.startswith("compare") and "left to find" in text:
            yield f"{name} says that nothing is left to find, which it does not look for"


def _no_shares(told: Told) -> Iterator[str]:
    """Shares that are none: over 1 or below 0, over 100 % or below 0."""
    for verb, content in told.content.items():
        for name, value in _named(content, ("error_removed", "refit_removed", "probability", "none", "unknown")):
            if value is not None and not 0.0 <= value <= 1.0:
                yield f"{verb}: {name} is {value}"
    for who, text in told.texts.items():
        for line in text.splitlines() if who != "report" else ():
            if "excess removed" in line or line.lstrip("│ ").startswith(("+", "−", "constants")):
                yield from (f"{who}: {share} %" for share in _SHARE.findall(line) if not 0.0 <= float(share) <= 100.0)


def _floors(told: Told) -> Iterator[str]:
    """Noise floors of one signal that differ: those of the given model, and those of both models compared together.

    Models that are compared together have the floor of the better one, to whose constants the sensors' noise may be
    another torque.
    """
    unseen = told.content["discover"]["unseen"]
    given: dict[str, dict[str, float]] = {unseen["signal"]: {"discover": unseen["noise_floor"]}}
    for name, error in told.content["discover"]["left"].items():
        given.setdefault(name, {})["left"] = error["noise_floor"]
    before, after, alone, found = told.comparisons
    _put_floors(given, "alone", alone)
    together: dict[str, dict[str, float]] = {}
    for place, comparison in (("before", before), ("after", after)):
        _put_floors(together, place, comparison)
    # what is fitted began as the model that was found
    fitted = {name: {"fit": error["noise_floor"]} for name, error in told.content.get("fit", _UNFITTED)["rmse"].items()}
    for name in fitted:
        fitted[name]["compare"] = found.overall[name]["noise_floor"]
    for floors in (given, together, fitted):
        for signal, by_place in floors.items():
            if not all(math.isclose(value, max(by_place.values()), rel_tol=SAME) for value in by_place.values()):
                yield f"{signal} has several noise floors: {by_place}"


def _put_floors(floors: dict[str, dict[str, float]], place: str, comparison: Comparison) -> None:
    for name, error in comparison.overall.items():
        of = floors.setdefault(name, {})
        of[place] = error["noise_floor"]
        for recording in comparison.recordings:
            if name in recording.signals:
                of[f"{place} {recording.name}"] = recording.signals[name]["noise_floor"]


def _orders(told: Told) -> Iterator[str]:
    """Causes that are told in different orders."""
    added = list(told.content["discover"]["added"])
    orders = {
        "diagnose": [entry["effect"] for entry in told.content["diagnose"]["ranking"] if entry["found"]],
        "parameters": [entry["effect"] for entry in told.content["discover"]["parameters"].values()],
    }
    if told.findings.verdict == "explained" and told.content["diagnose"]["verdict"] != added[0]:
        yield f"diagnose names {told.content['diagnose']['verdict']} first, discover {added[0]}"
    for who, order in orders.items():
        if list(dict.fromkeys(order)) != added:
            yield f"{who} tells {order}, discover {added}"
    told_first = told.texts["report"].split("How sure that is")[0]
    wrong = told_first.split("What was wrong")[-1]
    places = [wrong.find(effect_words(id)) for id in added]
    if told.findings.verdict == "explained" and places != sorted(places):
        yield f"the report does not tell {added} in this order: {wrong[:200]}"


def _credits(told: Told) -> Iterator[str]:
    """Steps that do not follow from each other, and what the constants' own fit did told as an effect's."""
    found = told.content["discover"]
    unseen, steps = found["unseen"], found["steps"]
    before = unseen["rmse"][0]
    for step in steps:
        if step["rmse_before"] != before and step["rmse_before"] not in unseen["rmse"]:
            yield f"{step['instance']} begins at {step['rmse_before']}, where {before} was left"
        if step["rmse_after"] > step["rmse_before"] and (step["error_removed"] or 0.0) > 0.0:
            yield f"{step['instance']} removes {step['error_removed']} and leaves more"
        before = step["rmse_after"]
    if unseen["rmse"][0] > unseen["as_given"]["rmse"]:
        yield "the fit of the model's own constants leaves more than there was, which effects are credited with"
    if steps and unseen["as_given"]["rmse"] != unseen["rmse"][0] and "refitted" not in told.texts["discover"]:
        yield "the fit of the model's own constants is not told"
    alone = told.comparisons[0].overall.get(unseen["signal"])
    mixed = told.comparisons[0].input == "mixed"
    # a search simulates in steps twice as long
    if alone is not None and not mixed and not math.isclose(alone["rmse"], unseen["as_given"]["rmse"], rel_tol=0.01):
        yield f"as given, discover tells {unseen['as_given']['rmse']}, compare {alone['rmse']}"


class Checked(NamedTuple):
    """A case, what was found, and what contradicts."""

    case: str
    said: list[str]
    contradictions: list[str]

    def line(self) -> str:
        """One line for the screen."""
        return f"{self.case:16s} {','.join(self.said) or '-'}: {'; '.join(self.contradictions) or 'told alike'}"


def checked(case: Case, _: Sequence[str] = ()) -> Checked:
    """A case, checked; every fourth is fitted too."""
    try:
        told = told_of(readable_train(case), case.start_model, fitted=int(case.name[:3]) % 4 == 0)
    except Exception as error:  # whatever it is, the case is lost and the others go on
        return Checked(case.name, [], [f"{type(error).__name__}: {error}"])
    return Checked(case.name, [told.findings.verdict, *told.findings.added], contradictions(told))


def _printed(show: Any) -> str:
    with console.capture() as printed:
        show()
    return printed.get()


def _words(written: str) -> str:
    body = written[written.find("<main>") : written.find("<script>")]
    return re.sub(r"\s+", " ", html.unescape(re.sub("<[^>]+>", " ", body)))


def _read(content: Mapping[str, object]) -> Any:
    return json.loads(json.dumps(content))


def _named(content: Any, names: Iterable[str]) -> Iterator[tuple[str, float | None]]:
    """Every number of these names, wherever it stands."""
    if isinstance(content, dict):
        for name, value in content.items():
            if name in names and (value is None or isinstance(value, int | float)):
                yield name, value
            yield from _named(value, names)
    elif isinstance(content, list):
        for value in content:
            yield from _named(value, names)
