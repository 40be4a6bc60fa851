"""The store: a folder of Parquet files, each written as a whole under a name of its own.

Campaigns that write at the same time do not touch each other's files. A job that two of them did is there twice and
counts once, with its latest try that was done; if none was, with its latest try. pandas, polars, DuckDB and pyarrow
read the folder directly.
"""

from __future__ import annotations

import os
import platform
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pyarrow as pa
import pyarrow.dataset as pd
import pyarrow.parquet as pq

from ema_bench_replay.errors import InputError

from .results import DONE, FAILED, SCHEMA, SCHEMA_VERSION

FOLDER = "results"
_MANY_FILES = 8  # number of a unit's files from which they are merged
_PART = ".part"
_TRIES = 5  # attempts to read while another process merges files
_OF_ONE = ("done_at", "unit", "name", "task", "model")  # when a result was made, and of what


class Store:
    """The results of campaigns in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._files = folder / FOLDER

    @classmethod
    def opened(cls, folder: Path) -> Store:
        """Open an existing store. Raises InputError if there is none, or one of another version."""
        store = cls(folder)
        first = next(store._each(), None)
        if first is None:
            raise InputError(f"{folder}: holds no results; give the folder that ema-twin campaign wrote (-o)")
        store._refuse_other_version(first)
        return store

    @classmethod
    def made(cls, folder: Path) -> Store:
        """Open or make a store to write to; its results are kept. Raises InputError if the folder holds other files."""
        store = cls(folder)
        if folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not store._files.is_dir())):
            raise InputError(f"{folder}: holds other files than results; give another folder with -o")
        if (first := next(store._each(), None)) is not None:
            store._refuse_other_version(first)
        try:
            store._files.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another folder with -o") from None
        return store

    def write(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Add rows with the columns of ``SCHEMA``: one file for each unit, which is written whole or not at all.

        Raises InputError if it cannot be written, as on a full disk.
        """
        units: dict[str, list[Mapping[str, Any]]] = {}
        for row in rows:
            units.setdefault(row["unit"], []).append(row)
        for unit, its in units.items():
            self._write(pa.Table.from_pylist([dict(row) for row in its], SCHEMA), unit)

    def settled(self) -> set[str]:
        """Keys of all jobs that have a try in which nothing failed; only the others need to be done again."""
        tries: dict[tuple[str, int], bool] = {}
        for key, status, done_at in _columns(self._read(["key", "status", "done_at"])):
            tries[key, done_at] = tries.get((key, done_at), True) and status != FAILED
        return {key for (key, _), settled in tries.items() if settled}

    def merge_files(self) -> None:
        """Merge the many files of a unit into one, and remove unfinished files of writers that were killed.

        What another campaign has merged meanwhile is left unchanged.
        """
        for folder in _listed(self._files):
            _clear_left_overs(folder)
            files = [file for file in _listed(folder) if file.suffix == ".parquet"]
            if len(files) < _MANY_FILES:
                continue
            try:
                table = _table_of(files)
            except FileNotFoundError:
                continue
            self._write(_rows(table, _latest(table)), table["unit"][0].as_py())
            for file in files:
                with suppress(FileNotFoundError):
                    file.unlink()

    def rows(self) -> list[dict[str, Any]]:
        """Each job's latest try that was done, else its latest, by unit, time and name.

        Of a recording that was changed, the rows of the latest job.
        """
        table = self._read()
        tried = _latest(table)
        latest: dict[tuple[Any, ...], tuple[int, int]] = {}
        for place, (done_at, *recording) in zip(tried, _columns(_rows(table.select(_OF_ONE), tried)), strict=True):
            of = (*recording,)
            latest[of] = max(latest.get(of, (done_at, place)), (done_at, place))
        chosen = _rows(table, [place for _, place in latest.values()])
        return list(chosen.sort_by([(by, "ascending") for by in ("unit", "time", "name")]).to_pylist())

    def _write(self, table: pa.Table, unit: str) -> None:
        folder = self._files / file_name(unit)
        name = uuid.uuid4().hex
        part = folder / f".{name}.{writer_host()}.{os.getpid()}{_PART}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with part.open("wb") as file:
                pq.write_table(table, file, compression="zstd")
                file.flush()
                os.fsync(file.fileno())
            part.replace(folder / f"{name}.parquet")
        except BaseException as error:
            with suppress(OSError):
                part.unlink()
            if isinstance(error, OSError):
                raise InputError(
                    f"{folder}: results cannot be written ({error.strerror or error}); make room, or permit writing, "
                    "and run the command again: finished results are kept"
                ) from None
            raise

    def _read(self, columns: Sequence[str] | None = None) -> pa.Table:
        for _ in range(_TRIES):
            with suppress(FileNotFoundError):  # of one that was merged with others meanwhile
                return _table_of([*self._each()], columns)
        raise InputError(f"{self._files}: its files change while they are read; try again")

    def _each(self) -> Iterator[Path]:
        return (file for folder in _listed(self._files) for file in _listed(folder) if file.suffix == ".parquet")

    def _refuse_other_version(self, file: Path) -> None:
        try:
            held = (pq.read_schema(file).metadata or {}).get(b"ema_twin.schema", b"").decode()
        except (pa.ArrowInvalid, OSError) as error:
            raise InputError(f"{file}: cannot be read ({error}); remove it, and run the campaign again") from None
        if held != SCHEMA_VERSION:
            said = f"version {held}" if held else "no version"
            raise InputError(
                f"{file}: has results of {said}, this ema-twin writes version {SCHEMA_VERSION}; "
                "give another folder with -o"
            )


def _table_of(files: Sequence[Path], columns: Sequence[str] | None = None) -> pa.Table:
    """All rows of these files. Raises InputError if one is damaged, FileNotFoundError if one has gone."""
    try:
        return pd.dataset([str(file) for file in files], SCHEMA, "parquet").to_table(columns).combine_chunks()
    except FileNotFoundError:
        raise
    except (pa.ArrowInvalid, OSError) as error:
        told = " ".join(str(error).split())
        place = next((str(file) for file in files if str(file) in told), str(files[0].parent))
        raise InputError(f"{place}: cannot be read ({told}); remove it, and run the campaign again") from None


def file_name(unit: str) -> str:
    """A unit's name as the name of a file or folder: never hidden, and never the folder above."""
    return quote(unit, safe=" ").replace(".", "%2E")


def writer_host() -> str:
    """This machine's name, as part of a file name."""
    return file_name(platform.node())


def _clear_left_overs(folder: Path) -> None:
    """Remove half-written files of processes of this machine that have ended."""
    for part in _listed(folder):
        *_, host, process, suffix = ("", "", *part.name.split("."))
        if f".{suffix}" != _PART or host != writer_host() or not process.isdecimal():
            continue
        try:
            os.kill(int(process), 0)
        except ProcessLookupError:
            part.unlink(missing_ok=True)
        except OSError:  # another user's process, and alive
            continue


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except (FileNotFoundError, NotADirectoryError):
        return []


def _rows(table: pa.Table, places: Sequence[int]) -> pa.Table:
    return table.take(pa.array(places, pa.int64()))  # of none, the type would not be known


def _columns(table: pa.Table) -> Iterator[tuple[Any, ...]]:
    """The rows of a table of texts and times [us]."""
    timeless = (column.cast(pa.int64()) if pa.types.is_timestamp(column.type) else column for column in table.columns)
    return zip(*(column.to_pylist() for column in timeless), strict=True)


def _latest(table: pa.Table) -> list[int]:
    """Places of the rows of each job's latest try; a try that was done counts before a later one that was not."""
    status = table["status"].to_pylist()
    tries: dict[str, dict[int, dict[tuple[str, str], int]]] = {}
    for place, (key, done_at, unit, name) in enumerate(_columns(table.select(["key", "done_at", "unit", "name"]))):
        tries.setdefault(key, {}).setdefault(done_at, {})[unit, name] = place
    found: list[int] = []
    for of in tries.values():
        best = max(of, key=lambda at: (all(status[place] == DONE for place in of[at].values()), at))
        found += of[best].values()
    return found
