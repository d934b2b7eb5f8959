"""The journal's file: a SQLite database with one row for each fact of where a mission stands.

SQLite appends a transaction to ``FILE-wal``. The kernel has it when :meth:`Journal.write` returns,
so the death of the process loses none. At 1000 pages (4 MB), and when the journal is closed, SQLite
moves the transactions to ``FILE``; only then does it wait for the disk (``synchronous=NORMAL``). A
loss of power may therefore lose the last transactions, but never a part of one.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import sqlite3
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from py_trees.common import Status
from pydantic import Field, TypeAdapter, ValidationError

from bt_mission.base.errors import BtMissionError
from bt_mission.base.verdicts import RequirementResult

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission

Key: TypeAlias = tuple[str, str]
"""Of a row: a field of :class:`JournalState`, and a name in it."""
Pack: TypeAlias = Callable[[Any], Any]
"""Returns a message as JSON; None for any other object."""
Unpack: TypeAlias = Callable[[Any], Any]

VERSION = 1
"""Of what the rows mean."""

SHORTEST = 512
"""Bytes of a database with one page. SQLite takes a file of a few bytes for an empty one."""

_TABLE = (
    "CREATE TABLE state (kind TEXT, name TEXT, value TEXT, checksum INTEGER, "
    "PRIMARY KEY (kind, name)) WITHOUT ROWID"
)
"""Values are JSON."""

_to_json = json.JSONEncoder(separators=(",", ":")).encode
"""A shared encoder: `json.dumps` with separators makes a new one at each call."""


@dataclass(frozen=True)
class Head:
    """Whose journal it is.

    Attributes:
        sources: SHA-256 of the mission's files, in hexadecimal.
    """

    mission: str
    sources: str
    inputs: dict[str, Any]
    seed: int
    namespace: str


@dataclass(frozen=True)
class End:
    """The end of a mission."""

    status: str
    reason: str


@dataclass(frozen=True)
class Sources:
    """The files of a mission.

    Attributes:
        file: The name of its file.
        texts: The texts of its file and of those that it includes, by name.
    """

    file: str
    texts: dict[str, str]


@dataclass(frozen=True)
class About:
    """The mission as a whole.

    Attributes:
        time_ns: ROS time of the newest transaction.
        end: None while the mission has not ended.
        revision: The files of the newest version; None if the mission was not revised.
    """

    head: Head
    time_ns: int = 0
    end: End | None = None
    revision: Sources | None = None


@dataclass(frozen=True)
class NodeState:
    """A node's status and memory at a ROS time in ns."""

    status: Status
    memory: dict[str, Any]
    saved_ns: int


@dataclass(frozen=True)
class OpenGoal:
    """A goal whose end is not confirmed: its action, its type, and the name of its leaf."""

    action: str
    type: str
    owner: str


@dataclass(frozen=True)
class JournalState:
    """The state of a mission in its journal.

    Attributes:
        about: The mission as a whole.
        nodes: By path.
        variables: As JSON, by ``PATH/NAME``. The path is that of the named tree that has the
            variable; it is empty for the mission itself.
        generators: States of the random generators, by name.
        goals: By UUID, in hexadecimal.
        requirements: By name.
    """

    about: About
    nodes: dict[str, NodeState] = field(default_factory=dict)
    variables: dict[str, Any] = field(default_factory=dict)
    generators: dict[str, tuple[int, str, float | None]] = field(default_factory=dict)
    goals: dict[Annotated[str, Field(pattern="^[0-9a-f]{32}$")], OpenGoal] = field(
        default_factory=dict
    )
    requirements: dict[str, RequirementResult] = field(default_factory=dict)


class Journal:
    """A journal that is open. No other process can open it meanwhile.

    Use :meth:`begin` or :meth:`resume` before :meth:`write`.

    Args:
        path: Of the file.
        must_exist: If not, a missing file is created.

    Raises:
        BtMissionError: If it cannot be opened, is in use, or is not a journal.
    """

    def __init__(self, path: Path, *, must_exist: bool = False) -> None:
        self.path = path
        try:
            target = Path(os.path.realpath(path))
            if must_exist and not target.exists():
                raise self._nothing_there()
            for link in (Path(f"{target}-wal"), Path(f"{target}-journal")):
                if link.is_symlink():
                    raise BtMissionError(
                        f"{link}: a symbolic link beside a journal; delete it", code="BT-906"
                    )
            if target.exists() and not target.is_file():
                raise BtMissionError(
                    f"{path}: cannot open the journal: not a regular file", code="BT-906"
                )
            if target.exists() and 0 < target.stat().st_size < SHORTEST:
                raise BtMissionError(f"{path}: not a journal", code="BT-906")
            self._database = sqlite3.connect(target, timeout=0, isolation_level=None)
        except (sqlite3.Error, OSError, ValueError) as error:
            raise self._not_opened(error) from error
        try:
            self._is_empty = self._prepare()
        except BaseException as error:
            self._database.close()
            if isinstance(error, sqlite3.Error):
                raise self._not_opened(error) from error
            raise

    def begin(self, mission: Mission, namespace: str) -> None:
        """Start the journal of a mission.

        Raises:
            BtMissionError: If the file has a mission that has not ended, or cannot be read or
                written.
        """
        if not self._is_empty and self._read().about.end is None:
            raise BtMissionError(
                f"{self.path}: the mission of this journal has not ended; continue it with "
                "--resume, or delete the file",
                code="BT-906",
            )
        with self._transaction():
            self._database.execute("DROP TABLE IF EXISTS state")
            self._database.execute(_TABLE)
            self._database.execute(f"PRAGMA user_version={VERSION}")
            self._put({("about", "head"): asdict(_head_of(mission, namespace))})

    def resume(self, mission: Mission, namespace: str) -> JournalState:
        """Return the state of the mission.

        Raises:
            BtMissionError: If it is the journal of another mission, or of one that has ended, or
                cannot be read.
        """
        if self._is_empty:
            raise self._nothing_there()
        state = self._read()
        theirs, ours = state.about.head, _head_of(mission, namespace)
        if theirs.mission != ours.mission:
            raise BtMissionError(
                f"{self.path}: the journal of another mission, '{theirs.mission}'", code="BT-906"
            )
        if theirs.sources != ours.sources:
            raise BtMissionError(
                f"{self.path}: the mission file has changed since this journal was started",
                code="BT-906",
            )
        for key, option in (("inputs", "--set"), ("seed", "--seed"), ("namespace", "--namespace")):
            then, now = getattr(theirs, key), getattr(ours, key)
            if then != now:
                raise BtMissionError(
                    f"{self.path}: the journal of a run with a different {key}: {then!r}, not "
                    f"{now!r} ({option})",
                    code="BT-906",
                )
        if state.about.end is not None:
            ended = ": ".join(filter(None, (state.about.end.status, state.about.end.reason)))
            raise BtMissionError(
                f"{self.path}: this mission has ended: {ended}; start it again without --resume",
                code="BT-906",
            )
        return state

    def read(self) -> JournalState | None:
        """Return the state of its mission; None for a new file.

        Raises:
            BtMissionError: It cannot be read.
        """
        return None if self._is_empty else self._read()

    def write(self, rows: Mapping[Key, Any], gone: Iterable[Key] = ()) -> None:
        """Write and delete rows, all of them or none.

        Raises:
            BtMissionError: If they cannot be written.
        """
        with self._transaction():
            self._put(rows)
            self._database.executemany("DELETE FROM state WHERE kind = ? AND name = ?", gone)

    def close(self) -> None:
        """Let other processes open it."""
        self._database.close()

    # ---- inside --------------------------------------------------------------------------

    def _prepare(self) -> bool:
        """Lock the file. Return whether it is empty. Other files are not changed."""
        self._database.execute("PRAGMA locking_mode=EXCLUSIVE")
        self._database.execute("PRAGMA trusted_schema=OFF")
        tables = self._database.execute("SELECT sql FROM sqlite_master").fetchall()
        (version,) = self._database.execute("PRAGMA user_version").fetchone()
        if tables and (tables != [(_TABLE,)] or version != VERSION):
            raise BtMissionError(
                f"{self.path}: not a journal of this version of bt-mission", code="BT-906"
            )
        self._database.execute("PRAGMA synchronous=OFF")  # of a new file nothing can be lost yet
        self._database.execute("PRAGMA journal_mode=WAL")
        self._database.execute("PRAGMA synchronous=NORMAL")
        return not tables

    def _read(self) -> JournalState:
        kinds: dict[str, dict[str, Any]] = {}
        try:
            (check,) = self._database.execute("PRAGMA quick_check(1)").fetchone()
            if check != "ok":
                raise self._damaged(check)
            rows = self._database.execute("SELECT kind, name, value, checksum FROM state")
            for kind, name, value, checksum in rows:
                row = f"row {kind} {name!r}"
                try:
                    if checksum != _checksum(kind, name, value):
                        raise self._damaged(f"{row}: its checksum is wrong")
                    kinds.setdefault(kind, {})[name] = json.loads(value)
                except (TypeError, ValueError, RecursionError) as error:
                    raise self._damaged(f"{row}: not JSON") from error
        except sqlite3.Error as error:
            raise self._damaged(error) from error
        try:
            return TypeAdapter(JournalState).validate_python(kinds)
        except ValidationError as error:
            wrong = error.errors()[0]
            place = " ".join(map(str, wrong["loc"]))
            raise self._damaged(f"row {place}: {wrong['msg']}") from error

    def _put(self, rows: Mapping[Key, Any]) -> None:
        values = []
        for (kind, name), value in rows.items():
            text = _to_json(value)
            values.append((kind, name, text, _checksum(kind, name, text)))
        self._database.executemany("INSERT OR REPLACE INTO state VALUES (?, ?, ?, ?)", values)

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        try:
            with self._database:  # commits, or rolls back
                self._database.execute("BEGIN")
                yield
        except (sqlite3.Error, TypeError, ValueError, OverflowError, RecursionError) as error:
            raise BtMissionError(
                f"{self.path}: cannot write the journal: {error}", code="BT-906"
            ) from error

    def _not_opened(self, error: Exception) -> BtMissionError:
        code = getattr(error, "sqlite_errorcode", None)
        if code == sqlite3.SQLITE_BUSY:
            return BtMissionError(
                f"{self.path}: a running mission uses this journal", code="BT-906"
            )
        if code == sqlite3.SQLITE_NOTADB:
            return BtMissionError(f"{self.path}: not a journal", code="BT-906")
        if code == sqlite3.SQLITE_CORRUPT:
            return self._damaged(error)
        if code is not None:  # SQLite does not pass on the error of the system
            try:
                os.close(os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC))
            except OSError as reason:
                error = reason
        why = (error.strerror if isinstance(error, OSError) else None) or error
        return BtMissionError(f"{self.path}: cannot open the journal: {why}", code="BT-906")

    def _nothing_there(self) -> BtMissionError:
        return BtMissionError(f"{self.path}: there is no journal to resume from", code="BT-906")

    def _damaged(self, why: object) -> BtMissionError:
        return BtMissionError(
            f"{self.path}: damaged: {why}; delete the file and start the mission again, since "
            f"its progress is unknown",
            code="BT-906",
        )


def rows_of_version(mission: Mission, namespace: str) -> dict[Key, Any]:
    """Return the rows by which a journal knows the version of a revised mission."""
    texts = {document.file: document.text for document in mission.documents}
    return {
        ("about", "head"): asdict(_head_of(mission, namespace)),
        ("about", "revision"): asdict(Sources(mission.document.file, texts)),
    }


def _head_of(mission: Mission, namespace: str) -> Head:
    digest = hashlib.sha256()
    documents = dict.fromkeys(tree.document.lines for tree in mission.all_trees)
    for lines in documents:
        digest.update("\n".join(lines).encode() + b"\0")
    inputs = dict(mission.inputs)
    return Head(mission.name, digest.hexdigest(), inputs, mission.seed, namespace)


def _checksum(kind: str, name: str, value: str) -> int:
    return zlib.crc32(f"{kind}\0{name}\0{value}".encode())


# ---- values as JSON ------------------------------------------------------------------------


def encode(value: Any, pack: Pack) -> Any:
    """Return a value as JSON; for a value without a form in JSON, its type."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [encode(part, pack) for part in value]
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    packed = pack(value)
    return {"lost": type(value).__name__} if packed is None else {"message": packed}


def decode(name: str, data: Any, unpack: Unpack) -> Any:
    """Return the value of the variable ``name``.

    Raises:
        BtMissionError: For a value without a form in JSON.
    """
    if isinstance(data, list):
        return [decode(name, part, unpack) for part in data]
    if not isinstance(data, dict):
        return data
    if "bytes" in data:
        return bytes.fromhex(data["bytes"])
    if "lost" in data:
        raise BtMissionError(
            f"the variable '{name}' was a {data['lost']}, which no journal keeps", code="BT-906"
        )
    return unpack(data["message"])


def pack_generator(generator: random.Random) -> tuple[int, str, float | None]:
    """Return the state of a random generator."""
    version, state, gauss = generator.getstate()
    return version, struct.pack(f"<{len(state)}I", *state).hex(), gauss


def unpack_generator(generator: random.Random, data: tuple[int, str, float | None]) -> None:
    """Put a random generator into that state."""
    version, state, gauss = data
    raw = bytes.fromhex(state)
    generator.setstate((version, struct.unpack(f"<{len(raw) // 4}I", raw), gauss))
