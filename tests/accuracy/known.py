"""Cases that were once missed and are named since, each with what had gone wrong: none may be lost again."""

from __future__ import annotations

from pathlib import Path

import yaml

from .cases import Case
from .judge import Verdict
from .other_machines import other_machine_case

UNKNOWN = "unknown"
REASONS: dict[str, str] = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text("utf-8"))
"""What had gone wrong, by the case's name."""


def known_case(name: str) -> Case:
    """One of them; its effects are in its name, since the order in which they are drawn changes with the catalogue."""
    seed, number, effects = name.split("_", 2)
    return other_machine_case(name, "plain", effects.split("+"), (int(seed), 5001, int(number)))


def known_cases() -> list[Case]:
    """All of them."""
    return [known_case(name) for name in REASONS]


def kept(verdict: Verdict) -> bool:
    """Whether all that is hidden is named, and nothing wrong beside it: the spring of a gearbox that rings is not.

    A cause of no catalogue is named by nothing, and told as unknown.
    """
    known = {*verdict.hidden} - {UNKNOWN}
    told = verdict.verdict == UNKNOWN or UNKNOWN not in verdict.hidden
    return known <= {*verdict.added} and told and not verdict.wrong
