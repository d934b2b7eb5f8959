"""The results of a sweep: a SQLite file that has each row as soon as it is known, and CSV of it.

SQLite rather than Parquet: a row is appended and durable at once, a process that is killed in the
middle loses none, and pandas, DuckDB, R and spreadsheets read it. (A Parquet file is written as a
whole; ``COPY (SELECT * FROM scenarios) TO 'sweep.parquet'`` in DuckDB makes one.)
"""

from __future__ import annotations

import csv
import fcntl
import json
import re
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, Self, TextIO

from pydantic import AfterValidator, ConfigDict, TypeAdapter, ValidationError

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import within
from bt_mission.base.text import cut, escape_lines
from bt_mission.scenarios.concrete.row import ScenarioRow, row_of_columns

FILE = "results.sqlite"
LOCK = "lock"
FORMAT = 3
"""Version of the tables."""
RECORDINGS = "recordings"
"""The folder of the results for recordings of single scenarios, named by their ids."""
VERSIONS = "versions"
"""The prefix of the keys of full versions; a fingerprint follows."""

_COLUMNS = {column.name: str(column.type) for column in fields(ScenarioRow)}
_NAMES = ", ".join(_COLUMNS)
_TYPES = {"int": "INTEGER", "bool": "INTEGER", "float": "REAL"}
_BESIDE = ("", "-wal", "-shm", "-journal")
"""Ends of the names of the file and of those that SQLite opens beside it."""


def _scenario(value: dict[str, Any]) -> dict[str, Any]:
    if not isinstance(value.get("inputs", {}), dict):
        raise ValueError("inputs are a mapping")  # noqa: TRY004 - pydantic takes a ValueError
    return value


@dataclass(frozen=True)
class SweepAbout:
    """What a sweep is: equal for the same sweep only.

    Attributes:
        mission: Its name; file: that of its file.
        mission_hash: SHA-256 of all files.
        scenario: The base that is varied, as a scenario file has it.
        vary: The parameters, as texts.
        sample: The number of draws; None is every combination.
        seeds: None is the mission's own.
        plans: Faults by the names of plans.
        scenarios: How many there are.
    """

    __pydantic_config__ = ConfigDict(extra="forbid", strict=True)

    mission: str = ""
    file: str = ""
    mission_hash: str = ""
    scenario: Annotated[dict[str, Any], AfterValidator(_scenario)] = field(default_factory=dict)
    vary: list[str] = field(default_factory=list)
    sample: int | None = None
    sample_seed: int = 0
    seeds: str | None = None
    plans: dict[str, list[Any]] = field(default_factory=dict)
    scenarios: int = 0


class ResultStore:
    """The rows of a sweep in a folder.

    Use :meth:`create`, :meth:`resume` or :meth:`read`.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection, lock: Any = None) -> None:
        self.folder = folder
        self._connection = connection
        self._lock = lock

    # ---- opening -------------------------------------------------------------------------

    @classmethod
    def create(cls, folder: Path, about: SweepAbout) -> Self:
        """Begin a new one.

        Raises:
            BtMissionError: There are results already, or they cannot be written.
        """
        store = cls._writable(folder)
        if store.is_empty:
            return store.begin(about)
        store.close()
        raise BtMissionError(
            f"{folder}: contains results of a sweep; add --resume to continue it, or choose "
            f"another folder with -o",
            code="BT-714",
        )

    @classmethod
    def resume(cls, folder: Path, about: SweepAbout) -> Self:
        """Continue the results of the same sweep.

        Raises:
            BtMissionError: For results of another sweep, with what differs.
        """
        store = cls._writable(folder)
        if store.is_empty:
            return store.begin(about)
        try:
            _refuse_other(folder, store.about, about)
        except BaseException:
            store.close()
            raise
        return store

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Open results to read them, also while a sweep writes.

        Raises:
            BtMissionError: The folder has no results.
        """
        file = folder / FILE if folder.is_dir() else folder
        if not file.is_file():
            raise BtMissionError(
                f"{folder}: contains no results of a sweep (no {FILE})", code="BT-714"
            )
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
            raise BtMissionError(
                f"cannot write {folder}: {error.strerror or error}", code="BT-1103"
            ) from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            lock.close()
            raise BtMissionError(
                f"{folder}: another sweep is writing its results there", code="BT-714"
            ) from error
        try:
            connection = sqlite3.connect(folder / FILE, isolation_level=None)
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=NORMAL")
        except sqlite3.Error as error:
            lock.close()
            raise BtMissionError(f"{folder / FILE}: {error}", code="BT-714") from error
        return cls(folder, connection, lock)

    @property
    def is_empty(self) -> bool:
        """Whether it has no rows, for example because no worker could be used."""
        if not self._read("SELECT 1 FROM sqlite_master"):
            return True
        self.check_format()
        return not self._read("SELECT 1 FROM scenarios LIMIT 1")

    def begin(self, about: SweepAbout) -> Self:
        """Make the tables."""
        columns = ", ".join(
            f"{name} {_TYPES.get(kind.partition(' ')[0], 'TEXT')}"
            for name, kind in _COLUMNS.items()
        )
        with self._writing("begin the results"):
            self._connection.execute(
                f"CREATE TABLE IF NOT EXISTS scenarios ({columns}, PRIMARY KEY (id)) WITHOUT ROWID"
            )
            self._connection.execute(
                "CREATE TABLE IF NOT EXISTS about (key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID"
            )
            self._connection.executemany(
                "INSERT OR REPLACE INTO about VALUES (?, ?)",
                [("format", str(FORMAT)), ("sweep", json.dumps(asdict(about), sort_keys=True))],
            )
        return self

    def check_format(self) -> None:
        """Refuse a file of another program or another version. Raises BtMissionError."""
        try:
            version = self.value("format")
        except BtMissionError as error:
            self.close()
            raise BtMissionError(
                f"{self.folder}: not results of a sweep ({error.__cause__})", code="BT-714"
            ) from error
        if version != str(FORMAT):
            self.close()
            got = "no version" if version is None else f"version {version}"
            raise BtMissionError(
                f"{self.folder}: results of {got}; this bt-mission has {FORMAT}", code="BT-714"
            )

    # ---- rows ----------------------------------------------------------------------------

    @property
    def about(self) -> SweepAbout:
        """The identity of the sweep."""
        try:
            return TypeAdapter(SweepAbout).validate_json(self.value("sweep") or "{}")
        except ValidationError:
            message = "the description of the sweep cannot be read"
            raise BtMissionError(f"{self.folder / FILE}: {message}", code="BT-714") from None

    def value(self, key: str) -> str | None:
        """Return a value beside the rows; None without one."""
        rows = self._read("SELECT value FROM about WHERE key = ?", key)
        return str(rows[0][0]) if rows else None

    def set_value(self, key: str, value: str) -> None:
        """Keep a value beside the rows."""
        with self._writing("write a value"):
            self._connection.execute("INSERT OR REPLACE INTO about VALUES (?, ?)", (key, value))

    def add(self, row: ScenarioRow) -> None:
        """Append a row; it is durable when this returns. One with the same id is replaced.

        Raises:
            BtMissionError: It cannot be written, for example on a full disk.
        """
        values = [
            json.dumps(cell) if isinstance(cell, dict | tuple) else cell
            for cell in asdict(row).values()
        ]
        marks = ", ".join("?" * len(values))
        with self._writing("write a row"):
            self._connection.execute(f"INSERT OR REPLACE INTO scenarios VALUES ({marks})", values)  # noqa: S608 - question marks only

    def ids(self, *, without_errors: bool = False) -> set[str]:
        """Return the ids of all rows, or of those of scenarios that could run."""
        condition = " WHERE outcome != 'error'" if without_errors else ""
        query = f"SELECT id FROM scenarios{condition}"  # noqa: S608 - no text of a user's
        return {row_id for (row_id,) in self._read(query)}

    def rows(self, where: str = "", *values: Any) -> Iterator[ScenarioRow]:
        """Yield all rows, in the order of their numbers.

        Args:
            where: A condition in SQL, from our code only, with ``?`` for the values.
        """
        condition = f" WHERE {where}" if where else ""
        query = f"SELECT {_NAMES} FROM scenarios{condition} ORDER BY number, id"  # noqa: S608 - no text of a user's
        try:
            for cells in self._connection.execute(query, values):
                columns = dict(zip(_COLUMNS, cells, strict=True))
                try:
                    yield row_of_columns(columns)
                except ValueError as error:
                    row = f"row {columns['number']!r} (id {columns['id']!r})"
                    raise BtMissionError(
                        f"{self.folder / FILE}: {row}: {error}", code="BT-714"
                    ) from None
        except sqlite3.DatabaseError as error:
            raise BtMissionError(f"{self.folder / FILE}: {error}", code="BT-714") from error

    # ---- ends ----------------------------------------------------------------------------

    def _read(self, query: str, *values: Any) -> list[Any]:
        """Return the rows of a query; close the file where it cannot be read.

        Raises:
            BtMissionError: It cannot be read, for example on a full disk.
        """
        try:
            return self._connection.execute(query, values).fetchall()
        except sqlite3.Error as error:
            self.close()
            raise BtMissionError(f"{self.folder / FILE}: {error}", code="BT-714") from error

    @contextmanager
    def _writing(self, what: str) -> Iterator[None]:
        """Write all of it, or nothing."""
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            with self._connection:  # commits, or rolls back
                yield
        except sqlite3.Error as error:
            raise BtMissionError(
                f"{self.folder / FILE}: cannot {what}: {error}", code="BT-714"
            ) from error

    def close(self) -> None:
        """Close the file, and let others write."""
        self._connection.close()
        if self._lock is not None:
            self._lock.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _refuse_links(folder: Path) -> None:
    for end in _BESIDE:
        within(folder, f"{FILE}{end}")


def _refuse_other(folder: Path, then: SweepAbout, now: SweepAbout) -> None:
    there, here = vars(then), json.loads(json.dumps(asdict(now)))
    differing = [
        f"{key} was {cut(json.dumps(there[key]), 60)}, is {cut(json.dumps(here[key]), 60)}"
        for key in sorted(here)
        if there[key] != here[key]
    ]
    if differing:
        differences = "; ".join(differing)
        raise BtMissionError(
            f"{folder}: contains results of another sweep ({differences}); choose another folder "
            f"with -o",
            code="BT-714",
        )


# ---- CSV --------------------------------------------------------------------------------------

_NESTED = {"parameters": "parameter", "nature": "nature", "requirements": ""}
_PLAIN = tuple(name for name in _COLUMNS if name not in _NESTED)
_FORMULA = re.compile(r"[=+\-@\t\r\n]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)


def write_csv(rows: Callable[[], Iterable[ScenarioRow]], file: TextIO) -> None:
    """Write a line for each row, as RFC 4180 has it.

    Each parameter has a column ``parameter.NAME``, each quantity of nature ``nature.NAME``, each
    requirement ``verdict.NAME`` and ``margin.NAME``. Columns and rows have the same order for the
    same results.

    A text that a spreadsheet would take for a formula has an apostrophe before it: reasons may come
    from servers and missions of others. (OWASP, "CSV Injection".)

    Args:
        rows: Gives them from the first on, each time that it is called.
        file: Opened with ``newline=""``.
    """
    names: dict[str, dict[str, None]] = {key: {} for key in _NESTED}
    for row in rows():
        for key in _NESTED:
            names[key] |= dict.fromkeys(getattr(row, key))
    head = [f"{_NESTED[key]}.{name}" for key in ("parameters", "nature") for name in names[key]]
    head += [f"{what}.{name}" for name in names["requirements"] for what in ("verdict", "margin")]
    writer = csv.writer(file)
    writer.writerow([*_PLAIN, *map(_cell, head)])
    for row in rows():
        cells = [getattr(row, name) for name in _PLAIN]
        cells += [row.parameters.get(name) for name in names["parameters"]]
        cells += [row.nature.get(name) for name in names["nature"]]
        for name in names["requirements"]:
            requirement = row.requirements.get(name)
            cells += [requirement and requirement.verdict, requirement and requirement.margin]
        writer.writerow(map(_cell, cells))


def _cell(value: Any) -> Any:
    match value:
        case bool():
            return str(value).lower()
        case str():
            shown = escape_lines(value)
            is_formula = _FORMULA.match(value) and not _NUMBER.fullmatch(value)
            return f"'{shown}" if is_formula else shown
        case list() | tuple() | Mapping():
            return json.dumps(value) if value else ""
    return value
