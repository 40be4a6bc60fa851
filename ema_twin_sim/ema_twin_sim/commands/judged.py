"""Shared by the commands that judge models by recordings: they read both and write findings in the same way."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ema_bench_replay.recording import Recording

from ..discovery.zeros_by_model import has_a_zero, with_the_models_zeros
from ..effects import find_effect
from ..measured.unstated_noise import with_noise_of
from ..model import Model, load_model
from ..own_effects import load_effects
from .inputs import load_runs, write_json
from .output import warn

if TYPE_CHECKING:
    from ..discovery.discover import Discovery


def read_judged(
    runs: Sequence[Path],
    models: Sequence[str],
    with_files: Sequence[Path] | None,
    without: Sequence[str] | None = None,
    *,
    import_map: str,
    start: float | None,
    end: float | None,
    strict: bool,
    between_them: bool = False,
) -> tuple[list[Recording], list[Model], list[str]]:
    """Read recordings, the models compared with them, and the ids of the effects to leave out.

    Users' own effects are loaded first, because a model may contain them. ``between_them``: as ``with_one_zero``.
    """
    load_effects(with_files or ())
    excluded = [find_effect(id, "--without").id for id in without or ()]
    given = [load_model(model) for model in models]
    recordings = load_runs(runs, import_map=import_map, start=start, end=end, strict=strict, least=2)
    recordings = with_one_zero(recordings, given, between_them=between_them)
    return recordings, [with_noise_told(recordings, model) for model in given], excluded


def with_one_zero(
    recordings: list[Recording], models: Sequence[Model], *, between_them: bool = False
) -> list[Recording]:
    """The recordings, with their positions' zeros where the first model that tells them has it; says what it moved.

    ``between_them``: only by what they differ from each other.
    """
    telling = next((model for model in models if has_a_zero(model)), None)
    if telling is None:
        return recordings
    moved, told = with_the_models_zeros(recordings, telling, between_them=between_them)
    warn_of(told, recordings)
    return moved


def with_noise_told(recordings: Sequence[Recording], model: Model) -> Model:
    """The model, with the noise of the recordings if it states none of its sensors; says so on the error output."""
    found, said = with_noise_of(recordings, model)
    if said:
        warn(said)
    return found


def write_evidence_bag(found: Discovery, file: Path, *, force: bool) -> None:
    """Write what each step of the search left unexplained as an MCAP."""
    from ..views.evidence_bag import write_evidence

    # the search splits a single table of operating points in two
    used = found.given if len(found.given) == len(found.recordings) else found.recordings
    write_evidence(found, used, file, force=force)


def warn_of(warnings: Iterable[str], recordings: Sequence[Recording], told: Collection[str] = ()) -> None:
    """Print the warnings except those ``told`` before and the recordings' own, which were told when they were read."""
    known = {*told, *(warning for recording in recordings for warning in recording.warnings)}
    for warning in warnings:
        if warning not in known:
            warn(warning)


def write_findings(json: Path | None, findings: Mapping[str, object], found: Discovery) -> None:
    """Write findings and the evidence behind them as JSON."""
    if json is not None:
        from ..discovery.evidence import evidence_json

        write_json(json, {**found.origin, **findings, "evidence": evidence_json(found)})
