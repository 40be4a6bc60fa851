"""What ``ema-twin diagnose`` prints: the ranking of the effects, and what is in doubt."""

from __future__ import annotations

from ..discovery.diagnose import Diagnosis
from ..words.ranking import ranked_words, size_words, worth_showing
from ..words.sentences import NOT_IN_CATALOGUE, no_effect_words, removed_words, surest_sentence
from .output import console, say
from .shown_search import show_doubts
from .tables import ReportTable, is_narrow

_BAR = 20  # characters, for a probability of 1


def show_diagnosis(diagnosis: Diagnosis, motion: str = "rotary") -> None:
    """Print the ranking and what is in doubt."""
    table = ReportTable("\nWhat the model may lack")
    table.words("effect")
    table.numbers("probability", justify="left")
    table.numbers("error removed")
    table.words("parameters")
    shown, left_out = worth_showing(diagnosis.ranking)
    for entry in shown:
        removed = "" if entry.error_removed is None else removed_words(entry.error_removed)
        style = "bold green" if entry.found else ("" if entry.probability > 0.0 else "dim")
        table.add_row(ranked_words(entry), _bar(entry.probability), removed, "\n".join(size_words(entry)), style=style)
    table.add_section()
    for label, probability in (
        (no_effect_words(diagnosis.beyond_noise), diagnosis.none),
        (NOT_IN_CATALOGUE, diagnosis.unknown),
    ):
        table.add_row(label, _bar(probability), "", "", style="" if probability > 0.0 else "dim")
    console.print(table)
    if diagnosis.ranking:
        say(
            "Probability: that this effect is missing; several may be missing at once, and those that the "
            "recordings cannot tell apart share one. Error removed: share of the error above the sensors' noise that "
            "this effect removes in addition to all others found, on data not used for fitting (discover counts its "
            f"steps one after another). {surest_sentence()}"
            + (f" {left_out} more with probability 0 are not listed (they are in --json)." if left_out else ""),
            style="dim",
        )
    show_doubts(diagnosis.groups, diagnosis.next_recording, motion)


def _bar(probability: float) -> str:
    longest = _BAR // 4 if is_narrow() else _BAR
    return f"{100.0 * probability:3.0f} % {'█' * round(longest * probability)}"
