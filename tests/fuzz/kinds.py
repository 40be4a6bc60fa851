"""What is read of others: how, valid examples to begin with, and how these are changed."""

from __future__ import annotations

import ast
import itertools
import random
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import zstandard
from mcap.writer import CompressionType

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.bags.mcap_scan import McapScan
from ema_bench_replay.load import load
from ema_bench_replay.nodes.incoming import Incoming
from ema_bench_replay.nodes.sample_codec import write_state
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_csv import read_trace
from ema_twin_sim.live.follower import Follower
from ema_twin_sim.model.model_file import load_model
from ema_twin_sim.own_effects.effect_file import _read
from ema_twin_sim.own_effects.table import checked_table
from ema_twin_sim.simulation.command import parse_command, write_command

from ..bags import DEFINITION, STATE, a_recording, other_writer, serialised, some_samples
from .mutations import Mutation, of_bytes, of_mcap, of_text

ROOT = Path(__file__).parents[2]
_ROWS = 40


class NotRun(Exception):
    """The input is code that nobody wrote: it is not run."""


@dataclass(frozen=True)
class Kind:
    """A kind of input.

    Attributes:
        suffix: of its files.
        seeds: makes valid examples; it may use a folder for that.
        prepare: makes what reads a file, and prepares the folder that the file will be in.
        mutate: changes an example.
    """

    suffix: str
    seeds: Callable[[Path], list[bytes]]
    prepare: Callable[[Path], Callable[[Path], object]]
    mutate: Mutation = of_text


def _traces(_folder: Path) -> list[bytes]:
    head = [
        b"".join(path.read_bytes().splitlines(True)[:_ROWS]) for path in sorted((ROOT / "tests/recordings").iterdir())
    ]
    comma = head[0].replace(b",", b";").replace(b".", b",")
    return [*head[:2], comma, comma.decode().encode("utf-16")]


def _bags(compression: CompressionType) -> Callable[[Path], list[bytes]]:
    def make(folder: Path) -> list[bytes]:
        made = []
        if compression is CompressionType.ZSTD:
            write_mcap(a_recording(60), folder / "own.mcap")
            made.append((folder / "own.mcap").read_bytes())
        packings = [bytes, zstandard.ZstdCompressor().compress] if compression is CompressionType.ZSTD else [bytes]
        for chunked, pack in itertools.product((True, False), packings):
            path = folder / "other.mcap"
            options = {"compression": compression, "use_chunking": chunked, "chunk_size": 2048}
            with other_writer(path, **options) as (writer, channel):
                for message, logged in serialised(some_samples(20)):
                    writer.add_message(channel, logged, pack(message), logged)
                writer.add_metadata("note", {"a": "b"})
                writer.add_attachment(1, 2, "a.txt", "text/plain", b"a")
            made.append(path.read_bytes())
        return made

    return make


def _bag_reader(_folder: Path) -> Callable[[Path], object]:
    def read(path: Path) -> None:
        for _ in McapScan(path).messages():  # what recover does
            pass
        load(path)

    return read


def _trace_reader(_folder: Path) -> Callable[[Path], object]:
    held = load_map("siemens")  # once: to read it again takes three times as long as a trace of 40 lines
    return lambda path: read_trace(path, held)


def _files(pattern: str) -> Callable[[Path], list[bytes]]:
    return lambda _folder: [path.read_bytes() for path in sorted((ROOT / "config").glob(pattern))]


def _model_reader(folder: Path) -> Callable[[Path], object]:
    shutil.copytree(ROOT / "config/models", folder, dirs_exist_ok=True)
    return load_model


def _models(folder: Path) -> list[bytes]:
    return [*_files("models/*.yaml")(folder), *_files("models/constants/*.yaml")(folder)]


def _map_reader(folder: Path) -> Callable[[Path], object]:
    trace = folder / "trace.CSV"
    trace.write_bytes(_traces(folder)[0])

    def read(path: Path) -> None:
        load_map(path)
        load(trace, import_map=path)

    return read


def _commands(_folder: Path) -> list[bytes]:
    texts = ("sine:0.02:1", "speed-triangle:0.05:2", "step:0.1:5", "ramp:0.05")
    return [*(write_command(text, 20.0, "it reverses") for text in texts), b"version: 1\ncommand: ramp:0.05\n"]


def _points(_folder: Path) -> list[bytes]:
    return [b"0 0\n1 0.1\n2 0.3\n3 -0.1\n", b"time [s];value [rad]\n0.0;0.1 # begin\n0.5;0.2\n1e1;-0.3\n"]


def _command_reader(_folder: Path) -> Callable[[Path], object]:
    time = np.linspace(0.0, 10.0, 101)

    def read(path: Path) -> None:
        command = parse_command(str(path))
        command(time)
        command.highest_speed(time)

    return read


def _effects(_folder: Path) -> list[bytes]:
    return [
        path.read_bytes() for path in (ROOT / "docs/examples/position_friction.py", ROOT / "docs/examples/press.py")
    ]


def _shape(source: bytes) -> str | None:
    """A program without its numbers and words; None where it is none."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant):
            node.value = None
    return ast.dump(tree)


def _effect_reader(folder: Path) -> Callable[[Path], object]:
    known = {_shape(source) for source in _effects(folder)}

    def read(path: Path) -> None:
        """A file that is no Python is refused before it runs; one that is may only differ in its constants."""
        shape = _shape(path.read_bytes())
        if shape is not None and shape not in known:
            raise NotRun
        checked_table(path, _read(path))

    return read


def _messages(_folder: Path) -> list[bytes]:
    signals = dict(current=0.1, speed=1.0, motor_position=0.2, output_position=0.1, speed_setpoint=1.0)
    types, root = parse(DEFINITION, STATE)
    named = {"header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "bench"}, "run": 1, **signals}
    return [*(write_state(k * 2_000_000, 1, k, signals) for k in range(3)), serialise(types, root, named)]


def _message_reader(_folder: Path) -> Callable[[Path], object]:
    incoming, follower = Incoming("bench/state"), Follower(load_model("polito_bench"))
    sequence = 0

    def read(path: Path) -> None:
        nonlocal sequence
        state = incoming.read(path.read_bytes())
        if state is None:
            raise Unreadable
        sequence += 1
        follower.answer(1, sequence, sequence * 2_000_000, state.signals)  # these values, at the bench's pace
        follower.answer(state.run, state.sequence, state.stamp, state.signals)

    return read


class Unreadable(Exception):
    """A message is left out and counted: nothing is refused in words."""


KINDS = {
    "CSV": Kind(".csv", _traces, _trace_reader),
    "MCAP": Kind(".mcap", _bags(CompressionType.NONE), _bag_reader, of_mcap),
    "MCAP zstd": Kind(".mcap", _bags(CompressionType.ZSTD), _bag_reader, of_mcap),
    "MCAP lz4": Kind(".mcap", _bags(CompressionType.LZ4), _bag_reader, of_mcap),
    "model": Kind(".yaml", _models, _model_reader),
    "import map": Kind(".yaml", _files("maps/*.yaml"), _map_reader),
    "command": Kind(".yaml", _commands, _command_reader),
    "command CSV": Kind(".csv", _points, _command_reader),
    "own effect": Kind(".py", _effects, _effect_reader),
    "message": Kind(".bin", _messages, _message_reader, of_bytes),
}


def changed(kind: Kind, example: bytes, other: bytes, chance: random.Random) -> bytes:
    """An input made of an example, now and then of two."""
    if chance.random() < 0.05 and example and other:
        example = example[: chance.randrange(len(example))] + other[chance.randrange(len(other)) :]
    return kind.mutate(example, chance)
