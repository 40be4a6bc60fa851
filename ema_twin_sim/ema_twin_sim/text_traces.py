"""Which text files of a folder are recordings: those named .csv; of other names only if the folder holds nothing else.

Notes, README files and logs of programs are named .txt and .log as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ema_bench_replay.load import OTHER_TRACES

from .listing import listed, number_of


def without_notes(
    folder: Path, recordings: Sequence[tuple[Path, ...]], tell: Callable[[str], None]
) -> list[tuple[Path, ...]]:
    """The recordings of a folder, each by its files, without the text files of other names; these if there are no more.

    ``tell`` is called with what a user may not expect.
    """
    others = [parts for parts in recordings if parts[0].suffix.lower() in OTHER_TRACES and parts[0].is_file()]
    found = [parts for parts in recordings if parts not in others]
    if not others:
        return found
    kinds = listed(sorted({parts[0].suffix.lower() for parts in others}))
    files = number_of(len(others), f"{kinds} file")
    if not found:
        tell(f"{folder}: holds no .csv or .mcap file; reading its {files} instead")
        return others
    if len(others) > len(found):
        tell(
            f"{folder}: leaving out its {files} beside {number_of(len(found), 'recording')} in .csv or .mcap files; "
            "rename those that are recordings to .csv"
        )
    return found
