"""``ema-twin recover``: a bag that was cut, made whole."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import options
from .output import console, warn

EXAMPLES = """Examples:

ema-twin recover live/live.mcap -o live_whole.mcap

A recorder that was killed, or whose disk was full, leaves a bag without an index, which most tools refuse. The original
is never changed."""


def run(
    bag: Annotated[Path, typer.Argument(metavar="FILE.mcap", help="The bag that was cut, or is damaged.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.mcap", help="The whole bag to write.")],
    force: options.Force = False,
) -> None:
    """Write what can be read of a damaged bag as one that every tool opens."""
    from ema_bench_replay.bags.recover import recover
    from ema_bench_replay.errors import InputError

    if not bag.is_file():
        raise InputError(f"{bag}: is no file; name the .mcap that is damaged")
    found = recover(bag, output, force=force)
    if found.damage:
        warn(f"{bag.name}: {found.damage}; recovered up to the last whole part")
    count = sum(found.messages.values())
    whole = "" if found.damage else f" ({bag.name} was whole)"
    console.print(f"{output}: {count} messages over {found.seconds:.3f} s{whole}", soft_wrap=True)
    for topic, messages in found.messages.items():
        console.print(f"  {topic}: {messages}", soft_wrap=True)
