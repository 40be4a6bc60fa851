"""Read the recordings that the command line names, check its outputs, and write results as JSON."""

from __future__ import annotations

import errno
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from ema_bench_replay.bags.bag_parts import bag_parts, how_to_convert, recordings_in
from ema_bench_replay.configuration import find_configuration
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import TRACES, load
from ema_bench_replay.outputs import write_text
from ema_bench_replay.recording import Recording

from ..listing import by_recording, number_of
from ..text_traces import without_notes
from .output import counted, warn


def load_runs(
    paths: Sequence[Path],
    *,
    import_map: str = "siemens",
    start: float | None = None,
    end: float | None = None,
    strict: bool = False,
    least: int = 1,
) -> list[Recording]:
    """Load the recordings that the paths name, each once, cut to [start, end] s.

    Warnings are printed, or refused if ``strict``. Raises InputError if one has fewer than ``least`` samples.
    """
    if start is not None and end is not None and start > end:
        raise InputError(f"--from {start:g} is after --to {end:g}; give the earlier time first")
    found = _together(_each_once([file for path in paths for file in find_recordings(path, warn)]))
    files = [parts[0] for parts in found]
    recordings = []
    with warned_or_refused(strict=strict) as warnings_of:
        for file, recording in zip(files, _read(found, import_map), strict=True):
            warnings_of(recording)
            if start is not None or end is not None:
                recording = recording.between(start, end)
            if len(recording) < least:
                raise InputError(
                    f"{file}: has {number_of(len(recording), 'sample')}, and {least} are needed; check --from and --to"
                )
            recordings.append(recording)
    names = _told_apart([recording.name for recording in recordings], files)
    return [replace(recording, name=name) for recording, name in zip(recordings, names, strict=True)]


@contextmanager
def warned_or_refused(*, strict: bool) -> Iterator[Callable[[Recording], None]]:
    """Print what is wrong with recordings, once for all in which it is the same, after all of them are read.

    Gives a function that takes each recording; if ``strict``, it raises InputError with the first of it.
    """
    warnings: list[str] = []

    def take(recording: Recording) -> None:
        if strict and recording.warnings:
            raise InputError(f"{recording.warnings[0]} (--strict refuses this; without it, it is only a warning)")
        warnings.extend(recording.warnings)

    try:
        yield take
    finally:
        for warning in by_recording(warnings):
            warn(warning)


def _read(found: Sequence[tuple[Path, ...]], import_map: str) -> Iterator[Recording]:
    """Yield the recordings of these files in turn; a bar or log lines show the progress."""
    with counted(len(found), "reading") as done:
        for parts in found:
            name = parts[0].stem
            yield load(parts, import_map=import_map, progress=partial(done.within, name))
            done(name)


def _told_apart(names: Sequence[str], files: Sequence[Path]) -> list[str]:
    """Make the names unique: equal ones get their folder's name, or a number if that is equal too."""
    often = Counter(names)
    apart = [
        f"{name} ({file.resolve().parent.name})" if often[name] > 1 else name
        for name, file in zip(names, files, strict=True)
    ]
    taken = Counter(apart)
    return [
        f"{name} ({number})" if often[name] > 1 and taken[new] > 1 else new
        for number, (name, new) in enumerate(zip(names, apart, strict=True), 1)
    ]


def find_recordings(path: Path, tell: Callable[[str], None] = lambda text: None) -> list[Path]:
    """The recordings that a path names: the path itself or, for a folder of recording folders, each of these.

    A folder of several .mcap files that are not parts of one recording stands for its files, as does a folder of text
    traces without any bag; those of other names than .csv only if it holds none of these, which ``tell`` is called
    with, and no bag of a kind that cannot be read, whose reader says how to convert it.
    """
    if not path.is_dir():
        return [path]
    found = bag_parts(path)
    if found:
        return [path] if len(found) == 1 else [file for parts in found for file in parts]
    inside = sorted(folder for folder in path.iterdir() if folder.is_dir() and any(folder.glob("*.mcap")))
    if inside:
        return inside
    named = TRACES if not how_to_convert(path) else (".csv",)
    texts = sorted(file for file in path.iterdir() if file.suffix.lower() in named and file.is_file())
    return [file for (file,) in without_notes(path, [(file,) for file in texts], tell)] or [path]


def _together(files: Sequence[Path]) -> list[tuple[Path, ...]]:
    """The files that each recording is read from: a folder or a file, or the parts that a recorder split it into."""
    bags = [file for file in files if file.suffix.lower() == ".mcap"]
    found = {parts[0]: parts for parts in recordings_in(bags)}
    return [found.get(file, (file,)) for file in files if file in found or file not in bags]


def _each_once(files: Sequence[Path]) -> list[Path]:
    held: dict[Path, int] = {}
    twice = set()
    for k in sorted(range(len(files)), key=lambda k: not files[k].is_dir()):  # folders first, before files in them
        bags = [files[k], *files[k].glob("*.mcap")]
        if {held.setdefault(bag.resolve(), k) for bag in bags} != {k}:
            twice.add(k)
    if twice:
        warn(f"given more than once, used once: {', '.join(dict.fromkeys(str(files[k]) for k in sorted(twice)))}")
    return [file for k, file in enumerate(files) if k not in twice]


def input_files(
    runs: Sequence[Path], models: Sequence[str], import_map: str, with_files: Sequence[Path] | None = None
) -> list[Path]:
    """The files that are read for these arguments; ``metadata.yaml`` of a recording is listed even if it is absent."""
    from ..model.model_file import model_files

    files = [file for name in models for file in model_files(name)]
    files += [find_configuration("maps", import_map), *(with_files or ())]
    for recording in (recording for run in runs for recording in find_recordings(run)):
        files += [recording, *recording.glob("*.mcap"), recording / "metadata.yaml"]
    return files


def refuse_inputs(inputs: Sequence[Path], *outputs: Path | None, folder: Path | None = None) -> None:
    """Raise InputError, before anything is computed, if an output is an input or another output (under any name), is a
    folder, or cannot be written.

    ``folder`` is an output that is a folder.
    """
    taken = {file.resolve(): f"an input ({file})" for file in inputs}
    for output in (*outputs, folder):
        if output is not None:
            if output is not folder and output.is_dir():
                raise InputError(f"{output}: is a folder; name a file")
            if output.resolve() in taken:
                raise InputError(f"{output}: is {taken[output.resolve()]}; choose another name for the output")
            taken[output.resolve()] = "another output too"
            _refuse_unwritable(output)


def _refuse_unwritable(output: Path) -> None:
    if output.exists() and not output.is_file():  # opening it later refuses a folder and accepts a pipe
        return
    folder = next(above for above in output.absolute().parents if above.exists())
    try:
        tempfile.TemporaryFile(dir=folder).close()  # if it is a file, the reason given is that it is no folder
    except FileNotFoundError:  # the folder is there, but its file system makes no files, as that of /proc
        raise InputError(
            f"{output}: cannot be written (no file can be made in {folder}); choose another folder"
        ) from None
    except OSError as error:
        reason, needed = error.strerror or error, "another folder"
        if isinstance(error, PermissionError) or error.errno == errno.EROFS:
            needed = "a folder with write permission"
        raise InputError(f"{output}: cannot be written ({reason}); choose {needed}") from None


def check_outputs(
    inputs: Sequence[Path],
    force: bool,
    *,
    json: Path | None = None,
    model: Path | None = None,
    command: Path | None = None,
    evidence: Path | None = None,
    page: Path | None = None,
    rrd: Path | None = None,
) -> None:
    """Raise InputError, before anything is computed, if an output cannot be written, or has a name of another kind.

    Likewise if it exists and ``force`` is not set; only JSON is replaced without it.
    """
    from ..model.model_file import check_model_name

    refuse_inputs(inputs, model, command, json, evidence, page, rrd)
    if model is not None:
        check_model_name(model)
    if command is not None and command.suffix.lower() not in (".yaml", ".yml"):
        raise InputError(f"{command}: unknown kind of command file '{command.suffix}'; name it .yaml")
    if evidence is not None and evidence.suffix != ".mcap":
        raise InputError(f"{evidence}: evidence is written as MCAP; name it .mcap")
    if page is not None and page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{page}: a report is a page; name it .html")
    check_rrd_name(rrd)
    for output in (model, command, evidence, page, rrd):
        if output is not None and output.is_file() and not force:
            raise InputError(f"{output}: exists already; give another name, or --force to replace it")


def check_rrd_name(path: Path | None) -> None:
    """Raise InputError if the name of a rerun file does not end in .rrd."""
    if path is not None and path.suffix != ".rrd":
        raise InputError(f"--rrd {path}: is not a rerun file's name; end it in .rrd")


def write_json(path: Path | None, content: object) -> None:
    """Write a result as JSON, replacing an existing file; numbers that are not finite become null."""
    if path is not None:
        import orjson  # in a millisecond, where the standard library takes a tenth of a second

        options = orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_APPEND_NEWLINE
        write_text(path, orjson.dumps(content, option=options).decode(), force=True)
