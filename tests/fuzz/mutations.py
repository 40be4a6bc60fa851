"""Inputs made from others: bytes and pieces changed, and records of an MCAP, inside its compressed chunks too."""

from __future__ import annotations

import random
import struct
import zlib
from collections.abc import Callable, Sequence
from io import BytesIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.records import Chunk

from ema_bench_replay.bags.mcap_file import MAGIC, bytes_of

Mutation = Callable[[bytes, random.Random], bytes]

LONGEST = 1 << 17
"""Bytes of an input: more is but slower."""
_CHUNK = 6
_RECORD = struct.Struct("<BQ")
_PACKED = {
    "": bytes,
    "zstd": zstandard.ZstdCompressor(level=1).compress,
    "lz4": lz4.frame.compress,
}
_UNPACKED = {
    "": bytes,
    "zstd": lambda data: zstandard.ZstdDecompressor().decompress(data, 1 << 24),
    "lz4": lz4.frame.decompress,
}
_NUMBERS = ("0", "-1", "1e308", "-1e-320", "nan", "inf", "1e400", "99999999999999999999", "0x1F", "1_0", "1:1:1", "")
_WORDS = ("\n", "\t", ",", ";", ":", "&a ", "*a", "!!", "{", "}", "[", "]", "- ", "<<: ", "null", "é", "\x1b[31m", '"')
_INTEGERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 31, (1 << 63) - 1, (1 << 64) - 1)


def of_bytes(data: bytes, chance: random.Random) -> bytes:
    """Some bytes changed, left out, doubled, or replaced by a whole number that is a limit of its kind."""
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 1, 2, 4, 16))):
        place = chance.randrange(len(changed) + 1)
        length = min(int(2 ** chance.uniform(0.0, 10.0)), len(changed) - place)
        way = chance.randrange(6)
        if way == 0 and place < len(changed):
            changed[place] ^= 1 << chance.randrange(8)
        elif way == 1:
            del changed[place : place + length]
        elif way == 2:
            changed[place:place] = changed[place : place + length] * chance.choice((1, 1, 2, 30))
        elif way == 3:
            kind = chance.choice(["<B", "<H", "<I", "<Q", ">I"])
            number = chance.choice(_INTEGERS) % (1 << 8 * struct.calcsize(kind))
            changed[place : place + struct.calcsize(kind)] = struct.pack(kind, number)
        elif way == 4:
            changed[place:place] = chance.randbytes(chance.choice((1, 2, 8)))
        elif chance.random() < 0.2:
            del changed[place:]
    return bytes(changed[:LONGEST])


def of_text(data: bytes, chance: random.Random) -> bytes:
    """Lines and words moved, doubled, left out; numbers replaced by unkind ones; or bytes changed."""
    if chance.random() < 0.3:
        return of_bytes(data, chance)
    lines = data.split(b"\n")
    for _ in range(chance.choice((1, 1, 2, 4))):
        place = chance.randrange(len(lines))
        way = chance.randrange(6)
        if way == 0:
            lines.insert(place, chance.choice(lines))
        elif way == 1 and len(lines) > 1:
            del lines[place]
        elif way == 2:
            lines[place] = _replaced(lines[place], chance, _NUMBERS)
        elif way == 3:
            lines[place] = _replaced(lines[place], chance, _WORDS)
        elif way == 4:
            lines[place] = b" " * chance.randrange(9) + lines[place].strip()
        else:
            words = lines[place].split()
            chance.shuffle(words)
            lines[place] = b" ".join(words)
    return b"\n".join(lines)[:LONGEST]


def _replaced(line: bytes, chance: random.Random, by: Sequence[str]) -> bytes:
    """The line with one of its words, or a place in it, replaced."""
    words = line.split(b" ")
    words[chance.randrange(len(words))] = chance.choice(by).encode()
    return b" ".join(words)


def of_mcap(data: bytes, chance: random.Random) -> bytes:
    """Bytes of the file or of one of its records, whose length is made right again; of a chunk its packed content."""
    if chance.random() < 0.25 or not data.startswith(MAGIC):
        return of_bytes(data, chance)
    records = list(records_of(data[len(MAGIC) :]))
    for _ in range(chance.choice((1, 1, 2))):
        if not records:
            break
        place = chance.randrange(len(records))
        way = chance.randrange(8)
        opcode, content = records[place]
        if way == 0:
            records.insert(chance.randrange(len(records) + 1), records[place])
        elif way == 1:
            del records[place]
        elif way == 2:
            records[place] = chance.randrange(20), content
        elif opcode == _CHUNK:
            records[place] = opcode, _chunk(content, chance)
        else:
            records[place] = opcode, of_bytes(content, chance)
    ending = MAGIC if chance.random() < 0.9 else b""
    return (MAGIC + joined(records) + ending)[:LONGEST]


def records_of(data: bytes) -> list[tuple[int, bytes]]:
    """Opcode and content of each whole record."""
    found, place = [], 0
    while place + _RECORD.size <= len(data):
        opcode, length = _RECORD.unpack_from(data, place)
        place += _RECORD.size
        if place + length > len(data):
            break
        found.append((opcode, data[place : place + length]))
        place += length
    return found


def joined(records: Sequence[tuple[int, bytes]]) -> bytes:
    return b"".join(_RECORD.pack(opcode, len(content)) + content for opcode, content in records)


def _chunk(content: bytes, chance: random.Random) -> bytes:
    """A chunk of changed records, with the size and checksum that belong to them; or one that does not read."""
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))
        records = records_of(_UNPACKED[chunk.compression](chunk.data))
        place = chance.randrange(len(records))
        records[place] = records[place][0], of_bytes(records[place][1], chance)
    except Exception:
        return of_bytes(content, chance)
    data = joined(records)
    chunk.compression = chance.choice((*[chunk.compression] * 8, *_PACKED, "x"))
    chunk.data = _PACKED.get(chunk.compression, bytes)(data)
    chunk.uncompressed_size, chunk.uncompressed_crc = len(data), zlib.crc32(data)
    if chance.random() < 0.1:
        chunk.uncompressed_size = chance.choice(_INTEGERS)
    return bytes_of(chunk)[_RECORD.size :]
