"""Records on disk: appended, read, torn, changed, written anew, locked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.core.errors import BtMissionError
from bt_mission.executive.journal.file import FORMAT, JournalFile

HEAD: dict[str, Any] = {"format": FORMAT}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A journal of three records, closed."""
    path = tmp_path / "m.journal"
    file = JournalFile(path)
    file.rewrite([HEAD])
    file.append({"t": 1})
    file.append({"t": 2, "nodes": {"0": ["RUNNING", {"x": [0.1, float("inf")]}, 2]}})
    file.close()
    return path


def read(path: Path) -> list[dict[str, Any]]:
    """Every record."""
    file = JournalFile(path)
    try:
        return file.read()
    finally:
        file.close()


def test_what_was_appended_is_read(path: Path) -> None:
    """In order, floats exactly; another process goes on behind it."""
    assert read(path)[1:] == [
        {"t": 1},
        {"t": 2, "nodes": {"0": ["RUNNING", {"x": [0.1, float("inf")]}, 2]}},
    ]
    file = JournalFile(path)
    file.read()
    file.append({"t": 3})
    file.close()
    assert [record.get("t") for record in read(path)] == [None, 1, 2, 3]


def test_every_byte_counts(path: Path) -> None:
    """Whichever is changed, the file is refused, with the line."""
    sound = path.read_bytes()
    for place in range(len(sound)):
        torn = bytearray(sound)
        torn[place] ^= 1
        path.write_bytes(torn)
        with pytest.raises(BtMissionError) as fault:
            read(path)
        line = sound[:place].count(b"\n") + 1
        assert str(fault.value).startswith((f"{path}:{line}: torn: ", f"{path}: not a journal"))


def test_every_cut_is_seen(path: Path) -> None:
    """Save one between two records: that is what an earlier death looks like."""
    sound = path.read_bytes()
    ends = [place + 1 for place, byte in enumerate(sound) if byte == ord("\n")]
    for place in range(1, len(sound)):
        path.write_bytes(sound[:place])
        if place in ends:
            assert len(read(path)) == ends.index(place) + 1
            continue
        with pytest.raises(BtMissionError, match=r"torn: it does not end; the \d records"):
            read(path)


def test_records_cannot_change_places(path: Path) -> None:
    """Nor can one be left out: each checksum goes over all before it."""
    lines = path.read_bytes().splitlines(keepends=True)
    for order in ([0, 2, 1], [0, 2], [0, 1, 1, 2]):
        path.write_bytes(b"".join(lines[index] for index in order))
        with pytest.raises(BtMissionError, match=r":[23]: torn: its checksum is wrong"):
            read(path)


@pytest.mark.parametrize("data", [b"", b"\n", b"hello\n", b"\xff\x00\n", b"mission: m\ntree: {}\n"])
def test_another_file_is_none(path: Path, data: bytes) -> None:
    """It is left as it is."""
    path.write_bytes(data)
    with pytest.raises(BtMissionError, match=r"not a journal|torn"):
        read(path)
    assert path.read_bytes() == data


def test_a_journal_of_another_version_is_refused(path: Path) -> None:
    """Its records may mean something else."""
    file = JournalFile(path)
    file.rewrite([{"format": "bt-mission journal 2"}])
    file.close()
    with pytest.raises(BtMissionError, match="not a journal of this version"):
        read(path)


def test_written_anew_it_is_short_again(path: Path) -> None:
    """And what is appended then follows; what has to stay moves the bound."""
    file = JournalFile(path, bound=200)
    records = file.read()
    for _ in range(20):
        file.append({"t": 9})
    was_long = file.is_long
    file.rewrite([records[0], {"t": 9, "values": {"": {"x": "x" * 300}}}])
    assert (was_long, file.is_long) == (True, False)
    file.append({"t": 10})
    file.close()
    assert [record.get("t") for record in read(path)] == [None, 9, 10]
    assert [one.name for one in path.parent.iterdir()] == ["m.journal"]


def test_two_cannot_write_one_journal(path: Path) -> None:
    """The second is told; it can have it when the first is done, written anew or not."""
    file = JournalFile(path)
    for _ in range(2):
        with pytest.raises(BtMissionError, match="a mission that runs has this journal open"):
            JournalFile(path)
        file.rewrite([HEAD])
    file.close()
    JournalFile(path).close()


@pytest.mark.parametrize("name", ["no/such/folder/j", ".", "a\0b"])
def test_a_place_that_is_none(tmp_path: Path, name: str) -> None:
    """A line with the reason."""
    with pytest.raises(BtMissionError, match="cannot open the journal"):
        JournalFile(tmp_path / name)


def test_a_full_disk_is_told(path: Path) -> None:
    """/dev/full takes nothing."""
    file = JournalFile(Path("/dev/full"))
    with pytest.raises(BtMissionError, match="cannot write the journal: No space left on device"):
        file.append({"t": 1})
    file.close()
