"""The results of a sweep: a SQLite file that has each row as soon as it is known.

SQLite rather than Parquet: a row is appended and durable at once, a process that is killed in the
middle loses none, and pandas, DuckDB, R and spreadsheets read it. (A Parquet file is written as a
whole; ``COPY (SELECT * FROM scenarios) TO 'sweep.parquet'`` in DuckDB makes one.)
"""

from __future__ import annotations

import fcntl
import json
import sqlite3
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from bt_mission.sweeps.folder import StoreError, within
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.row_reader import JSON, RowError, row_of_columns

FILE = "results.sqlite"
LOCK = "lock"
FORMAT = 2
"""Version of the tables."""

_NAMES = tuple(one.name for one in fields(ScenarioRow))
_TYPES = {"int": "INTEGER", "bool": "INTEGER", "float": "REAL"}
_BESIDE = ("", "-wal", "-shm", "-journal")
"""Ends of the names of the file and of those that SQLite opens beside it."""


class ResultStore:
    """The rows of a sweep in a folder.

    Args:
        folder: Of the results.
        about: What the sweep is, as JSON has it: equal for the same sweep only.

    Use :meth:`create`, :meth:`resume` or :meth:`read`.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection, lock: Any = None) -> None:
        self.folder = folder
        self._connection = connection
        self._lock = lock

    # ---- opening -------------------------------------------------------------------------

    @classmethod
    def create(cls, folder: Path, about: Mapping[str, Any]) -> Self:
        """Begin a new one.

        Raises:
            StoreError: Where there are results already, or they cannot be written.
        """
        store = cls._writable(folder)
        if store.is_empty or store.has_no_rows:
            return store.begin(about)
        store.close()
        raise StoreError(
            f"{folder}: has results of a sweep; add --resume to go on with it, or name another "
            "folder with -o"
        )

    @property
    def is_empty(self) -> bool:
        """Was the file just made, or its maker killed before it had begun?"""
        found = self._connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
        return not found[0]

    @property
    def has_no_rows(self) -> bool:
        """Are these results of ours in which nothing is, since no worker could be used, say?"""
        self.check_format()
        return not self._connection.execute("SELECT count(*) FROM scenarios").fetchone()[0]

    def begin(self, about: Mapping[str, Any]) -> Self:
        """Make the tables."""
        columns = ", ".join(
            f"{one.name} {_column(str(one.type))}{' PRIMARY KEY' if one.name == 'id' else ''}"
            for one in fields(ScenarioRow)
        )
        with self._transaction("begin the results") as connection:
            connection.execute(f"CREATE TABLE IF NOT EXISTS scenarios ({columns}) WITHOUT ROWID")
            connection.execute(
                "CREATE TABLE IF NOT EXISTS about (key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID"
            )
            connection.executemany(
                "INSERT OR REPLACE INTO about VALUES (?, ?)",
                [("format", str(FORMAT)), ("sweep", json.dumps(about, sort_keys=True))],
            )
        return self

    @classmethod
    def resume(cls, folder: Path, about: Mapping[str, Any]) -> Self:
        """Go on with the results of the same sweep.

        Raises:
            StoreError: For results of another sweep, with what differs.
        """
        store = cls._writable(folder)
        if store.is_empty:
            return store.begin(about)
        try:
            store.check_format()
            _refuse_other(folder, store.about, json.loads(json.dumps(about)))
        except BaseException:
            store.close()
            raise
        return store

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Open results to read them, also while a sweep writes.

        Raises:
            StoreError: Where there are none.
        """
        file = folder / FILE if folder.is_dir() else folder
        if not file.is_file():
            raise StoreError(f"{folder}: no results of a sweep are there (no {FILE})")
        if folder.is_dir():
            _refuse_links(folder)
        connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
        # Text that is no UTF-8 must not end the reading without the row's name.
        connection.text_factory = lambda data: data.decode(errors="replace")
        store = cls(file.parent, connection)
        store.check_format()
        return store

    @classmethod
    def _writable(cls, folder: Path) -> Self:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _refuse_links(folder)
            lock = within(folder, LOCK).open("w")
        except OSError as error:
            raise StoreError(f"cannot write {folder}: {error.strerror or error}") from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            lock.close()
            raise StoreError(f"{folder}: another sweep writes its results there") from error
        try:
            connection = sqlite3.connect(folder / FILE, isolation_level=None)
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=NORMAL")
        except sqlite3.Error as error:
            lock.close()
            raise StoreError(f"{folder / FILE}: {error}") from error
        return cls(folder, connection, lock)

    def check_format(self) -> None:
        """Refuse what is no file of ours, or of another version. Raises StoreError."""
        try:
            found = self._connection.execute("SELECT value FROM about WHERE key = 'format'")
            row = found.fetchone()
        except sqlite3.Error as error:
            self.close()
            raise StoreError(f"{self.folder}: not results of a sweep ({error})") from error
        if row is None or row[0] != str(FORMAT):
            self.close()
            got = "no version" if row is None else f"version {row[0]}"
            raise StoreError(f"{self.folder}: results of {got}; this bt-mission has {FORMAT}")

    # ---- rows ----------------------------------------------------------------------------

    @property
    def about(self) -> dict[str, Any]:
        """What the sweep is."""
        text = self.value("sweep")
        try:
            found = {} if text is None else json.loads(text)
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict) or not _is_about(found):
            raise StoreError(f"{self.folder / FILE}: the description of the sweep cannot be read")
        return found

    def value(self, key: str) -> str | None:
        """A value beside the rows; None where there is none."""
        found = self._connection.execute("SELECT value FROM about WHERE key = ?", (key,)).fetchone()
        return None if found is None else str(found[0])

    def set_value(self, key: str, value: str) -> None:
        """Keep a value beside the rows."""
        with self._transaction("write a value") as connection:
            connection.execute("INSERT OR REPLACE INTO about VALUES (?, ?)", (key, value))

    def add(self, row: ScenarioRow) -> None:
        """Append a row; it is there when this returns. One with the same id is replaced.

        Raises:
            StoreError: Where it cannot be written, on a full disk, say.
        """
        given = asdict(row)
        values = [json.dumps(given[key]) if key in JSON else given[key] for key in _NAMES]
        marks = ", ".join("?" * len(values))
        with self._transaction("write a row") as connection:
            connection.execute(f"INSERT OR REPLACE INTO scenarios VALUES ({marks})", values)  # noqa: S608 - question marks only

    def ids(self, *, without_errors: bool = False) -> set[str]:
        """The ids of all rows, or of those of scenarios that could run."""
        query = "SELECT id FROM scenarios"
        if without_errors:
            query += " WHERE outcome != 'error'"
        return {one for (one,) in self._connection.execute(query)}

    def rows(self, where: str = "", *values: Any) -> Iterator[ScenarioRow]:
        """All rows, in the order of their numbers.

        Args:
            where: A condition in SQL, ours alone, with ``?`` for the values.
        """
        condition = f" WHERE {where}" if where else ""
        query = f"SELECT {', '.join(_NAMES)} FROM scenarios{condition} ORDER BY number, id"  # noqa: S608 - no text of a user's
        try:
            for found in self._connection.execute(query, values):
                yield self._row(dict(zip(_NAMES, found, strict=True)))
        except sqlite3.DatabaseError as error:
            raise StoreError(f"{self.folder / FILE}: {error}") from error

    def _row(self, found: Mapping[str, Any]) -> ScenarioRow:
        try:
            return row_of_columns(found)
        except RowError as error:
            row = f"row {found['number']!r} (id {found['id']!r})"
            raise StoreError(f"{self.folder / FILE}: {row}: {error}") from None

    # ---- ends ----------------------------------------------------------------------------

    def _transaction(self, what: str) -> _Transaction:
        return _Transaction(self._connection, self.folder / FILE, what)

    def close(self) -> None:
        """Close the file, and let others write."""
        self._connection.close()
        if self._lock is not None:
            self._lock.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _Transaction:
    """All of it, or nothing; an error of SQLite is told in our words."""

    def __init__(self, connection: sqlite3.Connection, file: Path, what: str) -> None:
        self._connection = connection
        self._file = file
        self._what = what

    def __enter__(self) -> sqlite3.Connection:
        self._connection.execute("BEGIN IMMEDIATE")
        return self._connection

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        try:
            self._connection.execute("COMMIT" if error is None else "ROLLBACK")
        except sqlite3.Error as broken:
            error = error or broken
        if isinstance(error, sqlite3.Error):
            raise StoreError(f"{self._file}: cannot {self._what}: {error}") from error


def _column(written: str) -> str:
    return _TYPES.get(written.partition(" ")[0], "TEXT")


def _refuse_links(folder: Path) -> None:
    for end in _BESIDE:
        within(folder, f"{FILE}{end}")


def _is_about(found: Mapping[str, Any]) -> bool:
    """Is it what a plan writes of itself, as far as anybody reads it?"""
    kinds = {"vary": list, "plans": dict, "scenario": dict}
    return (
        all(isinstance(found.get(name, kind()), kind) for name, kind in kinds.items())
        and isinstance(found.get("scenario", {}).get("inputs", {}), dict)
        and all(isinstance(one, list) for one in found.get("plans", {}).values())
        and isinstance(found.get("scenarios", 0), int)
        and isinstance(found.get("sample"), int | None)
        and isinstance(found.get("seeds"), str | None)
        and all(isinstance(found.get(name, ""), str) for name in ("mission", "mission_hash"))
    )


def _refuse_other(folder: Path, then: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    differing = sorted(key for key in {*then, *now} if then.get(key) != now.get(key))
    if not differing:
        return
    told = "; ".join(
        f"{key} was {_short(then.get(key))}, is {_short(now.get(key))}" for key in differing
    )
    raise StoreError(
        f"{folder}: has results of another sweep ({told}); name another folder with -o"
    )


def _short(value: Any, most: int = 60) -> str:
    text = json.dumps(value)
    return text if len(text) <= most else f"{text[: most - 1]}…"
