"""The results of a sweep on disk."""

from __future__ import annotations

import csv
import io
import sqlite3
from pathlib import Path

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.sweep.store import FILE, ResultStore, SweepAbout, write_csv
from bt_mission.scenarios.concrete.row import RequirementMargin, ScenarioRow
from tests.support.rows import failed, margin, row

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


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Results of one row."""
    with ResultStore.create(tmp_path / "results", SweepAbout()) as store:
        store.add(ROW)
    return tmp_path / "results"


def change(folder: Path, statement: str, *values: object) -> None:
    """Change what is in the results as another program could."""
    with sqlite3.connect(folder / FILE) as connection:
        connection.execute(statement, values)


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


def test_others_read_it_as_columns(folder: Path):
    """With the SQLite of anybody."""
    result = sqlite3.connect(folder / FILE).execute(
        "SELECT seed, outcome, passed, json_extract(parameters, '$.speed'), "
        "json_extract(requirements, '$.slow.margin') FROM scenarios"
    )
    assert result.fetchall() == [(7, "failure", 0, 0.1, -0.25)]


def test_results_are_not_overwritten_without_a_word(folder: Path):
    """It says what to do."""
    with pytest.raises(
        BtMissionError, match="add --resume to continue it, or choose another folder"
    ):
        ResultStore.create(folder, SweepAbout())


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


def test_results_of_a_later_version_are_refused(folder: Path):
    """With both versions."""
    change(folder, "UPDATE about SET value = '9' WHERE key = 'format'")
    with pytest.raises(BtMissionError, match="results of version 9; this bt-mission has 3"):
        ResultStore.read(folder)


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


def test_results_that_cannot_be_read_are_told(folder: Path):
    """As on a full or a broken disk: here the page of the rows is damaged."""
    content = (folder / FILE).read_bytes()
    (folder / FILE).write_bytes(content[:4096] + b"\xff" * 4096 + content[8192:])
    with pytest.raises(BtMissionError, match=f"{FILE}: database disk image is malformed"):
        ResultStore.create(folder, SweepAbout())


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
def test_a_broken_row_is_named(folder: Path, column: str, value: object, words: str):
    """With its column, wherever the file comes from."""
    change(folder, f"UPDATE scenarios SET {column} = ?", value)  # noqa: S608
    with ResultStore.read(folder) as store, pytest.raises(BtMissionError) as caught:
        list(store.rows())
    assert words in str(caught.value)
    assert "results.sqlite: row" in str(caught.value)


@pytest.mark.parametrize("text", ["[", "3", '{"vary": 3}', '{"scenario": {"inputs": []}}'])
def test_a_broken_description_is_refused(folder: Path, text: str):
    """Whatever is wrong with it."""
    change(folder, "UPDATE about SET value = ? WHERE key = 'sweep'", text)
    with ResultStore.read(folder) as store, pytest.raises(BtMissionError, match="description"):
        store.about  # noqa: B018 - the reading is what fails


def test_text_that_is_no_utf_8_is_read(folder: Path):
    """What cannot be decoded is replaced."""
    change(folder, "UPDATE scenarios SET reason = CAST(x'ff41' AS TEXT)")
    with ResultStore.read(folder) as store:
        assert [row.reason for row in store.rows()] == ["\ufffdA"]


@pytest.mark.parametrize("end", ["", "-wal", "-shm", "-journal"])
def test_a_link_in_place_of_the_results_is_not_followed(folder: Path, tmp_path: Path, end: str):
    """Neither to read nor to write; a link to the folder is the user's."""
    (tmp_path / "named").symlink_to(folder)
    with ResultStore.read(tmp_path / "named") as store:
        assert store.ids() == {"a1"}
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    if end:
        (foreign / FILE).write_bytes((folder / FILE).read_bytes())
    (foreign / f"{FILE}{end}").symlink_to(folder / FILE)
    for opened in (ResultStore.read, lambda folder: ResultStore.resume(folder, SweepAbout())):
        with pytest.raises(BtMissionError, match="a symbolic link"):
            opened(foreign)


def test_a_link_in_place_of_the_lock_is_not_followed(tmp_path: Path):
    """What it leads to is not emptied."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / "lock").symlink_to(victim)
    with pytest.raises(BtMissionError, match="a symbolic link"):
        ResultStore.create(tmp_path, SweepAbout())
    assert victim.read_text() == "precious"


# ---- all rows as CSV -------------------------------------------------------------------------


def csv_of(*rows):
    """The CSV of rows."""
    file = io.StringIO(newline="")
    write_csv(lambda: rows, file)
    return file.getvalue()


def table(*rows):
    """The lines of the CSV of rows, by the names of the columns."""
    return list(csv.DictReader(io.StringIO(csv_of(*rows), newline="")))


def test_each_parameter_and_requirement_has_columns():
    """Also where only some of the rows have it; those of the others are empty."""
    lines = table(
        row(0, parameters={"speed": 0.1}, requirements={"clear": margin(0.25)}),
        row(1, parameters={"world": "hall"}, requirements={"calm": margin(None, "open")}),
    )
    assert lines[0]["parameter.speed"] == "0.1"
    assert (lines[0]["verdict.clear"], lines[0]["margin.clear"]) == ("holds", "0.25")
    assert (lines[1]["verdict.calm"], lines[1]["margin.calm"]) == ("open", "")
    assert (lines[1]["parameter.speed"], lines[1]["verdict.clear"]) == ("", "")


def test_lines_end_as_rfc_4180_says():
    """With carriage return and line feed; a text with quotes and commas comes back."""
    text = csv_of(failed(0, reason='he said "no", twice'))
    assert text.endswith("\r\n")
    assert '"he said ""no"", twice"' in text


@pytest.mark.parametrize("text", ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\tx", "\rx"])
def test_no_text_becomes_a_formula(text):
    """A spreadsheet shows what begins with an apostrophe, and reckons nothing."""
    (line,) = table(failed(0, reason=text, parameters={"name": text}))
    assert line["reason"].startswith("'")
    assert line["parameter.name"].startswith("'")


def test_the_names_of_columns_are_texts_of_others_too():
    """They begin with a word of ours, so that none is a formula."""
    (line,) = table(row(0, parameters={"=x": 1}, requirements={"=y": margin(1.0)}))
    assert {"parameter.=x", "margin.=y"} <= line.keys()


@pytest.mark.parametrize("value", [-0.25, -3, 1e-7, -1.5e300])
def test_numbers_stay_numbers(value):
    """A negative margin, and a negative number that is a text, begin with no apostrophe."""
    (line,) = table(
        row(0, parameters={"x": value, "t": str(value)}, requirements={"c": margin(value)})
    )
    assert [float(line[name]) for name in ("parameter.x", "parameter.t", "margin.c")] == [value] * 3


def test_what_commands_a_terminal_is_escaped():
    """The rows may be printed."""
    (line,) = table(failed(0, reason="\x1b[2Jgone\u202e"))
    assert line["reason"] == "\\x1b[2Jgone\\u202e"


def test_truth_and_lists_are_as_json_has_them():
    """So that every program reads them alike."""
    (line,) = table(row(0, faults=("at 2: x",), parameters={"quiet": False}))
    assert (line["passed"], line["parameter.quiet"]) == ("true", "false")
    assert line["faults"] == '["at 2: x"]'
