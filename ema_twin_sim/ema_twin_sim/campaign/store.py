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
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow import dataset

from ema_bench_replay.errors import InputError

from .results import DONE, FAILED, SCHEMA, SCHEMA_VERSION

if TYPE_CHECKING:
    import duckdb

FOLDER = "results"
_MANY_FILES = 8  # number of a unit's files from which they are merged
_PART = ".part"
_TRIES = 5  # attempts to read while another process merges files
_LATEST = f"""
SELECT * EXCLUDE (whole)
FROM (SELECT *, bool_and(status = '{DONE}') OVER (PARTITION BY key, done_at) AS whole FROM written)
QUALIFY rank() OVER (PARTITION BY key ORDER BY whole DESC, done_at DESC) = 1
"""
"""The rows of each job's latest try; a try that was done counts before a later one that was not."""
_RESULTS = f"""
CREATE VIEW results AS
SELECT * FROM ({_LATEST})
QUALIFY row_number() OVER (PARTITION BY unit, name, task, model ORDER BY done_at DESC) = 1
"""
"""Of each job its latest rows; of a changed recording, those of the latest job."""
_ONE_SCAN = """
SELECT string_agg(name) FROM duckdb_optimizers()
WHERE name IN ('window_self_join', 'late_materialization', 'top_n_window_elimination')
"""
"""DuckDB's optimizers that would read all files once more for each window: of 1e5 rows, 1.1 s instead of 0.7 s."""


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
        whole = f"SELECT key FROM written GROUP BY key, done_at HAVING bool_and(status != '{FAILED}')"
        return {row["key"] for row in self._asked(whole)}

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
                table = _latest(_table_of(files))
            except FileNotFoundError:
                continue
            self._write(table, table["unit"][0].as_py())
            for file in files:
                with suppress(FileNotFoundError):
                    file.unlink()

    @contextmanager
    def query(self) -> Iterator[duckdb.DuckDBPyConnection]:
        """Yield a database with the view ``results``: each job's latest try that was done, else its latest."""
        import duckdb

        with duckdb.connect() as database:
            database.execute("SET autoinstall_known_extensions = false; SET autoload_known_extensions = false")
            database.execute("SET TimeZone = 'UTC'; SET enable_progress_bar = false")
            pattern = f"{self._files}/*/*.parquet".replace("'", "''")
            database.execute(
                f"CREATE VIEW written AS SELECT * FROM read_parquet('{pattern}', hive_partitioning = false)"
            )
            database.execute(_RESULTS)
            database.execute(f"SET disabled_optimizers = '{database.sql(_ONE_SCAN).fetchall()[0][0] or ''}'")
            yield database

    def rows(self) -> list[dict[str, Any]]:
        """The rows of the view ``results``, by unit, time and name."""
        return self._asked("SELECT * FROM results ORDER BY unit, time NULLS LAST, name")

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

    def _asked(self, sql: str) -> list[dict[str, Any]]:
        """The rows that a statement selects. Raises InputError if a file is damaged."""
        import duckdb

        for _ in range(_TRIES):
            if next(self._each(), None) is None:
                return []
            try:
                with self.query() as database:
                    return list(database.sql(sql).to_arrow_table().to_pylist())
            except duckdb.Error:  # a listed file was merged with others meanwhile; if one is damaged, this names it
                with suppress(FileNotFoundError):
                    _table_of([*self._each()])
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


def _table_of(files: Sequence[Path]) -> pa.Table:
    """All rows of these files. Raises InputError if one is damaged, FileNotFoundError if one has gone."""
    try:
        return dataset.dataset([str(file) for file in files], SCHEMA, "parquet").to_table().combine_chunks()
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


def _latest(written: pa.Table) -> pa.Table:
    """The latest rows of each job, each once, even if others have merged the same files."""
    import duckdb

    with duckdb.connect() as database:
        database.register("written", written)
        return database.sql(f"SELECT DISTINCT ON (key, name) * FROM ({_LATEST})").to_arrow_table().cast(SCHEMA)
