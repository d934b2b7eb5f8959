"""The results of a sweep on disk."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from bt_mission.core.errors import BtMissionError
from bt_mission.sweeps.row import RequirementMargin, ScenarioRow
from bt_mission.sweeps.store import FILE, ResultStore, SweepAbout

ROW = ScenarioRow(
    id="a1",
    number=3,
    seed=7,
    world="hall",
    parameters={"speed": 0.1, "zones": ["a"]},
    faults=("at 1.0: drop scan",),
    outcome="failure",
    cause_kind="failed",
    reason="'drive' aborted: ünlucky",
    requirements={"slow": RequirementMargin("violated", -0.25, "m/s", 1.5)},
    least_margin=-0.25,
    trace_sha256="ff",
)


def test_rows_come_back_as_they_were(tmp_path: Path):
    """In the order of their numbers, and each only once."""
    other = ScenarioRow(id="b2", number=1, seed=0, outcome="success", passed=True)
    with ResultStore.create(tmp_path, SweepAbout()) as store:
        store.add(ROW)
        store.add(other)
        store.add(ROW)
    with ResultStore.read(tmp_path) as store:
        assert list(store.rows()) == [other, ROW]
        assert list(store.rows("passed = ?", 0)) == [ROW]
        assert store.ids() == {"a1", "b2"}


def test_others_read_it_as_columns(tmp_path: Path):
    """With the SQLite of anybody."""
    with ResultStore.create(tmp_path, SweepAbout()) as store:
        store.add(ROW)
        result = sqlite3.connect(tmp_path / FILE).execute(
            "SELECT seed, outcome, passed, json_extract(parameters, '$.speed'), "
            "json_extract(requirements, '$.slow.margin') FROM scenarios"
        )
        assert result.fetchall() == [(7, "failure", 0, 0.1, -0.25)]


def test_results_are_not_overwritten_without_a_word(tmp_path: Path):
    """It says what to do."""
    with ResultStore.create(tmp_path, SweepAbout(seeds="0..1")) as store:
        store.add(ROW)
    with pytest.raises(
        BtMissionError, match="add --resume to continue it, or choose another folder"
    ):
        ResultStore.create(tmp_path, SweepAbout(seeds="0..1"))


def test_a_folder_of_another_sweep_is_refused(tmp_path: Path):
    """With what differs, and nothing of it changed."""
    with ResultStore.create(tmp_path, SweepAbout(seeds="0..1", mission="m")) as store:
        store.add(ROW)
    with pytest.raises(BtMissionError, match=r'seeds was "0..1", is "0..9"'):
        ResultStore.resume(tmp_path, SweepAbout(seeds="0..9", mission="m"))
    with ResultStore.resume(tmp_path, SweepAbout(seeds="0..1", mission="m")) as store:
        assert store.ids() == {"a1"}


def test_a_sweep_that_was_killed_as_it_began_goes_on(tmp_path: Path):
    """The file is there, and nothing in it."""
    sqlite3.connect(tmp_path / FILE).close()
    (tmp_path / FILE).touch()
    with ResultStore.resume(tmp_path, SweepAbout(seeds="0..1")) as store:
        assert store.about == SweepAbout(seeds="0..1")


def test_two_sweeps_do_not_write_into_one_folder(tmp_path: Path):
    """The second is refused while the first writes; who reads is not."""
    with ResultStore.create(tmp_path, SweepAbout()) as store:
        store.add(ROW)
        with pytest.raises(BtMissionError, match="another sweep is writing its results there"):
            ResultStore.resume(tmp_path, SweepAbout())
        with ResultStore.read(tmp_path) as reader:
            assert reader.ids() == {"a1"}
    ResultStore.resume(tmp_path, SweepAbout()).close()


@pytest.mark.parametrize("content", [b"", b"no database at all, but long enough to be read" * 40])
def test_a_file_of_something_else_is_refused(tmp_path: Path, content: bytes):
    """In words."""
    (tmp_path / FILE).write_bytes(content)
    with pytest.raises(BtMissionError, match="not results of a sweep"):
        ResultStore.read(tmp_path)


def test_results_of_a_later_version_are_refused(tmp_path: Path):
    """With both versions."""
    ResultStore.create(tmp_path, SweepAbout()).close()
    with sqlite3.connect(tmp_path / FILE) as connection:
        connection.execute("UPDATE about SET value = '9' WHERE key = 'format'")
    with pytest.raises(BtMissionError, match="results of version 9; this bt-mission has 3"):
        ResultStore.read(tmp_path)


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path):
    """It cannot hold results."""
    (tmp_path / "x").write_text("")
    with pytest.raises(BtMissionError, match="cannot write"):
        ResultStore.create(tmp_path / "x", SweepAbout())


def test_a_full_disk_is_told_and_what_is_there_stays(tmp_path: Path):
    """A limit of pages stands for the disk."""
    with ResultStore.create(tmp_path, SweepAbout()) as store:
        store.add(ROW)
        connection = store._connection
        pages = connection.execute("PRAGMA page_count").fetchone()[0]
        connection.execute(f"PRAGMA max_page_count = {pages}")
        large = ScenarioRow(id="c", number=1, seed=0, reason="x" * 100_000)
        with pytest.raises(BtMissionError, match="cannot write a row: database or disk is full"):
            store.add(large)
    with ResultStore.read(tmp_path) as store:
        assert "a1" in store.ids()


def test_results_in_which_nothing_is_are_begun_anew(tmp_path: Path):
    """No worker could be used, say: there is nothing to lose."""
    ResultStore.create(tmp_path, SweepAbout(seeds="0..4")).close()
    with ResultStore.create(tmp_path, SweepAbout(seeds="0..9")) as store:
        assert store.about == SweepAbout(seeds="0..9")
        store.add(ROW)
    with pytest.raises(BtMissionError, match="contains results of a sweep"):
        ResultStore.create(tmp_path, SweepAbout(seeds="0..9"))


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("parameters", '{"a": [1', "column 'parameters': '{\"a\": [1' is not JSON"),
        ("parameters", "[" * 100_000, "column 'parameters': '[[[["),
        ("parameters", "[1]", "column 'parameters': '[1]' is invalid"),
        ("parameters", '{"a": ' + "[" * 500 + "]" * 500 + "}", "is invalid"),
        ("parameters", '{"a": NaN}', "is not JSON"),
        ("parameters", '{"a": 1e999}', "is not JSON"),
        ("virtual_s", "long", "column 'virtual_s': 'long' is invalid"),
        ("virtual_s", float("inf"), "column 'virtual_s': inf is invalid"),
        ("seed", "seven", "column 'seed': 'seven' is invalid"),
        ("number", b"x", "row b'x' (id 'a1'): column 'number'"),
        ("id", "../../away", "column 'id'"),
        ("sample", "ff" * 9, "column 'sample'"),
        ("coverage", "zz", "column 'coverage'"),
        ("outcome", "fine", "column 'outcome'"),
        ("passed", 2, "column 'passed'"),
        ("passed", 1, "column 'cause_kind': 'failed' contradicts"),
        ("cause_kind", "unlucky", "column 'cause_kind'"),
        ("faults", '{"a": 1}', "column 'faults'"),
        ("nature", '{"rain": 1}', "column 'nature'"),
        ("nature", '{"start_x": "far"}', "column 'nature'"),
        ("requirements", '{"slow": 3}', "column 'requirements'"),
        ("requirements", '{"slow": {"verdict": "maybe"}}', "column 'requirements'"),
    ],
)
def test_a_broken_row_is_named(tmp_path: Path, column: str, value: object, words: str):
    """With its column, wherever the file comes from."""
    with ResultStore.create(tmp_path, SweepAbout()) as store:
        store.add(ROW)
    with sqlite3.connect(tmp_path / FILE) as connection:
        connection.execute(f"UPDATE scenarios SET {column} = ?", (value,))  # noqa: S608
    with ResultStore.read(tmp_path) as store, pytest.raises(BtMissionError) as caught:
        list(store.rows())
    assert words in str(caught.value)
    assert "results.sqlite: row" in str(caught.value)


@pytest.mark.parametrize("text", ["[", "3", '{"vary": 3}', '{"scenario": {"inputs": []}}'])
def test_a_broken_description_is_refused(tmp_path: Path, text: str):
    """Whatever is wrong with it."""
    ResultStore.create(tmp_path, SweepAbout()).close()
    with sqlite3.connect(tmp_path / FILE) as connection:
        connection.execute("UPDATE about SET value = ? WHERE key = 'sweep'", (text,))
    with ResultStore.read(tmp_path) as store, pytest.raises(BtMissionError, match="description"):
        store.about  # noqa: B018 - the reading is what fails


def test_text_that_is_no_utf_8_is_read(tmp_path: Path):
    """What cannot be decoded is replaced."""
    with ResultStore.create(tmp_path, SweepAbout()) as store:
        store.add(ROW)
    with sqlite3.connect(tmp_path / FILE) as connection:
        connection.execute("UPDATE scenarios SET reason = CAST(x'ff41' AS TEXT)")
    with ResultStore.read(tmp_path) as store:
        assert [row.reason for row in store.rows()] == ["\ufffdA"]


@pytest.mark.parametrize("end", ["", "-wal", "-shm", "-journal"])
def test_a_link_in_place_of_the_results_is_not_followed(tmp_path: Path, end: str):
    """Neither to read nor to write; a link to the folder is the user's."""
    with ResultStore.create(tmp_path / "real", SweepAbout()) as store:
        store.add(ROW)
    (tmp_path / "named").symlink_to(tmp_path / "real")
    with ResultStore.read(tmp_path / "named") as store:
        assert store.ids() == {"a1"}
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    if end:
        (foreign / FILE).write_bytes((tmp_path / "real" / FILE).read_bytes())
    (foreign / f"{FILE}{end}").symlink_to(tmp_path / "real" / FILE)
    for opened in (ResultStore.read, lambda folder: ResultStore.resume(folder, SweepAbout())):
        with pytest.raises(BtMissionError, match="a symbolic link"):
            opened(foreign)


def test_a_link_in_place_of_the_lock_is_not_followed(tmp_path: Path):
    """What it leads to is not emptied."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "lock").symlink_to(victim)
    with pytest.raises(BtMissionError, match="a symbolic link"):
        ResultStore.create(folder, SweepAbout())
    assert victim.read_text() == "precious"
