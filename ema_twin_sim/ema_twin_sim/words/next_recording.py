"""The recording to make next, in plain words: the command, the motion that it is, and what it would show."""

from __future__ import annotations

import re

from ema_bench_replay.errors import InputError

from ..simulation.command import in_words
from .sentences import effect_words

_SUGGESTED = re.compile(r"(?P<command>[a-z-]+:[^ ]+) for (?P<seconds>[^ ]+) s: (?P<why>.*)")
_IDS = re.compile(r"[a-z]+(_[a-z]+)+(\([^)]*\))?")
_DEVIATIONS = "standard deviations"


def rival_words(rival: str) -> str:
    """``sun_runout(kind=conservative)`` as ``sun runout (kind conservative)``."""
    id, _, kind = rival.partition("(")
    return f"{effect_words(id)} ({kind.rstrip(')').replace('=', ' ')})" if kind else effect_words(id)


def spoken(text: str) -> str:
    """A sentence with its effect ids replaced by words."""
    words = _IDS.sub(lambda found: rival_words(found.group()), text)
    return f"{words[0].upper()}{words[1:]}."


def recording_words(suggestion: str, motion: str = "rotary") -> str:
    """What a search suggests to record, with its command in words and with units; other suggestions as they are."""
    found = _SUGGESTED.fullmatch(suggestion)
    try:
        said = in_words(found["command"], motion) if found is not None else ""
    except InputError:  # of an older file
        said = ""
    if found is None or not said:
        return suggestion
    why = spoken(found["why"]).replace(_DEVIATIONS, f"{_DEVIATIONS} of the noise", 1)
    return f"{found['command']} for {found['seconds']} s ({said}). {why}"
