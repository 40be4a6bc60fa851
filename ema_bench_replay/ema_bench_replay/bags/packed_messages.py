"""Individually compressed messages, as written by `ros2 bag record --compression-mode message`."""

from __future__ import annotations

import numpy as np
import zstandard

from ema_bench_replay.bags.cdr import CdrError
from ema_bench_replay.bags.mcap_scan import Block

_PACKED = b"\x28\xb5\x2f\xfd"  # magic number of a zstd frame; no CDR message begins so
_LARGEST = 1 << 16
"""Maximum bytes of a decompressed message: a state has some 250."""
_LARGEST_BLOCK = 256 << 20
"""Maximum bytes of all messages of a block."""


def unpacked(block: Block) -> Block:
    """The block with its messages decompressed to CDR; unchanged if the first is not compressed.

    Raises CdrError if a message cannot be decompressed, or is larger than any state.
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
    """Content of a frame, which must be complete. Raises CdrError."""
    try:
        size = zstandard.get_frame_parameters(frame).content_size
        if size == zstandard.CONTENTSIZE_UNKNOWN:
            size = len(unpacker.stream_reader(frame).read(_LARGEST + 1))  # accepts a truncated frame as complete
        if size > _LARGEST:  # before memory is allocated for it
            raise CdrError(f"unpacks to more than {_LARGEST >> 10} KiB, which no state has")
        return unpacker.decompress(frame, max_output_size=_LARGEST)
    except zstandard.ZstdError:
        raise CdrError("is packed with zstd and damaged") from None
