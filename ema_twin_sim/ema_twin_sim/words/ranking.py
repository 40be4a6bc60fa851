"""The ranking of effects: which of them are worth showing, and what they are called."""

from __future__ import annotations

from collections.abc import Sequence

from ..discovery.diagnose import Ranked
from ..quantities import estimate
from .findings import Findings
from .sentences import NOT_IN_CATALOGUE, effect_words, no_effect_words, options_words

_LEAST = 0.005  # smallest probability that is shown as more than none
UNLIKELY = 3
"""Number of effects below it that are shown."""


def worth_showing(ranking: Sequence[Ranked]) -> tuple[list[Ranked], int]:
    """The ranking without most effects of probability 0, and how many were left out."""
    likely = [entry for entry in ranking if entry.found or entry.probability >= _LEAST]
    others = [entry for entry in ranking if entry not in likely]
    return likely + others[:UNLIKELY], max(0, len(others) - UNLIKELY)


def ranked_words(entry: Ranked) -> str:
    """The effect with its options: ``cogging (order 24)``."""
    name, choices = effect_words(entry.effect), options_words(entry.options)
    return f"{name} ({choices})" if choices else name


def size_words(entry: Ranked) -> list[str]:
    """The effect's parameters: ``width 4.000 ± 0.020 mrad``."""
    return [
        f"{name} {estimate(held['value'], held['std'], held['unit'])}"  # type: ignore[arg-type]
        for name, held in entry.parameters.items()
    ]


def other_answers(findings: Findings) -> list[tuple[str, float]]:
    """That no effect is missing, and that one is that the catalogue lacks, with their probabilities."""
    none = f"{no_effect_words(findings.beyond_noise)} is missing"
    return [(none, findings.none or 0.0), (NOT_IN_CATALOGUE, findings.unknown or 0.0)]
