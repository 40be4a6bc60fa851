"""Columns that an import map names and a file lacks, in words: for a refusal that needs one of their signals."""

from __future__ import annotations

from collections.abc import Sequence

from ema_bench_replay.recording import LACKED, Recording


def lacked_columns(recording: Recording, signals: Sequence[str]) -> str:
    """Which columns of these ``signals`` the recording's file lacks, and what to do; empty if the map reads none."""
    known = recording.metadata
    none = [
        f"no column {known[signal + LACKED]} ({signal.replace('_', ' ')})"
        for signal in signals
        if signal + LACKED in known
    ]
    if not none:
        return ""
    file, by = known.get("source", recording.name), known.get("map", "")
    return (
        f"{file} has {' and '.join(none)}, which the map {by!r} reads; export it, or name the right column in the map"
    )
