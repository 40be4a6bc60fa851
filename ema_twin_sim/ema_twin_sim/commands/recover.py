"""``ema-twin recover``: repair a bag that was cut off."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import options
from .output import console, warn

EXAMPLES = """Examples:

ema-twin recover live/live.mcap     (writes live/live_recovered.mcap)

ema-twin recover live/live.mcap -o live_whole.mcap

If a recorder is killed or its disk is full, the bag has no index and most tools refuse it. The original is never
changed."""


def run(
    bag: Annotated[Path, typer.Argument(metavar="FILE.mcap", help="The truncated or damaged bag.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE.mcap", help="The repaired bag; FILE_recovered.mcap by default."),
    ] = None,
    force: options.Force = False,
) -> None:
    """Write what can be read of a damaged bag as one that every tool opens."""
    from ema_bench_replay.bags.recover import recover
    from ema_bench_replay.errors import InputError

    if not bag.is_file():
        raise InputError(f"{bag}: is no file; name the .mcap that is damaged")
    output = output or bag.with_name(f"{bag.stem}_recovered.mcap")
    found = recover(bag, output, force=force)
    if found.damage:
        lost = f"the last {found.torn} bytes are lost"
        warn(f"{bag.name}: {found.damage}; recovered up to the last whole part, {lost}")
    count = sum(found.messages.values())
    whole = "" if found.damage else f" ({bag.name} was whole)"
    console.print(f"{output}: {count} messages over {found.seconds:.3f} s{whole}", soft_wrap=True)
    for name, topic in found.topics.items():
        console.print(f"  {name}: {topic.messages} messages over {topic.seconds:.3f} s", soft_wrap=True)
