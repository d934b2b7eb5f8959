"""The file of a journal: what is written is read, and a file that cannot be used is refused."""

from __future__ import annotations

import os
import random
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.journal.store import Journal, JournalState
from bt_mission.language.mission import Mission
from bt_mission.sessions.load import load

MISSION = "mission: m\nseed: 3\ninputs: {x: [1.5, 2]}\ntree: {wait: 10}\n"
NODE = {"status": "RUNNING", "memory": {"x": [0.1, float("inf")]}, "saved_ns": 2}
GOAL = {"action": "/turn", "type": "a/action/Turn", "owner": "turn"}


@pytest.fixture
def mission() -> Mission:
    """The mission of the journal."""
    return load(MISSION)


@pytest.fixture
def path(tmp_path: Path, mission: Mission) -> Path:
    """A journal that was written to, closed."""
    path = tmp_path / "m.journal"
    journal = Journal(path)
    journal.begin(mission, "/")
    journal.write({("nodes", "0"): {**NODE, "saved_ns": 1}, ("goals", "ab" * 16): GOAL})
    rows: dict[Any, Any] = {("about", "time_ns"): 2, ("nodes", "0"): NODE}
    journal.write({**rows, ("variables", "/x"): "ü\0"}, [("goals", "ab" * 16)])
    journal.close()
    return path


def read(path: Path) -> JournalState:
    """Where the mission stood."""
    journal = Journal(path, must_exist=True)
    try:
        return journal.resume(load(MISSION), "/")
    finally:
        journal.close()


def change(path: Path, statement: str, *values: Any) -> None:
    """Change the file as SQLite can."""
    database = sqlite3.connect(path, isolation_level=None)
    database.execute(statement, values)
    database.close()


def test_what_was_written_is_read(path: Path, mission: Mission) -> None:
    """The newest of each row, floats exactly; the next process continues there."""
    state = read(path)
    assert (state.about.time_ns, state.variables, state.goals) == (2, {"/x": "ü\0"}, {})
    assert state.nodes["0"].memory == {"x": [0.1, float("inf")]}
    journal = Journal(path)
    journal.resume(mission, "/")
    journal.write({("about", "time_ns"): 3})
    journal.close()
    assert read(path).about.time_ns == 3
    assert [file.name for file in path.parent.iterdir()] == ["m.journal"]


def test_every_byte_counts(path: Path) -> None:
    """Whichever is changed, the file is refused, or says the same as before."""
    sound, state = path.read_bytes(), read(path)
    refused = 0
    for place in [place for place, byte in enumerate(sound) if byte][::4]:
        changed = bytearray(sound)
        changed[place] ^= 1
        path.write_bytes(changed)
        try:
            assert read(path) == state
        except BtMissionError as error:
            refused += 1
            assert str(error).startswith(f"{path}: ")  # noqa: PT017 - both ways are right
    assert refused > 100


@pytest.mark.parametrize("length", [1, 99, 100, 511, 4095, 4096, 5000])
def test_a_file_that_was_cut_is_refused(path: Path, length: int) -> None:
    """Also where a page is whole."""
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(BtMissionError, match=r"m\.journal: (damaged: |not a journal)"):
        read(path)


def test_what_was_cut_off_beside_it_was_never_written(
    path: Path, mission: Mission, tmp_path: Path
) -> None:
    """Wherever the file of transactions ends, the state is that after one of them."""
    journal = Journal(path)
    journal.resume(mission, "/")
    for tick in range(3, 13):
        journal.write({("about", "time_ns"): tick, ("variables", "/x"): tick})
    copy, beside = tmp_path / "copy", Path(f"{path}-wal").read_bytes()
    seen = set()
    for length in range(0, len(beside) + 1, 499):
        copy.write_bytes(path.read_bytes())
        Path(f"{copy}-wal").write_bytes(beside[:length])
        state = read(copy)
        seen.add(state.about.time_ns)
        assert state.variables["/x"] == (state.about.time_ns if state.about.time_ns > 2 else "ü\0")
    journal.close()
    assert seen >= set(range(2, 12))


@pytest.mark.parametrize(
    "data", [b"\n", b"hello\n", b"\xff\x00\n", b"mission: m\ntree: {}\n", b"x" * 9000]
)
def test_another_file_is_refused(path: Path, mission: Mission, data: bytes) -> None:
    """It stays as it is, also for a mission that starts."""
    path.write_bytes(data)
    with pytest.raises(BtMissionError, match=r"m\.journal: not a journal$"):
        read(path)
    with pytest.raises(BtMissionError, match=r"m\.journal: not a journal$"):
        Journal(path)
    assert path.read_bytes() == data


def test_another_database_is_refused(tmp_path: Path) -> None:
    """It stays as it is; so does a journal of another version."""
    other = tmp_path / "other"
    change(other, "CREATE TABLE state (kind TEXT)")
    before = other.read_bytes()
    with pytest.raises(BtMissionError, match="not a journal of this version of bt-mission"):
        Journal(other)
    assert other.read_bytes() == before


@pytest.mark.parametrize("data", [None, b""])
def test_an_empty_file_is_no_journal_yet(tmp_path: Path, mission: Mission, data: Any) -> None:
    """A process that dies before the first transaction leaves one."""
    path = tmp_path / "j"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(BtMissionError, match="there is no journal to resume from"):
        read(path)
    journal = Journal(path)
    journal.begin(mission, "/")
    journal.close()
    assert read(path).about.head.mission == "m"


def put(path: Path, kind: str, name: str, value: object) -> None:
    """Write a row of any content."""
    journal = Journal(path)
    journal.write({(kind, name): value})
    journal.close()


@pytest.mark.parametrize(
    ("kind", "name", "value", "words"),
    [
        ("nodes", "0", {**NODE, "status": "ASLEEP"}, "row nodes 0 status: Input should be"),
        ("nodes", "0", {**NODE, "saved_ns": None}, "row nodes 0 saved_ns: Input should be"),
        ("nodes", "0", {**NODE, "memory": 7}, "row nodes 0 memory: Input should be"),
        ("nodes", "0", 7, "row nodes 0: Input should be"),
        ("goals", "up", GOAL, "row goals up"),
        ("goals", "ab" * 16, {"action": 1}, "row goals abab"),
        ("generators", "0", [3, "00"], "row generators 0 2: Field required"),
        ("requirements", "r", {"name": "r"}, "row requirements r requirement: Field required"),
        ("about", "time_ns", "soon", "row about time_ns: Input should be"),
        ("about", "time_ns", float("nan"), "row about time_ns: Input should be"),
        ("about", "end", [], "row about end: Input should be"),
        ("about", "head", {}, "row about head mission: Field required"),
    ],
)
def test_rows_of_wrong_types_are_refused(
    path: Path, kind: str, name: str, value: object, words: str
) -> None:
    """With the row and what is wrong about it, also where a mission starts."""
    put(path, kind, name, value)
    with pytest.raises(BtMissionError) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}: damaged: {words}")
    journal = Journal(path)
    with pytest.raises(BtMissionError, match="damaged: row"):
        journal.begin(load(MISSION), "/")
    journal.close()


CHANGE = "UPDATE state SET {} = ? WHERE kind = 'nodes'"
CORRUPT = "row .*(its checksum is wrong|not JSON)"


@pytest.mark.parametrize(
    ("statement", "value", "words"),
    [
        ("PRAGMA user_version=2", [], "not a journal of this version of bt-mission"),
        ("DELETE FROM state WHERE name = 'head'", [], "damaged: row about head: Field required"),
        ("UPDATE state SET value = CAST(x'ff22' AS TEXT)", [], "damaged: Could not decode"),
        *(
            (CHANGE.format(column), [value], f"damaged: {words}")
            for column, value, words in (
                ("value", None, CORRUPT),
                ("value", b"\xff", CORRUPT),
                ("value", 7, CORRUPT),
                ("value", "{}", "row .*its checksum is wrong"),
                ("checksum", "x", "row .*its checksum is wrong"),
                ("name", "1", "row .*its checksum is wrong"),
                ("name", b"\xff", CORRUPT),
                ("kind", 7, "row .*its checksum is wrong"),
            )
        ),
    ],
)
def test_a_changed_table_is_refused(path: Path, statement: str, value: Any, words: str) -> None:
    """Another version, a row that is missing, a column of whatever type."""
    change(path, statement, *value)
    with pytest.raises(BtMissionError, match=words):
        read(path)


def test_a_huge_value_is_kept(path: Path) -> None:
    """It fits as long as SQLite takes it; a value that it does not take is named."""
    put(path, "variables", "/x", "x" * 3_000_000)
    assert len(read(path).variables["/x"]) == 3_000_000
    journal = Journal(path)
    journal.resume(load(MISSION), "/")
    journal._database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 4_000_000)
    for value in (10**5000, object(), "x" * 4_000_001):
        with pytest.raises(BtMissionError, match=r"m\.journal: cannot write the journal: "):
            journal.write({("variables", "/x"): value})
    journal.close()
    assert len(read(path).variables["/x"]) == 3_000_000


def test_two_cannot_have_one_journal(path: Path, mission: Mission) -> None:
    """The second one is refused, before and after the first one writes."""
    journal = Journal(path)
    with pytest.raises(BtMissionError, match="a running mission uses this journal"):
        Journal(path)
    journal.resume(mission, "/")
    journal.write({("about", "time_ns"): 4})
    code = (
        "import sys, pathlib, bt_mission.executive.journal.store as store\n"
        "store.Journal(pathlib.Path(sys.argv[1]))"
    )
    command = [sys.executable, "-c", code, str(path)]
    other = subprocess.run(command, check=False, capture_output=True, text=True)
    assert "a running mission uses this journal" in other.stderr
    journal.close()
    assert read(path).about.time_ns == 4


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("no/such/folder/j", "No such file or directory"),
        (".", "not a regular file"),
        ("a\0b", "embedded null"),
        ("pipe", "not a regular file"),
        ("loop", "Too many levels of symbolic links"),
        ("x" * 300, "File name too long"),
    ],
)
def test_a_place_that_cannot_be_used(tmp_path: Path, name: str, why: str) -> None:
    """A line with the reason."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(BtMissionError, match=f"cannot open the journal: .*{why}"):
        Journal(tmp_path / name)


def test_links(path: Path, tmp_path: Path) -> None:
    """A link to the journal is followed; one where SQLite writes beside it is not."""
    (tmp_path / "link").symlink_to(path)
    assert read(tmp_path / "link") == read(path)
    Path(f"{path}-wal").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(BtMissionError, match="-wal: a symbolic link beside a journal"):
        read(path)
    assert not (tmp_path / "elsewhere").exists()


def test_a_full_disk(path: Path, mission: Mission) -> None:
    """What does not fit is not written at all; what was written before is read."""
    journal = Journal(path)
    journal.resume(mission, "/")
    journal._database.execute("PRAGMA max_page_count=4")
    with pytest.raises(BtMissionError, match="cannot write the journal: database or disk is full"):
        journal.write({("about", "time_ns"): 9, ("variables", "/x"): "x" * 99_999})
    journal.close()
    assert (read(path).about.time_ns, read(path).variables) == (2, {"/x": "ü\0"})


WRITER = """
import sys, pathlib
from bt_mission.executive.journal.store import Journal
from bt_mission.sessions.load import load
journal = Journal(pathlib.Path(sys.argv[1]))
number = journal.resume(load(sys.argv[2]), "/").about.time_ns
while True:
    number += 1
    rows = {("variables", f"/{name}"): [number, "x" * (number % 50_000)] for name in "ab"}
    journal.write({("about", "time_ns"): number, **rows})
    print(number, flush=True)
"""


@pytest.mark.thorough
@pytest.mark.process
def test_a_process_that_is_killed_loses_nothing(path: Path) -> None:
    """Wherever it is in a transaction, and while SQLite moves transactions to the file."""
    drawn = random.Random(4)
    for _ in range(8):
        command = [sys.executable, "-c", WRITER, str(path), MISSION]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
            assert writer.stdout is not None
            for _ in range(drawn.randrange(1, 700)):
                written = int(writer.stdout.readline())
            writer.kill()
            written = max([written, *(int(line) for line in writer.stdout)])
        state = read(path)
        assert state.about.time_ns in (written, written + 1)
        assert {state.variables[f"/{name}"][0] for name in "ab"} == {state.about.time_ns}
