"""Messages that were packed one by one, as `ros2 bag record --compression-mode message` does it."""

from __future__ import annotations

import numpy as np
import zstandard

from ema_bench_replay.bags.cdr import CdrError
from ema_bench_replay.bags.mcap_scan import Block

_PACKED = b"\x28\xb5\x2f\xfd"  # how a frame of zstd begins, and no message in CDR
_LARGEST = 1 << 16
"""Bytes of a message, unpacked: a state has some 250."""
_LARGEST_BLOCK = 256 << 20
"""Bytes of all messages of a block."""


def unpacked(block: Block) -> Block:
    """The block with its messages as they are in CDR; itself where the first is not packed.

    Raises CdrError where one cannot be unpacked, or is larger than any state.
    """
    first = int(block.offsets[0])
    if block.data[first : first + len(_PACKED)] != _PACKED:
        return block
    unpacker = zstandard.ZstdDecompressor()
    found, total = [], 0
    for offset, size in zip(block.offsets.tolist(), block.sizes.tolist(), strict=True):
        data = _message(unpacker, block.data[offset : offset + size])
        if (total := total + len(data)) > _LARGEST_BLOCK:
            raise CdrError(f"unpacks with those beside it to more than {_LARGEST_BLOCK >> 20} MiB")
        found.append(data)
    sizes = np.array([len(data) for data in found])
    return Block(b"".join(found), np.cumsum(sizes) - sizes, sizes, block.log_times)


def _message(unpacker: zstandard.ZstdDecompressor, frame: bytes) -> bytes:
    """What a frame holds, which must be whole. Raises CdrError."""
    try:
        size = zstandard.get_frame_parameters(frame).content_size
        if size == zstandard.CONTENTSIZE_UNKNOWN:
            size = len(unpacker.stream_reader(frame).read(_LARGEST + 1))  # which takes a cut frame for a whole one
        if size > _LARGEST:  # before room is made for it
            raise CdrError(f"unpacks to more than {_LARGEST >> 10} KiB, which no state has")
        return unpacker.decompress(frame, max_output_size=_LARGEST)
    except zstandard.ZstdError:
        raise CdrError("is packed with zstd and damaged") from None
